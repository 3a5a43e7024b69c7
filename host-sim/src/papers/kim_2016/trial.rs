//! One seed of \[Kim2016\]: estimates, and RMS errors of the angular acceleration.

use fsw_core::math::savgol::{Differentiator, Fit, Growth, Pushed};
use nalgebra::Vector3;

use crate::estimation::{EstimatorName, Method, Precision, SetUpError};
use crate::papers::case::{Case, OWN};
use crate::report::plots::flight::interpolated;

pub(super) const PUBLISHED: Method =
    Method { estimator: EstimatorName::EkfSgfLls, precision: Precision::F64 };

/// Interval between two estimates, s.
const BATCH_S: f64 = 40.0;
/// Start of the RMS error of the acceleration, s. Own choice: the paper does not give the initial
/// state of its filter. The filter here starts on a noisy sample, and its first corrections exceed
/// the later ones by far.
pub(super) const SETTLED_S: f64 = 40.0;
/// Longest window of a derivative, samples. Figure 1 needs 20.
const CAPACITY: usize = 32;
/// Largest deviation of a sampling interval within a window, share of the interval.
const PERIOD_TOLERANCE: f64 = 0.1;

/// Time, s, and the error of a derivative at that time, rad/s².
pub(super) type DerivativeError = (f64, [f64; 3]);

/// The scenario, and the derivative of its true rate.
pub struct Kim2016 {
    pub(super) case: Case,
    /// Time halfway between two samples, s, and true acceleration, rad/s².
    pub(super) truth_rad_s2: Vec<(f64, [f64; 3])>,
}

/// Results of one seed.
pub struct Kim2016Trial {
    /// RMS error of the backward difference, Eq. (11), deg/s².
    pub(super) backward: [f64; 3],
    /// RMS error with the printed weights, which are those of a parabola, deg/s².
    pub(super) parabola: [f64; 3],
    /// RMS error with the weights of a quartic, deg/s².
    pub(super) quartic: [f64; 3],
    /// Estimates at the end of each batch, kg m².
    pub(super) batches: Vec<[f64; 6]>,
    /// Estimate at the end of the flight, kg m².
    pub(super) estimate: [f64; 6],
    /// Own estimator, kg m².
    pub(super) own: [f64; 6],
}

impl Kim2016 {
    /// Flies one seed.
    pub(super) fn trial(&self, seed: u64) -> Result<Kim2016Trial, SetUpError> {
        let samples_of_batch = (BATCH_S * self.case.scenario.gyro.rate_hz).round() as usize;
        let mut rates = Vec::with_capacity(self.case.flight.instants.len());
        let mut batches = Vec::new();
        let flown = self.case.fly(PUBLISHED, seed, |index, estimator| {
            rates.push(estimator.rate_rad_s());
            if index > 0 && index % samples_of_batch == 0 {
                batches.push(estimator.estimate().inertia.elements_kg_m2());
            }
        })?;
        let own = self.case.fly(OWN, seed, |_, _| ())?;
        let rms = |fit| self.rms_error_deg_s2(&rates, fit);
        Ok(Kim2016Trial {
            backward: rms(backward_difference())?,
            parabola: rms(Fit::centred(6, 2, 1))?,
            quartic: rms(Fit::centred(6, 4, 1))?,
            batches,
            estimate: flown.estimate.inertia.elements_kg_m2(),
            own: own.estimate.inertia.elements_kg_m2(),
        })
    }

    /// Error of the derivative of filtered rates.
    pub(super) fn errors_rad_s2(
        &self,
        rates_rad_s: &[Vector3<f64>],
        fit: Fit<f64>,
    ) -> Result<Vec<DerivativeError>, SetUpError> {
        let mut differentiator =
            Differentiator::<f64, 3, CAPACITY>::new(fit, Growth::WaitUntilFull, PERIOD_TOLERANCE)?;
        let instants = self.case.flight.instants.iter().zip(rates_rad_s);
        let errors = instants.filter_map(|(instant, rate)| {
            let pushed = differentiator.push(instant.time_us, (*rate).into());
            let Pushed::Fitted(fitted) = pushed else { return None };
            let time_s = instant.time_us as f64 * 1e-6 - fitted.delay_s;
            let truth = interpolated(&self.truth_rad_s2, time_s)?;
            Some((time_s, std::array::from_fn(|i| fitted.derivative_per_s[i] - truth[i])))
        });
        Ok(errors.collect())
    }

    /// RMS error of the derivative of filtered rates from [`SETTLED_S`] on, deg/s².
    pub(super) fn rms_error_deg_s2(
        &self,
        rates_rad_s: &[Vector3<f64>],
        fit: Fit<f64>,
    ) -> Result<[f64; 3], SetUpError> {
        let errors = self.errors_rad_s2(rates_rad_s, fit)?;
        let errors: Vec<_> = errors.into_iter().filter(|error| error.0 >= SETTLED_S).collect();
        let count = errors.len() as f64;
        Ok(std::array::from_fn(|i| {
            let square: f64 = errors.iter().map(|(_, error)| error[i] * error[i]).sum();
            (square / count).sqrt().to_degrees()
        }))
    }
}

/// \[Kim2016\] Eq. (11): the slope of the line through two samples, at the newer one.
pub(super) fn backward_difference() -> Fit<f64> {
    Fit::newest(2, 1, 1)
}
