//! Flexible appendages and sloshing liquids: motion and sensitivities of a body with stated modes.
//!
//! A mode is a linear oscillator of stated undamped frequency Ω and damping ratio ζ, with the body held, and of unknown
//! modal inertia μ over the trace, a symmetric matrix. With its absolute rate `u = ω + q̇`, q the deflection about each
//! body axis, total momentum is `m = (n − Σ μ) ω + x wᵤ + Σ μ u`: a mode acts like three wheels of the momentum `μ u`
//! on the body without it,
//!
//! ```text
//! ω = (n − Σ μ)⁻¹ (m − x wᵤ − Σ μ u)
//! u̇ = −c q̇ − k q,   q̇ = u − ω          c = 2 ζ Ω,  k = Ω²
//! ```
//!
//! which is the hybrid-coordinate equation of \[Likins1970\] for `μ = D Dᵀ / tr J`.
//! The unknown errors f of frequency and z of damping have `c = 2 ζ Ω (1 + f)(1 + z)`, `k = Ω² (1 + f)²`.
//!
//! Assumptions: small deflections; body and mode at rest relative to one another at the first sample of a window; the modal
//! inertia moves with the body.
//!
//! # Sensitivities
//!
//! With `P = D − Σ μ D_u` and V the direct effect of an unknown on the momentum of the body
//! ([`trajectory`](super)), `Eₑ q̇` for an element e of μ,
//!
//! ```text
//! S = (n − Σ μ)⁻¹ (P − V)
//! Ḋ = m × S − ω × D − c S + F
//! Ḋ_u = −c (D_u − S) − k D_q − (∂c q̇ + ∂k q),   Ḋ_q = D_u − S
//! ```
//!
//! The motion of a step is a Taylor series, as without modes. The sensitivities go by the classical method of Runge and
//! Kutta: a step of 0.3 rad of the fastest mode errs by 2e-5 of them.

use super::model::Model;
use super::sensitivity::columns_of_the_regressor;
use super::step::{Crossing, ORDERS, product};
use super::unknowns::{FIRST_GROUP, Group, Groups, Point, by_shape, shape_of};
use super::{Trajectory, of_wheel};
use crate::dynamics::wheels::Momenta;
use crate::math::{Entries, Mat, Vec3, rotated, scalar::Real};
use crate::tensor::Inertia;

/// Largest phase of a mode in a step, rad.
const STEP_PHASE: f64 = 0.3;
/// Steps across a block at most: a block that is longer than two periods is crossed less accurately.
const MOST_STEPS: u32 = 48;

/// Mode at one point of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator<T: Real> {
    /// μ.
    inertia: Mat<T, 3, 3>,
    /// c, 1/s, and k, 1/s².
    damping_per_s: T,
    stiffness_per_s2: T,
    /// 1 + f and 1 + z.
    frequency_share: T,
    damping_share: T,
}

crate::persist!([T: Real] Oscillator<T> { inertia, damping_per_s, stiffness_per_s2, frequency_share, damping_share });

impl<T: Real> Oscillator<T> {
    /// Without inertia.
    pub fn none() -> Self {
        Self {
            inertia: Mat::zeros(),
            damping_per_s: T::zero(),
            stiffness_per_s2: T::zero(),
            frequency_share: T::one(),
            damping_share: T::one(),
        }
    }

    /// Mode with this index at a point.
    pub fn new<const U: usize>(point: &Point<T, U>, groups: &Groups<T>, index: u8) -> Self {
        let Some([frequency_rad_s, damping]) = groups.modes.get(usize::from(index)).copied() else {
            return Self::none();
        };
        let moments = point.group(groups, Group::ModalMoments(index));
        let products = point.group(groups, Group::ModalProducts(index));
        let tuning = point.group(groups, Group::ModeTuning(index));
        let (frequency_share, damping_share) = (T::one() + tuning.x, T::one() + tuning.y);
        let frequency = frequency_rad_s * frequency_share;
        let elements = [moments.x, moments.y, moments.z, products.x, products.y, products.z];
        Self {
            inertia: Inertia::new(elements).matrix_kg_m2(),
            damping_per_s: (damping + damping) * damping_share * frequency,
            stiffness_per_s2: frequency * frequency,
            frequency_share,
            damping_share,
        }
    }

    /// u̇ for q̇ and q.
    fn slope(&self, relative: &Vec3<T>, angle: &Vec3<T>) -> Vec3<T> {
        -(relative * self.damping_per_s) - angle * self.stiffness_per_s2
    }
}

/// Tensor over the trace without the modal inertias.
pub fn of_body<T: Real>(over_trace: &[T; 6], modes: &[Oscillator<T>]) -> Inertia<T> {
    let mut of_body = *over_trace;
    for mode in modes {
        for (element, of_mode) in of_body.iter_mut().zip(elements(&mode.inertia)) {
            *element -= of_mode;
        }
    }
    Inertia::new(of_body)
}

/// Six elements of a symmetric matrix.
fn elements<T: Real>(m: &Mat<T, 3, 3>) -> [T; 6] {
    [m.at(0, 0), m.at(1, 1), m.at(2, 2), m.at(0, 1), m.at(0, 2), m.at(1, 2)]
}

/// State of a mode along a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deflection<T: Real, const U: usize> {
    /// u, rad/s, and q, rad.
    absolute: Vec3<T>,
    angle: Vec3<T>,
    /// D_u and D_q, by columns.
    by_absolute: [Vec3<T>; U],
    by_angle: [Vec3<T>; U],
    /// Sum over the steps of the present block of the mean of q̇.
    relative: Vec3<T>,
}

crate::persist!([T: Real, const U: usize] Deflection<T, U> { absolute, angle, by_absolute, by_angle, relative });

impl<T: Real, const U: usize> Deflection<T, U> {
    /// At rest.
    pub fn none() -> Self {
        let none = Vec3::zeros();
        Self {
            absolute: none,
            angle: none,
            by_absolute: [none; U],
            by_angle: [none; U],
            relative: none,
        }
    }
}

/// Derivatives of momentum and modes by one unknown.
#[derive(Clone, Copy)]
struct Column<T: Real, const M: usize> {
    momentum: Vec3<T>,
    absolute: [Vec3<T>; M],
    angle: [Vec3<T>; M],
}

impl<T: Real, const M: usize> Column<T, M> {
    /// `self + by · slope`.
    fn after(&self, slope: &Self, by: T) -> Self {
        let mut next = *self;
        next.momentum += slope.momentum * by;
        let slopes = slope.absolute.iter().chain(&slope.angle);
        for (value, slope) in next.absolute.iter_mut().chain(&mut next.angle).zip(slopes) {
            *value += *slope * by;
        }
        next
    }
}

/// Motion and drive at an instant of a step.
struct Instant<T: Real, const W: usize, const M: usize> {
    /// m + g, and ω.
    momentum: Vec3<T>,
    rate: Vec3<T>,
    absolute: [Vec3<T>; M],
    angle: [Vec3<T>; M],
    /// gᵤ, wᵤ − gᵤ, the momentum of each wheel and the slope of wᵤ, rad/s².
    beyond: Vec3<T>,
    drive: Vec3<T>,
    wheels: Momenta<T, W>,
    slope: Vec3<T>,
    /// V of the shape.
    by_shape: [Vec3<T>; 5],
}

/// Direct effects of an unknown: V, F, and that on u̇ of one mode.
struct Forcing<T: Real> {
    on_momentum: Vec3<T>,
    torque: Vec3<T>,
    on_mode: Option<(usize, Vec3<T>)>,
}

/// Taylor series of a step by its share of time.
struct Series<T: Real, const M: usize> {
    /// m + g.
    momentum: [Vec3<T>; ORDERS + 1],
    absolute: [[Vec3<T>; ORDERS + 1]; M],
    angle: [[Vec3<T>; ORDERS + 1]; M],
}

/// Value of a series.
fn value<T: Real>(series: &[Vec3<T>], share: T) -> Vec3<T> {
    series.iter().rev().fold(Vec3::zeros(), |sum, coefficient| sum * share + coefficient)
}

/// Mean of a series over the step.
fn mean<T: Real>(series: &[Vec3<T>]) -> Vec3<T> {
    let parts = (1u32..).zip(series);
    parts.fold(Vec3::zeros(), |sum, (k, coefficient)| sum + coefficient * (T::one() / T::count(k)))
}

/// Slope of a series at the end of the step.
fn end_slope<T: Real>(series: &[Vec3<T>]) -> Vec3<T> {
    let parts = (0u32..).zip(series);
    parts.fold(Vec3::zeros(), |sum, (k, coefficient)| sum + coefficient * T::count(k))
}

impl<T: Real, const W: usize, const M: usize> Model<T, W, M> {
    /// `A (n − Σ μ) n⁻¹`: a matrix A that acts on the momentum of the body without its modes, for modes at rest relative
    /// to it.
    #[inline(always)]
    pub(super) fn at_rest(&self, matrix: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
        if M == 0 { *matrix } else { self.with_modes_at_rest(matrix) }
    }

    fn with_modes_at_rest(&self, matrix: &Mat<T, 3, 3>) -> Mat<T, 3, 3> {
        let Some(body) = Inertia::new(elements(&self.inverse)).inverse() else { return *matrix };
        let total = self.modes.iter().fold(body, |sum, mode| sum + mode.inertia);
        match Inertia::new(elements(&total)).inverse() {
            Some(inverse) => matrix * (body * inverse),
            None => *matrix,
        }
    }

    /// Steps of a block of this length for the fastest mode.
    pub(super) fn steps_of_modes(&self, duration_s: T) -> u32 {
        let fastest = self.modes.iter().fold(T::zero(), |most, m| most.max(m.stiffness_per_s2));
        let phase_square = fastest * duration_s * duration_s;
        let mut steps = 1;
        while steps < MOST_STEPS
            && phase_square > T::lit(STEP_PHASE * STEP_PHASE) * T::count(steps * steps)
        {
            steps += 1;
        }
        steps
    }

    /// Σ μ v.
    fn modal_momentum(&self, values: impl Iterator<Item = Vec3<T>>) -> Vec3<T> {
        let modes = self.modes.iter().zip(values);
        modes.fold(Vec3::zeros(), |sum, (mode, value)| sum + mode.inertia * value)
    }

    /// Derivatives of the slopes by one unknown, and P.
    fn slope(
        &self,
        at: &Instant<T, W, M>,
        column: &Column<T, M>,
        forcing: &Forcing<T>,
    ) -> (Vec3<T>, Column<T, M>) {
        let of_body = column.momentum - self.modal_momentum(column.absolute.iter().copied());
        let rate = rotated(&self.inverse, &(of_body - forcing.on_momentum));
        let turned = at.momentum.cross(&rate) - at.rate.cross(&column.momentum);
        let momentum = turned - self.drag.component_mul(&rate) + forcing.torque;
        let mut slope = Column { momentum, ..*column };
        for (j, mode) in self.modes.iter().enumerate() {
            let relative = column.absolute[j] - rate;
            slope.absolute[j] = mode.slope(&relative, &column.angle[j]);
            slope.angle[j] = relative;
        }
        if let Some((mode, on_mode)) = forcing.on_mode
            && let Some(of_mode) = slope.absolute.get_mut(mode)
        {
            *of_mode += on_mode;
        }
        (of_body, slope)
    }

    /// Direct effects of a component of a group; none where it does not act on the motion.
    fn forcing(
        &self,
        (group, i): (Group, usize),
        at: &Instant<T, W, M>,
        known_torque: &Vec3<T>,
    ) -> Option<Forcing<T>> {
        let none = Vec3::zeros();
        let unit = Vec3::from_fn(|k, _| if k == i { T::one() } else { T::zero() });
        let (mut on_momentum, mut torque, mut on_mode) = (none, none, None);
        match group {
            Group::Torque => torque = unit,
            Group::Field(_) | Group::Axes => return None,
            Group::Drag => torque = -unit.component_mul(&at.rate),
            Group::Wheel(wheel) => {
                let momentum = of_wheel(&at.wheels, wheel) * self.scale;
                on_momentum = self.by_errors_of_wheel(wheel).get(i).copied()? * momentum;
            }
            Group::Common if i == 0 => on_momentum = -at.slope * self.scale,
            Group::Common if i == 1 => {
                let per_share = self.scale / self.torque_share;
                on_momentum = -at.beyond * per_share;
                torque = (known_torque + at.beyond.cross(&at.rate)) * per_share;
            }
            Group::Common => on_momentum = self.by_common_error(&at.wheels) * self.scale,
            Group::ModalMoments(mode) => {
                on_momentum = unit.component_mul(&at.relative(usize::from(mode))?);
            }
            Group::ModalProducts(mode) => {
                on_momentum = of_product(i, &at.relative(usize::from(mode))?);
            }
            Group::ModeTuning(mode) => {
                let j = usize::from(mode);
                let (oscillator, relative) = (self.modes.get(j)?, at.relative(j)?);
                let (c, k) = (oscillator.damping_per_s, oscillator.stiffness_per_s2);
                let by_damping = relative * -c;
                let angle = at.angle.get(j).copied()?;
                let by = match i {
                    0 => (by_damping - angle * (k + k)) * (T::one() / oscillator.frequency_share),
                    _ => by_damping * (T::one() / oscillator.damping_share),
                };
                on_mode = Some((j, by));
            }
            Group::Bias | Group::GyroScale | Group::GyroUpper | Group::GyroLower => return None,
        }
        Some(Forcing { on_momentum, torque, on_mode })
    }
}

/// `E v` for a product of inertia: xy, xz, yz.
fn of_product<T: Real>(product: usize, v: &Vec3<T>) -> Vec3<T> {
    let zero = T::zero();
    match product {
        0 => Vec3::new(v.y, v.x, zero),
        1 => Vec3::new(v.z, zero, v.x),
        _ => Vec3::new(zero, v.z, v.y),
    }
}

impl<T: Real, const W: usize, const M: usize> Instant<T, W, M> {
    /// q̇ of a mode.
    fn relative(&self, mode: usize) -> Option<Vec3<T>> {
        Some(self.absolute.get(mode)? - self.rate)
    }
}

impl<T: Real, const W: usize, const U: usize, const M: usize> Trajectory<T, W, U, M> {
    /// Modes at rest relative to the body at the first sample, half of its interval after the start of the block: `u = ω`,
    /// `D_u = S` there, and q such that it is zero there. At the start itself the wheels are extrapolated: a motor that begins
    /// with the record has not turned the body yet.
    #[inline(never)]
    pub(super) fn start_modes(&mut self, crossing: &Crossing<T, W, U>) {
        let half = T::lit(0.5);
        let share = half / crossing.samples;
        let since_s = crossing.duration_s * share;
        let [at_start, by_share, by_square] = crossing.of_wheel;
        let wheels = at_start + (by_share + by_square * share) * share;
        let before = self.model.rate_rad_s(&self.momentum, &at_start);
        let change = self.momentum.cross(&before) + crossing.torque;
        let rate = self.model.rate_rad_s(&(self.momentum + change * since_s), &wheels);
        let rows: [[T; U]; 3] =
            core::array::from_fn(|axis| self.rate_at_start(&rate, &wheels, axis));
        let [x, y, z] = &rows;
        for mode in &mut self.modes {
            *mode = Deflection { absolute: rate, ..Deflection::none() };
            mode.angle = (before - rate) * (since_s * half);
            let columns = x.iter().zip(y).zip(z);
            for (by, ((x, y), z)) in mode.by_absolute.iter_mut().zip(columns) {
                *by = Vec3::new(*x, *y, *z);
            }
        }
    }

    /// Carries motion and sensitivities across a step.
    #[inline(never)]
    pub(super) fn cross_flexible(&mut self, crossing: &mut Crossing<T, W, U>) {
        if crossing.done == 0 {
            self.modes.iter_mut().for_each(|mode| mode.relative = Vec3::zeros());
        }
        let half = T::lit(0.5);
        let (series, w) = self.series(crossing);
        let instants =
            [T::zero(), half, T::one()].map(|share| self.instant(crossing, &series, &w, share));
        for c in 0..U {
            self.carry(crossing, &instants, c);
        }
        let [start, _, end] = &instants;
        let modal = self.model.modal_momentum(series.absolute.iter().map(|of| mean(of)));
        let of_body = mean(&series.momentum) - mean(&w) - modal;
        let mean_rate = rotated(&self.model.inverse, &of_body);
        crossing.rate += mean_rate;
        for (j, mode) in self.modes.iter_mut().enumerate() {
            mode.relative += mean(&series.absolute[j]) - mean_rate;
            mode.absolute = end.absolute[j];
            mode.angle = end.angle[j];
        }
        let beyond = start.beyond - end.beyond;
        self.move_by(end.momentum - start.momentum + beyond * self.model.scale);
        crossing.done += 1;
    }

    /// Series of the present step, and the coefficients of x w. Adds to the sums of the crossing.
    fn series(&self, crossing: &mut Crossing<T, W, U>) -> (Series<T, M>, [Vec3<T>; 3]) {
        let [w0, w1, w2, g0, g1, g2] = crossing.within_step(self.model.scale);
        let (w, g) = ([w0, w1, w2], [g1, g2]);
        let (none, step_s) = (Vec3::zeros(), crossing.step_s);
        let mut series = Series {
            momentum: [none; ORDERS + 1],
            absolute: [[none; ORDERS + 1]; M],
            angle: [[none; ORDERS + 1]; M],
        };
        let mut turns = [none; ORDERS];
        series.momentum[0] = self.momentum + g0;
        for (j, mode) in self.modes.iter().enumerate() {
            series.absolute[j][0] = mode.absolute;
            series.angle[j][0] = mode.angle;
        }
        for k in 0..ORDERS {
            let part = T::one() / T::count(k as u32 + 1);
            let modal = self.model.modal_momentum(series.absolute.iter().map(|of| of[k]));
            let of_body = series.momentum[k] - w.get(k).copied().unwrap_or(none) - modal;
            let rate = rotated(&self.model.inverse, &of_body);
            turns[k] = rate * step_s;
            let mut slope = product(series.momentum.iter().take(k + 1), &turns);
            if k == 0 {
                slope += crossing.torque * step_s;
            }
            let slope = self.braked(slope, &turns[k]);
            series.momentum[k + 1] = slope * part + g.get(k).copied().unwrap_or(none);
            for (j, mode) in self.model.modes.iter().enumerate() {
                let relative = series.absolute[j][k] - rate;
                let by = part * step_s;
                series.absolute[j][k + 1] = mode.slope(&relative, &series.angle[j][k]) * by;
                series.angle[j][k + 1] = relative * by;
            }
        }
        self.add_means(crossing, &series, [g0, g1, g2]);
        (series, w)
    }

    /// Adds the mean of m less the momentum of the modes, and its slope at the ends of the block.
    fn add_means(&self, crossing: &mut Crossing<T, W, U>, series: &Series<T, M>, g: [Vec3<T>; 3]) {
        let of = |of_series: fn(&[Vec3<T>]) -> Vec3<T>| {
            let modal = self.model.modal_momentum(series.absolute.iter().map(|u| of_series(u)));
            of_series(&series.momentum) - of_series(&g) - modal
        };
        crossing.momentum += of(mean);
        if crossing.done == 0 {
            crossing.bend = of(|series| series.get(1).copied().unwrap_or(Vec3::zeros()));
        }
        if crossing.done + 1 == crossing.steps {
            crossing.bend -= of(end_slope);
        }
    }

    /// Motion and drive a share of the present step after its start.
    fn instant(
        &self,
        crossing: &Crossing<T, W, U>,
        series: &Series<T, M>,
        w: &[Vec3<T>; 3],
        share: T,
    ) -> Instant<T, W, M> {
        let momentum = value(&series.momentum, share);
        let absolute: [Vec3<T>; M] = core::array::from_fn(|j| value(&series.absolute[j], share));
        let angle = core::array::from_fn(|j| value(&series.angle[j], share));
        let modal = self.model.modal_momentum(absolute.iter().copied());
        let rate = rotated(&self.model.inverse, &(momentum - value(w, share) - modal));
        let x = (T::count(crossing.done) + share) * crossing.share;
        let [at_start, by_share, by_square] = crossing.of_wheel;
        let wheels = at_start + (by_share + by_square * x) * x;
        let beyond = crossing.beyond_ramp * (x * (T::one() - x));
        let slope = (by_share + by_square * (x + x)) * (T::one() / crossing.duration_s);
        Instant {
            momentum,
            rate,
            absolute,
            angle,
            beyond,
            drive: self.model.axes * wheels - beyond,
            wheels,
            slope: self.model.axes * slope,
            by_shape: by_shape::<T, _>(&columns_of_the_regressor(&Mat::identity(), &rate)),
        }
    }

    /// Carries the derivatives by one unknown across a step, and adds twice the mean of P to a sum.
    fn carry(&mut self, crossing: &mut Crossing<T, W, U>, at: &[Instant<T, W, M>; 3], c: usize) {
        let known = crossing.known_torque;
        let forcings = at.each_ref().map(|at| self.forcing_of(at, c, &known));
        let [Some(first), Some(middle), Some(last)] = &forcings else { return };
        let before = Column {
            momentum: self.sensitivity[c],
            absolute: core::array::from_fn(|j| self.modes[j].by_absolute[c]),
            angle: core::array::from_fn(|j| self.modes[j].by_angle[c]),
        };
        let [start, midst, end] = at;
        let (step_s, half) = (crossing.step_s, crossing.step_s * T::lit(0.5));
        let model = &self.model;
        let (p1, k1) = model.slope(start, &before, first);
        let (p2, k2) = model.slope(midst, &before.after(&k1, half), middle);
        let (p3, k3) = model.slope(midst, &before.after(&k2, half), middle);
        let (p4, k4) = model.slope(end, &before.after(&k3, step_s), last);
        let sixth = step_s * T::lit(1.0 / 6.0);
        let third = sixth + sixth;
        let after = before.after(&k1, sixth).after(&k2, third).after(&k3, third).after(&k4, sixth);
        self.sensitivity[c] = after.momentum;
        for (mode, (absolute, angle)) in
            self.modes.iter_mut().zip(after.absolute.iter().zip(&after.angle))
        {
            (mode.by_absolute[c], mode.by_angle[c]) = (*absolute, *angle);
        }
        let inner = p2 + p3;
        crossing.sensitivity[c] += (p1 + inner + inner + p4) * T::lit(1.0 / 3.0);
    }

    /// Direct effects of an unknown; none where its derivatives stay zero.
    fn forcing_of(
        &self,
        at: &Instant<T, W, M>,
        c: usize,
        known_torque: &Vec3<T>,
    ) -> Option<Forcing<T>> {
        let none = Vec3::zeros();
        let of = |on_momentum, torque| Some(Forcing { on_momentum, torque, on_mode: None });
        let Some(further) = c.checked_sub(FIRST_GROUP) else { return of(none, none) };
        match c.checked_sub(shape_of(U)) {
            Some(k) => match at.by_shape.get(k) {
                Some(by_shape) => of(*by_shape, none),
                None => of(at.drive, known_torque + at.beyond.cross(&at.rate)),
            },
            None => {
                let (place, component) = (further / 3, further % 3);
                let group = self.model.group.get(place).copied().flatten()?;
                if !self.model.is_active(place, component) {
                    return None;
                }
                self.model.forcing((group, component), at, known_torque)
            }
        }
    }

    /// Adds the direct derivatives of the mean reading of a block by the modal inertias, `−b Eₑ q̇`.
    #[inline(never)]
    pub(super) fn add_modes(&self, row: &mut [T; U], b: &Vec3<T>) {
        for (place, group) in self.model.group.iter().enumerate() {
            let (mode, is_product) = match group {
                Some(Group::ModalMoments(mode)) => (*mode, false),
                Some(Group::ModalProducts(mode)) => (*mode, true),
                _ => continue,
            };
            let Some(Deflection { relative, .. }) = self.modes.get(usize::from(mode)) else {
                continue;
            };
            for i in 0..3 {
                let by = if is_product {
                    b.dot(&of_product(i, relative))
                } else {
                    b.at(i, 0) * relative.at(i, 0)
                };
                if let Some(of_row) = row.get_mut(FIRST_GROUP + 3 * place + i) {
                    *of_row -= by;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::unknowns::Belief;
    use super::*;
    use crate::blocks::block::Block;
    use crate::blocks::span::Span;
    use nalgebra::{Matrix3, Vector3};
    use std::vec::Vec;

    /// Momentum, a wheel, a mode and the time offset, with the inertia.
    const UNKNOWNS: usize = 27;
    const PLACES: [Group; 6] = [
        Group::ModalMoments(0),
        Group::ModalProducts(0),
        Group::ModeTuning(0),
        Group::Torque,
        Group::Wheel(0),
        Group::Common,
    ];
    /// Frequency, rad/s, and damping ratio.
    const MODE: [f64; 2] = [3.0, 0.02];
    /// Length of a block, s, and number of blocks.
    const BLOCK_S: f64 = 0.5;
    const BLOCKS: usize = 40;

    fn groups() -> Groups<f64> {
        let mut groups = Groups { hardware: 4, modes: [MODE, [0.0; 2]], ..Groups::none() };
        for (place, group) in groups.place.iter_mut().zip(PLACES) {
            *place = Some((group, Belief::Within([1.0; 3])));
        }
        groups.place[2] = Some((Group::ModeTuning(0), Belief::Within([1.0, 1.0, 0.0])));
        groups
    }

    /// A mode of 4 % about a skew axis, on a body that turns.
    fn point() -> Point<f64, UNKNOWNS> {
        let d = Vector3::new(0.5, 0.8, 0.33).normalize() * (0.04f64 / 3.0).sqrt();
        let mu = d * d.transpose();
        let mut point = Point::sphere(Vec3::new(0.05, -0.03, 0.04));
        point.set_place(0, &Vec3::new(mu[(0, 0)], mu[(1, 1)], mu[(2, 2)]));
        point.set_place(1, &Vec3::new(mu[(0, 1)], mu[(0, 2)], mu[(1, 2)]));
        point.set_place(2, &Vec3::new(0.03, -0.1, 0.0));
        point.set_place(3, &Vec3::new(0.0004, -0.0002, 0.0003));
        point.set_shape(&[0.04, -0.03, 0.03, -0.05, 0.02]);
        point.set_scale(0.9);
        point
    }

    /// Known torque, from the start: a step.
    const TORQUE: Vec3<f64> = Vec3::new(0.004, -0.003, 0.002);

    /// A wheel about x that swings.
    fn wheel(t: f64) -> f64 {
        0.02 * (1.0 - (0.8 * t).cos())
    }

    fn spans() -> Vec<Span<f64, 1>> {
        let mean = |t: f64| {
            let integral = |t: f64| 0.02 * (t - (0.8 * t).sin() / 0.8);
            (integral(t + BLOCK_S) - integral(t)) / BLOCK_S
        };
        let momenta = |h: f64| Momenta::<f64, 1>::from_element(h);
        (0..BLOCKS)
            .map(|k| {
                let t = k as f64 * BLOCK_S;
                let block = Block {
                    duration_s: BLOCK_S,
                    wheels_n_m_s: momenta(mean(t)),
                    wheels_end_n_m_s: momenta(wheel(t + BLOCK_S)),
                    impulse_n_m_s: TORQUE * BLOCK_S,
                    ..Block::empty()
                };
                Span {
                    block,
                    wheels_at_start: momenta(wheel(t)),
                    samples: 1e6,
                    before: None,
                    after: None,
                }
            })
            .collect()
    }

    struct Prediction {
        rate_rad_s: Vec3<f64>,
        rows: [[f64; UNKNOWNS]; 3],
    }

    fn fly(point: &Point<f64, UNKNOWNS>) -> (Trajectory<f64, 1, UNKNOWNS, 1>, Vec<Prediction>) {
        let (spans, mut trajectory) = (spans(), Trajectory::blank());
        let axes = Mat::<f64, 3, 1>::new(1.0, 0.0, 0.0);
        assert!(trajectory.start(point, &groups(), &axes));
        let mut predictions = Vec::new();
        for span in &spans {
            let crossing = trajectory.cross(span);
            predictions.push(Prediction {
                rate_rad_s: trajectory.mean_rate_rad_s(&crossing),
                rows: core::array::from_fn(|axis| trajectory.mean_sensitivity(&crossing, axis)),
            });
        }
        (trajectory, predictions)
    }

    /// Mean rates of the blocks by Likins' equations in the modal coordinate, with fine steps of Runge and Kutta:
    /// `J_b ω̇ + D η̈ + ω × (J ω + x h a + D η̇) = τ − x ḣ a`, `η̈ + 2 ζ Ω η̇ + Ω² η = −Dᵀ ω̇`.
    fn by_likins(point: &Point<f64, UNKNOWNS>) -> Vec<Vector3<f64>> {
        const STEPS: usize = 200;
        let j = Inertia::new(point.over_trace()).matrix_kg_m2();
        let moments = point.of_place(0);
        let products = point.of_place(1);
        let tuning = point.of_place(2);
        let torque = point.of_place(3) + TORQUE * point.scale();
        // D from its outer product.
        let d = Vector3::new(moments.x, products.x, products.y) / moments.x.sqrt();
        let (frequency, damping) = (MODE[0] * (1.0 + tuning.x), MODE[1] * (1.0 + tuning.y));
        let x = point.scale();
        let slope = |t: f64, y: &[Vector3<f64>; 2], rate: &mut Vector3<f64>| {
            let (w, eta, eta_rate) = (y[0], y[1].x, y[1].y);
            *rate = w;
            let restoring = 2.0 * damping * frequency * eta_rate + frequency * frequency * eta;
            let h = Vector3::x() * (wheel(t) * x);
            let h_slope = Vector3::x() * (0.02 * 0.8 * (0.8 * t).sin() * x);
            let momentum = j * w + h + d * eta_rate;
            let body: Matrix3<f64> = j - d * d.transpose();
            let push = torque - h_slope + d * restoring - w.cross(&momentum);
            let acceleration = body.try_inverse().unwrap() * push;
            let eta_acceleration = -d.dot(&acceleration) - restoring;
            [acceleration, Vector3::new(eta_rate, eta_acceleration, 0.0)]
        };
        let rest = j.try_inverse().unwrap() * point.momentum();
        let mut y = [rest, Vector3::zeros()];
        let step_s = BLOCK_S / STEPS as f64;
        let mut means = Vec::new();
        for block in 0..BLOCKS {
            let mut sum = Vector3::zeros();
            for step in 0..STEPS {
                let t = block as f64 * BLOCK_S + step as f64 * step_s;
                let mut rates = [Vector3::zeros(); 4];
                let [r1, r2, r3, r4] = &mut rates;
                let after = |y: &[Vector3<f64>; 2], k: &[Vector3<f64>; 2], by: f64| {
                    [y[0] + k[0] * by, y[1] + k[1] * by]
                };
                let k1 = slope(t, &y, r1);
                let k2 = slope(t + 0.5 * step_s, &after(&y, &k1, 0.5 * step_s), r2);
                let k3 = slope(t + 0.5 * step_s, &after(&y, &k2, 0.5 * step_s), r3);
                let k4 = slope(t + step_s, &after(&y, &k3, step_s), r4);
                for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                    y = after(&y, &k, step_s * weight / 6.0);
                }
                sum += (rates[0] + (rates[1] + rates[2]) * 2.0 + rates[3]) / 6.0;
            }
            means.push(sum / STEPS as f64);
        }
        means
    }

    /// Remainder of the parabola of a wheel that swings by 0.4 rad in a block, over its 0.02.
    const PARABOLA: f64 = 4e-6;

    #[test]
    fn motion_is_that_of_the_modal_coordinate() {
        let mut point = point();
        point.set_place(4, &Vec3::zeros());
        let (_, predictions) = fly(&point);
        let expected = by_likins(&point);
        let swing = expected.iter().map(|w| w.norm()).fold(0.0, f64::max);
        for (k, (found, expected)) in predictions.iter().zip(&expected).enumerate() {
            let error = (found.rate_rad_s - expected).norm();
            assert!(error < PARABOLA, "block {k}: {error:e} of {swing}");
        }
    }

    /// A wheel that begins to turn the body at the first sample, extrapolated to half an interval before it: there the body
    /// turns backwards, and a mode that is slow beside the interval is at rest in space, not with the body.
    #[test]
    fn modes_are_at_rest_at_the_first_sample() {
        const SAMPLE_S: f64 = 0.1;
        const SLOPE: f64 = 0.01;
        let mut point = Point::<f64, UNKNOWNS>::sphere(Vec3::zeros());
        point.set_place(0, &Vec3::new(0.02, 0.0, 0.0));
        let mut trajectory = Trajectory::<f64, 1, UNKNOWNS, 1>::blank();
        assert!(trajectory.start(&point, &groups(), &Mat::<f64, 3, 1>::new(1.0, 0.0, 0.0)));
        let momenta = |t: f64| Momenta::<f64, 1>::from_element(SLOPE * t);
        let span = Span {
            block: Block {
                duration_s: 5.0 * SAMPLE_S,
                wheels_n_m_s: momenta(2.0 * SAMPLE_S),
                wheels_end_n_m_s: momenta(4.5 * SAMPLE_S),
                ..Block::empty()
            },
            wheels_at_start: momenta(-0.5 * SAMPLE_S),
            samples: 5.0,
            before: None,
            after: None,
        };
        let crossing = trajectory.enter(&span);
        trajectory.start_modes(&crossing);
        let mode = &trajectory.modes[0];
        // At the first sample wheel and body are at rest. Half an interval before, a sphere of trace 1 turns by 3 h x.
        assert!(mode.absolute.norm() < 1e-15, "{}", mode.absolute);
        let backwards = 3.0 * SLOPE * 0.5 * SAMPLE_S * point.scale();
        let angle = 0.5 * backwards * 0.5 * SAMPLE_S;
        assert!((mode.angle - Vec3::new(angle, 0.0, 0.0)).norm() < 1e-12, "{}", mode.angle);
    }

    /// A mode without inertia leaves motion and sensitivities as they are without modes, torque that bends included.
    #[test]
    fn mode_without_inertia_changes_nothing() {
        let mut point = point();
        (0..2).for_each(|place| point.set_place(place, &Vec3::zeros()));
        let axes = Mat::<f64, 3, 1>::new(1.0, 0.0, 0.0);
        let (mut flexible, mut rigid) = (
            Trajectory::<f64, 1, UNKNOWNS, 1>::blank(),
            Trajectory::<f64, 1, UNKNOWNS, 0>::blank(),
        );
        assert!(flexible.start(&point, &groups(), &axes));
        assert!(rigid.start(&point, &groups(), &axes));
        let mut largest = [0.0f64; 2];
        for mut span in spans() {
            span.block.beyond_ramp_n_m_s = Vec3::new(2e-4, -1e-4, 3e-4);
            span.samples = 5.0;
            let (a, b) = (flexible.cross(&span), rigid.cross(&span));
            let apart = flexible.mean_rate_rad_s(&a) - rigid.mean_rate_rad_s(&b);
            // One step of the rigid body against six: a few 1e-9 a block.
            assert!(apart.norm() < 1e-7, "{:e}", apart.norm());
            for axis in 0..3 {
                let (with, without) =
                    (flexible.mean_sensitivity(&a, axis), rigid.mean_sensitivity(&b, axis));
                for c in (0..FIRST_GROUP).chain(12..UNKNOWNS) {
                    largest[0] =
                        largest[0].max((with[c] - without[c]).abs() / (1.0 + with[c].abs()));
                    largest[1] = largest[1].max(with[c].abs());
                }
            }
        }
        // The rigid body has the means of both ends of its one step, which err by 6e-3.
        assert!(largest[0] < 6e-3 && largest[1] > 1.0, "{largest:?}");
    }

    /// The swing of the mode itself: without it the rates differ by twenty times the tolerance.
    #[test]
    fn mode_shows_in_the_motion() {
        let mut rigid = point();
        (0..2).for_each(|place| rigid.set_place(place, &Vec3::zeros()));
        let with = fly(&point()).1;
        let without = fly(&rigid).1;
        let apart = with.iter().zip(&without).map(|(a, b)| (a.rate_rad_s - b.rate_rad_s).norm());
        assert!(apart.fold(0.0, f64::max) > 20.0 * PARABOLA);
    }

    /// Error of the derivatives of a block's mean, over the largest of their column: classical Runge-Kutta of 0.3 rad
    /// over twenty periods, and the direct effects at the mean of both ends of each step.
    const DERIVATIVE: f64 = 6e-3;

    #[test]
    fn sensitivities_agree_with_finite_differences() {
        const STEP: f64 = 1e-6;
        let (_, predictions) = fly(&point());
        for c in 0..UNKNOWNS {
            if c == FIRST_GROUP + 8 {
                continue; // no third component of the tuning
            }
            let moved = |by: f64| {
                let mut step = [0.0; UNKNOWNS];
                step[c] = by;
                let mut next = point().stepped(&step);
                next.set_momentum(&(next.momentum() + Vec3::new(step[0], step[1], step[2])));
                fly(&next).1
            };
            let (up, down) = (moved(STEP), moved(-STEP));
            let numeric = |k: usize| (up[k].rate_rad_s - down[k].rate_rad_s) / (2.0 * STEP);
            let size = (0..BLOCKS).map(|k| numeric(k).norm()).fold(0.0, f64::max);
            assert!(size > 0.0, "column {c} acts");
            for (k, prediction) in predictions.iter().enumerate() {
                let found = Vec3::from_fn(|axis, _| prediction.rows[axis][c]);
                let error = (found - numeric(k)).norm();
                assert!(error < DERIVATIVE * size, "{c}, block {k}: {error:e} of {size:e}");
            }
        }
    }
}
