//! Series of a panel: curve, band, bars, dots, diamonds.

use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::canvas::{PlotError, failed};
use super::clip::clip;
use super::decimate::{self, Point};
use super::scale::Scale;
use super::style::{AREA_OPACITY, BAR_OPACITY, Colour, DASH, DOT, Mark};

/// Data with a name, a colour and a shape.
#[derive(Clone, Debug)]
pub struct Series {
    pub(super) name: String,
    pub(super) colour: Colour,
    pub(super) shape: Shape,
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    Curve(Mark, Vec<Point>),
    /// Position, lower and upper end.
    Band(Vec<(f64, f64, f64)>),
    /// Lower edge, upper edge, height.
    Bars(Vec<(f64, f64, f64)>),
    Dots(Vec<Dot>),
    Diamonds(Vec<Point>),
}

/// A value with a symmetric whisker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Position on the horizontal axis.
    pub x: f64,
    /// Value.
    pub value: f64,
    /// Half the length of the whisker.
    pub reach: f64,
}

pub(super) type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Series {
    /// A curve through the finite points.
    pub fn curve(
        name: &str,
        mark: Mark,
        colour: Colour,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points: Vec<Point> = points.into_iter().filter(|p| p.1.is_finite()).collect();
        Self::new(name, colour, Shape::Curve(mark, decimate::curve(&points)))
    }

    /// A horizontal line at `level`, from `x.0` to `x.1`.
    pub fn level(name: &str, mark: Mark, colour: Colour, x: (f64, f64), level: f64) -> Self {
        Self::curve(name, mark, colour, [(x.0, level), (x.1, level)])
    }

    /// A shaded area between two values. Each point is position, lower and upper end.
    pub fn band(
        name: &str,
        colour: Colour,
        points: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> Self {
        let is_finite =
            |(_, lower, upper): &(f64, f64, f64)| lower.is_finite() && upper.is_finite();
        let points: Vec<_> = points.into_iter().filter(is_finite).collect();
        Self::new(name, colour, Shape::Band(decimate::band(&points)))
    }

    /// Bars on the zero line: lower edge, upper edge, height.
    pub fn bars(name: &str, colour: Colour, bars: Vec<(f64, f64, f64)>) -> Self {
        Self::new(name, colour, Shape::Bars(bars))
    }

    /// Values with whiskers.
    pub fn dots(name: &str, colour: Colour, dots: impl IntoIterator<Item = Dot>) -> Self {
        let dots = dots.into_iter().filter(|dot| dot.value.is_finite() && dot.reach.is_finite());
        Self::new(name, colour, Shape::Dots(dots.collect()))
    }

    /// Values as hollow diamonds.
    pub fn diamonds(name: &str, colour: Colour, points: impl IntoIterator<Item = Point>) -> Self {
        let points = points.into_iter().filter(|point| point.1.is_finite());
        Self::new(name, colour, Shape::Diamonds(points.collect()))
    }

    fn new(name: &str, colour: Colour, shape: Shape) -> Self {
        Self { name: name.to_owned(), colour, shape }
    }

    /// Points that the axes have to contain.
    pub(super) fn extremes(&self) -> Vec<Point> {
        let both = |(x, low, high): (f64, f64, f64)| [(x, low), (x, high)];
        match &self.shape {
            Shape::Curve(_, points) | Shape::Diamonds(points) => points.clone(),
            Shape::Band(points) => points.iter().copied().flat_map(both).collect(),
            Shape::Bars(bars) => {
                bars.iter().flat_map(|&(from, to, height)| [(from, 0.0), (to, height)]).collect()
            }
            Shape::Dots(dots) => (dots.iter())
                .flat_map(|dot| both((dot.x, dot.value - dot.reach, dot.value + dot.reach)))
                .collect(),
        }
    }

    /// Draws the series in a panel of this vertical scale.
    pub(super) fn draw(&self, chart: &mut Chart<'_, '_>, scale: &Scale) -> Result<(), PlotError> {
        match &self.shape {
            Shape::Curve(mark, points) => draw_curve(chart, scale, self.colour, *mark, points),
            Shape::Band(points) => draw_band(chart, scale, self.colour, points),
            Shape::Bars(bars) => draw_bars(chart, scale, self.colour, bars),
            Shape::Dots(dots) => draw_dots(chart, scale, self.colour, dots),
            Shape::Diamonds(points) => draw_diamonds(chart, scale, self.colour, points),
        }
    }
}

fn draw_curve(
    chart: &mut Chart<'_, '_>,
    scale: &Scale,
    colour: Colour,
    mark: Mark,
    points: &[Point],
) -> Result<(), PlotError> {
    let points: Vec<Point> = points.iter().map(|p| (p.0, scale.height(p.1))).collect();
    let style = colour.rgb().stroke_width(mark.width());
    for piece in clip(&points, &scale.range) {
        match mark {
            Mark::Dashes => chart.draw_series(DashedLineSeries::new(piece, DASH, DASH, style)),
            Mark::Line | Mark::Thin | Mark::Wide => {
                chart.draw_series(LineSeries::new(piece, style))
            }
        }
        .map_err(failed)?;
    }
    Ok(())
}

fn draw_band(
    chart: &mut Chart<'_, '_>,
    scale: &Scale,
    colour: Colour,
    points: &[(f64, f64, f64)],
) -> Result<(), PlotError> {
    let upper = points.iter().map(|&(x, _, upper)| (x, scale.height_inside(upper)));
    let lower = points.iter().rev().map(|&(x, lower, _)| (x, scale.height_inside(lower)));
    let outline: Vec<Point> = upper.chain(lower).collect();
    let area = Polygon::new(outline, colour.rgb().mix(AREA_OPACITY).filled());
    chart.draw_series([area]).map(|_| ()).map_err(failed)
}

fn draw_bars(
    chart: &mut Chart<'_, '_>,
    scale: &Scale,
    colour: Colour,
    bars: &[(f64, f64, f64)],
) -> Result<(), PlotError> {
    let style = colour.rgb().mix(BAR_OPACITY).filled();
    let zero = scale.height_inside(0.0);
    let bar = |&(from, to, height): &(f64, f64, f64)| {
        Rectangle::new([(from, zero), (to, scale.height_inside(height))], style)
    };
    chart.draw_series(bars.iter().map(bar)).map(|_| ()).map_err(failed)
}

fn draw_dots(
    chart: &mut Chart<'_, '_>,
    scale: &Scale,
    colour: Colour,
    dots: &[Dot],
) -> Result<(), PlotError> {
    let line = colour.rgb().stroke_width(LINE);
    let whisker = |dot: &Dot| {
        let ends = [dot.value - dot.reach, dot.value + dot.reach];
        PathElement::new(ends.map(|y| (dot.x, scale.height_inside(y))), line)
    };
    chart.draw_series(dots.iter().map(whisker)).map_err(failed)?;
    let filled = colour.rgb().filled();
    let dot = |dot: &Dot| Circle::new((dot.x, scale.height_inside(dot.value)), DOT, filled);
    chart.draw_series(dots.iter().map(dot)).map(|_| ()).map_err(failed)
}

fn draw_diamonds(
    chart: &mut Chart<'_, '_>,
    scale: &Scale,
    colour: Colour,
    points: &[Point],
) -> Result<(), PlotError> {
    let line = colour.rgb().stroke_width(LINE);
    let diamond = |point: &Point| {
        EmptyElement::at((point.0, scale.height_inside(point.1)))
            + PathElement::new(DIAMOND.to_vec(), line)
    };
    chart.draw_series(points.iter().map(diamond)).map(|_| ()).map_err(failed)
}

/// Width of whiskers and outlines, px.
const LINE: u32 = 2;
/// Outline of a diamond about its centre, px.
pub(super) const DIAMOND: [(i32, i32); 5] = [(0, -7), (7, 0), (0, 7), (-7, 0), (0, -7)];
