//! Wanted rates, and the dividers that come nearest to them: whole-number arithmetic alone, so that
//! the host tests it.
//!
//! Input: the clocks in force. Output: register values for USARTs, timers and SPI.

/// What drives the core and the buses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum ClockSource {
    /// The 8 MHz crystal (HSE), multiplied by the PLL: 168 MHz, as exact as the crystal.
    Crystal,
    /// The internal RC oscillator (HSI): 16 MHz within 1 % at 25 °C, and within −8 to +4.5 % from
    /// −40 to 105 °C (DS8626, HSI oscillator characteristics). Time stamps and wheel speeds are
    /// wrong by as much.
    Internal,
}

/// The clocks in force, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// What they come from.
    pub source: ClockSource,
    /// Core, AHB and SysTick.
    pub core_hz: u32,
    /// USART2 and, unless doubled, TIM2 to TIM7.
    pub apb1_hz: u32,
    /// USART1 and SPI1.
    pub apb2_hz: u32,
}

/// The crystal of the board.
pub const HSE_HZ: u32 = 8_000_000;

impl Clocks {
    /// After reset, and when the crystal fails: the internal oscillator, no divider.
    pub const INTERNAL: Self = Self {
        source: ClockSource::Internal,
        core_hz: 16_000_000,
        apb1_hz: 16_000_000,
        apb2_hz: 16_000_000,
    };

    /// The fastest that the chip allows: 168 MHz, with the buses at their limits of 42 and 84 MHz.
    pub const CRYSTAL: Self = Self {
        source: ClockSource::Crystal,
        core_hz: HSE_HZ / PLL_M * PLL_N / PLL_P,
        apb1_hz: HSE_HZ / PLL_M * PLL_N / PLL_P / 4,
        apb2_hz: HSE_HZ / PLL_M * PLL_N / PLL_P / 2,
    };

    /// Clock of TIM2 to TIM5: twice that of their bus as soon as the bus is divided (RM0090,
    /// section 7.2, clocks).
    pub const fn timer_hz(&self) -> u32 {
        if self.apb1_hz == self.core_hz { self.apb1_hz } else { 2 * self.apb1_hz }
    }
}

/// Divider before the PLL: 2 MHz, the input with the least jitter (RM0090, RCC_PLLCFGR).
pub const PLL_M: u32 = HSE_HZ / 2_000_000;
/// The PLL's multiplier: 336 MHz, within its 100 to 432 MHz.
pub const PLL_N: u32 = 168;
/// Divider behind the PLL: 168 MHz.
pub const PLL_P: u32 = 2;
/// Divider for USB and the random numbers: 48 MHz. Unused, but it must be a legal one.
pub const PLL_Q: u32 = 7;

/// USART_BRR with oversampling by 16: the bit time in sixteenths of the USART's clock times 16,
/// which is clock / baud, rounded.
pub const fn baud_divider(bus_hz: u32, baud: u32) -> u32 {
    (bus_hz + baud / 2) / baud
}

/// TIMx_PSC for a counter at `ticks_per_s`: the register divides by one more than it holds.
pub const fn timer_prescaler(timer_hz: u32, ticks_per_s: u32) -> u16 {
    let divider = timer_hz / ticks_per_s;
    if divider == 0 {
        0
    } else if divider > 0x1_0000 {
        0xffff
    } else {
        (divider - 1) as u16
    }
}

/// SPI_CR1.BR for the fastest clock of at most `limit_hz`: the bus is divided by 2 to the power of
/// one more than the field holds, so by 2 to 256.
pub const fn spi_divider(bus_hz: u32, limit_hz: u32) -> u8 {
    let mut field = 0;
    while field < 7 && (bus_hz >> (field + 1)) > limit_hz {
        field += 1;
    }
    field
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A receiver samples the last bit of a byte, the tenth, within its half: 5 %, of which both
    /// ends and the crystals share.
    const BAUD_TOLERANCE: f64 = 0.005;

    #[test]
    fn the_clocks_stay_within_the_limits_of_the_chip() {
        let clocks = Clocks::CRYSTAL;
        assert_eq!(
            (clocks.core_hz, clocks.apb1_hz, clocks.apb2_hz),
            (168_000_000, 42_000_000, 84_000_000)
        );
        assert_eq!(clocks.timer_hz(), 84_000_000);
        assert_eq!(Clocks::INTERNAL.timer_hz(), 16_000_000);
        assert_eq!(HSE_HZ / PLL_M * PLL_N / PLL_Q, 48_000_000);
    }

    #[test]
    fn the_baud_rate_is_met_on_both_clocks_and_both_buses() {
        for clocks in [Clocks::CRYSTAL, Clocks::INTERNAL] {
            for bus_hz in [clocks.apb1_hz, clocks.apb2_hz] {
                let baud = f64::from(bus_hz) / f64::from(baud_divider(bus_hz, 115_200));
                assert!((baud / 115_200.0 - 1.0).abs() < BAUD_TOLERANCE, "{baud} of {bus_hz}");
            }
        }
    }

    #[test]
    fn a_timer_ticks_at_the_same_rate_on_both_clocks() {
        for ticks_per_s in [1_000_000, 4_000_000] {
            for clocks in [Clocks::CRYSTAL, Clocks::INTERNAL] {
                let divider = u32::from(timer_prescaler(clocks.timer_hz(), ticks_per_s)) + 1;
                assert_eq!(divider * ticks_per_s, clocks.timer_hz());
            }
        }
        assert_eq!(timer_prescaler(16_000_000, 1), 0xffff);
        assert_eq!(timer_prescaler(1_000, 1_000_000), 0);
    }

    #[test]
    fn the_spi_clock_is_the_fastest_within_its_limit() {
        assert_eq!(spi_divider(84_000_000, 10_000_000), 3); // 5.25 MHz; 10.5 would be too fast
        assert_eq!(spi_divider(16_000_000, 10_000_000), 0); // 8 MHz
        assert_eq!(spi_divider(84_000_000, 1), 7);
    }
}
