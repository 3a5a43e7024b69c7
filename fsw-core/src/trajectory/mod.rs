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

#[cfg(test)]
mod tests {
    use super::unknowns::Belief;
    use super::*;
    use crate::blocks::block::Block;
    use std::vec::Vec;

    /// All groups, with three wheels about the body axes.
    const UNKNOWNS: usize = 51;
    const PLACES: [Group; 14] = [
        Group::Torque,
        Group::Bias,
        Group::Drag,
        Group::GyroScale,
        Group::GyroUpper,
        Group::GyroLower,
        Group::Wheel(0),
        Group::Wheel(1),
        Group::Wheel(2),
        Group::Common,
        Group::Field(0),
        Group::Field(1),
        Group::Field(2),
        Group::Axes,
    ];

    fn all() -> Groups<f64> {
        let mut groups = Groups { hardware: 3, ..Groups::none() };
        for (place, group) in groups.place.iter_mut().zip(PLACES) {
            *place = Some((group, Belief::Zero));
        }
        groups
    }

    fn point() -> Point<f64, UNKNOWNS> {
        let mut point = Point::sphere(Vec3::new(0.1, -0.07, 0.08));
        point.set_place(0, &Vec3::new(0.0007, -0.0003, 0.001));
        point.set_place(1, &Vec3::new(0.01, 0.02, -0.01));
        point.set_place(2, &Vec3::new(0.007, -0.003, 0.01));
        for place in 3..9 {
            let size = 0.003 * place as f64;
            point.set_place(place, &Vec3::new(size, -0.7 * size, 0.4 * size));
        }
        point.set_place(9, &Vec3::new(0.05, 0.02, -0.01));
        point.set_shape(&[0.04, -0.03, 0.03, -0.05, 0.02]);
        point.set_scale(0.9);
        point
    }

    /// Wheels that swing, and a constant torque, over blocks of this length.
    fn spans(duration_s: f64, count: usize) -> Vec<Span<f64, 3>> {
        let wheels = |t: f64| Vec3::new(0.03 * (0.5 * t).sin(), 0.02, 0.03 * (0.4 * t).cos());
        let mean = |t: f64| {
            let i =
                |w: f64, f: fn(f64) -> f64| (f(w * (t + duration_s)) - f(w * t)) / (w * duration_s);
            Vec3::new(-0.03 * i(0.5, f64::cos), 0.02, 0.03 * i(0.4, f64::sin))
        };
        (0..count)
            .map(|k| {
                let t = k as f64 * duration_s;
                let block = Block {
                    duration_s,
                    wheels_n_m_s: mean(t),
                    wheels_end_n_m_s: wheels(t + duration_s),
                    impulse_n_m_s: Vec3::new(0.007, -0.003, 0.003) * duration_s,
                    ..Block::empty()
                };
                // So many that their mean is that over time.
                Span { block, wheels_at_start: wheels(t), samples: 1e6, before: None, after: None }
            })
            .collect()
    }

    /// Prediction for a block: mean reading, and the derivatives by columns.
    struct Prediction {
        rate_rad_s: Vec3<f64>,
        sensitivity: [Vec3<f64>; UNKNOWNS],
    }

    fn fly(
        point: &Point<f64, UNKNOWNS>,
        spans: &[Span<f64, 3>],
    ) -> (Trajectory<f64, 3, UNKNOWNS, 0>, Vec<Prediction>) {
        let mut trajectory = Trajectory::blank();
        assert!(trajectory.start(point, &all(), &Mat::identity()));
        let mut cross = |span: &Span<f64, 3>| {
            // At one attitude for all points: C has no derivatives.
            let half_turn = Vec3::new(0.1, -0.06, 0.08) * (span.block.duration_s * 0.5);
            trajectory.turn_axes(&half_turn);
            trajectory.set_torque(point);
            let crossing = trajectory.cross(span);
            trajectory.turn_axes(&half_turn);
            let rows: [[f64; UNKNOWNS]; 3] =
                core::array::from_fn(|axis| trajectory.mean_sensitivity(&crossing, axis));
            Prediction {
                rate_rad_s: trajectory.mean_rate_rad_s(&crossing),
                sensitivity: core::array::from_fn(|c| Vec3::from_fn(|r, _| rows[r][c])),
            }
        };
        let predictions = spans.iter().map(&mut cross).collect();
        (trajectory, predictions)
    }

    /// Remainder of the parabola of wheels that swing by a quarter of a radian in a block, 1e-3 of
    /// their 0.03 in the fourth power, over forty blocks.
    const PARABOLA: f64 = 5e-6;
    /// Error of the sensitivities at the end after forty blocks of steps of 0.42 rad.
    const END: f64 = 1e-5;
    /// The same of those to torque, drag and scale, whose forcing is taken at its mean.
    const END_OF_FORCING: f64 = 2e-3;
    /// Size of n⁻¹, and so of the sensitivities.
    const INVERSE: f64 = 3.0;
    /// Share of the largest derivative of a column by which one errs where the drive swings by 2 rad in a block.
    const SWING: f64 = 0.05;
    /// Error of their means by the trapezoid: a twelfth of the turn's square, 1.5e-2, of which a third
    /// enters.
    const MEAN: f64 = 6e-3;

    /// Two lengths of block, which turn by 0.2 and 0.02 rad.
    #[test]
    fn long_blocks_agree_with_short_ones() {
        let (long, means) = fly(&point(), &spans(0.5, 40));
        let (short, fine) = fly(&point(), &spans(0.05, 400));
        assert!((long.momentum - short.momentum).norm() < PARABOLA);
        for (k, mean) in means.iter().enumerate() {
            let ten = &fine[10 * k..10 * k + 10];
            let of_ten = ten.iter().map(|p| p.rate_rad_s).sum::<Vec3<f64>>() / 10.0;
            assert!((mean.rate_rad_s - of_ten).norm() < PARABOLA);
        }
    }

    fn moved(point: &Point<f64, UNKNOWNS>, column: usize, by: f64) -> Point<f64, UNKNOWNS> {
        let mut step = [0.0; UNKNOWNS];
        step[column] = by;
        let mut next = point.stepped(&step);
        next.set_momentum(&(next.momentum() + Vec3::new(step[0], step[1], step[2])));
        next
    }

    #[test]
    fn sensitivities_agree_with_finite_differences() {
        const STEP: f64 = 1e-5;
        let spans = spans(0.5, 40);
        let (end, predictions) = fly(&point(), &spans);
        for c in 0..UNKNOWNS {
            let (up, rates_up) = fly(&moved(&point(), c, STEP), &spans);
            let (down, rates_down) = fly(&moved(&point(), c, -STEP), &spans);
            let of_momentum = (up.momentum - down.momentum) / (2.0 * STEP);
            let size = of_momentum.norm().max(1.0);
            if (42..45).contains(&c) {
                continue; // the axes, no unknowns
            }
            let is_forcing = (3..6).contains(&c) || (9..12).contains(&c) || c > 20;
            let most = if is_forcing { END_OF_FORCING } else { END };
            let error = (end.sensitivity[c] - of_momentum).norm();
            assert!(error < most * size, "{c}: {error} of {size}");
            for (k, prediction) in predictions.iter().enumerate() {
                let of_rate = (rates_up[k].rate_rad_s - rates_down[k].rate_rad_s) / (2.0 * STEP);
                let size = of_rate.norm().max(INVERSE);
                let error = (prediction.sensitivity[c] - of_rate).norm();
                assert!(error < MEAN * size, "{c}, block {k}: {error} of {size}");
            }
        }
    }

    /// A step of torque, shape and scale with the momentum at the start that compensates it: the momentum of the body now is
    /// that of before, and over the trace in proportion to the scale.
    #[test]
    fn a_step_with_its_start_leaves_the_momentum_as_it_is() {
        const STEP: f64 = 1e-5;
        let spans = spans(0.5, 40);
        let (end, _) = fly(&point(), &spans);
        let back_to_start = end.back_to_start().unwrap();
        for c in (3..6).chain(45..UNKNOWNS) {
            let start = back_to_start.of(&end.push_of(c)) * STEP;
            let mut next = moved(&point(), c, STEP);
            next.set_momentum(&(next.momentum() - start));
            let (stepped, _) = fly(&next, &spans);
            let expected = end.momentum * (next.scale() / point().scale());
            let error = (stepped.momentum - expected).norm() / STEP;
            assert!(error < END_OF_FORCING * end.push_of(c).norm().max(1.0), "{c}: {error}");
        }
    }

    /// Wheels that swing by 2 rad in a block, of a body that turns little: the mean of the ends of a block is half of the
    /// mean over it.
    #[test]
    fn sensitivities_follow_a_swing_within_a_block() {
        const STEP: f64 = 1e-5;
        let duration_s = 4.0;
        let spans = spans(duration_s, 12);
        let mut slow = point();
        slow.set_momentum(&Vec3::new(-0.0002, 0.0207, 0.0271));
        slow.set_place(0, &Vec3::zeros());
        slow.set_place(1, &Vec3::zeros());
        let (_, predictions) = fly(&slow, &spans);
        for c in (3..6).chain(12..42).chain(45..UNKNOWNS) {
            let (_, up) = fly(&moved(&slow, c, STEP), &spans);
            let (_, down) = fly(&moved(&slow, c, -STEP), &spans);
            let numeric = |k: usize| (up[k].rate_rad_s - down[k].rate_rad_s) / (2.0 * STEP);
            let size = (0..spans.len()).map(|k| numeric(k).norm()).fold(0.0, f64::max);
            for (k, prediction) in predictions.iter().enumerate() {
                let error = (prediction.sensitivity[c] - numeric(k)).norm();
                assert!(error < SWING * size, "{c}, block {k}: {error:e} of {size:e}");
            }
        }
    }

    #[test]
    fn without_torque_momentum_keeps_its_size() {
        let mut spans = spans(0.5, 200);
        for span in &mut spans {
            span.block.impulse_n_m_s = Vec3::zeros();
        }
        let mut free = point();
        (0..3).for_each(|place| free.set_place(place, &Vec3::zeros()));
        let (end, _) = fly(&free, &spans);
        assert!((end.momentum.norm() - free.momentum().norm()).abs() < 1e-7);
    }

    /// Neither wheels nor torque: the column of the scale is zero in every bit.
    #[test]
    fn a_free_body_has_no_sensitivity_to_its_scale() {
        let mut spans = spans(0.5, 50);
        for span in &mut spans {
            span.block = Block { duration_s: 0.5, ..Block::empty() };
            span.wheels_at_start = Momenta::zeros();
        }
        let (end, predictions) = fly(&point(), &spans);
        assert_eq!(end.sensitivity[UNKNOWNS - 1], Vec3::zeros());
        assert!(predictions.iter().all(|p| p.sensitivity[UNKNOWNS - 1] == Vec3::zeros()));
    }
}
