//! Page of a Monte Carlo campaign: statistics, and histograms of the errors against the bound.

use maud::html;

use super::{Kind, Page, files, notes, places, section};
use crate::campaign::{Score, Verdict};
use crate::input::ELEMENT_NAMES;
use crate::report::json::McReport;
use crate::report::number::significant;
use crate::report::plots::histogram::{Histogram, bar_width, normal_curve};
use crate::report::plots::{Colour, Figure, Mark, Panel, Series};
use crate::report::table;

/// Half the width of a histogram of errors over bound or sigma.
const REACH: f64 = 6.0;
/// Largest NEES of its histogram: exceeded by one consistent run in 2,400, chi-square of six degrees of freedom.
const LARGEST_NEES: f64 = 24.0;

/// Distributions of the runs, filled one run at a time.
pub(in crate::report) struct Distributions {
    bound_kg_m2: [Option<f64>; 6],
    over_bound: [Histogram; 6],
    over_sigma: [Histogram; 6],
    nees: Histogram,
}

impl Distributions {
    /// Empty distributions of the runs of a report.
    pub fn new(report: &McReport) -> Self {
        let ratios = || std::array::from_fn(|_| Histogram::new(REACH));
        Self {
            bound_kg_m2: report.measure().bound_kg_m2,
            over_bound: ratios(),
            over_sigma: ratios(),
            nees: Histogram::new(LARGEST_NEES / 2.0),
        }
    }

    /// Adds a run, if it is in the statistics.
    pub fn add(&mut self, score: &Score) {
        if matches!(score.verdict, Verdict::Diverged | Verdict::Unobserved) {
            return;
        }
        for i in 0..6 {
            let error_kg_m2 = score.error_kg_m2[i];
            if let Some(bound_kg_m2) = self.bound_kg_m2[i] {
                self.over_bound[i].add(error_kg_m2 / bound_kg_m2);
            }
            self.over_sigma[i].add(error_kg_m2 / score.sigma_kg_m2[i]);
        }
        if let Some(nees) = score.nees {
            // A symmetric range, shifted to begin at zero.
            self.nees.add(nees - LARGEST_NEES / 2.0);
        }
    }
}

/// The page, and its figures.
pub(in crate::report) fn campaign(
    report: &McReport,
    runs: &Distributions,
    command: &str,
    all_notes: &[String],
    all_files: &[(&str, &str)],
) -> (String, Vec<Figure>) {
    let figures: Vec<Figure> = [errors(runs), sigmas(runs), nees(&runs.nees)]
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
    let measure = report.measure();
    let over_bound = match measure.rmse_over_bound_of_all {
        Some(ratio) => {
            let ratio = significant(ratio, 3);
            format!("RMS error {ratio} times the Cramér-Rao bound{}", measure.of)
        }
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

/// Panel of ratios by run, beside the standard normal distribution.
fn ratios(i: usize, ratios: &Histogram, reference: &str) -> Option<Panel> {
    let values = ratios.values();
    let normal = normal_curve(1.0, values as f64 * bar_width(REACH), REACH);
    let panel = Panel::new(format!("runs by {} error", ELEMENT_NAMES[i]))
        .with(Series::bars("runs", Colour::Main, ratios.bars()))
        .with(Series::curve(reference, Mark::Line, Colour::Truth, normal));
    (values > 0).then_some(panel)
}

/// Errors over the bound; over the RMS of the bounds where runs differ.
fn errors(runs: &Distributions) -> Figure {
    let panel = |i: usize| ratios(i, &runs.over_bound[i], "normal, at the bound");
    let panels = (0..6).filter_map(panel).collect();
    Figure::grid("Error over the Cramér-Rao bound", "error / bound", 3, panels)
        .named("data/error-over-bound")
}

/// Errors over the reported sigma of each run.
fn sigmas(runs: &Distributions) -> Figure {
    let panel = |i: usize| ratios(i, &runs.over_sigma[i], "normal, at the reported sigma");
    let panels = (0..6).filter_map(panel).collect();
    Figure::grid("Error over the reported sigma", "error / sigma", 3, panels)
        .named("data/error-over-sigma")
}

/// NEES of the runs beside chi-square of six degrees of freedom, `x² exp(−x/2) / 16`.
fn nees(all: &Histogram) -> Figure {
    if all.values() == 0 {
        return Figure::stacked("", "", Vec::new());
    }
    let (reach, shift) = (LARGEST_NEES / 2.0, LARGEST_NEES / 2.0);
    let bars = all.bars().into_iter();
    let bars = bars.map(|(from, to, height)| (from + shift, to + shift, height)).collect();
    let area = all.values() as f64 * bar_width(reach);
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
