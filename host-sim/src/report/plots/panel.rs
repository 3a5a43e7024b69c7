//! One pair of axes.

use std::ops::Range;

use plotters::prelude::*;

use super::decimate::Point;
use super::figure::{Area, PlotError, failed};
use super::series::{Series, Shape};
use super::style::{GRID, INK, label_style};
use super::ticks::{X_TICKS, Y_TICKS, power_of_ten, tick_format};

/// Values, their axes, and what they are called.
#[derive(Clone, Debug)]
pub struct Panel {
    y_label: String,
    pub(super) series: Vec<Series>,
    settling: f64,
    span: Option<(f64, f64)>,
    categories: Vec<String>,
    is_logarithmic: bool,
}

/// How values become heights.
pub(super) struct Scale {
    /// From the lower to the upper end, powers of ten if logarithmic.
    pub(super) range: Range<f64>,
    is_logarithmic: bool,
}

impl Scale {
    /// The height of a value.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.is_logarithmic {
            // What has no logarithm is below any scale.
            true => value.max(f64::MIN_POSITIVE).log10(),
            false => value,
        }
    }
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

    /// Adds what is drawn over the rest.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Lets the vertical scale fit only what comes after this part of the horizontal one, 0 to 1.
    pub fn fit_after(mut self, settling: f64) -> Self {
        self.settling = settling;
        self
    }

    /// Sets the lower and the upper end of the vertical scale.
    pub fn span(mut self, low: f64, high: f64) -> Self {
        self.span = Some((low, high));
        self
    }

    /// Names the whole numbers from zero along the horizontal axis.
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

    /// The vertical scale: all that is drawn after settling, and some air.
    fn scale(&self, x: &Range<f64>) -> Scale {
        const AIR: f64 = 0.06;
        // A constant still needs some height, else the axis has no scale.
        const LEAST_RELATIVE: f64 = 1e-6;
        // Beyond this the axis itself overflows.
        const MOST: f64 = 1e100;

        if let Some((low, high)) = self.span {
            return Scale { range: low..high, is_logarithmic: false };
        }
        let start = x.start + self.settling * (x.end - x.start);
        let points = self.series.iter().flat_map(Series::extremes);
        let is_logarithmic = self.is_logarithmic;
        let is_fit = |point: &Point| {
            point.0 >= start && point.1.abs() < MOST && (!is_logarithmic || point.1 > 0.0)
        };
        let height = |point: Point| if is_logarithmic { point.1.log10() } else { point.1 };
        let (low, high) = extent(points.filter(is_fit).map(height)).unwrap_or((-1.0, 1.0));
        let least = (low.abs().max(high.abs()) * LEAST_RELATIVE).max(1e-30);
        let air = ((high - low) * AIR).max(least);
        // Bars stand on the axis.
        let stands =
            self.series.iter().any(|series| matches!(series.shape, Shape::Bars(_))) && low == 0.0;
        Scale { range: if stands { 0.0 } else { low - air }..high + air, is_logarithmic }
    }

    pub(super) fn draw(&self, area: &Area<'_>, x_label: &str) -> Result<(), PlotError> {
        const Y_LABELS: i32 = 80;
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

    /// The name at this place, if it has one.
    fn category(&self, x: f64) -> String {
        let index = x.round();
        let is_whole = (x - index).abs() < 1e-6 && index >= 0.0;
        let name = is_whole.then(|| self.categories.get(index as usize)).flatten();
        name.cloned().unwrap_or_default()
    }
}

/// The smallest and the largest of some finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |extent, value| match extent {
        None => Some((value, value)),
        Some((low, high)) => Some((f64::min(low, value), f64::max(high, value))),
    })
}
