//! Error of interpolated wheel speeds, in the noise of the gyro.
//!
//! The effect of the error on the rate requires the inertia: that of a first pass over the log, or of the prior.

use flight_input::inertia::tensor;
use flight_input::log::Interpolation;

use super::error::SetUpError;
use super::name::Method;
use super::setup::Setup;
use super::stream::{estimate_log, median_period_s};
use super::system::set_up;
use crate::input::log::LogRow;
use crate::input::{Craft, interpolated};

/// Least error that is taken into account, share of the noise of the gyro: it adds 0.5 % to its variance.
const LEAST_SHARE: f64 = 0.07;

/// The craft, with the error of its wheel speeds in the noise of its gyro, and notes on that, on assumed tachometers
/// and on rows left out.
///
/// # Errors
/// An error of setting up the estimator of the first pass.
pub fn with_wheel_error(
    method: Method,
    craft: &Craft,
    rows: &[LogRow],
    error: &Interpolation,
) -> Result<(Craft, Vec<String>), SetUpError> {
    let mut craft = craft.clone();
    let mut notes = error.notes();
    if error.sigma_rad_s.iter().all(|sigma| *sigma == 0.0) {
        return Ok((craft, notes));
    }
    let setup = Setup::for_log(method, &craft, rows)?;
    let first = estimate_log(rows, set_up(&setup)?, |_, _, _| ()).estimate;
    let is_known = first.observed.directions == 6 && first.inertia.check().is_ok();
    let found = is_known.then(|| first.inertia.elements_kg_m2());
    let elements = found.or_else(|| craft.prior.as_ref().map(|prior| prior.inertia_kg_m2));
    let period_s = median_period_s(rows);
    let noise = elements.and_then(|elements| {
        interpolated::rate_noise_rad_s(&craft, error, &tensor(&elements), period_s)
    });
    let Some(noise) = noise else {
        notes.push(
            "the error of the interpolated wheel speeds is not in the sigma: no inertia is known; state a [prior]"
                .to_owned(),
        );
        return Ok((craft, notes));
    };
    // A noise that is not stated is that of the residuals, the error of the interpolation included.
    let gyro = craft.gyro.noise_rad_s.unwrap_or(first.residual_rms_rad_s);
    if noise < LEAST_SHARE * gyro {
        return Ok((craft, notes));
    }
    craft.gyro.noise_rad_s = Some(gyro.hypot(noise));
    notes.push(format!(
        "the error of the interpolated wheel speeds is in the sigma, as a noise of {noise:.2e} rad/s beside that of \
         the gyro, {gyro:.2e} rad/s"
    ));
    Ok((craft, notes))
}
