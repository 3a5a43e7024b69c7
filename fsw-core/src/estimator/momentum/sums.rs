//! Sums of all four methods: `M = Σ ω ωᵀ`, `B = Σ ω Qᵀ`, and the residual of `J ω = Q`.
//!
//! Input: rows `[ωᵀ Qᵀ]`, rad/s and N m s, one a sample. They are accumulated as one triangular
//! factor whose first three columns hold M, the next three B and the residual:
//!
//! `RᵀR = M`, `RᵀZ = B`, `LᵀL = Σ Q Qᵀ − ZᵀZ`.
//!
//! | block of the factor | content | unit |
//! |---|---|---|
//! | rows 1 to 3, columns 1 to 3 | R | rad/s |
//! | rows 1 to 3, columns 4 to 6 | Z | N m s |
//! | rows 4 to 6, columns 4 to 6 | L, the residual | N m s |
//!
//! Single precision then keeps the weakly excited axes, which a matrix of sums would lose beside an
//! axis that turns far faster.

use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real};

/// Largest ω (rad/s) or Q (N m s). No flight data comes near it; beyond, the square overflows
/// single precision.
const LARGEST: f64 = 1.0e15;

/// Smallest ω (rad/s) or Q (N m s) beside zero. No sensor resolves it; below, the square underflows
/// single precision.
const SMALLEST: f64 = 1.0e-15;

/// Lower limit of Σ ω² over its expectation for gyro noise alone; below it the axis is unusable.
/// Ours: over ten samples noise alone exceeds it in 99 of 100 cases.
const LEAST_OF_NOISE: f64 = 0.25;

/// Accumulated rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sums<T: Real> {
    rows: SquareRootInformation<T, 6>,
    samples: u32,
}

impl<T: Real> Default for Sums<T> {
    fn default() -> Self {
        Self { rows: SquareRootInformation::default(), samples: 0 }
    }
}

impl<T: Real> Sums<T> {
    /// Adds the row of `J ω = Q`, ω in rad/s and Q in N m s; `false`, without effect, where a
    /// number is not finite or so large that its square overflows.
    pub(super) fn add(&mut self, rate_rad_s: &Vec3<T>, momentum_n_m_s: &Vec3<T>) -> bool {
        let (w, q) = (rate_rad_s, momentum_n_m_s);
        let row = [w.x, w.y, w.z, q.x, q.y, q.z];
        if !row.iter().all(|x| x.abs() < T::lit(LARGEST)) {
            return false;
        }
        let row = row.map(|x| if x.abs() < T::lit(SMALLEST) { T::zero() } else { x });
        self.rows.add(row, T::zero());
        self.samples = self.samples.saturating_add(1);
        true
    }

    /// Accumulated samples.
    pub(super) fn samples(&self) -> u32 {
        self.samples
    }

    /// `n σ²`, rad²/s²: expected contribution of noise σ = `noise_rad_s` to each diagonal element
    /// of M.
    pub(super) fn noise_square(&self, noise_rad_s: T) -> T {
        noise_rad_s * noise_rad_s * T::count(self.samples)
    }

    /// R of `RᵀR = M`, 3×3, rad/s.
    pub(super) fn factor(&self) -> Mat<T, 3, 3> {
        self.block(0, 0)
    }

    /// Z of `Rᵀ Z = B`, 3×3, N m s: column r belongs to row r of the tensor.
    pub(super) fn right_hand_side(&self) -> Mat<T, 3, 3> {
        self.block(0, 3)
    }

    /// 3×3 block of the factor.
    fn block(&self, row: usize, column: usize) -> Mat<T, 3, 3> {
        let equations = self.rows.equations();
        Mat::from_fn(|i, k| equations[row + i].0[column + k])
    }

    /// True if a sum of squares of rates, rad²/s², exceeds a quarter of that of gyro noise alone,
    /// and the rounding of the factor.
    pub(super) fn is_excited(&self, square: T, noise_rad_s: T) -> bool {
        let least = self.noise_square(noise_rad_s) * T::lit(LEAST_OF_NOISE);
        let factor = self.factor();
        let rounding = T::EPSILON * T::lit(8.0);
        square > least && square > factor.dot(&factor) * (rounding * rounding)
    }

    /// Size of the tensor along the motion, kg m²: `√(Σ Qᵀ Q / (Σ ωᵀ ω − 3 n σ²))`, σ =
    /// `noise_rad_s`. `None` while the noise's share of `Σ ωᵀ ω` exceeds two thirds.
    pub(super) fn size_kg_m2(&self, noise_rad_s: T) -> Option<T> {
        let (m, z, residual) = (self.factor(), self.right_hand_side(), self.block(3, 3));
        let all = m.dot(&m);
        let motion = all - self.noise_square(noise_rad_s) * T::lit(3.0);
        let stands_out = motion > all * T::lit(1.0 / 3.0);
        if !stands_out {
            return None;
        }
        let size = ((z.dot(&z) + residual.dot(&residual)) / motion).sqrt();
        (size.is_finite() && size > T::zero()).then_some(size)
    }

    /// Gyro noise, rad/s, one sigma, that explains the residual of the best tensor of nine entries:
    ///
    /// `σ = √(Σ r² / (n |J|²))`
    ///
    /// since the residual of `J (ω − v) = Q` is `r = −J v` (N m s). 0 where the quotient is not
    /// finite.
    pub(super) fn residual_rms_rad_s(&self) -> T {
        let residual = self.block(3, 3);
        let tensor = self.basic_solution();
        let square = tensor.dot(&tensor) * T::count(self.samples);
        let rms = (residual.dot(&residual) / square).sqrt();
        if rms.is_finite() { rms } else { T::zero() }
    }

    /// `R⁻¹ Z`, kg m², with zero for each unknown whose pivot is lost in rounding.
    fn basic_solution(&self) -> Mat<T, 3, 3> {
        let (factor, mut x) = (self.factor(), self.right_hand_side());
        for column in 0..3 {
            for i in (0..3).rev() {
                for k in i + 1..3 {
                    let step = factor[(i, k)] * x[(k, column)];
                    x[(i, column)] -= step;
                }
                let pivot = factor[(i, i)];
                let is_sound = self.is_excited(pivot * pivot, T::zero());
                x[(i, column)] = if is_sound { x[(i, column)] / pivot } else { T::zero() };
            }
        }
        x
    }
}
