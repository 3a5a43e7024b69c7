//! Instruction counter on the target, its stand-in on the host.

#[cfg(target_os = "none")]
pub use fsw_target::arch::instructions::InstructionCounter as Counter;

/// Stand-in that runs the work and counts nothing.
#[cfg(not(target_os = "none"))]
pub struct Counter;

#[cfg(not(target_os = "none"))]
impl Counter {
    /// Runs `work`; always zero.
    pub fn count(&mut self, mut work: impl FnMut()) -> u32 {
        work();
        0
    }
}
