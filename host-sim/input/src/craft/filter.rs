//! `[filter]`: process noise of the filters, in craft files and scenarios.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use crate::error::InputError;
use crate::key::{ANY, FLAG, Key, NOT_NEGATIVE, NUMBER, Table};
use crate::section::Section;

/// Process noise of the rate.
pub const RATE_WALK: Key = Key::required(
    "rate_walk_rad_s_sqrt_s",
    NUMBER,
    "(rad/s)/√s",
    NOT_NEGATIVE,
    "Random walk of the rate, in the estimators that have it",
)
.or("that of the estimator");
/// Process noise of the inertia.
pub const INERTIA_WALK: Key = Key::required(
    "inertia_walk_kg_m2_sqrt_hour",
    NUMBER,
    "kg m²/√h",
    NOT_NEGATIVE,
    "Random walk of each inertia element, as by fuel consumption",
)
.or("0");
/// Torque between samples.
pub const TORQUE_IS_SMOOTH: Key = Key::required(
    "torque_is_smooth",
    FLAG,
    "",
    ANY,
    "External torque between its samples: smooth if true, else linear",
)
.or("false");

/// The keys of `[filter]` in a craft file.
pub const TABLE: Table = Table {
    header: "[filter]",
    about: "Process noise of the filters. Optional.",
    keys: &[RATE_WALK, INERTIA_WALK, TORQUE_IS_SMOOTH],
};

/// `[filter]` as written.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterFile {
    rate_walk_rad_s_sqrt_s: Option<Spanned<f64>>,
    inertia_walk_kg_m2_sqrt_hour: Option<Spanned<f64>>,
    torque_is_smooth: Option<Spanned<bool>>,
}

/// Process noise of the filters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Filter {
    /// Random walk of the rate, (rad/s)/√s; none for that of the estimator.
    pub rate_walk_rad_s_sqrt_s: Option<f64>,
    /// Random walk of each inertia element, kg m²/√h; none for zero.
    pub inertia_walk_kg_m2_sqrt_hour: Option<f64>,
    /// External torque between its samples: smooth if true, else linear.
    pub is_torque_smooth: bool,
}

impl FilterFile {
    /// The checked values of the file whose root is `root`.
    ///
    /// # Errors
    /// A negative random walk.
    pub fn read(&self, root: &Section<'_>) -> Result<Filter, InputError> {
        let section = root.table("filter");
        let (rate, inertia) = (&self.rate_walk_rad_s_sqrt_s, &self.inertia_walk_kg_m2_sqrt_hour);
        Ok(Filter {
            rate_walk_rad_s_sqrt_s: section.optional_number(&RATE_WALK, rate)?,
            inertia_walk_kg_m2_sqrt_hour: section.optional_number(&INERTIA_WALK, inertia)?,
            is_torque_smooth: self.torque_is_smooth.as_ref().is_some_and(|flag| *flag.get_ref()),
        })
    }

    /// The place of `torque_is_smooth`, if it is present.
    pub fn torque_is_smooth_at(&self) -> Option<Range<usize>> {
        self.torque_is_smooth.as_ref().map(Spanned::span)
    }
}

impl Filter {
    pub(super) fn write(&self, text: &mut String) {
        *text += "[filter]\n";
        for (key, walk) in [
            (RATE_WALK, self.rate_walk_rad_s_sqrt_s),
            (INERTIA_WALK, self.inertia_walk_kg_m2_sqrt_hour),
        ] {
            if let Some(walk) = walk {
                *text += &format!("{} = {walk:?}\n", key.name);
            }
        }
        if self.is_torque_smooth {
            *text += "torque_is_smooth = true\n";
        }
    }
}
