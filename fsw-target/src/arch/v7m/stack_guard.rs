//! Stack guard: regions of the memory protection unit (PMSAv7) below the stack.
//!
//! 1. The 1 MiB below the stack, without access: an access is a fault. A large stack frame could skip a
//!    smaller guard and reach the registers or the boot loader below the RAM.
//! 2. In it, with priority over it, 1 KiB from `_identity` of the memory file, read only: one-time-programmable
//!    bytes and unique identifier of the chip. A stack frame is written first: here too it is a fault.
//!
//! Registers: PM0214, section 4.2.

use core::arch::naked_asm;

/// Size of the closed region: 2 to the power of this, bytes.
const REGION_LOG2: u32 = 20;
/// Size of the readable region: 2 to the power of this, bytes. 1 KiB holds 528 one-time-programmable bytes,
/// the unique identifier and the size of the flash of an STM32F405 (RM0090, section 3.7 and chapter 39).
const IDENTITY_LOG2: u32 = 10;

/// MPU_RBAR: the region number is in this register, 0 and 1. The higher number has priority.
const RBAR_VALID: u32 = 1 << 4;
const RBAR_IDENTITY: u32 = RBAR_VALID | 1;
/// MPU_RASR: no access, never executed; size; enabled.
const RASR: u32 = 1 << 28 | (REGION_LOG2 - 1) << 1 | 1;
/// MPU_RASR: read only, never executed; size; enabled.
const RASR_IDENTITY: u32 = 1 << 28 | 0b110 << 24 | (IDENTITY_LOG2 - 1) << 1 | 1;
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
        "movw r1, #:lower16:_identity",
        "movt r1, #:upper16:_identity",
        "orr r1, r1, #{identity_region}",
        "str r1, [r0, #8]",
        "movw r1, #{identity_low}",
        "movt r1, #{identity_high}",
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
        identity_region = const RBAR_IDENTITY,
        identity_low = const RASR_IDENTITY & 0xffff,
        identity_high = const RASR_IDENTITY >> 16,
        ctrl = const CTRL,
    )
}
