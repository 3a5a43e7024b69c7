//! \[ElHariry2026\]: fourteen torque profiles of equal energy, and what noise in the regressors does to
//! least squares ("errors in variables").
//!
//! M. El Hariry et al.: When does excitation design help spacecraft inertia identification? A
//! first-principles study of the observability-accuracy link. Draft, 2026, with its programs in the
//! repository elharirymatteo/satellite-inertia-id. What is flown here is rung 3 of its ladder.

use nalgebra::{Matrix3x6, Matrix6, Vector3, Vector6};

use super::PapersFailed;
use super::course::{Course, OWN};
use super::distribution::Distribution;
use super::observability::regressor;
use crate::campaign::{Score, Statistics, Verdict, reduce};
use crate::estimation::{Precision, SetUpError};
use crate::input::log::LogRow;
use crate::report::published::{PublishedTable, Row};
use crate::simulation::log_of;

const PAPER: &str = "ElHariry2026";
const PLACE: &str = "rung 3";
/// What the scenarios' names begin with.
const FAMILY: &str = "elhariry-2026-";

/// The profiles, as the scenarios are called.
const PROFILES: [&str; 14] = [
    "constant",
    "sine-x",
    "sine-3axis-same",
    "sine-iso-0.005",
    "sine-iso-0.02",
    "sine-iso-0.08",
    "sine-iso-0.2",
    "sine-multifreq",
    "chirp",
    "prbs-a",
    "prbs-b",
    "random-a",
    "random-b",
    "random-c",
];

/// Median over the profiles of the bias by plain least squares, per cent.
const PLAIN_MEDIAN_PERCENT: f64 = 0.43;
/// The same by instrumental variables.
const INSTRUMENTAL_MEDIAN_PERCENT: f64 = 0.02;
/// Samples by which the instruments lag behind the regressors.
const LAG: usize = 3;

const PLAIN: &str = "plain least squares";
const INSTRUMENTAL: &str = "instrumental variables";

/// The profiles, flown.
pub struct Study {
    courses: Vec<Course>,
}

/// One seed: every profile, in the order of [`PROFILES`].
pub struct Run {
    profiles: Vec<Estimates>,
}

/// One flight by each method.
struct Estimates {
    plain: [f64; 6],
    instrumental: [f64; 6],
    own: Score,
}

impl Estimates {
    fn fly(course: &Course, seed: u64) -> Result<Self, SetUpError> {
        let log = log_of(&course.scenario, &course.flight, seed);
        let regressors = regressors(&log, 1.0 / course.scenario.gyro.rate_hz);
        let own = course.fly(OWN, seed, |_, _| ())?.estimate;
        Ok(Self {
            plain: solve(&log, &regressors, 0),
            instrumental: solve(&log, &regressors, LAG),
            own: course.reference().score(&own),
        })
    }
}

impl Study {
    /// The truths.
    pub fn new() -> Result<Self, PapersFailed> {
        let load = |name| Course::load(&format!("{FAMILY}{name}"));
        Ok(Self { courses: PROFILES.into_iter().map(load).collect::<Result<_, _>>()? })
    }

    /// Flies one seed.
    pub fn fly(&self, seed: u64) -> Result<Run, SetUpError> {
        let profiles = self.courses.iter().map(|course| Estimates::fly(course, seed));
        Ok(Run { profiles: profiles.collect::<Result<_, _>>()? })
    }

    /// Bias beside that of either published method, and RMS error over the bound.
    pub fn tables(&self, runs: &[Run]) -> Vec<PublishedTable> {
        vec![
            self.bias(PLAIN, PLAIN_MEDIAN_PERCENT, runs, |estimates| &estimates.plain),
            self.bias(INSTRUMENTAL, INSTRUMENTAL_MEDIAN_PERCENT, runs, |estimates| {
                &estimates.instrumental
            }),
            self.over_bound(runs),
        ]
    }

    fn table(&self, title: &str, estimator: &str, rows: Vec<Row>) -> PublishedTable {
        let directions = self.courses.iter().map(|c| c.flight.bound.observed_directions);
        PublishedTable {
            paper: PAPER,
            table: PLACE,
            title: title.to_owned(),
            scenario: format!("{FAMILY}*"),
            estimator: estimator.to_owned(),
            precision: Precision::F64.to_string(),
            own_estimator: Some(OWN.estimator.to_string()),
            observed_directions: directions.min().unwrap_or(0),
            rows,
            remark: None,
        }
    }

    /// Size of the mean error over the size of the six elements, profile by profile, and its median.
    fn bias(
        &self,
        estimator: &str,
        published: f64,
        runs: &[Run],
        method: fn(&Estimates) -> &[f64; 6],
    ) -> PublishedTable {
        let (mut all, mut all_own) = (Vec::new(), Vec::new());
        let mut rows = Vec::new();
        for (profile, name) in PROFILES.iter().enumerate() {
            let truth = self.courses[profile].truth_kg_m2();
            let flights = || runs.iter().map(|run| &run.profiles[profile]);
            let kept = flights().filter(|flight| flight.own.verdict != Verdict::Diverged);
            let ours = bias_percent(truth, flights().map(method));
            let own = bias_percent(truth, kept.map(|flight| &flight.own.inertia_kg_m2));
            all.push(ours);
            all_own.push(own);
            rows.push(Row {
                mean: Some(ours),
                own_mean: Some(own),
                ..Row::new(*name, "%").bound(self.bound_of_mean_percent(profile, runs.len()))
            });
        }
        rows.push(Row {
            published: Some(published),
            mean: Distribution::new(all).median(),
            own_mean: Distribution::new(all_own).median(),
            ..Row::new("median", "%")
        });
        let title = format!("bias by {estimator}: size of the mean error over that of the inertia");
        let mut table = self.table(&title, estimator, rows);
        table.remark = Some(format!(
            "The bound is that of the mean of {} runs: what noise alone leaves of a bias. Diverged runs \
             are left out of {}: {} of {}. The paper averages 200 runs, and prints the median alone.",
            runs.len(),
            OWN.estimator,
            runs.iter().flat_map(|run| &run.profiles).filter(is_diverged).count(),
            runs.len() * PROFILES.len(),
        ));
        table
    }

    /// One sigma of the six elements together, of the mean of so many runs, per cent of their size.
    fn bound_of_mean_percent(&self, profile: usize, runs: usize) -> Option<f64> {
        let course = &self.courses[profile];
        let square = |i: usize| course.bound_kg_m2(i).map(|bound| bound * bound);
        let sum = (0..6).map(square).sum::<Option<f64>>()?;
        let size = Vector6::from(*course.truth_kg_m2()).norm();
        Some(100.0 * (sum / runs as f64).sqrt() / size)
    }

    fn over_bound(&self, runs: &[Run]) -> PublishedTable {
        let mut rows = Vec::new();
        for (profile, name) in PROFILES.iter().enumerate() {
            let reference = self.courses[profile].reference();
            let flights = || runs.iter().map(|run| &run.profiles[profile]);
            let own = reduce(flights().map(|flight| &flight.own));
            let instrumental: [Option<f64>; 6] = std::array::from_fn(|i| {
                let bound = reference.bound_kg_m2[i]?;
                let error = |e: &Estimates| (e.instrumental[i] - reference.truth_kg_m2[i]) / bound;
                let square = flights().map(|flight| error(flight).powi(2)).sum::<f64>();
                Some((square / runs.len() as f64).sqrt())
            });
            let instrumental = Statistics { rmse_over_bound: instrumental, ..own };
            for (what, figure) in [
                ("all elements", Statistics::rmse_over_bound_of_all as fn(&Statistics) -> _),
                ("worst element", |found| worst(&found.rmse_over_bound)),
            ] {
                rows.push(Row {
                    mean: figure(&instrumental),
                    own_mean: figure(&own),
                    ..Row::new(format!("{name}, {what}"), "bounds")
                });
            }
        }
        let title = "RMS error over the Cramér-Rao bound";
        let mut table = self.table(title, INSTRUMENTAL, rows);
        let shown = self.courses.iter().filter(|c| c.flight.bound.observed_directions == 6);
        table.remark =
            Some(format!("{} of {} profiles show six directions.", shown.count(), PROFILES.len()));
        table
    }
}

fn is_diverged(flight: &&Estimates) -> bool {
    flight.own.verdict == Verdict::Diverged
}

fn worst(ratios: &[Option<f64>; 6]) -> Option<f64> {
    ratios.iter().copied().try_fold(0.0, |worst: f64, ratio| Some(worst.max(ratio?)))
}

/// Size of the mean error over the size of the truth, per cent.
fn bias_percent<'a>(truth_kg_m2: &[f64; 6], found: impl Iterator<Item = &'a [f64; 6]>) -> f64 {
    let truth = Vector6::from(*truth_kg_m2);
    let (mut sum, mut count) = (Vector6::zeros(), 0.0);
    for estimate in found {
        sum += Vector6::from(*estimate) - truth;
        count += 1.0;
    }
    100.0 * (sum / count).norm() / truth.norm()
}

/// `G(ω̇) + ω^× G(ω)` of each sample as it was measured, `ω̇` by central differences, one-sided at both
/// ends.
fn regressors(log: &[LogRow], period_s: f64) -> Vec<Matrix3x6<f64>> {
    let last = log.len().saturating_sub(1);
    let one = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        let difference: Vector3<f64> = log[after].rate_rad_s - log[before].rate_rad_s;
        let acceleration = difference / (period_s * (after - before) as f64);
        let rate = &log[k].rate_rad_s;
        regressor(&acceleration) + rate.cross_matrix() * regressor(rate)
    };
    (0..log.len()).map(one).collect()
}

/// `(Σ Zₖᵀ Rₖ)⁻¹ Σ Zₖᵀ τₖ`, with the regressors of `lag` samples before as instruments `Zₖ`; plain least
/// squares if that is zero. NaN where there is no inverse.
fn solve(log: &[LogRow], regressors: &[Matrix3x6<f64>], lag: usize) -> [f64; 6] {
    let (mut matrix, mut side) = (Matrix6::zeros(), Vector6::zeros());
    for ((instrument, regressor), row) in regressors.iter().zip(&regressors[lag..]).zip(&log[lag..])
    {
        matrix += instrument.tr_mul(regressor);
        side += instrument.tr_mul(&row.torque_n_m);
    }
    matrix.lu().solve(&side).map_or([f64::NAN; 6], Into::into)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;

    /// `∫ |τ|² dt` by the rectangles of the paper's programs.
    #[test]
    fn all_profiles_have_the_same_energy() {
        for name in PROFILES {
            let scenario = Scenario::load(&format!("{FAMILY}{name}")).unwrap();
            let energy: f64 = (0..=600)
                .map(|k| scenario.torque.at(f64::from(k) * 0.1).norm_squared() * 0.1)
                .sum();
            assert!((energy - 1.0).abs() < 1e-9, "{name}: {energy}");
            let middle = (scenario.torque.at(0.0) + scenario.torque.at(0.1)) / 2.0;
            assert!((scenario.torque.at(0.05) - middle).norm() < 1e-12, "{name}");
        }
    }

    /// Bias by plain least squares and by instrumental variables, per cent, of a few profiles, by a
    /// program that shares nothing with this one. Instrumental variables leave little but noise.
    #[test]
    fn the_published_methods_err_as_an_independent_program_says() {
        const KNOWN_PERCENT: [(&str, f64); 5] = [
            ("constant", 0.326),
            ("sine-iso-0.02", 0.574),
            ("chirp", 0.283),
            ("prbs-a", 0.190),
            ("random-c", 0.351),
        ];
        let study = Study::new().unwrap();
        let runs: Vec<Run> = (0..20).map(|seed| study.fly(seed).unwrap()).collect();
        let table = &study.tables(&runs)[0];
        for (name, percent) in KNOWN_PERCENT {
            let row = table.rows.iter().find(|row| row.quantity == name).unwrap();
            let ratio = row.mean.unwrap() / percent;
            // The mean of 20 runs scatters by about 0.01 %, and the known value is rounded.
            assert!((ratio - 1.0).abs() < 0.1, "{name}: {:?}", row.mean);
        }
        let median = |table: usize| study.tables(&runs)[table].rows[14].mean.unwrap();
        assert!((median(0) / PLAIN_MEDIAN_PERCENT - 1.0).abs() < 0.05, "{}", median(0));
        assert!(median(1) < 0.1 * median(0), "{}", median(1));
    }
}
