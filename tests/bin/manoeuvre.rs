//! Benchmark of designed manoeuvres.

use std::time::Instant;

use anyhow::Result;
use clap::Parser;
use host_sim::manoeuvre::Effort;
use tests::manoeuvre::{Case, SATELLITES};

/// Score of designed manoeuvres: sigma of the best fixed manoeuvre over that of the design.
#[derive(Debug, Parser)]
struct Arguments {
    /// Excursions, deg.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.5,2,5,20")]
    excursion: Vec<f64>,
    /// Shares of the largest momentum.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    momentum: Vec<f64>,
    /// Durations, s.
    #[arg(long, value_delimiter = ',', default_value = "60")]
    duration: Vec<f64>,
    /// Errors of the prior, share.
    #[arg(long, value_delimiter = ',', default_value = "0")]
    prior: Vec<f64>,
    /// Satellites, 0 to 2.
    #[arg(long, value_delimiter = ',', default_value = "0,1,2")]
    satellite: Vec<usize>,
    #[arg(long)]
    cone: bool,
    #[arg(long, default_value_t = 4)]
    starts: usize,
    #[arg(long, default_value_t = 8)]
    rounds: usize,
    #[arg(long, default_value_t = 40)]
    iterations: u64,
    #[arg(long, default_value_t = 5)]
    samples: usize,
}

fn main() -> Result<()> {
    let a = Arguments::parse();
    let effort =
        Effort { starts: a.starts, rounds: a.rounds, iterations: a.iterations, samples: a.samples };
    for &satellite in &a.satellite {
        for &duration_s in &a.duration {
            for &excursion_deg in &a.excursion {
                for &momentum_share in &a.momentum {
                    for &prior_error in &a.prior {
                        let case = Case { excursion_deg, momentum_share, duration_s, prior_error, has_cone: a.cone };
                        let begun = Instant::now();
                        let score = case.score(&SATELLITES[satellite], effort, 0)?;
                        println!(
                            "{satellite} T {duration_s} exc {excursion_deg} h {momentum_share} prior {prior_error}: design {:.4} % fixed {:.4} % {} gain {:.2}  knots {:.2} s x{}  {:?} {:?} {:.1} s",
                            100.0 * score.sigma, 100.0 * score.fixed_sigma, score.fixed, score.gain(),
                            score.design.knot_s, score.design.repeats,
                            score.design.best.usage.iter().filter_map(|(k, u)| Some((k.name(), (u.as_ref()? * 1000.0).round() / 1000.0))).collect::<Vec<_>>(),
                            score.design.elasticities.iter().map(|(k, e)| (k.name(), (e * 100.0).round() / 100.0)).filter(|x| x.1 != 0.0).collect::<Vec<_>>(),
                            begun.elapsed().as_secs_f64()
                        );
                        println!("   {:?}", score.design.fixed.iter().take(6).map(|f| format!("{} {:.2}", f.name, (f.log_size - score.design.best.log_size).exp())).collect::<Vec<_>>());
                    }
                }
            }
        }
    }
    Ok(())
}
