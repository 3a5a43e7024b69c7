//! 3. The estimators: one trait, then a room for each system.

pub mod ekf_sgf;
pub mod joint_ekf;
pub mod momentum;
#[cfg(test)]
pub(crate) mod test_flight;
pub mod window;

use crate::attitude::NoAttitude;
use crate::error::{ConfigError, Invalid, finite, positive};
use crate::gate::Rejection;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::monitor::observability::{Observed, observed};
use crate::sample::Sample;
use crate::tensor::Inertia;

/// An on-board estimator of the inertia tensor.
pub trait Estimator<T: Real, const W: usize> {
    /// Takes in one gyro sample and says what became of it.
    ///
    /// Never panics, whatever the sample holds, and costs a bounded amount of work.
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome;

    /// What is known by now. Valid at any time; costs more than a step (an eigenproblem of six),
    /// so call it at the rate of telemetry, not of the gyro.
    fn estimate(&self) -> Estimate<T>;

    /// Filtered body rate, rad/s: good for every step.
    fn rate_rad_s(&self) -> Vec3<T>;

    /// Innovation of the last sample that was predicted, if any.
    fn innovation(&self) -> Option<Innovation<T>>;
}

impl<T: Real, const W: usize, E: Estimator<T, W> + ?Sized> Estimator<T, W> for &mut E {
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        (**self).step(sample)
    }

    fn estimate(&self) -> Estimate<T> {
        (**self).estimate()
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        (**self).rate_rad_s()
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        (**self).innovation()
    }
}

/// Inertia before any data, elements `jxx jyy jzz jxy jxz jyz`, taken as uncorrelated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior<T: Real> {
    /// Expected elements, kg m². Must be physical.
    pub inertia_kg_m2: [T; 6],
    /// One sigma of each, kg m², above zero. Observability is judged against it.
    pub sigma_kg_m2: [T; 6],
}

crate::persist!(
    [T: Real] Prior<T> { inertia_kg_m2, sigma_kg_m2 } if |prior| prior.validate().is_ok()
);

/// Range of a product over that of a moment, where it has to be made up: no physical product
/// exceeds half a moment.
const PRODUCT_RANGE: f64 = 0.5;

/// What is held as possible while nothing is known, kg m²: no spacecraft of this project's kind
/// is larger.
const UNKNOWN_RANGE_KG_M2: f64 = 1.0e4;

impl<T: Real> Prior<T> {
    /// Of a body of which only the size is known: moments of this much and no products, each
    /// with a sigma as large as it can be.
    pub fn of_size(moment_kg_m2: T) -> Self {
        let (m, product) = (moment_kg_m2, moment_kg_m2 * T::lit(PRODUCT_RANGE));
        let inertia_kg_m2 = Inertia::spherical(m).elements_kg_m2();
        Self { inertia_kg_m2, sigma_kg_m2: [m, m, m, product, product, product] }
    }

    /// Of a body of which nothing is known.
    pub fn unknown() -> Self {
        let inertia_kg_m2 = Inertia::spherical(T::one()).elements_kg_m2();
        Self { inertia_kg_m2, ..Self::of_size(T::lit(UNKNOWN_RANGE_KG_M2)) }
    }

    /// Whether an element's sigma is above this share of the mean moment.
    pub fn is_vague(&self, share: T) -> bool {
        let moment = Inertia::new(self.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0);
        self.sigma_kg_m2.iter().any(|sigma| *sigma > share * moment)
    }

    /// Refuses a tensor that no body has and a sigma that isn't positive.
    pub fn validate(&self) -> Result<(), ConfigError> {
        Inertia::new(self.inertia_kg_m2).check().map_err(|why| ConfigError {
            field: "prior.inertia_kg_m2",
            reason: Invalid::NotPhysical(why),
        })?;
        for sigma in self.sigma_kg_m2 {
            positive("prior.sigma_kg_m2", sigma)?;
            // Variance and information of it are numbers, too: else this is none.
            let variance = sigma * sigma;
            finite("prior.sigma_kg_m2", variance * (T::one() / variance))?;
        }
        Ok(())
    }
}

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// It updated the estimate.
    Updated,
    /// The estimate stands as it was, or was only predicted.
    Coasting(Coasting),
    /// Part of the state was set anew.
    Reset(Reset),
}

/// Why a sample didn't update the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Coasting {
    /// The gate refused it.
    Rejected(Rejection),
    /// Too far from the prediction to be the gyro's noise; the state was predicted without it.
    Spike,
    /// It was taken in, but what has moved so far isn't enough for a first estimate.
    Aligning,
    /// It went into the rate, but the window of the differentiator is still filling (after a
    /// start, or because this sample came unevenly spaced): the inertia waits.
    Refilling,
    /// This estimator needs the attitude, and the sample's can't be used.
    NoAttitude(NoAttitude),
    /// This estimator starts from rest, and the body moves.
    WaitingForRest,
}

/// Why part of the state was set anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reset {
    /// The first usable sample: the rate starts from it.
    FirstSample,
    /// The motion so far gave a first estimate of the inertia; the filter starts from it.
    Aligned,
    /// Too long without samples to predict across: the rate starts anew, the inertia stays.
    Gap,
    /// So many spikes in a row that it is the estimate that must be wrong (a deployment, a
    /// docking): all starts anew from the motion, and no prior is believed any more.
    Lockout,
    /// A manoeuvre's data contradict, by a chi-square test, what was known of the inertia before
    /// it (a prior, or earlier manoeuvres): that is dropped.
    Changed,
    /// The state left the finite numbers, or its inertia had no inverse: all starts anew.
    Diverged,
}

crate::persist!([] enum Reset {
    0 => FirstSample, 1 => Aligned, 2 => Gap, 3 => Lockout, 4 => Changed, 5 => Diverged
});

impl Outcome {
    /// What and why, in a word or two: for logs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Updated => "updated",
            Self::Coasting(Coasting::Rejected(why)) => why.name(),
            Self::Coasting(Coasting::Spike) => "spike",
            Self::Coasting(Coasting::Aligning) => "aligning",
            Self::Coasting(Coasting::Refilling) => "refilling",
            Self::Coasting(Coasting::NoAttitude(why)) => why.name(),
            Self::Coasting(Coasting::WaitingForRest) => "waiting_for_rest",
            Self::Reset(Reset::FirstSample) => "reset_first_sample",
            Self::Reset(Reset::Aligned) => "reset_aligned",
            Self::Reset(Reset::Gap) => "reset_gap",
            Self::Reset(Reset::Lockout) => "reset_lockout",
            Self::Reset(Reset::Changed) => "reset_changed",
            Self::Reset(Reset::Diverged) => "reset_diverged",
        }
    }

    /// Whether the sample was made use of.
    pub fn used_sample(&self) -> bool {
        match self {
            Self::Updated | Self::Reset(_) => true,
            Self::Coasting(Coasting::Aligning | Coasting::Refilling) => true,
            Self::Coasting(
                Coasting::Rejected(_)
                | Coasting::Spike
                | Coasting::NoAttitude(_)
                | Coasting::WaitingForRest,
            ) => false,
        }
    }
}

/// The difference between a gyro sample and its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation<T: Real> {
    /// Measured minus predicted rate, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Its variance on each axis by the filter's own covariance, gyro noise included, rad²/s².
    pub variance_rad2_s2: Vec3<T>,
}

crate::persist!([T: Real] Innovation<T> { rate_rad_s, variance_rad2_s2 });

impl<T: Real> Innovation<T> {
    /// Normalised innovation squared, axis by axis: three degrees of freedom. Leaves out the
    /// correlation between axes, which is small beside the gyro's noise.
    pub fn nis(&self) -> T {
        let [x, y, z] = self.squared_ratios();
        x + y + z
    }

    /// Square of the largest ratio of an axis to its sigma.
    pub fn squared_test_ratio(&self) -> T {
        let [x, y, z] = self.squared_ratios();
        x.max(y).max(z)
    }

    fn squared_ratios(&self) -> [T; 3] {
        let (r, v) = (&self.rate_rad_s, &self.variance_rad2_s2);
        [r.x * r.x / v.x, r.y * r.y / v.y, r.z * r.z / v.z]
    }
}

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
    fn of(observed: &Observed) -> Self {
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
    fn of_inertia(
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
    fn of_nothing() -> Self {
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
    fn judge(&mut self, range_kg_m2: &[T; 6]) {
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
impl<T: Real + defmt::Format> defmt::Format for Prior<T> {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{} +- {} kg m2", self.inertia_kg_m2, self.sigma_kg_m2);
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format> defmt::Format for Innovation<T> {
    fn format(&self, f: defmt::Formatter) {
        let (rate, variance) = (self.rate_rad_s.as_slice(), self.variance_rad2_s2.as_slice());
        defmt::write!(f, "{} rad/s, variance {} rad2/s2", rate, variance);
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
