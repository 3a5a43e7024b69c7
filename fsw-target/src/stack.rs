//! How deep the stack has been.
//!
//! `memory.x` says where the stack is; cortex-m-rt paints all of it at start-up (its feature
//! `paint-stack`). What isn't painted any more has been used.

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
