//! What counts: on the target instructions, on the host nothing.

#[cfg(target_os = "none")]
pub use fsw_target::arch::instructions::InstructionCounter as Counter;

/// Does the work, and counts nothing: a host's instructions are of no interest.
#[cfg(not(target_os = "none"))]
pub struct Counter;

#[cfg(not(target_os = "none"))]
impl Counter {
    /// Does `work`; zero.
    pub fn count(&mut self, mut work: impl FnMut()) -> u32 {
        work();
        0
    }
}
