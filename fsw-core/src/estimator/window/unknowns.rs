//! The unknowns of a window: which they are, their order, a point in their space, and
//! information on them.
//!
//! | U | unknowns, three each, then the six elements |
//! |---|---|
//! | 9 | h₀, momentum at the start of the window |
//! | 12 | h₀; τ, constant disturbance torque in body axes |
//! | 15 | h₀; τ; b, gyro bias |
//! | 18 | h₀; τ; b; d, drag rates: a torque that slows the rate about each axis |
//!
//! The inertia comes last, so that the last six rows of a triangular factor are the information on
//! it alone, whatever the others are. All is in units of a typical inertia: momentum in rad/s,
//! torque in rad/s², drag in 1/s.

use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Vec3, scalar::Real};

/// Where the momentum, the torque and the gyro bias begin.
pub const MOMENTUM: usize = 0;
/// See [`MOMENTUM`].
pub const TORQUE: usize = 3;
/// See [`MOMENTUM`].
pub const BIAS: usize = 6;
/// See [`MOMENTUM`].
pub const DRAG: usize = 9;

/// Whether U unknowns are a number that the table has.
pub const fn is_a_set(unknowns: usize) -> bool {
    matches!(unknowns, 9 | 12 | 15 | 18)
}

/// Whether a torque is among U unknowns.
pub const fn has_torque(unknowns: usize) -> bool {
    unknowns > TORQUE + 6
}

/// Whether a gyro bias is among U unknowns.
pub const fn has_bias(unknowns: usize) -> bool {
    unknowns > BIAS + 6
}

/// Whether drag rates are among U unknowns.
pub const fn has_drag(unknowns: usize) -> bool {
    unknowns > DRAG + 6
}

/// Where the six elements begin.
pub const fn inertia_of(unknowns: usize) -> usize {
    unknowns - 6
}

/// Values of the unknowns, in units of a typical inertia. What isn't among them is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T: Real> {
    /// h₀, rad/s.
    pub momentum: Vec3<T>,
    /// τ, rad/s².
    pub torque: Vec3<T>,
    /// b, rad/s.
    pub bias: Vec3<T>,
    /// d, 1/s: the torque `−d ω` of each axis, of a typical inertia.
    pub drag: Vec3<T>,
    /// Six elements.
    pub inertia: [T; 6],
}

crate::persist!([T: Real] Point<T> { momentum, torque, bias, drag, inertia });

impl<T: Real> Point<T> {
    /// Momentum and inertia, without torque, bias and drag.
    pub fn new(momentum: Vec3<T>, inertia: [T; 6]) -> Self {
        let none = Vec3::zeros();
        Self { momentum, torque: none, bias: none, drag: none, inertia }
    }

    /// A step further.
    pub fn plus<const U: usize>(&self, step: &[T; U]) -> Self {
        let three = |at: usize| Vec3::new(step[at], step[at + 1], step[at + 2]);
        let mut next = Self {
            momentum: self.momentum + three(MOMENTUM),
            inertia: core::array::from_fn(|i| self.inertia[i] + step[inertia_of(U) + i]),
            ..*self
        };
        if has_torque(U) {
            next.torque += three(TORQUE);
        }
        if has_bias(U) {
            next.bias += three(BIAS);
        }
        if has_drag(U) {
            next.drag += three(DRAG);
        }
        next
    }

    /// The step from another point to this one.
    pub fn minus<const U: usize>(&self, other: &Self) -> [T; U] {
        let mut step = [T::zero(); U];
        for i in 0..3 {
            step[MOMENTUM + i] = self.momentum[i] - other.momentum[i];
            if has_torque(U) {
                step[TORQUE + i] = self.torque[i] - other.torque[i];
            }
            if has_bias(U) {
                step[BIAS + i] = self.bias[i] - other.bias[i];
            }
            if has_drag(U) {
                step[DRAG + i] = self.drag[i] - other.drag[i];
            }
        }
        for i in 0..6 {
            step[inertia_of(U) + i] = self.inertia[i] - other.inertia[i];
        }
        step
    }
}

/// What is known before any block: information on a step from a point, for unit variance of a gyro
/// sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known<T: Real, const U: usize> {
    /// θ₀.
    pub point: Point<T>,
    /// `R (θ − θ₀) = d`.
    pub information: SquareRootInformation<T, U>,
}

crate::persist!([T: Real, const U: usize] Known<T, U> { point, information });
