//! A stream of evenly spaced samples, differentiated and smoothed as it comes.
//!
//! Input: time stamp and N channels. Output: value and first derivative of each channel, both of
//! the same polynomial at the same instant, and how long ago that was. The last C samples are
//! kept in a ring; nothing is allocated.

use super::kernel::{Fit, Kernel};
use crate::error::ConfigError;
use crate::math::range::{not_negative, within};
use crate::math::scalar::Real;

/// How the window fills after a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Growth {
    /// Nothing is said before it is full.
    WaitUntilFull,
    /// Two samples make a backward difference, then the window is the largest odd number of
    /// samples there are: 3, 3, 5, 5, 7 for 3 to 7 of them, \[Kim2013\].
    Odd,
}

/// What the window holds after a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pushed<T: Real, const N: usize> {
    /// Enough for a fit.
    Fitted(Fitted<T, N>),
    /// The window is still filling.
    Filling,
    /// The sample came too early or too late for the even spacing that the weights assume: the
    /// window starts anew with it.
    Restarted,
}

/// The polynomial through the window, at the evaluation point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted<T: Real, const N: usize> {
    /// Each channel's value, in its own unit.
    pub value: [T; N],
    /// Each channel's derivative, its unit per second.
    pub derivative_per_s: [T; N],
    /// Mean sample period of the window, s.
    pub period_s: T,
    /// How long before the newest sample the evaluation point lies, s.
    pub delay_s: T,
}

/// N channels, a window of up to C samples.
#[derive(Clone, Debug)]
pub struct Differentiator<T: Real, const N: usize, const C: usize> {
    pub(crate) fit: Fit<T>,
    pub(crate) growth: Growth,
    /// An interval may differ from the mean of those before it by this share.
    pub(crate) period_tolerance: T,
    pub(crate) ring: [([T; N], u64); C],
    /// Where the next sample goes.
    pub(crate) next: usize,
    pub(crate) filled: usize,
    pub(crate) smoothing: Kernel<T, C>,
    pub(crate) differentiation: Kernel<T, C>,
}

impl<T: Real, const N: usize, const C: usize> Differentiator<T, N, C> {
    /// Fits as `fit` says; its `derivative` is not looked at, since value and first derivative
    /// are both given.
    ///
    /// # Errors
    /// What [`Fit::validate`] refuses, an `order` of zero, and a negative `period_tolerance`.
    pub fn new(fit: Fit<T>, growth: Growth, period_tolerance: T) -> Result<Self, ConfigError> {
        fit.validate(C)?;
        within("order", fit.order, 1, fit.window - 1)?;
        not_negative("period_tolerance", period_tolerance)?;
        let [smoothing, differentiation] = Kernel::value_and_slope(&fit);
        Ok(Self {
            fit,
            growth,
            period_tolerance,
            ring: [([T::zero(); N], 0); C],
            next: 0,
            filled: 0,
            smoothing,
            differentiation,
        })
    }

    /// Forgets all samples.
    pub fn restart(&mut self) {
        self.filled = 0;
    }

    /// Takes in the next sample.
    pub fn push(&mut self, time_us: u64, channels: [T; N]) -> Pushed<T, N> {
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

    /// `Σᵢⱼ wᵢ wⱼ ρ^|i−j|` of the differentiating weights, per period²: see
    /// [`Kernel::noise_gain`].
    pub fn derivative_noise_gain(&self, correlation: T) -> T {
        self.differentiation.noise_gain(correlation)
    }

    /// Whether the sample follows at the mean interval of the window, within tolerance.
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

    /// How many of the samples there are make the window, if any.
    fn window(&self) -> Option<usize> {
        match (self.growth, self.filled) {
            (_, filled) if filled >= self.fit.window => Some(self.fit.window),
            (Growth::WaitUntilFull, _) | (_, 0 | 1) => None,
            (Growth::Odd, 2) => Some(2),
            (Growth::Odd, filled) => Some(filled - (1 - filled % 2)),
        }
    }

    fn fitted(&mut self, window: usize, time_us: u64) -> Fitted<T, N> {
        let at = self.set_window(window);
        let last = T::count(window as u32 - 1);
        let span_us = time_us.saturating_sub(self.stamp(window, 0));
        let period_s = T::seconds(span_us) / last;
        let per_second = T::one() / period_s;
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
            derivative_per_s[c] *= per_second;
        }
        Fitted { value, derivative_per_s, period_s, delay_s: (last - at) * period_s }
    }

    /// Weights for a window of this length, which changes only while it grows; returns where
    /// they evaluate. A grown window is evaluated in its middle.
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

    fn kim_2013() -> Differentiator<f64, 1, 8> {
        Differentiator::new(Fit::centred(7, 2, 1), Growth::Odd, 0.1).unwrap()
    }

    fn parabola(t: f64) -> [f64; 1] {
        [1.0 - 2.0 * t + 3.0 * t * t]
    }

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

    #[test]
    fn value_and_derivative_belong_to_the_instant_that_is_named() {
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

    #[test]
    fn the_first_difference_is_exact_for_a_line() {
        let mut d = kim_2013();
        d.push(0, [1.0]);
        let Pushed::Fitted(f) = d.push(PERIOD_US, [2.0]) else { panic!("two make a difference") };
        assert!((f.value[0] - 1.5).abs() < 1e-15);
        assert!((f.derivative_per_s[0] - 10.0).abs() < 1e-12);
        assert!((f.delay_s - 0.05).abs() < 1e-15);
    }

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

    #[test]
    fn time_that_stands_still_or_runs_back_restarts() {
        let mut d = kim_2013();
        d.push(5 * PERIOD_US, [0.0]);
        assert_eq!(d.push(5 * PERIOD_US, [0.0]), Pushed::Restarted);
        assert_eq!(d.push(PERIOD_US, [0.0]), Pushed::Restarted);
    }

    #[test]
    fn refuses_what_cannot_be_differentiated() {
        let new = |fit| Differentiator::<f32, 1, 8>::new(fit, Growth::Odd, 0.1).unwrap_err();
        assert_eq!(new(Fit::centred(9, 2, 1)).field, "window");
        assert_eq!(new(Fit::centred(6, 0, 1)).field, "order");
        let negative =
            Differentiator::<f32, 1, 8>::new(Fit::centred(6, 2, 1), Growth::Odd, -0.1).unwrap_err();
        assert_eq!((negative.field, negative.reason), ("period_tolerance", Invalid::Negative));
    }
}
