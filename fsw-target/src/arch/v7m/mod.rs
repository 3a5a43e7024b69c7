//! Armv7-M and Armv7E-M: Cortex-M3, M4 and M7.
//!
//! The board's memory file places the stack at the lowest addresses of the RAM, below all statics. The stack guard
//! closes the addresses below the RAM, so that a stack that overflows faults and overwrites nothing; the
//! handler of the fault starts the stack again. (The linker flip-link makes the same arrangement, but
//! requires a linker that Debian's toolchain does not have.)

mod stack_guard;

use crate::runtime::stack;

/// Distance from the end of the stack within which a frame counts as an overflow, bytes: one
/// instruction pushes up to 16 double words, before or after the frame.
const OVERFLOW_MARGIN_BYTES: u32 = 128;

/// True if a fault is an overflow of the stack, by the address of its exception frame.
pub(super) fn stack_overflowed(_fault_status: u32, frame: u32) -> bool {
    frame < stack::end() + OVERFLOW_MARGIN_BYTES
}
