//! The front: the last fit, carried on block by block, and its watch for a change.
//!
//! The squared recursive residuals of a block, over their variance, have a mean of 3. Their cumulative
//! sum `c ← max(0, c + min(u², 16) − 3 − 1)` stays low as long as the fit predicts what comes; noise alone lifts
//! it above h once in `exp(2 h / 6)` blocks (Page's test with a drift of one and a variance of six): with
//! h = 60 once in 5·10⁸.

use super::pass::Pass;
use crate::math::scalar::Real;

/// Expected square, and the drift.
const EXPECTED: f64 = 4.0;
/// Largest contribution of a block: an outlier is not a change.
const MOST: f64 = 16.0;
/// h.
const CONTRADICTED: f64 = 60.0;

/// Fit that takes in further blocks.
#[derive(Clone, Copy, Debug)]
pub struct Front<T: Real, const U: usize> {
    pub pass: Pass<T, U>,
    /// True where the descent ended at a minimum.
    pub is_settled: bool,
    /// True where the data determine the shape: the point is worth starting from again.
    pub is_shape_observed: bool,
    /// True where the residuals of the fit agree with the noise.
    pub is_explained: bool,
    /// Variance of a sample for the watch, rad²/s².
    variance: T,
    /// Cumulative sum, and the block at which it began to rise.
    sum: T,
    pub rise: usize,
    /// True once the sum has exceeded its limit.
    pub is_contradicted: bool,
}

crate::persist!([T: Real, const U: usize] Front<T, U> {
    pass, is_settled, is_shape_observed, is_explained, variance, sum, rise, is_contradicted
} if |this| this.variance > T::zero());

impl<T: Real, const U: usize> Front<T, U> {
    /// Front from a completed pass, with the noise for the watch, rad/s.
    pub fn new(pass: Pass<T, U>, is_settled: bool, noise_rad_s: T) -> Self {
        Self {
            is_settled,
            is_shape_observed: false,
            is_explained: false,
            variance: noise_rad_s * noise_rad_s,
            sum: T::zero(),
            rise: pass.next,
            is_contradicted: false,
            pass,
        }
    }

    /// Watches the squared residuals of a block, rad²/s².
    pub fn watch(&mut self, square: T) {
        let share = (square / self.variance).min(T::lit(MOST));
        let sum = self.sum + share - T::lit(EXPECTED);
        if sum > T::zero() {
            self.sum = sum;
        } else {
            self.sum = T::zero();
            self.rise = self.pass.next;
        }
        if self.sum > T::lit(CONTRADICTED) {
            self.is_contradicted = true;
        }
    }
}
