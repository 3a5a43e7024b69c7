//! Stretch of blocks: the rest before it, and the size of what drives the body within it.

use super::block::Block;
use crate::dynamics::wheels::Momenta;
use crate::math::{Vec3, scalar::Real};

/// Measurement of the rate at the start of a window: the mean over the rest before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest<T: Real, const W: usize> {
    /// Number of samples; zero for none.
    pub weight: T,
    /// Mean rate, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Mean momentum of each wheel, N m s.
    pub wheels_n_m_s: Momenta<T, W>,
}

crate::persist!([T: Real, const W: usize] Rest<T, W> { weight, rate_rad_s, wheels_n_m_s });

impl<T: Real, const W: usize> Rest<T, W> {
    /// No rest.
    pub fn none() -> Self {
        Self { weight: T::zero(), rate_rad_s: Vec3::zeros(), wheels_n_m_s: Momenta::zeros() }
    }

    /// Rest with the block's samples added; the block alone where it does not agree.
    fn with(&self, block: &Block<T, W>, noise_rad_s: T) -> Self {
        let alone = Self {
            weight: block.weight,
            rate_rad_s: block.rate_rad_s,
            wheels_n_m_s: block.wheels_n_m_s,
        };
        let weight = self.weight + block.weight;
        let apart = block.rate_rad_s - self.rate_rad_s;
        let variance = noise_rad_s * noise_rad_s * weight / (self.weight * block.weight);
        // Exceeded once in 10⁴ by chance: chi-square of three degrees of freedom.
        if weight <= T::zero() || apart.dot(&apart) > variance * T::lit(21.1) {
            return alone;
        }
        let share = block.weight / weight;
        Self {
            weight,
            rate_rad_s: self.rate_rad_s + apart * share,
            wheels_n_m_s: self.wheels_n_m_s + (block.wheels_n_m_s - self.wheels_n_m_s) * share,
        }
    }
}

/// Start of a stretch of blocks, and the size of what drives the body within it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch<T: Real, const W: usize> {
    /// Rest before the first block.
    pub rest: Rest<T, W>,
    /// Momentum of each wheel at the start of the first block, N m s.
    pub wheels_n_m_s: Momenta<T, W>,
    /// Largest change of a wheel's momentum since then, N m s.
    pub wheels_span_n_m_s: T,
    /// True if external torque was known to act.
    pub has_torque: bool,
    /// Angle turned, `∫ |ω| dt`, rad, and duration, s.
    pub turn_rad: T,
    pub duration_s: T,
}

crate::persist!([T: Real, const W: usize] Stretch<T, W> { rest, wheels_n_m_s, wheels_span_n_m_s, has_torque, turn_rad, duration_s });

impl<T: Real, const W: usize> Stretch<T, W> {
    /// Stretch that begins with this wheel momentum, N m s.
    pub fn new(wheels_n_m_s: Momenta<T, W>) -> Self {
        let (rest, wheels_span_n_m_s) = (Rest::none(), T::zero());
        let (has_torque, turn_rad, duration_s) = (false, T::zero(), T::zero());
        Self { rest, wheels_n_m_s, wheels_span_n_m_s, has_torque, turn_rad, duration_s }
    }

    /// Adds a block before the first one to the rest.
    pub fn absorb(&mut self, block: &Block<T, W>, noise_rad_s: T) {
        self.rest = self.rest.with(block, noise_rad_s);
        self.wheels_n_m_s = self.rest.wheels_n_m_s;
    }

    /// True where wheels turn or a torque acts: the scale has a column that is not zero.
    pub fn has_drive(&self) -> bool {
        let is_turning = self.wheels_n_m_s.iter().any(|h| *h != T::zero());
        is_turning || self.wheels_span_n_m_s > T::zero() || self.has_torque
    }

    /// Notes the drive of a block.
    pub fn note(&mut self, block: &Block<T, W>) {
        let change = largest(&(block.wheels_n_m_s - self.wheels_n_m_s));
        self.wheels_span_n_m_s = self.wheels_span_n_m_s.max(change);
        self.has_torque |= block.impulse_n_m_s != Vec3::zeros();
        self.turn_rad += block.turn_square().sqrt();
        self.duration_s += block.duration_s;
    }
}

/// Largest absolute value of the wheels.
pub(super) fn largest<T: Real, const W: usize>(of_wheels: &Momenta<T, W>) -> T {
    of_wheels.iter().fold(T::zero(), |most, x| most.max(x.abs()))
}
