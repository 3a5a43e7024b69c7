//! Unknowns of a fit: the table of their groups, their places in the factor, a point in their space.
//!
//! | place | group | symbol | unit |
//! |---|---|---|---|
//! | 0 to 2 | momentum at the start of the window over the trace | `m₀` | rad/s |
//! | 3 to U − 7 | further groups of three, as far as U holds them | | |
//! | | disturbance torque over the trace | `d` | rad/s² |
//! | | gyro bias | `b` | rad/s |
//! | | drag, over the trace: torque `−c ω` on each axis | `c` | 1/s |
//! | U − 6 to U − 2 | shape | `q` | – |
//! | U − 1 | inverse of the trace over its unit, `κ / κᵤ` | `x` | – |
//!
//! Shape and scale come last: the last six rows of a triangular factor are then the information on
//! the inertia alone, with all other unknowns eliminated.
//!
//! # Shape and scale
//!
//! `J = (S + Σₖ qₖ Bₖ) / κ` with S a sphere of unit trace, `κ = 1 / tr(J)`, and five matrices Bₖ without
//! trace, orthonormal in the Frobenius norm. Motion depends on κ only through wheel momentum and known
//! torque: without them the sensitivity to the scale is zero in every bit, and no rounding of six
//! large columns can suggest that the scale was observed.

use crate::math::{Vec3, scalar::Real};

/// Place of the momentum.
pub const MOMENTUM: usize = 0;
/// Place of the first further group.
pub const FIRST_GROUP: usize = 3;
/// Further groups at most.
pub const GROUPS: usize = 3;

/// A group of three unknowns beside momentum and inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Constant disturbance torque, body axes.
    Torque,
    /// Constant gyro bias.
    Bias,
    /// Torque proportional to the rate about each axis.
    Drag,
}

crate::persist!([] enum Group { 0 => Torque, 1 => Bias, 2 => Drag });

/// Number of further groups that U unknowns hold.
pub const fn groups_of(unknowns: usize) -> usize {
    let groups = unknowns.saturating_sub(9) / 3;
    if groups < GROUPS { groups } else { GROUPS }
}

/// True for the supported numbers of unknowns.
pub const fn is_a_set(unknowns: usize) -> bool {
    matches!(unknowns, 9 | 12 | 15 | 18)
}

/// Place of the shape.
pub const fn shape_of(unknowns: usize) -> usize {
    unknowns - 6
}

/// Place of the scale.
pub const fn scale_of(unknowns: usize) -> usize {
    unknowns - 1
}

/// Belief in a group before the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Belief<T: Real> {
    /// Zero mean and this sigma, in the group's physical unit: N m, rad/s, 1/s.
    Within(T),
    /// Zero, and tested: the data's contradiction is a statistic of three degrees of freedom.
    Zero,
}

crate::persist!([T: Real] enum Belief<T> { 0 => Within(sigma: T), 1 => Zero });

/// Groups in use, by place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Groups<T: Real> {
    /// Group in each place and the belief in it.
    pub place: [Option<(Group, Belief<T>)>; GROUPS],
}

crate::persist!([T: Real] Groups<T> { place });

impl<T: Real> Groups<T> {
    /// True if the group in this place, if any, is `group`.
    pub fn is_at(&self, place: usize, group: Group) -> bool {
        self.place.get(place).is_some_and(|at| at.is_some_and(|(g, _)| g == group))
    }
}

/// Element of a trace-free basis of the shape: `√½`.
const ROOT_HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// `√⅙`.
const ROOT_SIXTH: f64 = 0.408_248_290_463_863;

/// Values of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T: Real> {
    /// `m₀`, rad/s.
    pub momentum: Vec3<T>,
    /// Further groups by place.
    pub group: [Vec3<T>; GROUPS],
    /// `q`.
    pub shape: [T; 5],
    /// `x = κ / κᵤ`, positive.
    pub scale: T,
}

crate::persist!([T: Real] Point<T> { momentum, group, shape, scale });

impl<T: Real> Point<T> {
    /// Momentum of a sphere of unit scale.
    pub fn sphere(momentum: Vec3<T>) -> Self {
        let group = [Vec3::zeros(); GROUPS];
        Self { momentum, group, shape: [T::zero(); 5], scale: T::one() }
    }

    /// Elements `n` of the tensor over its trace.
    pub fn over_trace(&self) -> [T; 6] {
        let third = T::lit(1.0 / 3.0);
        let mut n = of_shape(&self.shape);
        for moment in n.iter_mut().take(3) {
            *moment += third;
        }
        n
    }

    /// Value of a further group; zero where it is not in use.
    pub fn value(&self, groups: &Groups<T>, group: Group) -> Vec3<T> {
        match (0..GROUPS).find(|place| groups.is_at(*place, group)) {
            Some(place) => self.group.get(place).copied().unwrap_or(Vec3::zeros()),
            None => Vec3::zeros(),
        }
    }

    /// The point after a step of all unknowns but the momentum. The scale changes by a factor of
    /// five at most, so that it stays positive.
    pub fn stepped<const U: usize>(&self, step: &[T; U]) -> Self {
        let mut next = *self;
        for (place, group) in next.group.iter_mut().enumerate().take(groups_of(U)) {
            let at = FIRST_GROUP + 3 * place;
            *group += Vec3::new(step[at], step[at + 1], step[at + 2]);
        }
        for (k, q) in next.shape.iter_mut().enumerate() {
            *q += step[shape_of(U) + k];
        }
        let five = T::lit(5.0);
        let scale = self.scale + step[scale_of(U)];
        next.scale = scale.max(self.scale / five).min(self.scale * five);
        next
    }
}

/// Six elements of `Σ qₖ Bₖ`.
pub fn of_shape<T: Real>(q: &[T; 5]) -> [T; 6] {
    let (a, b) = (T::lit(ROOT_HALF), T::lit(ROOT_SIXTH));
    let [q0, q1, q2, q3, q4] = *q;
    [a * q0 + b * q1, b * q1 - a * q0, -(b + b) * q1, a * q2, a * q3, a * q4]
}

/// Shape of six elements over their trace: the inverse of [`of_shape`], blind to the trace.
pub fn to_shape<T: Real>(n: &[T; 6]) -> [T; 5] {
    let (a, b, two) = (T::lit(ROOT_HALF), T::lit(ROOT_SIXTH), T::lit(2.0));
    let [xx, yy, zz, xy, xz, yz] = *n;
    [a * (xx - yy), b * (xx + yy - two * zz), a * two * xy, a * two * xz, a * two * yz]
}

/// Derivatives by the shape from those by the six elements, for any sum linear in both.
pub fn by_shape<T: Real, V>(by_element: &[V; 6]) -> [V; 5]
where
    V: Copy
        + core::ops::Add<Output = V>
        + core::ops::Sub<Output = V>
        + core::ops::Mul<T, Output = V>,
{
    let (a, b) = (T::lit(ROOT_HALF), T::lit(ROOT_SIXTH));
    let [xx, yy, zz, xy, xz, yz] = *by_element;
    [(xx - yy) * a, (xx + yy) * b - zz * (b + b), xy * a, xz * a, yz * a]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Both directions, and the derivative against the linear form itself.
        #[test]
        fn shape_and_elements_are_inverse(q in prop::array::uniform5(-0.3..0.3f64), d in prop::array::uniform6(-1.0..1.0f64)) {
            let n = of_shape(&q);
            prop_assert!((n[0] + n[1] + n[2]).abs() < 1e-15);
            let again = to_shape(&n);
            let by = by_shape::<f64, f64>(&d);
            let (mut sum, mut direct) = (0.0, 0.0);
            for k in 0..5 {
                prop_assert!((again[k] - q[k]).abs() < 1e-14);
                sum += by[k] * q[k];
            }
            for i in 0..6 {
                direct += d[i] * n[i];
            }
            prop_assert!((sum - direct).abs() < 1e-14);
        }
    }

    /// Frobenius norm of a shape equals the norm of q.
    #[test]
    fn the_basis_is_orthonormal() {
        for k in 0..5 {
            let mut q = [0.0; 5];
            q[k] = 1.0;
            let [xx, yy, zz, xy, xz, yz]: [f64; 6] = of_shape(&q);
            let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
            assert!((square - 1.0).abs() < 1e-12);
        }
    }
}
