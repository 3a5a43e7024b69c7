//! A panel: axes and the series between them.

use std::ops::Range;

use serde::Serialize;

use super::decimate::Point;
use super::series::{Drawn, Series};

/// Series on a pair of axes, and the labels of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    pub(super) y_label: String,
    pub(super) series: Vec<Series>,
    /// Part of the horizontal axis, 0 to 1, that the vertical scale need not contain.
    settling: f64,
    /// Fixed vertical range.
    span: Option<(f64, f64)>,
    /// Names of the whole numbers on the horizontal axis.
    categories: Vec<String>,
    is_logarithmic: bool,
}

impl Panel {
    /// An empty panel.
    pub fn new(y_label: impl Into<String>) -> Self {
        Self {
            y_label: y_label.into(),
            series: Vec::new(),
            settling: 0.0,
            span: None,
            categories: Vec::new(),
            is_logarithmic: false,
        }
    }

    /// Adds a series, drawn over the others.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Fits the vertical scale to the points after this part of the horizontal axis, 0 to 1.
    pub fn fit_after(mut self, settling: f64) -> Self {
        self.settling = settling;
        self
    }

    /// Sets the lower and upper end of the vertical scale.
    pub fn span(mut self, low: f64, high: f64) -> Self {
        self.span = Some((low, high));
        self
    }

    /// Names the whole numbers from zero on the horizontal axis.
    pub fn categories(mut self, names: &[&str]) -> Self {
        self.categories = names.iter().map(|name| (*name).to_owned()).collect();
        self
    }

    /// Makes the vertical scale logarithmic.
    pub fn logarithmic(mut self) -> Self {
        self.is_logarithmic = true;
        self
    }

    fn x_range(&self) -> Range<f64> {
        if !self.categories.is_empty() {
            return -0.6..self.categories.len() as f64 - 0.4;
        }
        let points = self.series.iter().flat_map(Series::extremes).map(|point| point.0);
        let (first, last) = extent(points).unwrap_or((0.0, 1.0));
        first..if last > first { last } else { first + 1.0 }
    }

    /// Vertical range: all points after settling, and a margin. None without a point.
    fn y_range(&self, x: &Range<f64>) -> Option<(f64, f64)> {
        /// Margin above and below, share of the height.
        const MARGIN: f64 = 0.06;
        /// Least margin, share of the largest value: a constant has no height of its own.
        const LEAST_MARGIN: f64 = 1e-6;
        /// Larger values are left out: the axis would overflow.
        const LARGEST: f64 = 1e100;

        if self.span.is_some() {
            return self.span;
        }
        let start = x.start + self.settling * (x.end - x.start);
        let points = self.series.iter().flat_map(Series::extremes);
        let is_logarithmic = self.is_logarithmic;
        let is_fit = |point: &Point| {
            point.0 >= start && point.1.abs() < LARGEST && (!is_logarithmic || point.1 > 0.0)
        };
        let height = |point: Point| if is_logarithmic { point.1.log10() } else { point.1 };
        let (low, high) = extent(points.filter(is_fit).map(height))?;
        let least = (low.abs().max(high.abs()) * LEAST_MARGIN).max(1e-30);
        let margin = ((high - low) * MARGIN).max(least);
        // Bars stand on the axis: no margin below zero.
        let has_bars = self.series.iter().any(Series::is_bars) && low == 0.0;
        let (low, high) = (if has_bars { 0.0 } else { low - margin }, high + margin);
        Some(if is_logarithmic { (10_f64.powf(low), 10_f64.powf(high)) } else { (low, high) })
    }

    /// The panel as the page draws it. Series without points are left out.
    pub(super) fn drawn(&self) -> DrawnPanel<'_> {
        let x = self.x_range();
        DrawnPanel {
            y_label: &self.y_label,
            x_range: [x.start, x.end],
            y_range: self.y_range(&x),
            logarithmic: self.is_logarithmic,
            categories: &self.categories,
            series: self.series.iter().filter(|s| !s.is_empty()).map(Series::drawn).collect(),
        }
    }
}

/// A panel as the page draws it.
#[derive(Serialize)]
pub(super) struct DrawnPanel<'a> {
    y_label: &'a str,
    x_range: [f64; 2],
    y_range: Option<(f64, f64)>,
    logarithmic: bool,
    categories: &'a [String],
    series: Vec<Drawn<'a>>,
}

/// Smallest and largest of the finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |extent, value| match extent {
        None => Some((value, value)),
        Some((low, high)) => Some((f64::min(low, value), f64::max(high, value))),
    })
}

#[cfg(test)]
mod tests {
    use super::super::style::{Colour, Mark};
    use super::*;

    fn panel(points: &[Point]) -> Panel {
        let curve = Series::curve("a", Mark::Line, Colour::Main, points.iter().copied());
        Panel::new("a, m").with(curve)
    }

    #[test]
    fn range_fits_the_points_after_settling() {
        let panel = panel(&[(0.0, 1e6), (50.0, 2.0), (100.0, 1.0)]).fit_after(0.25);
        let (low, high) = panel.y_range(&panel.x_range()).unwrap();
        assert!(low < 1.0 && low > 0.9 && high > 2.0 && high < 2.1, "{low} {high}");
    }

    #[test]
    fn constant_short_or_not_finite_points_have_a_range() {
        for points in [vec![(0.0, 3.0)], vec![(0.0, 1e-300), (1.0, 1e300)], vec![(0.0, 0.0)]] {
            let panel = panel(&points);
            let x = panel.x_range();
            assert!(x.end > x.start);
            assert!(panel.y_range(&x).is_none_or(|(low, high)| high > low), "{points:?}");
        }
        assert_eq!(panel(&[(0.0, f64::NAN)]).y_range(&(0.0..1.0)), None);
    }

    #[test]
    fn logarithmic_range_leaves_out_what_has_no_logarithm() {
        let panel = panel(&[(0.0, 0.0), (1.0, 1e-3), (2.0, 10.0)]).logarithmic();
        let (low, high) = panel.y_range(&panel.x_range()).unwrap();
        assert!(low > 1e-4 && low < 1e-3 && high > 10.0 && high < 100.0, "{low} {high}");
    }
}
