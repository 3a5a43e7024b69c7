//! Numbers with a given number of significant digits, with an exponent outside 1e-4 to 1e6.

/// Smaller numbers are written with an exponent.
const SMALLEST_PLAIN: f64 = 1e-4;
/// Numbers from this value on are written with an exponent.
const LARGEST_PLAIN: f64 = 1e6;

/// A number with `digits` significant digits, as `0.00275` or `8.54e-9`.
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

/// A number with `decimals` decimals. Negative counts as zero.
pub(super) fn fixed(value: f64, decimals: i32) -> String {
    format!("{value:.*}", decimals.max(0) as usize)
}

/// Power of ten of the first significant digit. Zero for zero and for non-finite values.
pub(super) fn power(value: f64) -> i32 {
    if value == 0.0 || !value.is_finite() { 0 } else { value.abs().log10().floor() as i32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_given_significant_digits() {
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
