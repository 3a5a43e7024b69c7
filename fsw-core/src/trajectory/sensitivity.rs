//! Sensitivities of the momentum across a step: by inertia, torque, drag and hardware.

use super::step::Crossing;
use super::unknowns::{
    FIRST_GROUP, Group, MOMENTUM, by_shape, groups_of, may_hold_fields, scale_of, shape_of,
};
use super::{Trajectory, WITHOUT_HARDWARE, of_wheel};
use crate::math::{Entries, Mat, Vec3, column, rotated, scalar::Real, skew, times};

/// Matrices that carry D across a step.
struct Propagation<T: Real> {
    carry: Mat<T, 3, 3>,
    series: Mat<T, 3, 3>,
    /// φ times the factor of V and that of V'; none where the step turns little.
    by_drive: Mat<T, 3, 3>,
    by_drive_change: Option<Mat<T, 3, 3>>,
}

impl<T: Real> Propagation<T> {
    /// Effect of V and V' on the momentum. Not inlined, as `rotated`.
    #[cfg_attr(target_os = "none", inline(never))]
    fn of_drive(&self, mean: &Vec3<T>, change: &Vec3<T>) -> Vec3<T> {
        let by = self.by_drive_change.as_ref();
        let by_change = by.map_or(Vec3::zeros(), |by| rotated(by, change));
        rotated(&self.by_drive, mean) + by_change
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
    /// `V = G(ω) B E_q + (wᵤ − gᵤ) E_x`, and adds D₀ + D₁ to a sum. A step of 0.3 rad errs by 1e-5. Of
    /// torque and drag, small as they are, the means suffice.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn differentiate(&mut self, crossing: &mut Crossing<T, W, U>) {
        let step = self.propagation(crossing);
        let Propagation { carry, series, .. } = &step;
        let (w, duration_s) = (crossing.mean_rate, crossing.step_s);
        let sum = &mut crossing.sensitivity;
        let mut put = |column: &mut Vec3<T>, c: usize, pushed: Vec3<T>| {
            carry_column(carry, &pushed, column, &mut sum[c]);
        };
        for c in 0..3 {
            put(&mut self.sensitivity[MOMENTUM + c], MOMENTUM + c, Vec3::zeros());
        }
        for place in 0..groups_of(U) {
            let Some(group) = self.model.group[place] else { continue };
            if may_hold_fields(U)
                && let Group::Field(component) = group
            {
                for (i, torque) in self.torque_of_field(component).iter().enumerate() {
                    let c = FIRST_GROUP + 3 * place + i;
                    put(&mut self.sensitivity[c], c, series * (torque * duration_s));
                }
                continue;
            }
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
        step: &Propagation<T>,
    ) {
        let Propagation { carry, series, by_drive, by_drive_change } = step;
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
        step: &Propagation<T>,
    ) {
        let Propagation { carry, series, by_drive, by_drive_change } = step;
        let x = self.model.scale;
        let (mean, change) = crossing.wheels_in_step();
        let pushed_by = |mean: Vec3<T>, change: Vec3<T>| step.of_drive(&mean, &change) * x;
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

/// Carries a column of D, and adds both of its ends to a sum.
#[cfg_attr(target_os = "none", inline(never))]
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
