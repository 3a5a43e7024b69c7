//! 64-bit time from a 32-bit microsecond counter.
//!
//! Input: the counter, at each request for the time. Output: microseconds since counter zero.
//! Assumption: two readings are less than one wrap of the counter apart (71 minutes).

/// Time of the last reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExtendedTime {
    us: u64,
}

impl ExtendedTime {
    /// Time zero.
    pub const START: Self = Self { us: 0 };

    /// First time after the last reading at which the counter reads `count_us`.
    pub const fn advanced_to(self, count_us: u32) -> Self {
        let elapsed_us = count_us.wrapping_sub(self.us as u32);
        Self { us: self.us.wrapping_add(elapsed_us as u64) }
    }

    /// Smallest time from `time_us` on with the present 32 low bits, µs.
    pub const fn resumed_at(self, time_us: u64) -> Self {
        let behind_us = time_us.saturating_sub(self.us);
        let wraps = behind_us.div_ceil(1 << 32);
        Self { us: self.us.wrapping_add(wraps << 32) }
    }

    /// Time, µs.
    pub const fn us(self) -> u64 {
        self.us
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_continues_over_wraps_of_the_counter() {
        let mut time = ExtendedTime::START;
        let step_us: u32 = 1_000_000_007; // more than four steps per wrap, at varying counts
        for readings in 1..=100_u64 {
            time = time.advanced_to((time.us() as u32).wrapping_add(step_us));
            assert_eq!(time.us(), readings * u64::from(step_us));
        }
    }

    #[test]
    fn resumed_clock_is_never_behind_and_follows_its_counter() {
        let time = ExtendedTime::START.advanced_to(1_000);
        assert_eq!(time.resumed_at(900), time);
        let later = time.resumed_at(10_000_000_000);
        assert!((10_000_000_000..10_000_000_000 + (1 << 32)).contains(&later.us()));
        assert_eq!(later.advanced_to(1_007).us(), later.us() + 7);
    }

    #[test]
    fn same_count_is_the_same_time() {
        let time = ExtendedTime::START.advanced_to(u32::MAX);
        assert_eq!(time.advanced_to(u32::MAX), time);
        assert_eq!(time.advanced_to(0).us(), 1 << 32);
    }
}
