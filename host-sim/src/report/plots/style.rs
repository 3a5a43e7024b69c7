//! Colours, line marks, fonts.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Role of a series. The hues are distinct for all kinds of colour vision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Subject of the plot.
    Main,
    /// Comparison with many points.
    Light,
    /// Truth, or published value.
    Truth,
    /// Second subject.
    Other,
    /// Third subject.
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

/// Line of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Plain line.
    Line,
    /// Thin line, for dense noisy points.
    Thin,
    /// Wide line, for a curve behind another.
    Wide,
    /// Dashed line, for constants and bounds.
    Dashes,
}

impl Mark {
    /// Line width, px.
    pub(super) fn width(self) -> u32 {
        match self {
            Self::Line | Self::Dashes => 2,
            Self::Thin => 1,
            Self::Wide => 3,
        }
    }
}

/// Opacity of a band. Series behind it stay visible.
pub(super) const AREA_OPACITY: f64 = 0.22;
/// Opacity of a bar.
pub(super) const BAR_OPACITY: f64 = 0.55;
pub(super) const GRID: RGBColor = RGBColor(226, 226, 226);
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);

/// Length of a dash and of a gap, px.
pub(super) const DASH: i32 = 5;
/// Radius of a dot, px.
pub(super) const DOT: i32 = 4;

const FONT: &str = "sans-serif";
const TITLE_SIZE: i32 = 19;
const LABEL_SIZE: i32 = 13;
/// Approximate width of a letter of a label, px.
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
