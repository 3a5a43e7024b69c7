//! Gyro noise estimated from a log, for a craft that does not state it.
//!
//! Assumption: the noise is white. Noise correlated from sample to sample, such as vibration, is
//! underestimated by third differences and recovered by the residuals.

use super::error::SetUpError;
use super::setup::Setup;
use super::stream::estimate_log;
use super::system::set_up;
use crate::input::log::LogRow;

/// Largest number of passes over the log.
const MAX_PASSES: usize = 8;
/// Ratio of residual to assumed noise above which another pass follows.
const MAX_RESIDUAL_RATIO: f64 = 1.1;
/// Median of the absolute value of a standard normal variable.
const NORMAL_MEDIAN: f64 = 0.6745;
/// Samples that a third difference spans.
const DIFFERENCE_SAMPLES: usize = 4;

/// Gyro noise, one sigma per sample and axis, rad/s: the fixed point at which the residual RMS of
/// the estimator equals the noise that it assumes. The iteration starts from third differences, or
/// from the rounding error of the craft's quantum if that is larger.
///
/// # Errors
/// [`SetUpError::UnmeasurableGyroNoise`] if the log is too short or constant.
pub fn from_residuals(setup: &Setup<'_>, rows: &[LogRow]) -> Result<f64, SetUpError> {
    let unmeasurable = || SetUpError::UnmeasurableGyroNoise {
        reason: match rows.len() < DIFFERENCE_SAMPLES {
            true => "fewer than four samples",
            false => "its rates are constant",
        },
    };
    let rounding = setup.craft.gyro.rounding_sigma_rad_s().unwrap_or(0.0);
    let mut noise = from_third_differences(rows).ok_or_else(unmeasurable)?.max(rounding);
    for _ in 0..MAX_PASSES {
        let setup = Setup { gyro_noise_rad_s: Some(noise), refuse_spikes: false, ..setup.clone() };
        let result = estimate_log(rows, set_up(&setup)?, |_, _, _| ());
        let residual = result.estimate.residual_rms_rad_s;
        if residual <= MAX_RESIDUAL_RATIO * noise {
            break;
        }
        noise = residual;
    }
    Ok(noise)
}

/// One sigma of white noise per sample, rad/s, from third differences of the rates; none if the log
/// is too short or constant.
///
/// `d = z₃ − 3 z₂ + 3 z₁ − z₀` is zero for any motion that is a parabola over four samples, and its
/// variance is `(1 + 9 + 9 + 1) σ² = 20 σ²`. With the median of its size,
/// `σ = median |d| / (0.6745 √20)`. The median is insensitive to spikes.
fn from_third_differences(rows: &[LogRow]) -> Option<f64> {
    let mut sizes: Vec<f64> = rows
        .windows(DIFFERENCE_SAMPLES)
        .flat_map(|w| {
            let d = w[3].rate_rad_s - (w[2].rate_rad_s - w[1].rate_rad_s) * 3.0 - w[0].rate_rad_s;
            [d.x.abs(), d.y.abs(), d.z.abs()]
        })
        .collect();
    if sizes.is_empty() {
        return None;
    }
    sizes.sort_by(f64::total_cmp);
    let sigma = sizes[sizes.len() / 2] / NORMAL_MEDIAN / 20.0f64.sqrt();
    (sigma > 0.0).then_some(sigma)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::scenario::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    #[test]
    fn third_differences_recover_the_noise_of_a_moving_body() {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let log = log_of(&scenario, &Flight::simulate(&scenario).unwrap(), 3);
        let ratio = from_third_differences(&log).unwrap() / scenario.gyro.noise_rad_s;
        // 600 samples per axis: the median of 1,800 correlated values scatters by about 4 %.
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
    }

    #[test]
    fn an_empty_log_has_no_noise() {
        assert_eq!(from_third_differences(&[]), None);
    }
}
