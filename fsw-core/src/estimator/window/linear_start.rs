//! A first estimate from nothing: linear least squares on the conservation of momentum.
//!
//! The gyro itself, integrated, tells how the body has turned since the window opened: C takes
//! body axes to the axes of that instant, `Ċ = C ω^×`. Total momentum changes there only by
//! external torque, which makes an equation linear in the inertia `j` and the initial momentum H₀:
//!
//! `G(ω) j − Cᵀ H₀ − Cᵀ ∫ C dt τ_d − β = Cᵀ ∫ C τ dt − h_w`
//!
//! with a disturbance torque τ_d and, for a gyro bias b, `β = J b`, where they are among the unknowns
//! (what b does to C is left to Gauss-Newton). Nothing is differentiated, no initial guess exists, and since the measured turn is used, none
//! is lost however far the body turns. Gyro noise v enters the regressor and biases `j` by many
//! sigmas unless its expectation is taken out: `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)` per row of
//! unit weight. (The noise in C, an angle random walk, is left in: it is what Gauss-Newton
//! then removes.)

use super::block::Reading;
use super::solution::{Hold, hard};
use super::unknowns::{BIAS, DRAG, MOMENTUM, TORQUE, has_bias, has_drag, has_torque, inertia_of};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real, skew};
use crate::tensor::{Inertia, regressor};

/// Passes over the noise correction. Each shrinks its error by [`LARGEST_CORRECTION`] or more:
/// eight leave 3e-6 of the correction.
const CORRECTION_PASSES: usize = 8;

/// The noise's share of the information in any element, at most. From a half on the correction
/// wouldn't converge; already from a third on, what is left of the motion is as uncertain as the noise
/// that a hundred blocks happen to have.
const LARGEST_CORRECTION: f64 = 0.2;

/// Motion that is so many times the noise stands out clearly.
const CLEAR: f64 = 30.0;

/// An element whose sigma is above this share of the mean moment is too vague to start from.
const VAGUE: f64 = 0.2;

/// Accumulates the equation, three rows a block, into a square-root information factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearStart<T: Real, const U: usize> {
    information: SquareRootInformation<T, U>,
    rows: u32,
    /// C at the newest reading.
    attitude: Mat<T, 3, 3>,
    /// `∫ C τ dt` and `∫ C dt` up to the newest reading.
    impulse_n_m_s: Vec3<T>,
    push_s: Mat<T, 3, 3>,
    newest: Reading<T>,
    /// Sums over the block so far: of ω, of Cᵀ, of Cᵀ ∫ C dt, and of the right-hand side.
    samples: u32,
    sum_rate: Vec3<T>,
    sum_attitude: Mat<T, 3, 3>,
    sum_push_s: Mat<T, 3, 3>,
    sum_momentum: Vec3<T>,
}

/// What the equation says of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// H₀, N m s, in the body axes of that instant.
    pub momentum_n_m_s: Vec3<T>,
    /// τ_d, N m.
    pub torque_n_m: Vec3<T>,
    /// b, rad/s.
    pub bias_rad_s: Vec3<T>,
    /// Inertia, noise bias removed.
    pub inertia: Inertia<T>,
}

impl<T: Real> Solution<T> {
    fn of<const U: usize>(x: &[T; U]) -> Self {
        let three = |at: usize| Vec3::new(x[at], x[at + 1], x[at + 2]);
        let none = Vec3::zeros();
        let inertia = Inertia::new(core::array::from_fn(|i| x[inertia_of(U) + i]));
        let beta = if has_bias(U) { three(BIAS) } else { none };
        Self {
            momentum_n_m_s: three(MOMENTUM),
            torque_n_m: if has_torque(U) { three(TORQUE) } else { none },
            bias_rad_s: inertia.inverse().map_or(none, |inverse| inverse * beta),
            inertia,
        }
    }
}

/// How torque and bias are held beside the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Holds<T> {
    /// N m.
    pub torque: Hold<T>,
    /// rad/s.
    pub bias: Hold<T>,
}

impl<T: Real, const U: usize> LinearStart<T, U> {
    /// Starts at the first reading.
    pub fn new(first: Reading<T>) -> Self {
        let mut this = Self {
            information: SquareRootInformation::default(),
            rows: 0,
            attitude: Mat::identity(),
            impulse_n_m_s: Vec3::zeros(),
            push_s: Mat::zeros(),
            newest: first,
            samples: 0,
            sum_rate: Vec3::zeros(),
            sum_attitude: Mat::zeros(),
            sum_push_s: Mat::zeros(),
            sum_momentum: Vec3::zeros(),
        };
        this.sum();
        this
    }

    /// Takes in the next reading, `elapsed_s` after the last.
    pub fn add(&mut self, reading: Reading<T>, elapsed_s: T) {
        let (half, last) = (T::lit(0.5), self.newest);
        let (w0, w1) = (last.rate_rad_s, reading.rate_rad_s);
        // The turn of a rate that changes linearly, to third order: the cross product is what a
        // turn of its axis adds (coning).
        let turn = (w0 + w1) * (elapsed_s * half)
            + w0.cross(&w1) * (elapsed_s * elapsed_s * T::lit(1.0 / 12.0));
        let before = self.attitude * last.torque_n_m;
        let attitude_before = self.attitude;
        self.attitude *= rotation(&turn);
        if has_torque(U) {
            self.push_s += (attitude_before + self.attitude) * (elapsed_s * half);
        }
        let after = self.attitude * reading.torque_n_m;
        self.impulse_n_m_s += (before + after) * (elapsed_s * half);
        self.newest = reading;
        self.sum();
    }

    fn sum(&mut self) {
        let back = self.attitude.transpose();
        self.samples += 1;
        self.sum_rate += self.newest.rate_rad_s;
        self.sum_attitude += back;
        if has_torque(U) {
            self.sum_push_s += back * self.push_s;
        }
        self.sum_momentum += back * self.impulse_n_m_s - self.newest.wheel_momentum_n_m_s;
    }

    /// Makes three rows of the readings since the last block, as many as `samples` tells.
    pub fn close_block(&mut self) {
        let weight = T::one() / T::count(self.samples).sqrt();
        let g = regressor(&self.sum_rate);
        for r in 0..3 {
            let mut row = [T::zero(); U];
            for c in 0..3 {
                row[MOMENTUM + c] = -self.sum_attitude[(r, c)] * weight;
                if has_torque(U) {
                    row[TORQUE + c] = -self.sum_push_s[(r, c)] * weight;
                }
            }
            if has_bias(U) {
                row[BIAS + r] = -T::count(self.samples) * weight;
            }
            for c in 0..6 {
                row[inertia_of(U) + c] = g[(r, c)] * weight;
            }
            self.information.add(row, self.sum_momentum[r] * weight);
        }
        self.rows += 1;
        self.samples = 0;
        self.sum_rate = Vec3::zeros();
        self.sum_attitude = Mat::zeros();
        self.sum_push_s = Mat::zeros();
        self.sum_momentum = Vec3::zeros();
        // One Newton step keeps C orthogonal against rounding.
        let error =
            Mat::<T, 3, 3>::identity() * T::lit(3.0) - self.attitude.transpose() * self.attitude;
        self.attitude *= error * T::lit(0.5);
    }

    /// The data with what is held beside them, for white gyro noise of `noise_rad_s` per sample.
    fn held(&self, noise_rad_s: T, holds: &Holds<T>) -> SquareRootInformation<T, U> {
        let mut information = self.information;
        // The equation is in N m s, where the noise is that of the rate times the inertia.
        let size = self.size_kg_m2(noise_rad_s).unwrap_or(T::zero());
        let mut hold = |at: usize, weight: Option<T>| {
            for i in at..at + 3 {
                let hard = hard(information.column_size(i));
                let mut row = [T::zero(); U];
                row[i] = weight.unwrap_or(hard);
                information.add(row, T::zero());
            }
        };
        if has_torque(U) {
            hold(
                TORQUE,
                match holds.torque {
                    Hold::AtZero => None,
                    Hold::Within(sigma) => Some(noise_rad_s * size / sigma),
                },
            );
        }
        if has_bias(U) {
            hold(
                BIAS,
                match holds.bias {
                    Hold::AtZero => None,
                    Hold::Within(sigma) => Some(noise_rad_s / sigma),
                },
            );
        }
        // Drag isn't looked for here.
        if has_drag(U) {
            hold(DRAG, None);
        }
        information
    }

    /// The solution for white gyro noise of `noise_rad_s` per sample, or `None` while the motion
    /// doesn't determine all of the inertia above that noise.
    pub fn solve(&self, noise_rad_s: T, holds: &Holds<T>) -> Option<Solution<T>> {
        let information = self.held(noise_rad_s, holds);
        let factor = information.last::<6>().covariance_factor()?;
        let noise_information = noise_rad_s * noise_rad_s * T::count(self.rows);
        let share = |i: usize| noise_information * T::lit(if i < 3 { 1.0 } else { 2.0 });
        let variance = |i: usize| factor.row(i).dot(&factor.row(i));
        if !(0..6).all(|i| share(i) * variance(i) < T::lit(LARGEST_CORRECTION)) {
            return None;
        }
        let biased = information.solve()?;
        let mut x = biased;
        for _ in 0..CORRECTION_PASSES {
            let mut b = [T::zero(); U];
            for i in 0..6 {
                b[inertia_of(U) + i] = share(i) * x[inertia_of(U) + i];
            }
            let correction = information.solve_normal(&b)?;
            x = core::array::from_fn(|i| biased[i] + correction[i]);
        }
        let solution = Solution::of(&x);
        let trace = solution.inertia.trace_kg_m2();
        let row_sigma = noise_rad_s * trace * T::lit(1.0 / 3.0);
        let largest = trace * T::lit(VAGUE / 3.0);
        let is_sharp = |i: usize| variance(i) * row_sigma * row_sigma < largest * largest;
        (0..6).all(is_sharp).then_some(solution)
    }
}

impl<T: Real, const U: usize> LinearStart<T, U> {
    /// Of motion that nothing drives, which shows the inertia only up to its scale: momentum and
    /// inertia of mean moment 1 kg m². Noise bias isn't removed: `None` where there is much.
    pub fn solve_homogeneous(&self, noise_rad_s: T) -> Option<Solution<T>> {
        // The columns of the moments hold the squares of the rates, and of their noise.
        let squares = (0..3).fold(T::zero(), |sum, i| {
            let size = self.information.column_size(inertia_of(U) + i);
            sum + size * size
        });
        let noise_square = noise_rad_s * noise_rad_s * T::count(self.rows);
        if squares < noise_square * T::lit(CLEAR * CLEAR) {
            return None;
        }
        let at_zero = Holds { torque: Hold::AtZero, bias: Hold::AtZero };
        let mut information = self.held(T::zero(), &at_zero);
        let first = inertia_of(U);
        let weight = information.column_size(first);
        let mut trace = [T::zero(); U];
        for moment in first..first + 3 {
            trace[moment] = weight;
        }
        information.add(trace, weight * T::lit(3.0));
        let x = information.solve()?;
        let scale = T::lit(3.0) / (x[first] + x[first + 1] + x[first + 2]);
        let is_positive = scale > T::zero() && scale < T::one() / T::EPSILON;
        is_positive.then(|| Solution::of(&x.map(|x| x * scale)))
    }

    /// Size of the inertia along the motion, kg m²: the sphere that explains it best, noise bias
    /// removed. `None` where nothing drives the body, or the motion doesn't stand out of the noise.
    pub fn size_kg_m2(&self, noise_rad_s: T) -> Option<T> {
        // A sphere adds up the columns of the three moments.
        let mut sphere = SquareRootInformation::<T, 4>::default();
        let first = inertia_of(U);
        for (row, y) in self.information.equations() {
            sphere.add([row[0], row[1], row[2], row[first] + row[first + 1] + row[first + 2]], y);
        }
        let variance =
            sphere.covariance_factor()?.row(3).iter().fold(T::zero(), |s, x| s + *x * *x);
        let size = sphere.solve()?[3];
        let noise = noise_rad_s * noise_rad_s * T::count(self.rows) * T::lit(3.0) * variance;
        let size = size / (T::one() - noise);
        (noise < T::lit(LARGEST_CORRECTION) && size > T::zero() && size.is_finite()).then_some(size)
    }
}

/// The rotation by a vector of less than a radian: `1 + (1 − φ²/6 + φ⁴/120) φ^× + (½ − φ²/24 +
/// φ⁴/720) φ^× φ^×`, whose error is below `φ⁷ / 5040`.
fn rotation<T: Real>(turn_rad: &Vec3<T>) -> Mat<T, 3, 3> {
    let square = turn_rad.dot(turn_rad);
    let a = T::one() - square * (T::lit(1.0 / 6.0) - square * T::lit(1.0 / 120.0));
    let b = T::lit(0.5) - square * (T::lit(1.0 / 24.0) - square * T::lit(1.0 / 720.0));
    let x = skew(turn_rad);
    Mat::<T, 3, 3>::identity() + x * a + x * x * b
}

#[cfg(test)]
mod tests {
    use super::*;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const PERIOD_S: f64 = 0.01;

    const NONE: Holds<f64> = Holds { torque: Hold::AtZero, bias: Hold::AtZero };

    /// A body that turns by several radians, driven by a torque that makes it do so: its
    /// momentum is integrated with steps a tenth of a sample.
    fn fly<T: Real>(seconds: f64) -> LinearStart<T, 9> {
        let body = Inertia::new(INERTIA);
        let (j, inverse) = (body.matrix_kg_m2(), body.inverse().unwrap());
        let wheels = |t: f64| Vec3::new(0.0, 0.4 * (1.3 * t).sin(), 0.1);
        let torque = |t: f64| Vec3::new(0.3 * (0.9 * t).sin(), 0.0, 0.2 * (0.5 * t).cos());
        let cast = |v: Vec3<f64>| Vec3::from_fn(|i, _| T::lit(v[i]));
        let mut h = j * Vec3::new(0.3, -0.5, 0.2) + wheels(0.0);
        let reading = |t: f64, h: Vec3<f64>| Reading {
            rate_rad_s: cast(inverse * (h - wheels(t))),
            wheel_momentum_n_m_s: cast(wheels(t)),
            torque_n_m: cast(torque(t)),
        };
        let mut start = LinearStart::new(reading(0.0, h));
        let fine = PERIOD_S / 10.0;
        for k in 0..(seconds / PERIOD_S) as u32 {
            for i in 0..10 {
                let t = f64::from(k) * PERIOD_S + f64::from(i) * fine;
                let slope =
                    |t: f64, h: Vec3<f64>| torque(t) - (inverse * (h - wheels(t))).cross(&h);
                let half_way = h + slope(t, h) * (fine / 2.0);
                h += slope(t + fine / 2.0, half_way) * fine;
            }
            if k % 5 == 4 {
                start.close_block();
            }
            start.add(reading(f64::from(k + 1) * PERIOD_S, h), T::lit(PERIOD_S));
        }
        start
    }

    /// Trapezoids at this step: (0.01 s)² / 12 times second derivatives near 1.
    const TRAPEZOID: f64 = 1e-4;

    #[test]
    fn finds_the_inertia_without_a_guess_in_both_precisions() {
        let double = fly::<f64>(20.0).solve(1e-6, &NONE).unwrap().inertia.elements_kg_m2();
        let single = fly::<f32>(20.0)
            .solve(1e-6, &Holds { torque: Hold::AtZero, bias: Hold::AtZero })
            .unwrap()
            .inertia
            .elements_kg_m2();
        for i in 0..6 {
            assert!((double[i] - INERTIA[i]).abs() < TRAPEZOID, "{double:?}");
            assert!((f64::from(single[i]) - INERTIA[i]).abs() < TRAPEZOID, "{single:?}");
        }
    }

    #[test]
    fn says_nothing_before_the_motion_stands_out_of_the_noise() {
        assert!(fly::<f64>(0.1).solve(1e-2, &NONE).is_none());
        assert!(fly::<f64>(20.0).solve(10.0, &NONE).is_none());
    }

    #[test]
    fn the_size_along_the_motion_is_that_of_the_body() {
        let size = fly::<f64>(20.0).size_kg_m2(1e-6).unwrap();
        assert!(size > 1.0 && size < 2.0, "{size}");
    }

    #[test]
    fn rotation_is_the_exponential_of_the_cross_product() {
        let turn = Vec3::new(0.3, -0.4, 0.5);
        let (mut power, mut sum) = (Mat::<f64, 3, 3>::identity(), Mat::<f64, 3, 3>::identity());
        for n in 1..20 {
            power = power * skew(&turn) / f64::from(n);
            sum += power;
        }
        // φ⁷ / 5040.
        assert!((rotation(&turn) - sum).abs().max() < 2e-5);
    }
}
