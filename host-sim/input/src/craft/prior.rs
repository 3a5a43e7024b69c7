//! `[prior]`: the inertia expected before any measurement, in craft files and scenarios.

use serde::Deserialize;

use crate::error::InputError;
use crate::key::{ELEMENTS, Key, PHYSICAL, POSITIVE, Table};
use crate::section::{List, Section};

const INERTIA: Key = Key::required(
    "inertia_kg_m2",
    ELEMENTS,
    "kg m²",
    PHYSICAL,
    "Expected `jxx jyy jzz jxy jxz jyz`, wheels included and locked",
);
const SIGMA: Key = Key::required(
    "sigma_kg_m2",
    ELEMENTS,
    "kg m²",
    POSITIVE,
    "One sigma of each element, in the same order",
);

/// The keys of `[prior]`.
pub const TABLE: Table = Table {
    header: "[prior]",
    about: "The inertia expected before any measurement. Optional; both keys or neither.",
    keys: &[INERTIA, SIGMA],
};

/// The inertia expected before any measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// `jxx jyy jzz jxy jxz jyz`, wheels included and locked, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each element, in the same order, kg m².
    pub sigma_kg_m2: [f64; 6],
}

impl Prior {
    pub(super) fn write(&self, text: &mut String) {
        let Self { inertia_kg_m2, sigma_kg_m2 } = self;
        *text += &format!("[prior]\ninertia_kg_m2 = {inertia_kg_m2:?}\n");
        *text += &format!("sigma_kg_m2 = {sigma_kg_m2:?}\n");
    }
}

/// `[prior]` as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PriorFile {
    inertia_kg_m2: List,
    sigma_kg_m2: List,
}

impl PriorFile {
    /// The checked prior of the file whose root is `root`.
    ///
    /// # Errors
    /// An inertia that no rigid body has, or a sigma of zero or less.
    pub fn read(&self, root: &Section<'_>) -> Result<Prior, InputError> {
        let section = root.table("prior");
        Ok(Prior {
            inertia_kg_m2: section.inertia(&INERTIA, &self.inertia_kg_m2)?,
            sigma_kg_m2: section.list(&SIGMA, &self.sigma_kg_m2)?,
        })
    }
}
