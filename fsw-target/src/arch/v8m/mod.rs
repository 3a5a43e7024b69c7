//! Armv8-M with the Main Extension: Cortex-M33, in secure state.
//!
//! The stack limit register MSPLIM holds the lowest address of the stack: an instruction that would move the stack
//! pointer below it faults before it writes, and so does the entry of an exception. cortex-m-rt sets it from
//! `_stack_end` before any code uses the stack (its feature `set-msplim`).
//!
//! The memory protection unit (PMSAv8: MPU_RBAR, MPU_RLAR) stays off. Its only use on Armv7-M is the guard below the
//! stack, which a large frame can skip; MSPLIM cannot be skipped. Nothing runs in non-secure state.

/// UFSR.STKOF in CFSR: the stack pointer would have passed its limit. DDI0553, CFSR.
const STKOF: u32 = 1 << 20;

/// True if a fault is an overflow of the stack, by the fault status.
pub(super) fn stack_overflowed(fault_status: u32, _frame: u32) -> bool {
    fault_status & STKOF != 0
}
