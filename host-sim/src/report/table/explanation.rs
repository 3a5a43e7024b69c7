//! Table of `diagnose`.

use super::cells::{DIGITS, EMPTY, heading};
use crate::report::columns::Columns;
use crate::report::json::{DiagnosisReport, ExplanationReport};
use crate::report::number::{fixed, significant};

/// Most explanations of a table.
const LISTED: usize = 6;

/// Explanations with the share of chi-square that each accounts for, and the remedy of the first ones.
pub fn diagnosis(report: &DiagnosisReport) -> String {
    let chi_square = report.chi_square.map_or("not finite".to_owned(), |x| significant(x, DIGITS));
    let mut text =
        heading("chi-square", &format!("{chi_square} of {} readings", fixed(report.readings, 0)));
    text += &heading(
        "measured noise",
        &format!("{} rad/s", significant(report.measured_noise_rad_s, DIGITS)),
    );
    if report.explanations.is_empty() {
        return text + "explanations        none: no single cause explains more than the noise\n";
    }
    let mut table = Columns::new(&[
        ("explanation", ""),
        ("explains", ""),
        ("value", ""),
        ("one sigma", ""),
        ("unit", ""),
    ]);
    let listed = &report.explanations[..report.explanations.len().min(LISTED)];
    for explanation in listed {
        let cell =
            |value: Option<f64>| value.map_or(EMPTY.to_owned(), |value| significant(value, DIGITS));
        table.row([
            title(explanation),
            format!("{} %", fixed(100.0 * explanation.share_explained, 1)),
            cell(explanation.value),
            cell(explanation.sigma),
            explanation.unit.clone(),
        ]);
    }
    text = format!("{text}\n{}\n", table.finish());
    for explanation in listed {
        text += &format!("{}: {}\n", explanation.name, explanation.remedy);
        let others = &explanation.indistinguishable_from;
        if !others.is_empty() {
            text += &format!("  not distinguished from: {}\n", others.join("; "));
        }
    }
    text
}

/// Name, with the component of the value.
fn title(explanation: &ExplanationReport) -> String {
    match explanation.component.as_str() {
        "" => explanation.name.clone(),
        component => format!("{}: {component}", explanation.name),
    }
}
