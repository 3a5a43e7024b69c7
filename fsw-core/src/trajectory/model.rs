//! Model of the motion and of the reading at one point of the unknowns.

use super::WITHOUT_HARDWARE;
use super::modes::{Oscillator, of_body};
use super::unknowns::{FIRST_GROUP, GROUPS, Group, Groups, Point};
use crate::dynamics::wheels::Momenta;
use crate::hardware::axes_with_errors;
use crate::math::{Mat, Vec3, scalar::Real};

/// Model of the motion at one point of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T: Real, const W: usize, const M: usize> {
    /// n⁻¹, and (1 + M) n⁻¹; n without the modal inertias where there are modes.
    pub(super) inverse: Mat<T, 3, 3>,
    pub(super) reading: Mat<T, 3, 3>,
    pub(super) modes: [Oscillator<T>; M],
    /// Wheel axes by columns: as configured, and at the point.
    pub(super) configured_axes: Mat<T, 3, W>,
    pub(super) axes: Mat<T, 3, W>,
    /// δ, s, and 1 + t.
    pub(super) delay_s: T,
    pub(super) torque_share: T,
    pub(super) torque: Vec3<T>,
    pub(super) bias: Vec3<T>,
    pub(super) drag: Vec3<T>,
    pub(super) scale: T,
    /// Further group of unknowns in each place, and a bit for each component that is an unknown.
    pub(super) group: [Option<Group>; GROUPS],
    pub(super) active: [u8; GROUPS],
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
    pub(super) fn add_hardware<const U: usize>(&mut self, point: &Point<T, U>, groups: &Groups<T>) {
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

    pub(super) fn rate_of(&self, momentum: &Vec3<T>, drive: &Vec3<T>) -> Vec3<T> {
        self.inverse * (momentum - drive * self.scale)
    }

    /// Reading at such a body, bias included, rad/s.
    pub fn reading_rad_s(&self, momentum: &Vec3<T>, wheels: &Momenta<T, W>) -> Vec3<T> {
        let reading = self.at_rest(&self.reading);
        reading * (momentum - self.axes * wheels * self.scale) + self.bias
    }

    pub(super) fn reading_of(&self, momentum: &Vec3<T>, drive: &Vec3<T>) -> Vec3<T> {
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
