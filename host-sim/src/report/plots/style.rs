//! Colours and line marks, by their role. The page maps them to the palette of Okabe and Ito (2008), whose hues are
//! distinct for all kinds of colour vision.

use serde::Serialize;

/// Role of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
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
    /// Fourth subject.
    Fourth,
}

impl Colour {
    /// All, for subjects of equal rank.
    pub const ALL: [Self; 6] =
        [Self::Main, Self::Other, Self::Third, Self::Light, Self::Fourth, Self::Truth];
}

/// Line of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
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
