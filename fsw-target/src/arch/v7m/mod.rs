//! Armv7-M and Armv7E-M: Cortex-M3, M4 and M7.
//!
//! `memory.x` places the stack at the lowest addresses of the RAM, below all statics. The stack guard
//! closes the addresses below the RAM, so that a stack that overflows faults and overwrites nothing; the
//! handler of the fault starts the stack again. (The linker flip-link makes the same arrangement, but
//! requires a linker that Debian's toolchain does not have.)

mod hard_fault;
mod stack_guard;
