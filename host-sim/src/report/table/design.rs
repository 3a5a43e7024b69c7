//! Tables of `design`: accuracy before and after, standard manoeuvres, limits; and of a trade.

use super::cells::{DIGITS, EMPTY, heading, short};
use crate::input::ELEMENT_NAMES;
use crate::manoeuvre::{Trade, TradeRow};
use crate::report::columns::Columns;
use crate::report::json::DesignReport;
use crate::report::number::significant;

/// Standard manoeuvres in the table.
const SHOWN: usize = 5;

/// Table of a design.
pub fn design(report: &DesignReport) -> String {
    let criterion = report.optimality.to_uppercase();
    let mut text = [
        heading("manoeuvre of", &report.scenario),
        heading("duration", &format!("{} s", report.duration_s)),
        heading("criterion", &format!("{criterion}, errors of the hardware {}", report.hardware)),
        "\n".to_owned(),
        elements(report),
        "\n".to_owned(),
        axes(report),
    ]
    .concat();
    let observed: Vec<String> =
        report.observed_s.iter().map(|time_s| short(*time_s, EMPTY)).collect();
    text += "\n";
    text += &heading("observed after", &format!("{} s", observed.join(", ")));
    let hardware = hardware_share(report);
    text += &heading("hardware", &format!("{:.0} % of the variance", 100.0 * hardware));
    let rate = significant(report.peak_rate_rad_s.to_degrees(), DIGITS);
    text += &heading("peak rate", &format!("{rate} deg/s"));
    if !report.thruster_on_s.is_empty() {
        let rate = significant(report.end_rate_rad_s.to_degrees(), DIGITS);
        text += &heading("rate at the end", &format!("{rate} deg/s at most"));
    }
    text += &heading("gain", &gain(report));
    text += "\n";
    text += &fixed(report);
    text += "\n";
    text += &limits(report);
    if !report.thruster_on_s.is_empty() {
        text += "\n";
        text += &thrusters(report);
    }
    text
}

/// Share of considered errors of the hardware in the sum of the variances.
fn hardware_share(report: &DesignReport) -> f64 {
    let sum = |sigma: &[f64; 6]| sigma.iter().map(|s| s * s).sum::<f64>();
    1.0 - sum(&report.sigma_random_kg_m2) / sum(&report.sigma_kg_m2)
}

fn gain(report: &DesignReport) -> String {
    match report.fixed.first() {
        Some(best) if report.gain.is_finite() => {
            format!("{} times over {}", significant(report.gain, DIGITS), best.name)
        }
        _ => "no standard manoeuvre observes the inertia".to_owned(),
    }
}

fn elements(report: &DesignReport) -> String {
    let mut table = Columns::new(&[
        ("element", ""),
        ("expected", "kg m²"),
        ("sigma before", "kg m²"),
        ("after", "kg m²"),
        ("before", "%"),
        ("after", "%"),
    ]);
    for (i, name) in ELEMENT_NAMES.iter().enumerate() {
        let expected = report.inertia_kg_m2[i];
        let percent = |sigma: f64| (expected != 0.0).then(|| 100.0 * sigma / expected.abs());
        let before = report.sigma_before_kg_m2.map(|sigma| sigma[i]);
        let after = report.sigma_kg_m2[i];
        table.row([
            (*name).to_owned(),
            significant(expected, 4),
            short(before, EMPTY),
            significant(after, DIGITS),
            short(before.and_then(percent), EMPTY),
            short(percent(after), EMPTY),
        ]);
    }
    table.finish()
}

fn axes(report: &DesignReport) -> String {
    let mut table = Columns::new(&[("principal axis", ""), ("before", "deg"), ("after", "deg")]);
    for (i, name) in ["of the least moment", "of the middle moment", "of the largest moment"]
        .into_iter()
        .enumerate()
    {
        let [before, after] =
            [report.axes_before_deg, report.axes_deg].map(|axes| short(axes[i], EMPTY));
        table.row([name.to_owned(), before, after]);
    }
    table.finish()
}

fn fixed(report: &DesignReport) -> String {
    let mut table =
        Columns::new(&[("manoeuvre within the same limits", ""), ("sigma / design", "")]);
    let tuned = report.tuned.iter().map(|row| (format!("{} (tuned)", row.name), row));
    let standard = report.fixed.iter().take(SHOWN).map(|row| (row.name.clone(), row));
    for (name, row) in standard.chain(tuned) {
        table.row([name, significant(row.sigma_over_design, DIGITS)]);
    }
    table.finish()
}

fn limits(report: &DesignReport) -> String {
    let mut table = Columns::new(&[("limit", ""), ("used", "%"), ("limits by", "%")]);
    for row in &report.limits {
        let percent = |share: f64| format!("{:.0}", 100.0 * share);
        table.row([row.limit.to_owned(), percent(row.used), percent(row.share)]);
    }
    table.finish()
}

fn thrusters(report: &DesignReport) -> String {
    let mut table = Columns::new(&[("thruster", ""), ("pulses", ""), ("on", "s")]);
    for (number, pulses) in (1..).zip(&report.thruster_on_s) {
        let on_s: f64 = pulses.iter().map(|[on, off]| off - on).sum();
        table.row([format!("{number}"), pulses.len().to_string(), significant(on_s, DIGITS)]);
    }
    table.finish()
}

/// Table of a trade.
pub fn trade(quantity: Trade, rows: &[TradeRow]) -> String {
    let mut table = Columns::new(&[
        (quantity.name(), quantity.unit()),
        ("sigma", "%"),
        ("gain", ""),
        ("best standard", ""),
        ("limited by", ""),
    ]);
    for row in rows {
        table.row([
            significant(row.value, DIGITS),
            significant(row.sigma_percent, DIGITS),
            significant(row.gain, DIGITS),
            row.best_fixed.clone().unwrap_or_else(|| EMPTY.to_owned()),
            row.limited_by.to_owned(),
        ]);
    }
    table.finish()
}
