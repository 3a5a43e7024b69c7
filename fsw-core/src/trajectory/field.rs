//! Torque of a field that is fixed in inertial axes: `τ = μ × B`, the moment μ constant in body axes.
//!
//! With C the matrix that turns components in the body axes of the start into those of now, `Ċ = −ω × C`, and the field
//! B₀ in the axes of the start,
//!
//! ```text
//! τ = μ × C B₀ = Σₖ eₖ × C pₖ,    pₖ = μₖ B₀
//! ```
//!
//! is linear in the nine products `pₖⱼ = μₖ B₀ⱼ`: [`Group::Field`], over the trace, one group for each component of the
//! moment. For a moment and a field of any direction they are uncorrelated, of the variance σ² / 2 each where σ is that of
//! the torque about an axis. Torques linear in the attitude are sums of the same columns: the gravity gradient where the
//! body turns little, air.
//!
//! C follows the rate of the model at the point. An attitude of the readings contains their noise, by which a body that starts
//! at rest would seem to turn, and the columns of the products with it. C has no derivatives by the unknowns: the torque is
//! small, and a change of the point turns C by little. Its columns stand among the sensitivities, in the place of
//! [`Group::Axes`], which has no unknown.

use super::Trajectory;
use super::step::Crossing;
use super::unknowns::{Group, Point, may_hold_fields};
use crate::blocks::span::Span;
use crate::math::{Mat, Vec3, scalar::Real};

impl<T: Real, const W: usize, const U: usize, const M: usize> Trajectory<T, W, U, M> {
    /// True where the torque of a field is among the unknowns.
    pub fn has_field(&self) -> bool {
        may_hold_fields(U) && self.model.offset_of(Group::Axes).is_some()
    }

    /// C at the start.
    pub(super) fn start_axes(&mut self) {
        if may_hold_fields(U)
            && let Some(first) = self.model.offset_of(Group::Axes)
        {
            for i in 0..3 {
                if let Some(column) = self.sensitivity.get_mut(first + i) {
                    *column = unit(i);
                }
            }
        }
    }

    /// Turn of the body in half a block that it enters, rad, at the rate of its start.
    pub fn half_turn(&self, span: &Span<T, W>) -> Vec3<T> {
        let model = &self.model;
        let wheels = model.axes * span.drive_within(model.delay_s).wheels[0];
        model.rate_of(&self.momentum, &wheels) * (span.block.duration_s * T::lit(0.5))
    }

    /// Turn of the body in a block that is crossed, rad.
    pub fn turn_of(&self, crossing: &Crossing<T, W, U>) -> Vec3<T> {
        crossing.rate * (crossing.share * crossing.duration_s)
    }

    /// Turns C by an angle: by half a block before it, since the torque of the block is that of its middle, and by the rest
    /// of it afterwards.
    pub fn turn_axes(&mut self, turn: &Vec3<T>) {
        let Some(first) = self.model.offset_of(Group::Axes) else { return };
        for column in self.sensitivity.iter_mut().skip(first).take(3) {
            *column = turned(column, turn);
        }
    }

    /// Sets the torque of the model to that of a point at the present attitude.
    pub fn set_torque(&mut self, point: &Point<T, U>) {
        let Some(axes) = self.field_axes() else { return };
        let of = |group| match self.model.offset_of(group) {
            Some(first) => Vec3::from_fn(|i, _| point.value(first + i)),
            None => Vec3::zeros(),
        };
        let mut torque = of(Group::Torque);
        for k in 0..3 {
            torque += unit(k).cross(&(axes * of(Group::Field(k as u8))));
        }
        self.model.torque = torque;
    }

    /// C; none where no field is among the unknowns.
    fn field_axes(&self) -> Option<Mat<T, 3, 3>> {
        let first = self.model.offset_of(Group::Axes)?;
        let columns: &[Vec3<T>; 3] = self.sensitivity.get(first..)?.first_chunk()?;
        Some(Mat::from_columns(columns))
    }

    /// Torques of the three products of component k of the moment, by columns.
    pub(super) fn torque_of_field(&self, k: u8) -> [Vec3<T>; 3] {
        let Some(axes) = self.field_axes() else { return [Vec3::zeros(); 3] };
        [0, 1, 2].map(|j| unit(k.into()).cross(&crate::math::column(&axes, j)))
    }
}

fn unit<T: Real>(axis: usize) -> Vec3<T> {
    Vec3::from_fn(|i, _| if i == axis { T::one() } else { T::zero() })
}

/// Components of a fixed vector after a turn θ of the axes, of up to half a radian to 2e-4 of it.
///
/// Cayley's formula with `a = −θ/2 (1 + θ² / 12)`, for `tan θ/2`: exactly orthogonal.
fn turned<T: Real>(vector: &Vec3<T>, turn: &Vec3<T>) -> Vec3<T> {
    let one = T::one();
    let a = turn * (T::lit(-0.5) * (one + turn.dot(turn) * T::lit(1.0 / 12.0)));
    let across = a.cross(vector);
    vector + (across + a.cross(&across)) * (T::lit(2.0) / (one + a.dot(&a)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_turn_by_the_angle() {
        let turn = Vec3::<f64>::new(0.2, -0.3, 0.25);
        let vector = Vec3::<f64>::new(0.3, 0.5, -0.8);
        let exact = nalgebra::Rotation3::new(-turn) * vector;
        let found = turned(&vector, &turn);
        assert!((found - exact).norm() < 2e-4, "{found} {exact}");
        assert!((found.norm() - vector.norm()).abs() < 1e-15);
    }
}
