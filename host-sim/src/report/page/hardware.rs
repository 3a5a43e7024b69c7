//! Errors of the hardware: what was stated, what the data made of it, and what is left in the tensor.

use maud::{Markup, html};

use super::{place, table};
use crate::estimation::squared_norm;
use crate::report::json::{HardwareResult, ReplayReport};
use crate::report::number::significant;
use crate::report::plots::{Colour, Figure, Panel, Series};
use crate::report::table::in_words;

/// Contribution of each kind of error to the systematic sigma of the tensor.
pub(super) fn contributions(report: &ReplayReport) -> Figure {
    let kinds = kinds(report);
    let tensor = squared_norm(&report.elements_kg_m2());
    let percent = |squares: f64| 100.0 * (squares / tensor).sqrt();
    let bar = |(place, (_, squares)): (usize, &(String, f64))| {
        let middle = place as f64;
        (middle - 0.35, middle + 0.35, percent(*squares))
    };
    let bars = kinds.iter().enumerate().map(bar).collect();
    let names: Vec<&str> = kinds.iter().map(|(name, _)| name.as_str()).collect();
    let panel = Panel::new("systematic sigma, % of the tensor")
        .categories(&names)
        .with(Series::bars("by kind of error", Colour::Main, bars));
    Figure::stacked("Contributions of the hardware", "", vec![panel]).named("data/hardware")
}

/// Kinds of errors and the squared norm of the shift by one sigma of what the data leave, largest first.
fn kinds(report: &ReplayReport) -> Vec<(String, f64)> {
    let mut kinds: Vec<(String, f64)> = Vec::new();
    for parameter in &report.hardware {
        let squares = squared_norm(&parameter.effect_kg_m2);
        if !squares.is_finite() || squares == 0.0 {
            continue;
        }
        match kinds.iter_mut().find(|(kind, _)| *kind == parameter.kind) {
            Some((_, sum)) => *sum += squares,
            None => kinds.push((parameter.kind.clone(), squares)),
        }
    }
    kinds.sort_by(|a, b| b.1.total_cmp(&a.1));
    kinds
}

/// Table of all parameters, and the contributions.
pub(super) fn hardware(report: &ReplayReport, contributions: &Figure) -> Markup {
    if report.hardware.is_empty() {
        return html! {};
    }
    let tensor = squared_norm(&report.elements_kg_m2());
    let row = |p: &HardwareResult| {
        let share = 100.0 * (squared_norm(&p.effect_kg_m2) / tensor).sqrt();
        vec![
            p.name.clone(),
            format!("{}{}", in_words(p.stated, &p.unit), if p.assumed { ", assumed" } else { "" }),
            in_words(p.value, &p.unit),
            in_words(p.sigma, &p.unit),
            significant(100.0 * p.left(), 2),
            significant(share, 2),
            p.key.clone(),
        ]
    };
    let header = [
        "parameter",
        "stated σ",
        "estimate",
        "σ after the data",
        "left, %",
        "in the tensor, %",
        "key",
    ];
    html! {
        p { "σ after the data over the stated one is what is left of a parameter; its part in the tensor is the shift of the \
             tensor by one sigma of what is left, over the tensor. A parameter that the data do not determine keeps its \
             stated σ: a better value in the craft file, under its key, makes the tensor better." }
        (place(contributions))
        details {
            summary { "All parameters" }
            (table(&header, &report.hardware.iter().map(row).collect::<Vec<_>>()))
        }
    }
}
