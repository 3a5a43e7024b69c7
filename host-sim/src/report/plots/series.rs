//! What is drawn in a panel: curves, bands, bars, dots.

use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::clip::clip;
use super::decimate::{self, Point};
use super::figure::{PlotError, failed};
use super::panel::Scale;
use super::style::{AREA_OPACITY, BAR_OPACITY, Colour, DASH, DOT, Mark};

/// Named data of one look.
#[derive(Clone, Debug)]
pub struct Series {
    pub(super) name: String,
    pub(super) colour: Colour,
    pub(super) shape: Shape,
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    Curve(Mark, Vec<Point>),
    /// Horizontal value, lower and upper end.
    Band(Vec<(f64, f64, f64)>),
    /// From, to, height.
    Bars(Vec<(f64, f64, f64)>),
    Dots(Vec<Dot>),
    Diamonds(Vec<Point>),
}

/// A value with a reach above and below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Where along the horizontal axis.
    pub x: f64,
    /// The value.
    pub value: f64,
    /// How far its whisker goes to either side.
    pub reach: f64,
}

pub(super) type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Series {
    /// A curve through the points that are finite.
    pub fn curve(
        name: &str,
        mark: Mark,
        colour: Colour,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points: Vec<Point> = points.into_iter().filter(|p| p.1.is_finite()).collect();
        Self::new(name, colour, Shape::Curve(mark, decimate::curve(&points)))
    }

    /// A curve at one height, or several, as a step function drawn at its corners.
    pub fn level(name: &str, mark: Mark, colour: Colour, x: (f64, f64), level: f64) -> Self {
        Self::curve(name, mark, colour, [(x.0, level), (x.1, level)])
    }

    /// Shades what lies between two values: horizontal value, lower and upper end.
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

    /// Bars that stand on zero: from, to, height.
    pub fn bars(name: &str, colour: Colour, bars: Vec<(f64, f64, f64)>) -> Self {
        Self::new(name, colour, Shape::Bars(bars))
    }

    /// Values with whiskers.
    pub fn dots(name: &str, colour: Colour, dots: impl IntoIterator<Item = Dot>) -> Self {
        let dots = dots.into_iter().filter(|dot| dot.value.is_finite() && dot.reach.is_finite());
        Self::new(name, colour, Shape::Dots(dots.collect()))
    }

    /// Values, as hollow diamonds.
    pub fn diamonds(name: &str, colour: Colour, points: impl IntoIterator<Item = Point>) -> Self {
        let points = points.into_iter().filter(|point| point.1.is_finite());
        Self::new(name, colour, Shape::Diamonds(points.collect()))
    }

    fn new(name: &str, colour: Colour, shape: Shape) -> Self {
        Self { name: name.to_owned(), colour, shape }
    }

    /// All that is to fit into the panel.
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

    pub(super) fn draw(&self, chart: &mut Chart<'_, '_>, scale: &Scale) -> Result<(), PlotError> {
        let colour = self.colour.rgb();
        let line = colour.stroke_width(2);
        let inside = |y: f64| scale.place(y).clamp(scale.range.start, scale.range.end);
        match &self.shape {
            Shape::Curve(mark, points) => {
                let points: Vec<Point> = points.iter().map(|p| (p.0, scale.place(p.1))).collect();
                let style = colour.stroke_width(mark.width());
                for piece in clip(&points, &scale.range) {
                    match mark {
                        Mark::Dashes => {
                            chart.draw_series(DashedLineSeries::new(piece, DASH, DASH, style))
                        }
                        Mark::Line | Mark::Thin | Mark::Wide => {
                            chart.draw_series(LineSeries::new(piece, style))
                        }
                    }
                    .map_err(failed)?;
                }
            }
            Shape::Band(points) => {
                let upper = points.iter().map(|&(x, _, upper)| (x, inside(upper)));
                let lower = points.iter().rev().map(|&(x, lower, _)| (x, inside(lower)));
                let outline: Vec<Point> = upper.chain(lower).collect();
                let area = Polygon::new(outline, colour.mix(AREA_OPACITY).filled());
                chart.draw_series([area]).map_err(failed)?;
            }
            Shape::Bars(bars) => {
                let style = colour.mix(BAR_OPACITY).filled();
                let bar = |&(from, to, height): &(f64, f64, f64)| {
                    Rectangle::new([(from, inside(0.0)), (to, inside(height))], style)
                };
                chart.draw_series(bars.iter().map(bar)).map_err(failed)?;
            }
            Shape::Dots(dots) => {
                let whisker = |dot: &Dot| {
                    let ends = [dot.value - dot.reach, dot.value + dot.reach];
                    PathElement::new(ends.map(|y| (dot.x, inside(y))), line)
                };
                chart.draw_series(dots.iter().map(whisker)).map_err(failed)?;
                let dot = |dot: &Dot| Circle::new((dot.x, inside(dot.value)), DOT, colour.filled());
                chart.draw_series(dots.iter().map(dot)).map_err(failed)?;
            }
            Shape::Diamonds(points) => {
                let diamond = |point: &Point| {
                    EmptyElement::at((point.0, inside(point.1)))
                        + PathElement::new(DIAMOND.to_vec(), line)
                };
                chart.draw_series(points.iter().map(diamond)).map_err(failed)?;
            }
        }
        Ok(())
    }
}

/// Outline of a diamond about its middle, px.
pub(super) const DIAMOND: [(i32, i32); 5] = [(0, -7), (7, 0), (0, 7), (-7, 0), (0, -7)];
