//! Heading lines of a table, and the format of its cells.

use crate::report::number::{fixed, power, significant};

/// Significant digits of an uncertainty or an error.
pub(in crate::report) const DIGITS: usize = 3;
/// Cell without a value.
pub(in crate::report) const EMPTY: &str = "-";
/// Bound of an element that the motion does not observe.
pub(in crate::report) const UNOBSERVED: &str = "unobserved";

/// A line `name  text` above a table.
pub(super) fn heading(name: &str, text: &str) -> String {
    format!("{name:<20}{text}\n")
}

/// Three components, separated by commas.
pub(super) fn vector(values: &[f64; 3]) -> String {
    values.map(|value| significant(value, DIGITS)).join(", ")
}

/// A number with [`DIGITS`] significant digits, or `otherwise`.
pub(in crate::report) fn short(number: Option<f64>, otherwise: &str) -> String {
    or(number.map(|number| significant(number, DIGITS)), otherwise)
}

/// `text`, or `otherwise`.
pub(in crate::report) fn or(text: Option<String>, otherwise: &str) -> String {
    text.unwrap_or_else(|| otherwise.to_owned())
}

/// Decimals of a column of elements: two digits of the smallest sigma, within four to nine digits
/// of the largest element. Six digits without a sigma.
pub(in crate::report) fn decimals(sigmas: &[f64; 6], elements: &[f64; 6]) -> i32 {
    let smallest =
        sigmas.iter().copied().filter(|sigma| *sigma > 0.0).fold(f64::INFINITY, f64::min);
    let largest = elements.iter().fold(0.0, |largest: f64, element| largest.max(element.abs()));
    let significant_of_largest = |digits: i32| digits - 1 - power(largest);
    if smallest.is_finite() {
        (1 - power(smallest)).clamp(significant_of_largest(4), significant_of_largest(9))
    } else {
        significant_of_largest(6)
    }
}

/// An element in a column: all with the same decimals, or all with an exponent.
pub(in crate::report) fn element(value: f64, decimals: i32) -> String {
    const MOST_DECIMALS: i32 = 9;
    if decimals <= MOST_DECIMALS {
        fixed(value, decimals)
    } else if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.5e}")
    }
}
