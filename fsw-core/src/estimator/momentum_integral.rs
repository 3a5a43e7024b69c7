//! A first estimate from nothing: linear least squares on the integral of the gyrostat equation.
//!
//! Integrated once in body axes, the equation of motion is linear in the inertia `j` and the
//! unknown initial momentum `H₀`:
//!
//! `[G(ω(t)) + ∫ ω^× G(ω) dt] j − H₀ = ∫ τ dt − h_w(t) − ∫ ω × h_w dt`
//!
//! Nothing is differentiated and no initial guess exists. Gyro noise v enters the regressor, and
//! biases `j` by many sigmas unless its expectation is taken out: per sample,
//! `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)`. Its share is removed when solving.

use super::Prior;
use crate::dynamics::interval::{Drive, Interval};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::tensor::{Inertia, gyroscopic_regressor, regressor};

/// Passes over the noise correction. Each shrinks its error by [`LARGEST_CORRECTION`] or more:
/// eight leave 3e-6 of the correction.
const CORRECTION_PASSES: usize = 8;

/// The noise's share of the information in any element, at most: beyond, the motion doesn't
/// stand out of the noise, and the correction would not converge.
const LARGEST_CORRECTION: f64 = 0.2;

/// Accumulates the equation, three rows a sample, into a square-root information factor for
/// `(j, H₀)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentumIntegral<T: Real> {
    information: SquareRootInformation<T, 9>,
    samples: u32,
    /// `∫ ω^× G(ω) dt` and `∫ (τ − ω × h_w) dt` up to the last sample.
    regressor_integral: Mat<T, 3, 6>,
    impulse_n_m_s: Vec3<T>,
    last: Last<T>,
}

crate::persist!([T: Real] MomentumIntegral<T> {
    information, samples, regressor_integral, impulse_n_m_s, last
});

/// The last sample, for the trapezoidal rule and for the rate at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Last<T: Real> {
    regressor: Mat<T, 3, 6>,
    torque_n_m: Vec3<T>,
    wheel_momentum_n_m_s: Vec3<T>,
}

crate::persist!([T: Real] Last<T> { regressor, torque_n_m, wheel_momentum_n_m_s });

/// What the accumulated motion says of its last instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// Body rate at the last sample, rad/s: from the whole motion, not from that sample alone.
    pub rate_rad_s: Vec3<T>,
    /// Inertia, noise bias removed.
    pub inertia: Inertia<T>,
    /// S of the covariance `S Sᵀ` of rate and inertia, 9×9: formal, from the noise of each row's
    /// newest rate alone. What noise adds through the integrals isn't in it.
    pub covariance_factor: Mat<T, 9, 9>,
}

impl<T: Real> MomentumIntegral<T> {
    /// Starts at the first sample.
    pub fn new(rate_rad_s: &Vec3<T>, drive: &Drive<T>) -> Self {
        let mut this = Self {
            information: SquareRootInformation::default(),
            samples: 0,
            regressor_integral: Mat::zeros(),
            impulse_n_m_s: Vec3::zeros(),
            last: Last::at(rate_rad_s, drive),
        };
        this.add_rows(rate_rad_s);
        this
    }

    /// Takes in the sample at the end of `interval`. Integrals by the trapezoidal rule.
    pub fn add(&mut self, rate_rad_s: &Vec3<T>, interval: &Interval<T>) {
        let half_dt = interval.duration_s * T::lit(0.5);
        let now = Last::at(rate_rad_s, &interval.end);
        self.regressor_integral += (self.last.regressor + now.regressor) * half_dt;
        self.impulse_n_m_s += (self.last.torque_n_m + now.torque_n_m) * half_dt;
        self.last = now;
        self.add_rows(rate_rad_s);
    }

    fn add_rows(&mut self, rate_rad_s: &Vec3<T>) {
        let m = regressor(rate_rad_s) + self.regressor_integral;
        let y = self.impulse_n_m_s - self.last.wheel_momentum_n_m_s;
        for r in 0..3 {
            let mut row = [T::zero(); 9];
            for c in 0..6 {
                row[c] = m[(r, c)];
            }
            row[6 + r] = -T::one();
            self.information.add(row, y[r]);
        }
        self.samples = self.samples.saturating_add(1);
    }

    /// Samples taken in.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Rate and inertia for white gyro noise of `noise_rad_s` per sample, or `None` while the
    /// motion, with the prior where there is one, doesn't determine all of the inertia above
    /// that noise.
    pub fn solve(&self, noise_rad_s: T, prior: Option<&Prior<T>>) -> Option<Solution<T>> {
        let information = self.with_prior(noise_rad_s, prior);
        let factor = information.covariance_factor()?;
        let noise_information = noise_rad_s * noise_rad_s * T::count(self.samples);
        let share = |i: usize| noise_information * T::lit(if i < 3 { 1.0 } else { 2.0 });
        let variance = |i: usize| factor.row(i).dot(&factor.row(i));
        if !(0..6).all(|i| share(i) * variance(i) < T::lit(LARGEST_CORRECTION)) {
            return None;
        }
        let biased = information.solve()?;
        let mut x = biased;
        for _ in 0..CORRECTION_PASSES {
            let mut b = [T::zero(); 9];
            for i in 0..6 {
                b[i] = share(i) * x[i];
            }
            let correction = information.solve_normal(&b)?;
            x = core::array::from_fn(|i| biased[i] + correction[i]);
        }
        self.at_last_sample(&x, &factor, noise_rad_s)
    }

    /// The information with a row more for each element of the prior, in units of a motion row's
    /// noise.
    fn with_prior(&self, noise_rad_s: T, prior: Option<&Prior<T>>) -> SquareRootInformation<T, 9> {
        let mut information = self.information;
        if let Some(prior) = prior {
            let row_sigma = row_sigma(&Inertia::new(prior.inertia_kg_m2), noise_rad_s);
            for i in 0..6 {
                let weight = row_sigma / prior.sigma_kg_m2[i];
                let mut row = [T::zero(); 9];
                row[i] = weight;
                information.add(row, weight * prior.inertia_kg_m2[i]);
            }
        }
        information
    }

    /// Turns `(j, H₀)` into rate and inertia at the last sample. With the equation above,
    /// `J ω = H₀ + y − I j`, so `δω = J⁻¹ (δH₀ − (G(ω) + I) δj)`.
    fn at_last_sample(
        &self,
        x: &[T; 9],
        factor: &Mat<T, 9, 9>,
        noise_rad_s: T,
    ) -> Option<Solution<T>> {
        let j: Mat<T, 6, 1> = Mat::from_fn(|i, _| x[i]);
        let inertia = Inertia::new(j.into());
        let inverse = inertia.inverse()?;
        let y = self.impulse_n_m_s - self.last.wheel_momentum_n_m_s;
        let initial_momentum = Vec3::new(x[6], x[7], x[8]);
        let rate_rad_s = inverse * (initial_momentum + y - self.regressor_integral * j);
        let by_inertia = -(inverse * (regressor(&rate_rad_s) + self.regressor_integral));
        let mut jacobian = Mat::<T, 9, 9>::zeros();
        for i in 0..3 {
            for k in 0..6 {
                jacobian[(i, k)] = by_inertia[(i, k)];
            }
            for k in 0..3 {
                jacobian[(i, 6 + k)] = inverse[(i, k)];
            }
        }
        for k in 0..6 {
            jacobian[(3 + k, k)] = T::one();
        }
        let covariance_factor = jacobian * factor * row_sigma(&inertia, noise_rad_s);
        Some(Solution { rate_rad_s, inertia, covariance_factor })
    }
}

impl<T: Real> Last<T> {
    fn at(rate_rad_s: &Vec3<T>, drive: &Drive<T>) -> Self {
        let h = drive.wheel_momentum_n_m_s;
        Self {
            regressor: gyroscopic_regressor(rate_rad_s),
            torque_n_m: drive.torque_n_m - rate_rad_s.cross(&h),
            wheel_momentum_n_m_s: h,
        }
    }
}

/// One sigma of a row: that of `J v`, on average over the axes `σ √(tr(J²) / 3)`, N m s.
fn row_sigma<T: Real>(inertia: &Inertia<T>, noise_rad_s: T) -> T {
    let j = inertia.matrix_kg_m2();
    noise_rad_s * (j.dot(&j) * T::lit(1.0 / 3.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{gyrostat::Gyrostat, step::runge_kutta_4};

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const STEP_S: f64 = 0.01;

    fn drive(t: f64) -> Drive<f64> {
        Drive {
            torque_n_m: Vec3::new(0.3 * (0.9 * t).sin(), 0.0, 0.2 * (0.5 * t).cos()),
            wheel_momentum_n_m_s: Vec3::new(0.0, 0.4 * (1.3 * t).sin(), 0.1),
        }
    }

    fn fly<T: Real>(seconds: f64) -> MomentumIntegral<T> {
        let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
        let mut rate = Vec3::new(0.1, -0.2, 0.05);
        let cast = |v: &Vec3<f64>| Vec3::from_fn(|i, _| T::lit(v[i]));
        let narrow = |d: Drive<f64>| Drive {
            torque_n_m: cast(&d.torque_n_m),
            wheel_momentum_n_m_s: cast(&d.wheel_momentum_n_m_s),
        };
        let mut fit = MomentumIntegral::<T>::new(&cast(&rate), &narrow(drive(0.0)));
        for k in 0..(seconds / STEP_S) as usize {
            let t = k as f64 * STEP_S;
            let (start, middle, end) = (drive(t), drive(t + STEP_S / 2.0), drive(t + STEP_S));
            let interval = Interval { duration_s: STEP_S, start, middle, end };
            rate = runge_kutta_4(&body, &rate, &interval);
            let (start, middle, end) = (narrow(start), narrow(middle), narrow(end));
            let interval = Interval { duration_s: T::lit(STEP_S), start, middle, end };
            fit.add(&cast(&rate), &interval);
        }
        fit
    }

    /// Trapezoidal rule at this step and motion: (0.01 s)² / 12 times second derivatives near 1,
    /// against moments near 1.
    const TRAPEZOID: f64 = 1e-4;

    #[test]
    fn finds_the_inertia_without_a_guess() {
        let found = fly::<f64>(20.0).solve(1e-6, None).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((found[i] - INERTIA[i]).abs() < TRAPEZOID, "{found:?}");
        }
    }

    #[test]
    fn single_precision_suffices() {
        let found = fly::<f32>(20.0).solve(1e-6, None).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((f64::from(found[i]) - INERTIA[i]).abs() < TRAPEZOID, "{found:?}");
        }
    }

    #[test]
    fn the_rate_at_the_end_comes_with_it() {
        let fit = fly::<f64>(20.0);
        let rate = fit.solve(1e-6, None).unwrap().rate_rad_s;
        // The newest rate is one of the rows' regressors: solved for, it must agree with them.
        let momentum = fit.last.regressor;
        assert!((gyroscopic_regressor(&rate) - momentum).abs().max() < TRAPEZOID);
    }

    #[test]
    fn a_prior_fills_in_what_the_motion_does_not_show() {
        let prior = Prior { inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], sigma_kg_m2: [1e-3; 6] };
        let found = fly::<f64>(0.1).solve(1e-3, Some(&prior)).unwrap();
        for i in 0..6 {
            let sigma = found.covariance_factor.row(3 + i).norm();
            assert!((found.inertia.elements_kg_m2()[i] - prior.inertia_kg_m2[i]).abs() < 3e-3);
            assert!(sigma > 0.9e-3 && sigma < 1.1e-3, "{sigma}");
        }
    }

    #[test]
    fn says_nothing_before_the_motion_stands_out_of_the_noise() {
        assert!(fly::<f64>(0.1).solve(1e-2, None).is_none());
        assert!(fly::<f64>(20.0).solve(10.0, None).is_none());
    }
}
