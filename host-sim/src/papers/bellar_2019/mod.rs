//! \[Bellar2019\]: the nine-state filter, one flight and a Monte Carlo campaign.

mod figures;

use fsw_core::Inertia;
use nalgebra::Vector3;

use super::PapersFailed;
use super::course::{Course, OWN};
use super::distribution::Distribution;
use crate::campaign::{self, Campaign, RunFailed, Truths};
use crate::campaign::{MAX_CONSISTENT_SIGMAS, MAX_CONVERGED_BOUNDS, Verdict};
use crate::estimation::{AnyEstimator, EstimatorName, Method, Precision, SetUpError};
use crate::input::{ELEMENT_NAMES, Scenario};
use crate::report::published::{PublishedTable, Row};

const PAPER: &str = "Bellar2019";

/// Table 3: estimates, kg m².
const ESTIMATED_KG_M2: [f64; 6] = [14.1905, 17.2954, 20.3017, 0.0871, 0.1345, 0.6001];
/// Table 3: their errors, per cent.
const ERROR_PERCENT: [f64; 6] = [0.06, 0.02, 0.008, 0.46, 0.88, 0.25];
/// Text to Figure 3: global RMS error of the rate.
const RATE_RMSE_DEG_S: f64 = 3.6e-3;
/// Text to Figure 4: standard deviation of the rate.
const RATE_SIGMA_DEG_S: f64 = 2.4e-3;
/// Text to Figures 5 and 6: when the estimate has converged.
const CONVERGENCE_S: f64 = 350.0;
/// Text to Figures 7 and 8: runs that diverged, per cent.
const DIVERGED_PERCENT: f64 = 0.0;

/// Ours, as the paper doesn't say when it calls an estimate converged: no element further off than
/// this share of the mean moment, for good.
const CONVERGED_WITHIN: f64 = 0.01;
/// That is looked at every so many samples: reading an estimate out costs more than a step.
const LOOKED_AT_EVERY: usize = 10;

const PUBLISHED: Method =
    Method { estimator: EstimatorName::JointEkfPublished, precision: Precision::F64 };

/// What flies the campaign: as printed, in UD form from the same start, and our own.
const CAMPAIGN: [Method; 5] = [
    PUBLISHED,
    Method { precision: Precision::F32, ..PUBLISHED },
    Method { estimator: EstimatorName::JointEkfUnaligned, precision: Precision::F64 },
    Method { estimator: EstimatorName::JointEkfUnaligned, precision: Precision::F32 },
    OWN,
];

/// The flight of Table 3, and the campaign.
pub struct Study {
    course: Course,
    campaign: Scenario,
    truths: Truths,
}

/// One seed.
pub struct Run {
    published: OneFlight,
    own: OneFlight,
    /// In the order of [`CAMPAIGN`].
    campaign: [campaign::CampaignRun; 5],
}

struct OneFlight {
    verdict: Verdict,
    estimate_kg_m2: [f64; 6],
    /// RMS over samples and axes of estimated minus true rate, deg/s.
    rate_rmse_deg_s: f64,
    /// RMS over samples and axes of the filter's own sigma of the rate, deg/s.
    rate_sigma_deg_s: f64,
    /// NaN if it never has.
    convergence_s: f64,
}

impl Study {
    /// The truths.
    pub fn new() -> Result<Self, PapersFailed> {
        let campaign = Scenario::load("bellar-2019-campaign")?;
        let truths = Truths::simulate(&campaign)?;
        Ok(Self { course: Course::load("bellar-2019")?, campaign, truths })
    }

    /// Flies one seed.
    pub fn fly(&self, seed: u64) -> Result<Run, RunFailed> {
        let [a, b, c, d, e] = CAMPAIGN.map(|method| self.campaign_run(method, seed));
        Ok(Run {
            published: self.one_flight(PUBLISHED, seed)?,
            own: self.one_flight(OWN, seed)?,
            campaign: [a?, b?, c?, d?, e?],
        })
    }

    fn campaign_run(&self, method: Method, seed: u64) -> Result<campaign::CampaignRun, RunFailed> {
        let Method { estimator, precision } = method;
        let (scenario, truths) = (&self.campaign, &self.truths);
        Campaign { scenario, truths, estimator, precision, first_seed: seed, runs: 1 }.run_one(0)
    }

    fn one_flight(&self, method: Method, seed: u64) -> Result<OneFlight, SetUpError> {
        let truth_kg_m2 = self.course.truth_kg_m2();
        let limit = CONVERGED_WITHIN * truth_kg_m2[..3].iter().sum::<f64>() / 3.0;
        let is_close = |estimator: &dyn AnyEstimator| {
            let elements = estimator.estimate().inertia.elements_kg_m2();
            (0..6).all(|i| (elements[i] - truth_kg_m2[i]).abs() < limit)
        };
        let (mut error, mut sigma) = (MeanSquare::default(), MeanSquare::default());
        let mut convergence_s = f64::NAN;
        let flown = self.course.fly(method, seed, |number, estimator| {
            let instant = &self.course.flight.instants[number];
            // The first is the guess of Table 2 itself, degrees per second off.
            if number > 0 {
                error.add(estimator.rate_rad_s() - instant.rate_rad_s);
            }
            if let Some(one_sigma) = estimator.rate_sigma_rad_s() {
                sigma.add(one_sigma);
            }
            if number % LOOKED_AT_EVERY == 0 {
                let time_s = instant.time_us as f64 * 1e-6;
                convergence_s = match is_close(estimator) {
                    true if convergence_s.is_nan() => time_s,
                    true => convergence_s,
                    false => f64::NAN,
                };
            }
        })?;
        Ok(OneFlight {
            verdict: self.course.reference().score(&flown.estimate).verdict,
            estimate_kg_m2: flown.estimate.inertia.elements_kg_m2(),
            rate_rmse_deg_s: error.root().to_degrees(),
            rate_sigma_deg_s: sigma.root().to_degrees(),
            convergence_s,
        })
    }

    /// The tables of the paper, and what it says in its text.
    pub fn tables(&self, runs: &[Run]) -> Vec<PublishedTable> {
        let mut tables = vec![self.table_3(runs), self.text(runs)];
        tables.extend((0..CAMPAIGN.len()).map(|which| self.monte_carlo(which, runs)));
        tables
    }

    fn table(
        &self,
        place: &'static str,
        title: &str,
        method: Method,
        rows: Vec<Row>,
    ) -> PublishedTable {
        PublishedTable {
            paper: PAPER,
            table: place,
            title: title.to_owned(),
            scenario: self.course.scenario.name.clone(),
            estimator: method.estimator.to_string(),
            precision: method.precision.to_string(),
            own_estimator: Some(OWN.estimator.to_string()),
            observed_directions: self.course.flight.bound.observed_directions,
            rows,
            remark: None,
        }
    }

    fn table_3(&self, runs: &[Run]) -> PublishedTable {
        let of = |value: &dyn Fn(&OneFlight) -> f64| of_kept(runs, |run| &run.published, value);
        let of_own = |value: &dyn Fn(&OneFlight) -> f64| of_kept(runs, |run| &run.own, value);
        let mut rows = Vec::new();
        for i in 0..6 {
            rows.push(
                Row::new(ELEMENT_NAMES[i], "kg m2")
                    .truth(self.course.truth_kg_m2()[i])
                    .ours(Some(ESTIMATED_KG_M2[i]), &of(&|flight| flight.estimate_kg_m2[i]))
                    .bound(self.course.bound_kg_m2(i))
                    .own(&of_own(&|flight| flight.estimate_kg_m2[i])),
            );
        }
        for i in 0..6 {
            let error = |kg_m2| self.course.error_percent(i, kg_m2);
            let bound = self.course.bound_percent(i);
            let row = Row::new(format!("{} error", ELEMENT_NAMES[i]), "%")
                .ours(Some(ERROR_PERCENT[i]), &of(&|flight| error(flight.estimate_kg_m2[i])))
                .bound(bound)
                .own(&of_own(&|flight| error(flight.estimate_kg_m2[i])));
            let is_below = bound.is_some_and(|bound| ERROR_PERCENT[i] < bound);
            rows.push(if is_below { row.remark(BELOW_BOUND) } else { row });
        }
        let mut table = self.table("3", "estimates at the end, and their errors", PUBLISHED, rows);
        table.remark = Some(format!("{} {SAMPLE_TIME}", left_out(runs)));
        table
    }

    fn text(&self, runs: &[Run]) -> PublishedTable {
        let row = |name: &str, unit, published: f64, of: &dyn Fn(&OneFlight) -> f64| {
            let ours = of_kept(runs, |run| &run.published, of);
            (Row::new(name, unit).ours(Some(published), &ours), ours.count())
        };
        let (rmse, _) = row("rate RMSE", "deg/s", RATE_RMSE_DEG_S, &|f| f.rate_rmse_deg_s);
        let (sigma, _) = row("rate, one sigma", "deg/s", RATE_SIGMA_DEG_S, &|f| f.rate_sigma_deg_s);
        let (time, converged) = row("converged at", "s", CONVERGENCE_S, &|f| f.convergence_s);
        let criterion = format!(
            "within 1 % of the mean moment for good, our criterion: the paper gives none; {converged} \
             of {} runs",
            runs.len()
        );
        let own_time = of_kept(runs, |run| &run.own, &|flight| flight.convergence_s);
        let rows = vec![
            rmse.remark(format!(
                "over all samples and axes but the first sample, which is the initial guess; {} \
                 doesn't filter the rate",
                OWN.estimator
            )),
            sigma.remark(SIGMA),
            time.own(&own_time).remark(criterion),
        ];
        let title = "rate error, its sigma, and convergence";
        let mut table = self.table("text", title, PUBLISHED, rows);
        table.remark = Some(left_out(runs));
        table
    }

    fn monte_carlo(&self, which: usize, runs: &[Run]) -> PublishedTable {
        let verdicts = |is_counted: &dyn Fn(u64) -> bool, wanted: Verdict| {
            let counted = runs.iter().map(|run| &run.campaign[which]);
            let counted: Vec<bool> = counted
                .filter(|run| is_counted(run.seed))
                .map(|run| run.score.verdict == wanted)
                .collect();
            let share = counted.iter().filter(|is| **is).count() as f64 / counted.len() as f64;
            (!counted.is_empty()).then_some(100.0 * share)
        };
        let row = |name: String, published, mean| Row { published, mean, ..Row::new(name, "%") };
        let all = |_: u64| true;
        let mut rows = vec![
            row("converged".to_owned(), None, verdicts(&all, Verdict::Converged)),
            row("not converged".to_owned(), None, verdicts(&all, Verdict::NotConverged)),
            row("diverged".to_owned(), Some(DIVERGED_PERCENT), verdicts(&all, Verdict::Diverged)),
        ];
        let dispersion = &self.campaign.dispersion;
        for (step, factor) in dispersion.inertia_factors.iter().enumerate() {
            let is_step = |seed: u64| dispersion.truth_of(seed) == step;
            let mean = verdicts(&is_step, Verdict::Diverged);
            rows.push(row(format!("diverged at {factor} J"), Some(DIVERGED_PERCENT), mean));
        }
        let method = CAMPAIGN[which];
        let title = "Monte Carlo over the initial estimate, in five steps of the true inertia";
        let mut table = self.table("text", title, method, rows);
        table.scenario.clone_from(&self.campaign.name);
        table.own_estimator = None;
        // Once for all.
        table.remark = (which == 0).then(|| self.starts(runs));
        table
    }

    /// What the campaign's starts are, and what its words mean.
    fn starts(&self, runs: &[Run]) -> String {
        let is_physical = |run: &&Run| {
            let start = self.campaign.of_seed(run.campaign[0].seed).initial_estimate;
            start.is_some_and(|start| Inertia::new(start.inertia_kg_m2).check().is_ok())
        };
        let physical = 100.0 * runs.iter().filter(is_physical).count() as f64 / runs.len() as f64;
        format!(
            "Uniform within ±30 and ±2 kg m², the initial tensor is one that a body can have in \
             {physical:.1} % of the runs; in seven of eight a moment is negative. Diverged: by its own \
             word, or an error beyond {MAX_CONVERGED_BOUNDS:.0} bounds and \
             {MAX_CONSISTENT_SIGMAS:.0} of its own sigmas. {} \
             needs no start.",
            OWN.estimator
        )
    }
}

/// A quantity over the flights of one estimator that did not diverge: a single one that did would
/// drown the rest.
fn of_kept(
    runs: &[Run],
    flight: fn(&Run) -> &OneFlight,
    value: &dyn Fn(&OneFlight) -> f64,
) -> Distribution {
    let kept = runs.iter().map(flight).filter(|flight| flight.verdict != Verdict::Diverged);
    Distribution::new(kept.map(value))
}

/// How many flights aren't in the figures.
fn left_out(runs: &[Run]) -> String {
    let diverged = |flight: fn(&Run) -> &OneFlight| {
        runs.iter().map(flight).filter(|flight| flight.verdict == Verdict::Diverged).count()
    };
    format!(
        "Diverged, and left out: {} of {} runs as printed, {} of {}.",
        diverged(|run| &run.published),
        runs.len(),
        diverged(|run| &run.own),
        OWN.estimator
    )
}

const SIGMA: &str = "by the filter's own covariance, RMS over all samples and axes; ours is without \
                     process noise, whose value the paper doesn't give";
const BELOW_BOUND: &str = "below the bound: one lucky run";
const SAMPLE_TIME: &str = "\"Sample time 10\" of Table 1 can't be seconds: the bound of the \
                           products would be 12.5, 11.1 and 1.4 %; read as 10 Hz.";

/// Mean square of the components of vectors.
#[derive(Default)]
struct MeanSquare {
    sum: f64,
    count: f64,
}

impl MeanSquare {
    fn add(&mut self, vector: Vector3<f64>) {
        self.sum += vector.norm_squared();
        self.count += 3.0;
    }

    fn root(&self) -> f64 {
        (self.sum / self.count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments have two decimals of a per cent that are cut off, not rounded (0.0669 is printed as
    /// 0.06), one has three; products are rounded.
    #[test]
    fn the_errors_of_table_3_follow_from_its_estimates() {
        const TRUE_KG_M2: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
        const DIGIT_PERCENT: [f64; 6] = [0.01, 0.01, 0.001, 0.005, 0.005, 0.005];
        for i in 0..6 {
            let error = 100.0 * (ESTIMATED_KG_M2[i] / TRUE_KG_M2[i] - 1.0).abs();
            let rounding = 100.0 * 0.5e-4 / TRUE_KG_M2[i] + DIGIT_PERCENT[i];
            assert!((error - ERROR_PERCENT[i]).abs() < rounding, "{}: {error}", ELEMENT_NAMES[i]);
        }
    }
}
