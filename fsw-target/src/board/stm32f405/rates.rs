//! Dividers of clocks for the required rates, and the limit of the prefetch: integer arithmetic, tested on
//! the host.
//!
//! Input: the current clocks. Output: register values of USARTs, timers and SPI.

/// Source of the clocks of core and buses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum ClockSource {
    /// The 8 MHz crystal (HSE) and the PLL: 168 MHz with the accuracy of the crystal.
    Crystal,
    /// The internal RC oscillator (HSI): 16 MHz within 1 % at 25 °C, and within −8 to +4.5 % from
    /// −40 to 105 °C (DS8626, HSI oscillator characteristics). Time stamps and wheel speeds have the
    /// same error.
    Internal,
}

/// Clocks of core and buses, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clocks {
    /// Source.
    pub source: ClockSource,
    /// Core, AHB and SysTick.
    pub core_hz: u32,
    /// USART2; TIM2 to TIM7 by [`timer_hz`](Self::timer_hz).
    pub apb1_hz: u32,
    /// USART1 and SPI1.
    pub apb2_hz: u32,
}

/// The crystal of the board.
pub const HSE_HZ: u32 = 8_000_000;

impl Clocks {
    /// Clocks after a reset or a failure of the crystal: the internal oscillator without divider.
    pub const INTERNAL: Self = Self {
        source: ClockSource::Internal,
        core_hz: 16_000_000,
        apb1_hz: 16_000_000,
        apb2_hz: 16_000_000,
    };

    /// Fastest clocks of the chip: 168 MHz, and the buses at their limits of 42 and 84 MHz.
    pub const CRYSTAL: Self = Self {
        source: ClockSource::Crystal,
        core_hz: HSE_HZ / PLL_M * PLL_N / PLL_P,
        apb1_hz: HSE_HZ / PLL_M * PLL_N / PLL_P / 4,
        apb2_hz: HSE_HZ / PLL_M * PLL_N / PLL_P / 2,
    };

    /// Clock of TIM2 to TIM5, Hz: twice that of their bus if the bus is divided (RM0090, section 7.2,
    /// clocks).
    pub const fn timer_hz(&self) -> u32 {
        if self.apb1_hz == self.core_hz { self.apb1_hz } else { 2 * self.apb1_hz }
    }
}

/// Divider before the PLL: 2 MHz, the input with the least jitter (RM0090, RCC_PLLCFGR).
pub const PLL_M: u32 = HSE_HZ / 2_000_000;
/// Multiplier of the PLL: 336 MHz, within 100 to 432 MHz.
pub const PLL_N: u32 = 168;
/// Divider behind the PLL: 168 MHz.
pub const PLL_P: u32 = 2;
/// Divider for USB and random number generator: 48 MHz. Unused, but its value must be valid.
pub const PLL_Q: u32 = 7;

/// USART_BRR with oversampling by 16: clock / baud, rounded.
pub const fn baud_divider(bus_hz: u32, baud: u32) -> u32 {
    (bus_hz + baud / 2) / baud
}

/// TIMx_PSC of a counter at `ticks_per_s`: the divider less one.
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

/// SPI_CR1.BR of the fastest clock up to `limit_hz`: the field `n` divides the bus clock by 2ⁿ⁺¹, 2 to
/// 256.
pub const fn spi_divider(bus_hz: u32, limit_hz: u32) -> u8 {
    let mut field = 0;
    while field < 7 && (bus_hz >> (field + 1)) > limit_hz {
        field += 1;
    }
    field
}

/// REV_ID of the first revision of the silicon after A (RM0090, DBGMCU_IDCODE: A is 0x1000, Z 0x1001).
const AFTER_A: u16 = 0x1001;

/// True if the flash may prefetch: not on revision A (ES0182, "ART Accelerator prefetch queue instruction
/// is not supported").
pub const fn can_prefetch(revision: u16) -> bool {
    revision >= AFTER_A
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of the tolerance of a receiver: it samples the tenth and last bit of a byte within half a bit,
    /// 5 %, for both ends and their crystals together.
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
    fn revision_a_does_not_prefetch() {
        assert!(!can_prefetch(0x1000));
        assert!([0x1001, 0x1003, 0x1007, 0x100f].into_iter().all(can_prefetch));
    }

    #[test]
    fn the_baud_rate_is_accurate_on_both_clocks_and_buses() {
        for clocks in [Clocks::CRYSTAL, Clocks::INTERNAL] {
            for bus_hz in [clocks.apb1_hz, clocks.apb2_hz] {
                let baud = f64::from(bus_hz) / f64::from(baud_divider(bus_hz, 115_200));
                assert!((baud / 115_200.0 - 1.0).abs() < BAUD_TOLERANCE, "{baud} of {bus_hz}");
            }
        }
    }

    #[test]
    fn timers_have_the_same_rate_on_both_clocks() {
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
