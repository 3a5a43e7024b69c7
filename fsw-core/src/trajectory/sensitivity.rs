//! Sensitivities of the momentum across a step: by inertia, torque, drag and hardware.

use super::step::Crossing;
use super::unknowns::{
    FIRST_GROUP, Group, MOMENTUM, by_shape, groups_of, may_hold_all_axes, may_hold_fields,
    scale_of, shape_of,
};
use super::{Trajectory, WITHOUT_HARDWARE, of_wheel};
use crate::math::{Entries, Mat, Vec3, column, rotated, scalar::Real, skew, times};

/// Effect of V, linear over a step, on a column of D: of its mean and of its change.
struct ByDrive<T: Real> {
    by_mean: Mat<T, 3, 3>,
    /// None where the step turns little.
    by_change: Option<Mat<T, 3, 3>>,
}

impl<T: Real> ByDrive<T> {
    /// Not inlined, as `rotated`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn of(&self, mean: &Vec3<T>, change: &Vec3<T>) -> Vec3<T> {
        let by_change = self.by_change.as_ref();
        let by_change = by_change.map_or(Vec3::zeros(), |by| rotated(by, change));
        rotated(&self.by_mean, mean) + by_change
    }

    /// Of `V = G(ω) B`, for the mean and the change of ω.
    fn of_shape(&self, mean: &Vec3<T>, change: &Vec3<T>) -> [Vec3<T>; 5] {
        let mut by = by_shape::<T, _>(&columns_of_the_regressor(&self.by_mean, mean));
        if let Some(by_change) = &self.by_change {
            let more = by_shape::<T, _>(&columns_of_the_regressor(by_change, change));
            for (by, more) in by.iter_mut().zip(&more) {
                *by += more;
            }
        }
        by
    }
}

/// Matrices that carry D across a step: to its end, and to twice its mean over the step.
struct Propagation<T: Real, const W: usize, const U: usize> {
    carry: Mat<T, 3, 3>,
    series: Mat<T, 3, 3>,
    by_drive: ByDrive<T>,
    /// None where the step turns little: the sum of both ends is twice the mean.
    twice_mean: Option<TwiceMean<T>>,
}

/// Derivatives of twice the mean of D over a step: by D at its begin, by V, and by the effect of an impulse at its end.
struct TwiceMean<T: Real> {
    carry: Mat<T, 3, 3>,
    by_drive: ByDrive<T>,
    by_end: Mat<T, 3, 3>,
}

/// Effect of a drive or an impulse on a column of D: on its value at the end of a step, and on twice its mean over the step.
#[derive(Clone, Copy)]
struct Push<T: Real> {
    end: Vec3<T>,
    mean: Vec3<T>,
}

impl<T: Real> Push<T> {
    fn nothing() -> Self {
        Self { end: Vec3::zeros(), mean: Vec3::zeros() }
    }
}

impl<T: Real> core::ops::Add for Push<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { end: self.end + other.end, mean: self.mean + other.mean }
    }
}

impl<T: Real> core::ops::Mul<T> for Push<T> {
    type Output = Self;
    fn mul(self, by: T) -> Self {
        Self { end: self.end * by, mean: self.mean * by }
    }
}

impl<T: Real, const W: usize, const U: usize> Propagation<T, W, U> {
    /// None also where the sum of both ends will do.
    #[inline(always)]
    fn twice_mean(&self) -> Option<&TwiceMean<T>> {
        self.twice_mean.as_ref().filter(|_| may_hold_all_axes(U, W))
    }

    /// Push of V.
    #[cfg_attr(target_os = "none", inline(never))]
    fn of_drive(&self, mean: &Vec3<T>, change: &Vec3<T>) -> Push<T> {
        let of_mean = |of: &TwiceMean<T>| of.by_drive.of(mean, change);
        Push {
            end: self.by_drive.of(mean, change),
            mean: self.twice_mean().map_or(Vec3::zeros(), of_mean),
        }
    }

    /// Push of an impulse that acts throughout the step.
    fn of_impulse(&self, impulse: &Vec3<T>) -> Push<T> {
        let end = rotated(&self.series, impulse);
        let of_mean = |of: &TwiceMean<T>| rotated(&of.by_end, &end);
        Push { end, mean: self.twice_mean().map_or(Vec3::zeros(), of_mean) }
    }

    /// Pushes of the five coordinates of the shape, for the mean and the change of ω.
    #[inline(always)]
    fn of_shape(&self, mean: &Vec3<T>, change: &Vec3<T>) -> [Push<T>; 5] {
        let end = self.by_drive.of_shape(mean, change);
        let of_mean = |of: &TwiceMean<T>| of.by_drive.of_shape(mean, change);
        let twice_mean = self.twice_mean().map_or([Vec3::zeros(); 5], of_mean);
        core::array::from_fn(|k| Push { end: end[k], mean: twice_mean[k] })
    }

    /// Carries a column of D, and adds twice its mean to a sum.
    #[cfg_attr(target_os = "none", inline(never))]
    fn carry_column(&self, push: &Push<T>, column: &mut Vec3<T>, sum: &mut Vec3<T>) {
        let before = *column;
        *column = rotated(&self.carry, &before) + push.end;
        *sum += match self.twice_mean() {
            Some(mean) => rotated(&mean.carry, &before) + push.mean,
            None => before + *column,
        };
    }
}

impl<T: Real, const W: usize, const U: usize, const M: usize> Trajectory<T, W, U, M> {
    /// Carries D across a step. With `K = Δ (p^× − c) n⁻¹` and `A = K − Δ ω^×`, both at their means, and
    /// their changes K', A', ω' and w' over the step,
    ///
    /// `X = A + (A' A − A A') / 12`,  `D₁ = D₀ + φ (X D₀ + F)`,  `φ = 1 + X/2 + X²/6 + X³/24 + X⁴/120`,
    ///
    /// `F = Δ E_d − Δ ω E_c + Δ τᵤ E_x − (K + (A' K − A K') / 12) V − (K' − A K) / 12 V'`,
    ///
    /// `V = G(ω) B E_q + (wᵤ − gᵤ) E_x`. Twice the mean, by the slopes of D at both ends (Hermite's rule), goes to a sum:
    ///
    /// `2 D̄ = D₀ + D₁ − (A (D₁ − D₀) + A' (D₀ + D₁) / 2 − K' V − K V') / 6`.
    ///
    /// A step of 0.3 rad errs by 1e-5, the mean by `turn⁴ / 720`, the same. Of torque and drag, small as they are, the means
    /// suffice.
    ///
    /// The sum of both ends alone errs by `turn² / 12`, in each column by another share of it. That is enough but for a turn
    /// of all axes, where gyro and wheels are among the unknowns: it has no effect, and would seem to have one.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn differentiate(&mut self, crossing: &mut Crossing<T, W, U>) {
        let step = self.propagation(crossing);
        let (w, duration_s) = (crossing.mean_rate, crossing.step_s);
        let sum = &mut crossing.sensitivity;
        for c in MOMENTUM..FIRST_GROUP {
            step.carry_column(&Push::nothing(), &mut self.sensitivity[c], &mut sum[c]);
        }
        for place in 0..groups_of(U) {
            let Some(group) = self.model.group[place] else { continue };
            let impulses = match group {
                Group::Field(component) if may_hold_fields(U) => {
                    self.torque_of_field(component).map(|torque| torque * duration_s)
                }
                Group::Torque => along_each_axis(&Vec3::repeat(duration_s)),
                Group::Drag => along_each_axis(&(w * -duration_s)),
                _ => continue,
            };
            for (c, impulse) in (FIRST_GROUP + 3 * place..).zip(&impulses) {
                let push = step.of_impulse(impulse);
                step.carry_column(&push, &mut self.sensitivity[c], &mut sum[c]);
            }
        }
        if U > WITHOUT_HARDWARE {
            self.differentiate_by_hardware(crossing, &step);
        }
        self.differentiate_by_inertia(crossing, &step);
        crossing.done += 1;
    }

    /// Columns of shape and scale across a step.
    #[inline(always)]
    fn differentiate_by_inertia(
        &mut self,
        crossing: &mut Crossing<T, W, U>,
        step: &Propagation<T, W, U>,
    ) {
        let (w, duration_s) = (crossing.mean_rate, crossing.step_s);
        let sum = &mut crossing.sensitivity;
        let mut put = |c: usize, push: &Push<T>| {
            step.carry_column(push, &mut self.sensitivity[c], &mut sum[c]);
        };
        for (k, push) in step.of_shape(&w, &crossing.rate_change).iter().enumerate() {
            put(shape_of(U) + k, push);
        }
        let torque = crossing.known_torque + crossing.mean_beyond.cross(&w);
        let by_drive = step.of_drive(&crossing.mean_drive, &crossing.drive_change);
        put(scale_of(U), &(by_drive + step.of_impulse(&(torque * duration_s))));
    }

    /// Columns of gyro, wheels, time offset and torque across a step, as in
    /// [`differentiate`](Self::differentiate): those of the gyro do not move the body.
    ///
    /// Momentum δh that the wheels have beyond the assumed one adds `V = x δh`: `x hᵢ aᵢ` per share of a spin inertia,
    /// `x hᵢ eⱼ` per angle of a tilt, `−x ḣ` per second of the time offset. A share of the known torque pushes like
    /// that torque.
    #[cfg_attr(target_os = "none", inline(never))]
    fn differentiate_by_hardware(
        &mut self,
        crossing: &mut Crossing<T, W, U>,
        step: &Propagation<T, W, U>,
    ) {
        let x = self.model.scale;
        let (mean, change) = crossing.wheels_in_step();
        let pushed_by = |mean: Vec3<T>, change: Vec3<T>| step.of_drive(&mean, &change) * x;
        for place in 0..groups_of(U) {
            let pushes = match self.model.group[place] {
                Some(Group::Wheel(wheel)) => {
                    let (mean, change) = (of_wheel(&mean, wheel), of_wheel(&change, wheel));
                    self.model.by_errors_of_wheel(wheel).map(|e| pushed_by(e * mean, e * change))
                }
                Some(Group::Common) => {
                    let [slope, bend] = crossing.slope_of_drive(&self.model.axes, &change);
                    let [mean, change] =
                        [&mean, &change].map(|momenta| self.model.by_common_error(momenta));
                    let common = pushed_by(mean, change);
                    // The same sums as of the scale: without wheels both columns are proportional to rounding.
                    let torque =
                        crossing.known_torque + crossing.mean_beyond.cross(&crossing.mean_rate);
                    let of_beyond = step.of_drive(&-crossing.mean_beyond, &-crossing.beyond_change);
                    let by_torque = of_beyond + step.of_impulse(&(torque * crossing.step_s));
                    [pushed_by(slope, bend), by_torque * (x / self.model.torque_share), common]
                }
                _ => continue,
            };
            for (i, push) in pushes.iter().enumerate() {
                let c = FIRST_GROUP + 3 * place + i;
                if self.model.is_active(place, i) {
                    step.carry_column(push, &mut self.sensitivity[c], &mut crossing.sensitivity[c]);
                }
            }
        }
    }

    /// Matrices of a step of D.
    fn propagation(&self, crossing: &Crossing<T, W, U>) -> Propagation<T, W, U> {
        let one = Mat::<T, 3, 3>::identity();
        let by_momentum = self.model.inverse * crossing.step_s;
        let mut k = across(&crossing.mean, &by_momentum);
        for i in 0..3 {
            for c in 0..3 {
                *k.at_mut(i, c) -= self.model.drag.at(i, 0) * by_momentum.at(i, c);
            }
        }
        let a = k - skew(&(crossing.mean_rate * crossing.step_s));
        // A' / 12 and K' / 12.
        let changes = (!crossing.is_slow).then(|| {
            let twelfth = T::lit(1.0 / 12.0);
            let k_change = across(&(crossing.change * twelfth), &by_momentum);
            let rate_change = crossing.rate_change * (crossing.step_s * twelfth);
            (k_change - skew(&rate_change), k_change)
        });
        let (mut x, mut by_mean, mut by_change) = (a, k, None);
        if let Some((a_change, k_change)) = &changes {
            x += times(a_change, &a) - times(&a, a_change);
            by_mean += times(a_change, &k) - times(&a, k_change);
            by_change = Some(times(&a, &k) * T::lit(1.0 / 12.0) - k_change);
        }
        let fourth = one * T::lit(1.0 / 24.0) + x * T::lit(1.0 / 120.0);
        let third = one * T::lit(1.0 / 6.0) + times(&x, &fourth);
        let series = one + times(&x, &(one * T::lit(0.5) + times(&x, &third)));
        let carry = one + times(&series, &x);
        let by_mean = times(&series, &-by_mean);
        let by_change = by_change.map(|by| times(&series, &by));
        let changes = changes.filter(|_| may_hold_all_axes(U, W));
        let twice_mean = changes.map(|(a_change, k_change)| {
            let sixth = T::lit(1.0 / 6.0);
            let by_begin = one - a_change + a * sixth;
            let by_end = one - a_change - a * sixth;
            TwiceMean {
                carry: by_begin + times(&by_end, &carry),
                by_drive: ByDrive {
                    by_mean: times(&by_end, &by_mean) + k_change + k_change,
                    by_change: by_change.map(|by| times(&by_end, &by) + k * sixth),
                },
                by_end,
            }
        });
        Propagation { carry, series, by_drive: ByDrive { by_mean, by_change }, twice_mean }
    }

    /// Effect of a change of the momentum now on that at the start of the window; none where the numbers leave their range.
    pub fn back_to_start(&self) -> Option<BackToStart<T>> {
        let [a, b, c] = *self.sensitivity.get(MOMENTUM..)?.first_chunk()?;
        let (by_a, by_b, by_c) = (b.cross(&c), c.cross(&a), a.cross(&b));
        let one_over = T::one() / a.dot(&by_a);
        one_over.is_finite().then_some(BackToStart { rows: [by_a, by_b, by_c], one_over })
    }

    /// `∂m/∂θ` of an unknown at constant momentum h of the body. For the scale it is `∂m/∂x − m/x`, since `m = κ h` is in
    /// proportion to x.
    pub fn push_of(&self, index: usize) -> Vec3<T> {
        let by = self.sensitivity.get(index).copied().unwrap_or(Vec3::zeros());
        if index == scale_of(U) { by - self.momentum / self.model.scale } else { by }
    }
}

/// `(∂m/∂m₀)⁻¹`: change of the momentum at the start of the window that makes a change of the momentum now.
pub struct BackToStart<T: Real> {
    /// Rows of the inverse times the determinant, and one over that.
    rows: [Vec3<T>; 3],
    one_over: T,
}

impl<T: Real> BackToStart<T> {
    /// Momentum at the start for this one now.
    pub fn of(&self, now: &Vec3<T>) -> Vec3<T> {
        let [a, b, c] = &self.rows;
        Vec3::new(a.dot(now), b.dot(now), c.dot(now)) * self.one_over
    }
}

/// Each component along its axis.
fn along_each_axis<T: Real>(by: &Vec3<T>) -> [Vec3<T>; 3] {
    let none = T::zero();
    [Vec3::new(by.x, none, none), Vec3::new(none, by.y, none), Vec3::new(none, none, by.z)]
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
