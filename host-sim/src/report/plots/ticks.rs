//! Tick labels of an axis.

use std::ops::Range;

use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;

use crate::report::number::significant;

/// Largest number of ticks on a vertical axis.
pub(super) const Y_TICKS: usize = 6;
/// Largest number of ticks on a horizontal axis.
pub(super) const X_TICKS: usize = 7;

/// Label of a tick at `10^power` on a logarithmic axis.
pub(super) fn power_of_ten(power: f64) -> String {
    let value = 10f64.powf(power);
    match (power - power.round()).abs() < 1e-6 {
        true if (-3.0..=4.5).contains(&power) => significant(value, 1),
        true => format!("1e{}", power.round()),
        false => significant(value, 2),
    }
}

/// Label format of an axis: the fewest digits that distinguish its ticks, with an exponent if more
/// than four decimals would be needed.
pub(super) fn tick_format(range: &Range<f64>, most: usize) -> impl Fn(&f64) -> String {
    const MOST_DECIMALS: usize = 4;
    const MOST_DIGITS: usize = 12;
    let ticks = RangedCoordf64::from(range.clone()).key_points(most);
    let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let step = if step.is_finite() { step } else { range.end - range.start };

    let write = move |value: f64, digits: usize, has_exponent: bool| {
        // A tick near zero is zero with a rounding error.
        match (value.abs() < step / 1e3, has_exponent) {
            (true, _) => "0".to_owned(),
            (false, true) => format!("{value:.digits$e}"),
            (false, false) => format!("{value:.digits$}"),
        }
    };
    let is_exact = |digits: usize, has_exponent: bool| {
        let error =
            |tick: f64| write(tick, digits, has_exponent).parse().unwrap_or(f64::NAN) - tick;
        ticks.iter().all(|tick| error(*tick).abs() < step / 1e3)
    };
    let largest = range.start.abs().max(range.end.abs());
    let decimals = (0..=MOST_DECIMALS).find(|digits| is_exact(*digits, false));
    let (digits, has_exponent) = match decimals {
        Some(decimals) if largest < 1e6 => (decimals, false),
        _ => (0..MOST_DIGITS)
            .find(|digits| is_exact(*digits, true))
            .map_or((MOST_DIGITS, true), |digits| (digits, true)),
    };
    move |value| write(*value, digits, has_exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_have_the_decimals_that_distinguish_them() {
        assert_eq!(tick_format(&(14.19..14.21), Y_TICKS)(&14.2), "14.200");
        assert_eq!(tick_format(&(0.0..0.04), Y_TICKS)(&0.03), "0.03");
        assert_eq!(tick_format(&(-5e-4..5e-4), Y_TICKS)(&2e-4), "0.0002");
        assert_eq!(tick_format(&(-5e-6..5e-6), Y_TICKS)(&-2e-6), "-2e-6");
        assert_eq!(tick_format(&(0.0..600.0), Y_TICKS)(&1e-17), "0");
    }

    #[test]
    fn logarithmic_ticks_show_values() {
        for (power, text) in [(2.0, "100"), (-3.0, "0.001"), (-6.0, "1e-6"), (0.5, "3.2")] {
            assert_eq!(power_of_ten(power), text);
        }
    }
}
