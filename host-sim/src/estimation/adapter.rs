//! `f64` adapter over the precision and the number of wheels of a core estimator.

use std::marker::PhantomData;

use fsw_core::checkpoint::{self, InvalidWord, Persist, Words};
use fsw_core::hardware::Finding;
use fsw_core::{Estimate, Estimator, Inertia, Innovation, Outcome, Quaternion, Real, Sample, Vec3};
use nalgebra::Vector3;

use super::setup::Setup;
use crate::input::log::LogRow;

/// An estimator of the flight core with an `f64` interface.
pub trait AnyEstimator {
    /// Processes one sample.
    fn step(&mut self, row: &LogRow) -> Outcome;
    /// Completes the work that is due on the samples so far: for the end of a log.
    fn finish(&mut self);
    /// Estimate after the last sample.
    fn estimate(&self) -> Estimate<f64>;
    /// Results on the parameters of the hardware that are among the unknowns.
    fn hardware(&self) -> Vec<Finding<f64>>;
    /// Filtered body rate, rad/s.
    fn rate_rad_s(&self) -> Vector3<f64>;
    /// Innovation of the last sample; none if the sample was not predicted.
    fn innovation(&self) -> Option<Innovation<f64>>;
    /// One sigma of the filtered rate by the filter's own covariance, rad/s; none without an
    /// innovation.
    ///
    /// With the identity as measurement matrix, and axis by axis, the variance after the update is
    /// `P⁺ = (S − R) R / S`, with S the innovation variance and R the gyro variance, rad²/s².
    fn rate_sigma_rad_s(&self) -> Option<Vector3<f64>>;
    /// Angular acceleration that the last sample completed; none if the estimator has no
    /// differentiator.
    fn acceleration(&self) -> Option<Acceleration>;
    /// Writes the state to a medium, or reads it from there, as a checkpoint; none if the estimator has no
    /// checkpoints. After a rejected read the state is invalid until another one is read.
    fn transfer(&mut self, words: &mut dyn Words) -> Option<Result<(), InvalidWord>>;
}

/// Angular acceleration at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration {
    /// Derivative of the filtered rate, body axes, rad/s².
    pub rad_s2: Vector3<f64>,
    /// Time from that instant to the last sample, s.
    pub delay_s: f64,
}

/// Adapter over an estimator that is already configured. `gyro_noise_rad_s` is the gyro noise of
/// its configuration, needed for [`AnyEstimator::rate_sigma_rad_s`] only.
pub fn any_estimator<T: Real, E: Estimator<T, W> + 'static, const W: usize>(
    estimator: E,
    gyro_noise_rad_s: Option<f64>,
) -> Box<dyn AnyEstimator> {
    Box::new(Adapter::<T, E, W>::new(estimator, gyro_noise_rad_s, |_| None))
}

/// Adapter over an estimator with checkpoints, configured by `setup`.
pub(super) fn of_setup<T: Real, E: Estimator<T, W> + Persist + 'static, const W: usize>(
    estimator: E,
    setup: &Setup<'_>,
) -> Box<dyn AnyEstimator> {
    with_acceleration::<T, E, W>(estimator, setup, |_| None)
}

/// The same for an estimator without checkpoints.
pub(super) fn without_checkpoints<T: Real, E: Estimator<T, W> + 'static, const W: usize>(
    estimator: E,
    setup: &Setup<'_>,
) -> Box<dyn AnyEstimator> {
    any_estimator::<T, E, W>(estimator, setup.gyro_noise_rad_s)
}

/// Adapter over an estimator with checkpoints and a differentiator; `acceleration` reads its output.
pub(super) fn with_acceleration<T, E, const W: usize>(
    estimator: E,
    setup: &Setup<'_>,
    acceleration: fn(&E) -> Option<Acceleration>,
) -> Box<dyn AnyEstimator>
where
    T: Real,
    E: Estimator<T, W> + Persist + 'static,
{
    let mut adapter = Adapter::<T, E, W>::new(estimator, setup.gyro_noise_rad_s, acceleration);
    adapter.transfer = Some(checkpoint::transfer::<E>);
    Box::new(adapter)
}

/// Transfer of a state to or from a medium.
type Transfer<E> = fn(&mut E, &mut dyn Words) -> Result<(), InvalidWord>;

struct Adapter<T, E, const W: usize> {
    estimator: E,
    gyro_variance_rad2_s2: Option<f64>,
    acceleration: fn(&E) -> Option<Acceleration>,
    /// None if the estimator has no checkpoints.
    transfer: Option<Transfer<E>>,
    precision: PhantomData<T>,
}

impl<T, E, const W: usize> Adapter<T, E, W> {
    fn new(
        estimator: E,
        gyro_noise_rad_s: Option<f64>,
        acceleration: fn(&E) -> Option<Acceleration>,
    ) -> Self {
        let gyro_variance_rad2_s2 = gyro_noise_rad_s.map(|sigma| sigma * sigma);
        let precision = PhantomData;
        Self { estimator, gyro_variance_rad2_s2, acceleration, transfer: None, precision }
    }
}

impl<T: Real, E: Estimator<T, W>, const W: usize> AnyEstimator for Adapter<T, E, W> {
    fn step(&mut self, row: &LogRow) -> Outcome {
        // A log has one speed per wheel of the craft; the filling wheels stand still.
        let speed = |i: usize| row.wheel_speed_rad_s.get(i).copied().unwrap_or(0.0);
        self.estimator.step(&Sample {
            time_us: row.time_us,
            rate_rad_s: narrow(&row.rate_rad_s),
            wheel_speed_rad_s: std::array::from_fn(|i| T::lit(speed(i))),
            torque_n_m: narrow(&row.torque_n_m),
            attitude: row.attitude.map(|q| Quaternion::new(q.map(T::lit))),
        })
    }

    fn finish(&mut self) {
        self.estimator.finish();
    }

    fn estimate(&self) -> Estimate<f64> {
        let e = self.estimator.estimate();
        Estimate {
            inertia: Inertia::new(e.inertia.elements_kg_m2().map(T::to_f64)),
            covariance_kg2_m4: e.covariance_kg2_m4.map(T::to_f64),
            sigma_random_kg_m2: e.sigma_random_kg_m2.map(|sigma| sigma.map(T::to_f64)),
            trace_spread: e.trace_spread.to_f64(),
            observed: e.observed,
            status: e.status,
            disturbance_torque_n_m: e.disturbance_torque_n_m.as_ref().map(widen),
            gyro_bias_rad_s: e.gyro_bias_rad_s.as_ref().map(widen),
            residual_rms_rad_s: e.residual_rms_rad_s.to_f64(),
            residuals_white: e.residuals_white,
            projected: e.projected,
        }
    }

    fn hardware(&self) -> Vec<Finding<f64>> {
        let mut findings = Vec::new();
        self.estimator.each_of_hardware(&mut |finding| {
            findings.push(Finding {
                parameter: finding.parameter,
                value: finding.value.to_f64(),
                sigma: finding.sigma.to_f64(),
                stated: finding.stated.to_f64(),
                effect_kg_m2: finding.effect_kg_m2.map(T::to_f64),
            });
        });
        findings
    }

    fn rate_rad_s(&self) -> Vector3<f64> {
        widen(&self.estimator.rate_rad_s())
    }

    fn innovation(&self) -> Option<Innovation<f64>> {
        self.estimator.innovation().map(|i| Innovation {
            rate_rad_s: widen(&i.rate_rad_s),
            variance_rad2_s2: widen(&i.variance_rad2_s2),
        })
    }

    fn rate_sigma_rad_s(&self) -> Option<Vector3<f64>> {
        let gyro = self.gyro_variance_rad2_s2?;
        self.innovation().map(|innovation| {
            innovation.variance_rad2_s2.map(|s| ((s - gyro).max(0.0) * gyro / s).sqrt())
        })
    }

    fn acceleration(&self) -> Option<Acceleration> {
        (self.acceleration)(&self.estimator)
    }

    fn transfer(&mut self, words: &mut dyn Words) -> Option<Result<(), InvalidWord>> {
        self.transfer.map(|transfer| transfer(&mut self.estimator, words))
    }
}

/// A vector rounded to the estimator's precision.
pub(super) fn narrow<T: Real>(v: &Vector3<f64>) -> Vec3<T> {
    Vec3::from_fn(|i, _| T::lit(v[i]))
}

/// A vector of the estimator in `f64`, exactly.
pub(super) fn widen<T: Real>(v: &Vec3<T>) -> Vector3<f64> {
    Vector3::from_fn(|i, _| v[i].to_f64())
}
