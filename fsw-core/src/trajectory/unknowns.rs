//! Unknowns of a fit: the table of their groups, their places in the factor, a point in their space.
//!
//! | place | group | symbol | unit |
//! |---|---|---|---|
//! | 0 to 2 | momentum at the start of the window over the trace | `m₀` | rad/s |
//! | 3 to U − 7 | further groups of three, as far as U holds them | | |
//! | | disturbance torque over the trace | `d` | rad/s² |
//! | | moment times field, about each body axis (module `field`) | `p₁`; `p₂`; `p₃` | rad/s² |
//! | | attitude: a group without unknowns | `C` | – |
//! | | gyro bias | `b` | rad/s |
//! | | drag, over the trace: torque `−c ω` on each axis | `c` | 1/s |
//! | | modal inertia of an appendage or a liquid, over the trace: moments; products | `μ_xx μ_yy μ_zz`; `μ_xy μ_xz μ_yz` | – |
//! | | its frequency and damping: errors of the stated ones (module `modes`) | `f z` | share |
//! | | time offset, error of the known torque, common error of the wheels | `δ t s` | s, share |
//! | | gyro scale factor error, about each axis | `M_xx M_yy M_zz` | share |
//! | | gyro axes, upper: reading x of a rate about y, x of z, y of z | `M_xy M_xz M_yz` | rad |
//! | | gyro axes, lower: reading y of a rate about x, z of x, z of y | `M_yx M_zx M_zy` | rad |
//! | | wheel i: error of its spin inertia, tilts of its axis | `s θ₁ θ₂` | share, rad |
//! | U − 6 to U − 2 | shape | `q` | – |
//! | U − 1 | inverse of the trace over its unit, `κ / κᵤ` | `x` | – |
//!
//! The groups down to frequency and damping belong to one window, the others to the hardware, and last from window to window
//! like the inertia ([`hardware`](crate::hardware)). Where U is too small for all of the hardware, the last place before the
//! shape stays free, for those that are considered (module `considered` of the window).
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

use core::ops::Range;

use crate::hardware::Parameter;
use crate::math::{Vec3, scalar::Real};

/// Place of the momentum.
pub const MOMENTUM: usize = 0;
/// Place of the first further group.
pub const FIRST_GROUP: usize = 3;
/// Stated modes at most.
pub const MOST_MODES: usize = 2;
/// Groups of a mode.
pub const GROUPS_OF_MODE: usize = 3;
/// Further groups at most: torque, bias, drag, those of the modes, four of gyro and clock, eight wheels.
pub const GROUPS: usize = 15 + GROUPS_OF_MODE * MOST_MODES;
/// Smallest sigma of the clock's rate that correlates parameters, share: its effect on a tensor is below the rounding of
/// single precision, and the square of a smaller one leaves the range of `f32`.
const LEAST_CLOCK: f64 = 1e-9;
/// Sigma of an unknown beside its part by the clock, over that part, at least.
const LEAST_BESIDE_CLOCK: f64 = 1e-3;
/// Unknowns at most.
pub const MOST_UNKNOWNS: usize = 9 + 3 * GROUPS;

/// A group of three unknowns beside momentum and inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Constant disturbance torque, body axes.
    Torque,
    /// Constant gyro bias.
    Bias,
    /// Torque proportional to the rate about each axis.
    Drag,
    /// Scale factor errors of the gyro.
    GyroScale,
    /// Errors of the gyro's axes above the diagonal.
    GyroUpper,
    /// Those below it.
    GyroLower,
    /// Errors of spin inertia and axis of a wheel.
    Wheel(u8),
    /// Time offset of the gyro, error of the known torque, common error of the spin inertias.
    Common,
    /// Moments of the modal inertia of a mode, over the trace.
    ModalMoments(u8),
    /// Products of it.
    ModalProducts(u8),
    /// Errors of frequency and damping of a mode.
    ModeTuning(u8),
    /// Component of a moment that is constant in body axes, times a field that is constant in inertial ones.
    Field(u8),
    /// No unknowns: inertial axes in those of the body, of the torque of a field.
    Axes,
}

crate::persist!([] enum Group {
    0 => Torque, 1 => Bias, 2 => Drag, 3 => GyroScale, 4 => GyroUpper, 5 => GyroLower, 6 => Wheel(wheel: u8), 7 => Common,
    8 => ModalMoments(mode: u8), 9 => ModalProducts(mode: u8), 10 => ModeTuning(mode: u8),
    11 => Field(component: u8), 12 => Axes
});

impl Group {
    /// Parameter of the hardware that a component of the group is.
    pub fn parameter(self, component: usize) -> Option<Parameter> {
        let first = component.min(2) as u8;
        match self {
            Self::GyroScale => Some(Parameter::GyroScale(first)),
            Self::GyroUpper => {
                [(0, 1), (0, 2), (1, 2)].get(component).map(|(i, k)| Parameter::GyroAxes(*i, *k))
            }
            Self::GyroLower => {
                [(1, 0), (2, 0), (2, 1)].get(component).map(|(i, k)| Parameter::GyroAxes(*i, *k))
            }
            Self::Wheel(wheel) if component == 0 => Some(Parameter::WheelInertia(wheel)),
            Self::Wheel(wheel) => Some(Parameter::WheelAxis(wheel, first - 1)),
            Self::Common => {
                [Parameter::Delay, Parameter::TorqueScale, Parameter::CommonWheelInertia]
                    .get(component)
                    .copied()
            }
            Self::ModalMoments(mode) => Some(Parameter::ModalInertia(mode, first)),
            Self::ModalProducts(mode) => Some(Parameter::ModalInertia(mode, 3 + first)),
            Self::ModeTuning(mode) => {
                [Parameter::ModeFrequency(mode), Parameter::ModeDamping(mode)]
                    .get(component)
                    .copied()
            }
            Self::Torque | Self::Bias | Self::Drag | Self::Field(_) | Self::Axes => None,
        }
    }

    /// True for a group of a mode.
    pub fn is_of_mode(self) -> bool {
        matches!(self, Self::ModalMoments(_) | Self::ModalProducts(_) | Self::ModeTuning(_))
    }
}

/// Groups of the gyro's errors: scale factors, axes above the diagonal and below it.
const GROUPS_OF_GYRO: usize = 3;
/// Groups of the torque of a field.
pub const GROUPS_OF_FIELD: usize = 4;

/// True where U unknowns can hold the torque of a field, a constant one, and a bias or drag.
pub const fn may_hold_fields(unknowns: usize) -> bool {
    groups_of(unknowns) > GROUPS_OF_FIELD + 1
}

/// True where U unknowns can hold all errors of gyro and wheels: then a turn of all axes is among their directions.
pub const fn may_hold_all_axes(unknowns: usize, wheels: usize) -> bool {
    groups_of(unknowns) >= GROUPS_OF_GYRO + wheels
}

/// Number of further groups that U unknowns hold.
pub const fn groups_of(unknowns: usize) -> usize {
    let groups = unknowns.saturating_sub(9) / 3;
    if groups < GROUPS { groups } else { GROUPS }
}

/// True for the supported numbers of unknowns.
pub const fn is_a_set(unknowns: usize) -> bool {
    unknowns >= 9 && unknowns <= MOST_UNKNOWNS && unknowns.is_multiple_of(3)
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
    /// Zero mean and these sigmas, in the group's physical unit. A component with the sigma zero is not an
    /// unknown.
    Within([T; 3]),
    /// Zero, and tested: the data's contradiction is a statistic of three degrees of freedom.
    Zero,
}

crate::persist!([T: Real] enum Belief<T> { 0 => Within(sigma: [T; 3]), 1 => Zero });

/// Groups in use, by place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Groups<T: Real> {
    /// Group in each place and the belief in it.
    pub place: [Option<(Group, Belief<T>)>; GROUPS],
    /// First place of the hardware: the groups before it belong to one window.
    pub hardware: usize,
    /// Known time offset of the gyro, s.
    pub delay_s: T,
    /// One sigma of the clock's rate, share, part of the sigmas of [`Parameter::by_clock`].
    pub clock: T,
    /// Stated undamped frequency, rad/s, and damping ratio of each mode; zero for none.
    pub modes: [[T; 2]; MOST_MODES],
}

crate::persist!([T: Real] Groups<T> { place, hardware, delay_s, clock, modes } if |this| this.hardware <= GROUPS);

impl<T: Real> Groups<T> {
    /// No groups.
    #[inline(always)] // built in its place
    pub fn none() -> Self {
        Self {
            place: const { [None; GROUPS] },
            hardware: GROUPS,
            delay_s: T::zero(),
            clock: T::zero(),
            modes: [[T::zero(); 2]; MOST_MODES],
        }
    }

    /// True if the group in this place, if any, is `group`.
    pub fn is_at(&self, place: usize, group: Group) -> bool {
        self.place.get(place).is_some_and(|at| at.is_some_and(|(g, _)| g == group))
    }

    /// True where a component of the group in this place is an unknown.
    pub fn is_active(&self, place: usize, component: usize) -> bool {
        match self.place.get(place) {
            Some(Some((_, Belief::Within(sigma)))) => {
                sigma.get(component).is_some_and(|sigma| *sigma > T::zero())
            }
            Some(Some((_, Belief::Zero))) => true,
            _ => false,
        }
    }

    /// Error of the clock as part of an unknown in these places, by column: its value by an error of one, and the
    /// variance of the rest. None where it has no part.
    pub fn by_clock(&self, column: usize, places: &Range<usize>) -> Option<(T, T)> {
        let (place, component) = (column.checked_sub(FIRST_GROUP)? / 3, column % 3);
        if self.clock < T::lit(LEAST_CLOCK)
            || !places.contains(&place)
            || !self.is_active(place, component)
        {
            return None;
        }
        let Some(Some((group, Belief::Within(sigma)))) = self.place.get(place) else { return None };
        let by = T::lit(group.parameter(component)?.by_clock());
        let (sigma, of_clock) = (*sigma.get(component)?, by * self.clock);
        // The clock alone leaves no variance, and a weight has to be finite.
        let least = of_clock * T::lit(LEAST_BESIDE_CLOCK);
        let rest = (sigma * sigma - of_clock * of_clock).max(least * least);
        (by != T::zero()).then_some((by, rest))
    }

    /// Sigma of an unknown of the hardware or of a mode before the data; none for the others.
    pub fn sigma(&self, column: usize) -> Option<T> {
        let place = column.checked_sub(FIRST_GROUP)? / 3;
        match self.place.get(place) {
            Some(Some((group, Belief::Within(sigma))))
                if place >= self.hardware || group.is_of_mode() =>
            {
                sigma.get(column % 3).copied().filter(|sigma| *sigma > T::zero())
            }
            _ => None,
        }
    }

    /// Calls `visit` with each of U unknowns that is a share of what drives the body: errors of spin inertias and of the known
    /// torque.
    #[inline(always)]
    pub fn each_share_of_drive<const U: usize>(&self, mut visit: impl FnMut(usize)) {
        for place in self.hardware..groups_of(U) {
            let components = match self.place.get(place) {
                Some(Some((Group::Wheel(_), _))) => 0..1,
                Some(Some((Group::Common, _))) => 1..3,
                _ => continue,
            };
            components.for_each(|component| visit(FIRST_GROUP + 3 * place + component));
        }
    }

    /// Bits of the components that are unknowns.
    pub fn active_bits(&self, place: usize) -> u8 {
        (0..3).fold(0, |bits, i| bits | u8::from(self.is_active(place, i)) << i)
    }

    /// Number of unknowns in use in the places from this one on.
    #[inline(never)]
    pub fn unknowns_from<const U: usize>(&self, place: usize) -> u32 {
        let columns = 3 * place..3 * groups_of(U);
        columns.filter(|k| self.is_active(k / 3, k % 3)).count() as u32
    }

    /// True for a place of a mode.
    pub fn is_of_mode(&self, place: usize) -> bool {
        self.place.get(place).copied().flatten().is_some_and(|(group, _)| group.is_of_mode())
    }

    /// True where hardware is among the unknowns.
    pub fn has_hardware(&self) -> bool {
        self.place.iter().skip(self.hardware).any(Option::is_some)
    }

    /// True where the model has a time offset, known or unknown.
    pub fn has_offset(&self) -> bool {
        let is_unknown = |place| self.is_at(place, Group::Common) && self.is_active(place, 0);
        self.delay_s != T::zero() || (self.hardware..GROUPS).any(is_unknown)
    }

    /// First of U unknowns that lasts from window to window.
    pub fn first_kept<const U: usize>(&self) -> usize {
        FIRST_GROUP + 3 * self.hardware.min(groups_of(U))
    }
}

/// Element of a trace-free basis of the shape: `√½`.
const ROOT_HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// `√⅙`.
const ROOT_SIXTH: f64 = 0.408_248_290_463_863;

/// Values of the unknowns, by place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T: Real, const U: usize> {
    values: [T; U],
}

crate::persist!([T: Real, const U: usize] Point<T, U> { values });

impl<T: Real, const U: usize> Point<T, U> {
    /// Momentum of a sphere of unit scale.
    pub fn sphere(momentum: Vec3<T>) -> Self {
        let mut point = Self { values: [T::zero(); U] };
        point.set_momentum(&momentum);
        point.set_scale(T::one());
        point
    }

    /// Value of one unknown.
    pub fn value(&self, index: usize) -> T {
        self.values.get(index).copied().unwrap_or(T::zero())
    }

    /// Sets one unknown.
    pub fn set_value(&mut self, index: usize, value: T) {
        if let Some(of_index) = self.values.get_mut(index) {
            *of_index = value;
        }
    }

    /// Three unknowns from `first` on.
    fn three(&self, first: usize) -> Vec3<T> {
        Vec3::from_fn(|i, _| self.value(first + i))
    }

    fn set_three(&mut self, first: usize, values: &Vec3<T>) {
        for i in 0..3 {
            self.set_value(first + i, values[i]);
        }
    }

    /// `m₀`, rad/s.
    pub fn momentum(&self) -> Vec3<T> {
        self.three(MOMENTUM)
    }

    /// Sets `m₀`, rad/s.
    pub fn set_momentum(&mut self, momentum: &Vec3<T>) {
        self.set_three(MOMENTUM, momentum);
    }

    /// Group in a place; zero beyond the last one.
    pub fn of_place(&self, place: usize) -> Vec3<T> {
        if place < groups_of(U) { self.three(FIRST_GROUP + 3 * place) } else { Vec3::zeros() }
    }

    /// Sets the group in a place.
    pub fn set_place(&mut self, place: usize, values: &Vec3<T>) {
        if place < groups_of(U) {
            self.set_three(FIRST_GROUP + 3 * place, values);
        }
    }

    /// `q`.
    pub fn shape(&self) -> [T; 5] {
        core::array::from_fn(|k| self.value(shape_of(U) + k))
    }

    /// Sets `q`.
    pub fn set_shape(&mut self, shape: &[T; 5]) {
        for (k, q) in shape.iter().enumerate() {
            self.set_value(shape_of(U) + k, *q);
        }
    }

    /// `x = κ / κᵤ`, positive.
    pub fn scale(&self) -> T {
        self.value(scale_of(U))
    }

    /// Sets `x`.
    pub fn set_scale(&mut self, scale: T) {
        self.set_value(scale_of(U), scale);
    }

    /// Elements `n` of the tensor over its trace.
    pub fn over_trace(&self) -> [T; 6] {
        over_trace(&self.shape())
    }

    /// Derivatives of an element `j = n / κ` of the tensor by shape and scale, for the trace `1 / κ`: `∂j/∂q = B / κ` and
    /// `∂j/∂x = −j / x`.
    pub fn of_element(&self, element: usize, trace: T) -> [T; 6] {
        let element = element.min(5);
        let mut one = [T::zero(); 6];
        one[element] = trace;
        let [q0, q1, q2, q3, q4] = by_shape::<T, T>(&one);
        [q0, q1, q2, q3, q4, -self.over_trace()[element] * trace / self.scale()]
    }

    /// Value of a further group; zero where it is not in use.
    pub fn group(&self, groups: &Groups<T>, group: Group) -> Vec3<T> {
        match (0..GROUPS).find(|place| groups.is_at(*place, group)) {
            Some(place) => self.of_place(place),
            None => Vec3::zeros(),
        }
    }

    /// The point after a step of all unknowns but the momentum. The scale changes by a factor of
    /// five at most, so that it stays positive.
    pub fn stepped(&self, step: &[T; U]) -> Self {
        let mut next = *self;
        for (value, step) in next.values.iter_mut().zip(step).skip(FIRST_GROUP) {
            *value += *step;
        }
        let five = T::lit(5.0);
        let scale = self.scale();
        next.set_scale(next.scale().max(scale / five).min(scale * five));
        next
    }

    /// True where all values are finite.
    pub fn is_finite(&self) -> bool {
        self.values.iter().all(|x| x.is_finite())
    }
}

/// Elements `n` of the tensor over its trace that has this shape.
pub fn over_trace<T: Real>(shape: &[T; 5]) -> [T; 6] {
    let third = T::lit(1.0 / 3.0);
    let mut n = of_shape(shape);
    for moment in n.iter_mut().take(3) {
        *moment += third;
    }
    n
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
