//! Firmware images in QEMU.
//!
//! ```text
//! replay  recorded flight: the bits of the host, and no code that panics
//! board   failures, restarts, interrupts, serial ports
//! boards  other boards and cores: the bits of the host
//! flight  flight image with a ground station on its serial port; memory budgets
//! ```
//!
//! All tests but one need the Cortex-M target, most of them QEMU: `tests/check.sh` runs them.

mod board;
mod boards;
mod flight;
mod replay;

use std::time::Duration;

/// Time limit of an image. None takes more than a second in QEMU; a loaded machine takes longer.
const LIMIT: Duration = Duration::from_secs(120);

/// Exclusive use of the machine by one test: the time limits of the others hold without a compiler or
/// another emulator beside them.
fn alone() -> std::sync::MutexGuard<'static, ()> {
    static MACHINE: std::sync::Mutex<()> = std::sync::Mutex::new(());
    MACHINE.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
