//! Table 3 of \[Bellar2019\], the figures of its text, and the campaign of Figures 7 and 8.

use fsw_core::Inertia;

use super::trial::{Bellar2019, Bellar2019Trial, CAMPAIGN, OneFlight, PUBLISHED};
use crate::campaign::{MAX_CONSISTENT_SIGMAS, MAX_CONVERGED_BOUNDS, Verdict};
use crate::estimation::Method;
use crate::input::ELEMENT_NAMES;
use crate::papers::case::OWN;
use crate::papers::distribution::Distribution;
use crate::papers::paper::Paper;
use crate::report::published::{PublishedTable, Row};

/// Table 3: estimates, kg m².
const ESTIMATED_KG_M2: [f64; 6] = [14.1905, 17.2954, 20.3017, 0.0871, 0.1345, 0.6001];
/// Table 3: errors of the estimates, per cent.
const ERROR_PERCENT: [f64; 6] = [0.06, 0.02, 0.008, 0.46, 0.88, 0.25];
/// Text to Figure 3: global RMS error of the rate.
const RATE_RMSE_DEG_S: f64 = 3.6e-3;
/// Text to Figure 4: standard deviation of the rate.
const RATE_SIGMA_DEG_S: f64 = 2.4e-3;
/// Text to Figures 5 and 6: time of convergence.
const CONVERGENCE_S: f64 = 350.0;
/// Text to Figures 7 and 8: runs that diverged, per cent.
const DIVERGED_PERCENT: f64 = 0.0;

const SIGMA: &str = "by the filter's covariance, RMS over all samples and axes; ours without \
                     process noise, since the paper does not give its value";
const BELOW_BOUND: &str = "below the bound: possible for a single run only";
const SAMPLE_TIME: &str = "\"Sample time 10\" of Table 1 cannot be seconds: the bound of the \
                           products would be 12.5, 11.1 and 1.4 %; read as 10 Hz.";

impl Bellar2019 {
    fn table(
        &self,
        place: &'static str,
        title: &str,
        method: Method,
        rows: Vec<Row>,
    ) -> PublishedTable {
        PublishedTable::new(Self::KEY, place, title, &self.case, method, rows)
    }

    /// Estimates at the end of the flight, and their errors.
    pub(super) fn table_3(&self, trials: &[Bellar2019Trial]) -> PublishedTable {
        let ours =
            |value: &dyn Fn(&OneFlight) -> f64| kept(trials, |trial| &trial.published, value);
        let own = |value: &dyn Fn(&OneFlight) -> f64| kept(trials, |trial| &trial.own, value);
        let estimate = |i: usize| {
            Row::new(ELEMENT_NAMES[i], "kg m2")
                .truth(self.case.truth_kg_m2()[i])
                .ours(Some(ESTIMATED_KG_M2[i]), &ours(&|flight| flight.estimate_kg_m2[i]))
                .bound(self.case.bound_kg_m2(i))
                .own(&own(&|flight| flight.estimate_kg_m2[i]))
        };
        let error = |i: usize| {
            let percent = |flight: &OneFlight| self.case.error_percent(i, flight.estimate_kg_m2[i]);
            let bound = self.case.bound_percent(i);
            let row = Row::new(format!("{} error", ELEMENT_NAMES[i]), "%")
                .ours(Some(ERROR_PERCENT[i]), &ours(&percent))
                .bound(bound)
                .own(&own(&percent));
            let is_below = bound.is_some_and(|bound| ERROR_PERCENT[i] < bound);
            if is_below { row.remark(BELOW_BOUND) } else { row }
        };
        let rows = (0..6).map(estimate).chain((0..6).map(error)).collect();
        self.table("3", "estimates at the end, and their errors", PUBLISHED, rows)
            .remark(format!("{} {SAMPLE_TIME}", diverged(trials)))
    }

    /// Rate error, its sigma, and time of convergence, from the text.
    pub(super) fn text(&self, trials: &[Bellar2019Trial]) -> PublishedTable {
        let row = |name: &str, unit, published: f64, of: &dyn Fn(&OneFlight) -> f64| {
            let ours = kept(trials, |trial| &trial.published, of);
            (Row::new(name, unit).ours(Some(published), &ours), ours.count())
        };
        let (rmse, _) = row("rate RMSE", "deg/s", RATE_RMSE_DEG_S, &|f| f.rate_rmse_deg_s);
        let (sigma, _) = row("rate, one sigma", "deg/s", RATE_SIGMA_DEG_S, &|f| f.rate_sigma_deg_s);
        let (time, converged) = row("converged at", "s", CONVERGENCE_S, &|f| f.convergence_s);
        let criterion = format!(
            "own criterion, since the paper gives none: error within 1 % of the mean moment from \
             then on; {converged} of {} runs",
            trials.len()
        );
        let own_time = kept(trials, |trial| &trial.own, &|flight| flight.convergence_s);
        let rows = vec![
            rmse.remark(format!(
                "over all axes and all samples except the first, which is the initial state; {} \
                 does not filter the rate",
                OWN.estimator
            )),
            sigma.remark(SIGMA),
            time.own(&own_time).remark(criterion),
        ];
        self.table("text", "rate error, its sigma, and convergence", PUBLISHED, rows)
            .remark(diverged(trials))
    }

    /// Share of converged and diverged runs of one filter of [`CAMPAIGN`].
    pub(super) fn monte_carlo(&self, method: usize, trials: &[Bellar2019Trial]) -> PublishedTable {
        let percent = |is_counted: &dyn Fn(u64) -> bool, verdict: Verdict| {
            let runs = trials.iter().map(|trial| &trial.campaign[method]);
            let is_verdict: Vec<bool> = runs
                .filter(|run| is_counted(run.seed))
                .map(|run| run.score.verdict == verdict)
                .collect();
            let share =
                is_verdict.iter().filter(|is| **is).count() as f64 / is_verdict.len() as f64;
            (!is_verdict.is_empty()).then_some(100.0 * share)
        };
        let row = |name: String, published, mean| Row { published, mean, ..Row::new(name, "%") };
        let all = |_: u64| true;
        let mut rows = vec![
            row("converged".to_owned(), None, percent(&all, Verdict::Converged)),
            row("not converged".to_owned(), None, percent(&all, Verdict::NotConverged)),
            row("diverged".to_owned(), Some(DIVERGED_PERCENT), percent(&all, Verdict::Diverged)),
        ];
        let dispersion = &self.campaign.dispersion;
        for (step, factor) in dispersion.inertia_factors.iter().enumerate() {
            let is_step = |seed: u64| dispersion.truth_of(seed) == step;
            let mean = percent(&is_step, Verdict::Diverged);
            rows.push(row(format!("diverged at {factor} J"), Some(DIVERGED_PERCENT), mean));
        }
        let title = "Monte Carlo over the initial estimate, in five steps of the true inertia";
        let mut table = self.table("text", title, CAMPAIGN[method], rows).without_own();
        table.scenario.clone_from(&self.campaign.name);
        // The remark holds for all filters and is printed with the first.
        if method == 0 { table.remark(self.initial_estimates(trials)) } else { table }
    }

    /// Remark on the initial estimates of the campaign, and on the definition of divergence.
    fn initial_estimates(&self, trials: &[Bellar2019Trial]) -> String {
        let is_physical = |trial: &&Bellar2019Trial| {
            let initial = self.campaign.of_seed(trial.campaign[0].seed).initial_estimate;
            initial.is_some_and(|initial| Inertia::new(initial.inertia_kg_m2).check().is_ok())
        };
        let physical = trials.iter().filter(is_physical).count() as f64;
        let physical_percent = 100.0 * physical / trials.len() as f64;
        format!(
            "The initial tensor is uniform within ±30 and ±2 kg m². It is physical in \
             {physical_percent:.1} % of the runs; in seven of eight a moment is negative. Diverged: \
             by its own status, or with an error above {MAX_CONVERGED_BOUNDS:.0} bounds and above \
             {MAX_CONSISTENT_SIGMAS:.0} of its own sigmas. {} needs no initial estimate.",
            OWN.estimator
        )
    }
}

/// A quantity over the flights of one estimator. Diverged flights are left out: one of them would
/// dominate the mean.
fn kept(
    trials: &[Bellar2019Trial],
    flight: fn(&Bellar2019Trial) -> &OneFlight,
    value: &dyn Fn(&OneFlight) -> f64,
) -> Distribution {
    let kept = trials.iter().map(flight).filter(|flight| flight.verdict != Verdict::Diverged);
    Distribution::new(kept.map(value))
}

/// Remark on the number of flights left out.
fn diverged(trials: &[Bellar2019Trial]) -> String {
    let diverged = |flight: fn(&Bellar2019Trial) -> &OneFlight| {
        trials.iter().map(flight).filter(|flight| flight.verdict == Verdict::Diverged).count()
    };
    format!(
        "Diverged, and left out: {} of {} runs as printed, {} of {}.",
        diverged(|trial| &trial.published),
        trials.len(),
        diverged(|trial| &trial.own),
        OWN.estimator
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The percentages of the moments are truncated (0.0669 is printed as 0.06), to two or three
    /// decimals. Those of the products are rounded to two decimals.
    #[test]
    fn errors_of_table_3_follow_from_its_estimates() {
        const TRUE_KG_M2: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
        /// Truncation or rounding of each percentage.
        const DIGIT_PERCENT: [f64; 6] = [0.01, 0.01, 0.001, 0.005, 0.005, 0.005];
        /// Rounding of an estimate: half a unit of the fourth decimal.
        const HALF_DIGIT_KG_M2: f64 = 0.5e-4;
        for i in 0..6 {
            let error = 100.0 * (ESTIMATED_KG_M2[i] / TRUE_KG_M2[i] - 1.0).abs();
            let rounding = 100.0 * HALF_DIGIT_KG_M2 / TRUE_KG_M2[i] + DIGIT_PERCENT[i];
            assert!((error - ERROR_PERCENT[i]).abs() < rounding, "{}: {error}", ELEMENT_NAMES[i]);
        }
    }
}
