//! Shift test: a persistent mean of the innovations on one axis, too small for the spike gate.
//!
//! Input: innovation ν, its variance S on each axis, gyro noise σ. Output: a [`Decision`]. The
//! caller predicts across shifted samples, and restarts after a lock-out.
//!
//! Faults of one axis, such as a pulse of its bias or a reading that sticks, stay below six sigmas
//! for long, and vanish in a mean over three axes. Two cumulative sums an axis \[Page1954\], one for
//! each sign:
//!
//! `g ← max(0, g ± z − k)`, `z = ν σ / S`, shifted where `g > h`, with `k = 0.5`, `h = 20`.
//!
//! z is the test ratio `ν / √S`, and smaller where the filter's own uncertainty is part of S: a
//! filter that has just started is not tested against its first errors.
//!
//! | mean of z | samples to the decision, `h / (mean − k)` |
//! |---|---|
//! | 10 | 3 |
//! | 3 | 8 |
//! | 1 | 40 |
//! | below 0.5 | not detected |
//!
//! False alarms of white innovations, six sums: one in 5e8 samples for the stated noise,
//! `ARL = (exp(2 k b) − 2 k b − 1) / 2 k²` with `b = h + 1.166` \[Siegmund1985\]; one in 8e5 for noise
//! 1.2 times as large. The effect of one is a coasting of ten samples.

use super::innovation::Innovation;
use crate::math::{Vec3, scalar::Real};

/// Reference value k: half of the smallest mean that is to be detected quickly, one sigma.
const REFERENCE: f64 = 0.5;

/// Decision limit h: false alarms as stated above.
const LIMIT: f64 = 20.0;

/// Largest sum. The sum falls by k a sample once the fault has ended: ten samples to the limit.
const LARGEST: f64 = 25.0;

/// Shifted samples that make a lock-out. The prediction bridges faults that are shorter: 20 s at
/// 10 Hz, and the samples until the sums have fallen.
const LOCKOUT_AFTER: u16 = 212;

/// Consistent samples that cancel a shifted one in the count for a lock-out. A changed body shows in
/// parts of the motion, so that a shift may pause; a share of one shifted sample in 17 remains
/// without a lock-out.
const PAUSE: u16 = 16;

/// Decision on one innovation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// No shift.
    Consistent,
    /// A shift: not to be used.
    Shifted,
    /// A shift that does not end: the estimate is wrong, not the gyro.
    LockOut,
}

/// Cumulative sums of each axis.
///
/// ```
/// use fsw_core::monitor::shift::{Decision, ShiftTest};
/// use fsw_core::{Innovation, Vec3};
///
/// let noise_rad_s = 1e-3f32;
/// let innovation = |sigmas: f32| Innovation {
///     rate_rad_s: Vec3::new(0.0, sigmas * noise_rad_s, 0.0),
///     variance_rad2_s2: Vec3::repeat(noise_rad_s * noise_rad_s),
/// };
/// let mut test = ShiftTest::default();
/// assert_eq!(test.judge(&innovation(5.0), noise_rad_s), Decision::Consistent);
/// for _ in 0..10 {
///     test.judge(&innovation(3.0), noise_rad_s);
/// }
/// assert!(test.is_shifted());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShiftTest<T: Real> {
    /// Sums of positive and of negative shifts, in sigmas.
    sums: [Vec3<T>; 2],
    /// The last innovation was shifted.
    is_shifted: bool,
    /// Shifted samples less their share of the consistent ones, in units of `1 / PAUSE`.
    count: u16,
}

crate::persist!([T: Real] ShiftTest<T> { sums, is_shifted, count });

impl<T: Real> Default for ShiftTest<T> {
    fn default() -> Self {
        Self { sums: [Vec3::zeros(); 2], is_shifted: false, count: 0 }
    }
}

impl<T: Real> ShiftTest<T> {
    /// Discards the sums, as after a restart of the estimator.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// True where no shifted sample is left in the count for a lock-out.
    pub fn is_calm(&self) -> bool {
        self.count == 0
    }

    /// True where the last innovation was shifted.
    pub fn is_shifted(&self) -> bool {
        self.is_shifted
    }

    /// Adds an innovation, for gyro noise of `noise_rad_s`, one sigma.
    #[inline]
    pub fn judge(&mut self, innovation: &Innovation<T>, noise_rad_s: T) -> Decision {
        let mut is_shifted = false;
        let [up, down] = &mut self.sums;
        for axis in 0..3 {
            let scale = noise_rad_s / innovation.variance_rad2_s2[axis];
            let z = innovation.rate_rad_s[axis] * scale;
            for (sum, z) in [(&mut up[axis], z), (&mut down[axis], -z)] {
                let next = *sum + (z - T::lit(REFERENCE));
                // A sum that is not a number starts over.
                *sum = if next > T::zero() { next } else { T::zero() };
                if *sum > T::lit(LIMIT) {
                    is_shifted = true;
                    *sum = if *sum < T::lit(LARGEST) { *sum } else { T::lit(LARGEST) };
                }
            }
        }
        self.is_shifted = is_shifted;
        if !is_shifted {
            self.count = self.count.saturating_sub(1);
            return Decision::Consistent;
        }
        self.count = self.count.saturating_add(PAUSE);
        if self.count < LOCKOUT_AFTER * PAUSE { Decision::Shifted } else { Decision::LockOut }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Decisions on a sequence of means on the z axis, in sigmas, without noise.
    fn decisions(means: impl IntoIterator<Item = f64>) -> Vec<Decision> {
        let mut test = ShiftTest::default();
        let judge = |mean: f64| {
            let (rate_rad_s, variance_rad2_s2) = (Vec3::new(0.0, 0.0, mean), Vec3::repeat(1.0));
            let decision = test.judge(&Innovation { rate_rad_s, variance_rad2_s2 }, 1.0);
            assert_eq!(test.is_shifted(), decision != Decision::Consistent);
            decision
        };
        means.into_iter().map(judge).collect()
    }

    #[test]
    fn a_shift_is_detected_after_the_stated_samples() {
        for (mean, samples) in [(10.0, 3), (3.0, 9), (-3.0, 9), (1.0, 41), (-1.0, 41)] {
            let found = decisions([mean; 60]);
            let first = found.iter().position(|d| *d == Decision::Shifted);
            assert_eq!(first, Some(samples - 1), "{mean}");
        }
        assert!(decisions([0.5; 5000]).iter().all(|d| *d == Decision::Consistent));
    }

    #[test]
    fn the_end_of_a_fault_ends_the_shift() {
        let found = decisions((0..200).map(|k| if k < 50 { 5.0 } else { 0.0 }));
        let end = found.iter().rposition(|d| *d == Decision::Shifted).unwrap();
        assert!((50..62).contains(&end), "{end}");
    }

    #[test]
    fn a_shift_that_does_not_end_locks_out() {
        let found = decisions([3.0; 300]);
        let first = found.iter().position(|d| *d == Decision::LockOut);
        assert_eq!(first, Some(8 + usize::from(LOCKOUT_AFTER) - 1));
    }

    /// Fault of nine samples in every 100, and in every 400.
    #[test]
    fn a_shift_with_pauses_locks_out() {
        let every =
            |period: u32| decisions((0..8000).map(|k| if k % period < 9 { 6.0 } else { 0.0 }));
        assert!(every(100).contains(&Decision::LockOut));
        assert!(!every(400).contains(&Decision::LockOut));
    }

    /// A single spike of six sigmas, an infinity and a NaN.
    #[test]
    fn single_innovations_are_no_shift() {
        let found = decisions([6.0, 0.0, -6.0, f64::NAN, 0.0]);
        assert!(found.iter().all(|d| *d == Decision::Consistent));
        let after = decisions([f64::INFINITY, f64::NAN, 0.0, 0.0]);
        assert_eq!(after[3], Decision::Consistent);
    }

    /// Sixteen consistent samples cancel a shifted one; a restart cancels all.
    #[test]
    fn calm_returns_with_consistent_samples_or_a_restart() {
        let (mut test, mut left) = (ShiftTest::default(), 0u32);
        for k in 0..600 {
            let rate_rad_s = Vec3::new(if k < 10 { 10.0 } else { 0.0 }, 0.0, 0.0);
            let variance_rad2_s2 = Vec3::repeat(1.0);
            left = match test.judge(&Innovation { rate_rad_s, variance_rad2_s2 }, 1.0) {
                Decision::Consistent => left.saturating_sub(1),
                _ => left + u32::from(PAUSE),
            };
            assert_eq!(test.is_calm(), left == 0, "{k}");
            let mut restarted = test;
            restarted.restart();
            assert_eq!(restarted, ShiftTest::default());
        }
        assert!(test.is_calm());
    }
}
