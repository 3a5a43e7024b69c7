//! Runtime services of an image: failure handling, log, restart record, stack guard.

pub mod failure;
pub mod log;
#[cfg(target_os = "none")]
pub mod restart;
#[cfg(target_os = "none")]
pub mod stack;
