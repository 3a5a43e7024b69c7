//! Stack measurement: size and high-water mark.
//!
//! The memory file of the board places the stack at the bottom of the RAM. cortex-m-rt fills it with a constant at start-up
//! (its feature `paint-stack`); a word that holds another value has been used.

use cortex_m_rt::STACK_PAINT_VALUE;

#[allow(unsafe_code, reason = "symbols of the linker script")]
unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Lowest address of the stack, which is the lowest of the RAM. The stack grows down to it.
pub fn end() -> u32 {
    (&raw const _stack_end) as u32
}

/// Address behind the highest word of the stack.
fn start() -> u32 {
    (&raw const _stack_start) as u32
}

/// Size of the stack, bytes.
pub fn size_bytes() -> u32 {
    start().wrapping_sub(end())
}

/// High-water mark of the stack since start-up, bytes, interrupts included. Reads every unused word: some
/// 10,000 instructions for 16 KiB, for the rate of telemetry.
///
/// A used word that holds the constant counts as unused. This is unlikely for the lowest used word, and
/// makes the mark four bytes too low.
pub fn high_water_bytes() -> u32 {
    let mut word = &raw const _stack_end;
    let start = &raw const _stack_start;
    // SAFETY: all words between the two symbols belong to the stack, and any bits are a valid u32. The
    // read is volatile, since no Rust object owns this memory.
    #[allow(unsafe_code, reason = "reads the memory of the stack")]
    while word < start && unsafe { word.read_volatile() } == STACK_PAINT_VALUE {
        word = word.wrapping_add(1);
    }
    (start as u32).wrapping_sub(word as u32)
}
