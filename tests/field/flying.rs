//! The runs of a campaign, in parallel on all cores.

use anyhow::Result;
use host_sim::estimation::Precision;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::campaign::Campaign;
use super::motion::Library;
use super::run::{Run, fly};

/// Flies `runs` seeds of a campaign from `first_seed` on. The result is in the order of the seeds and
/// independent of the number of threads; a run that cannot be flown has its reason.
///
/// # Errors
/// The truth of the campaign cannot be simulated.
pub fn fly_all(
    campaign: &Campaign,
    precision: Precision,
    library: &mut Library,
    first_seed: u64,
    runs: u64,
) -> Result<Vec<Result<Run, String>>> {
    let motions = library.motions(&campaign.source)?;
    let one = |seed| fly(campaign, precision, &motions, seed).map_err(|error| error.to_string());
    Ok((first_seed..first_seed.saturating_add(runs)).into_par_iter().map(one).collect())
}
