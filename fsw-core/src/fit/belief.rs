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

use crate::math::scalar::Real;
use crate::math::square_root_information::{SquareRootInformation, unit_row};
use crate::monitor::whiteness::chi_square;
use crate::prior::Prior;
use crate::trajectory::unknowns::{
    Belief, FIRST_GROUP, GROUPS, Group, Groups, Point, groups_of, scale_of, shape_of, to_shape,
};

/// Sigma of each coordinate of the shape over all physical tensors: principal moments over the trace
/// lie in (0, ½), and uniform over that triangle the coordinates have a sigma of 0.14.
pub const SHAPE_SIGMA: f64 = 0.15;
/// Sigma of the inverse trace over its unit where nothing is known: a factor of ten, ln 10.
pub const SCALE_SIGMA: f64 = 2.3;
/// Chi-square of six degrees of freedom that chance exceeds once in 10⁵: two tensors contradict each
/// other.
pub const CONTRADICTED: f64 = 33.0;
/// Normal variable that chance exceeds once in 10⁵.
pub const RARE: f64 = 4.265;
/// Sigma of hardware that is held over the stated one.
const HELD: f64 = 1e-3;
/// Information of a constraint over that of the data on the same unknown.
const CONSTRAINT: f64 = 1e5;

/// Variance of each coordinate of shape and scale after a random walk of the elements, over `κ² σ²`.
pub const WALKED: [u32; 6] = [1, 1, 2, 2, 2, 3];

/// Information of earlier windows on the inertia and the hardware, of unit variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Past<T: Real, const U: usize> {
    /// Reference: a point of unit scale, and the inverse trace there, 1/(kg m²).
    pub point: Point<T, U>,
    pub per_kg_m2: T,
    /// `R δ = d` for a step δ of hardware, shape and inverse trace over its reference. The rows of the other
    /// unknowns pin them to zero.
    pub information: SquareRootInformation<T, U>,
}

crate::persist!([T: Real, const U: usize] Past<T, U> { point, per_kg_m2, information } if |this| this.per_kg_m2 > T::zero());

impl<T: Real, const U: usize> Past<T, U> {
    /// Forgets by a random walk of each element, one sigma, kg m².
    ///
    /// `δq = κ B δj` and `δκ = −κ² δtr`: variances `κ² σ²` of a moment's coordinate, `2 κ² σ²` of a
    /// product's, and `3 κ² σ²` of the inverse trace over itself.
    pub fn walk(&mut self, sigma_kg_m2: T) {
        let share = self.per_kg_m2 * sigma_kg_m2;
        let variance = share * share;
        if variance > T::zero() {
            for (place, times) in WALKED.into_iter().enumerate() {
                self.information.walk(shape_of(U) + place, variance * T::count(times));
            }
        }
    }

    /// Point at the best estimate by this alone for hardware as at the reference, with the inverse trace over
    /// `unit`.
    pub fn point(&self, unit_per_kg_m2: T) -> Option<Point<T, U>> {
        let mut six = SquareRootInformation::<T, 6>::default();
        for index in FIRST_GROUP..U {
            let of_index = &self.information.factor[index];
            let mut row = [T::zero(); 6];
            for (k, u) in row.iter_mut().enumerate() {
                let column = shape_of(U) + k;
                *u = if column == index { T::one() } else { of_index[column] };
            }
            six.fold(&row, self.information.right_hand_side[index], of_index[index]);
        }
        let step = six.solve()?;
        let mut point = self.point;
        let shape = point.shape();
        point.set_shape(&core::array::from_fn(|k| shape[k] + step[k]));
        let scale = (T::one() + step[5]).max(T::lit(0.2)) * self.per_kg_m2 / unit_per_kg_m2;
        point.set_scale(scale);
        Some(point)
    }

    /// Replaces `past` by the information of a window on what lasts, about `point` and of unit variance. False where
    /// that is not finite; `past` is unchanged then.
    #[inline(never)]
    pub fn replace(
        past: &mut Option<Self>,
        window: &mut SquareRootInformation<T, U>,
        point: &Point<T, U>,
        unit_per_kg_m2: T,
    ) -> bool {
        // Scale over its value at the point.
        let (last, scale) = (scale_of(U), point.scale());
        for row in window.factor.iter_mut().take(last) {
            row[last] *= scale;
        }
        window.factor[last][last] *= scale * scale;
        window.right_hand_side[last] /= scale;
        if !window.factor.iter().flatten().all(|x| x.is_finite()) {
            return false;
        }
        let per_kg_m2 = scale * unit_per_kg_m2;
        match past {
            // In its place: without a copy on the stack.
            Some(past) => {
                (past.point, past.per_kg_m2) = (*point, per_kg_m2);
                past.information = *window;
                past.point.set_scale(T::one());
            }
            None => {
                let mut point = *point;
                point.set_scale(T::one());
                *past = Some(Self { point, per_kg_m2, information: *window });
            }
        }
        true
    }

    /// Adds this to the information of a window, of unit variance, about `point`.
    #[inline(never)]
    pub fn add_to(
        &self,
        window: &mut SquareRootInformation<T, U>,
        groups: &Groups<T>,
        point: &Point<T, U>,
        unit_per_kg_m2: T,
    ) {
        for index in FIRST_GROUP..U {
            let (row, y, weight) = self.row(index, groups, point, unit_per_kg_m2);
            window.fold(&row, y, weight);
        }
    }

    /// Joins the information of other windows, in place.
    pub fn join(&mut self, other: &Self, groups: &Groups<T>) {
        // The scale of the reference is one: both its unit and its value stay.
        other.add_to(&mut self.information, groups, &self.point, self.per_kg_m2);
    }

    /// Row `index` of the information as one on the unknowns of a fit at `point`.
    ///
    /// # Common scale of body and drive
    ///
    /// Spin inertias, known torque and tensor times a common factor show in no motion: the information is zero along
    /// `g = (1 + s, 1 + t, −ξ)`, for shares s and t of the drive and ξ the inverse trace over that of the reference. But it is so along the g of its reference, and g is
    /// another one at `point`. Along a difference of `Δs`, information of a relative σ would show the factor to `σ / Δs`. Column
    /// ξ is therefore such that a row has the same product with g at both:
    ///
    /// `u'_ξ = u_ξ + u · (g_reference − g) / −ξ = u_ξ + (Σ u_s Δs − u_ξ Δξ) / ξ`
    ///
    /// \[Huang2010\]. Information that a motion does give, where a drive is known exactly, stays as it is. The
    /// right-hand side takes the mean of both columns, which leaves an error of third order in the distance.
    #[inline(never)]
    pub(super) fn row(
        &self,
        index: usize,
        groups: &Groups<T>,
        point: &Point<T, U>,
        unit_per_kg_m2: T,
    ) -> ([T; U], T, T) {
        let (index, last) = (index.min(scale_of(U)), scale_of(U));
        let (to_relative, half) = (unit_per_kg_m2 / self.per_kg_m2, T::lit(0.5));
        let factor = &self.information.factor[index];
        let (mut row, mut y) = ([T::zero(); U], self.information.right_hand_side[index]);
        for k in index..last {
            let u = if k == index { T::one() } else { factor[k] };
            row[k] = u;
            y -= u * (point.value(k) - self.point.value(k));
        }
        let mut by_drive = T::zero();
        groups.each_share_of_drive::<U>(|k| {
            let u = row.get(k).copied().unwrap_or(T::zero());
            by_drive += u * (point.value(k) - self.point.value(k));
        });
        let u = if index == last { T::one() } else { factor[last] };
        let relative = point.scale() * to_relative;
        let away = relative - T::one();
        let turned = (by_drive - u * away) / relative;
        row[last] = (u + turned) * to_relative;
        y -= (u + turned * half) * away;
        (row, y, factor[index])
    }
}

/// Everything that is known beside the blocks.
#[derive(Clone, Copy, Debug)]
pub struct Beliefs<'a, T: Real, const U: usize> {
    pub groups: &'a Groups<T>,
    pub prior: Option<&'a Prior<T>>,
    pub past: Option<&'a Past<T, U>>,
    /// κᵤ of the fit, 1/(kg m²).
    pub unit_per_kg_m2: T,
    /// One sigma of a sample, rad/s: rows are in units of its variance.
    pub noise_rad_s: T,
    /// True where the hardware is held at its point: at first a descent is far from the solution, and errors of
    /// the hardware would take part in that.
    pub holds_hardware: bool,
    /// True where the modes are held without inertia: until the data show them.
    pub holds_modes: bool,
    /// One sigma of the gyro bias' walk over the window, rad/s: the unknown is the newest bias, and its range is
    /// that of the first one.
    pub bias_walked_rad_s: T,
    /// True where the last pass of a descent lets the torque walk.
    pub has_varying_torque: bool,
    /// True where the inertia walks in the last passes.
    pub has_varying_inertia: bool,
}

impl<T: Real, const U: usize> Beliefs<'_, T, U> {
    /// Adds all rows to a factor about `point`. Returns the contradiction of each group that is tested,
    /// chi-square of three degrees of freedom; zero for the others.
    #[inline(never)]
    pub fn add(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T, U>,
    ) -> [T; GROUPS] {
        self.add_kept(factor, point);
        self.add_of_window(factor, point)
    }

    /// Adds the rows on the groups that belong to one window. Returns as [`add`](Self::add).
    #[inline(never)]
    pub fn add_of_window(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T, U>,
    ) -> [T; GROUPS] {
        self.each_of_places(0..self.groups.hardware, point, &mut |row, y, weight| {
            factor.fold(row, y, weight);
        });
        self.constrain(factor, point)
    }

    /// Adds the rows on what lasts from window to window: hardware and inertia.
    #[inline(never)]
    pub fn add_kept(&self, factor: &mut SquareRootInformation<T, U>, point: &Point<T, U>) {
        self.add_hardware(factor, point);
        self.each_of_inertia(point, &mut |row, y, weight| {
            factor.fold(row, y, weight);
        });
    }

    /// Adds the rows of earlier windows and of the prior to the information of a window.
    #[inline(never)]
    pub fn add_known(&self, window: &mut SquareRootInformation<T, U>, point: &Point<T, U>) {
        self.each_known(point, &mut |row, y, weight| {
            window.fold(row, y, weight);
        });
    }

    /// Adds the rows on the hardware alone.
    #[inline(never)]
    pub fn add_hardware(&self, factor: &mut SquareRootInformation<T, U>, point: &Point<T, U>) {
        self.each_of_places(self.groups.hardware..GROUPS, point, &mut |row, y, weight| {
            factor.fold(row, y, weight);
        });
    }

    /// Adds the rows on the hardware before the last place, which considered groups take in turn.
    #[inline(never)]
    pub fn add_solved(&self, factor: &mut SquareRootInformation<T, U>, point: &Point<T, U>) {
        let last = groups_of(U).saturating_sub(1);
        self.each_of_places(self.groups.hardware..last, point, &mut |row, y, weight| {
            factor.fold(row, y, weight);
        });
    }

    /// Sum of squares that earlier windows and the prior leave when added to the information of a
    /// window on what lasts and to the stated hardware, over the noise: chi-square of six degrees of freedom each, and
    /// one for each parameter of the hardware. They are added to `window`.
    #[inline(never)]
    pub fn contradiction(
        &self,
        window: &mut SquareRootInformation<T, U>,
        point: &Point<T, U>,
    ) -> T {
        let mut sum = T::zero();
        self.each_known(point, &mut |row: &[T; U], y, weight| {
            sum += window.fold(row, y, weight).square();
        });
        sum / (self.noise_rad_s * self.noise_rad_s)
    }

    /// Value of the [`contradiction`](Self::contradiction) that chance exceeds once in 10⁵.
    pub fn contradicted(&self) -> T {
        if groups_of(U) == 0 {
            return T::lit(CONTRADICTED);
        }
        let hardware = self.groups.unknowns_from::<U>(self.groups.hardware);
        if hardware == 0 { T::lit(CONTRADICTED) } else { chi_square(6 + hardware, RARE) }
    }

    /// Sum of squares of all rows at a point, rad²/s²: zero where each belief is met.
    #[inline(never)]
    pub fn cost(&self, point: &Point<T, U>) -> T {
        let mut sum = T::zero();
        self.each_of_places(0..GROUPS, point, &mut |_, y, weight| sum += y * y * weight);
        self.each_of_inertia(point, &mut |_, y, weight| sum += y * y * weight);
        sum
    }

    /// Calls `add` with each row on the groups in these places, its right-hand side and weight.
    #[inline(never)]
    fn each_of_places(
        &self,
        places: core::ops::Range<usize>,
        point: &Point<T, U>,
        add: &mut dyn FnMut(&[T; U], T, T),
    ) {
        let variance = self.noise_rad_s * self.noise_rad_s;
        for place in places.start..places.end.min(groups_of(U)) {
            for i in 0..3 {
                let sigma = match self.groups.place[place] {
                    Some((_, Belief::Zero)) => continue,
                    Some((Group::Torque | Group::Field(_), Belief::Within(sigma))) => {
                        sigma[i] * self.unit_per_kg_m2 * point.scale()
                    }
                    Some((Group::Bias, Belief::Within(sigma))) => self.of_bias(sigma[i]),
                    Some((_, Belief::Within(sigma))) => sigma[i],
                    None => T::zero(),
                };
                let is_held = if self.groups.is_of_mode(place) {
                    self.holds_modes
                } else {
                    self.holds_hardware && place >= self.groups.hardware
                };
                let sigma = if is_held { sigma * T::lit(HELD) } else { sigma };
                let column = FIRST_GROUP + 3 * place + i;
                let mut row = unit_row(column);
                let variance_of_row = match self.groups.by_clock(column, &places) {
                    Some(by_clock) => {
                        let of_row = self.beside_clock(&mut row, column, by_clock, &places);
                        if is_held { of_row * T::lit(HELD * HELD) } else { of_row }
                    }
                    None => sigma * sigma,
                };
                // A place that is not in use has an empty column, and any weight pins it.
                let is_unknown = variance_of_row > T::zero();
                let weight = if is_unknown { variance / variance_of_row } else { T::one() };
                let y = (0..U).zip(&row).fold(T::zero(), |y, (k, u)| y - *u * point.value(k));
                add(&row, y, weight);
            }
        }
    }

    /// Subtracts from the row of an unknown its expectation by the unknowns after it, with which it shares the clock's error.
    /// Returns the variance of the difference. The rows of all such unknowns are their joint prior: for `vₖ = aₖ c + eₖ` with variances `C` of c and
    /// `σₖ²` of eₖ, `E[c | vⱼ, j > k] = Σ aⱼ vⱼ / σⱼ² / (1 / C + Σ aⱼ² / σⱼ²)`.
    #[inline(never)]
    fn beside_clock(
        &self,
        row: &mut [T; U],
        column: usize,
        (by, rest): (T, T),
        places: &core::ops::Range<usize>,
    ) -> T {
        let mut information = T::one() / (self.groups.clock * self.groups.clock);
        for (k, of_column) in row.iter_mut().enumerate().skip(column + 1) {
            if let Some((by, rest)) = self.groups.by_clock(k, places) {
                *of_column = by / rest;
                information += by * by / rest;
            }
        }
        for of_column in row.iter_mut().skip(column + 1) {
            *of_column *= -by / information;
        }
        rest + by * by / information
    }

    /// Sigma of the newest bias for that of the first one, rad/s.
    fn of_bias(&self, sigma: T) -> T {
        let walked = self.bias_walked_rad_s;
        if walked > T::zero() { (sigma * sigma + walked * walked).sqrt() } else { sigma }
    }

    /// Calls `add` with each row of earlier windows and of the prior, its right-hand side and weight.
    /// Not inlined, as the others: one function for all that add them.
    #[inline(never)]
    fn each_known(&self, point: &Point<T, U>, add: &mut dyn FnMut(&[T; U], T, T)) {
        let variance = self.noise_rad_s * self.noise_rad_s;
        if let Some(past) = self.past {
            for index in self.groups.first_kept::<U>()..U {
                let (row, y, weight) = past.row(index, self.groups, point, self.unit_per_kg_m2);
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
    #[inline(never)]
    fn each_of_inertia(&self, point: &Point<T, U>, add: &mut dyn FnMut(&[T; U], T, T)) {
        let variance = self.noise_rad_s * self.noise_rad_s;
        self.each_known(point, add);
        let centre = self.prior.map_or([T::zero(); 5], shape_of_prior);
        for k in 0..5 {
            let row = unit_row(shape_of(U) + k);
            let weight = variance * T::lit(1.0 / (SHAPE_SIGMA * SHAPE_SIGMA));
            add(&row, centre[k] - point.shape()[k], weight);
        }
        if self.prior.is_none() {
            // On the logarithm, with ln x ≈ 2 (x − 1) / (x + 1).
            let (one, two) = (T::one(), T::lit(2.0));
            let mut row = [T::zero(); U];
            let scale = point.scale();
            row[scale_of(U)] = one / scale;
            let y = two * (one - scale) / (one + scale);
            add(&row, y, variance * T::lit(1.0 / (SCALE_SIGMA * SCALE_SIGMA)));
        }
    }

    /// Row of one element of the prior, in kg m².
    fn prior_row(&self, prior: &Prior<T>, element: usize, point: &Point<T, U>) -> ([T; U], T) {
        let element = element.min(5);
        let trace = T::one() / (point.scale() * self.unit_per_kg_m2);
        let mut row = [T::zero(); U];
        row[shape_of(U)..].copy_from_slice(&point.of_element(element, trace));
        (row, prior.inertia_kg_m2[element] - point.over_trace()[element] * trace)
    }

    /// Constrains the groups that are tested to zero; returns the squares that this adds over the noise.
    fn constrain(
        &self,
        factor: &mut SquareRootInformation<T, U>,
        point: &Point<T, U>,
    ) -> [T; GROUPS] {
        let mut contradiction = [T::zero(); GROUPS];
        let one_over_variance = T::one() / (self.noise_rad_s * self.noise_rad_s);
        for place in 0..groups_of(U) {
            if !matches!(self.groups.place[place], Some((_, Belief::Zero))) {
                continue;
            }
            for i in 0..3 {
                let column = FIRST_GROUP + 3 * place + i;
                let row = unit_row(column);
                let weight = information_on(factor, column) * T::lit(CONSTRAINT);
                let weight = if weight > T::zero() { weight } else { T::one() };
                let left = factor.fold(&row, -point.value(column), weight);
                contradiction[place] += left.square() * one_over_variance;
            }
        }
        contradiction
    }
}

/// Squared norm of a column of R: the information on one unknown with all others known.
pub fn information_on<T: Real, const U: usize>(
    factor: &SquareRootInformation<T, U>,
    column: usize,
) -> T {
    information_from(0, factor, column)
}

/// The same with the unknowns before `first` eliminated.
pub fn information_from<T: Real, const U: usize>(
    first: usize,
    factor: &SquareRootInformation<T, U>,
    column: usize,
) -> T {
    let (mut sum, column) = (T::zero(), column.min(U.saturating_sub(1)));
    for i in first..column {
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
    const UNIT: f64 = 1.0 / 9.0;

    fn of_nothing<const U: usize>(groups: &Groups<f64>) -> Beliefs<'_, f64, U> {
        Beliefs {
            groups,
            prior: None,
            past: None,
            unit_per_kg_m2: UNIT,
            noise_rad_s: 1e-3,
            holds_hardware: false,
            holds_modes: false,
            bias_walked_rad_s: 0.0,
            has_varying_torque: false,
            has_varying_inertia: false,
        }
    }

    /// A fit without blocks ends at the prior, with its covariance.
    #[test]
    fn without_blocks_the_prior_is_the_estimate() {
        let mut point = Point::<f64, 9>::sphere(crate::math::Vec3::zeros());
        let groups = Groups::none();
        let beliefs = Beliefs { prior: Some(&PRIOR), ..of_nothing(&groups) };
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
        let trace = 1.0 / (point.scale() * UNIT);
        for i in 0..6 {
            let (found, prior) = (point.over_trace()[i] * trace, PRIOR.inertia_kg_m2[i]);
            assert!((found - prior).abs() < 0.02 * PRIOR.sigma_kg_m2[i], "{i}: {found} {prior}");
        }
    }

    /// Variance after a walk against the sum of covariances.
    #[test]
    fn a_walk_adds_to_the_covariance() {
        let mut past = Past {
            point: Point::<f64, 9>::sphere(crate::math::Vec3::zeros()),
            per_kg_m2: UNIT,
            information: SquareRootInformation::of_each([0.0; 9], [1e4; 9]),
        };
        past.walk(0.05);
        let variances = past.information.variances().unwrap();
        let share = (0.05f64 / 9.0).powi(2);
        for (k, times) in [1.0, 1.0, 2.0, 2.0, 2.0, 3.0].into_iter().enumerate() {
            assert!((variances[3 + k] - 1e-4 - times * share).abs() < 1e-12);
        }
    }

    /// Earlier windows that know all but a common scale of body and drive to 1e-6, seen from a point with other shares: of
    /// the scale they know nothing there either, and a point that differs by the scale alone fits them as well. With the columns of
    /// the reference they would know it to 1e-4.
    #[test]
    fn earlier_windows_show_no_scale_of_body_and_drive_at_any_point() {
        const U: usize = 18;
        const SIGMA: f64 = 1e-6;
        let mut groups = Groups::none();
        groups.hardware = 0;
        let places = [Group::Wheel(0), Group::Wheel(1), Group::Common];
        for (place, group) in groups.place.iter_mut().zip(places) {
            *place = Some((group, Belief::Within([0.01; 3])));
        }
        let shares = [3, 6, 10, 11];
        let mut reference = Point::<f64, U>::sphere(crate::math::Vec3::zeros());
        for (k, share) in shares.into_iter().zip([0.008, -0.005, 0.02, 0.003]) {
            reference.set_value(k, share);
        }
        // Along `g`: the factor of each wheel by its own error, of all by the common one, of the torque by its error.
        let along = |point: &Point<f64, U>, scale: f64| {
            let mut g = [0.0; U];
            (g[3], g[6]) = (point.value(3), point.value(6));
            (g[10], g[11]) = (1.0 + point.value(10), 1.0 + point.value(11));
            g[scale_of(U)] = -scale;
            g
        };
        let mut normal = crate::estimator::test_hardware::normal(1);
        let g = along(&reference, 1.0);
        let mut information = SquareRootInformation::<f64, U>::default();
        for _ in 0..40 {
            let mut row: [f64; U] = core::array::from_fn(|k| if k < 3 { 0.0 } else { normal() });
            row[scale_of(U)] += row.iter().zip(&g).map(|(u, g)| u * g).sum::<f64>();
            information.fold(&row, 0.0, 1.0 / (SIGMA * SIGMA));
        }
        let past = Past { point: reference, per_kg_m2: UNIT, information };
        let knows = |point: &Point<f64, U>| {
            let scale = point.scale();
            let (mut of_scale, mut cost) = (0.0, 0.0);
            for index in FIRST_GROUP..U {
                let (row, y, weight) = past.row(index, &groups, point, UNIT);
                let along = along(point, scale);
                let product: f64 = row.iter().zip(along).map(|(u, g)| u * g).sum();
                of_scale += product * product * weight;
                cost += y * y * weight;
            }
            (of_scale.sqrt().recip(), cost)
        };
        // The same motion: all shares times a factor.
        let factor = 1.005;
        let mut scaled = reference;
        for k in [3, 6] {
            scaled.set_value(k, reference.value(k) * factor);
        }
        for k in [10, 11] {
            scaled.set_value(k, (1.0 + reference.value(k)) * factor - 1.0);
        }
        scaled.set_scale(1.0 / factor);
        let (sigma, cost) = knows(&scaled);
        assert!(sigma > 1e3 && cost < 1.0, "{sigma} {cost}");
        // Another motion, which they exclude.
        let mut other = scaled;
        other.set_value(3, 0.02);
        other.set_scale(0.98);
        let (sigma, cost) = knows(&other);
        assert!(sigma > 1e3 && cost > 1e6, "{sigma} {cost}");
    }

    /// Rows on hardware with a clock's error are the inverse of the covariance `diag(σ²) + C a aᵀ`.
    #[test]
    fn a_clock_correlates_scale_factors_wheels_and_torque() {
        const U: usize = 15;
        let (clock, own) = (3e-3, [2e-3, 4e-3]);
        let mut groups = Groups::none();
        groups.hardware = 0;
        groups.clock = clock;
        let with_clock = |own: f64, by: f64| own.hypot(by * clock);
        let common = [5e-3, with_clock(own[0], 2.0), with_clock(0.0, 1.0)];
        groups.place[0] = Some((Group::Common, Belief::Within(common)));
        groups.place[1] = Some((Group::GyroScale, Belief::Within([with_clock(own[1], 1.0); 3])));
        let beliefs = Beliefs { groups: &groups, noise_rad_s: 1e-4, ..of_nothing(&groups) };
        let point = Point::<f64, U>::sphere(crate::math::Vec3::zeros());
        let mut factor = SquareRootInformation::<f64, U>::default();
        for column in (0..3).chain(shape_of(U)..U) {
            let mut row = [0.0; U];
            row[column] = 1.0;
            factor.fold(&row, 0.0, 1.0);
        }
        beliefs.add_hardware(&mut factor, &point);
        let by = [0.0, -2.0, -1.0, 1.0, 1.0, 1.0];
        let variance = [common[0], own[0], 1e-3 * clock, own[1], own[1], own[1]];
        for i in 0..6 {
            let mut unit = [0.0; U];
            unit[FIRST_GROUP + i] = 1.0;
            let covariance = factor.solve_normal(&unit).unwrap();
            for k in 0..6 {
                let diagonal = if i == k { variance[i] * variance[i] } else { 0.0 };
                let expected = diagonal + clock * clock * by[i] * by[k];
                let found = covariance[FIRST_GROUP + k] * 1e-8;
                assert!(
                    (found - expected).abs() < 1e-9 * clock * clock,
                    "{i} {k} {found} {expected}"
                );
            }
        }
    }

    /// A sigma of any size gives finite rows in single precision, denormal numbers included.
    #[test]
    fn rows_of_any_clock_are_finite() {
        const U: usize = 15;
        for exponent in -45..1 {
            let clock = 10f32.powi(exponent);
            let mut groups = Groups::<f32>::none();
            (groups.hardware, groups.clock) = (0, clock);
            let sigma = [5e-3, (2.0 * clock).hypot(1e-3), clock];
            groups.place[0] = Some((Group::Common, Belief::Within(sigma)));
            groups.place[1] = Some((Group::GyroScale, Belief::Within([clock; 3])));
            let beliefs = Beliefs {
                groups: &groups,
                prior: None,
                past: None,
                unit_per_kg_m2: 1.0,
                noise_rad_s: 1e-4,
                holds_hardware: false,
                holds_modes: false,
                bias_walked_rad_s: 0.0,
                has_varying_torque: false,
                has_varying_inertia: false,
            };
            let point = Point::<f32, U>::sphere(crate::math::Vec3::zeros());
            beliefs.each_of_places(0..2, &point, &mut |row, y, weight| {
                let is_finite = row.iter().all(|u| u.is_finite()) && y.is_finite();
                assert!(
                    is_finite && weight > 0.0 && weight.is_finite(),
                    "{clock}: {row:?} {weight}"
                );
            });
        }
    }
}
