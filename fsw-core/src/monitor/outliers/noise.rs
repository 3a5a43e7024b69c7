//! Gyro noise by differences of accepted readings: no model of the motion.
//!
//! Differences of order k remove a motion that is a polynomial of degree k − 1. Two orders are
//! measured, and the smaller result counts:
//!
//! | order | difference | time stamps |
//! |---|---|---|
//! | 4 | reading minus the cubic through two neighbours on each side | any |
//! | 6 | sixth difference of seven readings in a row | even |
//!
//! Mean square over the last 512 differences and the three axes, each square clipped at nine
//! variances: an outlier that passed has little effect. A refused reading interrupts both orders.
//!
//! Relative standard deviation of the result on white noise, with `Σ ρ² = 2.63` for the correlation
//! of fourth differences (70, −56, 28, −8, 1) / 70: `½ √(2 · 2.63 / 3n)`, 3.8 % after n = 300
//! readings, 2.1 % with the full memory (an exponential mean of memory n has the variance of a mean
//! over 2n).

use crate::math::{Vec3, scalar::Real};

/// Differences in the memory.
const MEMORY: u16 = 512;

/// Largest square of a difference, in variances.
const CLIP: f64 = 9.0;

/// Mean of `min(z², 9)` for a normal z of unit variance: `1 − E(z²; z² > 9) + 9 P(z² > 9)`,
/// `1 − 0.0293 + 0.0243`.
const CLIPPED_VARIANCE: f64 = 0.995;

/// Sum of the squared coefficients of the sixth difference: (1, 6, 15, 20, 15, 6, 1) squared.
const SQUARED_GAIN_6: f64 = 924.0;

/// Readings in a row of the two orders.
const READINGS: [u8; 2] = [5, 7];

/// Measured noise of the gyro.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise<T: Real> {
    /// Differences of order 0 to 5 at the last reading, rad/s.
    differences: [Vec3<T>; 6],
    /// Accepted readings in a row, up to seven.
    in_a_row: u8,
    /// Squared errors of the cubic at the last two readings, rad²/s²: valid once their successors
    /// are accepted.
    waiting: [Vec3<T>; 2],
    fourth: Mean<T>,
    sixth: Mean<T>,
}

crate::persist!([T: Real] Noise<T> { differences, in_a_row, waiting, fourth, sixth });

/// Mean square, rad²/s².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mean<T: Real> {
    square: T,
    count: u16,
}

crate::persist!([T: Real] Mean<T> { square, count } if |this| this.square >= T::zero());

impl<T: Real> Noise<T> {
    /// No reading.
    pub(super) fn unknown() -> Self {
        let mean = Mean { square: T::zero(), count: 0 };
        Self {
            differences: [Vec3::zeros(); 6],
            in_a_row: 0,
            waiting: [Vec3::zeros(); 2],
            fourth: mean,
            sixth: mean,
        }
    }

    /// Interrupts the sequence: at a refused reading and at a gap.
    pub(super) fn interrupt(&mut self) {
        self.in_a_row = 0;
    }

    /// Adds an accepted reading (rad/s) with its squared error of the cubic, normalised to the
    /// variance of a reading, if that is known; `variance` on each axis limits the squares, rad²/s².
    pub(super) fn add(
        &mut self,
        rate_rad_s: &Vec3<T>,
        squared_error: Option<Vec3<T>>,
        variance: &Vec3<T>,
    ) {
        let mut difference = *rate_rad_s;
        for order in &mut self.differences {
            let next = difference - *order;
            *order = difference;
            difference = next;
        }
        let Some(squared_error) = squared_error else {
            return self.interrupt();
        };
        let [last, before_last] = self.waiting;
        self.waiting = [squared_error, last];
        let [of_fourth, of_sixth] = READINGS;
        self.in_a_row = self.in_a_row.saturating_add(1).min(of_sixth);
        if self.in_a_row >= of_fourth {
            self.fourth.add(&before_last, variance);
        }
        if self.in_a_row >= of_sixth {
            let square = difference.component_mul(&difference) * T::lit(1.0 / SQUARED_GAIN_6);
            self.sixth.add(&square, variance);
        }
    }

    /// One sigma of a reading, mean of the axes, rad/s. Zero before the first differences, and for
    /// readings that repeat.
    pub(super) fn sigma_rad_s(&self) -> T {
        let is_even = self.sixth.count > 0 && self.sixth.square < self.fourth.square;
        let square = if is_even { self.sixth.square } else { self.fourth.square };
        (square * T::lit(1.0 / CLIPPED_VARIANCE)).sqrt()
    }
}

impl<T: Real> Mean<T> {
    /// `m ← m + (s − m) / n`, s the mean over the axes of the clipped squares, `n ≤ 512`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn add(&mut self, squares: &Vec3<T>, variance: &Vec3<T>) {
        let mut sum = T::zero();
        for axis in 0..3 {
            let limit = variance[axis] * T::lit(CLIP);
            sum += if squares[axis] > limit { limit } else { squares[axis] };
        }
        self.count = self.count.saturating_add(1).min(MEMORY);
        let step = (sum * T::lit(1.0 / 3.0) - self.square) / T::count(self.count.into());
        let square = self.square + step;
        self.square = if square.is_finite() && square > T::zero() { square } else { T::zero() };
    }
}
