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
    Ok(lists.into_iter().flatten().collect())
}
