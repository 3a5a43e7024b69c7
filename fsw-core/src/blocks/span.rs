//! Drive within a block: course of wheel momentum and impulse, and its shift by a time offset.

use super::block::Block;
use crate::dynamics::wheels::Momenta;
use crate::math::{Mat, Vec3, scalar::Real};

/// A block with the wheel momentum at its start. Wheels and torque are times the unit κᵤ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<T: Real, const W: usize> {
    /// Block, scaled.
    pub block: Block<T, W>,
    /// Momentum of each wheel at its start, times the unit, rad/s.
    pub wheels_at_start: Momenta<T, W>,
    /// Number of samples between its ends.
    pub samples: T,
    /// Drive in the blocks before and after it, for a time offset; none where there is no block.
    pub before: Option<Courses<T, W>>,
    pub after: Option<Courses<T, W>>,
}

/// Course of wheels and impulse over a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Courses<T: Real, const W: usize> {
    wheels: Course<T, W>,
    /// Impulse of the external torque since the start of the block.
    impulse: Course<T, 3>,
}

/// N quantities over a block, each a parabola with its right mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course<T: Real, const N: usize> {
    /// A share s of the way through: `by_share[0] + s (by_share[1] + s by_share[2])`.
    by_share: [Mat<T, N, 1>; 3],
    duration_s: T,
}

impl<T: Real, const N: usize> Course<T, N> {
    /// Parabola through both ends whose mean, beyond the straight line, is `share` of a sixth of its bulge.
    fn through(
        start: &Mat<T, N, 1>,
        end: &Mat<T, N, 1>,
        mean: &Mat<T, N, 1>,
        share: T,
    ) -> [Mat<T, N, 1>; 3] {
        let beyond_line = mean - (start + end) * T::lit(0.5);
        let bulge = beyond_line * (share * T::lit(6.0));
        [*start, end - start + bulge, -bulge]
    }

    /// Value a share of the way through.
    fn at(&self, share: T) -> Mat<T, N, 1> {
        let [start, slope, bend] = self.by_share;
        start + (slope + bend * share) * share
    }

    /// Mean from one share to another.
    fn mean(&self, from: T, to: T) -> Mat<T, N, 1> {
        let [start, slope, bend] = self.by_share;
        let squares = from * from + from * to + to * to;
        start + slope * ((from + to) * T::lit(0.5)) + bend * (squares * T::lit(1.0 / 3.0))
    }

    /// The mean over the time `s` before its end, and the value there.
    fn before_end(&self, s: T) -> (Mat<T, N, 1>, Mat<T, N, 1>) {
        let from = T::one() - s / self.duration_s;
        (self.mean(from, T::one()), self.at(from))
    }

    /// The mean over the time `s` after its start, and the value there.
    fn after_start(&self, s: T) -> (Mat<T, N, 1>, Mat<T, N, 1>) {
        let to = s / self.duration_s;
        (self.mean(T::zero(), to), self.at(to))
    }

    /// Start, end and mean of what the block shows a time `earlier_s` before; negative for later.
    ///
    /// Both ends are read from the parabolas of the blocks that they lie in, and the mean loses the part of one end
    /// and gains that of the other one. Beyond the first and the last block the parabola of the block goes on.
    fn shifted(
        &self,
        earlier_s: T,
        before: Option<&Self>,
        after: Option<&Self>,
    ) -> [Mat<T, N, 1>; 3] {
        let mean = self.mean(T::zero(), T::one());
        let by = earlier_s.abs();
        let share = by / self.duration_s;
        if earlier_s > T::zero() {
            let (lost, end) = self.before_end(by);
            let (gained, start) = match before {
                Some(before) => before.before_end(by),
                None => (self.mean(-share, T::zero()), self.at(-share)),
            };
            [start, end, mean + (gained - lost) * share]
        } else {
            let (lost, start) = self.after_start(by);
            let beyond = T::one() + share;
            let (gained, end) = match after {
                Some(after) => after.after_start(by),
                None => (self.mean(T::one(), beyond), self.at(beyond)),
            };
            [start, end, mean + (gained - lost) * share]
        }
    }

    /// The course with a constant added.
    fn offset(mut self, by: &Mat<T, N, 1>) -> Self {
        self.by_share[0] += by;
        self
    }

    /// Value at the end of the block.
    fn end(&self) -> Mat<T, N, 1> {
        let [start, slope, bend] = self.by_share;
        start + slope + bend
    }
}

/// Mean over time of a parabola `s (1 − s)` over that of N samples, `1 / (1 + 1 / 2 N²)`.
pub(super) fn of_samples<T: Real>(samples: T) -> T {
    T::one() / (T::one() + T::lit(0.5) / (samples * samples))
}

impl<T: Real, const W: usize> Span<T, W> {
    /// Mean over time of a parabola `s (1 − s)` over that of its samples, `1 / (1 + 1 / 2 N²)`.
    pub fn of_samples(&self) -> T {
        of_samples(self.samples)
    }

    /// Mean impulse beyond a ramp over time, and the impulse, without the turning of the former.
    fn impulse(&self) -> (Vec3<T>, Vec3<T>) {
        let block = &self.block;
        let beyond = block.beyond_ramp_n_m_s * self.of_samples();
        // The impulse of a block has all of what the turning of g makes of it.
        let turned = block.rate_rad_s.cross(&beyond) * block.duration_s;
        (beyond, block.impulse_n_m_s + turned)
    }

    /// Course of wheels and impulse over the block.
    #[inline(never)]
    pub fn courses(&self) -> Courses<T, W> {
        let (start, block) = (&self.wheels_at_start, &self.block);
        let duration_s = block.duration_s;
        let (end, mean) = (&block.wheels_end_n_m_s, &block.wheels_n_m_s);
        let by_share = Course::through(start, end, mean, self.of_samples());
        let (beyond, impulse) = self.impulse();
        let mean = impulse * T::lit(0.5) + beyond;
        let of_impulse = Course::through(&Vec3::zeros(), &impulse, &mean, T::one());
        Courses {
            wheels: Course { by_share, duration_s },
            impulse: Course { by_share: of_impulse, duration_s },
        }
    }

    /// Drive that acts within the block, `delay_s` before its instants.
    pub fn drive_within(&self, delay_s: T) -> Drive<T, W> {
        if delay_s == T::zero() {
            let wheels = self.courses().wheels.by_share;
            let (beyond, impulse) = self.impulse();
            return Drive { wheels, wheel_mean: self.block.wheels_n_m_s, impulse, beyond };
        }
        self.drive_before(delay_s)
    }

    /// Drive that acts a time before the instants of the block.
    #[inline(never)]
    fn drive_before(&self, delay_s: T) -> Drive<T, W> {
        let own = self.courses();
        let [before, after] = [&self.before, &self.after].map(Option::as_ref);
        let wheels =
            own.wheels.shifted(delay_s, before.map(|b| &b.wheels), after.map(|a| &a.wheels));
        // The mean over the samples lacks a share of the bulge that the mean over time has.
        let [start, end, mean] = wheels;
        let line = (start + end) * T::lit(0.5);
        let wheel_mean = line + (mean - line) * (T::one() / self.of_samples());
        let wheels = Course::through(&start, &end, &mean, T::one());
        let before = before.map(|b| b.impulse.offset(&-b.impulse.end()));
        let after = after.map(|a| a.impulse.offset(&own.impulse.end()));
        let [start, end, mean] = own.impulse.shifted(delay_s, before.as_ref(), after.as_ref());
        let beyond = mean - (start + end) * T::lit(0.5);
        Drive { wheels, wheel_mean, impulse: end - start, beyond }
    }
}

/// Drive that acts within a block.
#[derive(Clone, Copy, Debug)]
pub struct Drive<T: Real, const W: usize> {
    /// Parabola of each wheel's momentum, and its mean over the samples.
    pub wheels: [Momenta<T, W>; 3],
    pub wheel_mean: Momenta<T, W>,
    /// Impulse of the external torque, and the mean over time of what it has beyond a ramp.
    pub impulse: Vec3<T>,
    pub beyond: Vec3<T>,
}
