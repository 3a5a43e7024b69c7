//! Entry of the hard fault: any fault of the core, an overflow of the stack among them.
//!
//! The stack pointer at entry may point outside the RAM. So the handler starts the stack again from its
//! top, and never returns to the code that faulted. The same for Armv7-M and Armv8-M.

use super::stack_overflowed;
use crate::runtime::failure::{Failure, Kind, end_image};
use core::arch::naked_asm;
use cortex_m::peripheral::SCB;

/// Handler of the hard fault. Before anything is pushed:
///
/// 1. a pending lazy store of the floating-point registers is cancelled (FPCCR.LSPACT), since it would
///    write to the stack that faulted;
/// 2. r0 is the address of the exception frame; if the frame lies in the stack, r1 is the address of the
///    instruction (at 24 bytes) and r2 the return address of its function (at 20 bytes), otherwise both
///    are 0;
/// 3. the stack starts again from its top.
///
/// Armv8-M sets the stack pointer to the limit where a frame would exceed it, and stores no frame: an address
/// at the limit is no frame.
///
/// Registers: PM0214, sections 4.6.3 (FPCCR) and 2.3.7 (exception entry); Armv8-M Architecture Reference Manual,
/// DDI0553, PushStack and FPCCR.
#[allow(unsafe_code, reason = "a function without a stack")]
// SAFETY: the vector table requires this name, and no other function has it; the assembly uses no
// stack and continues in a function that does not return.
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn HardFault() -> ! {
    naked_asm!(
        "movw r3, #0xef34",
        "movt r3, #0xe000",
        "ldr r2, [r3]",
        "bic r2, r2, #1",
        "str r2, [r3]",
        "mrs r0, msp",
        "movw r3, #:lower16:_stack_start",
        "movt r3, #:upper16:_stack_start",
        "msr msp, r3",
        "movs r1, #0",
        "movs r2, #0",
        "subs r3, r3, #32",
        "cmp r0, r3",
        "bhi 1f",
        "movw r3, #:lower16:_stack_end",
        "movt r3, #:upper16:_stack_end",
        "cmp r0, r3",
        "bls 1f",
        "ldr r1, [r0, #24]",
        "ldr r2, [r0, #20]",
        "1: b {go_on}",
        go_on = sym hard_fault,
    )
}

extern "C" fn hard_fault(frame: u32, at: u32, from: u32) -> ! {
    // SAFETY: reading the status of the fault has no side effect.
    #[allow(unsafe_code, reason = "the fault may have hit while the block was in use")]
    let status = unsafe { &*SCB::PTR }.cfsr.read();
    defmt::error!("fault status {=u32:#010x}", status);
    if stack_overflowed(status, frame) {
        defmt::error!("stack overflow at {=u32:#010x}, called from {=u32:#010x}", at, from);
        end_image(Failure { kind: Kind::StackOverflow, at, from });
    }
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", at, from);
    end_image(Failure { kind: Kind::HardFault, at, from })
}
