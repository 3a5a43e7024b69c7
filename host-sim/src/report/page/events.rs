//! Rejected samples, restarts, changes, and causes that explain the residuals.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::{facts, table};
use crate::report::json::{ExplanationReport, ReplayReport};
use crate::report::number::significant;

/// Most times in a row.
const LISTED: usize = 20;

/// Table of the events with their times, and of the rejected samples.
pub(super) fn events(report: &ReplayReport) -> Markup {
    let rows: Vec<Vec<String>> = [
        (
            "gaps",
            "first sample after an interval too long for a prediction; the inertia is kept",
            &report.gaps,
        ),
        ("restarts", "the whole state restarts", &report.restarts),
        (
            "interruptions",
            "a fault or a change in mid-motion; the earlier estimate is in doubt",
            &report.interruptions,
        ),
        (
            "changes",
            "the earlier estimate was discarded: new data contradicted it",
            &report.changes,
        ),
        ("spikes", "samples too far from the prediction", &report.spikes.first_s),
    ]
    .into_iter()
    .filter(|(_, _, times)| !times.is_empty())
    .map(|(name, meaning, times_s)| {
        let number = if name == "spikes" { report.spikes.count as usize } else { times_s.len() };
        vec![name.to_owned(), number.to_string(), times(number, times_s), meaning.to_owned()]
    })
    .collect();
    html! {
        (facts(&[
            ("samples", report.samples.to_string()),
            ("accepted", report.accepted.to_string()),
            ("rejected", counts(&report.rejected)),
            ("rows skipped", counts(&report.skipped_rows)),
        ]))
        @if rows.is_empty() {
            p { "No gap, restart, interruption, change or spike." }
        } @else {
            (table(&["event", "number", "times, s", "meaning"], &rows))
        }
    }
}

/// Causes that explain the residuals, best first.
pub(super) fn explanations(explanations: &[ExplanationReport]) -> Markup {
    if explanations.is_empty() {
        return html! {};
    }
    let row = |e: &ExplanationReport| {
        let value = e.value.map_or(String::new(), |value| {
            let sigma = e.sigma.map_or(String::new(), |s| format!(" ± {}", significant(s, 2)));
            format!("{} {}{sigma} {}", e.component, significant(value, 3), e.unit)
        });
        vec![
            e.name.clone(),
            significant(100.0 * e.share_explained, 3),
            value.trim().to_owned(),
            e.remedy.clone(),
        ]
    };
    let rows: Vec<_> = explanations.iter().map(row).collect();
    table(&["cause", "explains, %", "value", "line that states or corrects it"], &rows)
}

fn counts(by_reason: &BTreeMap<String, u64>) -> String {
    let counts = by_reason.iter().filter(|(_, count)| **count > 0);
    let counts: Vec<_> = counts.map(|(reason, count)| format!("{count} {reason}")).collect();
    if counts.is_empty() { "none".to_owned() } else { counts.join(", ") }
}

fn times(number: usize, times_s: &[f64]) -> String {
    let mut listed: Vec<String> = times_s.iter().take(LISTED).map(f64::to_string).collect();
    if listed.len() < number {
        listed.push("…".to_owned());
    }
    listed.join(", ")
}
