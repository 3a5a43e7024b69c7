//! The table of the campaigns, a line for each, and the line of a single run.

use fsw_core::Status;
use host_sim::estimation::Precision;

use super::campaign::Campaign;
use super::figures::Figures;
use super::run::Run;

/// Width of the name of a campaign.
const NAME: usize = 50;

/// The two lines above the table.
pub fn head() -> String {
    let columns = format!(
        "{:<NAME$} {:<4} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>13} {:>7} {:>8} {:>6} {:>7} {:>5} \
         {:>7} {:>7}  {}",
        "campaign",
        "",
        "runs",
        "conv",
        "part",
        "unobs",
        "div",
        "¬white",
        "RMS/bound",
        "NEES",
        "worst σ",
        "silent",
        "RMS/ref",
        "told",
        "wrong s",
        "right s",
        "spikes gaps lockouts interruptions changes divergences"
    );
    format!("{columns}\n{}", "-".repeat(columns.chars().count()))
}

/// The line of a campaign: its figures, and the limits that are missed.
pub fn row(campaign: &Campaign, precision: Precision, figures: &Figures) -> String {
    let [converged, partial, unobservable, diverged] = figures.status;
    let range =
        figures.over_bound.map(|[least, most]| format!("{}..{}", short(least), short(most)));
    let optional = |value: Option<f64>| value.map_or("–".to_owned(), short);
    let told = match figures.visible {
        [0, _] => "–".to_owned(),
        [visible, told] => format!("{:.0}%", 100.0 * told as f64 / visible as f64),
    };
    let c = &figures.counts;
    let counts = format!(
        "{} {} {} {} {} {}",
        c.spike,
        c.gap_resets,
        c.lockout_resets,
        c.interruption_resets,
        c.change_resets,
        c.divergence_resets
    );
    let mut line = format!(
        "{:<NAME$} {:<4} {:>6} {converged:>6} {partial:>6} {unobservable:>6} {diverged:>6} {:>6} \
         {:>13} {:>7} {:>8} {:>6} {:>7} {told:>5} {:>7} {:>7}  {counts}",
        campaign.name,
        precision.to_string(),
        figures.runs,
        figures.not_white,
        range.unwrap_or("–".to_owned()),
        optional(figures.nees),
        short(figures.worst_sigmas),
        figures.silent,
        optional(figures.over_reference),
        short(figures.wrong_s),
        short(figures.recovery_s),
    );
    let missed = figures.missed(campaign);
    if !missed.is_empty() {
        line += &format!("  MISSED: {}", missed.join(", "));
    }
    if let Some(seed) = figures.silent_seed {
        line += &format!("  (silent: seed {seed})");
    }
    if let Some(reason) = &figures.failure {
        line += &format!("  ({reason})");
    }
    line
}

/// The line of a single run.
pub fn run(run: &Run) -> String {
    let white = match run.white {
        Some(true) => "white",
        Some(false) => "not-white",
        None => "untested",
    };
    let c = &run.counts;
    let rejected: Vec<String> = (c.rejected().iter())
        .filter(|(_, count)| *count > 0)
        .map(|(name, count)| format!("{name}={count}"))
        .collect();
    let [own, reference] = run.extra.squares;
    let mut line = format!(
        "  seed {:<6} {:>6} samples  {:<12} dirs {} {white:<9} {:>8} σ {:>8} bounds  NEES {:>8}  \
         gap={} lockout={} interruption={} change={} divergence={} {}",
        run.seed,
        run.samples,
        name(run.score.status),
        run.directions,
        short(run.worst_sigmas()),
        short(run.worst_bounds()),
        run.score.nees.map_or("–".to_owned(), |nees| short(nees / 6.0)),
        c.gap_resets,
        c.lockout_resets,
        c.interruption_resets,
        c.change_resets,
        c.divergence_resets,
        rejected.join(" "),
    );
    if reference > 0.0 {
        line += &format!("  RMS/ref {}", short((own / reference).sqrt()));
    }
    if run.extra.wrong_s > 0.0 || run.extra.recovery_s > 0.0 {
        line += &format!("  wrong {} s, right after {} s", run.extra.wrong_s, run.extra.recovery_s);
    }
    if run.extra.disagrees {
        line += "  DISAGREES";
    }
    if run.extra.silent > 0 {
        line += &format!("  SILENT {}", run.extra.silent);
    }
    line
}

fn name(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::Partial => "partial",
        Status::Unobservable => "unobservable",
        Status::Diverged => "diverged",
    }
}

/// Three significant digits.
fn short(x: f64) -> String {
    match x.abs() {
        size if size >= 1e5 || (size > 0.0 && size < 1e-2) => format!("{x:.1e}"),
        size if size >= 100.0 => format!("{x:.0}"),
        size if size >= 10.0 => format!("{x:.1}"),
        _ => format!("{x:.2}"),
    }
}
