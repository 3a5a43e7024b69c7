//! A first estimate from nothing: linear least squares on the integral of the gyrostat equation.
//!
//! Integrated once in body axes, the equation of motion is linear in the inertia `j` and the
//! unknown initial momentum `H₀`:
//!
//! `M(t) j − H₀ = y(t)`, `M = G(ω(t)) + ∫ ω^× G(ω) dt`, `y = ∫ τ dt − h_w(t) − ∫ ω × h_w dt`
//!
//! Nothing is differentiated and no initial guess exists. `H₀` enters each row alike, so it takes
//! no rotation: with the means `M̄`, `ȳ` of all rows so far it is `H₀ = M̄ j − ȳ`, and `j` is solved for
//! from the deviations from these means, which are kept as they grow (Welford's way).
//!
//! Gyro noise v enters the regressor, and biases `j` by many sigmas unless its expectation is taken
//! out: per sample, `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)`. Its share is removed when solving.

use super::Prior;
use crate::dynamics::interval::{Drive, Interval};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::ud::Ud;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::tensor::{Inertia, gyroscopic_regressor, regressor};

/// Passes over the noise correction. Each shrinks its error by [`LARGEST_CORRECTION`] or more:
/// eight leave 3e-6 of the correction.
const CORRECTION_PASSES: usize = 8;

/// The noise's share of the information in any element, at most: beyond, the motion doesn't
/// stand out of the noise, and the correction would not converge.
const LARGEST_CORRECTION: f64 = 0.2;

/// Accumulates the equation, three rows a sample, into a triangular factor for `j`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentumIntegral<T: Real> {
    information: SquareRootInformation<T, 6>,
    samples: u32,
    /// `M̄`, `ȳ` over the samples so far.
    mean_regressor: Mat<T, 3, 6>,
    mean_impulse_n_m_s: Vec3<T>,
    /// `∫ ω^× G(ω) dt` and `∫ (τ − ω × h_w) dt` up to the last sample.
    regressor_integral: Mat<T, 3, 6>,
    impulse_n_m_s: Vec3<T>,
    last: Last<T>,
}

crate::persist!([T: Real] MomentumIntegral<T> {
    information, samples, mean_regressor, mean_impulse_n_m_s, regressor_integral, impulse_n_m_s, last
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
    /// Covariance of rate and inertia: formal, from the noise of each row's newest rate alone. What
    /// noise adds through the integrals isn't in it.
    pub covariance: Ud<T, 9>,
}

impl<T: Real> MomentumIntegral<T> {
    /// Starts at the first sample, for white gyro noise of `noise_rad_s` per sample.
    pub fn new(
        rate_rad_s: &Vec3<T>,
        drive: &Drive<T>,
        noise_rad_s: T,
        prior: Option<&Prior<T>>,
    ) -> Self {
        let last = Last::at(rate_rad_s, drive);
        Self {
            information: prior
                .map_or_else(SquareRootInformation::default, |p| believed(p, noise_rad_s)),
            samples: 1,
            mean_regressor: regressor(rate_rad_s),
            mean_impulse_n_m_s: -last.wheel_momentum_n_m_s,
            regressor_integral: Mat::zeros(),
            impulse_n_m_s: Vec3::zeros(),
            last,
        }
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

    /// The deviation from the old mean, of weight `n / (n + 1)`, is what the n-th row adds to the sum
    /// of squares about the mean.
    fn add_rows(&mut self, rate_rad_s: &Vec3<T>) {
        let before = T::count(self.samples);
        self.samples = self.samples.saturating_add(1);
        let share = T::one() / T::count(self.samples);
        let weight = before * share;
        let off = regressor(rate_rad_s) + self.regressor_integral - self.mean_regressor;
        let y = self.impulse() - self.mean_impulse_n_m_s;
        self.mean_regressor += off * share;
        self.mean_impulse_n_m_s += y * share;
        for r in 0..3 {
            let row = core::array::from_fn(|c| off[(r, c)]);
            self.information.add_weighted(&row, y[r], weight);
        }
    }

    /// y.
    fn impulse(&self) -> Vec3<T> {
        self.impulse_n_m_s - self.last.wheel_momentum_n_m_s
    }

    /// Samples taken in.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Rate and inertia, or `None` while the motion, with the prior where there is one, doesn't
    /// determine all of the inertia above the gyro's noise.
    pub fn solve(&self, noise_rad_s: T) -> Option<Solution<T>> {
        let covariance = self.information.covariance_ud()?;
        let noise_information = noise_rad_s * noise_rad_s * T::count(self.samples);
        let share = |i: usize| noise_information * T::lit(if i < 3 { 1.0 } else { 2.0 });
        if !(0..6).all(|i| share(i) * covariance.variance(i) < T::lit(LARGEST_CORRECTION)) {
            return None;
        }
        let biased = self.information.solve()?;
        let mut j = biased;
        for _ in 0..CORRECTION_PASSES {
            let correction = covariance.times(&core::array::from_fn(|i| share(i) * j[i]));
            j = core::array::from_fn(|i| biased[i] + correction[i]);
        }
        self.at_last_sample(&Inertia::new(j), &covariance, noise_rad_s)
    }

    /// Turns `(H₀, j)` into rate and inertia at the last sample: `J ω = H₀ + y − I j`, I the integral
    /// of the regressor. With `H₀ = M̄ j − ȳ + e`, e the noise of the mean,
    /// `δω = J⁻¹ (e + (M̄ − I − G(ω)) δj)`.
    fn at_last_sample(
        &self,
        inertia: &Inertia<T>,
        of_inertia: &Ud<T, 6>,
        noise_rad_s: T,
    ) -> Option<Solution<T>> {
        let j = Mat::<T, 6, 1>::from(inertia.elements_kg_m2());
        let by_momentum = inertia.inverse()?;
        let since_mean = self.mean_regressor - self.regressor_integral;
        let momentum = since_mean * j + self.impulse() - self.mean_impulse_n_m_s;
        let rate_rad_s = by_momentum * momentum;
        let by_inertia = by_momentum * (since_mean - regressor(&rate_rad_s));

        let row_variance = row_variance(inertia, noise_rad_s);
        let of_mean = row_variance / T::count(self.samples);
        let mut covariance = Ud::diagonal(core::array::from_fn(|i| match i.checked_sub(3) {
            None => of_mean,
            Some(k) => of_inertia.d(k) * row_variance,
        }));
        for k in 1..6 {
            for i in 0..k {
                covariance.set_u(3 + i, 3 + k, of_inertia.u(i, k));
            }
        }
        covariance.transform_first(&by_momentum, &by_inertia);
        Some(Solution { rate_rad_s, inertia: *inertia, covariance })
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

/// A row for each element of the prior, in units of a motion row's noise.
fn believed<T: Real>(prior: &Prior<T>, noise_rad_s: T) -> SquareRootInformation<T, 6> {
    let row_variance = row_variance(&Inertia::new(prior.inertia_kg_m2), noise_rad_s);
    let weights = prior.sigma_kg_m2.map(|sigma| row_variance / (sigma * sigma));
    SquareRootInformation::of_each(prior.inertia_kg_m2, weights)
}

/// The variance of a row: that of `J v`, on average over the axes `σ² tr(J²) / 3`, (N m s)².
fn row_variance<T: Real>(inertia: &Inertia<T>, noise_rad_s: T) -> T {
    let j = inertia.matrix_kg_m2();
    noise_rad_s * noise_rad_s * j.dot(&j) * T::lit(1.0 / 3.0)
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

    fn fly<T: Real>(
        seconds: f64,
        noise_rad_s: f64,
        prior: Option<&Prior<T>>,
    ) -> MomentumIntegral<T> {
        let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
        let mut rate = Vec3::new(0.1, -0.2, 0.05);
        let cast = |v: &Vec3<f64>| Vec3::from_fn(|i, _| T::lit(v[i]));
        let narrow = |d: Drive<f64>| Drive {
            torque_n_m: cast(&d.torque_n_m),
            wheel_momentum_n_m_s: cast(&d.wheel_momentum_n_m_s),
        };
        let mut fit = MomentumIntegral::<T>::new(
            &cast(&rate),
            &narrow(drive(0.0)),
            T::lit(noise_rad_s),
            prior,
        );
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
        let found = fly::<f64>(20.0, 1e-6, None).solve(1e-6).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((found[i] - INERTIA[i]).abs() < TRAPEZOID, "{found:?}");
        }
    }

    #[test]
    fn single_precision_suffices() {
        let found = fly::<f32>(20.0, 1e-6, None).solve(1e-6).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((f64::from(found[i]) - INERTIA[i]).abs() < TRAPEZOID, "{found:?}");
        }
    }

    #[test]
    fn the_rate_at_the_end_comes_with_it() {
        let fit = fly::<f64>(20.0, 1e-6, None);
        let rate = fit.solve(1e-6).unwrap().rate_rad_s;
        // The newest rate is one of the rows' regressors: solved for, it must agree with them.
        let momentum = fit.last.regressor;
        assert!((gyroscopic_regressor(&rate) - momentum).abs().max() < TRAPEZOID);
    }

    /// The same equations put down one by one, with `H₀` among the unknowns.
    #[test]
    fn the_covariance_is_that_of_all_rows() {
        let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
        let (mut rate, mut integral) = (Vec3::new(0.1, -0.2, 0.05), Mat::<f64, 3, 6>::zeros());
        let mut fit = MomentumIntegral::new(&rate, &drive(0.0), 1e-3, None);
        let row = |rate: &Vec3<f64>, integral: &Mat<f64, 3, 6>| regressor(rate) + integral;
        let mut rows = std::vec![row(&rate, &integral)];
        for k in 0..500 {
            let t = f64::from(k) * STEP_S;
            let (start, middle, end) = (drive(t), drive(t + STEP_S / 2.0), drive(t + STEP_S));
            let interval = Interval { duration_s: STEP_S, start, middle, end };
            let before = gyroscopic_regressor(&rate);
            rate = runge_kutta_4(&body, &rate, &interval);
            integral += (before + gyroscopic_regressor(&rate)) * (STEP_S / 2.0);
            rows.push(row(&rate, &integral));
            fit.add(&rate, &interval);
        }
        let mut information = Mat::<f64, 9, 9>::zeros();
        for m in &rows {
            let mut all = Mat::<f64, 3, 9>::zeros();
            all.fixed_view_mut::<3, 3>(0, 0).copy_from(&-Mat::<f64, 3, 3>::identity());
            all.fixed_view_mut::<3, 6>(0, 3).copy_from(m);
            information += all.transpose() * all;
        }
        let found = fit.solve(1e-3).unwrap();
        // J δω = δH₀ − (G(ω) + I) δj.
        let inverse = found.inertia.inverse().unwrap();
        let mut jacobian = Mat::<f64, 9, 9>::identity();
        let by_inertia = -(inverse * row(&found.rate_rad_s, &integral));
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&inverse);
        jacobian.fixed_view_mut::<3, 6>(0, 3).copy_from(&by_inertia);
        let covariance = jacobian * information.try_inverse().unwrap() * jacobian.transpose();
        let expected = covariance * row_variance(&found.inertia, 1e-3);
        let ours = found.covariance.covariance();
        for i in 0..9 {
            for k in 0..9 {
                let scale = (expected[(i, i)] * expected[(k, k)]).sqrt();
                assert!((ours[(i, k)] - expected[(i, k)]).abs() < 1e-6 * scale, "{i} {k}");
            }
        }
    }

    #[test]
    fn a_prior_fills_in_what_the_motion_does_not_show() {
        let prior = Prior { inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], sigma_kg_m2: [1e-3; 6] };
        let found = fly::<f64>(0.1, 1e-3, Some(&prior)).solve(1e-3).unwrap();
        for i in 0..6 {
            let sigma = found.covariance.variance(3 + i).sqrt();
            assert!((found.inertia.elements_kg_m2()[i] - prior.inertia_kg_m2[i]).abs() < 3e-3);
            assert!(sigma > 0.9e-3 && sigma < 1.1e-3, "{sigma}");
        }
    }

    #[test]
    fn says_nothing_before_the_motion_stands_out_of_the_noise() {
        assert!(fly::<f64>(0.1, 1e-2, None).solve(1e-2).is_none());
        assert!(fly::<f64>(20.0, 10.0, None).solve(10.0).is_none());
    }
}
