//! A panel: axes and the series between them.

use std::ops::Range;

use plotters::prelude::*;

use super::canvas::{Area, PlotError, failed};
use super::decimate::Point;
use super::scale::Scale;
use super::series::{Series, Shape};
use super::style::{GRID, INK, label_style};
use super::ticks::{X_TICKS, Y_TICKS, power_of_ten, tick_format};

/// Series on a pair of axes, and the labels of the axes.
#[derive(Clone, Debug)]
pub struct Panel {
    y_label: String,
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

    /// Vertical scale: all points after settling, and a margin.
    fn scale(&self, x: &Range<f64>) -> Scale {
        /// Margin above and below, share of the height.
        const MARGIN: f64 = 0.06;
        /// Least margin, share of the largest value: a constant has no height of its own.
        const LEAST_MARGIN: f64 = 1e-6;
        /// Larger values are left out: the axis would overflow.
        const LARGEST: f64 = 1e100;

        if let Some((low, high)) = self.span {
            return Scale { range: low..high, is_logarithmic: false };
        }
        let start = x.start + self.settling * (x.end - x.start);
        let points = self.series.iter().flat_map(Series::extremes);
        let is_logarithmic = self.is_logarithmic;
        let is_fit = |point: &Point| {
            point.0 >= start && point.1.abs() < LARGEST && (!is_logarithmic || point.1 > 0.0)
        };
        let height = |point: Point| if is_logarithmic { point.1.log10() } else { point.1 };
        let (low, high) = extent(points.filter(is_fit).map(height)).unwrap_or((-1.0, 1.0));
        let least = (low.abs().max(high.abs()) * LEAST_MARGIN).max(1e-30);
        let margin = ((high - low) * MARGIN).max(least);
        // Bars stand on the axis: no margin below zero.
        let has_bars =
            self.series.iter().any(|series| matches!(series.shape, Shape::Bars(_))) && low == 0.0;
        Scale { range: if has_bars { 0.0 } else { low - margin }..high + margin, is_logarithmic }
    }

    /// Draws axes and series.
    pub(super) fn draw(&self, area: &Area<'_>, x_label: &str) -> Result<(), PlotError> {
        /// Width of the labels of the vertical axis, px.
        const Y_LABELS: i32 = 80;
        /// Height of the labels of the horizontal axis, px.
        const X_LABELS: i32 = 44;

        let x = self.x_range();
        let scale = self.scale(&x);
        let mut chart = ChartBuilder::on(area)
            .margin(6)
            .margin_right(20)
            .set_label_area_size(LabelAreaPosition::Left, Y_LABELS)
            .set_label_area_size(LabelAreaPosition::Bottom, X_LABELS)
            .build_cartesian_2d(x.clone(), scale.range.clone())
            .map_err(failed)?;
        let y_tick = tick_format(&scale.range, Y_TICKS);
        let x_tick = tick_format(&x, X_TICKS);
        let y_text = |y: &f64| if self.is_logarithmic { power_of_ten(*y) } else { y_tick(y) };
        let x_text =
            |x: &f64| if self.categories.is_empty() { x_tick(x) } else { self.category(*x) };
        let mut mesh = chart.configure_mesh();
        mesh.bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .label_style(label_style())
            .axis_desc_style(label_style())
            .x_labels(X_TICKS.max(2 * self.categories.len()))
            .y_labels(Y_TICKS)
            .x_label_formatter(&x_text)
            .y_label_formatter(&y_text)
            .x_desc(x_label)
            .y_desc(&self.y_label);
        if !self.categories.is_empty() {
            mesh.disable_x_mesh();
        }
        mesh.draw().map_err(failed)?;
        self.series.iter().try_for_each(|series| series.draw(&mut chart, &scale))
    }

    /// Name of the category at this position.
    fn category(&self, x: f64) -> String {
        let index = x.round();
        let is_whole = (x - index).abs() < 1e-6 && index >= 0.0;
        let name = is_whole.then(|| self.categories.get(index as usize)).flatten();
        name.cloned().unwrap_or_default()
    }
}

/// Smallest and largest of the finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |extent, value| match extent {
        None => Some((value, value)),
        Some((low, high)) => Some((f64::min(low, value), f64::max(high, value))),
    })
}
