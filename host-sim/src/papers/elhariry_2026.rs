//! \[ElHariry2026\]: fourteen torque profiles of equal energy, and the bias of least squares by noise
//! in the regressors (errors in variables).
//!
//! M. El Hariry et al.: When does excitation design help spacecraft inertia identification? A
//! first-principles study of the observability-accuracy link. Draft, 2026, with its programs in the
//! repository elharirymatteo/satellite-inertia-id. Reproduced here: rung 3 of its ladder.

use nalgebra::{Matrix3x6, Matrix6, Vector3, Vector6};

use super::case::{Case, OWN};
use super::distribution::Distribution;
use super::paper::{Paper, PapersFailed};
use super::rank_test::regressor;
use crate::campaign::{Score, Statistics, Verdict, reduce};
use crate::estimation::{Precision, SetUpError};
use crate::input::log::LogRow;
use crate::report::published::{PaperFigure, PublishedTable, Row};
use crate::simulation::log_of;

const PLACE: &str = "rung 3";
/// Beginning of the scenario names.
pub(crate) const FAMILY: &str = "elhariry-2026-";

/// Profiles, by the end of the scenario name.
pub(crate) const PROFILES: [&str; 14] = [
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
/// Median over the profiles of the bias by instrumental variables, per cent.
const INSTRUMENTAL_MEDIAN_PERCENT: f64 = 0.02;
/// Lag of the instruments behind the regressors, samples.
const LAG: usize = 3;

const PLAIN: &str = "plain least squares";
const INSTRUMENTAL: &str = "instrumental variables";

/// The scenarios of all profiles.
pub struct ElHariry2026 {
    /// In the order of [`PROFILES`].
    cases: Vec<Case>,
}

/// Estimates of one seed, in the order of [`PROFILES`].
pub struct ElHariry2026Trial {
    profiles: Vec<Estimates>,
}

/// Estimates of one flight by each method.
struct Estimates {
    /// Plain least squares, kg m².
    plain: [f64; 6],
    /// Instrumental variables, kg m².
    instrumental: [f64; 6],
    /// Own estimator.
    own: Score,
}

impl Estimates {
    fn fly(case: &Case, seed: u64) -> Result<Self, SetUpError> {
        let log = log_of(&case.scenario, &case.flight, seed);
        let regressors = regressors(&log, 1.0 / case.scenario.gyro.rate_hz);
        let own = case.fly(OWN, seed, |_, _| ())?.estimate;
        Ok(Self {
            plain: solve(&log, &regressors, 0),
            instrumental: solve(&log, &regressors, LAG),
            own: case.reference().score(&own),
        })
    }
}

impl Paper for ElHariry2026 {
    type Trial = ElHariry2026Trial;

    const KEY: &'static str = "ElHariry2026";

    fn load() -> Result<Self, PapersFailed> {
        let load = |name| Case::load(&format!("{FAMILY}{name}"));
        Ok(Self { cases: PROFILES.into_iter().map(load).collect::<Result<_, _>>()? })
    }

    fn fly(&self, seed: u64) -> Result<ElHariry2026Trial, PapersFailed> {
        let profiles = self.cases.iter().map(|case| Estimates::fly(case, seed));
        Ok(ElHariry2026Trial { profiles: profiles.collect::<Result<_, _>>()? })
    }

    /// Bias beside that of either published method, and RMS error over the bound.
    fn tables(&self, trials: &[ElHariry2026Trial]) -> Vec<PublishedTable> {
        vec![
            self.bias(PLAIN, PLAIN_MEDIAN_PERCENT, trials, |estimates| &estimates.plain),
            self.bias(INSTRUMENTAL, INSTRUMENTAL_MEDIAN_PERCENT, trials, |estimates| {
                &estimates.instrumental
            }),
            self.over_bound(trials),
        ]
    }

    /// No figure is reproduced.
    fn figures(
        &self,
        _first_seed: u64,
        _trials: &[ElHariry2026Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        Ok(Vec::new())
    }
}

impl ElHariry2026 {
    fn table(&self, title: &str, estimator: &str, rows: Vec<Row>) -> PublishedTable {
        let directions = self.cases.iter().map(|case| case.flight.bound.observed_directions);
        PublishedTable {
            paper: Self::KEY,
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

    /// Norm of the mean error over the norm of the six elements, profile by profile, and its median.
    fn bias(
        &self,
        estimator: &str,
        published: f64,
        trials: &[ElHariry2026Trial],
        method: fn(&Estimates) -> &[f64; 6],
    ) -> PublishedTable {
        let (mut all, mut all_own) = (Vec::new(), Vec::new());
        let mut rows = Vec::new();
        for (profile, name) in PROFILES.iter().enumerate() {
            let truth = self.cases[profile].truth_kg_m2();
            let flights = || trials.iter().map(|trial| &trial.profiles[profile]);
            let kept = flights().filter(|flight| flight.own.verdict != Verdict::Diverged);
            let ours = bias_percent(truth, flights().map(method));
            let own = bias_percent(truth, kept.map(|flight| &flight.own.inertia_kg_m2));
            all.push(ours);
            all_own.push(own);
            rows.push(Row {
                mean: Some(ours),
                own_mean: Some(own),
                ..Row::new(*name, "%").bound(self.bound_of_mean_percent(profile, trials.len()))
            });
        }
        rows.push(Row {
            published: Some(published),
            mean: Distribution::new(all).median(),
            own_mean: Distribution::new(all_own).median(),
            ..Row::new("median", "%")
        });
        let title = format!("bias by {estimator}: size of the mean error over that of the inertia");
        self.table(&title, estimator, rows).remark(format!(
            "The bound is that of the mean of {} runs: the part of a bias explained by noise. \
             Diverged runs are left out of {}: {} of {}. The paper averages 200 runs, and prints \
             only the median.",
            trials.len(),
            OWN.estimator,
            trials.iter().flat_map(|trial| &trial.profiles).filter(is_diverged).count(),
            trials.len() * PROFILES.len(),
        ))
    }

    /// One sigma of the mean of `trials` estimates, all six elements together, per cent of the norm
    /// of the elements.
    fn bound_of_mean_percent(&self, profile: usize, trials: usize) -> Option<f64> {
        let case = &self.cases[profile];
        let square = |i: usize| case.bound_kg_m2(i).map(|bound| bound * bound);
        let sum = (0..6).map(square).sum::<Option<f64>>()?;
        let size = Vector6::from(*case.truth_kg_m2()).norm();
        Some(100.0 * (sum / trials as f64).sqrt() / size)
    }

    /// RMS error over the bound, profile by profile.
    fn over_bound(&self, trials: &[ElHariry2026Trial]) -> PublishedTable {
        let mut rows = Vec::new();
        for (profile, name) in PROFILES.iter().enumerate() {
            let reference = self.cases[profile].reference();
            let flights = || trials.iter().map(|trial| &trial.profiles[profile]);
            let own = reduce(flights().map(|flight| &flight.own));
            let instrumental: [Option<f64>; 6] = std::array::from_fn(|i| {
                let bound = reference.bound_kg_m2[i]?;
                let error = |e: &Estimates| (e.instrumental[i] - reference.truth_kg_m2[i]) / bound;
                let square = flights().map(|flight| error(flight).powi(2)).sum::<f64>();
                Some((square / trials.len() as f64).sqrt())
            });
            let instrumental = Statistics { rmse_over_bound: instrumental, ..own };
            for (elements, figure) in [
                ("all elements", Statistics::rmse_over_bound_of_all as fn(&Statistics) -> _),
                ("worst element", |found| worst(&found.rmse_over_bound)),
            ] {
                rows.push(Row {
                    mean: figure(&instrumental),
                    own_mean: figure(&own),
                    ..Row::new(format!("{name}, {elements}"), "bounds")
                });
            }
        }
        let observed = self.cases.iter().filter(|case| case.flight.bound.observed_directions == 6);
        let title = "RMS error over the Cramér-Rao bound";
        self.table(title, INSTRUMENTAL, rows).remark(format!(
            "In {} of {} profiles six directions are observable.",
            observed.count(),
            PROFILES.len()
        ))
    }
}

fn is_diverged(flight: &&Estimates) -> bool {
    flight.own.verdict == Verdict::Diverged
}

/// Largest of the ratios. None if an element has none.
fn worst(ratios: &[Option<f64>; 6]) -> Option<f64> {
    ratios.iter().copied().try_fold(0.0, |worst: f64, ratio| Some(worst.max(ratio?)))
}

/// Norm of the mean error over the norm of the truth, `|mean(ĵ − j)| / |j|`, per cent.
fn bias_percent<'a>(truth_kg_m2: &[f64; 6], found: impl Iterator<Item = &'a [f64; 6]>) -> f64 {
    let truth = Vector6::from(*truth_kg_m2);
    let (mut sum, mut count) = (Vector6::zeros(), 0.0);
    for estimate in found {
        sum += Vector6::from(*estimate) - truth;
        count += 1.0;
    }
    100.0 * (sum / count).norm() / truth.norm()
}

/// Regressor `R = G(ω̇) + ω^× G(ω)` of each sample, with the measured rate `ω`, rad/s.
///
/// `ω̇` is a central difference, one-sided at both ends. `period_s` is the sampling interval.
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

/// Instrumental variables, `ĵ = (Σ Zₖᵀ Rₖ)⁻¹ Σ Zₖᵀ τₖ`, kg m².
///
/// The instruments `Zₖ` are the regressors `lag` samples earlier; `lag = 0` is plain least squares.
/// NaN if the matrix is singular.
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

    /// Energy `∫ |τ|² dt` by the rectangle rule, as in the paper's programs, and torque that is
    /// linear between samples.
    #[test]
    fn all_profiles_have_the_same_energy() {
        /// Rounding of a sum of 600 terms, share of the energy.
        const ENERGY_TOLERANCE: f64 = 1e-9;
        /// Rounding of an interpolated torque, N m.
        const TORQUE_TOLERANCE_N_M: f64 = 1e-12;
        for name in PROFILES {
            let scenario = Scenario::load(&format!("{FAMILY}{name}")).unwrap();
            let energy: f64 = (0..=600)
                .map(|k| scenario.torque.at(f64::from(k) * 0.1).norm_squared() * 0.1)
                .sum();
            assert!((energy - 1.0).abs() < ENERGY_TOLERANCE, "{name}: {energy}");
            let middle = (scenario.torque.at(0.0) + scenario.torque.at(0.1)) / 2.0;
            assert!((scenario.torque.at(0.05) - middle).norm() < TORQUE_TOLERANCE_N_M, "{name}");
        }
    }

    /// Reference: bias by plain least squares of a few profiles, by an independent program.
    #[test]
    fn published_methods_have_the_bias_of_an_independent_program() {
        const KNOWN_PERCENT: [(&str, f64); 5] = [
            ("constant", 0.326),
            ("sine-iso-0.02", 0.574),
            ("chirp", 0.283),
            ("prbs-a", 0.190),
            ("random-c", 0.351),
        ];
        /// Share. The mean of 20 runs scatters by about 0.01 %, and the reference is rounded.
        const BIAS_TOLERANCE: f64 = 0.1;
        /// Share of the published median, which is rounded to two digits.
        const MEDIAN_TOLERANCE: f64 = 0.05;
        /// Bias by instrumental variables over that by plain least squares: noise of 20 runs.
        const INSTRUMENTAL_OVER_PLAIN: f64 = 0.1;

        let paper = ElHariry2026::load().unwrap();
        let trials: Vec<_> = (0..20).map(|seed| paper.fly(seed).unwrap()).collect();
        let tables = paper.tables(&trials);
        for (name, percent) in KNOWN_PERCENT {
            let row = tables[0].rows.iter().find(|row| row.quantity == name).unwrap();
            let ratio = row.mean.unwrap() / percent;
            assert!((ratio - 1.0).abs() < BIAS_TOLERANCE, "{name}: {:?}", row.mean);
        }
        let [plain, instrumental] = [0, 1].map(|table| tables[table].rows[14].mean.unwrap());
        assert!((plain / PLAIN_MEDIAN_PERCENT - 1.0).abs() < MEDIAN_TOLERANCE, "{plain}");
        assert!(instrumental < INSTRUMENTAL_OVER_PLAIN * plain, "{instrumental}");
    }
}
