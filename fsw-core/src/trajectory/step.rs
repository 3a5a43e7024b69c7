//! Steps across a block: Taylor series of the momentum.

use super::{Trajectory, WITHOUT_HARDWARE};
use crate::dynamics::wheels::Momenta;
use crate::math::{Mat, Vec3, rotated, scalar::Real};

/// Orders of the Taylor series, and those of a step that turns little.
pub(super) const ORDERS: usize = 7;
const LOW_ORDERS: usize = 4;

/// A block that is being crossed.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<T: Real, const W: usize, const U: usize> {
    pub(super) steps: u32,
    pub(super) done: u32,
    /// True where a step turns little.
    pub(super) is_slow: bool,
    /// Length of a step, s, and its share of the block.
    pub(super) step_s: T,
    pub(super) share: T,
    pub(super) samples: T,
    /// Means over the samples of the block, per unit of x: drive `w̄ − ḡ`, momentum of each wheel, and ḡ.
    pub(super) drive: Vec3<T>,
    pub(super) wheel_mean: Momenta<T, W>,
    pub(super) beyond: Vec3<T>,
    /// Known torque per unit of x, and all torque but drag.
    pub(super) known_torque: Vec3<T>,
    pub(super) torque: Vec3<T>,
    /// Momentum of each wheel a share s of the way through: `of_wheel[0] + s (of_wheel[1] + s of_wheel[2])`, and wᵤ
    /// likewise.
    pub(super) of_wheel: [Momenta<T, W>; 3],
    pub(super) wheels: [Vec3<T>; 3],
    /// Length of the block, s.
    pub(super) duration_s: T,
    /// `6 ḡᵤ`: gᵤ is `6 ḡᵤ s (1 − s)`.
    pub(super) beyond_ramp: Vec3<T>,
    /// Of the last step: means of m + g and of ω, and their changes; mean and change of the drive; gᵤ.
    pub(super) mean: Vec3<T>,
    pub(super) change: Vec3<T>,
    pub(super) mean_rate: Vec3<T>,
    pub(super) rate_change: Vec3<T>,
    pub(super) mean_drive: Vec3<T>,
    pub(super) drive_change: Vec3<T>,
    pub(super) mean_beyond: Vec3<T>,
    pub(super) beyond_change: Vec3<T>,
    /// `Δ ṁ` over a step, at the start of the block less that at the end of the last step.
    pub(super) bend: Vec3<T>,
    /// Sums over the steps: means of m and of ω, and sum of both ends of D.
    pub(super) momentum: Vec3<T>,
    pub(super) rate: Vec3<T>,
    pub(super) sensitivity: [Vec3<T>; U],
}

impl<T: Real, const W: usize, const U: usize, const M: usize> Trajectory<T, W, U, M> {
    /// Carries m across a step. With the time as a share of the step, p = m + g, w and the turn u = Δ ω
    /// are polynomials whose coefficients follow from one another,
    ///
    /// `uₖ = Δ n⁻¹ (pₖ − wₖ)`,  `(k + 1) mₖ₊₁ = Δ τ (k = 0) − c uₖ − Σᵢ uᵢ × pₖ₋ᵢ`,
    ///
    /// where nothing but m goes beyond the parabola. The sums of the low and of the high orders are kept apart.
    /// [`differentiate`](Self::differentiate) follows.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn move_on(&mut self, crossing: &mut Crossing<T, W, U>) {
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
        crossing.rate += crossing.mean_rate;
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
}

impl<T: Real, const W: usize, const U: usize> Crossing<T, W, U> {
    /// Notes the slope of m at the start of the first step, and at the end of the last one.
    #[inline(always)]
    pub(super) fn bend_between(&mut self, first: &Vec3<T>, last: &Vec3<T>) {
        if self.done == 0 {
            self.bend = *first;
        }
        if self.done + 1 == self.steps {
            self.bend -= last;
        }
    }

    /// `−ḣ` of wheels with these axes, mean over the present step and its change, for a change of their momenta.
    #[inline(always)]
    pub(super) fn slope_of_drive(
        &self,
        axes: &Mat<T, 3, W>,
        change: &Momenta<T, W>,
    ) -> [Vec3<T>; 2] {
        let bend = -(self.share + self.share) / self.duration_s;
        [axes * change * (-T::one() / self.step_s), axes * self.of_wheel[2] * bend]
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
        if U > WITHOUT_HARDWARE {
            self.beyond_change = g1 + g2;
        }
        [w0 * scale, w1 * scale, w2 * scale, g0 * scale, g1 * scale, g2 * scale]
    }

    /// Mean of each wheel's momentum over the present step, and its change.
    pub(super) fn wheels_in_step(&self) -> (Momenta<T, W>, Momenta<T, W>) {
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
#[cfg_attr(target_os = "none", inline(never))]
pub(super) fn product<'a, T: Real>(
    p: core::iter::Take<core::slice::Iter<'a, Vec3<T>>>,
    u: &[Vec3<T>],
) -> Vec3<T> {
    let mut products = p.rev().zip(u).map(|(p, u)| p.cross(u));
    let first = products.next().unwrap_or(Vec3::zeros());
    products.fold(first, |sum, product| sum + product)
}
