//! The clock tree: the 8 MHz crystal and the PLL, 168 MHz; or, if they fail, the internal 16 MHz.
//!
//! Output: which clocks are in force, and what went wrong if they are not the wanted ones. Every
//! wait is bounded: a flight board may not hang on a crystal that is dead, and QEMU's clock unit
//! reads 0 for ever. (This is why the raw registers are used and not stm32f4xx-hal, whose
//! set-up waits without a bound.)
//!
//! A crystal that dies in flight is noticed by the clock security system: the hardware switches to
//! the internal oscillator and raises the non-maskable interrupt. Handled there: the buses lose
//! their dividers, and every rate that was derived from the clocks is derived anew (baud rates,
//! SPI, both timers), so that the board carries on at a tenth of its speed with telemetry, time
//! and captures in the same units. Not handled: a byte that is on the line at that instant is
//! lost (its packet fails the CRC); the counters that tick between the failure and the end of the
//! handler, some microseconds, tick at the wrong rate; and nothing goes back to the crystal before
//! the next reset.
//!
//! Registers: RM0090, chapters 3 (flash latency), 5 (PWR) and 7 (RCC of the STM32F405).

use super::rates::{Clocks, PLL_M, PLL_N, PLL_Q};
use core::sync::atomic::{AtomicU8, Ordering};
use cortex_m_rt::exception;
use stm32f4::stm32f405::{FLASH, PWR, Peripherals, RCC};

/// How often the crystal's ready flag is polled: at 16 MHz a poll takes at least six cycles, so
/// more than 100 ms. A crystal takes 2 ms (DS8626, HSE oscillator characteristics).
const CRYSTAL_POLLS: u32 = 300_000;

/// How often any other flag is polled: more than 3 ms. The PLL locks within 0.3 ms (DS8626, main
/// PLL characteristics); the others follow within microseconds.
const FLAG_POLLS: u32 = 10_000;

/// Why the board does not run on its crystal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
#[repr(u8)]
pub enum ClockFault {
    /// The crystal did not start.
    CrystalDead = 1,
    /// The PLL did not lock.
    PllUnlocked = 2,
    /// The flash did not take the wait states of the fast clock.
    FlashTooFast = 3,
    /// The core did not switch to the PLL.
    NotSwitched = 4,
    /// The crystal failed after start-up.
    CrystalLost = 5,
}

/// The [`ClockFault`] as its number; 0: none, the crystal is in force.
static FAULT: AtomicU8 = AtomicU8::new(ClockFault::CrystalDead as u8);

/// Why the board does not run on its crystal, if so.
pub fn fault() -> Option<ClockFault> {
    match FAULT.load(Ordering::Relaxed) {
        0 => None,
        2 => Some(ClockFault::PllUnlocked),
        3 => Some(ClockFault::FlashTooFast),
        4 => Some(ClockFault::NotSwitched),
        5 => Some(ClockFault::CrystalLost),
        _ => Some(ClockFault::CrystalDead),
    }
}

/// The clocks in force.
pub fn in_force() -> Clocks {
    if fault().is_none() { Clocks::CRYSTAL } else { Clocks::INTERNAL }
}

/// Starts the crystal and the PLL, or stays on the internal oscillator. Returns the clocks that
/// are in force then; [`fault`] says why if they are the slow ones.
pub fn start(rcc: &RCC, pwr: &PWR, flash: &FLASH) -> Clocks {
    let fault = match run_on_crystal(rcc, pwr, flash) {
        Ok(()) => 0,
        Err(fault) => {
            run_on_internal(rcc);
            fault as u8
        }
    };
    FAULT.store(fault, Ordering::Relaxed);
    in_force()
}

fn run_on_crystal(rcc: &RCC, pwr: &PWR, flash: &FLASH) -> Result<(), ClockFault> {
    rcc.cr().modify(|_, w| w.hseon().on());
    wait(CRYSTAL_POLLS, || rcc.cr().read().hserdy().is_ready()).ok_or(ClockFault::CrystalDead)?;

    // The regulator's scale 1 is needed above 144 MHz; it takes effect with the PLL.
    rcc.apb1enr().modify(|_, w| w.pwren().enabled());
    pwr.cr().modify(|_, w| w.vos().scale1());

    rcc.pllcfgr().write(|w| {
        // SAFETY: factors within the fields and the PLL's limits, see `rates`.
        #[allow(unsafe_code, reason = "the register's fields take any bits")]
        unsafe {
            w.pllm().bits(PLL_M as u8).plln().bits(PLL_N as u16).pllq().bits(PLL_Q as u8);
        }
        w.pllp().div2().pllsrc().hse()
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    wait(FLAG_POLLS, || rcc.cr().read().pllrdy().is_ready()).ok_or(ClockFault::PllUnlocked)?;

    // Five wait states for 168 MHz at 2.7 to 3.6 V, in force once they read back.
    flash
        .acr()
        .modify(|_, w| w.latency().ws5().prften().enabled().icen().enabled().dcen().enabled());
    wait(FLAG_POLLS, || flash.acr().read().latency().is_ws5()).ok_or(ClockFault::FlashTooFast)?;

    rcc.cfgr().modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    wait(FLAG_POLLS, || rcc.cfgr().read().sws().is_pll()).ok_or(ClockFault::NotSwitched)?;

    rcc.cr().modify(|_, w| w.csson().on());
    Ok(())
}

/// Back to where the chip is after reset; the wait states may stay, they only cost time.
fn run_on_internal(rcc: &RCC) {
    rcc.cfgr().modify(|_, w| w.sw().hsi());
    // If this isn't confirmed there is nothing left to try.
    let _ = wait(FLAG_POLLS, || rcc.cfgr().read().sws().is_hsi());
    rcc.cfgr().modify(|_, w| w.hpre().div1().ppre1().div1().ppre2().div1());
    rcc.cr().modify(|_, w| w.pllon().off().hseon().off());
}

/// Polls `done`, but no more than `polls` times; `None` if it never was.
pub fn wait(polls: u32, mut done: impl FnMut() -> bool) -> Option<()> {
    for _ in 0..polls {
        if done() {
            return Some(());
        }
    }
    None
}

#[allow(unsafe_code, reason = "cortex-m-rt asks for an unsafe handler")]
// SAFETY: called by the hardware only. It shares registers with code that it interrupts, and no
// memory but atomics.
#[exception]
unsafe fn NonMaskableInt() {
    // SAFETY: only the registers that hold a rate are written, each in one store, and nobody else
    // writes them after start-up.
    let chip = unsafe { Peripherals::steal() };
    if chip.RCC.cir().read().cssf().bit_is_clear() {
        return;
    }
    chip.RCC.cir().modify(|_, w| w.cssc().clear());
    chip.RCC.cfgr().modify(|_, w| w.ppre1().div1().ppre2().div1());
    FAULT.store(ClockFault::CrystalLost as u8, Ordering::Relaxed);
    super::follow_clocks(&chip, &Clocks::INTERNAL);
}
