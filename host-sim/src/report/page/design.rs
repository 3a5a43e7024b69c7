//! Page of a design: accuracy, limits, the manoeuvre over time beside the best standard one; and of a trade.

use maud::html;

use super::{Kind, Page, files, notes, places, section};
use crate::input::ELEMENT_NAMES;
use crate::manoeuvre::{SeriesRow, Trade, TradeRow};
use crate::report::json::DesignReport;
use crate::report::number::significant;
use crate::report::plots::{Colour, Figure, Mark, Panel, Series};
use crate::report::table;

/// A manoeuvre over time.
type Rows<'a> = &'a [SeriesRow];

/// The page, and its figures; `standard` is the best standard manoeuvre over time, empty without one.
pub(in crate::report) fn design(
    report: &DesignReport,
    (designed, standard): (Rows<'_>, Rows<'_>),
    command: &str,
    all_notes: &[String],
    all_files: &[(&str, &str)],
) -> (String, Vec<Figure>) {
    let figures: Vec<Figure> =
        [accuracy(report, designed, standard), wheels(designed), pointing(designed, standard)]
            .into_iter()
            .filter(|figure| !figure.is_empty())
            .collect();
    let title = format!("Manoeuvre of {}, {} s", report.scenario, report.duration_s);
    let body = html! {
        (section("Result", html! { pre .wide { (table::design(report)) } }))
        (section("Over time", places(&figures)))
        (notes(all_notes))
        (files(all_files))
    };
    let is_observed = report.observed_s.iter().all(Option::is_some);
    let kind = if is_observed { Kind::Good } else { Kind::Partial };
    let verdict = verdict(report);
    let page = Page { title: &title, verdict: &verdict, kind, command, body, figures: &figures };
    (page.html(), figures)
}

/// Accuracy of the moments, gain, and the limit that counts most.
fn verdict(report: &DesignReport) -> String {
    let percent = (0..3).map(|i| 100.0 * report.sigma_kg_m2[i] / report.inertia_kg_m2[i].abs());
    let percent = significant(percent.fold(0.0, f64::max), 3);
    let observed = report.observed_s.iter().flatten().count();
    let shown = match observed {
        6 => format!("The moments to {percent} % or better, one sigma"),
        _ => format!(
            "{observed} of 6 directions are observed; the moments to {percent} %, one sigma"
        ),
    };
    let gain = report
        .fixed
        .first()
        .filter(|_| report.gain.is_finite())
        .map_or("no standard manoeuvre observes the inertia".to_owned(), |best| {
            format!("{} times better than {}", significant(report.gain, 3), best.name)
        });
    let limit =
        report.limits.first().map_or(String::new(), |row| format!("; limited by {}", row.limit));
    format!("{shown}: {gain}{limit}.")
}

fn curve<'a>(
    name: &str,
    colour: Colour,
    rows: Rows<'a>,
    value: impl Fn(&'a SeriesRow) -> f64,
) -> Series {
    Series::curve(name, Mark::Line, colour, rows.iter().map(|row| (row.time_s, value(row))))
}

/// One sigma of each element over time, by the samples before that time.
fn accuracy(report: &DesignReport, designed: Rows<'_>, standard: Rows<'_>) -> Figure {
    let sigma =
        |i: usize| move |row: &SeriesRow| row.sigma_kg_m2.map_or(f64::NAN, |sigma| sigma[i]);
    let name = report.fixed.first().map_or("", |best| &best.name);
    let panel = |(i, element): (usize, &&str)| {
        Panel::new(format!("sigma of {element}, kg m²"))
            .logarithmic()
            .with(curve(name, Colour::Light, standard, sigma(i)))
            .with(curve("design", Colour::Main, designed, sigma(i)))
    };
    let panels = ELEMENT_NAMES.iter().enumerate().map(panel).collect();
    Figure::grid("One sigma of each element", "time, s", 3, panels).named("data/sigma")
}

/// A panel with a curve for each of several components.
fn components<'a>(
    label: &str,
    rows: Rows<'a>,
    names: &[String],
    value: impl Fn(&'a SeriesRow, usize) -> Option<f64> + Copy,
) -> Panel {
    names.iter().enumerate().fold(Panel::new(label), |panel, (i, name)| {
        let colour = Colour::ALL[i % Colour::ALL.len()];
        panel.with(curve(name, colour, rows, |row| value(row, i).unwrap_or(f64::NAN)))
    })
}

/// Torque and speed of each wheel.
fn wheels(designed: Rows<'_>) -> Figure {
    let count = designed.first().map_or(0, |row| row.torque_n_m.len());
    let names: Vec<String> = (1..=count).map(|wheel| format!("wheel {wheel}")).collect();
    let torque =
        components("torque, N m", designed, &names, |row, i| row.torque_n_m.get(i).copied());
    let speed = components("speed, rad/s", designed, &names, |row, i| {
        row.wheel_speed_rad_s.get(i).copied()
    });
    Figure::stacked("Wheels", "time, s", vec![torque, speed]).named("data/wheels")
}

/// Body rate, and rotation from the attitude of the start.
fn pointing(designed: Rows<'_>, standard: Rows<'_>) -> Figure {
    let axes = ["x", "y", "z"].map(str::to_owned);
    let rate =
        components("body rate, rad/s", designed, &axes, |row, i| row.rate_rad_s.get(i).copied());
    let degrees = |row: &SeriesRow| row.excursion_rad.to_degrees();
    let excursion = Panel::new("excursion, deg")
        .with(curve("best standard manoeuvre", Colour::Light, standard, degrees))
        .with(curve("design", Colour::Main, designed, degrees));
    Figure::stacked("Body", "time, s", vec![rate, excursion]).named("data/body")
}

/// The page of a trade, and its figure.
pub(in crate::report) fn trade(
    scenario: &str,
    quantity: Trade,
    rows: &[TradeRow],
    command: &str,
    all_files: &[(&str, &str)],
) -> (String, Vec<Figure>) {
    let label = format!("{}, {}", quantity.name(), quantity.unit());
    let points = |value: fn(&TradeRow) -> f64| rows.iter().map(move |row| (row.value, value(row)));
    let sigma = Panel::new("sigma, %").logarithmic().with(Series::curve(
        "design",
        Mark::Line,
        Colour::Main,
        points(|row| row.sigma_percent),
    ));
    let gain = Panel::new("gain over the best standard manoeuvre").with(Series::curve(
        "gain",
        Mark::Line,
        Colour::Main,
        points(|row| row.gain),
    ));
    let figures =
        vec![Figure::stacked("Accuracy and gain", &label, vec![sigma, gain]).named("data/trade")];
    let title = format!("Trade of {scenario} over {}", quantity.name());
    let body = html! {
        (section("Designs", html! { pre .wide { (table::trade(quantity, rows)) } }))
        (section("Over the range", places(&figures)))
        (files(all_files))
    };
    let verdict = match (rows.first(), rows.last()) {
        (Some(first), Some(last)) => {
            let at = |row: &TradeRow| {
                let (sigma, value) = (significant(row.sigma_percent, 3), significant(row.value, 3));
                format!("{sigma} % at {value} {}", quantity.unit())
            };
            format!("Sigma from {} to {}.", at(first), at(last))
        }
        _ => "No design is complete.".to_owned(),
    };
    let kind = Kind::Good;
    let page = Page { title: &title, verdict: &verdict, kind, command, body, figures: &figures };
    (page.html(), figures)
}
