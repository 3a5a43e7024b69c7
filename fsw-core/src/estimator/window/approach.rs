//! Blocks as a pass comes to them: each with what its neighbours tell of its inside.
//!
//! Wheel momentum half-way between the means of two blocks is where one ends and the other begins, and
//! what the external torque does inside a block shows in how it changes from the block before to the
//! one after. What is found on the way from one block to the next is kept, so that each is unpacked
//! once a pass.

use super::block::Block;
use super::trajectory::Span;
use crate::math::{Vec3, scalar::Real};

/// The next block that a pass crosses, and the one after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach<T: Real> {
    here: Option<Block<T>>,
    after: Option<Block<T>>,
    /// Of the next block: mean wheel momentum, that at its start if anything is before it, and what the
    /// torque's impulse is beyond a ramp.
    mean: Vec3<T>,
    start: Option<Vec3<T>>,
    beyond_ramp: Vec3<T>,
}

crate::persist!([T: Real] Approach<T> { here, after, mean, start, beyond_ramp });

impl<T: Real> Approach<T> {
    /// Nothing ahead.
    pub fn nothing() -> Self {
        let none = Vec3::zeros();
        Self { here: None, after: None, mean: none, start: None, beyond_ramp: none }
    }

    /// Two blocks ahead, the last of these, and two before them, as far as there are.
    pub fn begin(&mut self, around: [Option<Block<T>>; 4]) {
        let [second_before, before, here, after] = around;
        (self.here, self.after) = (here, after);
        let Some(here) = here else { return };
        self.beyond_ramp = beyond_ramp(before.as_ref(), &here, after.as_ref());
        self.mean = wheel_momentum(&here, &self.beyond_ramp);
        self.start = before.map(|before| {
            let beyond = beyond_ramp(second_before.as_ref(), &before, Some(&here));
            half_way(&before, &wheel_momentum(&before, &beyond), &here, &self.mean)
        });
    }

    /// Whether no block is ahead.
    pub fn is_at_the_end(&self) -> bool {
        self.here.is_none()
    }

    /// The next block's number of samples is this, and if zero its rate isn't to be believed.
    pub fn set_samples(&mut self, samples: u32) {
        if let Some(here) = &mut self.here {
            here.samples = samples;
        }
    }

    /// Goes on to the next block, and returns the one that is to be crossed in units of an inertia
    /// whose inverse is `per`. `second_after` comes after the two that are ahead.
    pub fn go_on(&mut self, second_after: Option<Block<T>>, per: T) -> Option<Span<T>> {
        let here = self.here?;
        let mean = self.mean;
        let beyond_here = self.beyond_ramp;
        let (mut beyond_after, mut mean_after) = (Vec3::zeros(), Vec3::zeros());
        let mut end = None;
        if let Some(after) = &self.after {
            beyond_after = beyond_ramp(Some(&here), after, second_after.as_ref());
            mean_after = wheel_momentum(after, &beyond_after);
            end = Some(half_way(&here, &mean, after, &mean_after));
        }
        // Beyond the ends as before them.
        let mirror = |known: Vec3<T>| mean + mean - known;
        let (start, end_of_here) = match (self.start, end) {
            (Some(start), Some(end)) => (start, end),
            (Some(start), None) => (start, mirror(start)),
            (None, Some(end)) => (mirror(end), end),
            (None, None) => (mean, mean),
        };
        self.here = self.after;
        self.after = second_after;
        self.mean = mean_after;
        self.start = end;
        self.beyond_ramp = beyond_after;
        // n samples in a row miss 1/n² of what the mean over time makes of the curvature.
        let n = T::count(here.samples.max(1));
        let bend = start + end_of_here - mean - mean;
        let over_time = mean + bend * (T::lit(1.0 / 12.0) / (n * n));
        // The parabola that has this mean and these ends.
        let middle = over_time * T::lit(1.5) - (start + end_of_here) * T::lit(0.25);
        let block = Block {
            drive_n_m_s: here.drive_n_m_s * per,
            impulse_n_m_s: here.impulse_n_m_s * per,
            ..here
        };
        Some(Span {
            block,
            wheels_at_start: start * per,
            wheels_in_the_middle: middle * per,
            wheels_at_end: end_of_here * per,
            beyond_ramp: beyond_here * per,
        })
    }
}

/// Half-way between the means of two blocks.
fn half_way<T: Real>(a: &Block<T>, mean_a: &Vec3<T>, b: &Block<T>, mean_b: &Vec3<T>) -> Vec3<T> {
    let share = a.duration_s / (a.duration_s + b.duration_s);
    mean_a + (mean_b - mean_a) * share
}

/// Mean wheel momentum of a block over its samples: the drive and the external torque's share,
/// `beyond_ramp` over time.
fn wheel_momentum<T: Real>(block: &Block<T>, beyond_ramp: &Vec3<T>) -> Vec3<T> {
    let n = T::count(block.samples.max(1));
    block.drive_n_m_s + beyond_ramp * (T::one() + T::lit(0.5) / (n * n))
}

/// What the external torque's impulse is beyond a ramp, mean over time: `−τ̇ Δ² / 12` for a torque
/// that changes steadily, with τ̇ from the block before to the one after.
fn beyond_ramp<T: Real>(
    before: Option<&Block<T>>,
    here: &Block<T>,
    after: Option<&Block<T>>,
) -> Vec3<T> {
    let torque = |b: &Block<T>| b.impulse_n_m_s * (T::one() / b.duration_s);
    let inner = if before.is_some() && after.is_some() { here.duration_s } else { T::zero() };
    let (before, after) = (before.unwrap_or(here), after.unwrap_or(here));
    let apart = (before.duration_s + after.duration_s) * T::lit(0.5) + inner;
    let change = torque(before) - torque(after);
    change * (here.duration_s * here.duration_s * T::lit(1.0 / 12.0) / apart)
}
