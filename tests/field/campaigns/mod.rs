//! The list of campaigns, one file per subject.

mod changes;
mod clock;
mod fine_gyro;
mod noise;
mod outliers;
mod precision;
mod prefixes;
mod rest;
mod short;
mod tumbles;

use anyhow::Result;

use super::campaign::Campaign;

/// Subjects whose limits hold in every campaign of their small version. Tests assert them.
const HELD: [&str; 12] = [
    "rest/",
    "short/",
    "tumble/",
    "frame/",
    "outliers/",
    "prefix/",
    "noise/",
    "change/",
    "transient/",
    "clock/",
    "vague-prior/",
    "fine-gyro/",
];

/// Every campaign.
///
/// # Errors
/// A scenario that its reader rejects.
pub fn all() -> Result<Vec<Campaign>> {
    let lists = [
        rest::list()?,
        short::list()?,
        tumbles::list()?,
        outliers::list()?,
        prefixes::list()?,
        fine_gyro::list()?,
        noise::list()?,
        changes::list()?,
        clock::list()?,
        precision::list()?,
    ];
    let holds = |name: &str| HELD.iter().any(|subject| name.starts_with(subject));
    let held =
        |campaign: Campaign| Campaign { held: campaign.held || holds(&campaign.name), ..campaign };
    Ok(lists.into_iter().flatten().map(held).collect())
}
