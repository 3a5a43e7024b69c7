//! Page of one estimate: of a recorded log, or of a simulated flight with its truth.

use maud::{Markup, html};

use super::hardware::{contributions, hardware};
use super::tensor::{principal_axes, ratios, tensor};
use super::{Kind, Page, events, facts, files, notes, place, places, section, table};
use crate::input::ELEMENT_NAMES;
use crate::report::history::HistoryRow;
use crate::report::json::{ReplayReport, RunReport, Status};
use crate::report::number::significant;
use crate::report::out_dir::Simulated;
use crate::report::plots::{Figure, flight as plots};
use crate::report::verdict;

/// A result, and what was recorded of its way.
pub(in crate::report) struct Flown<'a> {
    /// Heading.
    pub title: &'a str,
    /// Command line that reproduces it.
    pub command: &'a str,
    /// Estimate.
    pub report: &'a ReplayReport,
    /// Comparison with the truth, of a simulated flight.
    pub run: Option<&'a RunReport>,
    /// State after each sample.
    pub history: &'a [HistoryRow],
    /// True motion, of a simulated flight.
    pub simulated: Option<Simulated<'a>>,
    /// Names of the files beside the page and their contents.
    pub files: &'a [(&'a str, &'a str)],
}

/// The page, and its figures.
pub(in crate::report) fn flight(flown: &Flown<'_>) -> (String, Vec<Figure>) {
    let Flown { title, command, report, run, history, .. } = *flown;
    let estimates = estimates(flown);
    let motion = motion(flown);
    let contributions = contributions(report);
    let body = html! {
        (section("Tensor", html! { (tensor(report, run)) (ratios(report)) }))
        (section("Principal moments and axes", principal_axes(report, run)))
        (section("Why", html! {
            (facts(&summary(report)))
            (events::explanations(&report.explanations))
        }))
        (section("Estimates over time", html! { (place(&estimates[0])) }))
        (section("Excitation", html! { (observed(report, history)) (place(&estimates[1])) }))
        (section("Hardware", hardware(report, &contributions)))
        (section("Rejected samples, restarts and changes", events::events(report)))
        (section("Rates and residuals", places(&motion)))
        (notes(&report.notes))
        (files(flown.files))
    };
    let verdict = match run {
        Some(run) => verdict::of_run(run, history),
        None => verdict::of_estimate(report, history),
    };
    let all: Vec<Figure> = estimates.into_iter().chain([contributions]).chain(motion).collect();
    let figures: Vec<Figure> = all.into_iter().filter(|figure| !figure.is_empty()).collect();
    let kind = match report.status {
        Status::Converged if report.residuals_white == Some(false) || !report.physical => {
            Kind::Partial
        }
        Status::Converged => Kind::Good,
        Status::Partial => Kind::Partial,
        Status::Unobservable | Status::Diverged => Kind::Bad,
    };
    let page = Page { title, verdict: &verdict, kind, command, body, figures: &figures };
    (page.html(), figures)
}

/// Facts on the estimate.
fn summary(report: &ReplayReport) -> Vec<(&'static str, String)> {
    let vector = |v: &[f64; 3]| v.map(|x| significant(x, 3)).join(", ");
    let white = match report.residuals_white {
        None => "not tested",
        Some(true) => "white: the model explains the data",
        Some(false) => "not white: an effect outside the model",
    };
    let scale = if report.scale_observed { "scale observed" } else { "scale not observed" };
    let mut facts = vec![
        ("status", report.status.to_string()),
        ("estimator", format!("{}, {}", report.estimator, report.precision)),
        ("observed", format!("{} of 6 directions, {scale}", report.observed_directions)),
        ("residuals", format!("{} rad/s RMS, {white}", significant(report.residual_rms_rad_s, 4))),
    ];
    facts.extend(
        report
            .disturbance_torque_n_m
            .map(|t| ("disturbance torque", format!("{} N m", vector(&t)))),
    );
    facts.extend(report.gyro_bias_rad_s.map(|b| ("gyro bias", format!("{} rad/s", vector(&b)))));
    facts
}

/// Figures of the tensor: estimates, and their sigma.
fn estimates(flown: &Flown<'_>) -> [Figure; 2] {
    let truth = flown.simulated.map(|simulated| simulated.flight.instants.as_slice());
    let title = "Elements of the tensor; the vertical scale is that of the last three quarters";
    [
        plots::inertia(title, flown.history, truth, &plots::ALL_ELEMENTS).named("data/inertia"),
        plots::sigmas("Sigma of each element", flown.history).named("data/sigma"),
    ]
}

/// Figures of rates, residuals and, of a simulated flight, the true motion.
fn motion(flown: &Flown<'_>) -> Vec<Figure> {
    let history = flown.history;
    let truth = flown.simulated.map(|simulated| simulated.flight.instants.as_slice());
    let mut figures = vec![
        plots::innovations("Residuals: measured minus predicted rate", history)
            .named("data/innovations"),
        plots::rates("Body rate", history).named("data/rates"),
    ];
    if history.iter().any(|row| row.acceleration.is_some()) {
        let accelerations = plots::accelerations("Angular acceleration", history, truth);
        figures.push(accelerations.named("data/accelerations"));
    }
    let Some(Simulated { flight, craft, .. }) = flown.simulated else { return figures };
    let truth = &flight.instants;
    figures.push(plots::rate_errors("Error of the rate", history, truth).named("data/rate-errors"));
    let wheels = plots::wheel_speeds("Wheel speeds", truth);
    figures.extend(wheels.map(|figure| figure.named("data/wheel-speeds")));
    let torque = plots::control_torque("Torque of the wheels on the body", truth, &craft.wheels);
    figures.extend(torque.map(|figure| figure.named("data/control-torque")));
    figures.push(plots::euler_angles("Attitude", truth).named("data/attitude"));
    figures
}

/// Shares of the mean moment that the sigma of an element falls below.
const LEVELS_PERCENT: [f64; 3] = [10.0, 1.0, 0.1];

/// Times at which the sigma of each element fell below shares of the mean moment, for good.
fn observed(report: &ReplayReport, history: &[HistoryRow]) -> Markup {
    let mean = report.elements_kg_m2()[..3].iter().sum::<f64>() / 3.0;
    if history.is_empty() || !(mean.is_finite() && mean > 0.0) {
        return html! {};
    }
    let row = |i: usize| {
        let since = |percent: &f64| {
            let is_above = |row: &HistoryRow| {
                row.sigma_kg_m2[i].is_nan() || row.sigma_kg_m2[i] > percent / 100.0 * mean
            };
            let first = history.iter().rposition(is_above).map_or(0, |last| last + 1);
            history.get(first).map_or("never".to_owned(), |row| significant(row.time_s, 3))
        };
        let observed = if report.element_observed[i] { "yes" } else { "no" };
        let mut cells = vec![ELEMENT_NAMES[i].to_owned(), observed.to_owned()];
        cells.extend(LEVELS_PERCENT.iter().map(since));
        cells
    };
    html! {
        p { "Time in s from which the sigma of an element stays below a share of the mean moment." }
        (table(&["element", "observed", "10 %", "1 %", "0.1 %"], &(0..6).map(row).collect::<Vec<_>>()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::json::examples;

    #[test]
    fn page_of_a_log_without_history_has_its_tables_and_no_plot_but_the_hardware() {
        let report = examples::with_hardware();
        let flown = Flown {
            title: "log.csv",
            command: "host-sim replay",
            report: &report,
            run: None,
            history: &[],
            simulated: None,
            files: &[("result.json", "the result")],
        };
        let (html, figures) = flight(&flown);
        assert_eq!(figures.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["data/hardware"]);
        for words in [
            "limited by the wheel spin inertia",
            "14.2010",
            "2 spike, 1 stuck",
            "href=\"result.json\"",
        ] {
            assert!(html.contains(words), "{words}");
        }
    }

    #[test]
    fn page_of_a_run_has_truth_and_errors() {
        let run = examples::run();
        let flown = Flown {
            title: "stsat3-spin-up",
            command: "host-sim run",
            report: &run.estimate,
            run: Some(&run),
            history: &[],
            simulated: None,
            files: &[],
        };
        let (html, _) = flight(&flown);
        for words in [
            "<th>error/σ</th>",
            "<th>error/bound</th>",
            "<th>axis off by</th>",
            "The largest error",
        ] {
            assert!(html.contains(words), "{words}");
        }
    }
}
