//! Stream of evenly spaced samples, smoothed and differentiated.
//!
//! Input: time stamp, µs, and N channels. Output: value and first derivative of each channel, both
//! of the same polynomial at the same instant, and the age of that instant.
//!
//! `y(t) = Σᵢ wᵢ yᵢ`, `ẏ(t) = Σᵢ w'ᵢ yᵢ / Δt`, with the weights of [`kernel`](super::kernel) and
//! the mean sample period `Δt` of the window.
//!
//! Assumption: samples are evenly spaced within a tolerance; a sample that is not restarts the
//! window.
//!
//! The newest C samples are kept in a ring, and nothing is allocated. A full window of n samples
//! costs `2 n N` products per sample. While the window grows, each sample also takes new weights.
//!
//! | evaluation point | delay | noise gain of the derivative |
//! |---|---|---|
//! | [`Fit::centred`] | half the window | smallest |
//! | [`Fit::newest`] | none | largest |

use super::kernel::{Fit, Kernel, LARGEST_ORDER};
use crate::error::ConfigError;
use crate::math::range::{not_negative, within};
use crate::math::scalar::Real;

/// Behaviour while the window fills after a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Growth {
    /// No output before the window is full.
    WaitUntilFull,
    /// Growing odd window, \[Kim2013\]: two samples make a backward difference; 3 to 7 samples make
    /// windows of 3, 3, 5, 5, 7.
    Odd,
}

/// Content of the window after a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pushed<T: Real, const N: usize> {
    /// Polynomial through the window.
    Fitted(Fitted<T, N>),
    /// Too few samples for a fit.
    Filling,
    /// Sample too early or too late for the even spacing that the weights assume. It is the first
    /// of a new window.
    Restarted,
}

/// Polynomial through the window, at the evaluation point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted<T: Real, const N: usize> {
    /// Value of each channel, in its unit.
    pub value: [T; N],
    /// First derivative of each channel, its unit per second.
    pub derivative_per_s: [T; N],
    /// Mean sample period of the window, s.
    pub period_s: T,
    /// Age of the evaluation point relative to the newest sample, s.
    pub delay_s: T,
}

/// Smoothing and differentiation of N channels with a window of up to C samples.
///
/// ```
/// use fsw_core::math::savgol::{Differentiator, Fit, Growth, Pushed};
///
/// // A parabola through five samples at 10 Hz, evaluated at the newest one.
/// let fit = Fit::newest(5, 2, 1);
/// let mut rate = Differentiator::<f64, 1, 5>::new(fit, Growth::WaitUntilFull, 0.1)?;
/// for k in 0..5u64 {
///     let t = 0.1 * k as f64;
///     if let Pushed::Fitted(fitted) = rate.push(100_000 * k, [t * t]) {
///         assert!((fitted.derivative_per_s[0] - 0.8).abs() < 1e-12); // 2 t at 0.4 s
///         assert_eq!(fitted.delay_s, 0.0);
///     }
/// }
/// # Ok::<(), fsw_core::ConfigError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Differentiator<T: Real, const N: usize, const C: usize> {
    /// Polynomial and evaluation point of the full window.
    pub(crate) fit: Fit<T>,
    /// Behaviour while the window fills.
    pub(crate) growth: Growth,
    /// Largest deviation of an interval from the mean of those before it, relative.
    pub(crate) period_tolerance: T,
    /// Channels and time stamp, µs, of the newest samples.
    pub(crate) ring: [([T; N], u64); C],
    /// Index of the next sample in the ring.
    pub(crate) next: usize,
    /// Samples in the window.
    pub(crate) filled: usize,
    /// Weights of the value.
    pub(crate) smoothing: Kernel<T, C>,
    /// Weights of the derivative, per sample period.
    pub(crate) differentiation: Kernel<T, C>,
}

impl<T: Real, const N: usize, const C: usize> Differentiator<T, N, C> {
    /// Empty window. `fit.derivative` is ignored, since value and first derivative are both given.
    ///
    /// `period_tolerance` is relative: 0.1 accepts an interval within 10 % of the mean.
    ///
    /// # Errors
    /// Those of [`Fit::validate`], an `order` of zero, and a negative `period_tolerance`.
    pub fn new(fit: Fit<T>, growth: Growth, period_tolerance: T) -> Result<Self, ConfigError> {
        fit.validate(C)?;
        within("order", fit.order, 1, fit.window - 1)?;
        not_negative("period_tolerance", period_tolerance)?;
        Ok(Self::of_valid(fit, growth, period_tolerance))
    }

    /// As [`new`](Self::new), for values that have passed its checks.
    #[inline(always)] // built in its place
    pub(crate) fn of_valid(fit: Fit<T>, growth: Growth, period_tolerance: T) -> Self {
        let [smoothing, differentiation] = Kernel::value_and_slope(&fit);
        Self {
            fit,
            growth,
            period_tolerance,
            ring: [([T::zero(); N], 0); C],
            next: 0,
            filled: 0,
            smoothing,
            differentiation,
        }
    }

    /// Discards all samples.
    pub fn restart(&mut self) {
        self.filled = 0;
    }

    /// Adds the sample of `time_us`, and fits the window that it completes.
    ///
    /// | state of the window | result |
    /// |---|---|
    /// | the interval deviates from the mean by more than the tolerance | [`Pushed::Restarted`] |
    /// | too few samples | [`Pushed::Filling`] |
    /// | complete, or growing by [`Growth::Odd`] | [`Pushed::Fitted`] |
    pub fn push(&mut self, time_us: u64, channels: [T; N]) -> Pushed<T, N> {
        self.bound();
        let is_even = self.is_even(time_us);
        if !is_even {
            self.filled = 0;
        }
        if let Some(place) = self.ring.get_mut(self.next) {
            *place = (channels, time_us);
        }
        self.next = (self.next + 1) % C;
        self.filled = (self.filled + 1).min(self.fit.window);
        match self.window() {
            _ if !is_even => Pushed::Restarted,
            None => Pushed::Filling,
            Some(window) => Pushed::Fitted(self.fitted(window, time_us)),
        }
    }

    /// Noise gain of the derivative, `Σᵢⱼ wᵢ wⱼ ρ^|i−j|`, per sample period²: see
    /// [`Kernel::noise_gain`].
    ///
    /// ```
    /// use fsw_core::math::savgol::{Differentiator, Fit, Growth};
    ///
    /// // Parabola through five samples: 12 / (n (n² − 1)) = 0.1 for white noise.
    /// let fit = Fit::<f64>::centred(5, 2, 1);
    /// let rate = Differentiator::<f64, 3, 8>::new(fit, Growth::Odd, 0.1)?;
    /// assert!((rate.derivative_noise_gain(0.0) - 0.1).abs() < 1e-15);
    /// # Ok::<(), fsw_core::ConfigError>(())
    /// ```
    pub fn derivative_noise_gain(&self, correlation: T) -> T {
        self.differentiation.noise_gain(correlation)
    }

    /// Brings window, order, index and count into their ranges, which they leave by a flipped bit only: no sum of them
    /// overflows, and no index is beyond the ring.
    #[inline]
    fn bound(&mut self) {
        self.fit.window = self.fit.window.min(C).max(2);
        self.fit.order = self.fit.order.min(LARGEST_ORDER).min(self.fit.window - 1);
        self.filled = self.filled.min(self.fit.window);
        self.next = if self.next < C { self.next } else { 0 };
    }

    /// True for a sample at the mean interval of the window, within tolerance.
    fn is_even(&self, time_us: u64) -> bool {
        if self.filled == 0 {
            return true;
        }
        let newest = self.stamp(self.filled, self.filled - 1);
        let Some(elapsed_us) = time_us.checked_sub(newest) else { return false };
        if self.filled == 1 {
            return elapsed_us > 0;
        }
        let span_us = newest.saturating_sub(self.stamp(self.filled, 0));
        let mean_s = T::seconds(span_us) / T::count(self.filled as u32 - 1);
        (T::seconds(elapsed_us) - mean_s).abs() <= self.period_tolerance * mean_s
    }

    /// Length of the window that the present samples make, if any.
    fn window(&self) -> Option<usize> {
        match (self.growth, self.filled) {
            (_, filled) if filled >= self.fit.window => Some(self.fit.window),
            (Growth::WaitUntilFull, _) | (_, 0 | 1) => None,
            (Growth::Odd, 2) => Some(2),
            (Growth::Odd, filled) => Some(filled - (1 - filled % 2)),
        }
    }

    /// Polynomial through the newest `window` samples: `y = Σ wᵢ yᵢ`, `ẏ = Σ w'ᵢ yᵢ / Δt`.
    fn fitted(&mut self, window: usize, time_us: u64) -> Fitted<T, N> {
        let at = self.set_window(window);
        let last = T::count(window as u32 - 1);
        let span_us = time_us.saturating_sub(self.stamp(window, 0));
        let period_s = T::seconds(span_us) / last;
        let inverse_period = T::one() / period_s;
        let mut value = [T::zero(); N];
        let mut derivative_per_s = value;
        let weights = self.smoothing.weights().iter().zip(self.differentiation.weights());
        for (i, (smooth, differentiate)) in weights.enumerate() {
            let Some((channels, _)) = self.ring.get(self.index(window, i)) else { continue };
            for c in 0..N {
                value[c] += *smooth * channels[c];
                derivative_per_s[c] += *differentiate * channels[c];
            }
        }
        for c in 0..N {
            derivative_per_s[c] *= inverse_period;
        }
        Fitted { value, derivative_per_s, period_s, delay_s: (last - at) * period_s }
    }

    /// Sets the weights for a window of this length, which changes only while it grows. Returns
    /// their evaluation point: the middle for a growing window.
    fn set_window(&mut self, window: usize) -> T {
        let mut fit = self.fit;
        if window < self.fit.window {
            fit = Fit::centred(window, self.fit.order.min(window - 1), 0);
        }
        if self.smoothing.weights().len() != window {
            [self.smoothing, self.differentiation] = Kernel::value_and_slope(&fit);
        }
        fit.at
    }

    /// Ring index of the i-th sample, oldest first, of the newest `window`.
    fn index(&self, window: usize, i: usize) -> usize {
        (self.next + C + i - window) % C
    }

    /// Time stamp of that sample, µs.
    fn stamp(&self, window: usize, i: usize) -> u64 {
        self.ring.get(self.index(window, i)).map_or(0, |(_, time_us)| *time_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Invalid;
    use std::vec::Vec;

    const PERIOD_US: u64 = 100_000;

    /// Window of seven samples that grows, parabola, one channel: \[Kim2013\].
    fn kim_2013() -> Differentiator<f64, 1, 8> {
        Differentiator::new(Fit::centred(7, 2, 1), Growth::Odd, 0.1).unwrap()
    }

    /// Test signal `1 − 2 t + 3 t²`.
    fn parabola(t: f64) -> [f64; 1] {
        [1.0 - 2.0 * t + 3.0 * t * t]
    }

    /// Window lengths from the delay of a centred fit, `(n − 1) / 2` periods.
    #[test]
    fn the_window_grows_as_in_kim_2013() {
        let mut d = kim_2013();
        let delays: Vec<Option<f64>> = (0..9)
            .map(|k| match d.push(k * PERIOD_US, [k as f64]) {
                Pushed::Fitted(f) => Some((f.delay_s / f.period_s).round() * 2.0 + 1.0),
                _ => None,
            })
            .collect();
        // 2 d + 1 is the window; the backward difference's middle, half a period, rounds to 3.
        let windows = [3.0, 3.0, 5.0, 5.0, 7.0, 7.0, 7.0].map(Some);
        assert_eq!(delays[0], None);
        assert_eq!(delays[2..], windows);
    }

    /// A parabola is reproduced exactly at the evaluation point: centred, newest and in between.
    #[test]
    fn value_and_derivative_belong_to_the_stated_instant() {
        for fit in
            [Fit::centred(6, 2, 1), Fit::newest(6, 2, 1), Fit { at: 3.7, ..Fit::centred(6, 2, 1) }]
        {
            let mut d = Differentiator::<f64, 1, 8>::new(fit, Growth::WaitUntilFull, 0.1).unwrap();
            let mut fits = 0;
            for k in 0..40 {
                let now = k as f64 * 0.1;
                if let Pushed::Fitted(f) = d.push(k * PERIOD_US, parabola(now)) {
                    let t = now - f.delay_s;
                    assert!((f.value[0] - parabola(t)[0]).abs() < 1e-12);
                    assert!((f.derivative_per_s[0] - (6.0 * t - 2.0)).abs() < 1e-11);
                    fits += 1;
                }
            }
            assert_eq!(fits, 35);
        }
    }

    /// Two samples give the mean value and the difference quotient, half a period before the newest
    /// one.
    #[test]
    fn the_first_difference_is_exact_for_a_line() {
        let mut d = kim_2013();
        d.push(0, [1.0]);
        let Pushed::Fitted(f) = d.push(PERIOD_US, [2.0]) else { panic!("two make a difference") };
        assert!((f.value[0] - 1.5).abs() < 1e-15);
        assert!((f.derivative_per_s[0] - 10.0).abs() < 1e-12);
        assert!((f.delay_s - 0.05).abs() < 1e-15);
    }

    /// Jitter of 4 % passes a tolerance of 10 %; a doubled interval does not.
    #[test]
    fn jitter_within_tolerance_passes_and_a_gap_restarts() {
        let mut d = kim_2013();
        let mut now = 0;
        for k in 0..20 {
            now += PERIOD_US + if k % 2 == 0 { 4_000 } else { 0 };
            assert_ne!(d.push(now, [0.0]), Pushed::Restarted);
        }
        now += 2 * PERIOD_US;
        assert_eq!(d.push(now, [0.0]), Pushed::Restarted);
        assert!(matches!(d.push(now + PERIOD_US, [0.0]), Pushed::Fitted(_)));
    }

    /// Equal and earlier time stamps.
    #[test]
    fn non_increasing_time_restarts_the_window() {
        let mut d = kim_2013();
        d.push(5 * PERIOD_US, [0.0]);
        assert_eq!(d.push(5 * PERIOD_US, [0.0]), Pushed::Restarted);
        assert_eq!(d.push(PERIOD_US, [0.0]), Pushed::Restarted);
    }

    /// Window above the capacity, order zero, negative tolerance.
    #[test]
    fn an_invalid_fit_or_tolerance_is_rejected() {
        let new = |fit| Differentiator::<f32, 1, 8>::new(fit, Growth::Odd, 0.1).unwrap_err();
        assert_eq!(new(Fit::centred(9, 2, 1)).field, "window");
        assert_eq!(new(Fit::centred(6, 0, 1)).field, "order");
        let negative =
            Differentiator::<f32, 1, 8>::new(Fit::centred(6, 2, 1), Growth::Odd, -0.1).unwrap_err();
        assert_eq!((negative.field, negative.reason), ("period_tolerance", Invalid::Negative));
    }
}
