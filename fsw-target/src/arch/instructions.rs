//! Exact counter of executed instructions, in QEMU.
//!
//! With `-icount shift=8` virtual time advances by 256 ns per instruction of any kind, and SysTick runs on
//! virtual time. The difference of two readings of SysTick is thus a number of instructions, exact and
//! reproducible. On a board, or in QEMU without that option, it is not: [`InstructionCounter::start`]
//! checks it on known instruction sequences.

use cortex_m::asm;
use cortex_m::peripheral::{SYST, syst::SystClkSource};

/// SysTick ticks per 1000 instructions: 168 MHz, the core clock of the STM32F405 in QEMU, times 256 ns.
const TICKS_PER_1000: u64 = 43_008;

/// Reload value of SysTick, 24 bits: 390,000 instructions. Longer work counts as [`u32::MAX`].
const RELOAD: u32 = 0x00ff_ffff;

/// Iterations of the shorter loop of the check.
const LOOP: u32 = 1_000;

/// SysTick as a counter of instructions.
pub struct InstructionCounter {
    timer: SYST,
    /// Instructions of two readings and an empty call.
    overhead: u32,
}

/// SysTick does not count instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotExact;

impl InstructionCounter {
    /// Starts SysTick.
    ///
    /// # Errors
    /// [`NotExact`] outside QEMU with `-icount shift=8`.
    pub fn start(mut timer: SYST) -> Result<Self, NotExact> {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.enable_counter();
        let mut counter = Self { timer, overhead: 0 };
        counter.overhead = counter.count(|| ());
        if counter.is_exact() { Ok(counter) } else { Err(NotExact) }
    }

    /// Check: four instructions count as four, a loop of twice the iterations as twice the instructions
    /// (except for its entry and exit), and a too long loop as [`u32::MAX`].
    fn is_exact(&mut self) -> bool {
        let four = self.count(|| {
            asm::nop();
            asm::nop();
            asm::nop();
            asm::nop();
        });
        let [short, long] = [LOOP, 2 * LOOP].map(|turns| self.count(|| asm::delay(turns)));
        let too_long = self.count(|| asm::delay(RELOAD / 40));
        four == 4 && short >= LOOP && long.abs_diff(2 * short) < LOOP / 10 && too_long == u32::MAX
    }

    /// Number of instructions of `work`. Instructions that the compiler moves out of the call are not
    /// counted; [`core::hint::black_box`] prevents this.
    pub fn count(&mut self, mut work: impl FnMut()) -> u32 {
        self.count_call(&mut work)
    }

    /// Never inlined, so that its own instructions are the same for any work.
    #[inline(never)]
    fn count_call(&mut self, work: &mut dyn FnMut()) -> u32 {
        self.timer.clear_current();
        let _ = self.timer.has_wrapped(); // clears the flag, set by the write above
        let start = SYST::get_current();
        work();
        let end = SYST::get_current();
        if self.timer.has_wrapped() {
            return u32::MAX;
        }
        instructions(start, end).saturating_sub(self.overhead)
    }
}

/// Instructions between two readings. The error is below one tick, a fortieth of an instruction, since
/// readings are rounded down.
fn instructions(start: u32, end: u32) -> u32 {
    let ticks = u64::from(start.wrapping_sub(end) & RELOAD);
    ((ticks * 1000 + TICKS_PER_1000 / 2) / TICKS_PER_1000) as u32
}
