//! `momentum-batch`, `momentum-conventional`, `momentum-pre-estimate`, `momentum-suggested`: the
//! four estimators of \[Kim2010\], by conservation of momentum in inertial space.
//!
//! ```text
//!  sample ─► balance ─► sums ─────────► formulas ─► elements   Eqs. (3), (10), (14) to (16)
//!            m, Q       [Σ m mᵀ, Σ m Qᵀ]   └──────► worth      covariance, observed directions
//! ```
//!
//! With P the matrix from inertial into body axes, total momentum `P⁻¹ (J ω + h_w)` stays what it
//! was at the start, Eq. (7), and so `J m = Q` with
//!
//! `m = ω(t) − P(t) P(0)⁻¹ ω(0)`, `Q = P(t) P(0)⁻¹ h_w(0) − h_w(t)`.
//!
//! Nothing is differentiated. The four methods differ in how they solve `J m = Q`; all read the
//! same sums, so [`Method`] only says which formula [`estimate`](Momentum::estimate) uses.
//!
//! Departures from the paper:
//! * The paper starts at rest, `ω(0) = 0`. So does this where the first sample is within
//!   [`rest_sigma`](Config::rest_sigma) of zero; else the measured `ω(0)` enters `m` as above, and
//!   its noise, which stands in all rows, enters the covariance.
//! * The paper has no external torque. A known one changes the momentum in inertial space by
//!   `∫ P⁻¹ τ dt` (trapezoidal rule), which joins Q. An unknown one is an error of Q that only the
//!   residual betrays.
//! * The paper gives no covariance. Here the elements are always what the formula says, however
//!   wrong, and the covariance is about *them*: what the method neglects and what noise in the
//!   regressor does are part of it. Where the formula divides by nothing, the prior is held.
//!
//! What to expect: gyro noise in m pulls every element towards zero, and nothing here takes it
//! out, as the paper doesn't. Noise of the attitude and of the tachometers is left out of the
//! covariance. There is no prediction to compare a sample with, and so no spike is recognised.

mod formulas;
mod sums;
mod worth;

pub use formulas::Method;

use super::{Coasting, Estimate, Estimator, Innovation, Outcome, Prior, Reset, Status};
use crate::dynamics::wheels::WheelArray;
use crate::error::{ConfigError, not_negative, positive};
use crate::gate::{self, Gate, Verdict};
use crate::math::{Mat, Vec3, scalar::Real};
use crate::monitor::observability::{Observed, observed};
use crate::sample::Sample;
use crate::tensor::Inertia;
use sums::Sums;
use worth::Worth;

/// Samples, at least, before their residual is believed to condemn the model.
const WARM_UP: u32 = 64;

/// Squared residual over what gyro noise explains, above which the model doesn't explain the
/// data: as for the innovations of the filters, gyro noise stated up to 1.4 times too small.
const DIVERGED: f64 = 2.0;

/// Configuration, fixed for the estimator's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// Which of the paper's formulas.
    pub method: Method,
    /// Gyro noise, one sigma, white, per sample, rad/s.
    pub gyro_noise_rad_s: T,
    /// What is believed beforehand. The paper has none, and the formulas make no use of it: it
    /// says what sigma an element has that the data doesn't show. Default none: the size of the
    /// inertia along the motion, and half of it for the products.
    pub prior: Option<Prior<T>>,
    /// A first sample within so many sigma of zero on every axis is a start from rest, as in the
    /// paper. Default 5; with infinity every start is.
    pub rest_sigma: T,
    /// Which samples are looked at. Default as for every estimator.
    pub gate: gate::Config<T>,
}

impl<T: Real> Config<T> {
    /// The paper's `method`.
    pub fn kim_2010(method: Method, gyro_noise_rad_s: T) -> Self {
        let gate = gate::Config::default();
        Self { method, gyro_noise_rad_s, prior: None, rest_sigma: T::lit(5.0), gate }
    }

    /// Refuses the first field that is out of its range, by name.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gyro_noise_rad_s", self.gyro_noise_rad_s)?;
        if let Some(prior) = &self.prior {
            prior.validate()?;
        }
        not_negative("rest_sigma", self.rest_sigma)?;
        self.gate.validate()
    }
}

/// The estimator, W wheels.
#[derive(Clone, Debug)]
pub struct Momentum<T: Real, const W: usize> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    balance: Option<Balance<T>>,
    sums: Sums<T>,
    rate_rad_s: Vec3<T>,
}

/// What is conserved, in inertial axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Balance<T: Real> {
    /// `P(0)⁻¹ h_w(0) + ∫ P⁻¹ τ dt`, N m s.
    momentum_n_m_s: Vec3<T>,
    /// `P(0)⁻¹ ω(0)`, rad/s; none for a start from rest.
    initial_rate_rad_s: Option<Vec3<T>>,
    /// When it was last brought up to date, and the external torque then, N m.
    time_us: u64,
    torque_n_m: Vec3<T>,
}

impl<T: Real, const W: usize> Momentum<T, W> {
    /// An estimator that waits for its first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        config.validate()?;
        Ok(Self {
            gate: Gate::new(config.gate),
            balance: None,
            sums: Sums::default(),
            rate_rad_s: Vec3::zeros(),
            config,
            wheels,
        })
    }

    fn is_at_rest(&self, rate_rad_s: &Vec3<T>) -> bool {
        let limit = self.config.rest_sigma * self.config.gyro_noise_rad_s;
        rate_rad_s.iter().all(|x| x.abs() <= limit)
    }

    fn balance_at(&self, sample: &Sample<T, W>, to_body: &Mat<T, 3, 3>) -> Balance<T> {
        let to_inertial = to_body.transpose();
        Balance {
            momentum_n_m_s: to_inertial * self.wheels.momentum_n_m_s(&sample.wheel_speed_rad_s),
            initial_rate_rad_s: Some(to_inertial * sample.rate_rad_s),
            time_us: sample.time_us,
            torque_n_m: to_inertial * sample.torque_n_m,
        }
    }

    /// `J m = Q` of this sample into the sums.
    fn add(&mut self, sample: &Sample<T, W>, to_body: &Mat<T, 3, 3>, balance: &Balance<T>) -> bool {
        let h_w = self.wheels.momentum_n_m_s(&sample.wheel_speed_rad_s);
        let q = to_body * balance.momentum_n_m_s - h_w;
        match balance.initial_rate_rad_s {
            None => self.sums.add(&sample.rate_rad_s, &q),
            Some(initial) => {
                self.sums.add_from_measured_start(&(sample.rate_rad_s - to_body * initial), &q)
            }
        }
    }

    fn take(&mut self, sample: &Sample<T, W>, to_body: &Mat<T, 3, 3>) -> Outcome {
        let now = self.balance_at(sample, to_body);
        self.rate_rad_s = sample.rate_rad_s;
        let Some(last) = self.balance else {
            let is_at_rest = self.is_at_rest(&sample.rate_rad_s);
            let first = Balance {
                initial_rate_rad_s: now.initial_rate_rad_s.filter(|_| !is_at_rest),
                ..now
            };
            self.balance = Some(first);
            if is_at_rest {
                self.add(sample, to_body, &first);
            }
            return Outcome::Reset(Reset::FirstSample);
        };
        let elapsed_us = sample.time_us.saturating_sub(last.time_us);
        let torque = last.torque_n_m + now.torque_n_m;
        let has_torque = [last.torque_n_m, now.torque_n_m].iter().any(|t| *t != Vec3::zeros());
        // Without torque momentum is conserved across any gap; with it, the impulse is unknown.
        if has_torque && elapsed_us > self.config.gate.max_gap_us {
            self.balance = Some(now);
            return Outcome::Reset(Reset::Gap);
        }
        let impulse = torque * (T::seconds(elapsed_us) * T::lit(0.5));
        let balance = Balance {
            momentum_n_m_s: last.momentum_n_m_s + impulse,
            initial_rate_rad_s: last.initial_rate_rad_s,
            ..now
        };
        self.balance = Some(balance);
        if self.add(sample, to_body, &balance) {
            Outcome::Updated
        } else {
            Outcome::Coasting(Coasting::Rejected(gate::Rejection::OutOfRange))
        }
    }

    fn status(&self, shown: &Observed, estimated: &Observed) -> Status {
        match (shown.directions, estimated.directions) {
            (0, _) => Status::Unobservable,
            _ if !self.explains_the_data() => Status::Diverged,
            (6, 6) => Status::Converged,
            _ => Status::Partial,
        }
    }

    fn explains_the_data(&self) -> bool {
        let ratio = self.sums.residual_rms_rad_s() / self.config.gyro_noise_rad_s;
        self.sums.samples() < WARM_UP || ratio * ratio <= T::lit(DIVERGED)
    }
}

impl<T: Real, const W: usize> Estimator<T, W> for Momentum<T, W> {
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        if let Verdict::Rejected(why) = self.gate.check(sample) {
            return Outcome::Coasting(Coasting::Rejected(why));
        }
        let attitude = sample.attitude.ok_or(crate::attitude::NoAttitude::Missing);
        match attitude.and_then(|q| q.to_body()) {
            Ok(to_body) => self.take(sample, &to_body),
            Err(why) => Outcome::Coasting(Coasting::NoAttitude(why)),
        }
    }

    /// Directions are those that the data has shown to an estimator of all six elements; the
    /// covariance is that of the method's own elements, which may be worse.
    fn estimate(&self) -> Estimate<T> {
        let Config { method, gyro_noise_rad_s, prior, .. } = &self.config;
        let worth = Worth::new(&self.sums, *gyro_noise_rad_s, prior.as_ref());
        let (elements, covariance_kg2_m4) = worth.of(*method);
        let range = &worth.believed().sigma_kg_m2;
        let shown = observed(&worth.covariance_of_the_best(), range);
        Estimate {
            inertia: Inertia::new(elements),
            covariance_kg2_m4,
            observed: shown,
            status: self.status(&shown, &observed(&covariance_kg2_m4, range)),
            disturbance_torque_n_m: None,
            gyro_bias_rad_s: None,
            residual_rms_rad_s: self.sums.residual_rms_rad_s(),
        }
    }

    /// The last sample's: nothing is filtered.
    fn rate_rad_s(&self) -> Vec3<T> {
        self.rate_rad_s
    }

    /// None: nothing is predicted.
    fn innovation(&self) -> Option<Innovation<T>> {
        None
    }
}
