//! Numbers as an engineer writes them: so many significant digits, an exponent where zeros would
//! otherwise have to be counted.

/// Numbers below this are written with an exponent.
const SMALLEST_PLAIN: f64 = 1e-4;
/// And numbers from this on.
const LARGEST_PLAIN: f64 = 1e6;

/// A number with so many significant digits, as `0.00275` or `8.54e-9`.
pub(super) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.max(1);
    let size = value.abs();
    if !(SMALLEST_PLAIN..LARGEST_PLAIN).contains(&size) {
        return format!("{value:.*e}", digits - 1);
    }
    fixed(value, digits as i32 - 1 - power(size))
}

/// A number with so many decimals; none if that is negative.
pub(super) fn fixed(value: f64, decimals: i32) -> String {
    format!("{value:.*}", decimals.max(0) as usize)
}

/// The power of ten of the first significant digit; 0 for zero.
pub(super) fn power(value: f64) -> i32 {
    if value == 0.0 || !value.is_finite() { 0 } else { value.abs().log10().floor() as i32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_significant() {
        for (value, expected) in [
            (14.201_02, "14.2"),
            (0.002_751, "0.00275"),
            (-0.000_027_5, "-2.75e-5"),
            (123_456.0, "123456"),
            (1.5e7, "1.50e7"),
            (0.0, "0"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(significant(value, 3), expected);
        }
    }
}
