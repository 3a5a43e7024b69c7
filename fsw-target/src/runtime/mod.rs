//! Services of an image that depend on no chip: failures, log, restart record, stack measurement, and the
//! time stamps between an interrupt and the loop.
//!
//! 1. [`failure`]: failures that the code does not handle; `restart`: their record over a reset.
//! 2. [`log`]: one log line on target and host.
//! 3. [`extended_time`]: 64-bit time from a 32-bit counter; [`stamps`]: time stamps of gyro samples.
//! 4. `shared`: state that an interrupt and the loop share; `shared_time`: on-board time; `serial`: serial ports;
//!    [`bounded`]: waits; `stack`: high-water mark of the stack.
//! 5. [`sealed`]: a value whose memory is checked before each use.

pub mod bounded;
pub mod extended_time;
pub mod failure;
pub mod log;
#[cfg(target_os = "none")]
pub mod restart;
pub mod sealed;
#[cfg(target_os = "none")]
pub mod serial;
#[cfg(target_os = "none")]
pub mod shared;
#[cfg(target_os = "none")]
pub mod shared_time;
#[cfg(target_os = "none")]
pub mod stack;
pub mod stamps;
