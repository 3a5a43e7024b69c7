//! Mean reading of a block and its derivatives by the unknowns, directly and by the motion.

use super::model::Model;
use super::step::Crossing;
use super::unknowns::{FIRST_GROUP, Group, MOMENTUM, by_shape, groups_of, scale_of, shape_of};
use super::{Trajectory, WITHOUT_HARDWARE, of_wheel};
use crate::dynamics::wheels::Momenta;
use crate::hardware::tilt_directions;
use crate::math::{Entries, Mat, Vec3, column, norm, scalar::Real};

impl<T: Real, const W: usize, const U: usize, const M: usize> Trajectory<T, W, U, M> {
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
    /// `S̄ = n⁻¹ (D̄ − V̄)`, with D̄ the mean of both ends of each step and V̄ at the means of rate and drive: these may swing
    /// within a block, and the mean of the ends of a sine over a third of its period is 0.6 of its mean.
    pub fn mean_sensitivity(&self, crossing: &Crossing<T, W, U>, axis: usize) -> [T; U] {
        let axis = axis.min(2);
        let b = Vec3::from_fn(|k, _| self.model.reading[(axis, k)]);
        let a = b * (T::lit(0.5) * crossing.share);
        let rate = crossing.rate * crossing.share;
        let mut row = [T::zero(); U];
        for c in 0..U {
            row[c] = a.dot(&crossing.sensitivity[c]);
        }
        self.model.add_readings(&mut row, axis, &b, &rate, &crossing.drive);
        if U > WITHOUT_HARDWARE {
            let slope = crossing.of_wheel[1] + crossing.of_wheel[2];
            let slope = self.model.axes * slope * (T::one() / crossing.duration_s);
            self.model.add_drives(&mut row, &b, &crossing.wheel_mean, &slope, &crossing.beyond);
            self.model.add_gyro(&mut row, axis, &rate);
        }
        if M > 0 {
            self.add_modes(&mut row, &(b * crossing.share));
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

    /// Derivatives of a wheel's axis `(1 + s + sᵢ) u` by its errors, with `u = t / |t|` for `t = a + θ₁ e₁ + θ₂ e₂`: u by
    /// the share, and `(1 + s + sᵢ) / |t| (eⱼ − u (u · eⱼ))` by a tilt. Since a is normal to both e, `1 / |t| = u · a`.
    ///
    /// They are those at the point, as all others: derivatives of several points would show what no motion shows, such as a
    /// common factor of wheels and body.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn by_errors_of_wheel(&self, wheel: u8) -> [Vec3<T>; 3] {
        let configured = column(&self.configured_axes, usize::from(wheel));
        let axis = column(&self.axes, usize::from(wheel));
        let share = norm(&axis);
        let unit = axis * (T::one() / share);
        let by_tilt = share * unit.dot(&configured);
        let [first, second] =
            tilt_directions(&configured).map(|e| (e - unit * unit.dot(&e)) * by_tilt);
        [unit, first, second]
    }

    /// Derivative of the wheels' momentum by a common error of their spin inertias: the sum along unit vectors.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn by_common_error(&self, momenta: &Momenta<T, W>) -> Vec3<T> {
        let mut sum = Vec3::zeros();
        for i in 0..W {
            let axis = column(&self.axes, i);
            sum += axis * (of_wheel(momenta, i as u8) / norm(&axis));
        }
        sum
    }

    /// Adds the direct derivatives by wheels and time offset, `−b V`, for momentum of the wheels, its slope,
    /// rad/s², and the impulse beyond a ramp.
    #[cfg_attr(target_os = "none", inline(never))]
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
                    self.by_errors_of_wheel(wheel).map(|e| -b.dot(&e) * h)
                }
                Some(Group::Common) => {
                    let common = -b.dot(&self.by_common_error(wheels)) * self.scale;
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
    #[cfg_attr(target_os = "none", inline(never))]
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
