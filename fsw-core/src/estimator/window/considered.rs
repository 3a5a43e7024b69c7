//! Considered hardware: errors that widen the covariance without being among the unknowns.
//!
//! A group r of three parameters for which U has no place is considered \[Schmidt1966\]. With Λ the information of the
//! blocks on shape and scale s, all other unknowns eliminated, and B their cross-information with the parameters,
//!
//! ```text
//! effect       E = P B          error of the solution for an error of one of each parameter
//! covariance   P + Σ σ² e eᵀ    P that of the noise, e the columns of E, σ one sigma of each parameter
//! ```
//!
//! It is exact as far as the fit is linear, whatever the weights. Fits of several windows share the parameters: their
//! cross-information adds up like their information.
//!
//! # Computation
//!
//! The last place of the hardware belongs to no unknown. After a descent has settled, one more pass about its point for
//! each group has that group there, with the sensitivities of an unknown. The last nine rows of its factor are
//!
//! ```text
//! [ U_rr  U_rs ]      B = U_rsᵀ D_r U_rr
//! [       U_ss ]
//! ```
//!
//! and what the fit leaves of a parameter's column is `Σ σ² (Λ_rr − Bᵀ Λ⁻¹ B)`: the expected squares of residuals that
//! the stated hardware explains. A pass without any group follows, from which the front continues. While it takes in
//! further blocks, B is taken to grow with their number.
//!
//! A random walk of the inertia leaves B as it is, which makes the effect of earlier windows too large rather than too
//! small.

use super::Window;
use super::solution::Solution;
use super::work::Work;
use crate::fit::belief::{Beliefs, Past};
use crate::fit::descent::{Considering, Descent};
use crate::fit::pass::Pass;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Entries, Mat, scalar::Real};
use crate::trajectory::unknowns::{Belief, Group, Groups, groups_of, shape_of};

/// Share of the expected square of an error of the hardware that residuals may have: three sigma.
pub const EXPLAINED_SQUARE: f64 = 9.0;

/// Cross-information of shape and scale with C groups of three parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cross<T: Real, const C: usize> {
    by_group: [[[T; 6]; 3]; C],
    /// Effect of each parameter on the group that is solved for before them: that of the time offset.
    on_solved: [[[T; 3]; 3]; C],
}

crate::persist!([T: Real, const C: usize] Cross<T, C> { by_group, on_solved });

impl<T: Real, const C: usize> Cross<T, C> {
    /// Without content.
    pub const NOTHING: Self =
        Self { by_group: [[[T::ZERO; 6]; 3]; C], on_solved: [[[T::ZERO; 3]; 3]; C] };

    /// Adds another one: `weight` times, with the scale over `per`.
    fn add(&mut self, other: &Self, weight: T, per: T) {
        for (sum, of_other) in
            self.by_group.iter_mut().flatten().zip(other.by_group.iter().flatten())
        {
            for (k, (sum, x)) in sum.iter_mut().zip(of_other).enumerate() {
                *sum += *x * if k == 5 { weight * per } else { weight };
            }
        }
    }

    /// Effect of one parameter on shape and scale, for the factor of their covariance: `R⁻¹ R⁻ᵀ b`.
    fn effect(&self, group: usize, component: usize, root: &Mat<T, 6, 6>) -> Mat<T, 6, 1> {
        match self.by_group.get(group).and_then(|of_group| of_group.get(component)) {
            Some(by) => times_transpose(root, by),
            None => Mat::zeros(),
        }
    }
}

/// Cross-information of the descent, the front, earlier windows and doubted ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Considered<T: Real, const C: usize> {
    /// Of the present descent and of the front, for rows of a sample's variance, about their points.
    pub descent: Cross<T, C>,
    pub front: Cross<T, C>,
    /// Rows of the front when it was fitted.
    pub fitted_rows: u32,
    /// Of unit variance, about their references.
    pub past: Cross<T, C>,
    pub doubted: Cross<T, C>,
}

crate::persist!([T: Real, const C: usize] Considered<T, C> { descent, front, fitted_rows, past, doubted });

impl<T: Real, const C: usize> Considered<T, C> {
    /// Without content: a constant, built in its place and not on the stack.
    pub const NOTHING: Self = Self {
        descent: Cross::NOTHING,
        front: Cross::NOTHING,
        fitted_rows: 0,
        past: Cross::NOTHING,
        doubted: Cross::NOTHING,
    };
}

/// Source of the cross-information of a solution beside earlier windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The present descent.
    Descent,
    /// The front.
    Front,
    /// No blocks.
    Nothing,
}

/// `R Rᵀ b` of an upper triangular R.
#[inline(never)]
fn times_transpose<T: Real>(root: &Mat<T, 6, 6>, by: &[T; 6]) -> Mat<T, 6, 1> {
    let mut product = Mat::<T, 6, 1>::zeros();
    for column in 0..6 {
        let mut sum = T::zero();
        for row in 0..column + 1 {
            sum += root.at(row, column) * by[row];
        }
        for row in 0..column + 1 {
            *product.at_mut(row, 0) += root.at(row, column) * sum;
        }
    }
    product
}

/// A parameter of a pass: its row of B, its effect on the group before it, and the sum of squares that a fit leaves of
/// its column.
type OfParameter<T> = ([T; 6], [T; 3], T);

/// B of a group in the place before the shape, by parameter.
fn cross_of<T: Real, const U: usize>(factor: &SquareRootInformation<T, U>) -> [OfParameter<T>; 3] {
    let (first, solved) = (shape_of(U).saturating_sub(3), shape_of(U).saturating_sub(6));
    let mut result = [([T::zero(); 6], [T::zero(); 3], T::zero()); 3];
    for (i, (cross, on_solved, left)) in result.iter_mut().enumerate() {
        // Solved group and shape for a parameter of one.
        let mut fit = SquareRootInformation::<T, 9>::default();
        for (row, of_row) in factor.factor.iter().enumerate().skip(solved) {
            let at = |column: usize| match of_row.get(column) {
                Some(_) if column == row => T::one(),
                Some(value) if column > row => *value,
                _ => T::zero(),
            };
            let weight = of_row.get(row).copied().unwrap_or(T::zero());
            let y = at(first + i);
            let known =
                core::array::from_fn(|k| if k < 3 { at(solved + k) } else { at(first + k) });
            if row >= first {
                for (sum, by) in cross.iter_mut().zip(known.iter().skip(3)) {
                    *sum += *by * y * weight;
                }
            }
            *left += fit.fold(&known, y, weight).square();
        }
        if let Some(solution) = fit.solve() {
            for (effect, x) in on_solved.iter_mut().zip(&solution) {
                *effect = *x;
            }
        }
    }
    result
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// Group that is considered with this index, and the sigma of each of its parameters.
    fn considered_group(&self, index: usize) -> Option<(Group, [T; 3])> {
        if index >= C {
            return None;
        }
        match self.config.considered_group::<U>(index)? {
            (group, Belief::Within(sigma)) => Some((group, sigma)),
            (_, Belief::Zero) => None,
        }
    }

    /// True where any group is considered.
    pub(super) fn considers(&self) -> bool {
        self.considered_group(0).is_some()
    }

    /// Groups of the present pass.
    #[inline(never)]
    pub(super) fn groups_of_pass(&self, considering: Considering) -> Groups<T> {
        let mut groups = self.groups;
        if let Considering::Group(index) = considering
            && let Some((group, sigma)) = self.considered_group(usize::from(index))
            && let Some(place) = groups.place.get_mut(groups_of(U).saturating_sub(1))
        {
            *place = Some((group, Belief::Within(sigma)));
        }
        groups
    }

    /// Begins the pass of the considered group with this index about the point of the descent, or the last pass.
    #[inline(never)]
    pub(super) fn consider(&mut self, index: u8) {
        let is_considered = self.considered_group(usize::from(index)).is_some();
        let Work::Descent(Descent { pass, considering, .. }) = &mut self.work else { return };
        *considering = if is_considered { Considering::Group(index) } else { Considering::Done };
        if index == 0 {
            pass.explained = T::zero();
            self.considered.descent = Cross::NOTHING;
        }
        self.repeat_pass();
    }

    /// Takes the cross-information of a group from the pass that has ended.
    #[inline(never)]
    pub(super) fn take_cross(&mut self, index: u8) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let mut factor = pass.factor;
        let sigma = self.sigma_of_sample(pass);
        let beliefs = Beliefs { noise_rad_s: sigma, ..self.beliefs(pass.unit_per_kg_m2) };
        beliefs.add_of_window(&mut factor, &pass.point);
        beliefs.add_solved(&mut factor, &pass.point);
        let cross = cross_of(&factor);
        let Some((_, sigma)) = self.considered_group(usize::from(index)) else { return };
        let rows = T::count(pass.residuals.rows.max(1));
        let squares = sigma.iter().zip(&cross);
        let squares = squares.fold(T::zero(), |sum, (s, (_, _, left))| sum + *s * *s * *left);
        let index = usize::from(index);
        let Cross { by_group, on_solved } = &mut self.considered.descent;
        if let (Some(by), Some(on)) = (by_group.get_mut(index), on_solved.get_mut(index)) {
            *by = cross.map(|(by, _, _)| by);
            *on = cross.map(|(_, on, _)| on);
        }
        if let Work::Descent(Descent { pass, .. }) = &mut self.work {
            pass.explained += squares / rows;
        }
    }

    /// Cross-information of a source and of earlier windows, over unit variance, about a point whose scale has this
    /// unit, for a sigma of a sample.
    fn total_cross(&self, source: Source, unit_per_kg_m2: T, sigma_rad_s: T) -> Cross<T, C> {
        let weight = T::one() / (sigma_rad_s * sigma_rad_s);
        let mut total = Cross::NOTHING;
        match (source, &self.front) {
            (Source::Descent, _) => total.add(&self.considered.descent, weight, T::one()),
            (Source::Front, Some(front)) => {
                let fitted = T::count(self.considered.fitted_rows.max(1));
                let grown = T::count(front.pass.residuals.rows) / fitted;
                total.add(&self.considered.front, weight * grown, T::one());
            }
            _ => {}
        }
        if let Some(past) = &self.past {
            total.add(&self.considered.past, T::one(), unit_per_kg_m2 / past.per_kg_m2);
        }
        total
    }

    /// Covariance of the elements that errors of the considered hardware cause, kg² m⁴, for a solution of the noise.
    #[inline(never)]
    pub(super) fn systematic(
        &self,
        source: Source,
        sigma_rad_s: T,
        solution: &Solution<T, U>,
    ) -> Option<Mat<T, 6, 6>> {
        if !self.considers() {
            return None;
        }
        let mut sum = Mat::<T, 6, 6>::zeros();
        let jacobian = solution.jacobian();
        let at = (solution.unit_per_kg_m2, sigma_rad_s);
        self.each_effect(source, at, &solution.root, &mut |_, _, effect, sigma| {
            let by = jacobian * effect * sigma;
            sum += by * by.transpose();
        });
        Some(sum)
    }

    /// Calls `visit` with each considered parameter, as group and component, its effect on shape and scale, and its
    /// sigma.
    pub(super) fn each_effect(
        &self,
        source: Source,
        (unit_per_kg_m2, sigma_rad_s): (T, T),
        root: &Mat<T, 6, 6>,
        visit: &mut dyn FnMut(Group, usize, Mat<T, 6, 1>, T),
    ) {
        let cross = self.total_cross(source, unit_per_kg_m2, sigma_rad_s);
        for index in 0..C {
            let Some((group, sigma)) = self.considered_group(index) else { break };
            for (i, sigma) in sigma.into_iter().enumerate() {
                if sigma > T::zero() {
                    visit(group, i, cross.effect(index, i, root), sigma);
                }
            }
        }
    }

    /// Variance of a component of the solved group before the considered ones that their errors cause.
    pub(super) fn variance_of_solved(&self, place: usize, component: usize) -> T {
        let mut variance = T::zero();
        if place + 2 != groups_of(U) {
            return variance;
        }
        for (index, of_group) in self.considered.front.on_solved.iter().enumerate() {
            let Some((_, sigma)) = self.considered_group(index) else { break };
            for (effect, sigma) in of_group.iter().zip(sigma) {
                let by = effect.get(component).copied().unwrap_or(T::zero()) * sigma;
                variance += by * by;
            }
        }
        variance
    }

    /// Widens the information of the front's window on shape and scale by the difference that the considered hardware
    /// makes between it and earlier windows: before a test whether they contradict each other.
    #[inline(never)]
    pub(super) fn widen(
        &self,
        window: &mut SquareRootInformation<T, U>,
        (unit_per_kg_m2, sigma_rad_s): (T, T),
        past: Option<(&Past<T, U>, &Cross<T, C>)>,
    ) {
        if !self.considers() {
            return;
        }
        let (mut alone, mut of_past) = (Mat::<T, 6, 6>::zeros(), Mat::<T, 6, 6>::zeros());
        if !window.covariance_factor_of_last(&mut alone) {
            return;
        }
        let past =
            past.filter(|(past, _)| past.information.covariance_factor_of_last(&mut of_past));
        for index in 0..C {
            let Some((_, sigma)) = self.considered_group(index) else { break };
            for (i, sigma) in sigma.into_iter().enumerate() {
                if sigma <= T::zero() {
                    continue;
                }
                let mut apart = self.considered.front.effect(index, i, &alone);
                if let Some((past, cross)) = past {
                    let mut by_past = cross.effect(index, i, &of_past);
                    *by_past.at_mut(5, 0) *= past.per_kg_m2 / unit_per_kg_m2;
                    apart -= by_past;
                }
                let mut along = [T::zero(); U];
                for (along, apart) in along.iter_mut().skip(shape_of(U)).zip(apart.as_slice()) {
                    *along = *apart;
                }
                let share = sigma / sigma_rad_s;
                window.walk_along(&along, U - 1, share * share);
            }
        }
    }

    /// The cross-information of the descent becomes that of the front.
    pub(super) fn take_front_cross(&mut self, rows: u32) {
        self.considered.front = self.considered.descent;
        self.considered.fitted_rows = rows;
    }

    /// That of a source, for a sigma of a sample and about a point of this scale, becomes that of earlier windows, with
    /// theirs.
    pub(super) fn join_cross(
        &mut self,
        source: Source,
        (unit_per_kg_m2, scale): (T, T),
        sigma_rad_s: T,
    ) {
        let total = self.total_cross(source, unit_per_kg_m2, sigma_rad_s);
        let mut joined = Cross::NOTHING;
        joined.add(&total, T::one(), scale);
        self.considered.past = joined;
    }

    /// That of the descent becomes that of what is doubted.
    pub(super) fn doubt_cross(&mut self, scale: T, sigma_rad_s: T) {
        let mut doubted = Cross::NOTHING;
        doubted.add(&self.considered.descent, T::one() / (sigma_rad_s * sigma_rad_s), scale);
        self.considered.doubted = doubted;
    }

    /// That of earlier windows joins that of what is doubted.
    pub(super) fn doubt_past_cross(&mut self) {
        match (&self.doubted, &self.past) {
            (Some(doubted), Some(past)) => {
                let per = doubted.per_kg_m2 / past.per_kg_m2;
                let of_past = self.considered.past;
                self.considered.doubted.add(&of_past, T::one(), per);
            }
            (None, _) => self.considered.doubted = self.considered.past,
            (Some(_), None) => {}
        }
    }

    /// Mean square of a residual that errors of the considered hardware explain, at most, rad²/s².
    pub(super) fn explained(&self, pass: &Pass<T, W, U, M>) -> T {
        pass.explained * T::lit(EXPLAINED_SQUARE)
    }
}
