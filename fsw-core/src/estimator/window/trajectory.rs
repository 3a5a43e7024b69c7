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
use crate::tensor::{Inertia, regressor};

/// A block may turn by so much, rad, for one Runge-Kutta step: its error, `turn⁵ / 120`, is then
/// below single precision.
const SHORT_TURN: f64 = 0.03;
/// Steps across a block that turns further. Up to a turn of 0.2 rad they err by 1e-8.
const STEPS: u32 = 4;

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

impl<T: Real> Span<T> {
    /// h_w and g a share x of the way through: parabolas that have their means and their ends.
    fn inside(&self, x: T) -> (Vec3<T>, Vec3<T>) {
        let rest = T::one() - x;
        let bulge = x * rest * T::lit(4.0);
        let chord = self.wheels_at_start * rest + self.wheels_at_end * x;
        let middle = (self.wheels_at_start + self.wheels_at_end) * T::lit(0.5);
        let wheels = chord + (self.wheels_in_the_middle - middle) * bulge;
        (wheels, self.beyond_ramp * (bulge * T::lit(1.5)))
    }
}

/// What a trajectory says of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction<T: Real, const U: usize> {
    /// ω̄ + b, mean reading over the block's samples, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// S̄, its derivatives, column by column.
    pub sensitivity: [Vec3<T>; U],
}

/// Where a trajectory has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory<T: Real, const U: usize> {
    /// J⁻¹.
    inverse: Mat<T, 3, 3>,
    /// τ, b and d.
    torque: Vec3<T>,
    bias: Vec3<T>,
    drag: Vec3<T>,
    /// h.
    momentum: Vec3<T>,
    /// What rounding took from h, to be given back with the next step: motion about an unstable
    /// axis would magnify it.
    lost: Vec3<T>,
    /// D, column by column.
    sensitivity: [Vec3<T>; U],
}

impl<T: Real, const U: usize> Trajectory<T, U> {
    /// Starts at a point; `None` where its inertia has no inverse.
    pub fn new(point: &Point<T>) -> Option<Self> {
        let mut sensitivity = [Vec3::zeros(); U];
        for i in 0..3 {
            sensitivity[MOMENTUM + i][i] = T::one();
        }
        Some(Self {
            inverse: Inertia::new(point.inertia).inverse()?,
            torque: point.torque,
            bias: point.bias,
            drag: point.drag,
            momentum: point.momentum,
            lost: Vec3::zeros(),
            sensitivity,
        })
    }

    /// Integrates across a block.
    ///
    /// Momentum without g, which is zero at both ends, by Runge-Kutta of fourth order. Its mean
    /// over the samples is that of Hermite's cubic through both ends; n samples in a row miss
    /// 1/n² of what the mean over time makes of its curvature.
    pub fn advance(&mut self, span: &Span<T>) -> Prediction<T, U> {
        let block = &span.block;
        let (dt, half, sixth) = (block.duration_s, T::lit(0.5), T::lit(1.0 / 6.0));
        // The impulse already has all of what the turning of g makes of it.
        let turned = block.rate_rad_s.cross(&span.beyond_ramp);
        let torque = block.impulse_n_m_s / dt + turned + self.torque;
        let inverse = self.inverse;
        let rate = |h: &Vec3<T>, wheels: &Vec3<T>| inverse * (h - wheels);
        let drag = self.drag;
        let slope = |h: &Vec3<T>, wheels: &Vec3<T>| {
            let w = rate(h, wheels);
            let braked = if has_drag(U) { drag.component_mul(&w) } else { Vec3::zeros() };
            torque - braked - w.cross(h)
        };

        let start = self.momentum;
        let turn = rate(&start, &span.wheels_at_start) * dt;
        let is_short = turn.dot(&turn) < T::lit(SHORT_TURN * SHORT_TURN);
        let steps = if is_short { 1 } else { STEPS };
        let step_s = dt / T::count(steps);
        let mut sensitivity = [Vec3::zeros(); U];
        for step in 0..steps {
            let at = |quarter: u32| span.inside(T::count(4 * step + quarter) / T::count(4 * steps));
            let ((w0, g0), (w1, g1), (w2, g2)) = (at(0), at(2), at(4));
            let h = self.momentum;
            let k1 = slope(&(h + g0), &w0);
            let k2 = slope(&(h + k1 * (step_s * half) + g1), &w1);
            let k3 = slope(&(h + k2 * (step_s * half) + g1), &w1);
            let k4 = slope(&(h + k3 * step_s + g2), &w2);
            self.move_by((k1 + (k2 + k3) * T::lit(2.0) + k4) * (step_s * sixth));
            let middle = (h + self.momentum) * half + (k1 - k4) * (step_s * T::lit(0.125)) + g1;
            self.differentiate(&middle, &rate(&middle, &w1), step_s, &mut sensitivity);
        }
        let end = self.momentum;
        let bend = slope(&start, &span.wheels_at_start) - slope(&end, &span.wheels_at_end);
        let n = T::count(block.samples);
        let share = T::lit(1.0 / 12.0) * (T::one() + half / (n * n));
        let mean = (start + end) * half + bend * (dt * share);
        let rate_rad_s = inverse * (mean - block.drive_n_m_s) + self.bias;
        let share = T::one() / T::count(steps);
        let mut sensitivity = sensitivity.map(|column| column * share);
        if has_bias(U) {
            for i in 0..3 {
                sensitivity[BIAS + i][i] = T::one();
            }
        }
        Prediction { rate_rad_s, sensitivity }
    }

    /// Adds to h, and keeps what rounding takes (Kahan's sum).
    fn move_by(&mut self, change: Vec3<T>) {
        let change = change + self.lost;
        let sum = self.momentum + change;
        self.lost = change - (sum - self.momentum);
        self.momentum = sum;
    }

    /// Carries D across a step by the exponential series of its equation in the middle, with
    /// `X = Δ ((h^× − d) J⁻¹ − ω^×)` and `B = E_τ − ω E_d − (h^× − d) J⁻¹ G(ω) E_j`,
    ///
    /// `D₁ = D₀ + (1 + X/2 + X²/6) (X D₀ + Δ B)`,
    ///
    /// and adds S̄, from the mean of both. A step of 0.05 rad errs by 2e-4, which is enough:
    /// sensitivities only steer towards the solution, and scale its covariance.
    fn differentiate(
        &mut self,
        momentum: &Vec3<T>,
        rate_rad_s: &Vec3<T>,
        duration_s: T,
        sum: &mut [Vec3<T>; U],
    ) {
        let half = T::lit(0.5);
        let one = Mat::<T, 3, 3>::identity();
        let mut by_rate = skew(momentum);
        if has_drag(U) {
            for i in 0..3 {
                by_rate[(i, i)] -= self.drag[i];
            }
        }
        let x = (by_rate * self.inverse - skew(rate_rad_s)) * duration_s;
        let series = one + x * (one * half + x * T::lit(1.0 / 6.0));
        let g = regressor(rate_rad_s);
        let mut carry = |c: usize, pushed: Vec3<T>, by_inertia: Vec3<T>| {
            let before = self.sensitivity[c];
            let after = before + series * (x * before + pushed);
            self.sensitivity[c] = after;
            sum[c] += self.inverse * ((before + after) * half) - by_inertia;
        };
        for i in 0..3 {
            carry(MOMENTUM + i, Vec3::zeros(), Vec3::zeros());
        }
        if has_torque(U) {
            for i in 0..3 {
                let mut pushed = Vec3::zeros();
                pushed[i] = duration_s;
                carry(TORQUE + i, pushed, Vec3::zeros());
            }
        }
        if has_drag(U) {
            for i in 0..3 {
                let mut pushed = Vec3::zeros();
                pushed[i] = -rate_rad_s[i] * duration_s;
                carry(DRAG + i, pushed, Vec3::zeros());
            }
        }
        for i in 0..6 {
            let by_inertia = self.inverse * Vec3::from(g.column(i));
            carry(inertia_of(U) + i, -(by_rate * by_inertia) * duration_s, by_inertia);
        }
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
    ) -> (Trajectory<f64, UNKNOWNS>, Vec<Prediction<f64, UNKNOWNS>>) {
        let mut trajectory = Trajectory::new(point).unwrap();
        let predictions = spans.iter().map(|span| trajectory.advance(span)).collect();
        (trajectory, predictions)
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
