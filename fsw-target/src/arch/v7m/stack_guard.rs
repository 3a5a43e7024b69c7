//! Stack guard: a region of the memory protection unit (PMSAv7) below the stack, closed to all access.
//!
//! Guard region: the 8 KiB below the stack, without access: an access is a fault. They hold nothing on an
//! STM32F405, whose unique identifier, one-time-programmable bytes and option bytes below must stay readable.
//! A frame that skips the guard reaches reserved addresses or the boot ROM, where a write is a bus
//! fault.
//!
//! Registers: PM0214, section 4.2.

use core::arch::naked_asm;

/// Size of the closed region: 2 to the power of this, bytes.
const REGION_LOG2: u32 = 13;

/// MPU_RBAR: the region number is 0, from this register.
const RBAR_VALID: u32 = 1 << 4;
/// MPU_RASR: no access, never executed; size; enabled.
const RASR: u32 = 1 << 28 | (REGION_LOG2 - 1) << 1 | 1;
/// MPU_CTRL: enabled, except in the handler of hard faults; addresses outside the region stay open.
const CTRL: u32 = 1 << 2 | 1;

/// Closes the memory below the stack. cortex-m-rt calls this function by its name before `main`; it uses
/// no stack itself.
#[allow(unsafe_code, reason = "runs before the RAM is initialised")]
// SAFETY: no other function has this name; no static is accessed, and no other code uses the unit.
#[unsafe(naked)]
#[unsafe(no_mangle)]
extern "C" fn __pre_init() {
    naked_asm!(
        "movw r0, #0xed94", // MPU_CTRL; RBAR follows at 8, RASR at 12
        "movt r0, #0xe000",
        "movw r1, #:lower16:_stack_end",
        "movt r1, #:upper16:_stack_end",
        "subs r1, r1, #1",
        "lsrs r1, r1, #{log2}",
        "lsls r1, r1, #{log2}",
        "orr r1, r1, #{valid}",
        "str r1, [r0, #8]",
        "movw r1, #{rasr_low}",
        "movt r1, #{rasr_high}",
        "str r1, [r0, #12]",
        "movs r1, #{ctrl}",
        "str r1, [r0]",
        "dsb",
        "isb",
        "bx lr",
        log2 = const REGION_LOG2,
        valid = const RBAR_VALID,
        rasr_low = const RASR & 0xffff,
        rasr_high = const RASR >> 16,
        ctrl = const CTRL,
    )
}
