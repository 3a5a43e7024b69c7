//! Series of a panel: curve, band, bars, dots, diamonds.

use serde::Serialize;

use super::decimate::{self, Point};
use super::style::{Colour, Mark};

/// Data with a name, a colour and a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub(super) name: String,
    colour: Colour,
    shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
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

/// Columns of a table: name and cells, position and value.
pub(super) type Column = (String, Vec<Point>);

impl Series {
    /// A curve through the finite points.
    pub fn curve(
        name: &str,
        mark: Mark,
        colour: Colour,
        points: impl IntoIterator<Item = Point>,
    ) -> Self {
        let points = points.into_iter().filter(|p| p.1.is_finite());
        Self::new(name, colour, Shape::Curve(mark, points.collect()))
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
        let points = points.into_iter().filter(is_finite);
        Self::new(name, colour, Shape::Band(points.collect()))
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

    /// True without any point.
    pub(super) fn is_empty(&self) -> bool {
        self.extremes().is_empty()
    }

    /// True for bars, which stand on the axis.
    pub(super) fn is_bars(&self) -> bool {
        matches!(self.shape, Shape::Bars(_))
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

    /// The series as columns of a table: a band and dots with whiskers have a lower and an upper one.
    pub(super) fn columns(&self) -> Vec<Column> {
        let name = &self.name;
        let pair = |points: &mut dyn Iterator<Item = (f64, f64, f64)>| {
            let (low, high): (Vec<_>, Vec<_>) =
                points.map(|(x, low, high)| ((x, low), (x, high))).unzip();
            vec![(format!("{name}, low"), low), (format!("{name}, high"), high)]
        };
        match &self.shape {
            Shape::Curve(_, points) | Shape::Diamonds(points) => {
                vec![(name.clone(), points.clone())]
            }
            Shape::Band(points) => pair(&mut points.iter().copied()),
            Shape::Bars(bars) => {
                let middle = |&(from, to, height): &(f64, f64, f64)| (0.5 * (from + to), height);
                vec![(name.clone(), bars.iter().map(middle).collect())]
            }
            Shape::Dots(dots) => {
                let mut ends = dots.iter().map(|dot| {
                    let Dot { x, value, reach } = *dot;
                    (x, value - reach, value + reach)
                });
                let mut columns = pair(&mut ends);
                columns.push((name.clone(), dots.iter().map(|dot| (dot.x, dot.value)).collect()));
                columns
            }
        }
    }

    /// The series as the page draws it: decimated and rounded.
    pub(super) fn drawn(&self) -> Drawn<'_> {
        let (kind, points) = match &self.shape {
            Shape::Curve(mark, points) => {
                let kind = match mark {
                    Mark::Line => "line",
                    Mark::Thin => "thin",
                    Mark::Wide => "wide",
                    Mark::Dashes => "dashes",
                };
                let point = |(x, y): Point| [x, y, y, y];
                let pieces = decimate::pieces(points, |point| point.0).into_iter();
                let drawn = pieces.map(|piece| decimate::curve(piece).into_iter().map(point));
                (kind, joined(drawn.map(Iterator::collect)))
            }
            Shape::Diamonds(points) => {
                ("diamonds", points.iter().map(|&(x, y)| [x, y, y, y]).collect())
            }
            Shape::Band(points) => {
                let point = |(x, low, high): (f64, f64, f64)| [x, high, low, high];
                let pieces = decimate::pieces(points, |point| point.0).into_iter();
                let drawn = pieces.map(|piece| decimate::band(piece).into_iter().map(point));
                ("band", joined(drawn.map(Iterator::collect)))
            }
            Shape::Bars(bars) => {
                let bar =
                    |&(from, to, height): &(f64, f64, f64)| [(from + to) / 2.0, height, from, to];
                ("bars", bars.iter().map(bar).collect())
            }
            Shape::Dots(dots) => {
                let dot =
                    |dot: &Dot| [dot.x, dot.value, dot.value - dot.reach, dot.value + dot.reach];
                ("dots", dots.iter().map(dot).collect())
            }
        };
        let column = |i: usize| points.iter().map(|point| rounded(point[i])).collect();
        let has_ends = matches!(kind, "band" | "bars" | "dots");
        let end = |i: usize| if has_ends { column(i) } else { Vec::new() };
        let (x, y, low, high) = (column(0), column(1), end(2), end(3));
        Drawn { name: &self.name, colour: self.colour, kind, x, y, low, high }
    }
}

/// Pieces with a point without value between each two, at which the page interrupts the line.
fn joined(pieces: impl Iterator<Item = Vec<[f64; 4]>>) -> Vec<[f64; 4]> {
    pieces.fold(Vec::new(), |mut all, piece| {
        if let (Some(last), Some(next)) = (all.last(), piece.first()) {
            let middle = 0.5 * (last[0] + next[0]);
            all.push([middle, f64::NAN, f64::NAN, f64::NAN]);
        }
        all.extend(piece);
        all
    })
}

/// A series as the page draws it; a value that is none is null.
#[derive(Serialize)]
pub(super) struct Drawn<'a> {
    name: &'a str,
    colour: Colour,
    kind: &'static str,
    x: Vec<f64>,
    y: Vec<f64>,
    /// Lower ends of a band and of whiskers, left edges of bars.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    low: Vec<f64>,
    /// Upper ends, right edges.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    high: Vec<f64>,
}

/// Eight significant digits: more than a zoomed plot resolves, half the text of all digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.7e}").parse().unwrap_or(value)
}
