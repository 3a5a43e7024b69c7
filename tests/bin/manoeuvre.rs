//! Benchmark of designed manoeuvres. Commands:
//!
//! ```sh
//! cargo run --release -p tests --bin manoeuvre                    the table of host-sim/docs/manoeuvres.md
//! cargo run --release -p tests --bin manoeuvre -- --all           every combination, with and without a cone
//! cargo run --release -p tests --bin manoeuvre -- --random 1000   random designs flown by the truth
//! ```
//!
//! A row has the bound of the inertia after the design, √tr C / ‖j‖, that of the best standard manoeuvre over it,
//! and that of cosines of the best frequency over it. A limit exceeded by a random design is printed as MISSED,
//! and the exit status is then 1.

use std::io::{Write, stdout};
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use host_sim::manoeuvre::Effort;
use tests::manoeuvre::random::{self, Worst};
use tests::manoeuvre::{Case, SATELLITES, Satellite};

/// Score designed manoeuvres against the best standard ones.
#[derive(Debug, Parser)]
struct Arguments {
    /// Largest excursions, deg.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.5,2,5,20")]
    excursion: Vec<f64>,
    /// Shares of the wheels' momentum.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    momentum: Vec<f64>,
    /// Durations, s.
    #[arg(long, value_delimiter = ',', default_value = "60")]
    duration: Vec<f64>,
    /// Errors of the prior, shares.
    #[arg(long, value_delimiter = ',', default_value = "0")]
    prior: Vec<f64>,
    /// With a keep-out cone one degree from the boresight.
    #[arg(long)]
    cone: bool,
    /// Every combination: momentum 20, 50, 100 %, 15, 60, 600 s, prior 0, 20, 50 %, with and without the cone.
    #[arg(long)]
    all: bool,
    /// Satellites, 1 to 3.
    #[arg(long, value_delimiter = ',', default_value = "1,2,3")]
    satellite: Vec<usize>,
    /// Seed.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Number of random designs, in place of the table.
    #[arg(long)]
    random: Option<u64>,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    if let Some(count) = arguments.random {
        return random_designs(arguments.seed, count);
    }
    writeln!(
        stdout(),
        "| satellite | duration, s | excursion, deg | momentum, % | prior, % | cone | sigma, % | best standard | gain | \
         over tuned cosines |\n|---|---|---|---|---|---|---|---|---|---|"
    )?;
    for case in cases(&arguments) {
        for number in &arguments.satellite {
            if let Some(satellite) = number.checked_sub(1).and_then(|i| SATELLITES.get(i)) {
                row(satellite, &case, arguments.seed)?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn cases(arguments: &Arguments) -> Vec<Case> {
    let all = |list: &[f64], every: &[f64]| if arguments.all { every } else { list }.to_vec();
    let cones = if arguments.all { vec![false, true] } else { vec![arguments.cone] };
    let mut cases = Vec::new();
    for duration_s in all(&arguments.duration, &[15.0, 60.0, 600.0]) {
        for &excursion_deg in &arguments.excursion {
            for momentum_share in all(&arguments.momentum, &[0.2, 0.5, 1.0]) {
                for prior_error in all(&arguments.prior, &[0.0, 0.2, 0.5]) {
                    cases.extend(cones.iter().map(|&has_cone| Case {
                        excursion_deg,
                        momentum_share,
                        duration_s,
                        prior_error,
                        has_cone,
                    }));
                }
            }
        }
    }
    cases
}

fn row(satellite: &Satellite, case: &Case, seed: u64) -> Result<()> {
    let head = format!(
        "| {} | {} | {} | {:.0} | {:.0} | {} |",
        satellite.name,
        case.duration_s,
        case.excursion_deg,
        100.0 * case.momentum_share,
        100.0 * case.prior_error,
        if case.has_cone { "yes" } else { "–" },
    );
    match case.score(satellite, Effort::default(), seed) {
        Ok(score) => {
            let tuned = score.design.tuned.as_ref();
            let tuned =
                tuned.map_or("–".to_owned(), |t| format!("{:.2}", score.design.gain_over(t)));
            let (percent, gain) = (100.0 * score.sigma, score.gain());
            writeln!(stdout(), "{head} {percent:.4} | {} | {gain:.2} | {tuned} |", score.fixed)?;
        }
        Err(error) => writeln!(stdout(), "{head} {error} |||")?,
    }
    Ok(())
}

fn random_designs(seed: u64, count: u64) -> Result<ExitCode> {
    let mut worst = Worst::default();
    for seed in seed..seed + count {
        let flown = random::fly(seed)?;
        if let Some(missed) = flown.missed() {
            writeln!(stdout(), "seed {seed}: MISSED {missed}")?;
        }
        worst.add(&flown);
    }
    writeln!(stdout(), "{worst}")?;
    Ok(if worst.missed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
