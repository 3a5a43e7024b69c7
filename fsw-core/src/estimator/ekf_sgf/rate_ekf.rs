//! Rate filter: three states, nominal inertia, \[Kim2013\], \[Kim2016\] Table 1.
//!
//! Input: measured rate and the drive between samples. Output: filtered rate ω̂ (rad/s), its
//! covariance P (rad²/s²), and the innovation.
//!
//! Process and measurement, `J₀` the nominal inertia (kg m²):
//!
//! `ω̇ = J₀⁻¹ (τ − ḣ_w − ω × (J₀ ω + h_w)) + w`, `y = ω + v`, `H = 1`
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `ω̂⁻`, `ω̂` | rate before and after the correction | rad/s |
//! | `P⁻`, `P` | its covariance | rad²/s² |
//! | `F`, `Φ` | `∂ω̇/∂ω`, transition over the interval | 1/s, – |
//! | `Q` | process noise | rad²/s³ |
//! | `R` | variance of the gyro noise | rad²/s² |
//! | `K` | gain | – |
//!
//! Continuous-discrete: state and covariance are propagated over the interval between two samples,
//! then corrected with the sample. The filter reduces the gyro's noise before differentiation; the
//! inertia is estimated by [`regression`](super::regression).
//!
//! Departures from Table 1:
//!
//! * wheels: the papers have none;
//! * the covariance goes through the interval by its transition, `Φ P Φᵀ + Q Δt`, instead of an
//!   integration of `Ṗ = F P + P Fᵀ + Q`;
//! * the corrected covariance is `P = K R`. It equals `(1 − K) P` for `H = 1` and R alike on each
//!   axis, without the difference that costs the latter its positivity in single precision;
//! * the process noise, whose values the papers leave open, has a part that grows with the
//!   acceleration (see [`Config::acceleration_doubt`]).
//!
//! Valid range: any gyro noise whose square fits the precision. The gain is formed from `P / R`, so
//! no power of R above the first appears.
//!
//! ```
//! use fsw_core::estimator::ekf_sgf::rate_ekf::{Config, RateEkf};
//! use fsw_core::{Inertia, Vec3};
//!
//! let nominal = Inertia::new([7.1f32, 8.65, 10.15, 0.0, 0.0, 0.0]);
//! let mut filter = RateEkf::new(Config::new(1e-4), &nominal)?;
//! filter.restart(&Vec3::new(0.01, 0.0, 0.0));
//! let innovation = filter.innovation(&Vec3::new(0.0101, 0.0, 0.0));
//! assert!((innovation.rate_rad_s.x - 1e-4).abs() < 1e-7);
//! # Ok::<(), fsw_core::ConfigError>(())
//! ```

use super::Innovation;
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::Interval;
use crate::dynamics::step::{Transition, runge_kutta_4};
use crate::error::ConfigError;
use crate::math::range::{not_negative, positive};
use crate::math::{Mat, Vec3, inverse_symmetric, scalar::Real};
use crate::tensor::Inertia;

/// Configuration, fixed for the filter's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// Gyro noise, one sigma, white, per sample, rad/s, above zero. Must be given.
    pub gyro_noise_rad_s: T,
    /// Random walk of the rate, the same on each axis, (rad/s)/√s, zero or above: the square root
    /// of Q in \[Kim2016\] Table 1. Ours, since both papers leave it open: a hundredth of the gyro
    /// noise per √s, for slow disturbances only.
    pub rate_walk_rad_s_sqrt_s: T,
    /// Relative sigma of the change of rate that the nominal model predicts, dimensionless, zero or
    /// above: adds `(doubt · |Δω|)²` to the variance of each axis at each step. Ours; the papers
    /// have a constant Q, which is this at 0.
    ///
    /// It bounds the lag behind the true rate to about `(relative error of J₀ / doubt)` gyro sigmas
    /// in any manoeuvre, where a constant Q suits one manoeuvre. A larger value means less lag and
    /// noisier accelerations. Default 0.2: an inertia half wrong then lags by 2.5 sigma, which is
    /// no spike.
    pub acceleration_doubt: T,
}

crate::persist!([T: Real] Config<T> {
    gyro_noise_rad_s, rate_walk_rad_s_sqrt_s, acceleration_doubt
});

impl<T: Real> Config<T> {
    /// Defaults for a gyro of this noise (one sigma, white, per sample, rad/s).
    pub fn new(gyro_noise_rad_s: T) -> Self {
        let rate_walk_rad_s_sqrt_s = gyro_noise_rad_s * T::lit(0.01);
        let acceleration_doubt = T::lit(0.2);
        Self { gyro_noise_rad_s, rate_walk_rad_s_sqrt_s, acceleration_doubt }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// Names the first field that is out of its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gyro_noise_rad_s", self.gyro_noise_rad_s)?;
        not_negative("rate_walk_rad_s_sqrt_s", self.rate_walk_rad_s_sqrt_s)?;
        not_negative("acceleration_doubt", self.acceleration_doubt)
    }
}

/// Filtered rate and its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateEkf<T: Real> {
    config: Config<T>,
    /// Body of the inertia J₀.
    nominal: Gyrostat<T>,
    /// ω̂.
    rate_rad_s: Vec3<T>,
    /// P, rad²/s².
    covariance: Mat<T, 3, 3>,
}

// A telecommand may set the nominal inertia, which is therefore state.
crate::persist!([T: Real] RateEkf<T> { nominal, rate_rad_s, covariance; unchanged config });

impl<T: Real> RateEkf<T> {
    /// A filter at rest, with the gyro's covariance, until [`restart`](Self::restart).
    ///
    /// # Errors
    /// The first field of `config` that is out of its range, or `nominal` where that tensor is not
    /// physical.
    pub fn new(config: Config<T>, nominal: &Inertia<T>) -> Result<Self, ConfigError> {
        use crate::error::Invalid;
        use crate::error::NotPhysical;
        config.validate()?;
        let refuse = |why| ConfigError { field: "nominal", reason: Invalid::NotPhysical(why) };
        nominal.check().map_err(refuse)?;
        let singular = || refuse(NotPhysical::NotPositiveDefinite);
        let nominal = Gyrostat::new(nominal).ok_or_else(singular)?;
        let covariance = Mat::identity() * (config.gyro_noise_rad_s * config.gyro_noise_rad_s);
        Ok(Self { config, nominal, rate_rad_s: Vec3::zeros(), covariance })
    }

    /// Starts from a measured rate with the gyro's covariance, `ω̂ = y`, `P = R`. Ours: the papers
    /// leave the initial state open.
    pub fn restart(&mut self, rate_rad_s: &Vec3<T>) {
        self.rate_rad_s = *rate_rad_s;
        self.covariance = Mat::identity() * self.noise_variance();
    }

    /// Prediction over one interval of length Δt (s): the rate by one Runge-Kutta step of the
    /// gyrostat equation, and
    ///
    /// `P⁻ = Φ P⁺ Φᵀ + (s² Δt + doubt² |Δω|²) 1`
    ///
    /// with s the random walk, (rad/s)/√s, and Δω the predicted change of rate, rad/s.
    pub fn predict(&mut self, interval: &Interval<T>) {
        let start = self.rate_rad_s;
        self.rate_rad_s = runge_kutta_4(&self.nominal, &start, interval);
        let transition = Transition::of_rate(&self.nominal, &start, &self.rate_rad_s, interval);
        self.covariance = transformed(&transition, &self.covariance);
        let change = (self.rate_rad_s - start) * self.config.acceleration_doubt;
        let walk = self.config.rate_walk_rad_s_sqrt_s;
        let q = walk * walk * interval.duration_s + change.dot(&change);
        for i in 0..3 {
            self.covariance[(i, i)] += q;
        }
    }

    /// Innovation `ν = y − ω̂⁻` (rad/s) and the diagonal of `S = P⁻ + R` (rad²/s²).
    pub fn innovation(&self, measured_rad_s: &Vec3<T>) -> Innovation<T> {
        let r = self.noise_variance();
        Innovation {
            rate_rad_s: measured_rad_s - self.rate_rad_s,
            variance_rad2_s2: Vec3::from_fn(|i, _| self.covariance[(i, i)] + r),
        }
    }

    /// Correction with a measured rate y (rad/s), \[Kim2016\] Table 1 with `H = 1`:
    ///
    /// `K = P (P + R)⁻¹ = (P/R) (P/R + 1)⁻¹`, `ω̂ ← ω̂ + K (y − ω̂)`, `P ← K R`
    ///
    /// The division by R comes first, since rad²/s² of a quiet gyro, cubed in a determinant,
    /// underflow in single precision. Without effect where `P + R` has no inverse: see
    /// [`is_valid`](Self::is_valid).
    pub fn update(&mut self, measured_rad_s: &Vec3<T>) {
        let r = self.noise_variance();
        let in_sigmas = self.covariance * (T::one() / r);
        let Some(inverse) = inverse_symmetric(&(in_sigmas + Mat::identity())) else { return };
        let gain = symmetric_product(&in_sigmas, &inverse);
        self.rate_rad_s += gain * (measured_rad_s - self.rate_rad_s);
        self.covariance = gain * r;
    }

    /// Filtered rate, rad/s.
    pub fn rate_rad_s(&self) -> Vec3<T> {
        self.rate_rad_s
    }

    /// P: the filter's own covariance of the rate, rad²/s², 3×3.
    pub fn covariance(&self) -> Mat<T, 3, 3> {
        self.covariance
    }

    /// Mean gain after a correction, `K = tr(P) / (3 R)`, limited to ε…1: 1 copies the gyro, near 0
    /// follows the model. Noise that remains in the rate is that of a first-order lag, with
    /// correlation `1 − K` from sample to sample.
    pub fn mean_gain(&self) -> T {
        let gain = self.covariance.trace() / (self.noise_variance() * T::lit(3.0));
        gain.max(T::EPSILON).min(T::one())
    }

    /// True if every number is finite and no variance negative.
    pub fn is_valid(&self) -> bool {
        // An infinity or a NaN in any term makes the sum one.
        let (rate, p) = (&self.rate_rad_s, &self.covariance);
        let upper = p[(0, 1)] + p[(0, 2)] + p[(1, 2)];
        (rate.x + rate.y + rate.z + p.trace() + upper).is_finite()
            && (0..3).all(|i| self.covariance[(i, i)] >= T::zero())
    }

    /// R: variance of the gyro noise on each axis, rad²/s².
    fn noise_variance(&self) -> T {
        self.config.gyro_noise_rad_s * self.config.gyro_noise_rad_s
    }
}

/// `A P Aᵀ` of a symmetric P, from its upper triangle.
fn transformed<T: Real>(a: &Mat<T, 3, 3>, p: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    symmetric_product(&(a * p), &a.transpose())
}

/// `A B` where the product is known to be symmetric: the upper triangle, mirrored.
fn symmetric_product<T: Real>(a: &Mat<T, 3, 3>, b: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    let element =
        |i: usize, k: usize| a[(i, 0)] * b[(0, k)] + a[(i, 1)] * b[(1, k)] + a[(i, 2)] * b[(2, k)];
    let (xx, xy, xz) = (element(0, 0), element(0, 1), element(0, 2));
    let (yy, yz, zz) = (element(1, 1), element(1, 2), element(2, 2));
    Mat::<T, 3, 3>::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::interval::Drive;
    use proptest::prelude::*;

    const NOMINAL: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const NOISE_RAD_S: f64 = 1e-3;

    /// 0.1 s of constant torque, N m, and constant wheel momentum.
    fn interval<T: Real>(torque: [f64; 3]) -> Interval<T> {
        let drive = Drive {
            torque_n_m: Vec3::from(torque.map(T::lit)),
            wheel_momentum_n_m_s: Vec3::new(T::zero(), T::lit(0.1), T::zero()),
        };
        Interval { duration_s: T::lit(0.1), start: drive, middle: drive, end: drive }
    }

    /// A filter with the true inertia as nominal and no random walk.
    fn filter<T: Real>(doubt: f64) -> RateEkf<T> {
        let config = Config {
            acceleration_doubt: T::lit(doubt),
            rate_walk_rad_s_sqrt_s: T::zero(),
            ..Config::new(T::lit(NOISE_RAD_S))
        };
        RateEkf::new(config, &Inertia::new(NOMINAL.map(T::lit))).unwrap()
    }

    #[test]
    fn with_the_true_inertia_noise_averages_out() {
        let mut ekf = filter::<f64>(0.0);
        let mut rate = Vec3::new(0.1, -0.2, 0.05);
        ekf.restart(&rate);
        for k in 0..400 {
            let iv = interval([0.01, 0.02, -0.01]);
            rate = runge_kutta_4(&ekf.nominal, &rate, &iv);
            ekf.predict(&iv);
            let noise = if k % 2 == 0 { NOISE_RAD_S } else { -NOISE_RAD_S };
            ekf.update(&(rate + Vec3::repeat(noise)));
        }
        assert!((ekf.rate_rad_s() - rate).norm() < 0.02 * NOISE_RAD_S);
        // 400 samples of equal weight: the sigma falls as 1/√n, stretched by the motion.
        let sigma = ekf.covariance().trace().sqrt() / NOISE_RAD_S;
        assert!((0.05..0.3).contains(&sigma), "{sigma}");
    }

    #[test]
    fn doubt_bounds_the_lag_of_a_wrong_inertia() {
        let mut ekf = filter::<f64>(1.0);
        let truth = Gyrostat::new(&Inertia::new(NOMINAL.map(|x| 2.0 * x))).unwrap();
        let mut rate = Vec3::new(0.1, -0.2, 0.05);
        ekf.restart(&rate);
        let mut worst = 0.0f64;
        for k in 0..600 {
            let t = f64::from(k) * 0.1;
            let iv = interval([0.05 * t.sin(), 0.03 * t.cos(), 0.02]);
            rate = runge_kutta_4(&truth, &rate, &iv);
            ekf.predict(&iv);
            ekf.update(&rate);
            worst = worst.max((ekf.rate_rad_s() - rate).norm());
        }
        assert!(worst < 2.0 * NOISE_RAD_S, "{worst}");
    }

    #[test]
    fn single_precision_gives_the_same_rate() {
        let (mut single, mut double) = (filter::<f32>(1.0), filter::<f64>(1.0));
        single.restart(&Vec3::new(0.1, -0.2, 0.05));
        double.restart(&Vec3::new(0.1, -0.2, 0.05));
        for k in 0..1000 {
            let torque = [0.01 * f64::from(k % 7), -0.02, 0.01 * f64::from(k % 3)];
            single.predict(&interval(torque));
            double.predict(&interval(torque));
            let measured = double.rate_rad_s() + Vec3::repeat(NOISE_RAD_S * f64::from(k % 5 - 2));
            single.update(&measured.map(|x| x as f32));
            double.update(&measured);
        }
        let error = single.rate_rad_s().map(f64::from) - double.rate_rad_s();
        // A few roundings of rates up to 10 rad/s, which decay as fast as the filter's memory.
        assert!(error.norm() < 1e-5 * (1.0 + double.rate_rad_s().norm()), "{error:?}");
    }

    proptest! {
        #[test]
        fn the_covariance_stays_symmetric_and_positive(
            torques in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 200),
        ) {
            let mut ekf = filter::<f32>(0.3);
            for torque in torques {
                ekf.predict(&interval(torque));
                let measured = ekf.rate_rad_s();
                ekf.update(&measured);
                let p = ekf.covariance() * (1e6f32);
                prop_assert!(ekf.is_valid());
                prop_assert!((p - p.transpose()).abs().max() <= 1e-5 * p.abs().max());
                prop_assert!(p.determinant() > 0.0);
            }
        }
    }

    #[test]
    fn names_the_field_that_is_out_of_range() {
        let refused = |config: Config<f64>, j| RateEkf::new(config, &Inertia::new(j)).unwrap_err();
        let good = Config::new(1e-4);
        assert_eq!(refused(good, [1.0, 1.0, 3.0, 0.0, 0.0, 0.0]).field, "nominal");
        let e = refused(Config { acceleration_doubt: -1.0, ..good }, NOMINAL);
        assert_eq!(e.field, "acceleration_doubt");
        let e = refused(Config { gyro_noise_rad_s: 0.0, ..good }, NOMINAL);
        assert_eq!(e.field, "gyro_noise_rad_s");
    }
}
