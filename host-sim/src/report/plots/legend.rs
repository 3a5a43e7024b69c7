//! Legend of a figure: a sample of each series and its name.

use plotters::prelude::*;

use super::canvas::{Area, PlotError, failed};
use super::series::{DIAMOND, Series, Shape};
use super::style::{AREA_OPACITY, BAR_OPACITY, DOT, LETTER, Mark, label_style, left};

/// Left margin, px.
pub(super) const LEFT: i32 = 24;
/// Height of the first line, px.
const TOP: i32 = 50;
/// Distance between two lines, px.
const LINE: i32 = 22;
/// Space below the last line, px.
const BOTTOM: i32 = 14;
/// Length of the sample before a name, px.
const SAMPLE: i32 = 28;
/// Gap between sample and name, px.
const GAP: i32 = 8;

/// Entries with their positions, px.
pub(super) struct Legend<'a> {
    entries: Vec<(&'a Series, (i32, i32))>,
}

impl<'a> Legend<'a> {
    /// One entry per name, in lines of at most `width` pixels. Series without points have none.
    pub fn new(series: impl Iterator<Item = &'a Series>, width: u32) -> Self {
        let mut entries: Vec<(&Series, (i32, i32))> = Vec::new();
        let (mut x, mut y) = (LEFT, TOP);
        for series in series {
            let is_present = entries.iter().any(|(other, _)| other.name == series.name);
            if is_present || series.extremes().is_empty() {
                continue;
            }
            let length = SAMPLE + GAP + LETTER * series.name.chars().count() as i32 + 3 * GAP;
            if x > LEFT && x + length > width as i32 {
                (x, y) = (LEFT, y + LINE);
            }
            entries.push((series, (x, y)));
            x += length;
        }
        Self { entries }
    }

    /// Height of title and legend, px.
    pub fn height(&self) -> i32 {
        let lines = self.entries.last().map_or(0, |(_, place)| (place.1 - TOP) / LINE);
        TOP + lines * LINE + BOTTOM
    }

    /// Draws all entries.
    pub fn draw(&self, area: &Area<'_>) -> Result<(), PlotError> {
        self.entries.iter().try_for_each(|(series, place)| draw_entry(series, area, *place))
    }
}

fn draw_entry(series: &Series, area: &Area<'_>, (x, y): (i32, i32)) -> Result<(), PlotError> {
    let colour = series.colour.rgb();
    let line = |from: i32, to: i32, width: u32| {
        area.draw(&PathElement::new([(from, y), (to, y)], colour.stroke_width(width)))
    };
    let block = |opacity: f64| {
        let style = colour.mix(opacity).filled();
        area.draw(&Rectangle::new([(x, y - 6), (x + SAMPLE, y + 6)], style))
    };
    let middle = x + SAMPLE / 2;
    match &series.shape {
        Shape::Curve(Mark::Dashes, _) => line(x, x + 10, 2).and_then(|()| line(x + 16, x + 26, 2)),
        Shape::Curve(mark, _) => line(x, x + SAMPLE, mark.width()),
        Shape::Band(_) => block(AREA_OPACITY),
        Shape::Bars(_) => block(BAR_OPACITY),
        Shape::Dots(_) => area.draw(&Circle::new((middle, y), DOT, colour.filled())),
        Shape::Diamonds(_) => {
            let outline = DIAMOND.map(|(dx, dy)| (middle + dx, y + dy));
            area.draw(&PathElement::new(outline.to_vec(), colour.stroke_width(2)))
        }
    }
    .map_err(failed)?;
    let style = label_style().pos(left());
    area.draw_text(&series.name, &style, (x + SAMPLE + GAP, y)).map_err(failed)
}
