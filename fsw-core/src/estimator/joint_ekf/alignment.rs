//! Alignment: rate and inertia from the motion itself, by linear least squares on the integral of
//! the gyrostat equation. No initial guess and no derivative.
//!
//! Input: gyro samples with the drive between them. Output: a [`Solution`] at the last sample,
//! which the filter starts from once its covariance is small enough.
//!
//! Integrated once in body axes, the equation of motion is linear in the six elements `j` and in
//! the unknown initial momentum `H₀` (N m s):
//!
//! `M(t) j − H₀ = y(t)`, `M = G(ω(t)) + ∫ ω^× G(ω) dt`, `y = ∫ τ dt − h_w(t) − ∫ ω × h_w dt`
//!
//! with G the [`regressor`] (rad/s), y an impulse (N m s). `H₀` has the same coefficient in each
//! row and is eliminated by subtraction of the means, without Givens rotations: with the means
//! `M̄`, `ȳ` of all rows `H₀ = M̄ j − ȳ`, and `j` is solved for from the deviations from these
//! means, which are updated as rows arrive (Welford's recursion).
//!
//! Gyro noise v enters the regressor and biases `j` by many sigmas. Its expectation,
//! [`regressor_noise_share`] `σ²` per sample, is removed when solving.
//!
//! | symbol | in code | unit |
//! |---|---|---|
//! | `M̄` | `mean_regressor` | rad/s |
//! | `ȳ` | `mean_impulse_n_m_s` | N m s |
//! | `∫ ω^× G(ω) dt` | `regressor_integral` | rad/s |
//! | `∫ (τ − ω × h_w) dt` | `impulse_n_m_s` | N m s |
//! | `MᵀM` about the mean | `information` | rad²/s² |
//!
//! Assumptions: white gyro noise of known sigma; integrals by the trapezoidal rule, so the motion
//! must be slow beside the sample rate; noise in the integrals is neglected.
//!
//! Ours: \[Bellar2019\] starts from a given inertia. The method is derived in this file.

use super::Prior;
use crate::dynamics::interval::Drive;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::ud::Ud;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::tensor::{Inertia, gyroscopic_regressor, regressor, regressor_noise_share};

/// Iterations of the noise correction. Each shrinks its error by [`LARGEST_CORRECTION`] or more:
/// eight leave 3e-6 of the correction.
const CORRECTION_PASSES: usize = 8;

/// Largest ratio of expected noise information to total information of any element. Beyond it the
/// motion does not stand out of the noise, and the correction would converge slowly or not at all.
const LARGEST_CORRECTION: f64 = 0.2;

/// Largest mean square of the residuals, in variances of a row, of a motion that the model explains:
/// 1.2, and five standard deviations of the mean square of n white residuals, `√(2 / n)`. The margin
/// of 0.2 is twice the error of a measured noise, and the noise of the integrals.
const LARGEST_RESIDUAL: f64 = 1.2;
const RESIDUAL_DEVIATIONS: f64 = 5.0;

/// Accumulated least squares: three rows a sample in a triangular factor for `j`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment<T: Real> {
    /// `Σ (M − M̄)ᵀ (M − M̄)` as its square root, rad²/s², and the right-hand side.
    information: SquareRootInformation<T, 6>,
    /// Sum of the squared residuals, (N m s)².
    squares: T,
    samples: u32,
    /// `M̄`, rad/s.
    mean_regressor: Mat<T, 3, 6>,
    /// `ȳ`.
    mean_impulse_n_m_s: Vec3<T>,
    /// `∫ ω^× G(ω) dt` up to the last sample, rad/s.
    regressor_integral: Mat<T, 3, 6>,
    /// `∫ (τ − ω × h_w) dt` up to the last sample.
    impulse_n_m_s: Vec3<T>,
    last: Integrands<T>,
}

crate::persist!([T: Real] Alignment<T> {
    information, squares, samples, mean_regressor, mean_impulse_n_m_s, regressor_integral, impulse_n_m_s,
    last
});

/// The integrands at one sample, for the trapezoidal rule, and the wheels' momentum there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Integrands<T: Real> {
    /// `ω^× G(ω)`, rad²/s².
    regressor: Mat<T, 3, 6>,
    /// `τ − ω × h_w`.
    torque_n_m: Vec3<T>,
    /// `h_w`.
    wheel_momentum_n_m_s: Vec3<T>,
}

crate::persist!([T: Real] Integrands<T> { regressor, torque_n_m, wheel_momentum_n_m_s });

/// Least-squares solution at the last sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// Body rate, rad/s, by the whole motion rather than by the last sample alone.
    pub rate_rad_s: Vec3<T>,
    /// Inertia, kg m², noise bias removed. Not necessarily physical.
    pub inertia: Inertia<T>,
    /// Formal covariance of the nine states `(ω, j)`: from the noise of each row's own rate. The
    /// noise of the integrals is left out.
    pub covariance: Ud<T, 9>,
}

impl<T: Real> Alignment<T> {
    /// Starts at the first sample.
    ///
    /// `noise_rad_s`: gyro noise, one sigma per sample, above zero. A prior adds one row for each
    /// element; without one the motion alone determines the solution.
    pub fn new(
        rate_rad_s: &Vec3<T>,
        drive: &Drive<T>,
        noise_rad_s: T,
        prior: Option<&Prior<T>>,
    ) -> Self {
        let mut this = Self::empty();
        this.begin(rate_rad_s, drive, noise_rad_s, prior);
        this
    }

    /// Before the first sample: all zeros.
    #[inline(always)] // built in its place
    pub fn empty() -> Self {
        let zeros = Vec3::zeros();
        Self {
            information: SquareRootInformation::default(),
            squares: T::zero(),
            samples: 0,
            mean_regressor: Mat::zeros(),
            mean_impulse_n_m_s: zeros,
            regressor_integral: Mat::zeros(),
            impulse_n_m_s: zeros,
            last: Integrands {
                regressor: Mat::zeros(),
                torque_n_m: zeros,
                wheel_momentum_n_m_s: zeros,
            },
        }
    }

    /// Discards all samples.
    pub fn clear(&mut self) {
        self.samples = 0;
    }

    /// Starts at the first sample, in place. Arguments as of [`new`](Self::new).
    #[inline(never)]
    pub fn begin(
        &mut self,
        rate_rad_s: &Vec3<T>,
        drive: &Drive<T>,
        noise_rad_s: T,
        prior: Option<&Prior<T>>,
    ) {
        self.information =
            prior.map_or_else(SquareRootInformation::default, |p| prior_rows(p, noise_rad_s));
        self.squares = T::zero();
        self.samples = 1;
        self.last = Integrands::at(rate_rad_s, drive);
        self.mean_regressor = regressor(rate_rad_s);
        self.mean_impulse_n_m_s = -drive.wheel_momentum_n_m_s;
        self.regressor_integral = Mat::zeros();
        self.impulse_n_m_s = Vec3::zeros();
    }

    /// Adds the sample `elapsed_s` after the one before: both integrals by the trapezoidal rule,
    /// `∫ f dt += ½ (f₀ + f₁) Δt`, then three rows. The rate of an outlier, bridged by its
    /// neighbours, enters the integrals alone.
    pub fn add(&mut self, rate_rad_s: &Vec3<T>, drive: &Drive<T>, elapsed_s: T, is_accepted: bool) {
        let half_dt = elapsed_s * T::lit(0.5);
        let now = Integrands::at(rate_rad_s, drive);
        self.regressor_integral += (self.last.regressor + now.regressor) * half_dt;
        self.impulse_n_m_s += (self.last.torque_n_m + now.torque_n_m) * half_dt;
        self.last = now;
        if is_accepted {
            self.add_rows(rate_rad_s);
        }
    }

    /// Adds three rows as deviations from the mean of the n before them, with weight `n / (n + 1)`:
    /// that is exactly their share of the sum of squares about the new mean (Welford).
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
            self.squares += self.information.add_weighted(&row, y[r], weight).square();
        }
    }

    /// `y` at the last sample, N m s.
    fn impulse(&self) -> Vec3<T> {
        self.impulse_n_m_s - self.last.wheel_momentum_n_m_s
    }

    /// Samples accumulated, the first included.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Inertia with the expected noise taken out of the regressor, and the largest formal variance of an element, kg² m⁴:
    ///
    /// `j = (MᵀM − N)⁻¹ Mᵀy`, `N = n σ² diag(1 1 1 2 2 2)`,
    ///
    /// by the fixed-point iteration `j ← (MᵀM)⁻¹ (Mᵀy + N j)` on the factor of `MᵀM`: the matrix
    /// itself would lose weakly excited directions in single precision. n samples, σ =
    /// `noise_rad_s` (rad/s), M and y about their means.
    ///
    /// `None` while the motion, with the prior if there is one, does not determine every element
    /// above the noise: `Nᵢᵢ (MᵀM)⁻¹ᵢᵢ` must stay below `LARGEST_CORRECTION`.
    #[inline(never)]
    pub fn solve_inertia(&self, noise_rad_s: T) -> Option<(Inertia<T>, T)> {
        let covariance = self.information.covariance_ud()?;
        let noise_information = noise_rad_s * noise_rad_s * T::count(self.samples);
        let share = |i: usize| noise_information * regressor_noise_share(i);
        let mut largest = T::zero();
        for i in 0..6 {
            let variance = covariance.variance(i);
            let is_above_noise = share(i) * variance < T::lit(LARGEST_CORRECTION);
            if !is_above_noise {
                return None;
            }
            largest = largest.max(variance);
        }
        let biased = self.information.solve()?;
        let mut j = biased;
        for _ in 0..CORRECTION_PASSES {
            let correction = covariance.times(&core::array::from_fn(|i| share(i) * j[i]));
            j = core::array::from_fn(|i| biased[i] + correction[i]);
        }
        let inertia = Inertia::new(j);
        Some((inertia, largest * row_variance(&inertia, noise_rad_s)))
    }

    /// Rate and inertia at the last sample: [`solve_inertia`](Self::solve_inertia), then
    /// [`at_last_sample`](Self::at_last_sample).
    pub fn solve(&self, noise_rad_s: T) -> Option<Solution<T>> {
        self.at_last_sample(&self.solve_inertia(noise_rad_s)?.0, noise_rad_s)
    }

    /// True if the residuals are those of gyro noise, for this solution: their mean square is below
    /// `LARGEST_RESIDUAL` and its deviations, times the variance of a row.
    pub fn is_explained(&self, inertia: &Inertia<T>, noise_rad_s: T) -> bool {
        let rows = T::count(self.samples) * T::lit(3.0);
        let mean = self.squares / (rows * row_variance(inertia, noise_rad_s));
        let excess = mean - T::lit(LARGEST_RESIDUAL);
        let largest = T::lit(2.0 * RESIDUAL_DEVIATIONS * RESIDUAL_DEVIATIONS);
        excess <= T::zero() || excess * excess * rows <= largest
    }

    /// Rate and covariance at the last sample from `(H₀, j)`, for the solved inertia: `J ω = H₀ + y − I j`, I the
    /// integral of the regressor. With `H₀ = M̄ j − ȳ + e`, e the noise of the mean (N m s),
    ///
    /// `δω = J⁻¹ (e + (M̄ − I − G(ω)) δj)`,
    ///
    /// which transforms the covariance of `(e, j)` into that of `(ω, j)`. `None` where J has no
    /// inverse.
    #[inline(never)]
    pub fn at_last_sample(&self, inertia: &Inertia<T>, noise_rad_s: T) -> Option<Solution<T>> {
        let of_inertia = &self.information.covariance_ud()?;
        let j = Mat::<T, 6, 1>::from(inertia.elements_kg_m2());
        let by_momentum = inertia.inverse()?;
        let since_mean = self.mean_regressor - self.regressor_integral;
        let momentum = since_mean * j + self.impulse() - self.mean_impulse_n_m_s;
        let rate_rad_s = by_momentum * momentum;
        let by_inertia = by_momentum * (since_mean - regressor(&rate_rad_s));

        let row_variance = row_variance(inertia, noise_rad_s);
        let mean_variance = row_variance / T::count(self.samples);
        let mut covariance = of_mean_and_inertia(mean_variance, of_inertia, row_variance);
        covariance.transform_first(&by_momentum, &by_inertia);
        Some(Solution { rate_rad_s, inertia: *inertia, covariance })
    }
}

impl<T: Real> Integrands<T> {
    /// At a measured rate (rad/s) and the drive of the same instant.
    #[inline(never)]
    fn at(rate_rad_s: &Vec3<T>, drive: &Drive<T>) -> Self {
        let h = drive.wheel_momentum_n_m_s;
        Self {
            regressor: gyroscopic_regressor(rate_rad_s),
            torque_n_m: drive.torque_n_m - rate_rad_s.cross(&h),
            wheel_momentum_n_m_s: h,
        }
    }
}

/// Factor of the independent variables `(e, j)`: `mean_variance` on each axis of e, and
/// `row_variance` times `of_inertia`.
fn of_mean_and_inertia<T: Real>(
    mean_variance: T,
    of_inertia: &Ud<T, 6>,
    row_variance: T,
) -> Ud<T, 9> {
    let mut covariance = Ud::diagonal(core::array::from_fn(|i| match i.checked_sub(3) {
        None => mean_variance,
        Some(k) => of_inertia.d(k) * row_variance,
    }));
    for k in 1..6 {
        for i in 0..k {
            covariance.set_u(3 + i, 3 + k, of_inertia.u(i, k));
        }
    }
    covariance
}

/// One row for each element of the prior, in units of a motion row's noise: weight
/// `row variance / sigma²`, rad²/s².
fn prior_rows<T: Real>(prior: &Prior<T>, noise_rad_s: T) -> SquareRootInformation<T, 6> {
    let row_variance = row_variance(&Inertia::new(prior.inertia_kg_m2), noise_rad_s);
    let weights = prior.sigma_kg_m2.map(|sigma| row_variance / (sigma * sigma));
    SquareRootInformation::of_each(prior.inertia_kg_m2, weights)
}

/// Variance of one row, (N m s)²: that of `J v`, averaged over the axes, `σ² tr(J²) / 3`.
fn row_variance<T: Real>(inertia: &Inertia<T>, noise_rad_s: T) -> T {
    let j = inertia.matrix_kg_m2();
    noise_rad_s * noise_rad_s * j.dot(&j) * T::lit(1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{gyrostat::Gyrostat, interval::Interval, step::runge_kutta_4};

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const STEP_S: f64 = 0.01;

    /// Torques and wheel momentum that excite all six elements within a few seconds.
    fn drive(t: f64) -> Drive<f64> {
        Drive {
            torque_n_m: Vec3::new(0.3 * (0.9 * t).sin(), 0.0, 0.2 * (0.5 * t).cos()),
            wheel_momentum_n_m_s: Vec3::new(0.0, 0.4 * (1.3 * t).sin(), 0.1),
        }
    }

    /// Alignment over a noiseless flight of `seconds`, for stated gyro noise of `noise_rad_s`.
    fn fly<T: Real>(seconds: f64, noise_rad_s: f64, prior: Option<&Prior<T>>) -> Alignment<T> {
        let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
        let mut rate = Vec3::new(0.1, -0.2, 0.05);
        let cast = |v: &Vec3<f64>| Vec3::from_fn(|i, _| T::lit(v[i]));
        let narrow = |d: Drive<f64>| Drive {
            torque_n_m: cast(&d.torque_n_m),
            wheel_momentum_n_m_s: cast(&d.wheel_momentum_n_m_s),
        };
        let mut alignment =
            Alignment::<T>::new(&cast(&rate), &narrow(drive(0.0)), T::lit(noise_rad_s), prior);
        for k in 0..(seconds / STEP_S) as usize {
            let t = k as f64 * STEP_S;
            let (start, middle, end) = (drive(t), drive(t + STEP_S / 2.0), drive(t + STEP_S));
            let interval = Interval { duration_s: STEP_S, start, middle, end };
            rate = runge_kutta_4(&body, &rate, &interval);
            alignment.add(&cast(&rate), &narrow(end), T::lit(STEP_S), true);
        }
        alignment
    }

    /// Error of the trapezoidal rule, kg m²: (0.01 s)² / 12 times second derivatives near 1, for
    /// moments near 1.
    const TRAPEZOID: f64 = 1e-4;

    #[test]
    fn exact_motion_gives_the_inertia_without_a_prior() {
        let found = fly::<f64>(20.0, 1e-6, None).solve(1e-6).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((found[i] - INERTIA[i]).abs() < TRAPEZOID, "{found:?}");
        }
    }

    #[test]
    fn single_precision_gives_the_same_inertia() {
        let found = fly::<f32>(20.0, 1e-6, None).solve(1e-6).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((f64::from(found[i]) - INERTIA[i]).abs() < TRAPEZOID, "{found:?}");
        }
    }

    #[test]
    fn the_rate_at_the_last_sample_agrees_with_its_reading() {
        let alignment = fly::<f64>(20.0, 1e-6, None);
        let rate = alignment.solve(1e-6).unwrap().rate_rad_s;
        let reading = alignment.last.regressor;
        assert!((gyroscopic_regressor(&rate) - reading).abs().max() < TRAPEZOID);
    }

    /// Reference: all rows stored, `H₀` among nine unknowns, normal equations in f64.
    #[test]
    fn the_covariance_equals_that_of_the_nine_unknowns() {
        let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
        let (mut rate, mut integral) = (Vec3::new(0.1, -0.2, 0.05), Mat::<f64, 3, 6>::zeros());
        let mut alignment = Alignment::new(&rate, &drive(0.0), 1e-3, None);
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
            alignment.add(&rate, &end, STEP_S, true);
        }
        let mut information = Mat::<f64, 9, 9>::zeros();
        for m in &rows {
            let mut all = Mat::<f64, 3, 9>::zeros();
            all.fixed_view_mut::<3, 3>(0, 0).copy_from(&-Mat::<f64, 3, 3>::identity());
            all.fixed_view_mut::<3, 6>(0, 3).copy_from(m);
            information += all.transpose() * all;
        }
        let found = alignment.solve(1e-3).unwrap();
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
    fn unobserved_directions_hold_the_prior() {
        let prior = Prior { inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], sigma_kg_m2: [1e-3; 6] };
        let found = fly::<f64>(0.1, 1e-3, Some(&prior)).solve(1e-3).unwrap();
        for i in 0..6 {
            let sigma = found.covariance.variance(3 + i).sqrt();
            assert!((found.inertia.elements_kg_m2()[i] - prior.inertia_kg_m2[i]).abs() < 3e-3);
            assert!(sigma > 0.9e-3 && sigma < 1.1e-3, "{sigma}");
        }
    }

    #[test]
    fn no_solution_while_noise_hides_the_motion() {
        assert!(fly::<f64>(0.1, 1e-2, None).solve(1e-2).is_none());
        assert!(fly::<f64>(20.0, 10.0, None).solve(10.0).is_none());
    }
}
