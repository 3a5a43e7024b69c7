//! The stack: what keeps it where it belongs, and how deep it has been.
//!
//! `memory.x` puts it at the bottom of the RAM. Below is no memory that anything could be written
//! to, but on this chip there are registers and a boot loader within reach of a large frame. So the
//! memory protection unit closes the megabyte below, and whatever frame outgrows the stack faults at
//! its first access.
//!
//! cortex-m-rt paints the whole stack at start-up (its feature `paint-stack`). What isn't painted
//! any more has been used.

use core::arch::naked_asm;
use cortex_m_rt::STACK_PAINT_VALUE;

#[allow(unsafe_code, reason = "symbols of the linker script")]
unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Lowest address of the stack. It grows down to here, and what is below is no memory.
pub fn end() -> u32 {
    (&raw const _stack_end) as u32
}

/// Where the stack starts: the address behind its highest word.
fn start() -> u32 {
    (&raw const _stack_start) as u32
}

/// Bytes below the stack that are closed: 2 to the power of this.
const CLOSED_LOG2: u32 = 20;

// Fields of the memory protection unit's registers: PM0214, section 4.2.
const RBAR_VALID: u32 = 1 << 4;
/// Nobody may read, write or execute.
const RASR: u32 = 1 << 28 | (CLOSED_LOG2 - 1) << 1 | 1;
/// The unit is on, but not in the handler of hard faults; what no region covers stays open.
const CTRL: u32 = 1 << 2 | 1;

/// Closes the memory below the stack. cortex-m-rt calls it by its name, before anything that might
/// outgrow the stack; it uses none itself.
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
        log2 = const CLOSED_LOG2,
        valid = const RBAR_VALID,
        rasr_low = const RASR & 0xffff,
        rasr_high = const RASR >> 16,
        ctrl = const CTRL,
    )
}

/// Bytes that the stack may grow to.
pub fn size_bytes() -> u32 {
    start().wrapping_sub(end())
}

/// The most that the stack has grown to since start-up, bytes, interrupts included. Looks at every
/// word that has never been used: some 10,000 instructions for 16 KiB, so ask at the rate of
/// telemetry.
///
/// A word that was used but left with the paint's own value counts as unused; that the lowest one
/// is such a word is unlikely, and costs four bytes.
pub fn high_water_bytes() -> u32 {
    let mut word = &raw const _stack_end;
    let start = &raw const _stack_start;
    // SAFETY: all words between the two symbols are the stack's, and any bits make a u32. The read
    // is volatile, since to the compiler this memory is nobody's.
    #[allow(unsafe_code, reason = "reads the memory under the stack")]
    while word < start && unsafe { word.read_volatile() } == STACK_PAINT_VALUE {
        word = word.wrapping_add(1);
    }
    (start as u32).wrapping_sub(word as u32)
}
