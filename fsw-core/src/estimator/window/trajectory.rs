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
//! ([`unknowns`](super::unknowns)). A gyro bias adds to the reading and does not move the body.
//!
//! A block is crossed in one to three steps. Momentum goes by its Taylor series: the right-hand side is a
//! product, so that the coefficients follow from one another (Cauchy's rule), and its mean over the
//! step comes with them. Sensitivities go by the exponential of their equation's mean, with the
//! commutator that makes it one of fourth order (Magnus, Comm. Pure Appl. Math. 7, 1954; Iserles and
//! Nørsett, Phil. Trans. R. Soc. A 357, 1999).

use super::block::Block;
use super::unknowns::{
    FIRST_GROUP, GROUPS, Group, Groups, MOMENTUM, Point, by_shape, groups_of, scale_of, shape_of,
};
use crate::math::{Entries, Mat, Vec3, rotated, scalar::Real, skew};
use crate::tensor::Inertia;

/// Largest turn of a step, rad: the Taylor series then errs by `turn⁸ / 40320` of the momentum, 4e-8,
/// and by 2e-9 at 0.3 rad.
const STEP_TURN: f64 = 0.45;
/// Turn below which three orders less suffice and means alone of the sensitivities' equation, rad: what
/// that leaves is `turn⁵ / 120` of the momentum, 2e-10, and `turn² / 12` of a step's forcing, 1e-4.
const SLOW_TURN: f64 = 0.03;
/// Orders of the Taylor series, and those of a step that turns little.
const ORDERS: usize = 7;
const LOW_ORDERS: usize = 4;
/// Steps across a block at most. A block that turns farther than three of them is crossed less
/// accurately.
const MOST_STEPS: u32 = 3;

/// A block with the wheel momentum at its start. Wheels and torque are times the unit κᵤ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<T: Real> {
    /// Block, scaled.
    pub block: Block<T>,
    /// wᵤ at its start, rad/s.
    pub wheels_at_start: Vec3<T>,
    /// Number of samples between its ends.
    pub samples: T,
}

/// Model of the motion at one point of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T: Real> {
    /// n⁻¹.
    inverse: Mat<T, 3, 3>,
    torque: Vec3<T>,
    bias: Vec3<T>,
    drag: Vec3<T>,
    scale: T,
    /// Further group of unknowns in each place.
    group: [Option<Group>; GROUPS],
}

crate::persist!([T: Real] Model<T> { inverse, torque, bias, drag, scale, group });

impl<T: Real> Model<T> {
    /// Model at a point; `None` where its tensor has no inverse.
    pub fn new(point: &Point<T>, groups: &Groups<T>) -> Option<Self> {
        Some(Self {
            inverse: Inertia::new(point.over_trace()).inverse()?,
            torque: point.value(groups, Group::Torque),
            bias: point.value(groups, Group::Bias),
            drag: point.value(groups, Group::Drag),
            scale: point.scale,
            group: groups.place.map(|at| at.map(|(group, _)| group)),
        })
    }

    /// Model without content.
    pub fn blank() -> Self {
        let none = Vec3::zeros();
        let (scale, group) = (T::one(), [None; GROUPS]);
        Self { inverse: Mat::zeros(), torque: none, bias: none, drag: none, scale, group }
    }

    /// Rate of a body with this momentum and wheel momentum, `n⁻¹ (m − x wᵤ)`, rad/s.
    pub fn rate_rad_s(&self, momentum: &Vec3<T>, wheels: &Vec3<T>) -> Vec3<T> {
        self.inverse * (momentum - wheels * self.scale)
    }

    /// Place of a group among the unknowns.
    pub fn offset_of(&self, group: Group) -> Option<usize> {
        let place = self.group.iter().position(|at| *at == Some(group))?;
        Some(FIRST_GROUP + 3 * place)
    }

    /// Gyro bias at the point, rad/s.
    pub fn bias_rad_s(&self) -> Vec3<T> {
        self.bias
    }
}

/// A block that is being crossed.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<T: Real, const U: usize> {
    steps: u32,
    done: u32,
    /// True where a step turns little.
    is_slow: bool,
    /// Length of a step, s, and its share of the block.
    step_s: T,
    share: T,
    samples: T,
    /// Mean drive `w̄ − ḡ` of the block, per unit of x.
    drive: Vec3<T>,
    /// Known torque per unit of x, and all torque but drag.
    known_torque: Vec3<T>,
    torque: Vec3<T>,
    /// wᵤ a share s of the way through: `wheels[0] + s (wheels[1] + s wheels[2])`.
    wheels: [Vec3<T>; 3],
    /// `6 ḡᵤ`: gᵤ is `6 ḡᵤ s (1 − s)`.
    beyond_ramp: Vec3<T>,
    /// Of the last step: means of m + g and of ω, and their changes; mean and change of the drive; gᵤ.
    mean: Vec3<T>,
    change: Vec3<T>,
    mean_rate: Vec3<T>,
    rate_change: Vec3<T>,
    mean_drive: Vec3<T>,
    drive_change: Vec3<T>,
    mean_beyond: Vec3<T>,
    /// `Δ ṁ` over a step, at the start of the block less that at the end of the last step.
    bend: Vec3<T>,
    /// Sums over the steps: mean of m; means of both ends of ω, of the drive, and sum of both of D.
    momentum: Vec3<T>,
    rate: Vec3<T>,
    drive_ends: Vec3<T>,
    sensitivity: [Vec3<T>; U],
}

/// State of a trajectory at the end of the last block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory<T: Real, const U: usize> {
    /// Model of the motion.
    pub model: Model<T>,
    /// m, rad/s.
    momentum: Vec3<T>,
    /// Rounding error of the sum m, added back with the next step: motion about an unstable axis would
    /// magnify it.
    lost: Vec3<T>,
    /// D, by columns.
    sensitivity: [Vec3<T>; U],
}

crate::persist!([T: Real, const U: usize] Trajectory<T, U> { model, momentum, lost, sensitivity });

impl<T: Real, const U: usize> Trajectory<T, U> {
    /// Trajectory without a start.
    pub fn blank() -> Self {
        let none = Vec3::zeros();
        Self { model: Model::blank(), momentum: none, lost: none, sensitivity: [none; U] }
    }

    /// Starts at a point; false where its tensor has no inverse.
    pub fn start(&mut self, point: &Point<T>, groups: &Groups<T>) -> bool {
        let Some(model) = Model::new(point, groups) else { return false };
        self.model = model;
        self.momentum = point.momentum;
        self.lost = Vec3::zeros();
        self.sensitivity = [Vec3::zeros(); U];
        for i in 0..3 {
            *self.sensitivity[MOMENTUM + i].at_mut(i, 0) = T::one();
        }
        true
    }

    /// Crosses a block.
    #[inline(never)]
    pub fn cross(&mut self, span: &Span<T>) -> Crossing<T, U> {
        let mut crossing = self.enter(span);
        while crossing.done < crossing.steps {
            self.move_on(&mut crossing);
            self.differentiate(&mut crossing);
        }
        crossing
    }

    fn enter(&self, span: &Span<T>) -> Crossing<T, U> {
        let (block, model) = (&span.block, &self.model);
        let dt = block.duration_s;
        // Motion is as fast as the body turns, or as wheels of much momentum make it nutate.
        let nutation = model.inverse * self.momentum;
        let rate = model.rate_rad_s(&self.momentum, &span.wheels_at_start);
        let turn_square = rate.dot(&rate).max(nutation.dot(&nutation)) * (dt * dt);
        let mut steps = 1;
        while steps < MOST_STEPS
            && turn_square > T::lit(STEP_TURN * STEP_TURN) * T::count(steps * steps)
        {
            steps += 1;
        }
        let share = T::one() / T::count(steps);
        // The impulse already has all of what the turning of g makes of it.
        let mean_beyond = block.beyond_ramp_n_m_s * span.of_samples();
        let turned = block.rate_rad_s.cross(&mean_beyond);
        let known_torque = block.impulse_n_m_s * (T::one() / dt) + turned;
        let none = Vec3::zeros();
        Crossing {
            steps,
            done: 0,
            is_slow: turn_square < T::lit(SLOW_TURN * SLOW_TURN),
            step_s: dt * share,
            share,
            samples: span.samples,
            drive: block.drive_n_m_s(),
            known_torque,
            torque: known_torque * model.scale + model.torque,
            wheels: span.wheels_within(),
            beyond_ramp: mean_beyond * T::lit(6.0),
            mean: none,
            change: none,
            mean_rate: none,
            rate_change: none,
            mean_drive: none,
            drive_change: none,
            mean_beyond: none,
            bend: none,
            momentum: none,
            rate: none,
            drive_ends: none,
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
    fn move_on(&mut self, crossing: &mut Crossing<T, U>) {
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
            sums.change += next;
            sums.mean += next * part(k + 2);
            sums.slope += slope;
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
        if crossing.done == 0 {
            crossing.bend = first_slope;
        }
        if crossing.done + 1 == crossing.steps {
            crossing.bend -= low.slope + high.slope;
        }
        self.move_by(change);
    }

    /// Slope less that of the drag at turn u.
    fn braked(&self, slope: Vec3<T>, u: &Vec3<T>) -> Vec3<T> {
        let drag = &self.model.drag;
        if *drag == Vec3::zeros() { slope } else { slope - drag.component_mul(u) }
    }

    /// Adds to m with compensation for rounding (Kahan's sum).
    fn move_by(&mut self, change: Vec3<T>) {
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
    fn differentiate(&mut self, crossing: &mut Crossing<T, U>) {
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
                Group::Bias => continue,
            };
            for i in 0..3 {
                let c = FIRST_GROUP + 3 * place + i;
                put(&mut self.sensitivity[c], c, series.column(i) * by_rate[i]);
            }
        }
        let mut pushed = by_shape::<T, _>(&columns_of_the_regressor(&by_drive, &w));
        let mut by_scale = by_drive * crossing.mean_drive;
        if let Some(by_change) = by_drive_change {
            let more =
                by_shape::<T, _>(&columns_of_the_regressor(&by_change, &crossing.rate_change));
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
        crossing.done += 1;
    }

    /// Matrices of a step of D.
    fn propagation(&self, crossing: &Crossing<T, U>) -> Propagation<T> {
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

    /// Mean reading predicted over the samples of a block that is crossed, bias included, rad/s.
    ///
    /// The mean of N samples in a row lacks 1/24 N² of the change of slope that the mean over time has.
    pub fn mean_rate_rad_s(&self, crossing: &Crossing<T, U>) -> Vec3<T> {
        let n = crossing.samples;
        let bend = crossing.bend * (T::count(crossing.steps) * T::lit(1.0 / 24.0) / (n * n));
        let mean = crossing.momentum * crossing.share + bend;
        self.model.rate_rad_s(&mean, &crossing.drive) + self.model.bias
    }

    /// S̄ of one axis over a block that is crossed: derivatives of its mean reading.
    ///
    /// `S̄ = n⁻¹ (D̄ − V̄)`, with the means of both ends of each step.
    pub fn mean_sensitivity(&self, crossing: &Crossing<T, U>, axis: usize) -> [T; U] {
        let axis = axis.min(2);
        let b = Vec3::from_fn(|k, _| self.model.inverse.at(axis, k) * crossing.share);
        let a = b * T::lit(0.5);
        let mut row = [T::zero(); U];
        for c in 0..U {
            row[c] = a.dot(&crossing.sensitivity[c]);
        }
        self.model.add_readings(&mut row, axis, &b, &crossing.rate, &crossing.drive_ends);
        row
    }

    /// Derivatives of one axis of the rate at the start, for wheel momentum wᵤ there: `n⁻¹ (D₀ − V₀)`.
    pub fn sensitivity_at_start(&self, rate: &Vec3<T>, wheels: &Vec3<T>, axis: usize) -> [T; U] {
        let axis = axis.min(2);
        let b = Vec3::from_fn(|k, _| self.model.inverse.at(axis, k));
        let mut row = [T::zero(); U];
        for i in 0..3 {
            row[MOMENTUM + i] = b.at(i, 0);
        }
        self.model.add_readings(&mut row, axis, &b, rate, wheels);
        row
    }
}

/// Matrices that carry D across a step.
struct Propagation<T: Real> {
    carry: Mat<T, 3, 3>,
    series: Mat<T, 3, 3>,
    /// φ times the factor of V and that of V'; none where the step turns little.
    by_drive: Mat<T, 3, 3>,
    by_drive_change: Option<Mat<T, 3, 3>>,
}

impl<T: Real> Model<T> {
    /// Adds to a row the direct derivatives of the reading: of the rate by shape and scale, of the bias.
    fn add_readings<const U: usize>(
        &self,
        row: &mut [T; U],
        axis: usize,
        b: &Vec3<T>,
        w: &Vec3<T>,
        drive: &Vec3<T>,
    ) {
        for place in 0..groups_of(U) {
            if self.group[place] == Some(Group::Bias) {
                row[FIRST_GROUP + 3 * place + axis] = T::one();
            }
        }
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
}

impl<T: Real> Span<T> {
    /// Mean over time of a parabola `s (1 − s)` over that of its samples, `1 / (1 + 1 / 2 N²)`.
    fn of_samples(&self) -> T {
        T::one() / (T::one() + T::lit(0.5) / (self.samples * self.samples))
    }

    /// Coefficients of the parabola of wheel momentum through both ends, of the right mean over the
    /// samples.
    fn wheels_within(&self) -> [Vec3<T>; 3] {
        let (start, end) = (self.wheels_at_start, self.block.wheels_end_n_m_s);
        let beyond_line = self.block.wheels_n_m_s - (start + end) * T::lit(0.5);
        let bulge = beyond_line * (self.of_samples() * T::lit(6.0));
        [start, end - start + bulge, -bulge]
    }
}

impl<T: Real, const U: usize> Crossing<T, U> {
    /// Coefficients of x w and x g in the step's share of time, `[w₀ w₁ w₂ g₀ g₁ g₂]`; notes mean, change
    /// and ends of the drive.
    fn within_step(&mut self, scale: T) -> [Vec3<T>; 6] {
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
        [w0 * scale, w1 * scale, w2 * scale, g0 * scale, g1 * scale, g2 * scale]
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

/// Coefficient of the product of two polynomials, `Σᵢ pₖ₋ᵢ × uᵢ`, for p up to pₖ.
#[inline(never)]
fn product<'a, T: Real>(
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
fn columns_of_the_regressor<T: Real>(m: &Mat<T, 3, 3>, w: &Vec3<T>) -> [Vec3<T>; 6] {
    let [a, b, c]: [Vec3<T>; 3] = core::array::from_fn(|i| crate::math::column(m, i));
    [a * w.x, b * w.y, c * w.z, a * w.y + b * w.x, a * w.z + c * w.x, b * w.z + c * w.y]
}

#[cfg(test)]
mod tests {
    use super::super::unknowns::Belief;
    use super::*;
    use std::vec::Vec;

    const UNKNOWNS: usize = 18;
    const ALL: Groups<f64> = Groups {
        place: [
            Some((Group::Torque, Belief::Zero)),
            Some((Group::Bias, Belief::Zero)),
            Some((Group::Drag, Belief::Zero)),
        ],
    };

    fn point() -> Point<f64> {
        Point {
            momentum: Vec3::new(0.1, -0.07, 0.08),
            group: [
                Vec3::new(0.0007, -0.0003, 0.001),
                Vec3::new(0.01, 0.02, -0.01),
                Vec3::new(0.007, -0.003, 0.01),
            ],
            shape: [0.04, -0.03, 0.03, -0.05, 0.02],
            scale: 0.9,
        }
    }

    /// Wheels that swing, and a constant torque, over blocks of this length.
    fn spans(duration_s: f64, count: usize) -> Vec<Span<f64>> {
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
                Span { block, wheels_at_start: wheels(t), samples: 1e6 }
            })
            .collect()
    }

    /// Prediction for a block: mean reading, and the derivatives by columns.
    struct Prediction {
        rate_rad_s: Vec3<f64>,
        sensitivity: [Vec3<f64>; UNKNOWNS],
    }

    fn fly(
        point: &Point<f64>,
        spans: &[Span<f64>],
    ) -> (Trajectory<f64, UNKNOWNS>, Vec<Prediction>) {
        let mut trajectory = Trajectory::blank();
        assert!(trajectory.start(point, &ALL));
        let mut cross = |span: &Span<f64>| {
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

    fn moved(point: &Point<f64>, column: usize, by: f64) -> Point<f64> {
        let mut step = [0.0; UNKNOWNS];
        step[column] = by;
        let mut next = point.stepped(&step);
        next.momentum += Vec3::new(step[0], step[1], step[2]);
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
            let is_forcing = (3..6).contains(&c) || (9..12).contains(&c) || c == 17;
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
        let free = Point { group: [Vec3::zeros(); 3], ..point() };
        let (end, _) = fly(&free, &spans);
        assert!((end.momentum.norm() - free.momentum.norm()).abs() < 1e-7);
    }

    /// Neither wheels nor torque: the column of the scale is zero in every bit.
    #[test]
    fn a_free_body_has_no_sensitivity_to_its_scale() {
        let mut spans = spans(0.5, 50);
        for span in &mut spans {
            span.block = Block { duration_s: 0.5, ..Block::empty() };
            span.wheels_at_start = Vec3::zeros();
        }
        let (end, predictions) = fly(&point(), &spans);
        assert_eq!(end.sensitivity[UNKNOWNS - 1], Vec3::zeros());
        assert!(predictions.iter().all(|p| p.sensitivity[UNKNOWNS - 1] == Vec3::zeros()));
    }
}
