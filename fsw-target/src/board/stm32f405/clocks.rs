//! Clock tree: 168 MHz from the 8 MHz crystal and the PLL; after their failure, the internal 16 MHz.
//!
//! Output: the current clocks, and the reason if they are the internal ones. Every wait is bounded: a dead
//! crystal must not stop a flight board, and the clock unit of QEMU always reads 0. (For this reason the
//! registers are used directly and not through stm32f4xx-hal, whose set-up waits without a bound.)
//!
//! A crystal that fails in flight: see `clock_failure.rs`.
//!
//! Registers: RM0090, chapters 3 (flash latency), 5 (PWR) and 7 (RCC of the STM32F405).

use super::rates::{Clocks, PLL_M, PLL_N, PLL_Q, can_prefetch};
use crate::runtime::bounded::wait;
use core::sync::atomic::{AtomicU8, Ordering};
use stm32f4::stm32f405::{FLASH, PWR, RCC};

/// Polls of the ready flag of the crystal: at 16 MHz and at least six cycles each, more than 100 ms. A
/// crystal takes 2 ms (DS8626, HSE oscillator characteristics).
const CRYSTAL_POLLS: u32 = 300_000;

/// Polls of any other flag: more than 3 ms. The PLL locks within 0.3 ms (DS8626, main PLL
/// characteristics), the others within microseconds.
const FLAG_POLLS: u32 = 10_000;

/// Reason for a clock other than the crystal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
#[repr(u8)]
pub enum ClockFault {
    /// The crystal did not start.
    CrystalDead = 1,
    /// The PLL did not lock.
    PllUnlocked = 2,
    /// The flash did not accept the wait states of the fast clock.
    FlashTooFast = 3,
    /// The core did not switch to the PLL.
    NotSwitched = 4,
    /// The crystal failed after start-up.
    CrystalLost = 5,
}

/// Number of the [`ClockFault`]; 0: none, the crystal is in use.
static FAULT: AtomicU8 = AtomicU8::new(ClockFault::CrystalDead as u8);

/// Reason for a clock other than the crystal, if one is in use.
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

/// Switches the bus clocks to the internal oscillator, after the hardware has switched the core to it.
pub(super) fn follow_loss_of_crystal(rcc: &RCC) {
    rcc.cfgr().modify(|_, w| w.ppre1().div1().ppre2().div1());
    FAULT.store(ClockFault::CrystalLost as u8, Ordering::Relaxed);
}

/// The current clocks.
pub fn in_force() -> Clocks {
    if fault().is_none() { Clocks::CRYSTAL } else { Clocks::INTERNAL }
}

/// Starts crystal and PLL, or stays on the internal oscillator for the reason of [`fault`]. Returns the
/// clocks in use. `revision` of the silicon: REV_ID of DBGMCU_IDCODE.
pub fn start(rcc: &RCC, pwr: &PWR, flash: &FLASH, revision: u16) -> Clocks {
    let fault = match run_on_crystal(rcc, pwr, flash, revision) {
        Ok(()) => 0,
        Err(fault) => {
            run_on_internal(rcc);
            fault as u8
        }
    };
    FAULT.store(fault, Ordering::Relaxed);
    in_force()
}

fn run_on_crystal(rcc: &RCC, pwr: &PWR, flash: &FLASH, revision: u16) -> Result<(), ClockFault> {
    rcc.cr().modify(|_, w| w.hseon().on());
    wait(CRYSTAL_POLLS, || rcc.cr().read().hserdy().is_ready()).ok_or(ClockFault::CrystalDead)?;

    // Voltage scale 1 is required above 144 MHz; it takes effect with the PLL.
    rcc.apb1enr().modify(|_, w| w.pwren().enabled());
    pwr.cr().modify(|_, w| w.vos().scale1());

    rcc.pllcfgr().write(|w| {
        // SAFETY: factors within the fields and the limits of the PLL, see `rates`.
        #[allow(unsafe_code, reason = "the fields take any bits")]
        unsafe {
            w.pllm().bits(PLL_M as u8).plln().bits(PLL_N as u16).pllq().bits(PLL_Q as u8);
        }
        w.pllp().div2().pllsrc().hse()
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    wait(FLAG_POLLS, || rcc.cr().read().pllrdy().is_ready()).ok_or(ClockFault::PllUnlocked)?;

    // Five wait states for 168 MHz at 2.7 to 3.6 V, effective once they read back.
    flash.acr().modify(|_, w| {
        w.latency().ws5().icen().enabled().dcen().enabled().prften().bit(can_prefetch(revision))
    });
    wait(FLAG_POLLS, || flash.acr().read().latency().is_ws5()).ok_or(ClockFault::FlashTooFast)?;

    rcc.cfgr().modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    wait(FLAG_POLLS, || rcc.cfgr().read().sws().is_pll()).ok_or(ClockFault::NotSwitched)?;

    rcc.cr().modify(|_, w| w.csson().on());
    Ok(())
}

/// Returns to the clocks after a reset. The wait states may stay: they only cost time.
fn run_on_internal(rcc: &RCC) {
    rcc.cfgr().modify(|_, w| w.sw().hsi());
    // Without this confirmation no other clock is left.
    let _ = wait(FLAG_POLLS, || rcc.cfgr().read().sws().is_hsi());
    rcc.cfgr().modify(|_, w| w.hpre().div1().ppre1().div1().ppre2().div1());
    rcc.cr().modify(|_, w| w.pllon().off().hseon().off());
}
