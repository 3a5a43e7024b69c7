//! Input of an estimator's configuration, and the parts of it that all estimators share.

use fsw_core::hardware::{Disturbance, Hardware};
use fsw_core::{Prior, Real, gate};

use super::error::SetUpError;
use super::name::{EstimatorName, Precision};
use crate::input::Craft;

/// Longest gap that is bridged by prediction, sample periods. The core's own limit applies where it
/// is longer.
const MAX_GAP_PERIODS: f64 = 4.0;

/// Everything that the configuration of an estimator depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup<'a> {
    /// The estimator.
    pub estimator: EstimatorName,
    /// Its arithmetic.
    pub precision: Precision,
    /// The craft: wheels, gyro range, prior, process noise, disturbances to solve for.
    pub craft: &'a Craft,
    /// Noise of a reading, one sigma per sample and axis, rad/s: stated by the craft, rounding error
    /// included, or estimated from the log. None: the estimator estimates it, if it can.
    pub gyro_noise_rad_s: Option<f64>,
    /// Typical time between samples, s.
    pub sample_period_s: f64,
    /// Reject samples far from their prediction. Off while the gyro noise itself is unknown.
    pub refuse_spikes: bool,
}

impl Setup<'_> {
    /// Gyro noise, rad/s.
    ///
    /// # Errors
    /// [`SetUpError::NoGyroNoise`] if it is unknown.
    pub(super) fn required_gyro_noise_rad_s<T: Real>(&self) -> Result<T, SetUpError> {
        let missing = SetUpError::NoGyroNoise { estimator: self.estimator };
        self.gyro_noise_rad_s.map(T::lit).ok_or(missing)
    }

    /// The craft's prior of the inertia.
    pub(super) fn prior<T: Real>(&self) -> Option<Prior<T>> {
        self.craft.prior.as_ref().map(|prior| Prior {
            inertia_kg_m2: prior.inertia_kg_m2.map(T::lit),
            sigma_kg_m2: prior.sigma_kg_m2.map(T::lit),
        })
    }

    /// Random walk of each element of the inertia, kg m²/√s, if the craft states one.
    pub(super) fn inertia_walk_kg_m2_sqrt_s<T: Real>(&self) -> Option<T> {
        const SQRT_SECONDS_PER_HOUR: f64 = 60.0;
        self.craft
            .filter
            .inertia_walk_kg_m2_sqrt_hour
            .map(|walk| T::lit(walk / SQRT_SECONDS_PER_HOUR))
    }

    /// Errors of the hardware as the craft states them. Wheels that fill up the array have none.
    pub(super) fn hardware<T: Real, const W: usize>(&self) -> Hardware<T, W> {
        let stated = &self.craft.hardware;
        let of_wheel = |all: &[f64], i: usize| T::lit(all.get(i).copied().unwrap_or(0.0));
        let has_wheels = !self.craft.wheels.is_empty();
        let common = if has_wheels { stated.common_spin_inertia_sigma } else { 0.0 };
        // A mean over the interval before its time stamp is half an interval old.
        let averaging_s = if stated.gyro_averaged { 0.5 * self.sample_period_s } else { 0.0 };
        Hardware {
            gyro_scale: T::lit(stated.gyro_scale_sigma),
            gyro_axes_rad: T::lit(stated.gyro_axes_sigma_rad),
            delay_s: T::lit(stated.gyro_delay_s + averaging_s),
            delay_sigma_s: T::lit(stated.gyro_delay_sigma_s),
            wheel_inertia: std::array::from_fn(|i| of_wheel(&stated.wheel_spin_inertia_sigma, i)),
            wheel_axis_rad: std::array::from_fn(|i| of_wheel(&stated.wheel_axis_sigma_rad, i)),
            common_wheel_inertia: T::lit(common),
            torque_scale: T::lit(stated.torque_scale_sigma),
            clock: T::lit(stated.clock_sigma),
            mount_rad: stated.mount_sigma_rad.map(T::lit),
        }
    }

    /// Disturbances that the craft states, for an estimator that considers them.
    pub(super) fn disturbance<T: Real>(&self) -> Disturbance<T> {
        let stated = &self.craft.hardware;
        Disturbance {
            torque_n_m: T::lit(stated.torque_sigma_n_m.unwrap_or(0.0)),
            gyro_bias_rad_s: T::lit(stated.bias_sigma_rad_s.unwrap_or(0.0)),
        }
    }

    /// Gyro range of the craft, and the longest gap that is bridged by prediction.
    pub(super) fn configure_gate<T: Real>(&self, gate: &mut gate::Config<T>) {
        if let Some(range) = self.craft.gyro.range_rad_s {
            gate.range_rad_s = T::lit(range);
        }
        let bridged_us = (MAX_GAP_PERIODS * self.sample_period_s * 1e6) as u64;
        gate.max_gap_us = gate.max_gap_us.max(bridged_us);
    }
}
