//! Log: one line is a defmt frame on the target and a line of standard output on the host.
//!
//! On the target a frame has two outputs (`global_logger.rs`): RTT, which `probe-rs run` reads, and a serial
//! port, which QEMU and a ground harness without a probe can read. One image is thus readable everywhere:
//! defmt allows one logger per image, QEMU has no RTT, and semihosting stops a board without a probe.

#[cfg(target_os = "none")]
mod global_logger;
#[cfg(any(target_os = "none", test))]
mod rtt;

#[cfg(target_os = "none")]
pub use global_logger::init;

/// Logs one line. The format string must be valid for both `defmt` and `core::fmt`; the text is the same on
/// both sides.
#[cfg(target_os = "none")]
#[macro_export]
macro_rules! log_line {
    ($($arguments:tt)*) => { ::defmt::info!($($arguments)*) };
}

/// Logs one line. The format string must be valid for both `defmt` and `core::fmt`; the text is the same on
/// both sides.
#[cfg(not(target_os = "none"))]
#[macro_export]
macro_rules! log_line {
    ($($arguments:tt)*) => { ::std::println!($($arguments)*) };
}
