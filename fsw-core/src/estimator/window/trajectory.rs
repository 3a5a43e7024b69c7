//! Momentum and its sensitivities from block to block.
//!
//! From a point θ = (h₀, …, j) total momentum follows `ḣ = τ − d ω − ω × h` with `ω = J⁻¹ (h − h_w)`, and
//! its sensitivities `D = ∂h/∂θ` follow
//!
//! `Ḋ = h × S − ω × D − d S + E_τ − ω E_d`, `S = ∂ω/∂θ = J⁻¹ (D − G(ω) E_j)`.
//!
//! A constant disturbance torque acts beside the external one, and a drag d ω, axis by axis, stands
//! for what of it changes with the body's motion. A gyro bias doesn't move the body:
//! it is added to the rate that the gyro should show.
//!
//! A block is crossed in one step unless it turns far. Momentum goes by its Taylor series: the right-hand
//! side is a product, so that the coefficients follow from one another (Cauchy's rule), and its mean over
//! the step comes with them. Sensitivities go by the exponential of their equation's mean, with the
//! commutator that makes it one of fourth order (Magnus, Comm. Pure Appl. Math. 7, 1954; Iserles and
//! Nørsett, Phil. Trans. R. Soc. A 357, 1999).
//!
//! All is in units of a typical inertia, so that single precision sees numbers near 1.

use super::block::Block;
use super::unknowns::{
    BIAS, DRAG, MOMENTUM, Point, TORQUE, has_bias, has_drag, has_torque, inertia_of,
};
use crate::math::{Mat, Vec3, scalar::Real, skew};
use crate::tensor::Inertia;

/// A step may turn by so much, rad: the Taylor series then errs by `turn⁸ / 40320` of the momentum, 4e-8,
/// and where it turns by 0.3 by 2e-9.
const STEP_TURN: f64 = 0.45;
/// Up to so much, rad, three orders less of it do, and means alone of the sensitivities' equation: what
/// that leaves is `turn⁵ / 120` of the momentum, 2e-10, and `turn² / 12` of a step's forcing, 1e-4.
const SLOW_TURN: f64 = 0.03;
/// Steps across a block at most. One that turns farther than three steps may is longer than blocks are.
const MOST_STEPS: u32 = 3;

/// A block with what its neighbours tell of its inside, in units of the typical inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<T: Real> {
    /// The block.
    pub block: Block<T>,
    /// h_w at its start.
    pub wheels_at_start: Vec3<T>,
    /// h_w half-way.
    pub wheels_in_the_middle: Vec3<T>,
    /// h_w at its end.
    pub wheels_at_end: Vec3<T>,
    /// ḡ, mean over time of what the torque's impulse is beyond a ramp, as far as the torque of its
    /// neighbours tells.
    pub beyond_ramp: Vec3<T>,
}

/// A block that is being crossed, step by step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing<T: Real, const U: usize> {
    /// How many steps, and how many are done.
    steps: u32,
    done: u32,
    /// Whether a step turns little.
    is_slow: bool,
    /// Length of one, s, and their share of the block.
    step_s: T,
    share: T,
    samples: u32,
    drive: Vec3<T>,
    /// All torque but drag.
    torque: Vec3<T>,
    /// h_w a share x of the way through: `wheels[0] + x (wheels[1] + x wheels[2])`, which has its mean
    /// and its ends.
    wheels: [Vec3<T>; 3],
    /// `6 ḡ`: g is `6 ḡ x (1 − x)`.
    beyond_ramp: Vec3<T>,
    /// Of the step that is done: means of h + g and of ω, and their changes.
    mean: Vec3<T>,
    change: Vec3<T>,
    mean_rate: Vec3<T>,
    rate_change: Vec3<T>,
    /// `Δ ḣ` over a step, at the start of the block less that at the end of the last step.
    bend: Vec3<T>,
    /// Sums over the steps: of the mean of h, of that of ω at both ends, and of D at both ends.
    momentum: Vec3<T>,
    rate: Vec3<T>,
    sensitivity: [Vec3<T>; U],
}

crate::persist!([T: Real, const U: usize] Crossing<T, U> {
    steps, done, is_slow, step_s, share, samples, drive, torque, wheels, beyond_ramp, mean, change, mean_rate,
    rate_change, bend, momentum, rate, sensitivity
} if |this| this.done <= this.steps && this.steps <= MOST_STEPS);

/// Where a trajectory has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory<T: Real, const U: usize> {
    /// J⁻¹.
    inverse: Mat<T, 3, 3>,
    /// h.
    momentum: Vec3<T>,
    /// What rounding took from h, to be given back with the next step: motion about an unstable
    /// axis would magnify it.
    lost: Vec3<T>,
    /// D, column by column.
    sensitivity: [Vec3<T>; U],
}

crate::persist!([T: Real, const U: usize] Trajectory<T, U> { inverse, momentum, lost, sensitivity });

impl<T: Real, const U: usize> Crossing<T, U> {
    /// Nothing to cross.
    pub fn none() -> Self {
        let (o, none) = (T::zero(), Vec3::zeros());
        Self {
            steps: 0,
            done: 0,
            is_slow: false,
            step_s: o,
            share: o,
            samples: 0,
            drive: none,
            torque: none,
            wheels: [none; 3],
            beyond_ramp: none,
            mean: none,
            change: none,
            mean_rate: none,
            rate_change: none,
            bend: none,
            momentum: none,
            rate: none,
            sensitivity: [none; U],
        }
    }

    /// Whether all steps are done.
    pub fn is_done(&self) -> bool {
        self.done >= self.steps
    }

    /// Samples averaged in the block.
    pub fn samples(&self) -> u32 {
        self.samples
    }
}

impl<T: Real, const U: usize> Trajectory<T, U> {
    /// Nowhere yet.
    pub fn nowhere() -> Self {
        let none = Vec3::zeros();
        Self { inverse: Mat::zeros(), momentum: none, lost: none, sensitivity: [none; U] }
    }

    /// Starts at a point; false where its inertia has no inverse.
    pub fn start(&mut self, point: &Point<T>) -> bool {
        let Some(inverse) = Inertia::new(point.inertia).inverse() else { return false };
        self.inverse = inverse;
        self.momentum = point.momentum;
        self.lost = Vec3::zeros();
        self.sensitivity = [Vec3::zeros(); U];
        for i in 0..3 {
            self.sensitivity[MOMENTUM + i][i] = T::one();
        }
        true
    }

    /// Begins to cross a block, of a trajectory from `point`.
    pub fn enter(&self, crossing: &mut Crossing<T, U>, span: &Span<T>, point: &Point<T>) {
        let block = &span.block;
        let dt = block.duration_s;
        // Motion is as fast as the body turns, or as wheels of much momentum make it nutate.
        let nutation = self.inverse * self.momentum;
        let rate = nutation - self.inverse * span.wheels_at_start;
        let turn_square = rate.dot(&rate).max(nutation.dot(&nutation)) * (dt * dt);
        let mut steps = 1;
        while steps < MOST_STEPS
            && turn_square > T::lit(STEP_TURN * STEP_TURN) * T::count(steps * steps)
        {
            steps += 1;
        }
        crossing.steps = steps;
        crossing.done = 0;
        crossing.is_slow = turn_square < T::lit(SLOW_TURN * SLOW_TURN);
        crossing.share = T::one() / T::count(steps);
        crossing.step_s = dt * crossing.share;
        crossing.samples = block.samples;
        crossing.drive = block.drive_n_m_s;
        // The impulse already has all of what the turning of g makes of it.
        let turned = block.rate_rad_s.cross(&span.beyond_ramp);
        crossing.torque = block.impulse_n_m_s * (T::one() / dt) + turned + point.torque;
        let bulge = span.wheels_in_the_middle * T::lit(4.0)
            - (span.wheels_at_start + span.wheels_at_end) * T::lit(2.0);
        let chord = span.wheels_at_end - span.wheels_at_start;
        crossing.wheels = [span.wheels_at_start, chord + bulge, -bulge];
        crossing.beyond_ramp = span.beyond_ramp * T::lit(6.0);
        crossing.momentum = Vec3::zeros();
        crossing.rate = Vec3::zeros();
        crossing.bend = Vec3::zeros();
    }

    /// Carries h across a step. With the time as a share of the step, what is in a block is a
    /// polynomial: p = h + g, h_w and the turn u = Δ ω have coefficients that follow from one another,
    ///
    /// `uₖ = Δ J⁻¹ (pₖ − wₖ)`,  `(k + 1) hₖ₊₁ = Δ τ (k = 0) − d uₖ − Σᵢ uᵢ × pₖ₋ᵢ`,
    ///
    /// where nothing but h goes beyond the parabola. Written out, they stay in registers.
    /// [`differentiate`](Self::differentiate) follows.
    #[inline(never)]
    pub fn move_on(&mut self, crossing: &mut Crossing<T, U>, point: &Point<T>) {
        let part = |k: u32| T::one() / T::count(k);
        let (one, share) = (T::one(), crossing.share);
        let x = T::count(crossing.done) * share;
        let [at_start, by_share, by_square] = crossing.wheels;
        let w0 = at_start + (by_share + by_square * x) * x;
        let w1 = (by_share + by_square * (x + x)) * share;
        let w2 = by_square * (share * share);
        let g0 = crossing.beyond_ramp * (x * (one - x));
        let g1 = crossing.beyond_ramp * (share * (one - x - x));
        let g2 = crossing.beyond_ramp * -(share * share);

        let turn = self.inverse * crossing.step_s;
        let braked = |slope: Vec3<T>, u: &Vec3<T>| {
            if has_drag(U) { slope - point.drag.component_mul(u) } else { slope }
        };
        let h0 = self.momentum;
        let p0 = h0 + g0;
        let u0 = turn * (p0 - w0);
        let s0 = braked(crossing.torque * crossing.step_s + p0.cross(&u0), &u0);
        let p1 = s0 + g1;
        let u1 = turn * (p1 - w1);
        let s1 = braked(p1.cross(&u0) + p0.cross(&u1), &u1);
        let h2 = s1 * part(2);
        let p2 = h2 + g2;
        let u2 = turn * (p2 - w2);
        let s2 = braked(p2.cross(&u0) + p1.cross(&u1) + p0.cross(&u2), &u2);
        let h3 = s2 * part(3);
        let u3 = turn * h3;
        let s3 = braked(h3.cross(&u0) + p2.cross(&u1) + p1.cross(&u2) + p0.cross(&u3), &u3);
        let h4 = s3 * part(4);
        let half = part(2);
        let mut change = s0 + h2 + h3 + h4;
        let mut mean = h0 + s0 * half + h2 * part(3) + h3 * part(4) + h4 * part(5);
        let mut end_slope = s0 + s1 + s2 + s3;
        if !crossing.is_slow {
            let u4 = turn * h4;
            let s4 = h4.cross(&u0) + h3.cross(&u1) + p2.cross(&u2) + p1.cross(&u3) + p0.cross(&u4);
            let s4 = braked(s4, &u4);
            let h5 = s4 * part(5);
            let u5 = turn * h5;
            let s5 = h5.cross(&u0) + h4.cross(&u1) + h3.cross(&u2);
            let s5 = braked(s5 + p2.cross(&u3) + p1.cross(&u4) + p0.cross(&u5), &u5);
            let h6 = s5 * part(6);
            let u6 = turn * h6;
            let s6 = h6.cross(&u0) + h5.cross(&u1) + h4.cross(&u2) + h3.cross(&u3);
            let s6 = braked(s6 + p2.cross(&u4) + p1.cross(&u5) + p0.cross(&u6), &u6);
            let h7 = s6 * part(7);
            change += h5 + h6 + h7;
            mean += h5 * part(6) + h6 * part(7) + h7 * part(8);
            end_slope += s4 + s5 + s6;
        }
        crossing.mean = mean + g0 + g1 * half + g2 * part(3);
        crossing.change = change + g1 + g2;
        crossing.mean_rate = self.inverse * (crossing.mean - w0 - w1 * half - w2 * part(3));
        crossing.rate_change = self.inverse * (crossing.change - w1 - w2);
        crossing.momentum += mean;
        crossing.rate += self.inverse * (p0 - w0) + crossing.rate_change * half;
        if crossing.done == 0 {
            crossing.bend = s0;
        }
        if crossing.done + 1 == crossing.steps {
            crossing.bend -= end_slope;
        }
        self.move_by(change);
    }

    /// ω̄ + b, mean reading over the samples of a block that is crossed, rad/s.
    ///
    /// Of n samples in a row the mean misses 1/24 n² of the change of slope that the mean over time has.
    pub fn mean_rate_rad_s(&self, crossing: &Crossing<T, U>, point: &Point<T>) -> Vec3<T> {
        let n = T::count(crossing.samples);
        let bend = crossing.bend * (T::count(crossing.steps) * T::lit(1.0 / 24.0) / (n * n));
        let mean = crossing.momentum * crossing.share + bend;
        self.inverse * (mean - crossing.drive) + point.bias
    }

    /// S̄ of one axis over a block that is crossed: derivatives of its mean reading.
    ///
    /// `S̄ = J⁻¹ (D̄ − G(ω̄) E_j)`, with the mean of D at both ends of each step, and of ω there, so that a body
    /// that nothing drives shows exactly nothing of its size.
    #[inline(never)]
    pub fn mean_sensitivity(&self, crossing: &Crossing<T, U>, axis: usize) -> [T; U] {
        let axis = axis.min(2); // it always is, which the compiler can't see
        let b = Vec3::from_fn(|k, _| self.inverse[(axis, k)] * crossing.share);
        let a = b * T::lit(0.5);
        let w = &crossing.rate;
        let mut row = [T::zero(); U];
        for c in 0..U {
            row[c] = a.dot(&crossing.sensitivity[c]);
        }
        if has_bias(U) {
            row[BIAS + axis] = T::one();
        }
        let by_inertia = [
            b.x * w.x,
            b.y * w.y,
            b.z * w.z,
            b.x * w.y + b.y * w.x,
            b.x * w.z + b.z * w.x,
            b.y * w.z + b.z * w.y,
        ];
        for i in 0..6 {
            row[inertia_of(U) + i] -= by_inertia[i];
        }
        row
    }

    /// Adds to h, and keeps what rounding takes (Kahan's sum).
    fn move_by(&mut self, change: Vec3<T>) {
        let change = change + self.lost;
        let sum = self.momentum + change;
        self.lost = change - (sum - self.momentum);
        self.momentum = sum;
    }

    /// Carries D across a step. With `K = Δ (h^× − d) J⁻¹` and `A = K − Δ ω^×`, both at their means, and
    /// their changes K', A' and ω' over the step,
    ///
    /// `X = A + (A' A − A A') / 12`,  `D₁ = D₀ + φ (X D₀ + B)`,  `φ = 1 + X/2 + X²/6 + X³/24 + X⁴/120`,
    ///
    /// `B = Δ E_τ − Δ ω E_d − (K + (A' K − A K') / 12) G(ω) E_j − (K' − A K) / 12 G(ω') E_j`,
    ///
    /// and adds D₀ + D₁ to a sum, or begins it. A step of 0.3 rad errs by 1e-5, so that the
    /// sensitivities keep their phase from one end of a window to the other, and a body that nothing
    /// drives shows nothing of its size. Of torque and drag, small as they are, the means are enough.
    #[inline(never)]
    pub fn differentiate(&mut self, crossing: &mut Crossing<T, U>, point: &Point<T>) {
        let one = Mat::<T, 3, 3>::identity();
        let by_momentum = self.inverse * crossing.step_s;
        let mut k = across(&crossing.mean, &by_momentum);
        if has_drag(U) {
            for i in 0..3 {
                let braked = by_momentum.row(i) * point.drag[i];
                k.set_row(i, &(k.row(i) - braked));
            }
        }
        let a = k - skew(&(crossing.mean_rate * crossing.step_s));
        let (mut x, mut by_rate, mut by_rate_change) = (a, k, None);
        if !crossing.is_slow {
            let twelfth = T::lit(1.0 / 12.0);
            let k_change = across(&(crossing.change * twelfth), &by_momentum);
            let a_change = k_change - skew(&(crossing.rate_change * (crossing.step_s * twelfth)));
            x += a_change * a - a * a_change;
            by_rate += a_change * k - a * k_change;
            by_rate_change = Some(a * k * twelfth - k_change);
        }
        let fourth = one * T::lit(1.0 / 24.0) + x * T::lit(1.0 / 120.0);
        let third = one * T::lit(1.0 / 6.0) + x * fourth;
        let series = one + x * (one * T::lit(0.5) + x * third);
        let carry = one + series * x;
        let by_rate = series * -by_rate;
        let w = &crossing.mean_rate;
        let is_first = crossing.done == 0;
        let (sum, duration_s) = (&mut crossing.sensitivity, crossing.step_s);
        let mut put = |c: usize, pushed: Option<Vec3<T>>| {
            let before = self.sensitivity[c];
            let mut after = carry * before;
            if let Some(pushed) = pushed {
                after += pushed;
            }
            self.sensitivity[c] = after;
            let both = before + after;
            sum[c] = if is_first { both } else { sum[c] + both };
        };
        for i in 0..3 {
            put(MOMENTUM + i, None);
            if has_torque(U) {
                put(TORQUE + i, Some(series.column(i) * duration_s));
            }
            if has_drag(U) {
                put(DRAG + i, Some(series.column(i) * (-w[i] * duration_s)));
            }
        }
        let mut pushed = by_columns_of_the_regressor(&by_rate, w);
        if let Some(by_rate_change) = by_rate_change {
            let more =
                by_columns_of_the_regressor(&(series * by_rate_change), &crossing.rate_change);
            for i in 0..6 {
                pushed[i] += more[i];
            }
        }
        for i in 0..6 {
            put(inertia_of(U) + i, Some(pushed[i]));
        }
        crossing.done += 1;
    }

    /// How far a change of the starting momentum has grown, squared: the largest of three.
    pub fn growth_square(&self) -> T {
        let of = |i: usize| self.sensitivity[MOMENTUM + i].dot(&self.sensitivity[MOMENTUM + i]);
        of(0).max(of(1)).max(of(2))
    }

    /// Where a step of the starting point takes h, to first order, and what rounding takes from
    /// that.
    pub fn moved(&self, step: &[T; U]) -> (Vec3<T>, Vec3<T>) {
        let mut change = self.lost;
        for c in 0..U {
            change += self.sensitivity[c] * step[c];
        }
        let momentum = self.momentum + change;
        (momentum, change - (momentum - self.momentum))
    }

    /// Turns a row of information on (h₀, …) into one on (h, …): with the others as x,
    /// `δh₀ = D_h⁻¹ (δh − D_x δx)`.
    /// `None` where D_h has lost its inverse to rounding.
    pub fn row_at_end(&self, row: &[T; U]) -> Option<[T; U]> {
        let [a, b, c] = [self.sensitivity[0], self.sensitivity[1], self.sensitivity[2]];
        // The determinant is 1 but for rounding: neither term of Ḋ changes a volume.
        let scale = T::one() / a.dot(&b.cross(&c));
        if !scale.is_finite() {
            return None;
        }
        let by_momentum =
            (b.cross(&c) * row[0] + c.cross(&a) * row[1] + a.cross(&b) * row[2]) * scale;
        Some(core::array::from_fn(|i| match i {
            0..TORQUE => by_momentum[i],
            _ => row[i] - by_momentum.dot(&self.sensitivity[i]),
        }))
    }
}

/// `v^× M`.
fn across<T: Real>(v: &Vec3<T>, m: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
    Mat::from_columns(&core::array::from_fn::<Vec3<T>, 3, _>(|i| {
        v.cross(&Vec3::new(m[(0, i)], m[(1, i)], m[(2, i)]))
    }))
}

/// The columns of `M G(ω)`.
fn by_columns_of_the_regressor<T: Real>(m: &Mat<T, 3, 3>, w: &Vec3<T>) -> [Vec3<T>; 6] {
    let [a, b, c]: [Vec3<T>; 3] = core::array::from_fn(|i| m.column(i).into());
    [a * w.x, b * w.y, c * w.z, a * w.y + b * w.x, a * w.z + c * w.x, b * w.z + c * w.y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const INERTIA_ELEMENTS: [f64; 6] = [1.1, 0.9, 1.3, 0.1, -0.15, 0.05];

    /// All kinds of unknowns.
    const UNKNOWNS: usize = 18;

    fn point() -> Point<f64> {
        Point {
            momentum: Vec3::new(0.3, -0.2, 0.25),
            torque: Vec3::new(0.002, -0.001, 0.003),
            bias: Vec3::new(0.01, 0.02, -0.01),
            drag: Vec3::new(0.02, -0.01, 0.03),
            inertia: INERTIA_ELEMENTS,
        }
    }

    /// Wheels that swing, and a constant torque, over blocks of this length.
    fn spans(duration_s: f64, count: usize) -> Vec<Span<f64>> {
        let wheels = |t: f64| Vec3::new(0.1 * (0.5 * t).sin(), 0.05, 0.1 * (0.4 * t).cos());
        let mean = |t: f64| {
            let i =
                |w: f64, f: fn(f64) -> f64| (f(w * (t + duration_s)) - f(w * t)) / (w * duration_s);
            Vec3::new(-0.1 * i(0.5, f64::cos), 0.05, 0.1 * i(0.4, f64::sin))
        };
        (0..count)
            .map(|k| {
                let t = k as f64 * duration_s;
                let (start, end) = (wheels(t), wheels(t + duration_s));
                let block = Block {
                    // So many that their mean is that over time.
                    samples: 1_000_000,
                    duration_s,
                    rate_rad_s: Vec3::zeros(),
                    drive_n_m_s: mean(t),
                    impulse_n_m_s: Vec3::new(0.02, -0.01, 0.01) * duration_s,
                };
                Span {
                    block,
                    wheels_at_start: start,
                    wheels_in_the_middle: mean(t) * 1.5 - (start + end) * 0.25,
                    wheels_at_end: end,
                    beyond_ramp: Vec3::zeros(),
                }
            })
            .collect()
    }

    fn fly(
        point: &Point<f64>,
        spans: &[Span<f64>],
    ) -> (Trajectory<f64, UNKNOWNS>, Vec<Prediction>) {
        let mut trajectory = Trajectory::nowhere();
        assert!(trajectory.start(point));
        let mut crossing = Crossing::none();
        let mut cross = |span: &Span<f64>| {
            trajectory.enter(&mut crossing, span, point);
            while !crossing.is_done() {
                trajectory.move_on(&mut crossing, point);
                trajectory.differentiate(&mut crossing, point);
            }
            let rows: [[f64; UNKNOWNS]; 3] =
                core::array::from_fn(|axis| trajectory.mean_sensitivity(&crossing, axis));
            Prediction {
                rate_rad_s: trajectory.mean_rate_rad_s(&crossing, point),
                sensitivity: core::array::from_fn(|c| Vec3::from_fn(|r, _| rows[r][c])),
            }
        };
        let predictions = spans.iter().map(&mut cross).collect();
        (trajectory, predictions)
    }

    /// What a trajectory says of a block: its mean reading, and the derivatives column by column.
    struct Prediction {
        rate_rad_s: Vec3<f64>,
        sensitivity: [Vec3<f64>; UNKNOWNS],
    }

    /// What a parabola leaves of wheels that swing by a quarter of a radian in a block, 1e-3 of
    /// their 0.1 N m s in the fourth power, over forty blocks.
    const PARABOLA: f64 = 5e-6;
    /// What steps of 0.42 rad leave of the sensitivities to momentum and inertia, where they have grown for
    /// forty blocks.
    const END: f64 = 1e-5;
    /// And of those to torque and drag, whose forcing is taken at its mean: 1.2e-3 of the drag about z.
    const END_OF_FORCING: f64 = 2e-3;
    /// What the trapezoid leaves of their means: up to a twelfth of the turn's square, 1.5e-2, of which a third
    /// is seen.
    const MEAN: f64 = 6e-3;

    /// Two lengths of block, that turn by 0.2 and 0.02 rad.
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

    #[test]
    fn sensitivities_agree_with_finite_differences() {
        const STEP: f64 = 1e-5;
        let spans = spans(0.5, 40);
        let (end, predictions) = fly(&point(), &spans);
        for c in 0..UNKNOWNS {
            let mut step = [0.0; UNKNOWNS];
            step[c] = STEP;
            let (up, rates_up) = fly(&point().plus(&step), &spans);
            let (down, rates_down) = fly(&point().plus(&step.map(|x| -x)), &spans);
            let of_momentum = (up.momentum - down.momentum) / (2.0 * STEP);
            let size = of_momentum.norm().max(1.0);
            let is_forcing = (TORQUE..BIAS).contains(&c) || (DRAG..DRAG + 3).contains(&c);
            let most = if is_forcing { END_OF_FORCING } else { END };
            assert!((end.sensitivity[c] - of_momentum).norm() < most * size);
            for (k, prediction) in predictions.iter().enumerate() {
                let of_rate = (rates_up[k].rate_rad_s - rates_down[k].rate_rad_s) / (2.0 * STEP);
                let size = of_rate.norm().max(1.0);
                assert!((prediction.sensitivity[c] - of_rate).norm() < MEAN * size);
            }
        }
    }

    #[test]
    fn without_torque_momentum_keeps_its_size() {
        let mut spans = spans(0.5, 200);
        for span in &mut spans {
            span.block.impulse_n_m_s = Vec3::zeros();
        }
        let free = Point::new(point().momentum, INERTIA_ELEMENTS);
        let (end, _) = fly(&free, &spans);
        assert!((end.momentum.norm() - free.momentum.norm()).abs() < 1e-7);
    }

    #[test]
    fn information_on_the_start_is_the_same_at_the_end() {
        let (end, _) = fly(&point(), &spans(0.5, 20));
        let row: [f64; UNKNOWNS] = core::array::from_fn(|i| (i as f64 + 1.0).sin());
        let at_end = end.row_at_end(&row).unwrap();
        let step: [f64; UNKNOWNS] = core::array::from_fn(|i| 1e-3 * (2.0 * i as f64).cos());
        let (momentum, lost) = end.moved(&step);
        let change = momentum + lost - end.momentum;
        let before: f64 = (0..UNKNOWNS).map(|i| row[i] * step[i]).sum();
        let after: f64 = (0..3).map(|i| at_end[i] * change[i]).sum::<f64>()
            + (3..UNKNOWNS).map(|i| at_end[i] * step[i]).sum::<f64>();
        // The exponential series leaves the determinant of D_h 1e-4 off one.
        assert!((before - after).abs() < 1e-9, "{before} {after}");
    }
}
