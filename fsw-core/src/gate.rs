//! 2. Gate: usable samples are finite, in range, in order and not repeated.
//!
//! Input: each sample as it arrives. Output: the time since the last usable sample, or the reason
//! for the rejection.
//!
//! | check, in this order | rejected where | reason |
//! |---|---|---|
//! | finite | a rate, wheel speed or torque is infinite or NaN | [`Rejection::NotFinite`] |
//! | range | a rate is at or beyond the range of the gyro | [`Rejection::OutOfRange`] |
//! | order | the time stamp is not later than the last one | [`Rejection::OutOfOrder`] |
//! | stuck | all rates repeat the last reading `stuck_after` times | [`Rejection::Stuck`] |
//!
//! A gap in time is not a rejection: the sample is usable, but the rate cannot be predicted to it
//! ([`Verdict::Gap`]).
//!
//! The attitude is not checked here, since most estimators do not use it. Spikes are detected
//! later, against the prediction ([`monitor::spikes`](crate::monitor::spikes)).

use crate::error::ConfigError;
use crate::math::{Vec3, range::positive, scalar::Real};
use crate::sample::Sample;

/// Limits of a usable sample.
///
/// ```
/// use fsw_core::gate::Config;
///
/// // A gyro of ±500 deg/s, sampled once per minute.
/// let config = Config { range_rad_s: 8.7f32, max_gap_us: 90_000_000, ..Config::default() };
/// assert_eq!(config.validate(), Ok(()));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// Range of the gyro, rad/s: a rate of this magnitude or more on any axis is saturated. Default
    /// 100, above the range of gyros for small satellites. Must be positive.
    pub range_rad_s: T,
    /// Longest interval across which the rate is predicted, µs. Default 1 s.
    pub max_gap_us: u64,
    /// Number of equal successive readings (all three axes, to the last bit) that identifies a
    /// stuck sensor; 0 disables the check. Default 10: one false rejection in 10⁸ samples with
    /// noise of a third of a quantum per axis.
    pub stuck_after: u16,
}

crate::persist!([T: Real] Config<T> { range_rad_s, max_gap_us, stuck_after });

impl<T: Real> Default for Config<T> {
    fn default() -> Self {
        Self { range_rad_s: T::lit(100.0), max_gap_us: 1_000_000, stuck_after: 10 }
    }
}

impl<T: Real> Config<T> {
    /// Range check of the limits.
    ///
    /// # Errors
    /// `gate.range_rad_s` not positive or not finite.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gate.range_rad_s", self.range_rad_s)
    }
}

/// Result of the gate for one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// First usable sample.
    First,
    /// Usable sample after another one.
    After {
        /// Time since the last usable sample, µs.
        elapsed_us: u64,
    },
    /// Usable sample after an interval longer than `max_gap_us`.
    Gap,
    /// Unusable sample.
    Rejected(Rejection),
}

/// Reason for the rejection of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// A value is infinite or NaN.
    NotFinite,
    /// A rate is at or beyond the range of the gyro.
    OutOfRange,
    /// The time stamp is not later than that of the last usable sample.
    OutOfOrder,
    /// The gyro repeats its reading to the last bit.
    Stuck,
}

impl Rejection {
    /// Name of the reason in logs and telemetry.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::OutOfRange => "out_of_range",
            Self::OutOfOrder => "out_of_order",
            Self::Stuck => "stuck",
        }
    }
}

/// Gate with the time and rate of the last usable sample.
///
/// ```
/// use fsw_core::gate::{Config, Gate, Rejection, Verdict};
/// use fsw_core::{Sample, Vec3};
///
/// let sample = |time_us, x: f32| Sample {
///     time_us,
///     rate_rad_s: Vec3::new(x, 0.0, 0.0),
///     wheel_speed_rad_s: [],
///     torque_n_m: Vec3::zeros(),
///     attitude: None,
/// };
/// let mut gate = Gate::new(Config::default());
/// assert_eq!(gate.check(&sample(0, 0.1)), Verdict::First);
/// assert_eq!(gate.check(&sample(100, f32::NAN)), Verdict::Rejected(Rejection::NotFinite));
/// assert_eq!(gate.check(&sample(200, 0.1)), Verdict::After { elapsed_us: 200 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate<T: Real> {
    config: Config<T>,
    /// Time stamp of the last usable sample, µs.
    last_time_us: Option<u64>,
    /// Last reading that was checked for a repetition, rad/s.
    last_rate_rad_s: Vec3<T>,
    /// Number of times that it has been repeated.
    repeats: u16,
}

crate::persist!([T: Real] Gate<T> { last_time_us, last_rate_rad_s, repeats; unchanged config });

impl<T: Real> Gate<T> {
    /// Gate before the first sample. `config` must have passed [`Config::validate`].
    pub fn new(config: Config<T>) -> Self {
        Self { config, last_time_us: None, last_rate_rad_s: Vec3::zeros(), repeats: 0 }
    }

    /// Result for one sample, by the checks finite, range, order, stuck, gap in this order.
    pub fn check<const W: usize>(&mut self, sample: &Sample<T, W>) -> Verdict {
        if !sample.is_finite() {
            return Verdict::Rejected(Rejection::NotFinite);
        }
        if sample.rate_rad_s.iter().any(|x| x.abs() >= self.config.range_rad_s) {
            return Verdict::Rejected(Rejection::OutOfRange);
        }
        if self.last_time_us.is_some_and(|last| sample.time_us <= last) {
            return Verdict::Rejected(Rejection::OutOfOrder);
        }
        if self.is_stuck(&sample.rate_rad_s) {
            return Verdict::Rejected(Rejection::Stuck);
        }
        match self.last_time_us.replace(sample.time_us) {
            None => Verdict::First,
            Some(last) => match sample.time_us - last {
                elapsed_us if elapsed_us <= self.config.max_gap_us => Verdict::After { elapsed_us },
                _ => Verdict::Gap,
            },
        }
    }

    /// Counts repetitions of a reading.
    fn is_stuck(&mut self, rate_rad_s: &Vec3<T>) -> bool {
        if self.last_time_us.is_some() && *rate_rad_s == self.last_rate_rad_s {
            self.repeats = self.repeats.saturating_add(1);
        } else {
            self.repeats = 0;
        }
        self.last_rate_rad_s = *rate_rad_s;
        self.config.stuck_after > 0 && self.repeats >= self.config.stuck_after
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_us: u64, x: f32) -> Sample<f32, 1> {
        Sample {
            time_us,
            rate_rad_s: Vec3::new(x, 0.0, 0.0),
            wheel_speed_rad_s: [0.0],
            torque_n_m: Vec3::zeros(),
            attitude: None,
        }
    }

    /// Order and gaps; the limit of the gap is one second.
    #[test]
    fn time_is_checked_for_order_and_gaps() {
        let mut gate = Gate::new(Config::default());
        assert_eq!(gate.check(&sample(5, 0.1)), Verdict::First);
        assert_eq!(gate.check(&sample(105, 0.2)), Verdict::After { elapsed_us: 100 });
        assert_eq!(gate.check(&sample(105, 0.3)), Verdict::Rejected(Rejection::OutOfOrder));
        assert_eq!(gate.check(&sample(50, 0.3)), Verdict::Rejected(Rejection::OutOfOrder));
        assert_eq!(gate.check(&sample(205, 0.3)), Verdict::After { elapsed_us: 100 });
        assert_eq!(gate.check(&sample(2_000_000, 0.4)), Verdict::Gap);
    }

    /// The interval to the last usable sample includes rejected samples.
    #[test]
    fn elapsed_time_spans_rejected_samples() {
        let mut gate = Gate::new(Config::default());
        gate.check(&sample(0, 0.1));
        assert_eq!(gate.check(&sample(100, f32::NAN)), Verdict::Rejected(Rejection::NotFinite));
        assert_eq!(gate.check(&sample(200, 0.2)), Verdict::After { elapsed_us: 200 });
    }

    /// One invalid value among rate, wheel speed and torque rejects the sample.
    #[test]
    fn every_value_is_checked() {
        let mut gate = Gate::new(Config::default());
        let mut broken = sample(0, 0.1);
        broken.wheel_speed_rad_s[0] = f32::INFINITY;
        assert_eq!(gate.check(&broken), Verdict::Rejected(Rejection::NotFinite));
        broken = sample(0, 0.1);
        broken.torque_n_m.z = f32::NAN;
        assert_eq!(gate.check(&broken), Verdict::Rejected(Rejection::NotFinite));
        assert_eq!(gate.check(&sample(0, -100.0)), Verdict::Rejected(Rejection::OutOfRange));
    }

    /// The first different reading is accepted again.
    #[test]
    fn a_stuck_sensor_is_rejected_until_it_moves() {
        let mut gate = Gate::new(Config { stuck_after: 3, ..Config::default() });
        for k in 0..3 {
            assert!(!matches!(gate.check(&sample(k, 0.5)), Verdict::Rejected(_)));
        }
        assert_eq!(gate.check(&sample(3, 0.5)), Verdict::Rejected(Rejection::Stuck));
        assert_eq!(gate.check(&sample(4, 0.6)), Verdict::After { elapsed_us: 2 });
    }
}
