//! Player of a table: torques at the sample rate, limits, path to rest.

use super::table::Table;
use crate::math::{Vec3, norm, scalar::Real};

/// Longest time between two steps, µs: 0.3 s, three samples at 10 Hz. A torque acts no longer than this without a new
/// decision, where the caller steps the player without a reading in time.
pub const LONGEST_GAP_US: u64 = 300_000;
/// Readings in a row without a rate, or without the speed of a wheel, that are bridged. The third is an abort: isolated
/// spikes of a gyro and lost edges of a tachometer last one or two samples.
pub const MOST_REJECTED: u8 = 2;

/// [`LONGEST_GAP_US`] in seconds.
const LONGEST_GAP_S: f64 = 0.3;
/// Time constant of the law of rest, s: above [`LONGEST_GAP_US`], so that a wheel does not overshoot.
pub(super) const REST_S: f64 = 0.5;
/// Distance from the speed at the start that counts as rest: 1 rad/s, twice the slowest speed of a tachometer with 24
/// edges and half a second, or 0.2 % of the speed limit, where that is more: drag of 2e-5 N m on 1.5e-5 kg m² leaves
/// 0.7 rad/s.
const REST_RAD_S: f64 = 1.0;
const REST_SHARE: f64 = 2e-3;

/// Measurements at one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<T: Real, const W: usize> {
    /// Body rate, body axes, rad/s; `None` for a rejected or missing sample.
    pub rate_rad_s: Option<Vec3<T>>,
    /// Speed of each wheel relative to the body, rad/s; `None` for a wheel without a valid speed.
    pub wheel_speed_rad_s: [Option<T>; W],
}

impl<T: Real, const W: usize> Reading<T, W> {
    /// No measurement.
    pub const NONE: Self = Self { rate_rad_s: None, wheel_speed_rad_s: [None; W] };
}

/// Reason for the end of a manoeuvre before the end of its table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Abort {
    /// [`Player::abort`] with this reason: a telecommand.
    Command,
    /// Restart of the computer during the manoeuvre.
    Restart,
    /// Samples missing for [`LONGEST_GAP_US`], or a clock that ran backwards.
    Gap,
    /// Three samples of the gyro in a row rejected or unreadable.
    Glitch,
    /// Body rate beyond its limit.
    Rate,
    /// Rotation from the attitude at the start beyond its limit.
    Excursion,
    /// A wheel beyond its speed limit, or about to be.
    Speed,
    /// A wheel without a valid speed for three samples, or that does not follow its command.
    Wheel,
    /// The motors do not take commands.
    Motors,
}

/// State of a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// None since the start of the computer.
    Idle,
    /// Waiting for the start time.
    Waiting,
    /// The table is played.
    Flying,
    /// The wheels return to the speeds at the start.
    Resting,
    /// Ended, with the wheels at the speeds of the start.
    AtRest,
    /// Ended at the time limit, with a wheel elsewhere or of unknown speed.
    NotAtRest,
}

/// State and what was reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<T: Real, const W: usize> {
    /// State.
    pub state: State,
    /// Reason for an abort; `None` for a manoeuvre that is not or was not aborted.
    pub abort: Option<Abort>,
    /// Time in the table, µs; that of the end of the table's part that was flown, afterwards.
    pub flown_us: u32,
    /// Largest body rate relative to the mean one while waiting, rad/s.
    pub peak_rate_rad_s: T,
    /// Largest rotation from the attitude at the start, rad.
    pub peak_excursion_rad: T,
    /// Speed of each wheel at the start, rad/s.
    pub start_speed_rad_s: [T; W],
    /// Commanded torque of each motor, N m.
    pub torque_n_m: [T; W],
}

/// Phase with its data.
#[derive(Clone, Copy, Debug)]
enum Phase<T> {
    Idle,
    Waiting { at_us: u64 },
    Flying { since_us: u64 },
    Resting { left_s: T },
    Ended { is_at_rest: bool },
}

/// Player of a [`Table`] on `W` wheels.
#[derive(Clone, Copy, Debug)]
pub struct Player<T: Real, const W: usize> {
    phase: Phase<T>,
    spin_inertia_kg_m2: [T; W],
    abort: Option<Abort>,
    last_us: Option<u64>,
    flown_us: u32,
    start_speed_rad_s: [T; W],
    /// Measured, or propagated by the torque since; `None` before the first.
    speed_rad_s: [Option<T>; W],
    torque_n_m: [T; W],
    /// Mean rate while waiting, rad/s, and number of its readings.
    rest_rate_rad_s: Vec3<T>,
    rest_readings: u32,
    excursion: Excursion<T>,
    peak_rate_rad_s: T,
    peak_excursion_rad: T,
    /// Readings in a row without a rate, and without a speed of a wheel in use.
    without_rate: u8,
    without_speed: u8,
}

impl<T: Real, const W: usize> Player<T, W> {
    /// A player before its first manoeuvre, for wheels of these spin inertias, kg m²; zero for a place without a wheel.
    pub fn new(spin_inertia_kg_m2: [T; W]) -> Self {
        Self {
            phase: Phase::Idle,
            spin_inertia_kg_m2,
            abort: None,
            last_us: None,
            flown_us: 0,
            start_speed_rad_s: [T::ZERO; W],
            speed_rad_s: [None; W],
            torque_n_m: [T::ZERO; W],
            rest_rate_rad_s: Vec3::zeros(),
            rest_readings: 0,
            excursion: Excursion::none(),
            peak_rate_rad_s: T::ZERO,
            peak_excursion_rad: T::ZERO,
            without_rate: 0,
            without_speed: 0,
        }
    }

    /// Starts a manoeuvre at this time, µs, or at the next step if it is past. False during another one. The table must
    /// be valid ([`Table::validate`]).
    pub fn start(&mut self, at_us: u64) -> bool {
        if self.is_active() {
            return false;
        }
        *self = Self { phase: Phase::Waiting { at_us }, ..Self::new(self.spin_inertia_kg_m2) };
        true
    }

    /// Returns the wheels to these speeds, rad/s, after a restart during a manoeuvre. The present speeds are unknown
    /// until they are measured.
    pub fn rest_after_restart<const N: usize>(
        &mut self,
        table: &Table<T, W, N>,
        start_speed_rad_s: [T; W],
    ) {
        *self = Self { start_speed_rad_s, ..Self::new(self.spin_inertia_kg_m2) };
        self.rest(table, Some(Abort::Restart));
    }

    /// Aborts a manoeuvre at the next step: the wheels return to the speeds at the start. False without a manoeuvre
    /// that waits or flies.
    pub fn abort<const N: usize>(&mut self, table: &Table<T, W, N>, why: Abort) -> bool {
        match self.phase {
            Phase::Waiting { .. } => self.end_unmoved(why),
            Phase::Flying { .. } => self.rest(table, Some(why)),
            _ => return false,
        }
        true
    }

    /// True from the start to the end, the return to rest included.
    pub fn is_active(&self) -> bool {
        !matches!(self.phase, Phase::Idle | Phase::Ended { .. })
    }

    /// True while the wheels are commanded.
    pub fn is_moving(&self) -> bool {
        matches!(self.phase, Phase::Flying { .. } | Phase::Resting { .. })
    }

    /// True if a step is overdue at this time, µs: the caller steps without a reading.
    pub fn is_overdue(&self, now_us: u64) -> bool {
        let last_us = self.last_us.filter(|_| self.is_moving());
        last_us.is_some_and(|last_us| now_us.saturating_sub(last_us) >= LONGEST_GAP_US)
    }

    /// State and what was reached.
    pub fn progress(&self) -> Progress<T, W> {
        Progress {
            state: match self.phase {
                Phase::Idle => State::Idle,
                Phase::Waiting { .. } => State::Waiting,
                Phase::Flying { .. } => State::Flying,
                Phase::Resting { .. } => State::Resting,
                Phase::Ended { is_at_rest: true } => State::AtRest,
                Phase::Ended { is_at_rest: false } => State::NotAtRest,
            },
            abort: self.abort,
            flown_us: self.flown_us,
            peak_rate_rad_s: self.peak_rate_rad_s,
            peak_excursion_rad: self.peak_excursion_rad,
            start_speed_rad_s: self.start_speed_rad_s,
            torque_n_m: self.torque_n_m,
        }
    }

    /// Torque of each motor on its wheel from this time, µs, to the next step, N m: finite and within the limits of a
    /// valid table, whatever the reading.
    pub fn step<const N: usize>(
        &mut self,
        table: &Table<T, W, N>,
        time_us: u64,
        reading: &Reading<T, W>,
    ) -> [T; W] {
        let elapsed_us = self.last_us.map(|last_us| time_us.checked_sub(last_us));
        self.last_us = Some(time_us);
        let elapsed_s = T::seconds(elapsed_us.flatten().unwrap_or(0));
        self.take_speeds(table, elapsed_s, reading);
        self.take_rate(time_us, reading);
        if let Phase::Waiting { at_us } = self.phase
            && time_us >= at_us
        {
            self.take_off(table, time_us);
        }
        if let Phase::Flying { since_us } = self.phase {
            let is_gap = elapsed_us.is_some_and(|us| us.is_none_or(|us| us > LONGEST_GAP_US));
            let torque_n_m = self.planned_n_m(table, time_us, since_us, elapsed_us.flatten());
            let violation = if is_gap { Some(Abort::Gap) } else { self.violation(table) };
            match violation.or_else(|| self.overspeed(table, &torque_n_m)) {
                Some(why) => self.rest(table, Some(why)),
                None if self.flown_us >= table.duration_us() => self.rest(table, None),
                None => self.torque_n_m = torque_n_m,
            }
        }
        if let Phase::Resting { left_s } = self.phase {
            self.approach_rest(table, left_s, elapsed_s);
        }
        self.torque_n_m
    }

    /// Speeds as measured, or propagated by the torque since the last step.
    fn take_speeds<const N: usize>(
        &mut self,
        table: &Table<T, W, N>,
        elapsed_s: T,
        reading: &Reading<T, W>,
    ) {
        let mut is_missing = false;
        let wheels = self.speed_rad_s.iter_mut().zip(&reading.wheel_speed_rad_s);
        let wheels = wheels.zip(&self.torque_n_m).zip(&self.spin_inertia_kg_m2);
        for ((((speed, read), torque), spin), limit) in wheels.zip(&table.limits.torque_n_m) {
            let measured = read.filter(|speed| speed.is_finite());
            is_missing |= measured.is_none() && *limit > T::zero();
            let propagated = speed.map(|speed| speed + *torque / *spin * elapsed_s);
            *speed = measured.or(propagated).filter(|speed| speed.is_finite());
        }
        self.without_speed = if is_missing { self.without_speed.saturating_add(1) } else { 0 };
    }

    /// Rate and rotation from the attitude at the start, both relative to the mean rate while waiting.
    fn take_rate(&mut self, time_us: u64, reading: &Reading<T, W>) {
        // Squares of rates up to 1e18 rad/s are finite.
        let rate = reading.rate_rad_s.filter(|rate| rate.dot(rate).is_finite());
        let Some(rate_rad_s) = rate else {
            self.without_rate = self.without_rate.saturating_add(1);
            return;
        };
        self.without_rate = 0;
        if let Phase::Waiting { .. } = self.phase {
            self.rest_readings = self.rest_readings.saturating_add(1);
            let change = rate_rad_s - self.rest_rate_rad_s;
            self.rest_rate_rad_s += change / T::count(self.rest_readings);
        }
        self.excursion.turn(time_us, rate_rad_s - self.rest_rate_rad_s);
        if self.is_moving() {
            self.note_peaks();
        }
    }

    fn note_peaks(&mut self) {
        self.peak_rate_rad_s = self.peak_rate_rad_s.max(norm(&self.excursion.rate_rad_s));
        self.peak_excursion_rad = self.peak_excursion_rad.max(self.excursion.angle_rad());
    }

    /// Begins to fly, if rate and speeds are known and within their limits.
    fn take_off<const N: usize>(&mut self, table: &Table<T, W, N>, time_us: u64) {
        self.excursion = Excursion { attitude: [T::zero(); 3], scalar: T::one(), ..self.excursion };
        self.note_peaks();
        let is_known = self.without_rate == 0 && self.excursion.last_us.is_some();
        let why = match self.violation(table) {
            None if !is_known => Some(Abort::Glitch),
            None if self.without_speed > 0 => Some(Abort::Wheel),
            why => why,
        };
        if let Some(why) = why {
            return self.end_unmoved(why);
        }
        self.start_speed_rad_s = self.speed_rad_s.map(|speed| speed.unwrap_or(T::zero()));
        self.phase = Phase::Flying { since_us: time_us };
    }

    /// Planned torques until the next step. `flown_us` becomes the time in the table.
    ///
    /// The torque is that of the spline in the middle of the coming interval, which is taken as long as the last one: its
    /// impulse then is that of the spline within `T² ü / 24` of the torque.
    fn planned_n_m<const N: usize>(
        &mut self,
        table: &Table<T, W, N>,
        time_us: u64,
        since_us: u64,
        elapsed_us: Option<u64>,
    ) -> [T; W] {
        let flown_us = u32::try_from(time_us.saturating_sub(since_us)).unwrap_or(u32::MAX);
        self.flown_us = flown_us.min(table.duration_us());
        let half_us = elapsed_us.unwrap_or(0).min(LONGEST_GAP_US) as u32 / 2;
        let planned = table.torque_n_m(self.flown_us.saturating_add(half_us));
        within(planned, &table.limits.torque_n_m)
    }

    /// Limits of readings, rate and excursion, and speeds as they are.
    fn violation<const N: usize>(&self, table: &Table<T, W, N>) -> Option<Abort> {
        let limits = &table.limits;
        if self.without_rate > MOST_REJECTED {
            return Some(Abort::Glitch);
        }
        if self.without_speed > MOST_REJECTED {
            return Some(Abort::Wheel);
        }
        // Written so that NaN is a violation.
        let is_slow = norm(&self.excursion.rate_rad_s) <= limits.rate_rad_s;
        if !is_slow {
            return Some(Abort::Rate);
        }
        let is_near = self.excursion.angle_rad() <= limits.excursion_rad;
        if !is_near {
            return Some(Abort::Excursion);
        }
        None
    }

    /// A wheel in use beyond its speed limit, or after these torques for [`LONGEST_GAP_US`].
    fn overspeed<const N: usize>(
        &self,
        table: &Table<T, W, N>,
        torque_n_m: &[T; W],
    ) -> Option<Abort> {
        let limits = table.limits.torque_n_m.iter().zip(&table.limits.speed_rad_s);
        let wheels = self.speed_rad_s.iter().zip(torque_n_m).zip(&self.spin_inertia_kg_m2);
        let is_fast =
            |(((speed, torque), spin), (most_n_m, most_rad_s)): WheelWithLimits<'_, T>| {
                if *most_n_m <= T::zero() {
                    return false;
                }
                let Some(speed) = *speed else { return true };
                let ahead = speed + *torque / *spin * T::lit(LONGEST_GAP_S);
                let is_within = speed.abs() <= *most_rad_s && ahead.abs() <= *most_rad_s;
                !is_within
            };
        wheels.zip(limits).any(is_fast).then_some(Abort::Speed)
    }

    /// Ends a manoeuvre whose wheels have not moved.
    fn end_unmoved(&mut self, why: Abort) {
        self.abort = Some(why);
        self.phase = Phase::Ended { is_at_rest: true };
    }

    /// Begins the return to rest.
    fn rest<const N: usize>(&mut self, table: &Table<T, W, N>, why: Option<Abort>) {
        self.abort = why;
        self.phase = Phase::Resting { left_s: table.rest_s(&self.spin_inertia_kg_m2) };
    }

    /// Torques towards the speeds at the start; zero at the end.
    fn approach_rest<const N: usize>(&mut self, table: &Table<T, W, N>, left_s: T, elapsed_s: T) {
        let mut is_at_rest = true;
        let mut torque_n_m = [T::zero(); W];
        let limits = table.limits.torque_n_m.iter().zip(&table.limits.speed_rad_s);
        let wheels = torque_n_m.iter_mut().zip(&self.speed_rad_s).zip(&self.start_speed_rad_s);
        for ((((torque, speed), start), spin), (most_n_m, most_rad_s)) in
            wheels.zip(&self.spin_inertia_kg_m2).zip(limits)
        {
            if *most_n_m <= T::zero() {
                continue;
            }
            let away = speed.map(|speed| *start - speed);
            let near = T::lit(REST_RAD_S).max(T::lit(REST_SHARE) * *most_rad_s);
            is_at_rest &= away.is_some_and(|away| away.abs() <= near);
            *torque = away.map_or(T::zero(), |away| *spin * away / T::lit(REST_S));
        }
        let left_s = left_s - elapsed_s;
        let goes_on = !is_at_rest && left_s > T::zero();
        if goes_on {
            self.phase = Phase::Resting { left_s };
            self.torque_n_m = within(torque_n_m, &table.limits.torque_n_m);
        } else {
            self.phase = Phase::Ended { is_at_rest };
            self.torque_n_m = [T::zero(); W];
        }
    }
}

/// Speed, torque and spin inertia of a wheel, and its limits of torque and speed.
type WheelWithLimits<'a, T> = (((&'a Option<T>, &'a T), &'a T), (&'a T, &'a T));

/// Torques within their limits; zero in place of NaN.
fn within<T: Real, const W: usize>(mut torque_n_m: [T; W], most_n_m: &[T; W]) -> [T; W] {
    for (torque, most) in torque_n_m.iter_mut().zip(most_n_m) {
        let is_number = *torque <= T::zero() || *torque > T::zero();
        *torque = if is_number { torque.min(*most).max(-*most) } else { T::zero() };
    }
    torque_n_m
}

/// Rotation from the attitude at the start, by the quaternion `(v, s)` of the integrated rate.
#[derive(Clone, Copy, Debug)]
struct Excursion<T: Real> {
    attitude: [T; 3],
    scalar: T,
    rate_rad_s: Vec3<T>,
    /// Time of the last rate, µs.
    last_us: Option<u64>,
}

impl<T: Real> Excursion<T> {
    fn none() -> Self {
        let attitude = [T::zero(); 3];
        Self { attitude, scalar: T::one(), rate_rad_s: Vec3::zeros(), last_us: None }
    }

    /// Turns by the mean of the last rate and this one, rad/s: half angles `φ/2` to third order, within 1e-4 rad up to
    /// 0.5 rad a step.
    fn turn(&mut self, time_us: u64, rate_rad_s: Vec3<T>) {
        let elapsed_us = self.last_us.and_then(|last_us| time_us.checked_sub(last_us));
        let elapsed_s = T::seconds(elapsed_us.unwrap_or(0));
        let half = (self.rate_rad_s + rate_rad_s) * (T::lit(0.25) * elapsed_s);
        (self.rate_rad_s, self.last_us) = (rate_rad_s, Some(time_us));
        let square = half.dot(&half);
        let by = half * (T::one() - square / T::lit(6.0));
        let by_scalar = T::one() - square * T::lit(0.5);
        let [x, y, z] = self.attitude;
        let v = Vec3::new(x, y, z);
        let turned = by * self.scalar + v * by_scalar + v.cross(&by);
        let scalar = self.scalar * by_scalar - v.dot(&by);
        let size = (turned.dot(&turned) + scalar * scalar).sqrt();
        self.attitude = (turned / size).into();
        self.scalar = scalar / size;
    }

    /// Angle, rad, up to half a turn; NaN after a rate beyond all bounds.
    fn angle_rad(&self) -> T {
        let [x, y, z] = self.attitude;
        T::lit(2.0) * norm(&Vec3::new(x, y, z)).atan2(self.scalar.abs())
    }
}
