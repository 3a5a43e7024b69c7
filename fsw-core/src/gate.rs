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
//! # Hole in the rate
//!
//! A sample whose rate alone is rejected still has the drive of its instant: wheel speeds and torque. An estimator that
//! integrates the drive takes it ([`Gate::bridge`]), and its time stamp becomes the reference for the next interval. The
//! motion across the hole then follows from the drive exactly, by the same model as between two readings: its
//! error does not grow with the length. A start without an estimate takes the attitude across the hole from a straight
//! line between the rates at its ends. The hole ends as a gap where the larger of both has turned the body by more than
//! 1 rad, a third of the half turn at which two attitudes would become ambiguous, or after 30 s, as long as the rest
//! that ends a window. Holes up to `max_gap_us` are bridged at all rates.
//!
//! # Change of the clock
//!
//! One time stamp far ahead, or a clock that is set back, leaves all later samples out of order.
//! Eight such samples in a row, in order among themselves, show a change of the clock: the eighth is
//! a gap with the cause [`Gap::Clock`], and its time stamp the new reference. Late samples in
//! between, and rows that are repeated or in the wrong order, do not change the reference.
//!
//! The attitude is not checked here, since most estimators do not use it. Spikes are detected
//! later, against the prediction ([`monitor::spikes`](crate::monitor::spikes)).

use crate::error::ConfigError;
use crate::math::{Vec3, norm, range::positive, scalar::Real};
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
    /// Longest interval between two samples of known drive across which the rate is predicted, µs. Default 1 s. The torque
    /// is a straight line within it ([`interval`](crate::dynamics::interval)), which errs by 31 % of a sine of 0.25 Hz over
    /// 1 s, and by 5 % over 0.4 s.
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
    /// Usable sample after an interval longer than `max_gap_us` or after a change of the clock:
    /// [`Gate::cause_of_gap`].
    Gap,
    /// Unusable sample.
    Rejected(Rejection),
}

/// Cause of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Gap {
    /// No usable sample for longer than `max_gap_us`.
    Interval,
    /// Change of the clock: the time since the last usable sample is unknown.
    Clock,
}

crate::persist!([] enum Gap { 0 => Interval, 1 => Clock });

/// Samples out of order in a row, in order among themselves, that show a change of the clock.
///
/// More than a delayed block: the FIFO of a gyro or a packet of telemetry that arrives late holds up
/// to some samples, and these must not move the reference. A change costs this number of samples,
/// 0.8 s at 10 Hz.
const RESYNCHRONISED_AFTER: u8 = 8;

/// Longest hole in the rate, µs, and largest angle that the body turns in it, rad, where it is longer than `max_gap_us`.
const MOST_HOLE_US: u64 = 30_000_000;
const MOST_HOLE_TURN_RAD: f64 = 1.0;

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
    /// Time stamp of the last sample that was usable or bridged, µs.
    last_time_us: Option<u64>,
    /// Time stamp of the last usable sample, µs, and its speed of rotation, rad/s.
    last_rate_us: u64,
    last_speed_rad_s: T,
    /// Last reading that was checked for a repetition, rad/s.
    last_rate_rad_s: Vec3<T>,
    /// Number of times that it has been repeated.
    repeats: u16,
    /// Samples out of order in a row that are in order among themselves.
    late: u8,
    /// Time stamp of the last of them, µs.
    late_time_us: u64,
    cause_of_gap: Gap,
}

crate::persist!([T: Real] Gate<T> {
    last_time_us, last_rate_us, last_speed_rad_s, last_rate_rad_s, repeats, late, late_time_us, cause_of_gap; unchanged config
});

impl<T: Real> Gate<T> {
    /// Gate before the first sample. `config` must have passed [`Config::validate`].
    pub fn new(config: Config<T>) -> Self {
        Self {
            config,
            last_time_us: None,
            last_rate_us: 0,
            last_speed_rad_s: T::zero(),
            last_rate_rad_s: Vec3::zeros(),
            repeats: 0,
            late: 0,
            late_time_us: 0,
            cause_of_gap: Gap::Interval,
        }
    }

    /// Cause of the last [`Verdict::Gap`].
    pub fn cause_of_gap(&self) -> Gap {
        self.cause_of_gap
    }

    /// Result for one sample, by the checks finite, range, order, stuck, gap in this order.
    pub fn check<const W: usize>(&mut self, sample: &Sample<T, W>) -> Verdict {
        if !sample.is_finite() {
            return Verdict::Rejected(Rejection::NotFinite);
        }
        if sample.rate_rad_s.iter().any(|x| x.abs() >= self.config.range_rad_s) {
            return Verdict::Rejected(Rejection::OutOfRange);
        }
        let is_late = self.last_time_us.is_some_and(|last| sample.time_us <= last);
        if is_late && !self.is_new_clock(sample.time_us) {
            return Verdict::Rejected(Rejection::OutOfOrder);
        }
        if self.is_stuck(&sample.rate_rad_s) {
            return Verdict::Rejected(Rejection::Stuck);
        }
        self.late = 0;
        let speed_rad_s = norm(&sample.rate_rad_s);
        let last_speed_rad_s = core::mem::replace(&mut self.last_speed_rad_s, speed_rad_s);
        let last_rate_us = core::mem::replace(&mut self.last_rate_us, sample.time_us);
        let Some(last) = self.last_time_us.replace(sample.time_us) else {
            return Verdict::First;
        };
        let elapsed_us = sample.time_us.wrapping_sub(last);
        let hole_us = sample.time_us.wrapping_sub(last_rate_us);
        let is_bridged = self.is_short(hole_us, last_speed_rad_s.max(speed_rad_s));
        if !is_late && elapsed_us <= self.config.max_gap_us && is_bridged {
            return Verdict::After { elapsed_us };
        }
        self.cause_of_gap = if is_late { Gap::Clock } else { Gap::Interval };
        Verdict::Gap
    }

    /// Time since the last sample that was usable or bridged, µs, for a sample that [`check`](Self::check) has just
    /// rejected for its rate alone. None where its drive is not usable either: not finite, out of order, after a gap, or
    /// after a hole in the rate that is too long.
    ///
    /// ```
    /// use fsw_core::gate::{Config, Gate, Rejection, Verdict};
    /// use fsw_core::{Sample, Vec3};
    ///
    /// let sample = |time_us, x: f32| Sample {
    ///     time_us,
    ///     rate_rad_s: Vec3::new(x, 0.0, 0.0),
    ///     wheel_speed_rad_s: [50.0],
    ///     torque_n_m: Vec3::zeros(),
    ///     attitude: None,
    /// };
    /// let mut gate = Gate::new(Config::default());
    /// gate.check(&sample(0, 0.1));
    /// let bad = sample(100, f32::NAN);
    /// assert_eq!(gate.check(&bad), Verdict::Rejected(Rejection::NotFinite));
    /// assert_eq!(gate.bridge(&bad), Some(100));
    /// assert_eq!(gate.check(&sample(200, 0.1)), Verdict::After { elapsed_us: 100 });
    /// ```
    pub fn bridge<const W: usize>(&mut self, sample: &Sample<T, W>) -> Option<u64> {
        let elapsed_us = sample.time_us.checked_sub(self.last_time_us?)?;
        let hole_us = sample.time_us.wrapping_sub(self.last_rate_us);
        let is_in_order = elapsed_us > 0 && elapsed_us <= self.config.max_gap_us;
        let is_usable = is_in_order && sample.is_drive_finite();
        if !is_usable || !self.is_short(hole_us, self.last_speed_rad_s) {
            return None;
        }
        self.late = 0;
        self.last_time_us = Some(sample.time_us);
        Some(elapsed_us)
    }

    /// True for a hole in the rate that is bridged by the drive, at this speed of rotation, rad/s.
    fn is_short(&self, hole_us: u64, speed_rad_s: T) -> bool {
        let turns_little = || speed_rad_s * T::seconds(hole_us) <= T::lit(MOST_HOLE_TURN_RAD);
        hole_us <= self.config.max_gap_us || hole_us <= MOST_HOLE_US && turns_little()
    }

    /// Counts a sample that is not later than the last usable one; true once a run of them shows a
    /// change of the clock.
    fn is_new_clock(&mut self, time_us: u64) -> bool {
        let is_in_order = self.late > 0 && time_us > self.late_time_us;
        self.late = if is_in_order { self.late.saturating_add(1) } else { 1 };
        self.late_time_us = time_us;
        self.late >= RESYNCHRONISED_AFTER
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
    use std::vec::Vec;

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

    /// Verdicts on samples of these times, each with another reading.
    fn verdicts(gate: &mut Gate<f32>, times_us: impl IntoIterator<Item = u64>) -> Vec<Verdict> {
        let rate = |k: usize| 0.1 + 0.001 * k as f32;
        let samples = times_us.into_iter().enumerate().map(|(k, time_us)| sample(time_us, rate(k)));
        samples.map(|sample| gate.check(&sample)).collect()
    }

    /// Bits of every sign and exponent with the mantissas 0, 1, the largest quiet and signalling ones, and the neighbours
    /// of the range.
    fn classes(range_rad_s: f32) -> Vec<f32> {
        let mantissas = [0, 1, 0x003f_ffff, 0x0040_0000, 0x007f_ffff];
        let heads = (0..1 << 9).map(|head: u32| head << 23);
        let bits = heads.flat_map(|head| mantissas.map(|mantissa| head | mantissa));
        let near = [range_rad_s.to_bits() - 1, range_rad_s.to_bits(), range_rad_s.to_bits() + 1];
        let near = near.into_iter().flat_map(|bits| [bits, bits | 1 << 31]);
        bits.chain(near).map(f32::from_bits).collect()
    }

    /// A sample whose numbers are these: rates, wheel speed, torques.
    fn of_numbers(time_us: u64, numbers: &[f32; 7]) -> Sample<f32, 1> {
        let [x, y, z, speed, a, b, c] = *numbers;
        Sample {
            time_us,
            rate_rad_s: Vec3::new(x, y, z),
            wheel_speed_rad_s: [speed],
            torque_n_m: Vec3::new(a, b, c),
            attitude: None,
        }
    }

    /// The verdict by bits: an exponent of ones is not finite, and magnitudes compare as integers.
    fn expected(last_us: Option<u64>, sample: (u64, &[f32; 7]), config: &Config<f32>) -> Verdict {
        let magnitude = |number: &f32| number.to_bits() & 0x7fff_ffff;
        let (time_us, numbers) = sample;
        if numbers.iter().any(|number| magnitude(number) >= 0xff << 23) {
            return Verdict::Rejected(Rejection::NotFinite);
        }
        if numbers[..3].iter().any(|rate| magnitude(rate) >= config.range_rad_s.to_bits()) {
            return Verdict::Rejected(Rejection::OutOfRange);
        }
        let Some(last_us) = last_us else { return Verdict::First };
        match time_us.checked_sub(last_us) {
            None | Some(0) => Verdict::Rejected(Rejection::OutOfOrder),
            Some(elapsed_us) if elapsed_us <= config.max_gap_us => Verdict::After { elapsed_us },
            Some(_) => Verdict::Gap,
        }
    }

    /// Every class of numbers in each of seven places, and every pair of 25 classes in two places, at each class of time
    /// stamps: 435,000 samples.
    #[test]
    fn every_class_of_numbers_and_stamps_has_its_verdict() {
        let config = Config { range_rad_s: 8.75_f32, max_gap_us: 1_000_000, stuck_after: 0 };
        let (classes, usable) = (classes(config.range_rad_s), [0.1, 0.2, 0.3, 4.0, 0.0, 0.0, 0.0]);
        let last_us = 2_000_000;
        let stamps = [
            0,
            last_us - 1,
            last_us,
            last_us + 1,
            last_us + 1_000_000,
            last_us + 1_000_001,
            u64::MAX,
        ];
        let check = |numbers: &[f32; 7]| {
            for time_us in stamps {
                for last_us in [None, Some(last_us)] {
                    let mut gate = Gate::new(config);
                    if let Some(last_us) = last_us {
                        gate.check(&of_numbers(last_us, &usable));
                    }
                    let found = gate.check(&of_numbers(time_us, numbers));
                    let expected = expected(last_us, (time_us, numbers), &config);
                    assert_eq!(found, expected, "{numbers:?} at {time_us} after {last_us:?}");
                }
            }
        };
        for place in 0..7 {
            for class in &classes {
                let mut numbers = usable;
                numbers[place] = *class;
                check(&numbers);
            }
        }
        let few: Vec<f32> = classes.iter().copied().step_by(classes.len() / 24).collect();
        for (a, b) in (0..7).flat_map(|a| (0..a).map(move |b| (a, b))) {
            for (first, second) in few.iter().flat_map(|x| few.iter().map(move |y| (x, y))) {
                let mut numbers = usable;
                (numbers[a], numbers[b]) = (*first, *second);
                check(&numbers);
            }
        }
    }

    const DAY_US: u64 = 86_400_000_000;
    const LATE: Verdict = Verdict::Rejected(Rejection::OutOfOrder);

    /// Seven samples rejected, then a gap and the old rhythm.
    #[test]
    fn one_stamp_a_day_ahead_costs_eight_samples() {
        let mut gate = Gate::new(Config::default());
        let times = (0..20).map(|k| if k == 3 { DAY_US } else { 1000 * k });
        let found = verdicts(&mut gate, times);
        assert_eq!(found[3], Verdict::Gap);
        assert_eq!(found[4..11], [LATE; 7]);
        assert_eq!((found[11], gate.cause_of_gap()), (Verdict::Gap, Gap::Clock));
        assert_eq!(found[12..], [Verdict::After { elapsed_us: 1000 }; 8]);
    }

    /// A clock that is set back by a day, and one that starts at zero again.
    #[test]
    fn a_clock_that_is_set_back_becomes_the_reference() {
        for back in [DAY_US, 2 * DAY_US] {
            let mut gate = Gate::new(Config::default());
            let times = (0..30).map(|k| 2 * DAY_US + 1000 * k - if k < 10 { 0 } else { back });
            let found = verdicts(&mut gate, times);
            assert_eq!(found[10..17], [LATE; 7]);
            assert_eq!((found[17], gate.cause_of_gap()), (Verdict::Gap, Gap::Clock));
            assert_eq!(found[18..], [Verdict::After { elapsed_us: 1000 }; 12]);
        }
    }

    /// A block of seven that arrives late, the same row many times, a descending order.
    #[test]
    fn late_samples_do_not_move_the_reference() {
        let mut gate = Gate::new(Config::default());
        assert_eq!(verdicts(&mut gate, [9000])[0], Verdict::First);
        assert_eq!(verdicts(&mut gate, (0..7).map(|k| 1000 * k)), [LATE; 7]);
        assert_eq!(verdicts(&mut gate, [10_000]), [Verdict::After { elapsed_us: 1000 }]);
        assert_eq!(verdicts(&mut gate, [10_000; 50]), [LATE; 50]);
        assert_eq!(verdicts(&mut gate, (0..50).map(|k| 9000 - 10 * k)), [LATE; 50]);
        assert_eq!(verdicts(&mut gate, [11_000]), [Verdict::After { elapsed_us: 1000 }]);
    }

    /// A gap after a change of the clock has its own cause.
    #[test]
    fn the_cause_is_that_of_the_last_gap() {
        let mut gate = Gate::new(Config::default());
        verdicts(&mut gate, (0..20).map(|k| if k < 10 { DAY_US + k } else { k }));
        assert_eq!(gate.cause_of_gap(), Gap::Clock);
        assert_eq!(verdicts(&mut gate, [DAY_US]), [Verdict::Gap]);
        assert_eq!(gate.cause_of_gap(), Gap::Interval);
    }

    /// The interval to the last usable sample includes rejected samples.
    #[test]
    fn elapsed_time_spans_rejected_samples() {
        let mut gate = Gate::new(Config::default());
        gate.check(&sample(0, 0.1));
        assert_eq!(gate.check(&sample(100, f32::NAN)), Verdict::Rejected(Rejection::NotFinite));
        assert_eq!(gate.check(&sample(200, 0.2)), Verdict::After { elapsed_us: 200 });
    }

    /// Verdict after a hole in the rate, with a drive every 0.1 s, between readings of this rate, rad/s.
    fn after_hole(length_us: u64, x: f32) -> Verdict {
        let mut gate = Gate::new(Config::default());
        gate.check(&sample(0, x));
        for time_us in (100_000..length_us).step_by(100_000) {
            let bad = sample(time_us, f32::NAN);
            assert_eq!(gate.check(&bad), Verdict::Rejected(Rejection::NotFinite));
            gate.bridge(&bad);
        }
        gate.check(&sample(length_us, 0.99 * x))
    }

    /// Limits of a hole: a turn of 1 rad and 30 s; at any rate the longest gap.
    #[test]
    fn a_hole_in_the_rate_ends_by_its_turn() {
        let bridged = Verdict::After { elapsed_us: 100_000 };
        assert_eq!(after_hole(9_000_000, 0.1), bridged);
        assert_eq!(after_hole(11_000_000, 0.1), Verdict::Gap);
        assert_eq!(after_hole(1_000_000, 10.0), bridged);
        assert_eq!(after_hole(30_000_000, 0.01), bridged);
        assert_eq!(after_hole(30_100_000, 0.01), Verdict::Gap);
    }

    /// No drive, a late sample, one beyond a gap, and the time before the first sample.
    #[test]
    fn a_sample_without_a_drive_is_not_bridged() {
        let mut gate = Gate::new(Config::default());
        assert_eq!(gate.bridge(&sample(0, f32::NAN)), None);
        gate.check(&sample(100_000, 0.1));
        for time_us in [50_000, 100_000, 1_200_000] {
            assert_eq!(gate.bridge(&sample(time_us, f32::NAN)), None, "{time_us}");
        }
        let mut broken = sample(200_000, f32::NAN);
        broken.wheel_speed_rad_s[0] = f32::NAN;
        assert_eq!(gate.bridge(&broken), None);
        assert_eq!(gate.bridge(&sample(200_000, f32::NAN)), Some(100_000));
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
