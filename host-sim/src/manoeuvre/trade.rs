//! Trade: designs over a range of one quantity, all else equal.

use std::sync::atomic::{AtomicBool, Ordering};

use super::design::design;
use super::problem::{DesignError, Request};
use super::series::accuracy;
use crate::input::Scenario;

/// Quantity of a trade.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Trade {
    /// Largest excursion, deg.
    Excursion,
    /// Duration, s.
    Duration,
    /// Gyro noise of a sample, rad/s.
    Noise,
}

/// Result at one value of the quantity.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TradeRow {
    /// Value of the quantity: deg, s or rad/s.
    pub value: f64,
    /// One sigma of each element after the design, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// Root of the sum of the variances over the root of the sum of the squares of the elements, per cent.
    pub sigma_percent: f64,
    /// Sigma of the best standard manoeuvre over that of the design.
    pub gain: f64,
    /// Name of the best standard manoeuvre; none if all observe nothing.
    pub best_fixed: Option<String>,
    /// Limit with the largest share.
    pub limited_by: &'static str,
}

impl Trade {
    /// Unit of the quantity.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Excursion => "deg",
            Self::Duration => "s",
            Self::Noise => "rad/s",
        }
    }

    /// Name of the quantity.
    pub fn name(self) -> &'static str {
        match self {
            Self::Excursion => "excursion",
            Self::Duration => "duration",
            Self::Noise => "noise",
        }
    }

    /// Value of the quantity in a request.
    pub fn of(self, scenario: &Scenario, request: &Request) -> f64 {
        match self {
            Self::Excursion => request.limits.excursion_rad.to_degrees(),
            Self::Duration => request.duration_s,
            Self::Noise => scenario.gyro.noise_rad_s,
        }
    }

    fn set(self, value: f64, scenario: &mut Scenario, request: &mut Request) {
        match self {
            Self::Excursion => request.limits.excursion_rad = value.to_radians(),
            Self::Duration => request.duration_s = value,
            Self::Noise => scenario.gyro.noise_rad_s = value,
        }
    }
}

/// Designs at this number of values, equally spaced in their logarithm. `done` is called after each. If `stop` is
/// set, the rows are those completed.
///
/// # Errors
/// See [`DesignError`].
pub fn trade(
    scenario: &Scenario,
    request: &Request,
    (quantity, range, points): (Trade, [f64; 2], usize),
    stop: &AtomicBool,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<TradeRow>, DesignError> {
    let mut rows = Vec::new();
    for point in 0..points {
        let part = point as f64 / (points.max(2) - 1) as f64;
        let value = range[0] * (range[1] / range[0]).powf(part);
        let (mut scenario, mut request) = (scenario.clone(), request.clone());
        quantity.set(value, &mut scenario, &mut request);
        let found = match design(&scenario, &request, stop, &|_| ()) {
            Ok(found) => found,
            Err(_) if stop.load(Ordering::Relaxed) => break,
            Err(error) => return Err(error),
        };
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let accuracy = accuracy(&scenario, &request, &found.best)?;
        let norm = |x: &[f64; 6]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        rows.push(TradeRow {
            value,
            sigma_kg_m2: accuracy.after_kg_m2,
            sigma_percent: 100.0 * norm(&accuracy.after_kg_m2) / norm(&accuracy.inertia_kg_m2),
            gain: found.gain(),
            best_fixed: found.fixed.first().map(|fixed| fixed.name.clone()),
            limited_by: found.limiting.first().map_or("", |(kind, _)| kind.name()),
        });
        done();
    }
    Ok(rows)
}
