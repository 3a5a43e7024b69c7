//! The handlers that catch a failure, on the chip.
//!
//! # Overflow of the stack
//!
//! `memory.x` puts the stack at the lowest addresses of the RAM, below all statics. A stack that
//! grows too far leaves the RAM, where there is nothing to overwrite and all is closed
//! ([`crate::runtime::stack`]): the access faults. (The
//! linker flip-link makes the same arrangement, but needs a linker under it that Debian's tool
//! chain doesn't have.) The handler can't use the stack that overflowed, so it starts it anew: it
//! never returns to what was on it.

use super::{Failure, Kind};
use crate::runtime::stack;
use core::arch::naked_asm;
use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;

#[allow(unsafe_code, reason = "the image defines this function, by the macro `ends_by`")]
unsafe extern "Rust" {
    safe fn fsw_target_image_ends(failure: Failure) -> !;
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    // The place is enough to find it; the message would bring all of core::fmt into the image.
    let (at, from) = match info.location() {
        Some(place) => {
            defmt::error!("panicked at {=str}:{=u32}", place.file(), place.line());
            (place.line(), place.file().as_ptr() as u32)
        }
        None => {
            defmt::error!("panicked");
            (0, 0)
        }
    };
    fsw_target_image_ends(Failure { kind: Kind::Panic, at, from })
}

/// Where `defmt::panic!` and its like end, having logged. Without it defmt links a panic of
/// `core`, which would be the only one in an image that has none (the feature
/// `avoid-default-panic` leaves it out).
#[defmt::panic_handler]
fn defmt_panic() -> ! {
    fsw_target_image_ends(Failure { kind: Kind::Panic, at: 0, from: 0 })
}

#[allow(unsafe_code, reason = "cortex-m-rt asks for an unsafe handler")]
// SAFETY: called by the hardware only, and does not return to what was interrupted.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) -> ! {
    defmt::error!("interrupt {=i16} has no handler", interrupt);
    let at = u32::from(interrupt.unsigned_abs());
    fsw_target_image_ends(Failure { kind: Kind::UnservedInterrupt, at, from: 0 })
}

/// Called by the hardware on a fault, with a stack pointer that may point at nothing. So, before
/// anything is pushed:
///
/// 1. a lazy store of the floating-point registers that is still due is called off (FPCCR.LSPACT),
///    since it would go to the stack that faulted;
/// 2. the address of the exception frame is kept, and the caller and the instruction in it (at
///    20 and 24 bytes), if it lies in the stack;
/// 3. the stack starts anew from its top.
///
/// Registers: PM0214, sections 4.6.3 (FPCCR) and 2.3.7 (exception entry).
#[allow(unsafe_code, reason = "a function without a stack")]
// SAFETY: the vector table wants this name, and no other function has it; the assembly uses no
// stack and goes on in a function that doesn't return.
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
        "blo 1f",
        "ldr r1, [r0, #24]",
        "ldr r2, [r0, #20]",
        "1: b {go_on}",
        go_on = sym hard_fault,
    )
}

/// A frame that starts this close to the end of the stack, or beyond it, means an overflow: the
/// instruction that faults pushes up to 16 double words in one go, before or after the frame.
const OVERFLOW_MARGIN_BYTES: u32 = 128;

extern "C" fn hard_fault(frame: u32, at: u32, from: u32) -> ! {
    // SAFETY: reading the status of the fault changes nothing.
    #[allow(unsafe_code, reason = "the fault may have hit while the block was in use")]
    let status = unsafe { &*SCB::PTR }.cfsr.read();
    defmt::error!("fault status {=u32:#010x}", status);
    if frame < stack::end() + OVERFLOW_MARGIN_BYTES {
        defmt::error!("stack overflow at {=u32:#010x}, called from {=u32:#010x}", at, from);
        fsw_target_image_ends(Failure { kind: Kind::StackOverflow, at, from });
    }
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", at, from);
    fsw_target_image_ends(Failure { kind: Kind::HardFault, at, from })
}
