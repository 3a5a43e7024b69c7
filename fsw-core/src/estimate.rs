//! Estimate: inertia tensor, covariance, observed directions, status.
//!
//! Output of every estimator, at the rate of telemetry.

use crate::math::{Entries, Mat, Vec3, scalar::Real};
use crate::monitor::observability::{Observed, observed, range_before_data};
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Usability of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Status {
    /// All six directions are observed, and the model explains the data.
    Converged,
    /// Some directions are unobserved: they keep the prior and its variance. Or the elements are those of no rigid body,
    /// [`Inertia::check`], by an error that the covariance may allow.
    Partial,
    /// No direction is observed.
    Unobservable,
    /// The model does not explain the data: the numbers are not usable.
    Diverged,
}

impl Status {
    /// Status of a model that explains the data, by the number of observed directions.
    pub(crate) fn of(observed: &Observed) -> Self {
        match observed.directions {
            6.. => Self::Converged,
            1..6 => Self::Partial,
            0 => Self::Unobservable,
        }
    }
}

/// Inertia with its covariance, and further unknowns where they are estimated.
///
/// | field | known to |
/// |---|---|
/// | `inertia`, `covariance_kg2_m4`, `observed`, `status` | every estimator |
/// | `residual_rms_rad_s` | every estimator |
/// | `disturbance_torque_n_m`, `gyro_bias_rad_s` | `window`, where they are unknowns |
/// | `residuals_white`, `sigma_random_kg_m2` | `window`, `joint_ekf` |
/// | `projected` | `window` |
///
/// ```
/// use fsw_core::{Estimate, Status};
///
/// let before_any_data = Estimate::<f32>::nothing();
/// assert_eq!(before_any_data.status, Status::Unobservable);
/// assert_eq!(before_any_data.observed.directions, 0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<T: Real> {
    /// Inertia tensor.
    pub inertia: Inertia<T>,
    /// Covariance of the six elements, 6×6, kg² m⁴: of the noise and of the stated errors of the hardware.
    pub covariance_kg2_m4: Mat<T, 6, 6>,
    /// One sigma of each element by the noise alone, for hardware that is known exactly, kg m². `None` where the
    /// hardware is ideal, and the covariance is that of the noise.
    pub sigma_random_kg_m2: Option<[T; 6]>,
    /// Relative sigma r of a badly known trace t that the covariance contains beside a ratio n, a term `var(n) r² t²` of their
    /// product: zero where the trace is known well. Sigmas of ratios are without it ([`over_trace`](Self::over_trace)).
    pub trace_spread: T,
    /// Directions that the data have made known.
    pub observed: Observed,
    /// Usability.
    pub status: Status,
    /// Constant disturbance torque in body axes, N m, where it is an unknown.
    pub disturbance_torque_n_m: Option<Vec3<T>>,
    /// Gyro bias, rad/s, where it is an unknown.
    pub gyro_bias_rad_s: Option<Vec3<T>>,
    /// RMS over the used samples, all axes, of measured minus predicted rate, rad/s.
    pub residual_rms_rad_s: T,
    /// Result of a whiteness test: true where the residuals agree with the gyro's white noise.
    /// `None` without a test.
    pub residuals_white: Option<bool>,
    /// True where the data alone lead to an unphysical tensor: `inertia` is then the nearest
    /// physical one.
    pub projected: bool,
}

impl<T: Real> Estimate<T> {
    /// Estimate of the inertia alone. The observed directions are judged against the range of each
    /// element before the data, kg m², limited by [`range_before_data`], and decide the status.
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

    /// Zeros, to be filled in.
    pub(crate) fn of_nothing() -> Self {
        Self {
            inertia: Inertia::new([T::zero(); 6]),
            covariance_kg2_m4: Mat::zeros(),
            sigma_random_kg_m2: None,
            trace_spread: T::zero(),
            observed: Observed::default(),
            status: Status::Unobservable,
            disturbance_torque_n_m: None,
            gyro_bias_rad_s: None,
            residual_rms_rad_s: T::zero(),
            residuals_white: None,
            projected: false,
        }
    }

    /// Variance that a ratio has in the covariance of the elements, over its own: `1 + r²`, with r the
    /// [`trace_spread`](Self::trace_spread).
    pub(crate) fn spread_of_variance(&self) -> T {
        T::one() + self.trace_spread * self.trace_spread
    }

    /// Observed directions and status, as in [`of_inertia`](Self::of_inertia).
    pub(crate) fn judge(&mut self, range_kg_m2: &[T; 6]) {
        let range_kg_m2 = range_before_data(&self.inertia, range_kg_m2);
        self.observed = observed(&self.covariance_kg2_m4, &range_kg_m2);
        self.status = Status::of(&self.observed);
        self.limit_status();
    }

    /// The tensor of no rigid body is not converged.
    #[inline(never)]
    pub(crate) fn limit_status(&mut self) {
        if self.status == Status::Converged && self.inertia.check().is_err() {
            self.status = Status::Partial;
        }
    }

    /// Estimate without an estimator: the unknown prior.
    #[inline(never)] // inlined, its locals add 200 bytes to the stack of every report
    pub fn nothing() -> Self {
        let Prior { inertia_kg_m2, sigma_kg_m2 } = Prior::unknown();
        let covariance = Mat::from_diagonal(&sigma_kg_m2.map(|s| s * s).into());
        Self::of_inertia(Inertia::new(inertia_kg_m2), covariance, &sigma_kg_m2, T::zero())
    }

    /// One sigma of each element, kg m², order `jxx jyy jzz jxy jxz jyz`: square roots of the
    /// diagonal of the covariance.
    ///
    /// ```
    /// use fsw_core::Estimate;
    ///
    /// let sigma_kg_m2 = Estimate::<f64>::nothing().sigma_kg_m2();
    /// assert_eq!(sigma_kg_m2, [1e4, 1e4, 1e4, 5e3, 5e3, 5e3]);
    /// ```
    pub fn sigma_kg_m2(&self) -> [T; 6] {
        core::array::from_fn(|i| self.covariance_kg2_m4.at(i, i).max(T::zero()).sqrt())
    }

    /// One sigma of each element by the errors of the hardware, kg m²: total less random variance.
    pub fn sigma_systematic_kg_m2(&self) -> [T; 6] {
        let Some(random) = self.sigma_random_kg_m2 else { return [T::zero(); 6] };
        core::array::from_fn(|i| {
            let variance = self.covariance_kg2_m4.at(i, i) - random[i] * random[i];
            variance.max(T::zero()).sqrt()
        })
    }

    /// Elements relative to the trace, `n = j / tr`, and one sigma of each.
    ///
    /// Covariance `N P Nᵀ` with `N = ∂n/∂j = (1 − n tᵀ) / tr`, `t = (1 1 1 0 0 0)`. Torque-free
    /// motion without wheels determines these ratios and nothing else.
    ///
    /// ```
    /// use fsw_core::math::Mat;
    /// use fsw_core::{Estimate, Inertia};
    ///
    /// // Known up to a common factor: P = s² j jᵀ leaves no uncertainty of the ratios.
    /// let j = [1.0, 2.0, 2.0, 0.1, 0.0, 0.0];
    /// let column = Mat::<f64, 6, 1>::from(j);
    /// let estimate = Estimate {
    ///     inertia: Inertia::new(j),
    ///     covariance_kg2_m4: column * column.transpose() * 0.04,
    ///     ..Estimate::nothing()
    /// };
    /// let (ratio, sigma) = estimate.over_trace();
    /// assert_eq!(ratio[0], 0.2);
    /// assert!(sigma.iter().all(|sigma| *sigma < 1e-8));
    /// ```
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
        let spread = self.spread_of_variance();
        let sigma = core::array::from_fn(|i| {
            (covariance.at(i, i).max(T::zero()) / spread).sqrt() * scale.abs()
        });
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
