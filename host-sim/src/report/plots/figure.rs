//! A figure of panels over one time axis, and how it is drawn.

use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use thiserror::Error;

use super::super::history::HistoryRow;
use super::clip::clip;
use super::decimate::{self, Point};
use super::ticks::{Y_TICKS, tick_format};

/// A plot could not be drawn.
#[derive(Debug, Error)]
#[error("a plot could not be drawn: {0}")]
pub struct PlotError(String);

/// What a curve looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Line,
    /// For many noisy points, whose line covers an area.
    Thin,
    /// For what lies behind another line.
    Wide,
    Dashes,
}

/// A role rather than a hue. The hues are told apart by all kinds of colour vision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Colour {
    /// What the plot is about.
    Main,
    /// What it is compared with, when that is many points.
    Light,
    /// What is really so.
    Truth,
}

impl Colour {
    fn rgb(self) -> RGBColor {
        match self {
            Self::Main => RGBColor(0, 90, 160),
            Self::Light => RGBColor(240, 190, 90),
            Self::Truth => RGBColor(200, 60, 0),
        }
    }
}

const BAND: RGBColor = RGBColor(196, 218, 238);
const GRID: RGBColor = RGBColor(226, 226, 226);
const INK: RGBColor = RGBColor(40, 40, 40);

/// Length of a dash and of the gap after it, px.
const DASH: i32 = 5;

const FONT: &str = "sans-serif";
const TITLE_SIZE: i32 = 20;
const LABEL_SIZE: i32 = 13;
/// Height of the title and of the legend below it, px.
const HEAD: u32 = 64;

/// A value over time.
pub(super) struct Curve {
    name: &'static str,
    mark: Mark,
    colour: Colour,
    points: Vec<Point>,
}

impl Curve {
    /// The curve of `value`, which may leave rows out.
    pub(super) fn new(
        name: &'static str,
        mark: Mark,
        colour: Colour,
        history: &[HistoryRow],
        value: impl Fn(&HistoryRow) -> Option<f64>,
    ) -> Self {
        let points: Vec<Point> = (history.iter())
            .filter_map(|row| Some((row.time_s, value(row)?)))
            .filter(|point| point.1.is_finite())
            .collect();
        Self { name, mark, colour, points: decimate::curve(&points) }
    }
}

struct Band {
    name: &'static str,
    /// Time, lower and upper end.
    points: Vec<(f64, f64, f64)>,
}

/// One pair of axes.
pub(super) struct Panel {
    y_label: String,
    curves: Vec<Curve>,
    band: Option<Band>,
    settling: f64,
}

impl Panel {
    pub(super) fn new(y_label: String) -> Self {
        Self { y_label, curves: Vec::new(), band: None, settling: 0.0 }
    }

    pub(super) fn curve(mut self, curve: Curve) -> Self {
        self.curves.push(curve);
        self
    }

    /// Shades what lies between the two values.
    pub(super) fn band(
        mut self,
        name: &'static str,
        history: &[HistoryRow],
        ends: impl Fn(&HistoryRow) -> Option<(f64, f64)>,
    ) -> Self {
        let points: Vec<_> = (history.iter())
            .filter_map(|row| ends(row).map(|(lower, upper)| (row.time_s, lower, upper)))
            .filter(|(_, lower, upper)| lower.is_finite() && upper.is_finite())
            .collect();
        self.band = Some(Band { name, points: decimate::band(&points) });
        self
    }

    /// Lets the vertical scale fit only what comes after this part of the time, 0 to 1.
    pub(super) fn fit_after(mut self, settling: f64) -> Self {
        self.settling = settling;
        self
    }

    /// Times of all points.
    fn times(&self) -> impl Iterator<Item = f64> {
        self.curves.iter().flat_map(|curve| &curve.points).map(|point| point.0)
    }

    /// The vertical scale: all that is drawn from `start_s` on, and some air.
    fn y_range(&self, start_s: f64) -> Range<f64> {
        let curves = self.curves.iter().flat_map(|curve| curve.points.iter().copied());
        let band = self.band.iter().flat_map(|band| &band.points);
        let ends = band.flat_map(|&(time, lower, upper)| [(time, lower), (time, upper)]);
        let values = curves.chain(ends).filter(|point| point.0 >= start_s).map(|point| point.1);
        const AIR: f64 = 0.06;
        // A constant still needs some height, else the axis has no scale.
        const LEAST_RELATIVE: f64 = 1e-6;
        // Beyond this the axis itself overflows.
        const MOST: f64 = 1e100;
        let (low, high) = extent(values.filter(|value| value.abs() < MOST)).unwrap_or((-1.0, 1.0));
        let least = (low.abs().max(high.abs()) * LEAST_RELATIVE).max(1e-30);
        let air = ((high - low) * AIR).max(least);
        low - air..high + air
    }
}

/// A title, a legend, and panels.
pub(super) struct Figure {
    title: &'static str,
    panels: Vec<Panel>,
    rows: usize,
    columns: usize,
    size: (u32, u32),
}

impl Figure {
    /// Three panels, one above the other.
    pub(super) fn stacked(title: &'static str, panels: [Panel; 3]) -> Self {
        Self { title, panels: panels.into(), rows: 3, columns: 1, size: (960, 720) }
    }

    /// Two rows of three panels.
    pub(super) fn grid(title: &'static str, panels: [Panel; 6]) -> Self {
        Self { title, panels: panels.into(), rows: 2, columns: 3, size: (1260, 720) }
    }

    /// The figure as SVG.
    pub(super) fn draw(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, self.size).into_drawing_area();
            root.fill(&WHITE).map_err(failed)?;
            let (head, body) = root.split_vertically(HEAD);
            self.draw_head(&head)?;
            let times = self.panels.iter().flat_map(Panel::times);
            let (first, last) = extent(times).unwrap_or((0.0, 1.0));
            let x_range = first..if last > first { last } else { first + 1.0 };
            let areas = body.split_evenly((self.rows, self.columns));
            for (index, (panel, area)) in self.panels.iter().zip(&areas).enumerate() {
                let is_lowest = index / self.columns + 1 == self.rows;
                panel.draw(area, x_range.clone(), is_lowest)?;
            }
            root.present().map_err(failed)?;
        }
        Ok(svg)
    }

    fn draw_head(&self, area: &Area<'_>) -> Result<(), PlotError> {
        const LEFT: i32 = 24;
        const TITLE_Y: i32 = 24;
        const LEGEND_Y: i32 = 50;
        const SAMPLE: i32 = 28; // length of the piece of curve before its name
        const GAP: i32 = 8;
        const LETTER: i32 = 7; // about the width of one

        let font = FontDesc::new(FontFamily::Name(FONT), f64::from(TITLE_SIZE), FontStyle::Bold);
        let style = TextStyle::from(font).color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw_text(self.title, &style, (LEFT, TITLE_Y)).map_err(failed)?;

        // All panels have the same curves.
        let Some(panel) = self.panels.first() else { return Ok(()) };
        let style = label_style().pos(Pos::new(HPos::Left, VPos::Center));
        let mut x = LEFT;
        let mut entry = |name: &str, draw: &dyn Fn(i32) -> Result<(), PlotError>| {
            draw(x)?;
            area.draw_text(name, &style, (x + SAMPLE + GAP, LEGEND_Y)).map_err(failed)?;
            x += SAMPLE + GAP + LETTER * name.chars().count() as i32 + 3 * GAP;
            Ok::<_, PlotError>(())
        };
        for curve in &panel.curves {
            entry(curve.name, &|x| {
                let line = |from, to| {
                    area.draw(&PathElement::new([(from, LEGEND_Y), (to, LEGEND_Y)], curve.style()))
                };
                match curve.mark {
                    Mark::Line | Mark::Thin | Mark::Wide => line(x, x + SAMPLE),
                    Mark::Dashes => line(x, x + 10).and_then(|()| line(x + 16, x + 26)),
                }
                .map_err(failed)
            })?;
        }
        if let Some(band) = &panel.band {
            entry(band.name, &|x| {
                let corners = [(x, LEGEND_Y - 6), (x + SAMPLE, LEGEND_Y + 6)];
                area.draw(&Rectangle::new(corners, BAND.filled())).map_err(failed)
            })?;
        }
        Ok(())
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

impl Panel {
    fn draw(&self, area: &Area<'_>, x: Range<f64>, has_x_label: bool) -> Result<(), PlotError> {
        const Y_LABELS: i32 = 76;
        const X_LABELS: i32 = 44;

        let y = self.y_range(x.start + self.settling * (x.end - x.start));
        let mut chart = ChartBuilder::on(area)
            .margin(6)
            .margin_right(18)
            .set_label_area_size(LabelAreaPosition::Left, Y_LABELS)
            .set_label_area_size(LabelAreaPosition::Bottom, X_LABELS)
            .build_cartesian_2d(x.clone(), y.clone())
            .map_err(failed)?;
        let tick = tick_format(&y);
        chart
            .configure_mesh()
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .label_style(label_style())
            .axis_desc_style(label_style())
            .x_labels(7)
            .y_labels(Y_TICKS)
            .x_label_formatter(&|time| format!("{}", (time * 1e6).round() / 1e6))
            .y_label_formatter(&tick)
            .x_desc(if has_x_label { "time, s" } else { "" })
            .y_desc(&self.y_label)
            .draw()
            .map_err(failed)?;

        if let Some(band) = &self.band {
            let clamp = |value: f64| value.clamp(y.start, y.end);
            let upper = band.points.iter().map(|&(t, _, upper)| (t, clamp(upper)));
            let lower = band.points.iter().rev().map(|&(t, lower, _)| (t, clamp(lower)));
            let outline: Vec<Point> = upper.chain(lower).collect();
            let polygon = Polygon::new(outline, BAND.filled());
            chart.draw_series([polygon]).map_err(failed)?;
        }
        for curve in &self.curves {
            let style = curve.style();
            for piece in clip(&curve.points, &y) {
                match curve.mark {
                    Mark::Line | Mark::Thin | Mark::Wide => {
                        chart.draw_series(LineSeries::new(piece, style))
                    }
                    Mark::Dashes => {
                        chart.draw_series(DashedLineSeries::new(piece, DASH, DASH, style))
                    }
                }
                .map_err(failed)?;
            }
        }
        Ok(())
    }
}

impl Curve {
    fn style(&self) -> ShapeStyle {
        let width = match self.mark {
            Mark::Line | Mark::Dashes => 2,
            Mark::Thin => 1,
            Mark::Wide => 3,
        };
        self.colour.rgb().stroke_width(width)
    }
}

/// The smallest and the largest of some finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |extent, value| match extent {
        None => Some((value, value)),
        Some((low, high)) => Some((f64::min(low, value), f64::max(high, value))),
    })
}

fn label_style() -> TextStyle<'static> {
    TextStyle::from((FONT, LABEL_SIZE)).color(&INK)
}

/// Drawing into a string can hardly fail, and the backend's error types are of no use to anyone.
fn failed(error: impl std::fmt::Display) -> PlotError {
    PlotError(error.to_string())
}
