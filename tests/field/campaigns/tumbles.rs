//! 4\. Torque-free tumbles: without wheels the scale is unobserved, whatever the length of the record;
//! with wheels that turn freely it is observed as far as the bound says.

use anyhow::Result;

use super::super::campaign::{Campaign, Check, Limits, SINGLE};
use super::super::motion::Source;
use super::super::scenarios::{free_body, free_wheels, source};
use super::super::tumble::Tumbles;

/// Durations, s.
const MINUTES_S: [f64; 2] = [10.0, 600.0];
/// A long tumble, s.
const TWO_HOURS_S: f64 = 7200.0;

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for has_prior in [false, true] {
        let prior = if has_prior { "prior" } else { "no-prior" };
        let tumbles = Tumbles {
            base: free_body([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [0.0; 3], 10.0, 1e-4, 10.0)?,
            duration_s: MINUTES_S,
            rate_hz: [4.0, 200.0],
            has_prior,
        };
        let long =
            Tumbles { duration_s: [TWO_HOURS_S; 2], rate_hz: [4.0, 40.0], ..tumbles.clone() };
        for (name, tumbles, runs, small) in [("minutes", tumbles, 5000, 20), ("2h", long, 50, 0)] {
            list.push(Campaign {
                check: Check::NoScale,
                precisions: SINGLE,
                small,
                limits: Limits { converged: None, diverged: Some(0.0), ..Limits::HONEST },
                ..Campaign::new(
                    4,
                    format!("tumble/{name}-{prior}"),
                    Source::Tumbles(Box::new(tumbles)),
                    runs,
                )
            });
        }
    }
    list.extend(with_free_wheels()?);
    Ok(list)
}

/// Three or four wheels that turn freely, ten seconds to ten minutes, 4 to 100 Hz.
fn with_free_wheels() -> Result<Vec<Campaign>> {
    let mut list = Vec::new();
    for (wheels, rate_hz, noise_rad_s, duration_s) in [
        (3, 10.0, 1e-4, 10.0),
        (3, 10.0, 1e-4, 30.0),
        (3, 10.0, 1e-4, 60.0),
        (3, 10.0, 1e-4, 600.0),
        (4, 4.0, 1e-4, 600.0),
        (4, 100.0, 1.7e-3, 120.0),
    ] {
        let scenario = free_wheels(wheels, rate_hz, noise_rad_s, duration_s)?;
        list.push(Campaign {
            check: Check::WithinBound,
            precisions: SINGLE,
            small: 10,
            limits: Limits { diverged: Some(0.01), ..Limits::HONEST },
            ..Campaign::new(
                4,
                format!("tumble/{wheels}-free-wheels-{duration_s}s-{rate_hz}hz"),
                source(scenario),
                250,
            )
        });
    }
    Ok(list)
}
