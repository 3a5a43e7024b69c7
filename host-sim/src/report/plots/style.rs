//! What lines and marks look like, and what they mean.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A role rather than a hue. The hues are told apart by all kinds of colour vision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// What the plot is about.
    Main,
    /// What it is compared with, when that is many points.
    Light,
    /// What is really so, and what a paper printed.
    Truth,
    /// A second thing of the kind that the plot is about.
    Other,
    /// A third.
    Third,
}

impl Colour {
    pub(super) fn rgb(self) -> RGBColor {
        match self {
            Self::Main => RGBColor(0, 90, 160),
            Self::Light => RGBColor(240, 190, 90),
            Self::Truth => RGBColor(200, 60, 0),
            Self::Other => RGBColor(0, 145, 110),
            Self::Third => RGBColor(170, 80, 140),
        }
    }
}

/// What a curve looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A plain line.
    Line,
    /// For many noisy points, whose line covers an area.
    Thin,
    /// For what lies behind another line.
    Wide,
    /// For what stays the same, or bounds the rest.
    Dashes,
}

impl Mark {
    pub(super) fn width(self) -> u32 {
        match self {
            Self::Line | Self::Dashes => 2,
            Self::Thin => 1,
            Self::Wide => 3,
        }
    }
}

/// How much of its colour an area has: what lies behind still shows.
pub(super) const AREA_OPACITY: f64 = 0.22;
pub(super) const BAR_OPACITY: f64 = 0.55;
pub(super) const GRID: RGBColor = RGBColor(226, 226, 226);
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);

/// Length of a dash and of the gap after it, px.
pub(super) const DASH: i32 = 5;
/// Radius of a dot, px.
pub(super) const DOT: i32 = 4;

const FONT: &str = "sans-serif";
const TITLE_SIZE: i32 = 19;
const LABEL_SIZE: i32 = 13;
/// About the width of a letter of a label, px.
pub(super) const LETTER: i32 = 7;

pub(super) fn title_style() -> TextStyle<'static> {
    let font = FontDesc::new(FontFamily::Name(FONT), f64::from(TITLE_SIZE), FontStyle::Bold);
    TextStyle::from(font).color(&INK).pos(left())
}

pub(super) fn label_style() -> TextStyle<'static> {
    TextStyle::from((FONT, LABEL_SIZE)).color(&INK)
}

pub(super) fn left() -> Pos {
    Pos::new(HPos::Left, VPos::Center)
}
