//! One log line, on the target as a defmt frame, on the host on standard output.
//!
//! On the target a frame goes to two places at once (`global_logger.rs`): to RTT, where
//! `probe-rs run` finds it, and to the board's serial port, which QEMU and a ground harness
//! without a probe can read. So one image is readable everywhere; defmt allows only one logger in
//! an image, and RTT alone is invisible to QEMU, whereas semihosting output alone stops a board
//! that has no probe.

#[cfg(target_os = "none")]
mod global_logger;
#[cfg(any(target_os = "none", test))]
mod rtt;

#[cfg(target_os = "none")]
pub use global_logger::init;

/// Logs one line. The format string is one that both `defmt` and `core::fmt` understand, and what
/// comes out is the same text on both sides.
#[cfg(target_os = "none")]
#[macro_export]
macro_rules! log_line {
    ($($arguments:tt)*) => { ::defmt::info!($($arguments)*) };
}

/// Logs one line. The format string is one that both `defmt` and `core::fmt` understand, and what
/// comes out is the same text on both sides.
#[cfg(not(target_os = "none"))]
#[macro_export]
macro_rules! log_line {
    ($($arguments:tt)*) => { ::std::println!($($arguments)*) };
}
