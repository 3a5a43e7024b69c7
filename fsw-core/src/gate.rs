//! 2. Which samples are used: finite, in range, in order, no long gap, not stuck.
//!
//! Input: each sample as it arrives. Output: the time since the last one used, or the reason
//! why this one isn't. Spikes are recognised later, against the prediction
//! ([`monitor`](crate::monitor)).

use crate::error::ConfigError;
use crate::math::{Vec3, range::positive, scalar::Real};
use crate::sample::Sample;

/// What the gate lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// A rate of this size or more on any axis is saturated, rad/s. Default 100: no gyro of a
    /// small satellite measures more.
    pub range_rad_s: T,
    /// After a longer time without a usable sample the rate is no longer predicted across it,
    /// µs. Default 1 s.
    pub max_gap_us: u64,
    /// So many equal readings in a row (all three axes to the last bit) mean a stuck sensor;
    /// 0 switches the check off. Default 10: noise of a third of a quantum on each axis
    /// repeats a reading so often once in 10⁸ samples.
    pub stuck_after: u16,
}

crate::persist!([T: Real] Config<T> { range_rad_s, max_gap_us, stuck_after });

impl<T: Real> Default for Config<T> {
    fn default() -> Self {
        Self { range_rad_s: T::lit(100.0), max_gap_us: 1_000_000, stuck_after: 10 }
    }
}

impl<T: Real> Config<T> {
    /// Refuses what no sensor has.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gate.range_rad_s", self.range_rad_s)
    }
}

/// What the gate says of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The first usable sample.
    First,
    /// Usable, so many µs after the last usable one.
    After {
        /// Time since the last usable sample.
        elapsed_us: u64,
    },
    /// Usable, but too long after the last one to predict across.
    Gap,
    /// Not used.
    Rejected(Rejection),
}

/// Why a sample isn't used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// A value is infinite or NaN.
    NotFinite,
    /// A rate is at or beyond the sensor's range.
    OutOfRange,
    /// Its time stamp isn't after the last one.
    OutOfOrder,
    /// The gyro repeats itself to the last bit.
    Stuck,
}

impl Rejection {
    /// The reason in a word or two: for logs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::OutOfRange => "out_of_range",
            Self::OutOfOrder => "out_of_order",
            Self::Stuck => "stuck",
        }
    }
}

/// Remembers the last usable sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate<T: Real> {
    config: Config<T>,
    last_time_us: Option<u64>,
    last_rate_rad_s: Vec3<T>,
    repeats: u16,
}

crate::persist!([T: Real] Gate<T> { last_time_us, last_rate_rad_s, repeats; unchanged config });

impl<T: Real> Gate<T> {
    /// A gate that has seen nothing yet. `config` must have passed [`Config::validate`].
    pub fn new(config: Config<T>) -> Self {
        Self { config, last_time_us: None, last_rate_rad_s: Vec3::zeros(), repeats: 0 }
    }

    /// Judges one sample, in the order finite, range, order, stuck, gap.
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

    #[test]
    fn judges_time() {
        let mut gate = Gate::new(Config::default());
        assert_eq!(gate.check(&sample(5, 0.1)), Verdict::First);
        assert_eq!(gate.check(&sample(105, 0.2)), Verdict::After { elapsed_us: 100 });
        assert_eq!(gate.check(&sample(105, 0.3)), Verdict::Rejected(Rejection::OutOfOrder));
        assert_eq!(gate.check(&sample(50, 0.3)), Verdict::Rejected(Rejection::OutOfOrder));
        assert_eq!(gate.check(&sample(205, 0.3)), Verdict::After { elapsed_us: 100 });
        assert_eq!(gate.check(&sample(2_000_000, 0.4)), Verdict::Gap);
    }

    #[test]
    fn time_runs_on_across_rejected_samples() {
        let mut gate = Gate::new(Config::default());
        gate.check(&sample(0, 0.1));
        assert_eq!(gate.check(&sample(100, f32::NAN)), Verdict::Rejected(Rejection::NotFinite));
        assert_eq!(gate.check(&sample(200, 0.2)), Verdict::After { elapsed_us: 200 });
    }

    #[test]
    fn any_broken_value_counts() {
        let mut gate = Gate::new(Config::default());
        let mut broken = sample(0, 0.1);
        broken.wheel_speed_rad_s[0] = f32::INFINITY;
        assert_eq!(gate.check(&broken), Verdict::Rejected(Rejection::NotFinite));
        broken = sample(0, 0.1);
        broken.torque_n_m.z = f32::NAN;
        assert_eq!(gate.check(&broken), Verdict::Rejected(Rejection::NotFinite));
        assert_eq!(gate.check(&sample(0, -100.0)), Verdict::Rejected(Rejection::OutOfRange));
    }

    #[test]
    fn a_stuck_sensor_is_noticed_and_forgiven() {
        let mut gate = Gate::new(Config { stuck_after: 3, ..Config::default() });
        for k in 0..3 {
            assert!(!matches!(gate.check(&sample(k, 0.5)), Verdict::Rejected(_)));
        }
        assert_eq!(gate.check(&sample(3, 0.5)), Verdict::Rejected(Rejection::Stuck));
        assert_eq!(gate.check(&sample(4, 0.6)), Verdict::After { elapsed_us: 2 });
    }
}
