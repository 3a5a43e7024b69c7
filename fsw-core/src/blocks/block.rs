//! Blocks: averages over a few samples, with the drive of wheels and external torque.
//!
//! A sample stands for the interval from half-way to the one before it to half-way to the one after. A
//! block is the intervals of a few samples. Total momentum h and rate ω satisfy `J ω = h − h_w` at each
//! sample, and so on average over the samples of a block, exactly:
//!
//! `J z̄ + h̄_w = h̄ + J v̄`
//!
//! with z̄ the mean of the readings and v̄ that of their noise. The external torque enters as its impulse
//! `I = ∫ τ dt`, a ramp of momentum, and as the part beyond that ramp, `g(t) = ∫ τ − I t/Δ`, which is zero at
//! both ends and known: of g the mean ḡ is stored, and a parabola stands for its course. By the end of
//! the block g has turned with the body, which adds `−∫ ω × g dt ≈ −ω̄ × ∫ g dt` to the impulse.
//!
//! Wheel momentum within a block is a parabola through its values at both ends with the right mean.
//!
//! # Ends of a record
//!
//! The interval of the first sample is symmetric about it, and so is that of the last one. In the outer halves the torque is
//! that of the sample, and wheel momentum is extrapolated linearly. Without the outer half the mean of N samples would err by
//! `ω̈ Δt² (N − 1) / 24`.
//!
//! # Hole in the rate
//!
//! Samples without a rate still have their drive. They become blocks of their own, of weight zero: these carry
//! the momentum across the hole as any others do, and no reading of theirs is compared with it. Their rate is a straight
//! line between the blocks beside the hole once a linear start needs it, and that before the hole until then.

use crate::dynamics::wheels::Momenta;
use crate::math::{Mat, Vec3, scalar::Real};

/// Weight of a reading that the gate has refused and bridged from its neighbours, samples. It keeps
/// the mean continuous in time, and has next to no influence on the fit.
pub const REFUSED_WEIGHT: f64 = 0.02;

/// Averages over the samples of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block<T: Real, const W: usize> {
    /// Number of accepted samples; the variance of `rate_rad_s` is σ² over this.
    pub weight: T,
    /// Length Δ, s.
    pub duration_s: T,
    /// z̄, mean gyro reading, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Mean momentum of each wheel about its own axis, N m s.
    pub wheels_n_m_s: Momenta<T, W>,
    /// The same at the end of the block, N m s.
    pub wheels_end_n_m_s: Momenta<T, W>,
    /// I, impulse of the external torque in body axes with the turning of g, N m s.
    pub impulse_n_m_s: Vec3<T>,
    /// ḡ, mean of the impulse beyond a ramp, N m s.
    pub beyond_ramp_n_m_s: Vec3<T>,
}

crate::persist!([T: Real, const W: usize] Block<T, W> {
    weight, duration_s, rate_rad_s, wheels_n_m_s, wheels_end_n_m_s, impulse_n_m_s, beyond_ramp_n_m_s
});

impl<T: Real, const W: usize> Block<T, W> {
    /// Block without content.
    pub fn empty() -> Self {
        let (zero, none) = (T::zero(), Vec3::zeros());
        Self {
            weight: zero,
            duration_s: zero,
            rate_rad_s: none,
            wheels_n_m_s: Momenta::zeros(),
            wheels_end_n_m_s: Momenta::zeros(),
            impulse_n_m_s: none,
            beyond_ramp_n_m_s: none,
        }
    }

    /// `d = h̄_w − ḡ`: mean of the momentum that does not belong to the body's smooth motion, N m s, for wheels
    /// with these unit axes.
    pub fn drive_n_m_s(&self, axes: &Mat<T, 3, W>) -> Vec3<T> {
        axes * self.wheels_n_m_s - self.beyond_ramp_n_m_s
    }

    /// True for a block without a reading of the rate.
    pub fn is_hole(&self) -> bool {
        self.weight == T::zero()
    }

    /// Square of the angle `|z̄| Δ`, rad².
    pub fn turn_square(&self) -> T {
        let turn = self.rate_rad_s * self.duration_s;
        turn.dot(&turn)
    }

    /// This block and the next one as one.
    ///
    /// Each block's ramp gives way to the common one, and the difference goes into ḡ. Means are by duration:
    /// that of the middle stays where samples come unevenly. Of a hole and another block, the rate is that of the other.
    #[inline(never)]
    pub fn merge(&self, next: &Self) -> Self {
        let half = T::lit(0.5);
        let duration_s = self.duration_s + next.duration_s;
        let share = self.duration_s / duration_s;
        let rest = T::one() - share;
        let of_rate = match (self.is_hole(), next.is_hole()) {
            (true, false) => T::zero(),
            (false, true) => T::one(),
            _ => share,
        };
        let impulse = self.impulse_n_m_s + next.impulse_n_m_s;
        // Means of the common ramp over the two halves, and of each half's own.
        let (t_a, t_b) = (self.duration_s * half, self.duration_s + next.duration_s * half);
        let per_s = impulse / duration_s;
        let beyond_a = self.impulse_n_m_s * half - per_s * t_a;
        let beyond_b = self.impulse_n_m_s + next.impulse_n_m_s * half - per_s * t_b;
        Self {
            weight: self.weight + next.weight,
            duration_s,
            rate_rad_s: self.rate_rad_s * of_rate + next.rate_rad_s * (T::one() - of_rate),
            wheels_n_m_s: self.wheels_n_m_s * share + next.wheels_n_m_s * rest,
            wheels_end_n_m_s: next.wheels_end_n_m_s,
            impulse_n_m_s: impulse
                - self.rate_rad_s.cross(&beyond_a) * self.duration_s
                - next.rate_rad_s.cross(&beyond_b) * next.duration_s,
            beyond_ramp_n_m_s: (self.beyond_ramp_n_m_s + beyond_a) * share
                + (next.beyond_ramp_n_m_s + beyond_b) * rest,
        }
    }
}

/// One sample as the averager takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<T: Real, const W: usize> {
    /// Samples: 1, [`REFUSED_WEIGHT`] of one that was refused and bridged, or zero in a hole.
    pub weight: T,
    /// False in a hole: its rate is not known, and it shares no block with one whose rate is.
    pub is_known: bool,
    /// Gyro, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Momentum of each wheel about its own axis, N m s.
    pub wheel_momentum_n_m_s: Momenta<T, W>,
    /// External torque, N m.
    pub torque_n_m: Vec3<T>,
}

crate::persist!([T: Real, const W: usize] Reading<T, W> { weight, is_known, rate_rad_s, wheel_momentum_n_m_s, torque_n_m });

/// End of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<T> {
    /// Number of samples.
    pub samples: u32,
    /// Angle turned, rad.
    pub turn_rad: T,
    /// True for a torque that is smooth between its samples, such as a sine; false for straight lines.
    pub is_torque_smooth: bool,
}

/// Relative difference of two intervals above which three readings are not evenly spaced.
const UNEVEN: f64 = 0.02;

/// Averages readings into blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Averager<T: Real, const W: usize> {
    /// The newest reading; its interval ends half-way to the next.
    newest: Reading<T, W>,
    /// Half of the interval before the newest reading, s; and the torque half-way in it.
    half_before_s: T,
    torque_before_n_m: Vec3<T>,
    /// Time after the newest reading that a finished block contains, s; zero where the reading is in no block yet.
    finished_s: T,
    /// Momentum of each wheel at the start of the first block, or of the first one after a finished block, N m s.
    wheels_at_start: Momenta<T, W>,
    /// Change of the torque over that interval, and how much more that was than over the one
    /// before, N m.
    torque_change_n_m: Vec3<T>,
    torque_bend_n_m: Option<Vec3<T>>,
    /// Wheel momentum one reading before the newest, N m s, and the interval to the newest, s; zero before the second reading.
    wheels_before_last: Momenta<T, W>,
    elapsed_before_s: T,
    /// The reading before the block, and the time from it to the newest, s.
    before: Reading<T, W>,
    since_before_s: T,
    /// Sums over the block so far.
    samples: u32,
    weight: T,
    duration_s: T,
    sum_time_s: T,
    sum_rate: Vec3<T>,
    sum_wheel_momentum: Momenta<T, W>,
    sum_impulse: Vec3<T>,
    impulse_n_m_s: Vec3<T>,
    /// ∫ I dt, N m s².
    impulse_integral: Vec3<T>,
}

crate::persist!([T: Real, const W: usize] Averager<T, W> {
    newest, half_before_s, torque_before_n_m, finished_s, wheels_at_start, torque_change_n_m, torque_bend_n_m, wheels_before_last, elapsed_before_s, before,
    since_before_s, samples, weight, duration_s, sum_time_s, sum_rate, sum_wheel_momentum, sum_impulse,
    impulse_n_m_s, impulse_integral
});

/// The newer of two bends of the torque, axis by axis, if it goes on as the older one did: same
/// sign, and not twice or half as large. A step or a corner bends it once, or to and fro.
fn smooth_part<T: Real>(older: &Vec3<T>, newer: &Vec3<T>) -> Vec3<T> {
    let half = T::lit(0.5);
    Vec3::from_fn(|i, _| {
        let (a, b) = (older[i], newer[i]);
        let alike = a * b > T::zero() && a.abs() > half * b.abs() && b.abs() > half * a.abs();
        if alike { b } else { T::zero() }
    })
}

impl<T: Real, const W: usize> Averager<T, W> {
    /// Starts at a reading; the first block begins half of the interval to the next one before it.
    pub fn new(first: Reading<T, W>) -> Self {
        let o = Vec3::zeros();
        Self {
            newest: first,
            half_before_s: T::zero(),
            torque_before_n_m: first.torque_n_m,
            finished_s: T::zero(),
            wheels_at_start: first.wheel_momentum_n_m_s,
            torque_change_n_m: o,
            torque_bend_n_m: None,
            wheels_before_last: first.wheel_momentum_n_m_s,
            elapsed_before_s: T::zero(),
            before: first,
            since_before_s: T::zero(),
            samples: 0,
            weight: T::zero(),
            duration_s: T::zero(),
            sum_time_s: T::zero(),
            sum_rate: o,
            sum_wheel_momentum: Momenta::zeros(),
            sum_impulse: o,
            impulse_n_m_s: o,
            impulse_integral: o,
        }
    }

    /// Takes in the next reading, `elapsed_s` after the last one, which completes the last one's
    /// interval. Returns the block that ends with it, if one does.
    pub fn add(
        &mut self,
        reading: Reading<T, W>,
        elapsed_s: T,
        limits: &Limits<T>,
    ) -> Option<Block<T, W>> {
        if self.finished_s > T::zero() {
            self.resume(reading, elapsed_s, limits.is_torque_smooth);
            return None;
        }
        let half = T::lit(0.5);
        let half_after_s = elapsed_s * half;
        let last = self.newest;
        let torque_after = (last.torque_n_m + reading.torque_n_m) * half;
        if self.elapsed_before_s == T::zero() {
            self.half_before_s = half_after_s;
            let change = reading.wheel_momentum_n_m_s - last.wheel_momentum_n_m_s;
            self.wheels_at_start = last.wheel_momentum_n_m_s - change * half;
        }
        self.push_newest(torque_after, half_after_s);
        if limits.is_torque_smooth {
            self.correct_for_bend(reading.torque_n_m - last.torque_n_m, elapsed_s);
        }
        let rate = reading.rate_rad_s;
        let turn = rate.dot(&rate) * self.duration_s * self.duration_s;
        let has_turned = turn > limits.turn_rad * limits.turn_rad;
        let wheels_end = self.wheels_half_way(&reading, elapsed_s);
        self.advance(reading, torque_after, elapsed_s);
        let has_changed = reading.is_known != last.is_known;
        if self.samples < limits.samples && !has_turned && !has_changed {
            return None;
        }
        let block = self.block_to(wheels_end);
        self.begin_block(last);
        block
    }

    /// Begins the block after one that ended with the interval of this reading.
    fn begin_block(&mut self, last: Reading<T, W>) {
        let o = Vec3::zeros();
        *self = Self {
            before: last,
            since_before_s: self.half_before_s + self.half_before_s,
            samples: 0,
            weight: T::zero(),
            duration_s: T::zero(),
            sum_time_s: T::zero(),
            sum_rate: o,
            sum_wheel_momentum: Momenta::zeros(),
            sum_impulse: o,
            impulse_n_m_s: o,
            impulse_integral: o,
            ..*self
        };
    }

    /// Adds the impulse of a torque that goes straight from one value to another, N m, and its
    /// integral: that of a parabola.
    fn push(&mut self, from_n_m: Vec3<T>, to_n_m: Vec3<T>, duration_s: T) {
        let before = self.impulse_n_m_s;
        self.impulse_n_m_s += (from_n_m + to_n_m) * (duration_s * T::lit(0.5));
        self.impulse_integral += (before + self.impulse_n_m_s) * (duration_s * T::lit(0.5))
            - (to_n_m - from_n_m) * (duration_s * duration_s * T::lit(1.0 / 12.0));
    }

    /// Straight lines from sample to sample are right for a torque that steps; for one that swings
    /// they are too long by a twelfth of its bend, `change` less the change before.
    #[inline(never)]
    fn correct_for_bend(&mut self, change: Vec3<T>, elapsed_s: T) {
        let bend = change - self.torque_change_n_m;
        self.torque_change_n_m = change;
        // The first reading's torque has nothing before it to bend from.
        if self.elapsed_before_s == T::zero() {
            return;
        }
        let twelfth = elapsed_s * T::lit(1.0 / 12.0);
        match self.torque_bend_n_m.replace(bend) {
            Some(older) => self.impulse_n_m_s -= smooth_part(&older, &bend) * twelfth,
            // With what the first half interval couldn't know.
            None => self.impulse_n_m_s -= bend * (twelfth * T::lit(1.5)),
        }
    }

    /// Wheel momentum half-way between the newest reading and the next one, N m s.
    ///
    /// By the parabola through three readings, `(−h₋ + 6 h + 3 h₊) / 8`, where they are about evenly
    /// spaced: its error is `h‴ Δt³ / 16`. By the straight line otherwise.
    fn wheels_half_way(&self, next: &Reading<T, W>, elapsed_s: T) -> Momenta<T, W> {
        let (before, after) = (self.wheels_before_last, next.wheel_momentum_n_m_s);
        let last_h = self.newest.wheel_momentum_n_m_s;
        let uneven = (self.elapsed_before_s - elapsed_s).abs() > elapsed_s * T::lit(UNEVEN);
        if uneven {
            (last_h + after) * T::lit(0.5)
        } else {
            (last_h * T::lit(6.0) + after * T::lit(3.0) - before) * T::lit(0.125)
        }
    }

    /// Ends the block with the interval of the newest reading, half of the interval before it after it; none if that has been
    /// done, or there is no second reading.
    #[inline(never)]
    pub fn finish(&mut self) -> Option<Block<T, W>> {
        if self.finished_s > T::zero() || self.elapsed_before_s == T::zero() {
            return None;
        }
        let newest = self.newest;
        let half_after_s = self.elapsed_before_s * T::lit(0.5);
        self.push_newest(newest.torque_n_m, half_after_s);
        let change = newest.wheel_momentum_n_m_s - self.wheels_before_last;
        self.wheels_at_start = newest.wheel_momentum_n_m_s + change * T::lit(0.5);
        self.finished_s = half_after_s;
        let block = self.block_to(self.wheels_at_start);
        self.begin_block(newest);
        self.since_before_s = T::zero();
        block
    }

    /// Momentum of each wheel at the start of the first block, or of the first one after a finished block, N m s.
    pub fn wheels_at_start_n_m_s(&self) -> Momenta<T, W> {
        self.wheels_at_start
    }

    /// Adds the newest reading, with its interval from half-way before it to this time after it, where the torque is
    /// `torque_after`.
    #[inline(never)]
    fn push_newest(&mut self, torque_after: Vec3<T>, half_after_s: T) {
        let last = self.newest;
        // Up to the reading's instant, and from there to the end of its interval.
        self.push(self.torque_before_n_m, last.torque_n_m, self.half_before_s);
        self.sum_impulse += self.impulse_n_m_s;
        self.sum_time_s += self.duration_s + self.half_before_s;
        self.push(last.torque_n_m, torque_after, half_after_s);
        self.duration_s += self.half_before_s + half_after_s;
        self.sum_rate += last.rate_rad_s;
        self.sum_wheel_momentum += last.wheel_momentum_n_m_s;
        self.samples += 1;
        self.weight += last.weight;
    }

    /// Takes in the first reading after a finished block, and begins the next one at its end, without a sample yet. The
    /// impulse is that between the two readings less what the finished block has of it. The duration is up to half-way
    /// between the two, and negative where that lies before the end of the finished block.
    #[inline(never)]
    fn resume(&mut self, reading: Reading<T, W>, elapsed_s: T, is_torque_smooth: bool) {
        let (half, last) = (T::lit(0.5), self.newest.torque_n_m);
        let half_after_s = elapsed_s * half;
        let torque_after = (last + reading.torque_n_m) * half;
        self.impulse_n_m_s = (last + torque_after) * (half_after_s * half) - last * self.finished_s;
        self.duration_s = (half_after_s - self.finished_s).max(-half_after_s);
        if is_torque_smooth {
            self.correct_for_bend(reading.torque_n_m - last, elapsed_s);
        }
        self.impulse_integral = self.impulse_n_m_s * (self.duration_s * half);
        self.finished_s = T::zero();
        self.advance(reading, torque_after, elapsed_s);
    }

    /// Makes a reading the newest one.
    fn advance(&mut self, reading: Reading<T, W>, torque_before: Vec3<T>, elapsed_s: T) {
        self.wheels_before_last = self.newest.wheel_momentum_n_m_s;
        self.newest = reading;
        self.half_before_s = elapsed_s * T::lit(0.5);
        self.torque_before_n_m = torque_before;
        self.since_before_s += elapsed_s;
        self.elapsed_before_s = elapsed_s;
    }

    /// The block so far, without the newest reading, for wheel momentum at its end; none if that is all.
    #[inline(never)]
    fn block_to(&self, wheels_end_n_m_s: Momenta<T, W>) -> Option<Block<T, W>> {
        if self.samples == 0 {
            return None;
        }
        let one_over = T::one() / T::count(self.samples);
        let mean_time_s = self.sum_time_s * one_over;
        let ramp = self.impulse_n_m_s * (mean_time_s / self.duration_s);
        let wheel_momentum = self.sum_wheel_momentum * one_over;
        let beyond_ramp = self.sum_impulse * one_over - ramp;
        // The mean instant of uneven samples isn't the block's middle: move the
        // means there, along the chord from the reading before the block to the one after it.
        let span_s = self.since_before_s.max(self.duration_s);
        let aside = (mean_time_s - self.duration_s * T::lit(0.5)) / span_s;
        let mut rate_slope = self.newest.rate_rad_s - self.before.rate_rad_s;
        if !(self.newest.is_known && self.before.is_known) {
            rate_slope = Vec3::zeros();
        }
        let wheel_slope = self.newest.wheel_momentum_n_m_s - self.before.wheel_momentum_n_m_s;
        let rate_rad_s = self.sum_rate * one_over - rate_slope * aside;
        let ramp_integral = self.impulse_n_m_s * (self.duration_s * T::lit(0.5));
        let turned = rate_rad_s.cross(&(self.impulse_integral - ramp_integral));
        Some(Block {
            weight: self.weight,
            duration_s: self.duration_s,
            rate_rad_s,
            wheels_n_m_s: wheel_momentum - wheel_slope * aside,
            wheels_end_n_m_s,
            impulse_n_m_s: self.impulse_n_m_s - turned,
            beyond_ramp_n_m_s: beyond_ramp,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    const NO_TURN: f64 = 1e9;

    /// So many samples in a block, and a torque that swings between them or not.
    fn limits(samples: u32, is_torque_smooth: bool) -> Limits<f64> {
        Limits { samples, turn_rad: NO_TURN, is_torque_smooth }
    }

    fn reading(rate: f64, wheel: f64, torque: f64) -> Reading<f64, 3> {
        Reading {
            weight: 1.0,
            is_known: true,
            rate_rad_s: Vec3::new(rate, 0.0, 0.0),
            wheel_momentum_n_m_s: Vec3::new(wheel, 0.0, 0.0),
            torque_n_m: Vec3::new(torque, 0.0, 0.0),
        }
    }

    /// Blocks of a body of unit inertia that turns about one axis, from rest, by these limits, at 10 Hz. Its momentum is
    /// the impulse of the torque.
    fn blocks(
        torque: impl Fn(f64) -> f64,
        impulse: impl Fn(f64) -> f64,
        limits: Limits<f64>,
    ) -> Vec<Block<f64, 3>> {
        let wheel = |t: f64| 0.3 * (0.7 * t).sin();
        let at = |k: u32| {
            let t = f64::from(k) * 0.1;
            reading(impulse(t) - wheel(t), wheel(t), torque(t))
        };
        let mut averager = Averager::new(at(0));
        (1..=80).filter_map(|k| averager.add(at(k), 0.1, &limits)).collect()
    }

    /// `h̄_ramp − d` of each block, with h followed by impulses alone, less z̄: zero but for
    /// rounding where the impulses are exact.
    fn misfit(blocks: &[Block<f64, 3>]) -> f64 {
        let (mut h, mut worst) = (0.0, 0.0f64);
        for block in blocks {
            let mean = h + block.impulse_n_m_s.x / 2.0;
            let misfit = mean - block.drive_n_m_s(&Mat::identity()).x - block.rate_rad_s.x;
            worst = worst.max(misfit.abs());
            h += block.impulse_n_m_s.x;
        }
        worst
    }

    /// Straight lines from sample to sample, as a torque table has them: exact.
    #[test]
    fn a_torque_that_steps_inside_a_block_is_exact() {
        let torque =
            |t: f64| (10.0 * (t - 3.1)).clamp(0.0, 1.0) - (10.0 * (t - 5.5)).clamp(0.0, 1.0);
        let ramp = |x: f64| {
            if x < 0.0 {
                0.0
            } else if x < 0.1 {
                5.0 * x * x
            } else {
                x - 0.05
            }
        };
        let impulse = |t: f64| ramp(t - 3.1) - ramp(t - 5.5);
        for samples in [1, 3, 8] {
            assert!(misfit(&blocks(torque, impulse, limits(samples, false))) < 1e-12);
        }
    }

    /// Torque known at its samples alone, 33 in a period. The curvature over half an interval is missing at each end,
    /// (2π · 0.3 Hz · 0.1 s)² · 0.1 s / 24 = 1.5e-4; the next sample restores it.
    #[test]
    fn a_torque_that_swings_is_followed_between_its_samples() {
        let w = 2.0 * std::f64::consts::PI * 0.3;
        let found = blocks(|t| (w * t).sin(), |t| (1.0 - (w * t).cos()) / w, limits(4, true));
        assert!(misfit(&found) < 3e-4, "{}", misfit(&found));
        let straight = w * w * 0.01 / 12.0 * 2.0 / w;
        assert!(straight > 3e-3, "straight lines would err by {straight}");
    }

    proptest! {
        #[test]
        fn two_blocks_merged_are_the_block_of_both(
            rates in prop::array::uniform32(-1.0..1.0f64),
            torques in prop::array::uniform32(-1.0..1.0f64),
        ) {
            let make = |samples: u32| -> Vec<Block<f64, 3>> {
                let at = |k: usize| reading(rates[k], 2.0 * rates[31 - k], torques[k]);
                let mut averager = Averager::new(at(0));
                (1..32).filter_map(|k| averager.add(at(k), 0.1, &limits(samples, true))).collect()
            };
            let (short, long) = (make(4), make(8));
            for k in 0..long.len() {
                let merged = short[2 * k].merge(&short[2 * k + 1]);
                prop_assert!((merged.weight - long[k].weight).abs() < 1e-12);
                prop_assert!((merged.duration_s - long[k].duration_s).abs() < 1e-12);
                prop_assert!((merged.rate_rad_s - long[k].rate_rad_s).norm() < 1e-12);
                prop_assert!((merged.drive_n_m_s(&Mat::identity()) - long[k].drive_n_m_s(&Mat::identity())).norm() < 1e-12);
                prop_assert!((merged.impulse_n_m_s - long[k].impulse_n_m_s).norm() < 1e-12);
            }
        }
    }

    /// A rate that swings: the first and the last block have its mean as the others have it, but for what the mean of N
    /// samples in a row lacks of the bend of the rate.
    #[test]
    fn first_and_last_block_have_the_mean_of_the_rate() {
        let (w, dt) = (3.0f64, 0.1);
        let at = |k: u32| reading((w * f64::from(k) * dt).sin(), 0.0, 0.0);
        for samples in [1, 2, 5, 9] {
            let mut averager = Averager::new(at(0));
            let mut found: Vec<Block<f64, 3>> =
                (1..27).filter_map(|k| averager.add(at(k), dt, &limits(samples, false))).collect();
            found.extend(averager.finish());
            assert_eq!(averager.finish(), None);
            let mut start = -dt / 2.0;
            for block in &found {
                let end = start + block.duration_s;
                let mean = ((w * start).cos() - (w * end).cos()) / (w * block.duration_s);
                let lacks =
                    w * ((w * end).cos() - (w * start).cos()) * dt * dt / 24.0 / block.duration_s;
                let misfit = block.rate_rad_s.x - (mean - lacks);
                // The next order of the mean is 7 / 5760.
                assert!(misfit.abs() < 1.3e-3 * (w * dt).powi(4), "{samples}: {misfit}");
                start = end;
            }
            assert!((start - 26.5 * dt).abs() < 1e-12);
        }
    }

    /// A finished block in mid-motion: the next one begins at its end, and no impulse is lost.
    #[test]
    fn blocks_go_on_after_a_finished_one() {
        let torque = |k: u32| f64::from(k * k % 7);
        for elapsed_s in [0.1, 0.07, 0.3] {
            let at = |k: u32| reading(0.0, 0.5 * f64::from(k), torque(k));
            let mut averager = Averager::new(at(0));
            let mut found: Vec<Block<f64, 3>> = Vec::new();
            found.extend((1..10).filter_map(|k| averager.add(at(k), 0.1, &limits(4, false))));
            found.extend(averager.finish());
            let end = found.last().expect("a block").wheels_end_n_m_s.x;
            assert_eq!(end, averager.wheels_at_start_n_m_s().x);
            assert_eq!(end, 4.75);
            found.extend(averager.add(at(10), elapsed_s, &limits(4, false)));
            found.extend((11..20).filter_map(|k| averager.add(at(k), 0.1, &limits(4, false))));
            found.extend(averager.finish());
            let total: f64 = found.iter().map(|block| block.duration_s).sum();
            let impulse: f64 = found.iter().map(|block| block.impulse_n_m_s.x).sum();
            let trapezoids: f64 = (1..20)
                .map(|k| if k == 10 { elapsed_s } else { 0.1 } * (torque(k - 1) + torque(k)) / 2.0)
                .sum();
            let ends = 0.05 * (torque(0) + torque(19));
            assert!((total - 1.8 - elapsed_s - 0.1).abs() < 1e-12, "{total}");
            assert!((impulse - trapezoids - ends).abs() < 1e-12, "{impulse}");
            assert_eq!(found.iter().map(|block| block.weight).sum::<f64>(), 20.0);
        }
    }

    /// A finished block in mid-motion leaves the impulse of a torque that swings as it is without.
    #[test]
    fn smooth_torque_goes_on_after_a_finished_block() {
        let at = |k: u32| reading(0.0, 0.0, (0.9 * f64::from(k)).sin());
        let impulse = |finished: Option<u32>| {
            let mut averager = Averager::new(at(0));
            let mut sum = 0.0;
            for k in 1..30 {
                sum +=
                    averager.add(at(k), 0.1, &limits(4, true)).map_or(0.0, |b| b.impulse_n_m_s.x);
                if finished == Some(k) {
                    sum += averager.finish().map_or(0.0, |block| block.impulse_n_m_s.x);
                }
            }
            sum + averager.finish().map_or(0.0, |block| block.impulse_n_m_s.x)
        };
        for k in 1..29 {
            let apart = impulse(Some(k)) - impulse(None);
            assert!(apart.abs() < 1e-12, "{k}: {apart}");
        }
    }

    #[test]
    fn uneven_samples_are_averaged_in_the_middle() {
        // A rate that grows steadily: its mean over a block is that of the block's middle.
        let times = [0.0, 0.1, 0.23, 0.3, 0.44, 0.5, 0.6];
        let mut averager = Averager::new(reading(0.0, 0.0, 0.0));
        let mut start = -0.05;
        for pair in times.windows(2) {
            let next = reading(pair[1], 0.0, 0.0);
            if let Some(block) = averager.add(next, pair[1] - pair[0], &limits(2, true)) {
                let middle = start + block.duration_s / 2.0;
                assert!((block.rate_rad_s.x - middle).abs() < 1e-12);
                start += block.duration_s;
            }
        }
        assert!(start > 0.4);
    }

    #[test]
    fn a_block_ends_where_it_has_turned_far() {
        let mut averager = Averager::new(reading(1.0, 0.0, 0.0));
        let turning = Limits { turn_rad: 0.42, ..limits(100, false) };
        let lengths: Vec<f64> = (0..40)
            .filter_map(|_| averager.add(reading(1.0, 0.0, 0.0), 0.1, &turning))
            .map(|block| block.duration_s)
            .collect();
        assert!(lengths.len() == 8 && lengths.iter().all(|s| (0.42..0.52).contains(s)));
    }
}
