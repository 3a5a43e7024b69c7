//! Momentum and its sensitivities from block to block.
//!
//! All is over the trace of the inertia: `m = h / tr(J)`, `n = J / tr(J)`. From a point of the unknowns total
//! momentum follows
//!
//! `ṁ = x τᵤ + d − c ω − ω × m`, `ω = n⁻¹ (m − x wᵤ)`
//!
//! with `wᵤ` wheel momentum and `τᵤ` known torque, both times the unit κᵤ. Its sensitivities `D = ∂m/∂θ`
//! follow
//!
//! `Ḋ = m × S − ω × D − c S + E_d − ω E_c + τᵤ E_x`, `S = ∂ω/∂θ = n⁻¹ (D − G(ω) B E_q − wᵤ E_x)`
//!
//! with E the columns of the unknown named by their index and B the basis of the shape
//! ([`unknowns`]). A gyro bias adds to the reading and does not move the body.
//!
//! A block is crossed in one to three steps. Momentum goes by its Taylor series: the right-hand side is a
//! product, so that the coefficients follow from one another (Cauchy's rule), and its mean over the
//! step comes with them. Sensitivities go by the exponential of their equation's mean, with the
//! commutator that makes it one of fourth order (Magnus, Comm. Pure Appl. Math. 7, 1954; Iserles and
//! Nørsett, Phil. Trans. R. Soc. A 357, 1999).

mod field;
mod model;
pub mod modes;
mod reading;
mod sensitivity;
mod step;
#[cfg(test)]
mod tests;
pub mod unknowns;

pub use model::axes_at;

use model::Model;
use modes::Deflection;
use step::Crossing;
use unknowns::{Group, Groups, MOMENTUM, Point};

use crate::blocks::span::Span;
use crate::dynamics::wheels::Momenta;
use crate::math::{Entries, Mat, Vec3, norm, scalar::Real};

/// Largest turn of a step, rad: the Taylor series then errs by `turn⁸ / 40320` of the momentum, 4e-8,
/// and by 2e-9 at 0.3 rad.
const STEP_TURN: f64 = 0.45;
/// Turn below which three orders less suffice and means alone of the sensitivities' equation, rad: what
/// that leaves is `turn⁵ / 120` of the momentum, 2e-10, and `turn² / 12` of a step's forcing, 1e-4.
const SLOW_TURN: f64 = 0.03;
/// Steps across a block at most. A block that turns farther than three of them is crossed less
/// accurately.
const MOST_STEPS: u32 = 3;
/// Unknowns up to which there is no hardware among them: momentum, inertia, torque, bias and drag.
const WITHOUT_HARDWARE: usize = 9;

/// State of a trajectory at the end of the last block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory<T: Real, const W: usize, const U: usize, const M: usize> {
    /// Model of the motion.
    pub model: Model<T, W, M>,
    /// m, rad/s.
    pub(super) momentum: Vec3<T>,
    /// Rounding error of the sum m, added back with the next step: motion about an unstable axis would
    /// magnify it.
    lost: Vec3<T>,
    /// Known torque of the last block, per unit of x; none before the first one.
    last_torque: Option<Vec3<T>>,
    /// D, by columns.
    pub(super) sensitivity: [Vec3<T>; U],
    /// State of the modes, and its derivatives.
    pub(super) modes: [Deflection<T, U>; M],
}

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] Trajectory<T, W, U, M> {
    model, momentum, lost, last_torque, sensitivity, modes
});

impl<T: Real, const W: usize, const U: usize, const M: usize> Trajectory<T, W, U, M> {
    /// Trajectory without a start.
    pub fn blank() -> Self {
        let none = Vec3::zeros();
        let model = Model::blank();
        Self {
            model,
            momentum: none,
            lost: none,
            last_torque: None,
            sensitivity: [none; U],
            modes: [Deflection::none(); M],
        }
    }

    /// Inverse of the tensor over its unit.
    pub fn inverse(&self) -> &Mat<T, 3, 3> {
        &self.model.inverse
    }

    /// Starts at a point, for wheels with these axes; false where its tensor has no inverse.
    pub fn start(&mut self, point: &Point<T, U>, groups: &Groups<T>, axes: &Mat<T, 3, W>) -> bool {
        let Some(model) = Model::new(point, groups, axes) else { return false };
        self.model = model;
        self.momentum = point.momentum();
        self.lost = Vec3::zeros();
        self.last_torque = None;
        self.sensitivity = [Vec3::zeros(); U];
        for i in 0..3 {
            *self.sensitivity[MOMENTUM + i].at_mut(i, 0) = T::one();
        }
        self.start_axes();
        true
    }

    /// Puts the body to rest, without torque.
    pub fn stop(&mut self) {
        let none = Vec3::zeros();
        (self.momentum, self.lost, self.last_torque) = (none, none, None);
        self.model.torque = none;
        self.sensitivity = [none; U];
        self.modes = [Deflection::none(); M];
    }

    /// Crosses a block. Modes are at rest relative to the body at the first sample of the first block.
    #[inline(never)]
    pub fn cross(&mut self, span: &Span<T, W>) -> Crossing<T, W, U> {
        let mut crossing = self.enter(span);
        if M > 0 && self.last_torque.is_none() {
            self.start_modes(&crossing);
        }
        self.shift_torque(&crossing);
        while crossing.done < crossing.steps {
            if M > 0 {
                self.cross_flexible(&mut crossing);
            } else {
                self.move_on(&mut crossing);
                self.differentiate(&mut crossing);
            }
        }
        crossing
    }

    /// A time offset shifts a change of the known torque: at the boundary of two blocks `∂m/∂δ` takes `−x Δτᵤ`.
    fn shift_torque(&mut self, crossing: &Crossing<T, W, U>) {
        let known = crossing.known_torque;
        let before = self.last_torque.replace(known).unwrap_or(known);
        if U <= WITHOUT_HARDWARE {
            return;
        }
        let Some(offset) = self.model.offset_of(Group::Common) else { return };
        if let Some(of_delay) = self.sensitivity.get_mut(offset) {
            *of_delay -= (known - before) * self.model.scale;
        }
    }

    /// Rate of a body with all of the momentum, rad/s: no nutation is faster than about that.
    pub fn nutation_rad_s(&self) -> T {
        norm(&(self.model.inverse * self.momentum))
    }

    /// Square of the angle of the motion across a block, rad². Motion is as fast as the body turns, or as wheels of
    /// much momentum make it nutate.
    #[inline(always)]
    fn turn_square(&self, wheels: &Vec3<T>, duration_s: T) -> T {
        let nutation = self.model.inverse * self.momentum;
        let rate = self.model.rate_of(&self.momentum, wheels);
        rate.dot(&rate).max(nutation.dot(&nutation)) * (duration_s * duration_s)
    }

    /// Steps across a block in which the body turns by an angle of this square, rad², in `duration_s`.
    #[inline(always)]
    fn steps_of(&self, turn_square: T, duration_s: T) -> u32 {
        let mut steps = 1;
        while steps < MOST_STEPS
            && turn_square > T::lit(STEP_TURN * STEP_TURN) * T::count(steps * steps)
        {
            steps += 1;
        }
        if M > 0 { steps.max(self.model.steps_of_modes(duration_s)) } else { steps }
    }

    /// A block before its first step. Not inlined: the frames of its courses and of a step must not add up.
    #[inline(never)]
    fn enter(&self, span: &Span<T, W>) -> Crossing<T, W, U> {
        let (block, model) = (&span.block, &self.model);
        let dt = block.duration_s;
        let drive = span.drive_within(model.delay_s);
        let wheels = drive.wheels.map(|momenta| model.axes * momenta);
        let turn_square = self.turn_square(&wheels[0], dt);
        let steps = self.steps_of(turn_square, dt);
        let share = T::one() / T::count(steps);
        let mean_beyond = drive.beyond * model.torque_share;
        let known_torque = drive.impulse * (model.torque_share / dt);
        let beyond = mean_beyond * (T::one() / span.of_samples());
        let none = Vec3::zeros();
        Crossing {
            steps,
            done: 0,
            is_slow: turn_square < T::lit(SLOW_TURN * SLOW_TURN),
            step_s: dt * share,
            share,
            samples: span.samples,
            drive: model.axes * drive.wheel_mean - beyond,
            wheel_mean: drive.wheel_mean,
            beyond,
            duration_s: dt,
            known_torque,
            torque: known_torque * model.scale + model.torque,
            of_wheel: drive.wheels,
            wheels,
            beyond_ramp: mean_beyond * T::lit(6.0),
            mean: none,
            change: none,
            mean_rate: none,
            rate_change: none,
            mean_drive: none,
            drive_change: none,
            mean_beyond: none,
            beyond_change: none,
            bend: none,
            momentum: none,
            rate: none,
            sensitivity: [none; U],
        }
    }
}

/// Momentum of one wheel.
pub(super) fn of_wheel<T: Real, const W: usize>(momenta: &Momenta<T, W>, wheel: u8) -> T {
    momenta.as_slice().get(usize::from(wheel)).copied().unwrap_or(T::zero())
}
