//! A title, a legend, and panels.

use plotters::prelude::*;
use thiserror::Error;

use super::panel::Panel;
use super::series::{DIAMOND, Series, Shape};
use super::style::{AREA_OPACITY, BAR_OPACITY, DOT, LETTER, Mark, label_style, left, title_style};

/// A plot could not be drawn.
#[derive(Debug, Error)]
#[error("a plot could not be drawn: {0}")]
pub struct PlotError(String);

/// Drawing into a string can hardly fail, and the backend's error types are of no use to anyone.
pub(super) fn failed(error: impl std::fmt::Display) -> PlotError {
    PlotError(error.to_string())
}

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// Panels on one sheet.
#[derive(Clone, Debug)]
pub struct Figure {
    title: String,
    x_label: String,
    panels: Vec<Panel>,
    columns: usize,
    size: (u32, u32),
}

const LEFT: i32 = 24;
const TITLE_Y: i32 = 24;
const LEGEND_Y: i32 = 50;
const LEGEND_LINE: i32 = 22;
/// Length of the piece of curve before a name in the legend, px.
const SAMPLE: i32 = 28;
const GAP: i32 = 8;

impl Figure {
    /// Panels one above the other.
    pub fn stacked(title: impl Into<String>, x_label: &str, panels: Vec<Panel>) -> Self {
        const HEIGHT: u32 = 220;
        let height = HEIGHT * (panels.len().max(2) as u32) + 64;
        Self::new(title, x_label, panels, 1, (960, height))
    }

    /// Rows of so many panels.
    pub fn grid(
        title: impl Into<String>,
        x_label: &str,
        columns: usize,
        panels: Vec<Panel>,
    ) -> Self {
        const HEIGHT: u32 = 320;
        let rows = panels.len().div_ceil(columns.max(1)).max(1);
        let height = HEIGHT * (rows as u32) + 64;
        Self::new(title, x_label, panels, columns.max(1), (1260, height))
    }

    fn new(
        title: impl Into<String>,
        x_label: &str,
        panels: Vec<Panel>,
        columns: usize,
        size: (u32, u32),
    ) -> Self {
        Self { title: title.into(), x_label: x_label.to_owned(), panels, columns, size }
    }

    /// The figure as SVG.
    pub fn draw(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, self.size).into_drawing_area();
            root.fill(&WHITE).map_err(failed)?;
            let legend = self.legend();
            let lines = legend.last().map_or(0, |(_, place)| (place.1 - LEGEND_Y) / LEGEND_LINE);
            let (head, body) = root.split_vertically(LEGEND_Y + lines * LEGEND_LINE + 14);
            head.draw_text(&self.title, &title_style(), (LEFT, TITLE_Y)).map_err(failed)?;
            legend.iter().try_for_each(|(series, place)| series.draw_entry(&head, *place))?;
            let rows = self.panels.len().div_ceil(self.columns).max(1);
            let areas = body.split_evenly((rows, self.columns));
            for (index, (panel, area)) in self.panels.iter().zip(&areas).enumerate() {
                let is_lowest = index + self.columns >= self.panels.len();
                panel.draw(area, if is_lowest { &self.x_label } else { "" })?;
            }
            root.present().map_err(failed)?;
        }
        Ok(svg)
    }

    /// What the panels show, each name once, and where it goes.
    fn legend(&self) -> Vec<(&Series, (i32, i32))> {
        let mut entries: Vec<(&Series, (i32, i32))> = Vec::new();
        let (mut x, mut y) = (LEFT, LEGEND_Y);
        for series in self.panels.iter().flat_map(|panel| &panel.series) {
            let is_known = entries.iter().any(|(known, _)| known.name == series.name);
            if is_known || series.extremes().is_empty() {
                continue;
            }
            let width = SAMPLE + GAP + LETTER * series.name.chars().count() as i32 + 3 * GAP;
            if x > LEFT && x + width > self.size.0 as i32 {
                (x, y) = (LEFT, y + LEGEND_LINE);
            }
            entries.push((series, (x, y)));
            x += width;
        }
        entries
    }
}

impl Series {
    /// A sample and the name, at this place.
    fn draw_entry(&self, area: &Area<'_>, (x, y): (i32, i32)) -> Result<(), PlotError> {
        let colour = self.colour.rgb();
        let line = |from: i32, to: i32, width: u32| {
            area.draw(&PathElement::new([(from, y), (to, y)], colour.stroke_width(width)))
        };
        let block = |opacity: f64| {
            let style = colour.mix(opacity).filled();
            area.draw(&Rectangle::new([(x, y - 6), (x + SAMPLE, y + 6)], style))
        };
        let middle = x + SAMPLE / 2;
        match &self.shape {
            Shape::Curve(Mark::Dashes, _) => {
                line(x, x + 10, 2).and_then(|()| line(x + 16, x + 26, 2))
            }
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
        area.draw_text(&self.name, &style, (x + SAMPLE + GAP, y)).map_err(failed)
    }
}
