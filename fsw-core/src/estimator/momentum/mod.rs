//! `momentum-batch`, `momentum-conventional`, `momentum-pre-estimate`, `momentum-suggested`: the
//! four estimators of \[Kim2010\], by conservation of angular momentum in inertial space.
//!
//! ```text
//!  sample ─► gate ─► balance ─► sums ─────────► formulas ─► elements  Eqs. (3), (10), (14) to (16)
//!                    ω, Q       Σ ω ωᵀ, Σ ω Qᵀ     └──────► covariance, observed directions
//! ```
//!
//! The total momentum `P⁻¹ (J ω + h_w)` in inertial axes is constant, Eq. (7); from a start at rest
//!
//! `J ω(t) = Q(t) = P(t) P(0)⁻¹ h_w(0) − h_w(t)`, Eqs. (8), (11),
//!
//! with P the matrix from inertial into body axes, ω in rad/s, Q and `h_w` in N m s. Nothing is
//! differentiated. The four methods solve this differently from the same sums, so [`Method`] only
//! selects the formula of [`estimate`](Momentum::estimate).
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `P` | rotation from inertial into body axes, from the attitude | – |
//! | `ω` | measured body rate | rad/s |
//! | `h_w` | momentum of the wheels relative to the body, body axes | N m s |
//! | `H` | total momentum, inertial axes | N m s |
//! | `Q` | the body's share of it, body axes | N m s |
//! | `M`, `B` | `Σ ω ωᵀ`, `Σ ω Qᵀ` | rad²/s², N m s rad/s |
//!
//! # Restarts
//!
//! | event | state afterwards | outcome |
//! |---|---|---|
//! | body in motion, no balance | waits | [`Coasting::WaitingForRest`] |
//! | first sample at rest | balance of the wheels | [`Reset::FirstSample`] |
//! | gap with a torque | waits for rest; sums unchanged | [`Reset::Gap`], [`Reset::Clock`] |
//! | momentum not finite | waits for rest; sums unchanged | [`Reset::Diverged`] |
//! | no usable attitude | unchanged | [`Coasting::NoAttitude`] |
//!
//! # Assumptions and departures
//!
//! Assumptions: a start at rest, a known attitude at every sample, no unknown external torque. Gyro
//! noise is white; noise of the attitude and of the tachometers is left out of the covariance.
//!
//! Departures from the paper:
//!
//! * The paper starts at rest, `ω(0) = 0`. The balance starts with the first sample within
//!   [`rest_sigma`](Config::rest_sigma) of zero. With ω(0) ≠ 0 the right-hand side contains `P(t)
//!   P(0)⁻¹ J ω(0)` with the unknown J. The four formulas do not include this term.
//! * The paper has no external torque. A known one joins Q as its impulse. An unknown one is an
//!   error of Q that only the residual reveals.
//! * The paper gives no covariance. Here the elements are always the formula's, and the covariance
//!   is that of *their* error: the terms that a method neglects and the bias by noise in the
//!   regressor are part of it. An element whose formula divides by zero takes the prior.
//!
//! # Accuracy
//!
//! The slew of the paper excites three directions of six: its gains are proportional to J and its
//! initial angles equal, so it turns about one fixed axis and the three rates are proportional. The
//! regressor has rank 1, and the "batch" column of Table 2 is noise. The estimate reports three
//! observed directions there.
//!
//! Gyro noise in ω biases every element towards zero, and as in the paper nothing removes
//! it. Without a prediction there is no innovation, and no spike gate: a spike of the gyro enters
//! the sums.
//!
//! # Example
//!
//! ```
//! use fsw_core::estimator::momentum::{Config, Method, Momentum};
//! use fsw_core::{Estimator, Outcome, Quaternion, Reset, Sample, Vec3, WheelArray};
//!
//! let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
//! let wheels = WheelArray::new(axes, [4.113e-4f32; 3])?;
//! let config = Config::kim_2010(Method::Suggested, 1e-4);
//! let mut estimator = Momentum::new(config, wheels)?;
//! let outcome = estimator.step(&Sample {
//!     time_us: 0,
//!     rate_rad_s: Vec3::zeros(),
//!     wheel_speed_rad_s: [0.0; 3],
//!     torque_n_m: Vec3::zeros(),
//!     attitude: Some(Quaternion::identity()),
//! });
//! assert_eq!(outcome, Outcome::Reset(Reset::FirstSample));
//! # Ok::<(), fsw_core::ConfigError>(())
//! ```

mod balance;
mod config;
mod covariance;
mod formulas;
mod sums;
#[cfg(test)]
mod tests;

pub use config::Config;
pub use formulas::Method;

use crate::attitude::NoAttitude;
use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::estimate::{Estimate, Status};
use crate::estimator::Estimator;
use crate::gate::{Gate, Rejection, Verdict};
use crate::math::{Mat, Vec3, scalar::Real};
use crate::monitor::innovation::Innovation;
use crate::monitor::observability::{Observed, observed, range_before_data};
use crate::outcome::{Coasting, Outcome, Reset};
use crate::sample::Sample;
use crate::tensor::Inertia;
use balance::Balance;
use covariance::ErrorModel;
use sums::Sums;

/// Samples before the residual is tested: its relative scatter is then below √(1/(2 · 3 · 64)) =
/// 0.05.
const WARM_UP: u32 = 64;

/// Squared residual over that of the stated gyro noise, above which the model does not explain the
/// data. As for the innovations of the filters: gyro noise stated up to 1.4 times too small passes.
const DIVERGED: f64 = 2.0;

/// The estimator, W wheels.
#[derive(Clone, Debug)]
pub struct Momentum<T: Real, const W: usize> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    /// None before the first sample at rest, and after an unknown impulse.
    balance: Option<Balance<T>>,
    /// Since the first sample at rest.
    sums: Sums<T>,
    /// Of the last sample.
    rate_rad_s: Vec3<T>,
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

    /// One step: rest or balance, then the sums.
    fn update(&mut self, sample: &Sample<T, W>, to_body: &Mat<T, 3, 3>) -> Outcome {
        self.rate_rad_s = sample.rate_rad_s;
        let now = Balance::at_rest(&self.wheels, sample, to_body);
        let Some(last) = self.balance else {
            return self.start(sample, to_body, now);
        };
        if last.has_unknown_impulse(&now, self.config.gate.max_gap_us) {
            self.balance = self.is_at_rest(&sample.rate_rad_s).then_some(now);
            return Outcome::Reset(if last.is_before(&now) { Reset::Gap } else { Reset::Clock });
        }
        self.balance = last.advanced_to(&now);
        let Some(balance) = self.balance else {
            return Outcome::Reset(Reset::Diverged);
        };
        if self.add(sample, to_body, &balance) {
            Outcome::Updated
        } else {
            Outcome::Coasting(Coasting::Rejected(Rejection::OutOfRange))
        }
    }

    /// Starts the balance with a sample at rest.
    fn start(&mut self, sample: &Sample<T, W>, to_body: &Mat<T, 3, 3>, now: Balance<T>) -> Outcome {
        if !self.is_at_rest(&sample.rate_rad_s) {
            return Outcome::Coasting(Coasting::WaitingForRest);
        }
        self.balance = Some(now);
        self.add(sample, to_body, &now);
        Outcome::Reset(Reset::FirstSample)
    }

    /// True if the rate is within [`Config::rest_sigma`] of zero on every axis.
    fn is_at_rest(&self, rate_rad_s: &Vec3<T>) -> bool {
        let limit = self.config.rest_sigma * self.config.gyro_noise_rad_s;
        rate_rad_s.iter().all(|x| x.abs() <= limit)
    }

    /// Adds the rows `J ω = Q` of one sample; `false` where a number is out of range.
    fn add(&mut self, sample: &Sample<T, W>, to_body: &Mat<T, 3, 3>, balance: &Balance<T>) -> bool {
        let h_w = self.wheels.momentum_n_m_s(&sample.wheel_speed_rad_s);
        self.sums.add(&sample.rate_rad_s, &balance.body_momentum_n_m_s(to_body, &h_w))
    }

    /// Status from the directions that the data observes and those that the method estimates.
    fn status(&self, observed: &Observed, estimated: &Observed) -> Status {
        match (observed.directions, estimated.directions) {
            (0, _) => Status::Unobservable,
            _ if !self.explains_the_data() => Status::Diverged,
            (6, 6) => Status::Converged,
            _ => Status::Partial,
        }
    }

    /// True if the residual is that of the stated gyro noise: `(σ_residual / σ)² ≤ 2`.
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
        let attitude = sample.attitude.ok_or(NoAttitude::Missing);
        match attitude.and_then(|q| q.to_body()) {
            Ok(to_body) => self.update(sample, &to_body),
            Err(why) => Outcome::Coasting(Coasting::NoAttitude(why)),
        }
    }

    /// Observed directions are those of an estimator of all six elements on the same data; the
    /// covariance is that of the method's own elements, which may be larger.
    fn estimate(&self) -> Estimate<T> {
        let Config { method, gyro_noise_rad_s, prior, .. } = &self.config;
        let model = ErrorModel::new(&self.sums, *gyro_noise_rad_s, prior.as_ref());
        let (elements, covariance_kg2_m4) = model.solve(*method);
        let inertia = Inertia::new(elements);
        let range = &range_before_data(&inertia, &model.prior().sigma_kg_m2);
        let by_the_data = observed(&model.least_squares_covariance(), range);
        let mut estimate = Estimate {
            inertia,
            covariance_kg2_m4,
            sigma_random_kg_m2: None,
            trace_spread: T::zero(),
            observed: by_the_data,
            status: self.status(&by_the_data, &observed(&covariance_kg2_m4, range)),
            disturbance_torque_n_m: None,
            gyro_bias_rad_s: None,
            residual_rms_rad_s: self.sums.residual_rms_rad_s(),
            residuals_white: None,
            projected: false,
        };
        estimate.limit_status();
        estimate
    }

    /// The last sample's rate: nothing is filtered.
    fn rate_rad_s(&self) -> Vec3<T> {
        self.rate_rad_s
    }

    /// None: nothing is predicted.
    fn innovation(&self) -> Option<Innovation<T>> {
        None
    }
}
