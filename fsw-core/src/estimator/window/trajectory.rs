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
//! All is in units of a typical inertia, so that single precision sees numbers near 1.

use super::block::Block;
use super::unknowns::{
    BIAS, DRAG, MOMENTUM, Point, TORQUE, has_bias, has_drag, has_torque, inertia_of,
};
use crate::math::{Mat, Vec3, scalar::Real, skew};
use crate::tensor::Inertia;

/// A step may turn by so much, rad.
const STEP_TURN: f64 = 0.067;
/// And by so much where momentum takes one Runge-Kutta step in it, and not two: their error,
/// `turn⁵ / 120`, is then below single precision.
const WHOLE_TURN: f64 = 0.03;
/// Steps across a block at most. Up to a turn of 0.2 rad its six Runge-Kutta steps err by 2e-9.
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
    /// How many steps, how many are done, and whether each takes two Runge-Kutta steps.
    steps: u32,
    done: u32,
    is_halved: bool,
    /// Length of one, s, and their share of the block.
    step_s: T,
    share: T,
    duration_s: T,
    samples: u32,
    drive: Vec3<T>,
    /// All torque but drag.
    torque: Vec3<T>,
    /// h_w a share x of the way through: `wheels[0] + x (wheels[1] + x wheels[2])`, which has its mean
    /// and its ends.
    wheels: [Vec3<T>; 3],
    /// `6 ḡ`: g is `6 ḡ x (1 − x)`.
    beyond_ramp: Vec3<T>,
    /// h and ḣ at the start.
    momentum: Vec3<T>,
    slope: Vec3<T>,
    /// Sums over the steps: of ω half-way, and of D before and after.
    rate: Vec3<T>,
    sensitivity: [Vec3<T>; U],
}

crate::persist!([T: Real, const U: usize] Crossing<T, U> {
    steps, done, is_halved, step_s, share, duration_s, samples, drive, torque, wheels, beyond_ramp, momentum,
    slope, rate, sensitivity
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
            is_halved: false,
            step_s: o,
            share: o,
            duration_s: o,
            samples: 0,
            drive: none,
            torque: none,
            wheels: [none; 3],
            beyond_ramp: none,
            momentum: none,
            slope: none,
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

    /// h_w a share x of the way through.
    fn wheels(&self, x: T) -> Vec3<T> {
        self.wheels[0] + (self.wheels[1] + self.wheels[2] * x) * x
    }

    /// g there.
    fn beyond(&self, x: T) -> Vec3<T> {
        self.beyond_ramp * (x * (T::one() - x))
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
        let turn = self.inverse * (self.momentum - span.wheels_at_start) * dt;
        let turn_square = turn.dot(&turn);
        let mut steps = 1;
        while steps < MOST_STEPS
            && turn_square > T::lit(STEP_TURN * STEP_TURN) * T::count(steps * steps)
        {
            steps += 1;
        }
        crossing.steps = steps;
        crossing.done = 0;
        crossing.is_halved = turn_square > T::lit(WHOLE_TURN * WHOLE_TURN);
        crossing.share = T::one() / T::count(steps);
        crossing.step_s = dt * crossing.share;
        crossing.duration_s = dt;
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
        crossing.momentum = self.momentum;
    }

    /// ḣ for h and h_w.
    fn slope(&self, torque: &Vec3<T>, drag: &Vec3<T>, h: &Vec3<T>, wheels: &Vec3<T>) -> Vec3<T> {
        let w = self.inverse * (h - wheels);
        let braked = if has_drag(U) { torque - drag.component_mul(&w) } else { *torque };
        braked - w.cross(h)
    }

    /// A Runge-Kutta step of fourth order of momentum without g, which is zero at both ends of the block,
    /// from a share x₀ of the way through it to x₂. Returns ḣ at its start, and h with g half-way.
    #[inline(never)]
    fn move_on(
        &mut self,
        crossing: &Crossing<T, U>,
        point: &Point<T>,
        (x0, x2): (T, T),
        step_s: T,
    ) -> (Vec3<T>, Vec3<T>) {
        let half = T::lit(0.5);
        let x1 = (x0 + x2) * half;
        let (w1, g1) = (crossing.wheels(x1), crossing.beyond(x1));
        let slope = |h: &Vec3<T>, w: &Vec3<T>| self.slope(&crossing.torque, &point.drag, h, w);
        let h = self.momentum;
        let k1 = slope(&(h + crossing.beyond(x0)), &crossing.wheels(x0));
        let k2 = slope(&(h + k1 * (step_s * half) + g1), &w1);
        let k3 = slope(&(h + k2 * (step_s * half) + g1), &w1);
        let k4 = slope(&(h + k3 * step_s + crossing.beyond(x2)), &crossing.wheels(x2));
        self.move_by((k1 + (k2 + k3) * T::lit(2.0) + k4) * (step_s * T::lit(1.0 / 6.0)));
        (k1, (h + self.momentum) * half + (k1 - k4) * (step_s * T::lit(0.125)) + g1)
    }

    /// One step across a block.
    #[inline(never)]
    pub fn step(&mut self, crossing: &mut Crossing<T, U>, point: &Point<T>) {
        let half = T::lit(0.5);
        let at = |halves: u32| T::count(2 * crossing.done + halves) * (crossing.share * half);
        let (x0, x1, x2) = (at(0), at(1), at(2));
        let (slope, middle) = if crossing.is_halved {
            let half_s = crossing.step_s * half;
            let (slope, _) = self.move_on(crossing, point, (x0, x1), half_s);
            let middle = self.momentum + crossing.beyond(x1);
            self.move_on(crossing, point, (x1, x2), half_s);
            (slope, middle)
        } else {
            self.move_on(crossing, point, (x0, x2), crossing.step_s)
        };
        let rate = self.inverse * (middle - crossing.wheels(x1));
        let is_first = crossing.done == 0;
        if is_first {
            crossing.slope = slope;
            crossing.rate = Vec3::zeros();
        }
        crossing.done += 1;
        crossing.rate += rate;
        let (step_s, sum) = (crossing.step_s, &mut crossing.sensitivity);
        self.differentiate(&middle, &rate, step_s, &point.drag, sum, is_first);
    }

    /// ω̄ + b, mean reading over the samples of a block that is crossed, rad/s.
    ///
    /// The mean of h over them is that of Hermite's cubic through both ends; n samples in a row miss
    /// 1/n² of what the mean over time makes of its curvature.
    pub fn mean_rate_rad_s(&self, crossing: &Crossing<T, U>, point: &Point<T>) -> Vec3<T> {
        let (half, end) = (T::lit(0.5), self.momentum);
        let wheels = crossing.wheels(T::one());
        let bend = crossing.slope - self.slope(&crossing.torque, &point.drag, &end, &wheels);
        let n = T::count(crossing.samples);
        let share = T::lit(1.0 / 12.0) * (T::one() + half / (n * n));
        let mean = (crossing.momentum + end) * half + bend * (crossing.duration_s * share);
        self.inverse * (mean - crossing.drive) + point.bias
    }

    /// S̄ of one axis over a block that is crossed: derivatives of its mean reading.
    ///
    /// `S̄ = J⁻¹ (D̄ − G(ω̄) E_j)`, with the mean of D before and after each step, and of ω half-way.
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

    /// Carries D across a step by the exponential series of its equation in the middle, with
    /// `K = Δ (h^× − d) J⁻¹`, `X = K − Δ ω^×` and `B = Δ E_τ − Δ ω E_d − K G(ω) E_j`,
    ///
    /// `D₁ = D₀ + (1 + X/2 + X²/6) (X D₀ + B)`,
    ///
    /// and adds D₀ + D₁ to a sum, or begins it. A step of 0.067 rad errs by 4e-4, which is enough:
    /// sensitivities only steer towards the solution, and scale its covariance.
    fn differentiate(
        &mut self,
        momentum: &Vec3<T>,
        rate_rad_s: &Vec3<T>,
        duration_s: T,
        drag: &Vec3<T>,
        sum: &mut [Vec3<T>; U],
        is_first: bool,
    ) {
        let one = Mat::<T, 3, 3>::identity();
        let mut by_rate = skew(&(momentum * duration_s));
        if has_drag(U) {
            for i in 0..3 {
                by_rate[(i, i)] -= drag[i] * duration_s;
            }
        }
        let k = by_rate * self.inverse;
        let x = k - skew(&(rate_rad_s * duration_s));
        let series = one + x * (one * T::lit(0.5) + x * T::lit(1.0 / 6.0));
        let carry = one + series * x;
        let by_moment = series * -k;
        let w = rate_rad_s;
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
        // K times the columns of the regressor, written out.
        let [a, b, c]: [Vec3<T>; 3] = core::array::from_fn(|i| by_moment.column(i).into());
        let first = inertia_of(U);
        put(first, Some(a * w.x));
        put(first + 1, Some(b * w.y));
        put(first + 2, Some(c * w.z));
        put(first + 3, Some(a * w.y + b * w.x));
        put(first + 4, Some(a * w.z + c * w.x));
        put(first + 5, Some(b * w.z + c * w.y));
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
                trajectory.step(&mut crossing, point);
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
    /// What the series in the middle of a block leaves of the sensitivities, as documented, where
    /// they have grown for forty blocks.
    const SERIES: f64 = 1e-3;

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
            assert!((end.sensitivity[c] - of_momentum).norm() < SERIES * size);
            for (k, prediction) in predictions.iter().enumerate() {
                let of_rate = (rates_up[k].rate_rad_s - rates_down[k].rate_rad_s) / (2.0 * STEP);
                let size = of_rate.norm().max(1.0);
                assert!((prediction.sensitivity[c] - of_rate).norm() < SERIES * size);
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
