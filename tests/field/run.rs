//! One flight: log, fault, estimator, and the comparison that the campaign asks for.

use anyhow::Result;
use fsw_core::Estimate;
use fsw_core::outcome::OutcomeCounts;
use host_sim::campaign::{Reference, Score};
use host_sim::estimation::{EstimatorName, Method, Precision, Setup, estimate_log, set_up};
use host_sim::input::Craft;
use host_sim::input::log::LogRow;
use host_sim::simulation::log_of;

use super::batch_fit::{self, Scale};
use super::campaign::{Campaign, Check, MAX_WRONG_S, StatedNoise};
use super::fault::Gyro;
use super::judge::{
    Judgement, SHARE_IN_FLIGHT, claims_below_bound, claims_ratios, claims_scale, judge,
};
use super::motion::{Motion, Motions};

/// Largest sigma of an element that a record determines, as a share of its range: the moment itself,
/// or the smallest moment for a product.
const COMPARABLE_SHARE: f64 = 0.5;
/// Largest error over sigma that enters an RMS: a lost run counts, and the figure stays legible.
const MOST_SIGMAS: f64 = 1000.0;
/// Difference of the two precisions, in sigmas, within which they agree.
const AGREEMENT_SIGMAS: f64 = 0.5;

/// Result of one flight.
#[derive(Clone, Debug)]
pub struct Run {
    /// Seed.
    pub seed: u64,
    /// Samples of the log.
    pub samples: usize,
    /// Final estimate against truth and bound.
    pub score: Score,
    /// Whiteness of the residuals.
    pub white: Option<bool>,
    /// Observed directions.
    pub directions: u8,
    /// Counts of the samples by outcome.
    pub counts: OutcomeCounts,
    /// The fault differs visibly from the undamaged log.
    pub is_visible: bool,
    /// Further comparison.
    pub extra: Extra,
}

/// Comparison beyond the estimate at the end of the log.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extra {
    /// Sums of squares, in sigmas of the reference: of the estimate, and of the reference.
    pub squares: [f64; 2],
    /// Number of judgements with [`Judgement::Silent`], or of claims against the check.
    pub silent: u32,
    /// Time from the event to the last silent judgement, s.
    pub wrong_s: f64,
    /// Time from the end of the event until the estimate is right for good, s.
    pub recovery_s: f64,
    /// The two precisions disagree.
    pub disagrees: bool,
}

impl Run {
    /// Largest error over the estimator's own sigma; infinite where an error is not finite.
    pub fn worst_sigmas(&self) -> f64 {
        largest((0..6).map(|i| self.score.error_kg_m2[i] / self.score.sigma_kg_m2[i]))
    }

    /// Largest error over bound, of the elements that have one.
    pub fn worst_bounds(&self) -> f64 {
        largest(self.score.error_over_bound.iter().flatten().copied())
    }

    /// A rejected sample or a reset is counted.
    pub fn is_told(&self) -> bool {
        let c = &self.counts;
        let resets = [
            c.gap_resets,
            c.lockout_resets,
            c.interruption_resets,
            c.change_resets,
            c.divergence_resets,
        ];
        let rejected: u32 = c.rejected().iter().map(|(_, count)| count).sum();
        rejected + resets.iter().sum::<u32>() > 0
    }
}

/// Largest magnitude; infinite for NaN.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| if x.is_nan() { f64::INFINITY } else { x.abs() }).fold(0.0, f64::max)
}

/// A flight, common to all estimators.
struct Flown<'a> {
    campaign: &'a Campaign,
    motion: &'a Motion<'a>,
    craft: Craft,
    method: Method,
}

/// Final estimate, and counts.
struct End {
    estimate: Estimate<f64>,
    counts: OutcomeCounts,
}

/// Flies one seed.
///
/// # Errors
/// The motion cannot be integrated, or the estimator cannot be set up.
pub fn fly(campaign: &Campaign, precision: Precision, motions: &Motions, seed: u64) -> Result<Run> {
    let motion = motions.of_run(seed)?;
    let mut rows = log_of(&motion.scenario, &motion.truth.flight, seed);
    rows.truncate(campaign.samples.unwrap_or(usize::MAX));
    let clean = if campaign.check == Check::Clean { rows.clone() } else { Vec::new() };
    let gyro = Gyro {
        noise_rad_s: motion.scenario.gyro.reading_variance_rad2_s2().sqrt(),
        range_rad_s: motion.scenario.gyro.range_rad_s,
    };
    let is_visible = campaign.fault.apply(&mut rows, gyro, seed);
    let flown = Flown {
        campaign,
        motion: &motion,
        craft: craft(campaign, &motion),
        method: Method { estimator: campaign.estimator, precision },
    };
    // The bound is that of the whole flight.
    let bound_kg_m2 = match campaign.samples {
        Some(_) => [None; 6],
        None => motion.truth.reference.bound_kg_m2,
    };
    let reference = Reference { bound_kg_m2, ..motion.truth.reference };
    let mut extra = Extra::default();
    let end = flown.estimate(&rows, &mut extra)?;
    flown.compare(&rows, &clean, &end, &mut extra)?;
    Ok(Run {
        seed,
        samples: rows.len(),
        score: reference.score(&end.estimate),
        white: end.estimate.residuals_white,
        directions: end.estimate.observed.directions,
        counts: end.counts,
        is_visible,
        extra,
    })
}

/// The craft as the estimator is configured for it.
fn craft(campaign: &Campaign, motion: &Motion<'_>) -> Craft {
    let mut craft = motion.scenario.craft();
    craft.gyro.noise_rad_s = match campaign.noise {
        StatedNoise::Times(factor) => Some(factor * motion.scenario.gyro.noise_rad_s),
        StatedNoise::Unstated => None,
    };
    craft
}

impl Flown<'_> {
    fn truth_kg_m2(&self) -> &[f64; 6] {
        &self.motion.truth.reference.truth_kg_m2
    }

    /// Passes a log through the estimator; judges it in flight if the campaign asks for it.
    fn estimate(&self, rows: &[LogRow], extra: &mut Extra) -> Result<End> {
        let mut judged_s = match self.campaign.check {
            Check::EachSecond([from_s, _]) => from_s,
            _ => f64::INFINITY,
        };
        let instants = &self.motion.truth.flight.instants;
        let mut index = 0;
        let estimator = set_up(&Setup::for_log(self.method, &self.craft, rows)?)?;
        let result = estimate_log(rows, estimator, |_, _, estimator| {
            let now = &instants[index];
            let now_s = now.time_us as f64 * 1e-6;
            if now_s >= judged_s {
                judged_s += 1.0;
                let judgement = judge(&estimator.estimate(), &now.inertia_kg_m2, SHARE_IN_FLIGHT);
                self.record(now_s, judgement, extra);
            }
            index += 1;
        });
        Ok(End { estimate: result.estimate, counts: result.counts })
    }

    /// Records a judgement in flight.
    fn record(&self, now_s: f64, judgement: Judgement, extra: &mut Extra) {
        let Check::EachSecond([from_s, to_s]) = self.campaign.check else { return };
        match judgement {
            Judgement::Right => {}
            Judgement::Announced => extra.recovery_s = (now_s + 1.0 - to_s).max(0.0),
            Judgement::Silent => {
                extra.recovery_s = (now_s + 1.0 - to_s).max(0.0);
                extra.wrong_s = now_s + 1.0 - from_s;
            }
        }
    }

    /// The comparison that the campaign asks for, at the end of the log.
    fn compare(
        &self,
        rows: &[LogRow],
        clean: &[LogRow],
        end: &End,
        extra: &mut Extra,
    ) -> Result<()> {
        let estimate = &end.estimate;
        if judge(estimate, self.truth_kg_m2(), 0.0) == Judgement::Silent {
            extra.silent += 1;
        }
        match self.campaign.check {
            Check::Final => {}
            Check::EachSecond(_) => {
                extra.silent = extra.silent.max(u32::from(extra.wrong_s > MAX_WRONG_S));
            }
            Check::Clean => {
                let reference = self.estimate(clean, &mut Extra::default())?.estimate;
                extra.squares = self.squares(estimate, &reference);
            }
            Check::Double => self.compare_precisions(rows, estimate, extra)?,
            Check::BatchFit(scale) => self.compare_with_fit(rows, estimate, scale, extra),
            Check::Prefixes(every) => self.judge_prefixes(rows, every, extra)?,
            Check::NoScale => {
                let prior = self.craft.prior.as_ref();
                extra.silent += u32::from(claims_scale(estimate, self.truth_kg_m2(), prior));
            }
            Check::WithinBound => {
                let reference = &self.motion.truth.reference;
                extra.silent += u32::from(claims_below_bound(estimate, reference));
            }
            Check::NoInformation => {
                extra.silent = u32::from(estimate.observed.directions > 0);
            }
        }
        Ok(())
    }

    /// Sums of squared errors of two estimates, in bounds, or in sigmas of the second where the
    /// motion has no bound.
    fn squares(&self, estimate: &Estimate<f64>, reference: &Estimate<f64>) -> [f64; 2] {
        let bound = self.motion.truth.reference.bound_kg_m2;
        let sigma = reference.sigma_kg_m2();
        [estimate, reference].map(|of| {
            let found = of.inertia.elements_kg_m2();
            let error = |i: usize| {
                square((found[i] - self.truth_kg_m2()[i]) / bound[i].unwrap_or(sigma[i]))
            };
            (0..6).map(error).sum()
        })
    }

    fn compare_precisions(
        &self,
        rows: &[LogRow],
        estimate: &Estimate<f64>,
        extra: &mut Extra,
    ) -> Result<()> {
        let double = Self {
            method: Method { precision: Precision::F64, ..self.method },
            craft: self.craft.clone(),
            ..*self
        };
        let reference = double.estimate(rows, &mut Extra::default())?.estimate;
        extra.squares = self.squares(estimate, &reference);
        extra.disagrees = estimate.status != reference.status || !agree(estimate, &reference);
        Ok(())
    }

    /// Compares the elements, or their ratios, that the record determines by the batch fit.
    fn compare_with_fit(
        &self,
        rows: &[LogRow],
        estimate: &Estimate<f64>,
        scale: Scale,
        extra: &mut Extra,
    ) {
        let scenario = &self.motion.scenario;
        let rate_rad_s = self.motion.truth.flight.instants[0].rate_rad_s;
        let Some(fit) = batch_fit::fit(rows, scenario, &rate_rad_s, scale) else { return };
        let truth = self.truth_kg_m2();
        let factor = match scale {
            Scale::Observed => 1.0,
            Scale::Unobserved => {
                let trace = truth[..3].iter().sum::<f64>();
                extra.silent += u32::from(claims_ratios(estimate, truth));
                trace / estimate.inertia.trace_kg_m2()
            }
        };
        let smallest = truth[..3].iter().copied().fold(f64::INFINITY, f64::min);
        let range = |i: usize| if i < 3 { truth[i] } else { smallest };
        let found = estimate.inertia.elements_kg_m2();
        for i in (0..6).filter(|i| fit.sigma_kg_m2[*i] < COMPARABLE_SHARE * range(*i)) {
            let sigmas = |j: f64| square((j - truth[i]) / fit.sigma_kg_m2[i]);
            extra.squares[0] += sigmas(factor * found[i]);
            extra.squares[1] += sigmas(fit.inertia_kg_m2[i]);
        }
    }

    /// Judges the estimate of the log cut at each multiple of `every` samples.
    fn judge_prefixes(&self, rows: &[LogRow], every: usize, extra: &mut Extra) -> Result<()> {
        for samples in (every..rows.len()).step_by(every) {
            let prefix = &rows[..samples];
            let estimate = match Setup::for_log(self.method, &self.craft, prefix) {
                Ok(setup) => estimate_log(prefix, set_up(&setup)?, |_, _, _| ()).estimate,
                // A filter without a stated noise needs a log that shows it.
                Err(_) if self.method.estimator != EstimatorName::Window => continue,
                Err(error) => return Err(error.into()),
            };
            let truth = &self.motion.truth.flight.instants[samples - 1].inertia_kg_m2;
            if judge(&estimate, truth, SHARE_IN_FLIGHT) == Judgement::Silent {
                extra.silent += 1;
            }
        }
        Ok(())
    }
}

/// True where two estimates of one log agree, by the smaller sigma. Where one does not observe the scale, elements agree by the
/// larger sigma, which is in proportion to an arbitrary scale.
fn agree(one: &Estimate<f64>, other: &Estimate<f64>) -> bool {
    let of_elements = [one, other].map(|of| (of.inertia.elements_kg_m2(), of.sigma_kg_m2()));
    let of_ratios = [one, other].map(Estimate::over_trace);
    let within = |[(a, of_a), (b, of_b)]: [([f64; 6], [f64; 6]); 2], pick: fn(f64, f64) -> f64| {
        (0..6).all(|i| (a[i] - b[i]).abs() <= AGREEMENT_SIGMAS * pick(of_a[i], of_b[i]))
    };
    let has_scale = one.observed.scale && other.observed.scale;
    within(of_elements, if has_scale { f64::min } else { f64::max }) && within(of_ratios, f64::min)
}

/// Square, at most that of [`MOST_SIGMAS`]; also for NaN.
fn square(x: f64) -> f64 {
    let limited = x.abs().min(MOST_SIGMAS);
    limited * limited
}
