//! Knowledge beside the blocks of a window, as rows of its factor: prior, earlier windows, ranges.
//!
//! | knowledge | rows | on |
//! |---|---|---|
//! | range of a group in use | 3 | torque, bias, drag |
//! | place without a group | 3 | a unit value that pins it to zero |
//! | earlier windows | 6 | shape and scale |
//! | prior of the configuration | 6 | the six elements, linearised at the point |
//! | ranges of any rigid body | 6 | shape; scale where there is no prior |
//! | group that is tested | 3 | constrained to zero; the contradiction is the test |
//!
//! The ranges of any rigid body hold every direction that neither data nor prior determine.

use super::unknowns::{
    Belief, FIRST_GROUP, GROUPS, Group, Groups, Point, by_shape, groups_of, scale_of, shape_of,
    to_shape,
};
use crate::math::scalar::Real;
use crate::math::square_root_information::SquareRootInformation;
use crate::prior::Prior;

/// Sigma of each coordinate of the shape over all physical tensors: principal moments over the trace
/// lie in (0, ½), and uniform over that triangle the coordinates have a sigma of 0.14.
pub const SHAPE_SIGMA: f64 = 0.15;
/// Sigma of the inverse trace over its unit where nothing is known: a factor of ten, ln 10.
pub const SCALE_SIGMA: f64 = 2.3;
/// Chi-square of six degrees of freedom that chance exceeds once in 10⁵: two tensors contradict each
/// other.
pub const CONTRADICTED: f64 = 33.0;
/// Information of a constraint over that of the data on the same unknown.
const CONSTRAINT: f64 = 1e5;

/// Variance of each coordinate of shape and scale after a random walk of the elements, over `κ² σ²`.
pub const WALKED: [u32; 6] = [1, 1, 2, 2, 2, 3];

/// Information of earlier windows on the inertia, of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past<T: Real> {
    /// Shape of reference, and inverse trace of reference, 1/(kg m²).
    pub shape: [T; 5],
    pub per_kg_m2: T,
    /// `R δ = d` for a step δ of shape and of the inverse trace over its reference.
    pub information: SquareRootInformation<T, 6>,
}

crate::persist!([T: Real] Past<T> { shape, per_kg_m2, information } if |this| this.per_kg_m2 > T::zero());

impl<T: Real> Past<T> {
    /// Forgets by a random walk of each element, one sigma, kg m².
    ///
    /// `δq = κ B δj` and `δκ = −κ² δtr`: variances `κ² σ²` of a moment's coordinate, `2 κ² σ²` of a
    /// product's, and `3 κ² σ²` of the inverse trace over itself.
    pub fn walk(&mut self, sigma_kg_m2: T) {
        let share = self.per_kg_m2 * sigma_kg_m2;
        let variance = share * share;
        if variance > T::zero() {
            for (place, times) in WALKED.into_iter().enumerate() {
                self.information.walk(place, variance * T::count(times));
            }
        }
    }

    /// Point at the best estimate by this alone, with the inverse trace over `unit`.
    pub fn point(&self, unit_per_kg_m2: T) -> Option<Point<T>> {
        let step = self.information.solve()?;
        let mut point = Point::sphere(crate::math::Vec3::zeros());
        point.shape = core::array::from_fn(|k| self.shape[k] + step[k]);
        point.scale = (T::one() + step[5]).max(T::lit(0.2)) * self.per_kg_m2 / unit_per_kg_m2;
        Some(point)
    }

    /// Information of a window on shape and scale, joined with that of earlier windows where there are
    /// some: `window` is about `point`, of unit variance.
    pub fn joined(
        mut window: SquareRootInformation<T, 6>,
        point: &Point<T>,
        unit_per_kg_m2: T,
        earlier: Option<&Self>,
    ) -> Self {
        if let Some(past) = earlier {
            for index in 0..6 {
                let (row, y, weight) = past.row(index, point, unit_per_kg_m2);
                window.fold(&row, y, weight);
            }
        }
        // Scale over its value at the point.
        let scale = point.scale;
        for i in 0..5 {
            window.factor[i][5] *= scale;
        }
        window.factor[5][5] *= scale * scale;
        window.right_hand_side[5] /= scale;
        Self { shape: point.shape, per_kg_m2: scale * unit_per_kg_m2, information: window }
    }

    /// The same joined with the information of other windows, where there are some.
    pub fn joined_with(&self, other: Option<&Self>) -> Self {
        let mut point = Point::sphere(crate::math::Vec3::zeros());
        point.shape = self.shape;
        Self::joined(self.information, &point, self.per_kg_m2, other)
    }

    /// False where a number is not finite.
    pub fn is_finite(&self) -> bool {
        self.information.factor.iter().flatten().all(|x| x.is_finite())
    }

    /// Row `index` of the information as one on the unknowns of a fit at `point`.
    fn row<const U: usize>(&self, index: usize, point: &Point<T>, unit: T) -> ([T; U], T, T) {
        let index = index.min(5);
        let factor = &self.information.factor[index];
        let (mut row, mut y) = ([T::zero(); U], self.information.right_hand_side[index]);
        for k in index..6 {
            let u = if k == index { T::one() } else { factor[k] };
            let is_scale = k == 5;
            row[shape_of(U) + k] = if is_scale { u * unit / self.per_kg_m2 } else { u };
            let away = if is_scale {
                point.scale * unit / self.per_kg_m2 - T::one()
            } else {
                point.shape[k] - self.shape[k]
            };
            y -= u * away;
        }
        (row, y, factor[index])
    }
}

/// Everything that is known beside the blocks.
#[derive(Clone, Copy, Debug)]
pub struct Beliefs<'a, T: Real> {
    pub groups: &'a Groups<T>,
    pub prior: Option<&'a Prior<T>>,
    pub past: Option<&'a Past<T>>,
    /// κᵤ of the fit, 1/(kg m²).
    pub unit_per_kg_m2: T,
    /// One sigma of a sample, rad/s: rows are in units of its variance.
    pub noise_rad_s: T,
}

impl<T: Real> Beliefs<'_, T> {
    /// Adds all rows to a factor about `point`. Returns the contradiction of each group that is tested,
    /// chi-square of three degrees of freedom; zero for the others.
    #[inline(never)]
    pub fn add<const U: usize>(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T>,
    ) -> [T; GROUPS] {
        self.add_inertia(factor, point);
        self.add_groups(factor, point)
    }

    /// Adds the rows on further groups alone. Returns as [`add`](Self::add).
    #[inline(never)]
    pub fn add_groups<const U: usize>(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T>,
    ) -> [T; GROUPS] {
        self.each_of_groups(point, |row, y, weight| {
            factor.fold(row, y, weight);
        });
        self.constrain(factor, point)
    }

    /// Adds the rows on the inertia alone: to a factor of U unknowns, or to one of shape and scale only,
    /// U = 6.
    #[inline(never)]
    pub fn add_inertia<const U: usize>(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T>,
    ) {
        self.each_of_inertia(point, |row, y, weight| {
            factor.fold(row, y, weight);
        });
    }

    /// Adds the rows of earlier windows and of the prior to the information on shape and scale.
    #[inline(never)]
    pub fn add_known(&self, window: &mut SquareRootInformation<T, 6>, point: &Point<T>) {
        self.each_known(point, |row: &[T; 6], y, weight| {
            window.fold(row, y, weight);
        });
    }

    /// Sum of squares that earlier windows and the prior leave when added to the information of a
    /// window on shape and scale, over the noise: chi-square of six degrees of freedom each.
    #[inline(never)]
    pub fn contradiction(&self, window: &SquareRootInformation<T, 6>, point: &Point<T>) -> T {
        let mut both = *window;
        let mut sum = T::zero();
        self.each_known(point, |row: &[T; 6], y, weight| {
            sum += both.fold(row, y, weight).square();
        });
        sum / (self.noise_rad_s * self.noise_rad_s)
    }

    /// Sum of squares of all rows at a point, rad²/s²: zero where each belief is met.
    #[inline(never)]
    pub fn cost<const U: usize>(&self, point: &Point<T>) -> T {
        let mut sum = T::zero();
        self.each_of_groups::<U>(point, |_, y, weight| sum += y * y * weight);
        self.each_of_inertia::<U>(point, |_, y, weight| sum += y * y * weight);
        sum
    }

    /// Calls `add` with each row on a further group, its right-hand side and weight.
    fn each_of_groups<const U: usize>(&self, point: &Point<T>, mut add: impl FnMut(&[T; U], T, T)) {
        let variance = self.noise_rad_s * self.noise_rad_s;
        for place in 0..groups_of(U) {
            let Some(sigma) = self.sigma_of(place, point) else { continue };
            let weight = sigma.map_or(T::one(), |sigma| variance / (sigma * sigma));
            for i in 0..3 {
                let mut row = [T::zero(); U];
                row[FIRST_GROUP + 3 * place + i] = T::one();
                add(&row, -point.group[place][i], weight);
            }
        }
    }

    /// Calls `add` with each row of earlier windows and of the prior, its right-hand side and weight.
    fn each_known<const U: usize>(&self, point: &Point<T>, mut add: impl FnMut(&[T; U], T, T)) {
        let variance = self.noise_rad_s * self.noise_rad_s;
        if let Some(past) = self.past {
            for index in 0..6 {
                let (row, y, weight) = past.row(index, point, self.unit_per_kg_m2);
                add(&row, y, weight * variance);
            }
        }
        if let Some(prior) = self.prior {
            for element in 0..6 {
                let (row, y) = self.prior_row(prior, element, point);
                let sigma = prior.sigma_kg_m2[element];
                add(&row, y, variance / (sigma * sigma));
            }
        }
    }

    /// Calls `add` with each row on the inertia, its right-hand side and weight.
    fn each_of_inertia<const U: usize>(
        &self,
        point: &Point<T>,
        mut add: impl FnMut(&[T; U], T, T),
    ) {
        let variance = self.noise_rad_s * self.noise_rad_s;
        self.each_known(point, &mut add);
        let centre = self.prior.map_or([T::zero(); 5], shape_of_prior);
        for k in 0..5 {
            let mut row = [T::zero(); U];
            row[shape_of(U) + k] = T::one();
            let weight = variance * T::lit(1.0 / (SHAPE_SIGMA * SHAPE_SIGMA));
            let away = centre.get(k).zip(point.shape.get(k)).map(|(c, q)| *c - *q);
            add(&row, away.unwrap_or(T::zero()), weight);
        }
        if self.prior.is_none() {
            // On the logarithm, with ln x ≈ 2 (x − 1) / (x + 1).
            let (one, two) = (T::one(), T::lit(2.0));
            let mut row = [T::zero(); U];
            row[scale_of(U)] = one / point.scale;
            let y = two * (one - point.scale) / (one + point.scale);
            add(&row, y, variance * T::lit(1.0 / (SCALE_SIGMA * SCALE_SIGMA)));
        }
    }

    /// Sigma of a group over the trace: none where it is constrained, `Some(None)` where the place is not
    /// in use.
    fn sigma_of(&self, place: usize, point: &Point<T>) -> Option<Option<T>> {
        match self.groups.place.get(place).copied().flatten() {
            None => Some(None),
            Some((_, Belief::Zero)) => None,
            Some((Group::Torque, Belief::Within(sigma))) => {
                Some(Some(sigma * self.unit_per_kg_m2 * point.scale))
            }
            Some((_, Belief::Within(sigma))) => Some(Some(sigma)),
        }
    }

    /// Row of one element of the prior: `∂j/∂q = B / κ`, `∂j/∂x = −j / x`, in kg m².
    fn prior_row<const U: usize>(
        &self,
        prior: &Prior<T>,
        element: usize,
        point: &Point<T>,
    ) -> ([T; U], T) {
        let element = element.min(5);
        let trace = T::one() / (point.scale * self.unit_per_kg_m2);
        let mut of_element = [T::zero(); 6];
        of_element[element] = trace;
        let by = by_shape::<T, T>(&of_element);
        let mut row = [T::zero(); U];
        row[shape_of(U)..shape_of(U) + 5].copy_from_slice(&by);
        let at_point = point.over_trace()[element] * trace;
        row[scale_of(U)] = -at_point / point.scale;
        (row, prior.inertia_kg_m2[element] - at_point)
    }

    /// Constrains the groups that are tested to zero; returns the squares that this adds over the noise.
    fn constrain<const U: usize>(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T>,
    ) -> [T; GROUPS] {
        let mut contradiction = [T::zero(); GROUPS];
        let one_over_variance = T::one() / (self.noise_rad_s * self.noise_rad_s);
        for place in 0..groups_of(U) {
            if !matches!(self.groups.place[place], Some((_, Belief::Zero))) {
                continue;
            }
            for i in 0..3 {
                let column = FIRST_GROUP + 3 * place + i;
                let mut row = [T::zero(); U];
                row[column] = T::one();
                let weight = information_on(factor, column) * T::lit(CONSTRAINT);
                let weight = if weight > T::zero() { weight } else { T::one() };
                let left = factor.fold(&row, -point.group[place][i], weight);
                contradiction[place] += left.square() * one_over_variance;
            }
        }
        contradiction
    }
}

/// Information on shape and scale with all other unknowns eliminated.
pub fn last_six<T: Real, const U: usize>(
    factor: &SquareRootInformation<T, U>,
) -> SquareRootInformation<T, 6> {
    let mut six = SquareRootInformation::default();
    let first = shape_of(U);
    for i in 0..6 {
        for k in i..6 {
            six.factor[i][k] = factor.factor[first + i][first + k];
        }
        six.right_hand_side[i] = factor.right_hand_side[first + i];
    }
    six
}

/// Squared norm of a column of R: the information on one unknown with all others known.
pub fn information_on<T: Real, const U: usize>(
    factor: &SquareRootInformation<T, U>,
    column: usize,
) -> T {
    let (mut sum, column) = (T::zero(), column.min(U.saturating_sub(1)));
    for i in 0..column {
        let row = &factor.factor[i];
        sum += row[i] * row[column] * row[column];
    }
    sum + factor.factor[column][column]
}

/// Shape of a prior's tensor.
pub fn shape_of_prior<T: Real>(prior: &Prior<T>) -> [T; 5] {
    let j = prior.inertia_kg_m2;
    let trace = j[0] + j[1] + j[2];
    to_shape(&j.map(|x| x / trace))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat;

    const PRIOR: Prior<f64> = Prior {
        inertia_kg_m2: [2.0, 3.0, 4.0, 0.1, -0.1, 0.2],
        sigma_kg_m2: [0.1, 0.2, 0.3, 0.01, 0.02, 0.03],
    };
    const NO_GROUPS: Groups<f64> = Groups { place: [None; GROUPS] };
    const UNIT: f64 = 1.0 / 9.0;

    /// A fit without blocks ends at the prior, with its covariance.
    #[test]
    fn without_blocks_the_prior_is_the_estimate() {
        let mut point = Point::sphere(crate::math::Vec3::zeros());
        let beliefs = Beliefs {
            groups: &NO_GROUPS,
            prior: Some(&PRIOR),
            past: None,
            unit_per_kg_m2: UNIT,
            noise_rad_s: 1e-3,
        };
        let mut covariance = Mat::<f64, 6, 6>::zeros();
        for _ in 0..20 {
            let mut factor = SquareRootInformation::<f64, 9>::default();
            for i in 0..3 {
                let mut row = [0.0; 9];
                row[i] = 1.0;
                factor.add(row, 0.0);
            }
            assert_eq!(beliefs.add(&mut factor, &point), [0.0; GROUPS]);
            point = point.stepped(&factor.solve().unwrap());
            assert!(factor.covariance_of_last(&mut covariance));
        }
        let trace = 1.0 / (point.scale * UNIT);
        for i in 0..6 {
            let (found, prior) = (point.over_trace()[i] * trace, PRIOR.inertia_kg_m2[i]);
            assert!((found - prior).abs() < 0.02 * PRIOR.sigma_kg_m2[i], "{i}: {found} {prior}");
        }
    }

    /// Variance after a walk against the sum of covariances.
    #[test]
    fn a_walk_adds_to_the_covariance() {
        let mut past = Past {
            shape: [0.1, 0.0, 0.0, 0.02, 0.0],
            per_kg_m2: UNIT,
            information: SquareRootInformation::of_each([0.0; 6], [1e4; 6]),
        };
        past.walk(0.05);
        let variances = past.information.variances().unwrap();
        let share = (0.05f64 / 9.0).powi(2);
        for (k, times) in [1.0, 1.0, 2.0, 2.0, 2.0, 3.0].into_iter().enumerate() {
            assert!((variances[k] - 1e-4 - times * share).abs() < 1e-12);
        }
    }
}
