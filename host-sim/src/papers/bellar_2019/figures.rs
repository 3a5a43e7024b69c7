//! The figures of \[Bellar2019\].

use super::{CAMPAIGN, LOOKED_AT_EVERY, OWN, PAPER, PUBLISHED, Run, Study};
use crate::campaign::Verdict;
use crate::input::ELEMENT_NAMES;
use crate::papers::observability::{TIME_CONSTANT_S, rank_of_observability_matrix};
use crate::papers::{PapersFailed, figure};
use crate::report::papers_dir::PaperFigure;
use crate::report::plots::{Colour, Figure, Mark, Panel, PlotError, Series, flight};

/// Reach of a histogram to either side, in bounds.
const HISTOGRAM_BOUNDS: f64 = 8.0;
const HISTOGRAM_BARS: usize = 48;

impl Study {
    /// The figures of the paper: 1 to 6 of the first seed, 7 and 8 of all runs.
    pub fn figures(&self, seed: u64, runs: &[Run]) -> Result<Vec<PaperFigure>, PapersFailed> {
        let (_, history) = self.course.history(PUBLISHED, seed)?;
        let truth = &self.course.flight.instants;
        let by = |what: &str, number: &str| {
            format!("{what}, joint-ekf-published, seed {seed} ([Bellar2019] {number})")
        };
        let rates = flight::rates(&by("Estimated rate", "Fig. 2"), &history)?;
        let errors = flight::rate_errors(&by("Error of the rate", "Fig. 3"), &history, truth)?;
        let variances = flight::rate_variances(&by("Variance of the rate", "Fig. 4"), &history)?;
        let estimates = |what: &str, number: &str, elements: &[usize]| {
            flight::inertia(&by(what, number), &history, Some(truth), elements)
        };
        Ok(vec![
            figure(PAPER, "figure-1.svg", self.ranks()?),
            figure(PAPER, "figure-2.svg", rates),
            figure(PAPER, "figure-3.svg", errors),
            figure(PAPER, "figure-4.svg", variances),
            figure(PAPER, "figure-5.svg", estimates("Moments of inertia", "Fig. 5", &[0, 1, 2])?),
            figure(PAPER, "figure-6.svg", estimates("Products of inertia", "Fig. 6", &[3, 4, 5])?),
            figure(PAPER, "figure-7.svg", self.histograms("Fig. 7", 0..3, runs)?),
            figure(PAPER, "figure-8.svg", self.histograms("Fig. 8", 3..6, runs)?),
        ])
    }

    fn ranks(&self) -> Result<String, PlotError> {
        let scenario = &self.course.scenario;
        let ranks = |time_constant_s: [f64; 6]| {
            let instants = self.course.flight.instants.iter().step_by(LOOKED_AT_EVERY);
            instants.map(move |instant| {
                let rank = rank_of_observability_matrix(
                    self.course.truth_kg_m2(),
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
        Figure::stacked(title, "time, s", vec![panel]).draw()
    }

    fn histograms(
        &self,
        number: &str,
        elements: std::ops::Range<usize>,
        runs: &[Run],
    ) -> Result<String, PlotError> {
        let typical = self.truths.typical(runs.iter().map(|run| run.campaign[0].reference));
        let panel = |i: usize| {
            let bound_percent =
                typical.bound_kg_m2[i].map_or(1.0, |b| 100.0 * b / typical.truth_kg_m2[i].abs());
            let reach = HISTOGRAM_BOUNDS * bound_percent;
            let errors = |which: usize| -> Vec<f64> {
                let scores = runs.iter().map(|run| &run.campaign[which].score);
                let percent = |error: f64, found: f64| 100.0 * error / (found - error);
                scores.map(|s| percent(s.error_kg_m2[i], s.inertia_kg_m2[i])).collect()
            };
            let bars = |which| histogram(&errors(which), reach);
            let width = 2.0 * reach / HISTOGRAM_BARS as f64;
            let normal = normal_curve(bound_percent, runs.len() as f64 * width, reach);
            let own = format!("{}, {}", OWN.estimator, OWN.precision);
            Panel::new(format!("runs by {} error", ELEMENT_NAMES[i]))
                .with(Series::bars("joint-ekf-published, f64", Colour::Main, bars(0)))
                .with(Series::bars(&own, Colour::Light, bars(CAMPAIGN.len() - 1)))
                .with(Series::curve("at the bound", Mark::Line, Colour::Truth, normal))
        };
        let beyond = |which: usize| {
            let is_diverged = |run: &&Run| run.campaign[which].score.verdict == Verdict::Diverged;
            runs.iter().filter(is_diverged).count()
        };
        let title = format!(
            "Errors of {} runs ([Bellar2019] {number}); diverged, mostly beyond the scale: {} as \
             printed, {} {}",
            runs.len(),
            beyond(0),
            beyond(CAMPAIGN.len() - 1),
            OWN.estimator
        );
        Figure::grid(title, "error, % of the true element", 3, elements.map(panel).collect()).draw()
    }
}

/// How many of the values fall into each of the bars from `−reach` to `reach`.
fn histogram(values: &[f64], reach: f64) -> Vec<(f64, f64, f64)> {
    let width = 2.0 * reach / HISTOGRAM_BARS as f64;
    let edge = |bar: usize| -reach + bar as f64 * width;
    let is_in = |value: f64, bar: usize| (edge(bar)..edge(bar + 1)).contains(&value);
    let height = |bar: usize| values.iter().filter(|value| is_in(**value, bar)).count() as f64;
    (0..HISTOGRAM_BARS).map(|bar| (edge(bar), edge(bar + 1), height(bar))).collect()
}

/// The normal distribution of this sigma and area, from `−reach` to `reach`.
fn normal_curve(sigma: f64, area: f64, reach: f64) -> Vec<(f64, f64)> {
    const POINTS: i32 = 100;
    let peak = area / (sigma * (2.0 * std::f64::consts::PI).sqrt());
    let x = |k: i32| reach * f64::from(k) / f64::from(POINTS);
    (-POINTS..=POINTS).map(|k| (x(k), peak * (-0.5 * (x(k) / sigma).powi(2)).exp())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histogram_counts_what_is_within_reach() {
        let bars = histogram(&[0.0, 0.01, -7.99, 8.0, f64::NAN, 100.0], 8.0);
        assert_eq!(bars.iter().map(|bar| bar.2).sum::<f64>(), 3.0);
        assert_eq!((bars[0].0, bars[0].2), (-8.0, 1.0));
        assert_eq!(bars[HISTOGRAM_BARS / 2].2, 2.0);
    }

    #[test]
    fn normal_curve_has_its_area() {
        let curve = normal_curve(0.5, 200.0, 8.0);
        let area: f64 = curve.windows(2).map(|p| (p[1].0 - p[0].0) * (p[0].1 + p[1].1) / 2.0).sum();
        assert!((area - 200.0).abs() < 0.5, "{area}");
    }
}
