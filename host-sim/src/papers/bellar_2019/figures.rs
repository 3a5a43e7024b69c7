//! Figures 1 to 8 of \[Bellar2019\].

use super::trial::{Bellar2019, Bellar2019Trial, CAMPAIGN, CHECKED_EVERY, PUBLISHED};
use crate::campaign::Verdict;
use crate::input::ELEMENT_NAMES;
use crate::papers::case::OWN;
use crate::papers::paper::{Paper, PapersFailed};
use crate::papers::rank_test::{TIME_CONSTANT_S, rank_of_observability_matrix};
use crate::report::plots::histogram::{bar_width, histogram, normal_curve};
use crate::report::plots::{Colour, Figure, Mark, Panel, Series, flight};
use crate::report::published::PaperFigure;

/// Half the width of a histogram, in bounds.
const HISTOGRAM_BOUNDS: f64 = 8.0;

impl Bellar2019 {
    /// Figures 1 to 6 of the first seed, 7 and 8 of all trials.
    pub(super) fn all_figures(
        &self,
        first_seed: u64,
        trials: &[Bellar2019Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        let (_, history) = self.case.history(PUBLISHED, first_seed)?;
        let truth = &self.case.flight.instants;
        let title = |quantity: &str, number: &str| {
            format!("{quantity}, joint-ekf-published, seed {first_seed} ([Bellar2019] {number})")
        };
        let rates = flight::rates(&title("Estimated rate", "Fig. 2"), &history);
        let errors = flight::rate_errors(&title("Error of the rate", "Fig. 3"), &history, truth);
        let variances = title("Variance of the rate", "Fig. 4");
        let variances = flight::rate_variances(&variances, &history);
        let estimates = |quantity: &str, number: &str, elements: &[usize]| {
            flight::inertia(&title(quantity, number), &history, Some(truth), elements)
        };
        Ok(vec![
            Self::figure("figure-1", self.ranks()),
            Self::figure("figure-2", rates),
            Self::figure("figure-3", errors),
            Self::figure("figure-4", variances),
            Self::figure("figure-5", estimates("Moments of inertia", "Fig. 5", &[0, 1, 2])),
            Self::figure("figure-6", estimates("Products of inertia", "Fig. 6", &[3, 4, 5])),
            Self::figure("figure-7", self.histograms("Fig. 7", 0..3, trials)),
            Self::figure("figure-8", self.histograms("Fig. 8", 3..6, trials)),
        ])
    }

    /// Rank of the observability matrix over the true motion.
    fn ranks(&self) -> Figure {
        let scenario = &self.case.scenario;
        let ranks = |time_constant_s: [f64; 6]| {
            let instants = self.case.flight.instants.iter().step_by(CHECKED_EVERY);
            instants.map(move |instant| {
                let rank = rank_of_observability_matrix(
                    self.case.truth_kg_m2(),
                    &time_constant_s,
                    &instant.rate_rad_s,
                    &instant.torque_n_m,
                );
                (instant.time_us as f64 * 1e-6, rank as f64)
            })
        };
        let equal = ranks([TIME_CONSTANT_S[0]; 6]);
        let full = [(0.0, 9.0), (scenario.duration_s, 9.0)];
        let panel = Panel::new("rank of the observability matrix")
            .with(Series::curve("one time constant for all", Mark::Line, Colour::Other, equal))
            .with(Series::curve("as printed", Mark::Wide, Colour::Main, ranks(TIME_CONSTANT_S)))
            .with(Series::curve("published: 9", Mark::Dashes, Colour::Truth, full))
            .span(0.0, 10.0);
        let title =
            "Rank of the observability matrix at the true motion ([Bellar2019] Fig. 1, Eq. 23)";
        Figure::stacked(title, "time, s", vec![panel])
    }

    /// Distribution of the errors over the runs of the campaign, beside the normal distribution at
    /// the bound.
    fn histograms(
        &self,
        number: &str,
        elements: std::ops::Range<usize>,
        trials: &[Bellar2019Trial],
    ) -> Figure {
        let typical = self.truths.typical(trials.iter().map(|trial| trial.campaign[0].reference));
        let panel = |i: usize| {
            let bound_percent =
                typical.bound_kg_m2[i].map_or(1.0, |b| 100.0 * b / typical.truth_kg_m2[i].abs());
            let reach = HISTOGRAM_BOUNDS * bound_percent;
            let errors = |method: usize| -> Vec<f64> {
                let scores = trials.iter().map(|trial| &trial.campaign[method].score);
                let percent = |error: f64, found: f64| 100.0 * error / (found - error);
                scores.map(|s| percent(s.error_kg_m2[i], s.inertia_kg_m2[i])).collect()
            };
            let bars = |method| histogram(&errors(method), reach);
            let width = bar_width(reach);
            let normal = normal_curve(bound_percent, trials.len() as f64 * width, reach);
            let own = format!("{}, {}", OWN.estimator, OWN.precision);
            Panel::new(format!("runs by {} error", ELEMENT_NAMES[i]))
                .with(Series::bars("joint-ekf-published, f64", Colour::Main, bars(0)))
                .with(Series::bars(&own, Colour::Light, bars(CAMPAIGN.len() - 1)))
                .with(Series::curve("at the bound", Mark::Line, Colour::Truth, normal))
        };
        let diverged = |method: usize| {
            let verdicts = trials.iter().map(|trial| trial.campaign[method].score.verdict);
            verdicts.filter(|verdict| *verdict == Verdict::Diverged).count()
        };
        let title = format!(
            "Errors of {} runs ([Bellar2019] {number}); diverged, mostly beyond the scale: {} as \
             printed, {} {}",
            trials.len(),
            diverged(0),
            diverged(CAMPAIGN.len() - 1),
            OWN.estimator
        );
        Figure::grid(title, "error, % of the true element", 3, elements.map(panel).collect())
    }
}
