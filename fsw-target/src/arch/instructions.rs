//! Counts executed instructions, exactly, in QEMU.
//!
//! With `-icount shift=8` virtual time advances by 256 ns an instruction, whatever the instruction
//! does, and SysTick runs on that time. So the difference of two of its readings is a number of
//! instructions: exact, and the same in every run. On a board, or in QEMU without that option, it
//! is not: [`InstructionCounter::start`] finds out by counting what is known.

use cortex_m::asm;
use cortex_m::peripheral::{SYST, syst::SystClkSource};

/// SysTick ticks in a thousand instructions: 168 MHz, the core clock of QEMU's STM32F405, times
/// 256 ns.
const TICKS_PER_1000: u64 = 43_008;

/// SysTick counts down from here and starts again: it has 24 bits. That is 390,000 instructions, and
/// what takes more than that counts as [`u32::MAX`].
const RELOAD: u32 = 0x00ff_ffff;

/// Turns of the shortest loop that checks the counter.
const LOOP: u32 = 1_000;

/// SysTick, counting instructions.
pub struct InstructionCounter {
    timer: SYST,
    /// What two readings and a call that does nothing cost.
    overhead: u32,
}

/// Time isn't counted in instructions here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotExact;

impl InstructionCounter {
    /// Takes SysTick over and starts it.
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

    /// Four instructions must count as four, a loop of twice the turns as twice as many (but for what
    /// enters and leaves it), and one that is too long must be found out.
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

    /// Instructions that `work` executes. What the compiler moves out of the call isn't counted:
    /// hold it with [`core::hint::black_box`].
    pub fn count(&mut self, mut work: impl FnMut()) -> u32 {
        self.count_call(&mut work)
    }

    /// One and the same code for whatever is counted, so that its own share is always the same.
    #[inline(never)]
    fn count_call(&mut self, work: &mut dyn FnMut()) -> u32 {
        self.timer.clear_current();
        let _ = self.timer.has_wrapped(); // it has, from the zero that it was set to
        let start = SYST::get_current();
        work();
        let end = SYST::get_current();
        if self.timer.has_wrapped() {
            return u32::MAX;
        }
        instructions(start, end).saturating_sub(self.overhead)
    }
}

/// A reading is rounded down, so the difference of two is wrong by less than a tick, a fortieth of
/// an instruction.
fn instructions(start: u32, end: u32) -> u32 {
    let ticks = u64::from(start.wrapping_sub(end) & RELOAD);
    ((ticks * 1000 + TICKS_PER_1000 / 2) / TICKS_PER_1000) as u32
}
