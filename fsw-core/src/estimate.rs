//! The estimate: inertia tensor, covariance, observed directions, status.

use crate::math::{Mat, Vec3, scalar::Real};
use crate::monitor::observability::{Observed, observed};
use crate::prior::Prior;
use crate::tensor::Inertia;

/// How far an estimate can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Status {
    /// The data has shown all six directions, and the model explains the data.
    Converged,
    /// Some directions are unseen: they hold the prior, and its variance.
    Partial,
    /// Nothing of the inertia has been seen.
    Unobservable,
    /// The model doesn't explain the data: don't use the numbers.
    Diverged,
}

impl Status {
    /// What so many directions seen come to, where the model explains the data.
    pub(crate) fn of(observed: &Observed) -> Self {
        match observed.directions {
            6.. => Self::Converged,
            1..6 => Self::Partial,
            0 => Self::Unobservable,
        }
    }
}

/// The estimate, with what it is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<T: Real> {
    /// Inertia tensor.
    pub inertia: Inertia<T>,
    /// Covariance of the six elements, kg² m⁴, 6×6.
    pub covariance_kg2_m4: Mat<T, 6, 6>,
    /// Which directions the data has shown.
    pub observed: Observed,
    /// Whether to use it.
    pub status: Status,
    /// Constant disturbance torque in body axes, N m, where it is one of the unknowns.
    pub disturbance_torque_n_m: Option<Vec3<T>>,
    /// Gyro bias, rad/s, where it is one of the unknowns.
    pub gyro_bias_rad_s: Option<Vec3<T>>,
    /// RMS over the samples used, all axes, of measured minus predicted rate, rad/s.
    pub residual_rms_rad_s: T,
    /// Whether the residuals look like the gyro's white noise alone. `None` where that isn't tested.
    pub residuals_white: Option<bool>,
    /// Whether the data by itself asks for a tensor that no body has, so that `inertia` is the
    /// physical one nearest to that.
    pub projected: bool,
}

impl<T: Real> Estimate<T> {
    /// Where the inertia is all that is estimated: what has been seen is judged against the range
    /// of each element before the data, kg m², and no more than that is the status.
    pub(crate) fn of_inertia(
        inertia: Inertia<T>,
        covariance_kg2_m4: Mat<T, 6, 6>,
        range_kg_m2: &[T; 6],
        residual_rms_rad_s: T,
    ) -> Self {
        let mut estimate =
            Self { inertia, covariance_kg2_m4, residual_rms_rad_s, ..Self::of_nothing() };
        estimate.judge(range_kg_m2);
        estimate
    }

    /// All zero, to be filled in.
    pub(crate) fn of_nothing() -> Self {
        Self {
            inertia: Inertia::new([T::zero(); 6]),
            covariance_kg2_m4: Mat::zeros(),
            observed: Observed::default(),
            status: Status::Unobservable,
            disturbance_torque_n_m: None,
            gyro_bias_rad_s: None,
            residual_rms_rad_s: T::zero(),
            residuals_white: None,
            projected: false,
        }
    }

    /// Judges what has been seen, and so the status, as [`of_inertia`](Self::of_inertia) does.
    pub(crate) fn judge(&mut self, range_kg_m2: &[T; 6]) {
        self.observed = observed(&self.covariance_kg2_m4, range_kg_m2);
        self.status = Status::of(&self.observed);
    }

    /// While there is no estimator.
    pub fn nothing() -> Self {
        let Prior { inertia_kg_m2, sigma_kg_m2 } = Prior::unknown();
        let covariance = Mat::from_diagonal(&sigma_kg_m2.map(|s| s * s).into());
        Self::of_inertia(Inertia::new(inertia_kg_m2), covariance, &sigma_kg_m2, T::zero())
    }

    /// One sigma of each element, kg m².
    pub fn sigma_kg_m2(&self) -> [T; 6] {
        core::array::from_fn(|i| self.covariance_kg2_m4[(i, i)].max(T::zero()).sqrt())
    }

    /// The elements divided by the trace, and one sigma of each.
    ///
    /// With `n = j / tr`, `∂n/∂j = (1 − n tᵀ) / tr`, `t = (1 1 1 0 0 0)`. Of torque-free motion
    /// without wheels this is all that can be known.
    pub fn over_trace(&self) -> ([T; 6], [T; 6]) {
        let scale = T::one() / self.inertia.trace_kg_m2();
        let ratio = self.inertia.elements_kg_m2().map(|x| x * scale);
        let mut jacobian = Mat::<T, 6, 6>::identity();
        for i in 0..6 {
            for k in 0..3 {
                jacobian[(i, k)] -= ratio[i];
            }
        }
        let covariance = jacobian * self.covariance_kg2_m4 * jacobian.transpose();
        let sigma =
            core::array::from_fn(|i| covariance[(i, i)].max(T::zero()).sqrt() * scale.abs());
        (ratio, sigma)
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format> defmt::Format for Estimate<T> {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(
            f,
            "{}: {} +- {} kg m2, {}, residual {} rad/s",
            self.status,
            self.inertia,
            self.sigma_kg_m2(),
            self.observed,
            self.residual_rms_rad_s
        );
    }
}
