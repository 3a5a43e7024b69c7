//! Page of a Monte Carlo campaign: statistics, and histograms of the errors against the bound.

use maud::html;

use super::{Kind, Page, files, notes, places, section};
use crate::input::ELEMENT_NAMES;
use crate::report::json::McReport;
use crate::report::number::significant;
use crate::report::plots::histogram::{bar_width, histogram, normal_curve};
use crate::report::plots::{Colour, Figure, Mark, Panel, Series};
use crate::report::runs::RunRow;
use crate::report::table;

/// Half the width of a histogram of errors over bound or sigma.
const REACH: f64 = 6.0;
/// Largest NEES of its histogram: exceeded by one consistent run in 2,400, chi-square of six degrees of freedom.
const LARGEST_NEES: f64 = 24.0;

/// The page, and its figures.
pub(in crate::report) fn campaign(
    report: &McReport,
    runs: &[RunRow],
    command: &str,
    all_notes: &[String],
    all_files: &[(&str, &str)],
) -> (String, Vec<Figure>) {
    let figures: Vec<Figure> = [errors(report, runs), sigmas(runs), nees(runs)]
        .into_iter()
        .filter(|figure| !figure.is_empty())
        .collect();
    let title = format!("{}, {}, {} runs", report.scenario, report.estimator, report.runs);
    let body = html! {
        (section("Result", html! { pre .wide { (table::mc(report)) } }))
        (section("Distributions", places(&figures)))
        (notes(all_notes))
        (files(all_files))
    };
    let kind = match report.silent_lies + report.diverged {
        0 => Kind::Good,
        _ if report.used > 0 => Kind::Partial,
        _ => Kind::Bad,
    };
    let verdict = verdict(report);
    let page = Page { title: &title, verdict: &verdict, kind, command, body, figures: &figures };
    (page.html(), figures)
}

/// RMS over the bound, consistency, and the number of wrong results.
fn verdict(report: &McReport) -> String {
    let over_bound = match report.rmse_over_bound_of_all {
        Some(ratio) => format!("RMS error {} times the Cramér-Rao bound", significant(ratio, 3)),
        None => "Not all elements are observed".to_owned(),
    };
    let nees = report.nees_per_dof.map_or(String::new(), |nees| {
        let is_consistent = report.nees_95.is_some_and(|[low, high]| (low..=high).contains(&nees));
        let word = match is_consistent {
            true => "consistent",
            false if nees > 1.0 => "covariance too small",
            false => "covariance too large",
        };
        format!("; NEES {} per degree of freedom, {word}", significant(nees, 3))
    });
    format!(
        "{over_bound}{nees}. Of {} runs, {} diverged and {} report a wrong result as converged.",
        report.runs, report.diverged, report.silent_lies
    )
}

/// Runs in the statistics.
fn used(runs: &[RunRow]) -> impl Iterator<Item = &RunRow> {
    runs.iter().filter(|run| run.shown && !run.diverged)
}

/// Panel of ratios by run, beside the standard normal distribution.
fn ratios(i: usize, ratios: &[f64], reference: &str) -> Panel {
    let normal = normal_curve(1.0, ratios.len() as f64 * bar_width(REACH), REACH);
    Panel::new(format!("runs by {} error", ELEMENT_NAMES[i]))
        .with(Series::bars("runs", Colour::Main, histogram(ratios, REACH)))
        .with(Series::curve(reference, Mark::Line, Colour::Truth, normal))
}

/// Errors over the bound; over the RMS of the bounds where runs differ.
fn errors(report: &McReport, runs: &[RunRow]) -> Figure {
    let panel = |i: usize| {
        let bound = report.bound_kg_m2[i]?;
        let errors: Vec<f64> = used(runs).map(|run| run.error_kg_m2[i] / bound).collect();
        (!errors.is_empty()).then(|| ratios(i, &errors, "normal, at the bound"))
    };
    let panels = (0..6).filter_map(panel).collect();
    Figure::grid("Error over the Cramér-Rao bound", "error / bound", 3, panels)
        .named("data/error-over-bound")
}

/// Errors over the reported sigma of each run.
fn sigmas(runs: &[RunRow]) -> Figure {
    let panel = |i: usize| {
        let errors: Vec<f64> =
            used(runs).map(|run| run.error_kg_m2[i] / run.sigma_kg_m2[i]).collect();
        (!errors.is_empty()).then(|| ratios(i, &errors, "normal, at the reported sigma"))
    };
    let panels = (0..6).filter_map(panel).collect();
    Figure::grid("Error over the reported sigma", "error / sigma", 3, panels)
        .named("data/error-over-sigma")
}

/// NEES of the runs beside chi-square of six degrees of freedom, `x² exp(−x/2) / 16`.
fn nees(runs: &[RunRow]) -> Figure {
    let all: Vec<f64> = used(runs).filter_map(|run| run.nees).collect();
    if all.is_empty() {
        return Figure::stacked("", "", Vec::new());
    }
    // The histogram of a symmetric range, shifted to begin at zero.
    let (reach, shift) = (LARGEST_NEES / 2.0, LARGEST_NEES / 2.0);
    let shifted: Vec<f64> = all.iter().map(|x| x - shift).collect();
    let bars = histogram(&shifted, reach).into_iter();
    let bars = bars.map(|(from, to, height)| (from + shift, to + shift, height)).collect();
    let area = all.len() as f64 * bar_width(reach);
    let density = |k: u32| {
        let x = f64::from(k) * LARGEST_NEES / 100.0;
        (x, area * x * x * (-0.5 * x).exp() / 16.0)
    };
    let panel = Panel::new("runs by NEES").with(Series::bars("runs", Colour::Main, bars)).with(
        Series::curve(
            "chi-square, six degrees of freedom",
            Mark::Line,
            Colour::Truth,
            (0..=100).map(density),
        ),
    );
    Figure::stacked("Normalised estimation error squared", "NEES", vec![panel]).named("data/nees")
}
