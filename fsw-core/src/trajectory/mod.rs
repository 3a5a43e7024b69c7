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

pub mod modes;
pub mod unknowns;

use modes::{Deflection, Oscillator, of_body};
use unknowns::{
    FIRST_GROUP, GROUPS, Group, Groups, MOMENTUM, Point, by_shape, groups_of, scale_of, shape_of,
};

use crate::blocks::span::Span;
use crate::dynamics::wheels::Momenta;
use crate::hardware::{axes_with_errors, tilt_directions};
use crate::math::{Entries, Mat, Vec3, column, rotated, scalar::Real, skew};

/// Largest turn of a step, rad: the Taylor series then errs by `turn⁸ / 40320` of the momentum, 4e-8,
/// and by 2e-9 at 0.3 rad.
const STEP_TURN: f64 = 0.45;
/// Turn below which three orders less suffice and means alone of the sensitivities' equation, rad: what
/// that leaves is `turn⁵ / 120` of the momentum, 2e-10, and `turn² / 12` of a step's forcing, 1e-4.
const SLOW_TURN: f64 = 0.03;
/// Orders of the Taylor series, and those of a step that turns little.
pub(super) const ORDERS: usize = 7;
const LOW_ORDERS: usize = 4;
/// Steps across a block at most. A block that turns farther than three of them is crossed less
/// accurately.
const MOST_STEPS: u32 = 3;

/// Model of the motion at one point of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T: Real, const W: usize, const M: usize> {
    /// n⁻¹, and (1 + M) n⁻¹; n without the modal inertias where there are modes.
    pub(super) inverse: Mat<T, 3, 3>,
    pub(super) reading: Mat<T, 3, 3>,
    pub(super) modes: [Oscillator<T>; M],
    /// Wheel axes by columns: as configured, and at the point.
    configured_axes: Mat<T, 3, W>,
    pub(super) axes: Mat<T, 3, W>,
    /// δ, s, and 1 + t.
    delay_s: T,
    pub(super) torque_share: T,
    torque: Vec3<T>,
    bias: Vec3<T>,
    pub(super) drag: Vec3<T>,
    pub(super) scale: T,
    /// Further group of unknowns in each place, and a bit for each component that is an unknown.
    pub(super) group: [Option<Group>; GROUPS],
    active: [u8; GROUPS],
}

crate::persist!([T: Real, const W: usize, const M: usize] Model<T, W, M> {
    inverse, reading, modes, configured_axes, axes, delay_s, torque_share, torque, bias, drag, scale, group, active
});

impl<T: Real, const W: usize, const M: usize> Model<T, W, M> {
    /// Model at a point for wheels with these axes; `None` where its tensor has no inverse, or the body without its modes
    /// none.
    pub fn new<const U: usize>(
        point: &Point<T, U>,
        groups: &Groups<T>,
        axes: &Mat<T, 3, W>,
    ) -> Option<Self> {
        let modes = core::array::from_fn(|i| Oscillator::new(point, groups, i as u8));
        let inverse = of_body(&point.over_trace(), &modes).inverse()?;
        let mut model = Self {
            inverse,
            reading: inverse,
            modes,
            configured_axes: *axes,
            axes: *axes,
            delay_s: groups.delay_s,
            torque_share: T::one(),
            torque: point.group(groups, Group::Torque),
            bias: point.group(groups, Group::Bias),
            drag: point.group(groups, Group::Drag),
            scale: point.scale(),
            group: groups.place.map(|at| at.map(|(group, _)| group)),
            active: core::array::from_fn(|place| groups.active_bits(place)),
        };
        if U > WITHOUT_HARDWARE && groups.has_hardware() {
            model.add_hardware(point, groups);
        }
        Some(model)
    }

    /// Errors of gyro, wheels and torque at a point.
    #[inline(never)]
    fn add_hardware<const U: usize>(&mut self, point: &Point<T, U>, groups: &Groups<T>) {
        let [scale, upper, lower] = [Group::GyroScale, Group::GyroUpper, Group::GyroLower]
            .map(|group| point.group(groups, group));
        let one = T::one();
        let gyro = Mat::<T, 3, 3>::new(
            one + scale.x,
            upper.x,
            upper.y,
            lower.x,
            one + scale.y,
            upper.z,
            lower.y,
            lower.z,
            one + scale.z,
        );
        self.reading = gyro * self.inverse;
        let common = point.group(groups, Group::Common);
        self.delay_s += common[0];
        self.torque_share = one + common[1];
        self.axes = axes_at(point, groups, &self.configured_axes);
    }

    /// Model without content.
    pub fn blank() -> Self {
        let none = Vec3::zeros();
        Self {
            inverse: Mat::zeros(),
            reading: Mat::zeros(),
            modes: [Oscillator::none(); M],
            configured_axes: Mat::zeros(),
            axes: Mat::zeros(),
            delay_s: T::zero(),
            torque_share: T::one(),
            torque: none,
            bias: none,
            drag: none,
            scale: T::one(),
            group: [None; GROUPS],
            active: [0; GROUPS],
        }
    }

    /// Rate of a body with this momentum and momentum of its wheels, modes at rest relative to it, `n⁻¹ (m − x wᵤ)`, rad/s.
    pub fn rate_rad_s(&self, momentum: &Vec3<T>, wheels: &Momenta<T, W>) -> Vec3<T> {
        self.at_rest(&self.inverse) * (momentum - self.axes * wheels * self.scale)
    }

    fn rate_of(&self, momentum: &Vec3<T>, drive: &Vec3<T>) -> Vec3<T> {
        self.inverse * (momentum - drive * self.scale)
    }

    /// Reading at such a body, bias included, rad/s.
    pub fn reading_rad_s(&self, momentum: &Vec3<T>, wheels: &Momenta<T, W>) -> Vec3<T> {
        let reading = self.at_rest(&self.reading);
        reading * (momentum - self.axes * wheels * self.scale) + self.bias
    }

    fn reading_of(&self, momentum: &Vec3<T>, drive: &Vec3<T>) -> Vec3<T> {
        self.reading * (momentum - drive * self.scale) + self.bias
    }

    /// Wheel axes as configured.
    pub fn configured_axes(&self) -> &Mat<T, 3, W> {
        &self.configured_axes
    }

    /// True where a component of the group in a place is an unknown.
    pub(super) fn is_active(&self, place: usize, component: usize) -> bool {
        self.active.get(place).is_some_and(|bits| bits >> component & 1 == 1)
    }

    /// Place of a group among the unknowns.
    pub fn offset_of(&self, group: Group) -> Option<usize> {
        let place = self.group.iter().position(|at| *at == Some(group))?;
        Some(FIRST_GROUP + 3 * place)
    }
}

/// Axes of the wheels at a point, by columns.
pub fn axes_at<T: Real, const W: usize, const U: usize>(
    point: &Point<T, U>,
    groups: &Groups<T>,
    configured: &Mat<T, 3, W>,
) -> Mat<T, 3, W> {
    if U <= WITHOUT_HARDWARE || !groups.has_hardware() {
        return *configured;
    }
    let common = point.group(groups, Group::Common)[2];
    axes_with_errors(configured, common, |i| point.group(groups, Group::Wheel(i as u8)))
}

/// A block that is being crossed.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<T: Real, const W: usize, const U: usize> {
    pub(super) steps: u32,
    pub(super) done: u32,
    /// True where a step turns little.
    is_slow: bool,
    /// Length of a step, s, and its share of the block.
    pub(super) step_s: T,
    pub(super) share: T,
    samples: T,
    /// Mean drive `w̄ − ḡ` of the block, per unit of x.
    drive: Vec3<T>,
    /// Known torque per unit of x, and all torque but drag.
    pub(super) known_torque: Vec3<T>,
    pub(super) torque: Vec3<T>,
    /// Momentum of each wheel a share s of the way through: `of_wheel[0] + s (of_wheel[1] + s of_wheel[2])`, and wᵤ
    /// likewise.
    pub(super) of_wheel: [Momenta<T, W>; 3],
    wheels: [Vec3<T>; 3],
    /// Length of the block, s.
    pub(super) duration_s: T,
    /// `6 ḡᵤ`: gᵤ is `6 ḡᵤ s (1 − s)`.
    pub(super) beyond_ramp: Vec3<T>,
    /// Of the last step: means of m + g and of ω, and their changes; mean and change of the drive; gᵤ.
    mean: Vec3<T>,
    change: Vec3<T>,
    mean_rate: Vec3<T>,
    rate_change: Vec3<T>,
    mean_drive: Vec3<T>,
    drive_change: Vec3<T>,
    mean_beyond: Vec3<T>,
    beyond_change: Vec3<T>,
    /// Sum over the steps of the mean of both ends of g.
    beyond_ends: Vec3<T>,
    /// `Δ ṁ` over a step, at the start of the block less that at the end of the last step.
    pub(super) bend: Vec3<T>,
    /// Sums over the steps: mean of m; means of both ends of ω, of the drive, of each wheel, and sum of both of D.
    pub(super) momentum: Vec3<T>,
    pub(super) rate: Vec3<T>,
    drive_ends: Vec3<T>,
    wheel_ends: Momenta<T, W>,
    pub(super) sensitivity: [Vec3<T>; U],
}

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

    /// Starts at a point, for wheels with these axes and momenta, modes at rest relative to the body; false where its
    /// tensor has no inverse.
    pub fn start(
        &mut self,
        point: &Point<T, U>,
        groups: &Groups<T>,
        axes: &Mat<T, 3, W>,
        wheels: &Momenta<T, W>,
    ) -> bool {
        let Some(model) = Model::new(point, groups, axes) else { return false };
        self.model = model;
        self.momentum = point.momentum();
        self.lost = Vec3::zeros();
        self.last_torque = None;
        self.sensitivity = [Vec3::zeros(); U];
        for i in 0..3 {
            *self.sensitivity[MOMENTUM + i].at_mut(i, 0) = T::one();
        }
        if M > 0 {
            self.start_modes(wheels);
        }
        true
    }

    /// Crosses a block.
    #[inline(never)]
    pub fn cross(&mut self, span: &Span<T, W>) -> Crossing<T, W, U> {
        let mut crossing = self.enter(span);
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
        // Motion is as fast as the body turns, or as wheels of much momentum make it nutate.
        let nutation = model.inverse * self.momentum;
        let rate = model.rate_of(&self.momentum, &wheels[0]);
        let turn_square = rate.dot(&rate).max(nutation.dot(&nutation)) * (dt * dt);
        let steps = self.steps_of(turn_square, dt);
        let share = T::one() / T::count(steps);
        let mean_beyond = drive.beyond * model.torque_share;
        let known_torque = drive.impulse * (model.torque_share / dt);
        let of_samples = T::one() / span.of_samples();
        let none = Vec3::zeros();
        Crossing {
            steps,
            done: 0,
            is_slow: turn_square < T::lit(SLOW_TURN * SLOW_TURN),
            step_s: dt * share,
            share,
            samples: span.samples,
            drive: model.axes * drive.wheel_mean - mean_beyond * of_samples,
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
            beyond_ends: none,
            bend: none,
            momentum: none,
            rate: none,
            drive_ends: none,
            wheel_ends: Momenta::zeros(),
            sensitivity: [none; U],
        }
    }

    /// Carries m across a step. With the time as a share of the step, p = m + g, w and the turn u = Δ ω
    /// are polynomials whose coefficients follow from one another,
    ///
    /// `uₖ = Δ n⁻¹ (pₖ − wₖ)`,  `(k + 1) mₖ₊₁ = Δ τ (k = 0) − c uₖ − Σᵢ uᵢ × pₖ₋ᵢ`,
    ///
    /// where nothing but m goes beyond the parabola. The sums of the low and of the high orders are kept apart.
    /// [`differentiate`](Self::differentiate) follows.
    #[inline(never)]
    fn move_on(&mut self, crossing: &mut Crossing<T, W, U>) {
        let part = |k: usize| T::one() / T::count(k as u32);
        let (half, third) = (part(2), part(3));
        let inverse = &self.model.inverse;
        let [w0, w1, w2, g0, g1, g2] = crossing.within_step(self.model.scale);
        let (turn, torque) = (inverse * crossing.step_s, crossing.torque * crossing.step_s);
        let (w, g) = ([w0, w1, w2], [g1, g2]);
        let none = Vec3::zeros();
        let (mut p, mut u) = ([none; ORDERS], [none; ORDERS]);
        let mut coefficient = self.momentum + g0;
        let mut first_slope = none;
        let [mut low, mut high] = [Sums { change: none, mean: none, slope: none }; 2];
        low.mean = self.momentum;
        let orders = if crossing.is_slow { LOW_ORDERS } else { ORDERS };
        for k in 0..orders {
            let rate = w.get(k).map_or(coefficient, |w| coefficient - w);
            let (Some(of_p), Some(of_u)) = (p.get_mut(k), u.get_mut(k)) else { break };
            (*of_p, *of_u) = (coefficient, rotated(&turn, &rate));
            let of_u = *of_u;
            let mut slope = product(p.iter().take(k + 1), &u);
            if k == 0 {
                slope = torque + slope;
            }
            let slope = self.braked(slope, &of_u);
            if k == 0 {
                first_slope = slope;
            }
            let next = slope * part(k + 1);
            let sums = if k < LOW_ORDERS { &mut low } else { &mut high };
            sums.add(&next, part(k + 2), &slope);
            coefficient = g.get(k).map_or(next, |g| next + g);
        }
        let change = low.change + high.change;
        let mean = low.mean + high.mean;
        crossing.mean = mean + g0 + g1 * half + g2 * third;
        crossing.change = change + g1 + g2;
        crossing.mean_rate = rotated(inverse, &(crossing.mean - w0 - w1 * half - w2 * third));
        crossing.rate_change = rotated(inverse, &(crossing.change - w1 - w2));
        crossing.momentum += mean;
        let rate_at_start = rotated(inverse, &(self.momentum + g0 - w0));
        crossing.rate += rate_at_start + crossing.rate_change * half;
        crossing.bend_between(&first_slope, &(low.slope + high.slope));
        self.move_by(change);
    }

    /// Slope less that of the drag at turn u.
    pub(super) fn braked(&self, slope: Vec3<T>, u: &Vec3<T>) -> Vec3<T> {
        let drag = &self.model.drag;
        if *drag == Vec3::zeros() { slope } else { slope - drag.component_mul(u) }
    }

    /// Adds to m with compensation for rounding (Kahan's sum).
    pub(super) fn move_by(&mut self, change: Vec3<T>) {
        let change = change + self.lost;
        let sum = self.momentum + change;
        self.lost = change - (sum - self.momentum);
        self.momentum = sum;
    }

    /// Carries D across a step. With `K = Δ (p^× − c) n⁻¹` and `A = K − Δ ω^×`, both at their means, and
    /// their changes K', A', ω' and w' over the step,
    ///
    /// `X = A + (A' A − A A') / 12`,  `D₁ = D₀ + φ (X D₀ + F)`,  `φ = 1 + X/2 + X²/6 + X³/24 + X⁴/120`,
    ///
    /// `F = Δ E_d − Δ ω E_c + Δ τᵤ E_x − (K + (A' K − A K') / 12) V − (K' − A K) / 12 V'`,
    ///
    /// `V = G(ω) B E_q + (wᵤ − gᵤ) E_x`, and adds D₀ + D₁ to a sum. A step of 0.3 rad errs by 1e-5. Of
    /// torque and drag, small as they are, the means suffice.
    #[inline(never)]
    fn differentiate(&mut self, crossing: &mut Crossing<T, W, U>) {
        let Propagation { carry, series, by_drive, by_drive_change } = self.propagation(crossing);
        let (w, duration_s) = (crossing.mean_rate, crossing.step_s);
        let sum = &mut crossing.sensitivity;
        let mut put = |column: &mut Vec3<T>, c: usize, pushed: Vec3<T>| {
            carry_column(&carry, &pushed, column, &mut sum[c]);
        };
        for c in 0..3 {
            put(&mut self.sensitivity[MOMENTUM + c], MOMENTUM + c, Vec3::zeros());
        }
        for place in 0..groups_of(U) {
            let Some(group) = self.model.group[place] else { continue };
            let by_rate = match group {
                Group::Torque => Vec3::repeat(duration_s),
                Group::Drag => w * -duration_s,
                _ => continue,
            };
            let columns = series.data.0.iter().zip(by_rate.as_slice());
            for (c, (column, by)) in (FIRST_GROUP + 3 * place..).zip(columns) {
                put(&mut self.sensitivity[c], c, Vec3::from(*column) * *by);
            }
        }
        if U > WITHOUT_HARDWARE {
            self.differentiate_by_hardware(
                crossing,
                &carry,
                &series,
                &by_drive,
                by_drive_change.as_ref(),
            );
        }
        self.differentiate_by_inertia(
            crossing,
            &carry,
            &series,
            &by_drive,
            by_drive_change.as_ref(),
        );
        crossing.done += 1;
    }

    /// Columns of shape and scale across a step.
    #[inline(always)]
    fn differentiate_by_inertia(
        &mut self,
        crossing: &mut Crossing<T, W, U>,
        carry: &Mat<T, 3, 3>,
        series: &Mat<T, 3, 3>,
        by_drive: &Mat<T, 3, 3>,
        by_drive_change: Option<&Mat<T, 3, 3>>,
    ) {
        let (w, duration_s) = (crossing.mean_rate, crossing.step_s);
        let sum = &mut crossing.sensitivity;
        let mut put = |column: &mut Vec3<T>, c: usize, pushed: Vec3<T>| {
            carry_column(carry, &pushed, column, &mut sum[c]);
        };
        let mut pushed = by_shape::<T, _>(&columns_of_the_regressor(by_drive, &w));
        let mut by_scale = by_drive * crossing.mean_drive;
        if let Some(by_change) = by_drive_change {
            let more =
                by_shape::<T, _>(&columns_of_the_regressor(by_change, &crossing.rate_change));
            for k in 0..5 {
                pushed[k] += more[k];
            }
            by_scale += by_change * crossing.drive_change;
        }
        for k in 0..5 {
            let c = shape_of(U) + k;
            put(&mut self.sensitivity[c], c, pushed[k]);
        }
        let torque = crossing.known_torque + crossing.mean_beyond.cross(&w);
        let c = scale_of(U);
        put(&mut self.sensitivity[c], c, by_scale + series * (torque * duration_s));
    }

    /// Matrices of a step of D.
    fn propagation(&self, crossing: &Crossing<T, W, U>) -> Propagation<T> {
        let one = Mat::<T, 3, 3>::identity();
        let by_momentum = self.model.inverse * crossing.step_s;
        let mut k = across(&crossing.mean, &by_momentum);
        for i in 0..3 {
            for c in 0..3 {
                *k.at_mut(i, c) -= self.model.drag.at(i, 0) * by_momentum.at(i, c);
            }
        }
        let a = k - skew(&(crossing.mean_rate * crossing.step_s));
        let (mut x, mut by_drive, mut by_drive_change) = (a, k, None);
        if !crossing.is_slow {
            let twelfth = T::lit(1.0 / 12.0);
            let k_change = across(&(crossing.change * twelfth), &by_momentum);
            let a_change = k_change - skew(&(crossing.rate_change * (crossing.step_s * twelfth)));
            x += times(&a_change, &a) - times(&a, &a_change);
            by_drive += times(&a_change, &k) - times(&a, &k_change);
            by_drive_change = Some(times(&a, &k) * twelfth - k_change);
        }
        let fourth = one * T::lit(1.0 / 24.0) + x * T::lit(1.0 / 120.0);
        let third = one * T::lit(1.0 / 6.0) + times(&x, &fourth);
        let series = one + times(&x, &(one * T::lit(0.5) + times(&x, &third)));
        Propagation {
            carry: one + times(&series, &x),
            series,
            by_drive: times(&series, &-by_drive),
            by_drive_change: by_drive_change.map(|m| times(&series, &m)),
        }
    }

    /// Change of the momentum at the start of the window that has the effect, from now on, of a change of the unknown
    /// torque by one along each axis until now: `S = (∂m/∂m₀)⁻¹ ∂m/∂d`, s, by columns. The place of the torque among
    /// the unknowns comes first; none where the torque is no unknown.
    pub fn start_for_torque(&self) -> Option<(usize, [Vec3<T>; 3])> {
        let first = self.model.offset_of(Group::Torque)?;
        let [a, b, c] = *self.sensitivity.get(MOMENTUM..)?.first_chunk()?;
        let (by_a, by_b, by_c) = (b.cross(&c), c.cross(&a), a.cross(&b));
        let one_over = T::one() / a.dot(&by_a);
        let columns = [0, 1, 2].map(|i| {
            let d = self.sensitivity.get(first + i).copied().unwrap_or(Vec3::zeros());
            Vec3::new(by_a.dot(&d), by_b.dot(&d), by_c.dot(&d)) * one_over
        });
        one_over.is_finite().then_some((first, columns))
    }

    /// Mean reading predicted over the samples of a block that is crossed, bias included, rad/s.
    ///
    /// The mean of N samples in a row lacks 1/24 N² of the change of slope that the mean over time has.
    pub fn mean_rate_rad_s(&self, crossing: &Crossing<T, W, U>) -> Vec3<T> {
        let n = crossing.samples;
        let bend = crossing.bend * (T::count(crossing.steps) * T::lit(1.0 / 24.0) / (n * n));
        let mean = crossing.momentum * crossing.share + bend;
        self.model.reading_of(&mean, &crossing.drive)
    }

    /// S̄ of one axis over a block that is crossed: derivatives of its mean reading.
    ///
    /// `S̄ = n⁻¹ (D̄ − V̄)`, with the means of both ends of each step.
    pub fn mean_sensitivity(&self, crossing: &Crossing<T, W, U>, axis: usize) -> [T; U] {
        let axis = axis.min(2);
        let b = Vec3::from_fn(|k, _| self.model.reading[(axis, k)] * crossing.share);
        let a = b * T::lit(0.5);
        let mut row = [T::zero(); U];
        for c in 0..U {
            row[c] = a.dot(&crossing.sensitivity[c]);
        }
        self.model.add_readings(&mut row, axis, &b, &crossing.rate, &crossing.drive_ends);
        if U > WITHOUT_HARDWARE {
            let slope = (crossing.of_wheel[1] + crossing.of_wheel[2]) * (T::one() / crossing.share);
            let slope = self.model.axes * slope * (T::one() / crossing.duration_s);
            let beyond = &crossing.beyond_ends;
            self.model.add_drives(&mut row, &b, &crossing.wheel_ends, &slope, beyond);
            self.model.add_gyro(&mut row, axis, &(crossing.rate * crossing.share));
        }
        if M > 0 {
            self.add_modes(&mut row, &b);
        }
        row
    }

    /// Derivatives of one axis of the reading at the start, for momentum of the wheels there: `n⁻¹ (D₀ − V₀)`.
    pub fn reading_at_start(&self, rate: &Vec3<T>, wheels: &Momenta<T, W>, axis: usize) -> [T; U] {
        let reading = self.model.at_rest(&self.model.reading);
        let mut row = self.row_at_start(&reading, rate, wheels, axis.min(2));
        if U > WITHOUT_HARDWARE {
            self.model.add_bias(&mut row, axis.min(2));
            self.model.add_gyro(&mut row, axis.min(2), rate);
        }
        row
    }

    /// The same of the rate itself.
    pub fn rate_at_start(&self, rate: &Vec3<T>, wheels: &Momenta<T, W>, axis: usize) -> [T; U] {
        self.row_at_start(&self.model.at_rest(&self.model.inverse), rate, wheels, axis.min(2))
    }

    fn row_at_start(
        &self,
        inverse: &Mat<T, 3, 3>,
        rate: &Vec3<T>,
        wheels: &Momenta<T, W>,
        axis: usize,
    ) -> [T; U] {
        let b = Vec3::from_fn(|k, _| inverse.at(axis.min(2), k));
        let mut row = [T::zero(); U];
        for i in 0..3 {
            row[MOMENTUM + i] = b.at(i, 0);
        }
        self.model.add_body(&mut row, &b, rate, &(self.model.axes * wheels));
        if U > WITHOUT_HARDWARE {
            let none = Vec3::zeros();
            self.model.add_drives(&mut row, &b, wheels, &none, &none);
        }
        row
    }

    /// Columns of gyro, wheels, time offset and torque across a step, as in
    /// [`differentiate`](Self::differentiate): those of the gyro do not move the body.
    ///
    /// Momentum δh that the wheels have beyond the assumed one adds `V = x δh`: `x hᵢ aᵢ` per share of a spin inertia,
    /// `x hᵢ eⱼ` per angle of a tilt, `−x ḣ` per second of the time offset. A share of the known torque pushes like
    /// that torque.
    #[inline(never)]
    fn differentiate_by_hardware(
        &mut self,
        crossing: &mut Crossing<T, W, U>,
        carry: &Mat<T, 3, 3>,
        series: &Mat<T, 3, 3>,
        by_drive: &Mat<T, 3, 3>,
        by_drive_change: Option<&Mat<T, 3, 3>>,
    ) {
        let x = self.model.scale;
        let (mean, change) = crossing.wheels_in_step();
        let pushed_by = |mean: Vec3<T>, change: Vec3<T>| {
            let by_change = by_drive_change.map_or(Vec3::zeros(), |by| by * change);
            (by_drive * mean + by_change) * x
        };
        for place in 0..groups_of(U) {
            let pushed = match self.model.group[place] {
                Some(Group::Wheel(wheel)) => {
                    let (mean, change) = (of_wheel(&mean, wheel), of_wheel(&change, wheel));
                    self.model.directions(wheel).map(|e| pushed_by(e * mean, e * change))
                }
                Some(Group::Common) => {
                    let axes = &self.model.axes;
                    let [slope, bend] = crossing.slope_of_drive(axes, &change);
                    let common = pushed_by(axes * mean, axes * change);
                    let mut by_torque = crossing.by_torque(series, by_drive);
                    if let Some(by_change) = by_drive_change {
                        by_torque -= by_change * crossing.beyond_change;
                    }
                    let per_share = x / self.model.torque_share;
                    [pushed_by(slope, bend), by_torque * per_share, common]
                }
                _ => continue,
            };
            for (i, pushed) in pushed.iter().enumerate() {
                let c = FIRST_GROUP + 3 * place + i;
                if self.model.is_active(place, i) {
                    carry_column(
                        carry,
                        pushed,
                        &mut self.sensitivity[c],
                        &mut crossing.sensitivity[c],
                    );
                }
            }
        }
    }
}

/// Unknowns up to which there is no hardware among them: momentum, inertia, torque, bias and drag.
const WITHOUT_HARDWARE: usize = 9;

/// Momentum of one wheel.
pub(super) fn of_wheel<T: Real, const W: usize>(momenta: &Momenta<T, W>, wheel: u8) -> T {
    momenta.as_slice().get(usize::from(wheel)).copied().unwrap_or(T::zero())
}

/// Matrices that carry D across a step.
struct Propagation<T: Real> {
    carry: Mat<T, 3, 3>,
    series: Mat<T, 3, 3>,
    /// φ times the factor of V and that of V'; none where the step turns little.
    by_drive: Mat<T, 3, 3>,
    by_drive_change: Option<Mat<T, 3, 3>>,
}

impl<T: Real, const W: usize, const M: usize> Model<T, W, M> {
    /// Adds to a row the direct derivatives of the reading: of the rate by shape and scale, of the bias.
    fn add_readings<const U: usize>(
        &self,
        row: &mut [T; U],
        axis: usize,
        b: &Vec3<T>,
        w: &Vec3<T>,
        drive: &Vec3<T>,
    ) {
        self.add_bias(row, axis);
        self.add_body(row, b, w, drive);
    }

    fn add_bias<const U: usize>(&self, row: &mut [T; U], axis: usize) {
        for place in 0..groups_of(U) {
            if self.group[place] == Some(Group::Bias) {
                row[FIRST_GROUP + 3 * place + axis] = T::one();
            }
        }
    }

    /// Adds the derivatives by shape and scale.
    fn add_body<const U: usize>(
        &self,
        row: &mut [T; U],
        b: &Vec3<T>,
        w: &Vec3<T>,
        drive: &Vec3<T>,
    ) {
        let by_shape = by_shape::<T, _>(&[
            b.x * w.x,
            b.y * w.y,
            b.z * w.z,
            b.x * w.y + b.y * w.x,
            b.x * w.z + b.z * w.x,
            b.y * w.z + b.z * w.y,
        ]);
        for k in 0..5 {
            row[shape_of(U) + k] -= by_shape[k];
        }
        row[scale_of(U)] -= b.dot(drive);
    }

    /// The three directions of a wheel's errors: its axis and the two tilts.
    pub(super) fn directions(&self, wheel: u8) -> [Vec3<T>; 3] {
        let axis = column(&self.configured_axes, usize::from(wheel));
        let [first, second] = tilt_directions(&axis);
        [axis, first, second]
    }

    /// Adds the direct derivatives by wheels and time offset, `−b V`, for momentum of the wheels, its slope,
    /// rad/s², and the impulse beyond a ramp.
    #[inline(never)]
    fn add_drives<const U: usize>(
        &self,
        row: &mut [T; U],
        b: &Vec3<T>,
        wheels: &Momenta<T, W>,
        slope: &Vec3<T>,
        beyond: &Vec3<T>,
    ) {
        for place in 0..groups_of(U) {
            let by = match self.group[place] {
                Some(Group::Wheel(wheel)) => {
                    let h = of_wheel(wheels, wheel) * self.scale;
                    self.directions(wheel).map(|e| -b.dot(&e) * h)
                }
                Some(Group::Common) => {
                    let common = -b.dot(&(self.axes * wheels)) * self.scale;
                    let by_torque = b.dot(beyond) * self.scale / self.torque_share;
                    [b.dot(slope) * self.scale, by_torque, common]
                }
                _ => continue,
            };
            for (i, by) in by.into_iter().enumerate() {
                if self.is_active(place, i) {
                    row[FIRST_GROUP + 3 * place + i] += by;
                }
            }
        }
    }

    /// Adds the derivatives by the gyro's errors, for a mean rate ω: `∂zᵢ/∂Mᵢⱼ = ωⱼ`.
    #[inline(never)]
    fn add_gyro<const U: usize>(&self, row: &mut [T; U], axis: usize, rate: &Vec3<T>) {
        for place in 0..groups_of(U) {
            // Components of a group that act on this axis, and the axes that they take the rate from.
            let pairs: [Option<(usize, usize)>; 2] = match (self.group[place], axis) {
                (Some(Group::GyroScale), _) => [Some((axis, axis)), None],
                (Some(Group::GyroUpper), 0) => [Some((0, 1)), Some((1, 2))],
                (Some(Group::GyroUpper), 1) => [Some((2, 2)), None],
                (Some(Group::GyroLower), 1) => [Some((0, 0)), None],
                (Some(Group::GyroLower), 2) => [Some((1, 0)), Some((2, 1))],
                _ => continue,
            };
            for (component, of) in pairs.into_iter().flatten() {
                let of_row = row.get_mut(FIRST_GROUP + 3 * place + component);
                if let (Some(sum), Some(rate), true) =
                    (of_row, rate.as_slice().get(of), self.is_active(place, component))
                {
                    *sum += *rate;
                }
            }
        }
    }
}

impl<T: Real, const W: usize, const U: usize> Crossing<T, W, U> {
    /// Notes the slope of m at the start of the first step, and at the end of the last one.
    #[inline(always)]
    fn bend_between(&mut self, first: &Vec3<T>, last: &Vec3<T>) {
        if self.done == 0 {
            self.bend = *first;
        }
        if self.done + 1 == self.steps {
            self.bend -= last;
        }
    }

    /// `−ḣ` of wheels with these axes, mean over the present step and its change, for a change of their momenta.
    #[inline(always)]
    fn slope_of_drive(&self, axes: &Mat<T, 3, W>, change: &Momenta<T, W>) -> [Vec3<T>; 2] {
        let bend = -(self.share + self.share) / self.duration_s;
        [axes * change * (-T::one() / self.step_s), axes * self.of_wheel[2] * bend]
    }

    /// Push of the known torque across the present step, without the change of the drive. The same sums as of the scale:
    /// without wheels both columns are proportional to rounding.
    #[inline(always)]
    fn by_torque(&self, series: &Mat<T, 3, 3>, by_drive: &Mat<T, 3, 3>) -> Vec3<T> {
        let torque = self.known_torque + self.mean_beyond.cross(&self.mean_rate);
        series * (torque * self.step_s) - by_drive * self.mean_beyond
    }

    /// Coefficients of x w and x g in the step's share of time, `[w₀ w₁ w₂ g₀ g₁ g₂]`; notes mean, change
    /// and ends of the drive.
    pub(super) fn within_step(&mut self, scale: T) -> [Vec3<T>; 6] {
        let (one, share, half) = (T::one(), self.share, T::lit(0.5));
        let third = T::lit(1.0 / 3.0);
        let x = T::count(self.done) * share;
        let [at_start, by_share, by_square] = self.wheels;
        let w0 = at_start + (by_share + by_square * x) * x;
        let w1 = (by_share + by_square * (x + x)) * share;
        let w2 = by_square * (share * share);
        let g0 = self.beyond_ramp * (x * (one - x));
        let g1 = self.beyond_ramp * (share * (one - x - x));
        let g2 = self.beyond_ramp * -(share * share);
        self.mean_beyond = g0 + g1 * half + g2 * third;
        self.mean_drive = w0 + w1 * half + w2 * third - self.mean_beyond;
        self.drive_change = w1 + w2 - g1 - g2;
        self.drive_ends += w0 - g0 + self.drive_change * half;
        if U > WITHOUT_HARDWARE {
            self.beyond_change = g1 + g2;
            self.beyond_ends += g0 + self.beyond_change * half;
            let (mean, _) = self.wheels_in_step();
            let bulge = self.of_wheel[2] * (share * share);
            // The mean of a parabola and that of its ends differ by a sixth of its bend.
            self.wheel_ends += mean + bulge * T::lit(1.0 / 6.0);
        }
        [w0 * scale, w1 * scale, w2 * scale, g0 * scale, g1 * scale, g2 * scale]
    }
}

impl<T: Real, const W: usize, const U: usize> Crossing<T, W, U> {
    /// Mean of each wheel's momentum over the present step, and its change.
    fn wheels_in_step(&self) -> (Momenta<T, W>, Momenta<T, W>) {
        let share = self.share;
        let x = T::count(self.done) * share;
        let [at_start, by_share, by_square] = self.of_wheel;
        let slope = (by_share + by_square * (x + x)) * share;
        let bend = by_square * (share * share);
        let start = at_start + (by_share + by_square * x) * x;
        (start + slope * T::lit(0.5) + bend * T::lit(1.0 / 3.0), slope + bend)
    }
}

/// Sums over the orders of a step.
#[derive(Clone, Copy)]
struct Sums<T: Real> {
    change: Vec3<T>,
    mean: Vec3<T>,
    /// Slope at the end.
    slope: Vec3<T>,
}

impl<T: Real> Sums<T> {
    /// Adds an order: its coefficient, its share of the mean, and its slope at the end.
    #[inline(always)]
    fn add(&mut self, coefficient: &Vec3<T>, of_mean: T, slope: &Vec3<T>) {
        self.change += coefficient;
        self.mean += coefficient * of_mean;
        self.slope += slope;
    }
}

/// Coefficient of the product of two polynomials, `Σᵢ pₖ₋ᵢ × uᵢ`, for p up to pₖ.
#[inline(never)]
pub(super) fn product<'a, T: Real>(
    p: core::iter::Take<core::slice::Iter<'a, Vec3<T>>>,
    u: &[Vec3<T>],
) -> Vec3<T> {
    let mut products = p.rev().zip(u).map(|(p, u)| p.cross(u));
    let first = products.next().unwrap_or(Vec3::zeros());
    products.fold(first, |sum, product| sum + product)
}

/// Carries a column of D, and adds both of its ends to a sum.
#[inline(never)]
fn carry_column<T: Real>(
    carry: &Mat<T, 3, 3>,
    pushed: &Vec3<T>,
    column: &mut Vec3<T>,
    sum: &mut Vec3<T>,
) {
    let after = carry * *column + pushed;
    *sum += *column + after;
    *column = after;
}

/// Product of two matrices, out of line.
#[inline(never)]
fn times<T: Real>(a: &Mat<T, 3, 3>, b: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    a * b
}

/// `v^× M`.
fn across<T: Real>(v: &Vec3<T>, m: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    Mat::from_columns(&core::array::from_fn::<Vec3<T>, 3, _>(|i| {
        v.cross(&Vec3::new(m.at(0, i), m.at(1, i), m.at(2, i)))
    }))
}

/// The columns of `M G(ω)`.
pub(super) fn columns_of_the_regressor<T: Real>(m: &Mat<T, 3, 3>, w: &Vec3<T>) -> [Vec3<T>; 6] {
    let [a, b, c]: [Vec3<T>; 3] = core::array::from_fn(|i| column(m, i));
    [a * w.x, b * w.y, c * w.z, a * w.y + b * w.x, a * w.z + c * w.x, b * w.z + c * w.y]
}

#[cfg(test)]
mod tests {
    use super::unknowns::Belief;
    use super::*;
    use crate::blocks::block::Block;
    use std::vec::Vec;

    /// All groups, with three wheels about the body axes.
    const UNKNOWNS: usize = 39;
    const PLACES: [Group; 10] = [
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
        assert!(trajectory.start(point, &all(), &Mat::identity(), &spans[0].wheels_at_start));
        let mut cross = |span: &Span<f64, 3>| {
            let crossing = trajectory.cross(span);
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
