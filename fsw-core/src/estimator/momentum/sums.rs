//! The sums that all four methods read: `M = Σ ω ωᵀ`, `B = Σ ω Qᵀ` and what is left over.
//!
//! Kept as the triangular factor of the rows `[ωᵀ Qᵀ]`, six numbers a sample: its first three
//! columns hold M, the next three B and the residual. Single precision then keeps what a matrix
//! of sums would lose where one axis turns far faster than another.

use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real};

/// Beyond, no ω (rad/s) or Q (N m s) is of this world, and its square would overflow in single
/// precision.
const LARGEST: f64 = 1.0e15;

/// Below, the square would vanish in single precision: taken as zero. No sensor resolves it.
const SMALLEST: f64 = 1.0e-15;

/// A sum of squares below this share of what gyro noise alone makes of it can't be believed to
/// come from a gyro. Ours: over ten samples noise alone stays above it in all but one of 100 cases.
const LEAST_OF_NOISE: f64 = 0.25;

/// The accumulated rows.
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
    /// Takes in `J ω = Q`; `false` where a number isn't finite, or so large that it would ruin
    /// the sums.
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

    /// Rows so far.
    pub(super) fn samples(&self) -> u32 {
        self.samples
    }

    /// `n σ²`, rad²/s²: what noise of `noise_rad_s` adds to each diagonal element of M.
    pub(super) fn noise_square(&self, noise_rad_s: T) -> T {
        noise_rad_s * noise_rad_s * T::count(self.samples)
    }

    /// R of `RᵀR = M`, 3×3.
    pub(super) fn factor(&self) -> Mat<T, 3, 3> {
        self.block(0, 0)
    }

    /// Z of `Rᵀ Z = B`, 3×3: column r belongs to row r of the tensor.
    pub(super) fn right_hand_side(&self) -> Mat<T, 3, 3> {
        self.block(0, 3)
    }

    fn block(&self, row: usize, column: usize) -> Mat<T, 3, 3> {
        let equations = self.rows.equations();
        Mat::from_fn(|i, k| equations[row + i].0[column + k])
    }

    /// Whether a sum of squares of rates, rad²/s², for gyro noise of `noise_rad_s`, is more than rounding.
    pub(super) fn is_excited(&self, square: T, noise_rad_s: T) -> bool {
        let least = self.noise_square(noise_rad_s) * T::lit(LEAST_OF_NOISE);
        let factor = self.factor();
        let rounding = T::EPSILON * T::lit(8.0);
        square > least && square > factor.dot(&factor) * (rounding * rounding)
    }

    /// `√(Σ Qᵀ Q / Σ ωᵀ ω)`, kg m²: the size of the tensor along the motion, with the noise's
    /// share of the rates taken out; `None` while that is no more than a third of all.
    pub(super) fn size_kg_m2(&self, noise_rad_s: T) -> Option<T> {
        let (m, z, left) = (self.factor(), self.right_hand_side(), self.block(3, 3));
        let all = m.dot(&m);
        let motion = all - self.noise_square(noise_rad_s) * T::lit(3.0);
        let stands_out = motion > all * T::lit(1.0 / 3.0);
        if !stands_out {
            return None;
        }
        let size = ((z.dot(&z) + left.dot(&left)) / motion).sqrt();
        (size.is_finite() && size > T::zero()).then_some(size)
    }

    /// The gyro noise, rad/s, one sigma, that explains what no tensor of nine elements can:
    /// the residual of `J (ω − v) = Q` is `−J v`.
    pub(super) fn residual_rms_rad_s(&self) -> T {
        let left = self.block(3, 3);
        let tensor = self.basic_solution();
        let square = tensor.dot(&tensor) * T::count(self.samples);
        let rms = (left.dot(&left) / square).sqrt();
        if rms.is_finite() { rms } else { T::zero() }
    }

    /// `R⁻¹ Z`, with zero for each unknown whose pivot is lost in rounding.
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
