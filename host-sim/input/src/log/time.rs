//! Time stamps, from decimal text to integers, exactly.
//!
//! `f64` seconds since 1970 resolve only 0.2 µs, and sums over a long log lose microseconds. Time is
//! therefore integer throughout: text → picoseconds → difference → microseconds.

use crate::units::TimeUnit;

/// Resolution: decimal places of a second.
const DECIMALS: i32 = 12;
const PICOSECONDS_PER_MICROSECOND: i128 = 1_000_000;
/// Limit of a time stamp, as a power of ten: within `i128` at this resolution.
const MAX_POWER: i32 = 20;
/// The years 2000 to 2100 in seconds since 1970.
const CENTURY_S: std::ops::Range<i128> = 946_684_800..4_102_444_800;
pub(super) const PICOSECONDS_PER_SECOND: i128 = 1_000_000_000_000;

/// Unit of a log with this first stamp, if its craft file states none: other than the second only where
/// the number is a time since 1970 in that unit, within the years 2000 to 2100. As seconds these are
/// 30,000 years and more.
pub(super) fn unit_of(first: TimeStamp) -> TimeUnit {
    let is_since_1970 = |unit: &TimeUnit| {
        CENTURY_S.contains(&(first.picoseconds / (PICOSECONDS_PER_SECOND * per_second(*unit))))
    };
    let small = [TimeUnit::Millisecond, TimeUnit::Microsecond, TimeUnit::Nanosecond];
    small.into_iter().find(is_since_1970).unwrap_or(TimeUnit::Second)
}

/// Units per second.
pub(super) fn per_second(unit: TimeUnit) -> i128 {
    10i128.pow(unit.power().unsigned_abs())
}

/// A time stamp from the log's own origin: picoseconds, if the unit of its column is the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TimeStamp {
    pub(super) picoseconds: i128,
}

/// Fault of a text that is not a time stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TimeError {
    /// Not a decimal number.
    NotANumber,
    /// NaN, infinite, or beyond 10²⁰.
    NotFinite,
}

impl TimeStamp {
    /// A decimal number in `unit`, with or without an exponent, truncated to twelve decimals of a second, or of the unit
    /// where it is longer.
    pub(super) fn parse_in(text: &str, unit: TimeUnit) -> Result<Self, TimeError> {
        // The grammar of numbers is that of the standard library, in this column as in the others.
        let approximate: f64 = text.parse().map_err(|_| TimeError::NotANumber)?;
        if !approximate.is_finite() || approximate.abs() >= 10f64.powi(MAX_POWER) {
            return Err(TimeError::NotFinite);
        }

        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>()),
            None => (text, Ok(0)),
        };
        // An exponent beyond i32 with a finite value: the value is zero to this resolution.
        let Ok(exponent) = exponent else { return Ok(Self { picoseconds: 0 }) };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));

        // value = digits · 10^(exponent − length of fraction) s, digit by digit down to the last
        // decimal of the resolution.
        let digits = whole.bytes().chain(fraction.bytes()).filter(u8::is_ascii_digit);
        let digits_before_point = whole.bytes().filter(u8::is_ascii_digit).count();
        let mut power =
            i64::from(exponent) + digits_before_point as i64 + i64::from(DECIMALS + unit.power());
        let mut picoseconds: i128 = 0;
        for digit in digits {
            if power <= 0 {
                break;
            }
            power -= 1;
            picoseconds = picoseconds * 10 + i128::from(digit - b'0');
        }
        for _ in 0..power {
            if picoseconds == 0 {
                break;
            }
            picoseconds *= 10;
        }
        let sign = if text.starts_with('-') { -1 } else { 1 };
        Ok(Self { picoseconds: sign * picoseconds * unit.multiple() })
    }

    /// The time since `start`, rounded to 1 µs, both in `unit`; none if negative or beyond 64 bits.
    pub(super) fn microseconds_since(self, start: Self, unit: TimeUnit) -> Option<u64> {
        let microsecond = PICOSECONDS_PER_MICROSECOND * per_second(unit);
        u64::try_from((self.since(start) + microsecond / 2).div_euclid(microsecond)).ok()
    }

    /// Microseconds from the log's own origin, rounded down; none beyond 64 bits.
    pub(super) fn microseconds(self, unit: TimeUnit) -> Option<i64> {
        let microsecond = PICOSECONDS_PER_MICROSECOND * per_second(unit);
        i64::try_from(self.picoseconds.div_euclid(microsecond)).ok()
    }

    /// The time since `start`, picoseconds if the unit is the second.
    pub(super) fn since(self, start: Self) -> i128 {
        self.picoseconds - start.picoseconds
    }
}

/// Seconds as an exact decimal number without trailing zeros.
pub(super) fn seconds_text(time_us: u64) -> String {
    let (whole, fraction) = (time_us / 1_000_000, time_us % 1_000_000);
    let text = format!("{whole}.{fraction:06}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<TimeStamp, TimeError> {
        TimeStamp::parse_in(text, TimeUnit::Second)
    }

    fn microseconds(start: &str, end: &str) -> Option<u64> {
        let (start, end) = (parse(start).unwrap(), parse(end).unwrap());
        end.microseconds_since(start, TimeUnit::Second)
    }

    #[test]
    fn times_since_1970_in_small_units_are_read_without_loss() {
        let unit = |text| unit_of(parse(text).unwrap());
        for (first, second, expected) in [
            ("1700000000000000000", "1700000000000001000", TimeUnit::Nanosecond),
            ("1700000000000000", "1700000000000001", TimeUnit::Microsecond),
            ("1700000000000", "1700000000000.001", TimeUnit::Millisecond),
            ("1700000000", "1700000000.000001", TimeUnit::Second),
        ] {
            assert_eq!(unit(first), expected, "{first}");
            let stamps = [first, second].map(|text| parse(text).unwrap());
            assert_eq!(stamps[1].microseconds_since(stamps[0], expected), Some(1), "{first}");
        }
        for relative in ["0", "100", "-5", "1e6", "12345678901"] {
            assert_eq!(unit(relative), TimeUnit::Second, "{relative}");
        }
    }

    #[test]
    fn decimal_text_is_exact() {
        for (text, expected) in [
            ("0.1", 100_000),
            ("1e-1", 100_000),
            ("+.1E+0", 100_000),
            ("0.000001", 1),
            ("1.", 1_000_000),
            ("12345e-4", 1_234_500),
            ("0.00001e5", 1_000_000),
            ("2.47E-4", 247),
            ("0.0000004", 0),
            ("0.0000005", 1),
            ("1e-999999999999", 0),
            ("0e999999999999", 0),
            ("123456789.123456", 123_456_789_123_456),
        ] {
            assert_eq!(microseconds("0", text), Some(expected), "{text}");
        }
    }

    #[test]
    fn stated_units_are_exact() {
        for (text, unit, picoseconds) in [
            ("1700000000000000001", TimeUnit::Nanosecond, 1_700_000_000_000_000_001_000),
            ("12.5", TimeUnit::Microsecond, 12_500_000),
            ("-3e-3", TimeUnit::Millisecond, -3_000_000),
            ("0.0004", TimeUnit::Nanosecond, 0),
            ("2", TimeUnit::Minute, 120_000_000_000_000),
            ("-0.5", TimeUnit::Hour, -1_800_000_000_000_000),
            ("60000.000001", TimeUnit::Day, 5_184_000_000_086_400_000_000),
            ("2360", TimeUnit::Week, 1_427_328_000_000_000_000_000),
        ] {
            assert_eq!(TimeStamp::parse_in(text, unit), Ok(TimeStamp { picoseconds }), "{text}");
        }
    }

    #[test]
    fn microseconds_are_exact_from_a_distant_origin() {
        assert_eq!(microseconds("1750000000.000001", "1750000000.000248"), Some(247));
        assert_eq!(microseconds("-0.5", "0.25"), Some(750_000));
        // Equal as f64.
        assert_eq!(microseconds("100000000000000000.1", "100000000000000000.2"), Some(100_000));
    }

    #[test]
    fn text_that_is_not_a_time_is_rejected() {
        for (text, expected) in [
            ("", TimeError::NotANumber),
            ("-", TimeError::NotANumber),
            ("1e", TimeError::NotANumber),
            ("0x10", TimeError::NotANumber),
            ("12:00", TimeError::NotANumber),
            ("nan", TimeError::NotFinite),
            ("-inf", TimeError::NotFinite),
            ("1e400", TimeError::NotFinite),
            ("1e20", TimeError::NotFinite),
        ] {
            assert_eq!(parse(text), Err(expected), "{text:?}");
        }
    }

    #[test]
    fn overflow_and_negative_differences_give_none() {
        assert_eq!(microseconds("0", "9e17"), None);
        assert_eq!(microseconds("1", "0"), None);
    }

    #[test]
    fn written_time_reads_back_exactly() {
        for time_us in [0, 1, 247, 100_000, 1_000_000, 123_456_789_123_456] {
            assert_eq!(microseconds("0", &seconds_text(time_us)), Some(time_us));
        }
        assert_eq!(seconds_text(600_000_000), "600");
    }
}
