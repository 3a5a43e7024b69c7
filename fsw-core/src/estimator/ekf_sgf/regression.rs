//! Inertia from rates, accelerations and torques of the same instants, by linear least squares:
//! \[Kim2013\] (recursive, three moments), \[Kim2016\] Eqs. (3) to (6) (batch, six elements).
//!
//! `[G(ω̇) + ω^× G(ω)] j = τ − ḣ_w − ω × h_w`, three rows an instant. Both papers' estimators are
//! the same sums read out at different times, so both are accumulated here as one square-root
//! information factor: no stored history, and no normal matrix to lose in single precision what
//! the motion shows weakly. With the elements ordered moments first, fixing the products and
//! solving for the three moments needs no sums of its own.
//!
//! Departures from the papers: rows are weighted by the noise of their own acceleration; what is
//! believed beforehand (P₀ of \[Kim2013\]) joins when solving, fixed, so that it neither fades
//! under a forgetting factor nor lets a direction without data wind up. For \[Kim2016\], which has
//! none, it shifts a direction by `(σ_data / σ_prior)²` of the distance between the two.

use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, eigen::symmetric_eigen, scalar::Real};
use crate::prior::Prior;
use crate::tensor::{Inertia, gyroscopic_regressor, regressor};

/// Rows, at least, before their residuals are believed to tell the noise.
const RESIDUALS_COUNT: u32 = 60;

/// Weighted rows with larger elements are not of this world, and their squares would overflow in
/// single precision: the sum of their absolute values.
const LARGEST_IN_SIGMAS: f64 = 1.0e15;

/// Data over prior sigma above which a direction holds the prior. Regressor noise alone makes
/// it 0.9 to 1.1.
const SHOWN: f64 = 0.75;

/// `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)` for white v of σ on each axis.
fn noise_share<T: Real>(element: usize) -> T {
    if element < 3 { T::one() } else { T::lit(2.0) }
}

/// Which elements are solved for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Elements {
    /// The three moments, with the products at their nominal values: \[Kim2013\].
    Moments,
    /// All six: \[Kim2016\].
    All,
}

crate::persist!([] enum Elements { 0 => Moments, 1 => All });

/// What one instant of the motion says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<T: Real> {
    /// Body rate, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Its derivative, rad/s².
    pub acceleration_rad_s2: Vec3<T>,
    /// What turns the body: `τ − ḣ_w − ω × h_w`, N m.
    pub torque_n_m: Vec3<T>,
    /// One sigma of the noise in each axis of the acceleration, rad/s².
    pub acceleration_sigma_rad_s2: T,
    /// By how much the two sides of the equation are known to miss each other for another reason
    /// than that noise, N m: what a lag of the filtered rate does. Not corrected for, but owned
    /// up to in the covariance.
    pub imbalance_n_m: Vec3<T>,
}

crate::persist!([T: Real] Instant<T> {
    rate_rad_s, acceleration_rad_s2, torque_n_m, acceleration_sigma_rad_s2, imbalance_n_m
});

/// The sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regression<T: Real> {
    information: SquareRootInformation<T, 6>,
    /// Typical nominal moment, kg m²: turns noise of the acceleration into noise of a row.
    moment_kg_m2: T,
    instants: T,
    residual_square: T,
    /// `Σ Hᵀ` times the imbalance.
    imbalance: [T; 6],
}

crate::persist!([T: Real] Regression<T> {
    information, moment_kg_m2, instants, residual_square, imbalance
});

/// What the sums say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// Nominal where nothing was seen.
    pub inertia: Inertia<T>,
    /// Of the six elements, kg² m⁴. See [`Regression::solve`] for what it leaves out.
    pub covariance_kg2_m4: Mat<T, 6, 6>,
}

impl<T: Real> Regression<T> {
    /// Nothing seen yet.
    pub fn new(nominal: &Prior<T>) -> Self {
        let j = Inertia::new(nominal.inertia_kg_m2).matrix_kg_m2();
        Self {
            information: SquareRootInformation::default(),
            moment_kg_m2: (j.dot(&j) * T::lit(1.0 / 3.0)).sqrt(),
            instants: T::zero(),
            residual_square: T::zero(),
            imbalance: [T::zero(); 6],
        }
    }

    /// Weighs everything so far with `forgetting` (1 keeps all, \[Kim2013\]).
    pub fn forget(&mut self, forgetting: T) {
        if forgetting == T::one() {
            return;
        }
        self.information.forget(forgetting);
        self.instants *= forgetting;
        self.residual_square *= forgetting;
        self.imbalance = self.imbalance.map(|x| x * forgetting);
    }

    /// Takes in one instant; `false` where it isn't finite, or so large that it would ruin the
    /// sums.
    pub fn add(&mut self, instant: &Instant<T>) -> bool {
        let weight = T::one() / (instant.acceleration_sigma_rad_s2 * self.moment_kg_m2);
        let h = (regressor(&instant.acceleration_rad_s2)
            + gyroscopic_regressor(&instant.rate_rad_s))
            * weight;
        let y = instant.torque_n_m * weight;
        let imbalance = instant.imbalance_n_m * weight;
        let is_sane = size(&h) + size(&y) + size(&imbalance) < T::lit(LARGEST_IN_SIGMAS);
        if !is_sane {
            return false;
        }
        for r in 0..3 {
            let row = core::array::from_fn(|c| h[(r, c)]);
            let unexplained = self.information.add_weighted(&row, y[r], T::one());
            self.residual_square += unexplained.square();
            for c in 0..6 {
                self.imbalance[c] += h[(r, c)] * imbalance[r];
            }
        }
        self.instants += T::one();
        true
    }

    /// The elements, with what they are worth.
    ///
    /// The covariance is the sum of
    ///
    /// * `s² (HᵀH)⁻¹` for the noise in the equation's balance, `s²` the mean squared residual, or
    ///   what the noise of the accelerations means if that is more;
    /// * `A (S² + j₀ j₀ᵀ) Aᵀ` for the same noise in the regressor, which pulls the solution towards
    ///   zero by `A = (HᵀH)⁻¹ N`, N the noise's expected share of `HᵀH`; j is about nominal, S the
    ///   prior's sigma;
    /// * the square of what the known imbalance, the lag of the rate, does to the solution;
    /// * with three moments, what the products' own sigma does to them.
    ///
    /// A direction that comes out hardly better than the prior holds the prior. So a spin about one
    /// axis shows the three elements of `J a`, whatever the noise does to the rank of `HᵀH`.
    ///
    /// Left out: correlation between instants that share a window (the telescoping sum makes
    /// slow motions better than this, motions as fast as the window worse, up to twice); noise
    /// of the rate; errors of the torque and of the wheels.
    pub fn solve(&self, elements: Elements, nominal: &Prior<T>) -> Solution<T> {
        let mut information = self.information;
        for i in 0..6 {
            let mut row = [T::zero(); 6];
            let weight = T::one() / nominal.sigma_kg_m2[i];
            row[i] = weight;
            information.add(row, weight * nominal.inertia_kg_m2[i]);
        }
        match elements {
            Elements::All => {
                let x0 = Believed { value: nominal.inertia_kg_m2, sigma: nominal.sigma_kg_m2 };
                let (x, covariance) = self.read_out(&information, &x0, &Mat::zeros());
                Solution { inertia: Inertia::new(x), covariance_kg2_m4: covariance }
            }
            Elements::Moments => self.solve_moments(&information, nominal),
        }
    }

    /// The first three rows of the factor with the products `p` at their nominal values:
    /// `R₁₁ m = d₁ − R₁₂ p`. An error `δp` moves the moments by `−R₁₁⁻¹ R₁₂ δp`. The correlation
    /// of moments and products that follows is left out of the covariance.
    #[inline(never)]
    fn solve_moments(
        &self,
        information: &SquareRootInformation<T, 6>,
        nominal: &Prior<T>,
    ) -> Solution<T> {
        let (value, sigma) = (&nominal.inertia_kg_m2, &nominal.sigma_kg_m2);
        let mut moments = SquareRootInformation::<T, 3>::default();
        let mut by_products = [[T::zero(); 3]; 3];
        for (row, d) in information.equations().iter().take(3) {
            let mut y = *d;
            for p in 0..3 {
                y -= row[3 + p] * value[3 + p];
                for m in 0..3 {
                    by_products[p][m] += row[m] * row[3 + p];
                }
            }
            moments.add([row[0], row[1], row[2]], y);
        }
        let mut unmodelled = Mat::<T, 3, 3>::zeros();
        for p in 0..3 {
            let moved = moments.solve_normal(&by_products[p]).unwrap_or([T::MAX; 3]);
            let moved = Vec3::from(moved) * sigma[3 + p];
            unmodelled += moved * moved.transpose();
        }
        let x0 = Believed {
            value: [value[0], value[1], value[2]],
            sigma: [sigma[0], sigma[1], sigma[2]],
        };
        let (m, covariance) = self.read_out(&moments, &x0, &unmodelled);
        let mut full = Mat::<T, 6, 6>::zeros();
        for i in 0..3 {
            for k in 0..3 {
                full[(i, k)] = covariance[(i, k)];
            }
            full[(3 + i, 3 + i)] = sigma[3 + i] * sigma[3 + i];
        }
        let inertia = Inertia::new([m[0], m[1], m[2], value[3], value[4], value[5]]);
        Solution { inertia, covariance_kg2_m4: full }
    }

    #[inline(never)]
    fn read_out<const N: usize>(
        &self,
        information: &SquareRootInformation<T, N>,
        x0: &Believed<T, N>,
        unmodelled: &Mat<T, N, N>,
    ) -> ([T; N], Mat<T, N, N>) {
        let mut covariance = Mat::<T, N, N>::zeros();
        let (Some(x), true) =
            (information.solve(), information.covariance_of_last(&mut covariance))
        else {
            return (x0.value, x0.covariance());
        };
        covariance *= self.residual_variance(N);
        covariance += unmodelled;
        match self.add_bias(information, x0, &mut covariance) {
            Some(()) => x0.hold_unseen(&x, &covariance),
            None => (x0.value, x0.covariance()),
        }
    }

    /// Adds `A (S² + j₀ j₀ᵀ) Aᵀ`, `A = (HᵀH)⁻¹ N`, and the square of what the imbalance does.
    #[inline(never)]
    fn add_bias<const N: usize>(
        &self,
        information: &SquareRootInformation<T, N>,
        x0: &Believed<T, N>,
        covariance: &mut Mat<T, N, N>,
    ) -> Option<()> {
        // In rows of unit sigma, noise of one sigma in the acceleration is 1 / moment.
        let noise = self.instants / (self.moment_kg_m2 * self.moment_kg_m2);
        let mut pulled = [T::zero(); N];
        for k in 0..N {
            let mut b = [T::zero(); N];
            b[k] = noise * noise_share(k);
            let column = information.solve_normal(&b)?;
            for i in 0..N {
                pulled[i] += column[i] * x0.value[k];
            }
            add_square(covariance, &column.map(|c| c * x0.sigma[k]));
        }
        let imbalance = core::array::from_fn(|k| self.imbalance.get(k).map_or(T::zero(), |b| *b));
        let moved = information.solve_normal(&imbalance)?;
        add_square(covariance, &pulled);
        add_square(covariance, &moved);
        Some(())
    }

    /// Mean squared residual of a row in sigmas, at least 1.
    fn residual_variance(&self, unknowns: usize) -> T {
        let rows = self.instants * T::lit(3.0);
        if rows < T::count(RESIDUALS_COUNT) {
            return T::one();
        }
        (self.residual_square / (rows - T::count(unknowns as u32))).max(T::one())
    }
}

/// Adds `v vᵀ`.
fn add_square<T: Real, const N: usize>(covariance: &mut Mat<T, N, N>, v: &[T; N]) {
    for i in 0..N {
        for k in 0..N {
            covariance[(i, k)] += v[i] * v[k];
        }
    }
}

/// The sum of the absolute values; not a number where one of them isn't.
fn size<T: Real, const R: usize, const C: usize>(m: &Mat<T, R, C>) -> T {
    let mut sum = T::zero();
    for r in 0..R {
        for c in 0..C {
            sum += m[(r, c)].abs();
        }
    }
    sum
}

/// The prior of N elements.
struct Believed<T: Real, const N: usize> {
    value: [T; N],
    sigma: [T; N],
}

impl<T: Real, const N: usize> Believed<T, N> {
    fn covariance(&self) -> Mat<T, N, N> {
        let mut c = Mat::zeros();
        for i in 0..N {
            c[(i, i)] = self.sigma[i] * self.sigma[i];
        }
        c
    }

    /// `x` with its covariance, but the prior in each direction that isn't shown.
    /// Directions are the eigenvectors of the covariance in units of the prior's sigmas.
    #[inline(never)]
    fn hold_unseen(&self, x: &[T; N], covariance: &Mat<T, N, N>) -> ([T; N], Mat<T, N, N>) {
        let mut scaled = Mat::<T, N, N>::zeros();
        for i in 0..N {
            for k in 0..N {
                scaled[(i, k)] = covariance[(i, k)] / self.sigma[i] / self.sigma[k];
            }
        }
        if !scaled.iter().chain(x.iter()).all(|v| v.is_finite()) {
            return (self.value, self.covariance());
        }
        let (variance, direction) = symmetric_eigen(&scaled);
        let (mut value, mut kept) = (self.value, Mat::<T, N, N>::zeros());
        for d in 0..N {
            let seen = variance[d] < T::lit(SHOWN * SHOWN);
            let mut along = T::zero();
            for i in 0..N {
                along += direction[(i, d)] * (x[i] - self.value[i]) / self.sigma[i];
            }
            let variance = if seen { variance[d].max(T::zero()) } else { T::one() };
            for i in 0..N {
                let axis = direction[(i, d)] * self.sigma[i];
                if seen {
                    value[i] += axis * along;
                }
                for k in 0..N {
                    kept[(i, k)] += variance * axis * (direction[(k, d)] * self.sigma[k]);
                }
            }
        }
        (value, kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::observability::observed;
    use proptest::prelude::*;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const SIGMA_RAD_S2: f64 = 1e-4;

    fn prior<T: Real>() -> Prior<T> {
        Prior {
            inertia_kg_m2: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0].map(T::lit),
            sigma_kg_m2: [1.0, 1.0, 1.0, 0.5, 0.5, 0.5].map(T::lit),
        }
    }

    /// An instant of any motion, and the torque that it takes.
    fn instant(j: &[f64; 6], rate: [f64; 3], acceleration: [f64; 3]) -> Instant<f64> {
        let (w, a) = (Vec3::from(rate), Vec3::from(acceleration));
        let j = Inertia::new(*j).matrix_kg_m2();
        Instant {
            rate_rad_s: w,
            acceleration_rad_s2: a,
            torque_n_m: j * a + w.cross(&(j * w)),
            acceleration_sigma_rad_s2: SIGMA_RAD_S2,
            imbalance_n_m: Vec3::zeros(),
        }
    }

    fn narrow(i: &Instant<f64>) -> Instant<f32> {
        let cast = |v: &Vec3<f64>| v.map(|x| x as f32);
        Instant {
            rate_rad_s: cast(&i.rate_rad_s),
            acceleration_rad_s2: cast(&i.acceleration_rad_s2),
            torque_n_m: cast(&i.torque_n_m),
            acceleration_sigma_rad_s2: i.acceleration_sigma_rad_s2 as f32,
            imbalance_n_m: cast(&i.imbalance_n_m),
        }
    }

    fn tumble(j: &[f64; 6]) -> impl Iterator<Item = Instant<f64>> {
        (0..200).map(move |k| {
            let t = 0.1 * f64::from(k);
            instant(
                j,
                [0.2 * t.sin(), 0.1 * (1.7 * t).cos(), 0.15 * (0.6 * t).sin()],
                [0.2 * t.cos(), -0.17 * (1.7 * t).sin(), 0.09 * (0.6 * t).cos()],
            )
        })
    }

    /// What the prior does to a noiseless solution: its weight over the data's.
    const PRIOR_SHIFT: f64 = 1e-4;

    #[test]
    fn a_tumble_shows_all_six_in_both_precisions() {
        let (mut double, mut single) =
            (Regression::<f64>::new(&prior()), Regression::<f32>::new(&prior()));
        for i in tumble(&INERTIA) {
            assert!(double.add(&i) && single.add(&narrow(&i)));
        }
        let double = double.solve(Elements::All, &prior());
        let single = single.solve(Elements::All, &prior());
        assert_eq!(observed(&double.covariance_kg2_m4, &prior().sigma_kg_m2).directions, 6);
        assert_eq!(observed(&single.covariance_kg2_m4, &prior().sigma_kg_m2).directions, 6);
        for k in 0..6 {
            assert!((double.inertia.elements_kg_m2()[k] - INERTIA[k]).abs() < PRIOR_SHIFT);
            assert!(
                (f64::from(single.inertia.elements_kg_m2()[k]) - INERTIA[k]).abs() < PRIOR_SHIFT
            );
        }
    }

    #[test]
    fn three_moments_with_the_products_known() {
        let known = Prior {
            inertia_kg_m2: [0.75, 0.6, 0.9, 0.1, -0.2, 0.05],
            sigma_kg_m2: [1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3],
        };
        let mut sums = Regression::new(&known);
        for i in tumble(&INERTIA) {
            sums.add(&i);
        }
        let found = sums.solve(Elements::Moments, &known);
        for k in 0..6 {
            assert!((found.inertia.elements_kg_m2()[k] - INERTIA[k]).abs() < PRIOR_SHIFT);
        }
        let seen = observed(&found.covariance_kg2_m4, &known.sigma_kg_m2);
        assert_eq!(seen.element, [true, true, true, false, false, false]);
    }

    #[test]
    fn three_moments_own_up_to_products_that_are_not_known() {
        let mut sums = Regression::new(&prior());
        for i in tumble(&INERTIA) {
            sums.add(&i);
        }
        let found = sums.solve(Elements::Moments, &prior());
        for k in 0..3 {
            let error = found.inertia.elements_kg_m2()[k] - INERTIA[k];
            assert!(error.abs() < 3.0 * found.covariance_kg2_m4[(k, k)].sqrt());
        }
    }

    proptest! {
        /// The recursion as \[Kim2013\] prints it, with Joseph's covariance, one row at a time.
        #[test]
        fn agrees_with_the_printed_recursion(
            motion in prop::collection::vec(prop::array::uniform6(-1.0..1.0f64), 30),
        ) {
            let mut sums = Regression::new(&prior());
            let mut x = Mat::<f64, 6, 1>::from(prior::<f64>().inertia_kg_m2);
            let mut p = Mat::<f64, 6, 6>::from_diagonal(
                &prior::<f64>().sigma_kg_m2.map(|s| s * s).into());
            for m in &motion {
                let mut i = instant(&INERTIA, [m[0], m[1], m[2]], [m[3], m[4], m[5]]);
                // Loud, so that the prior still counts.
                i.acceleration_sigma_rad_s2 = 1.0;
                sums.add(&i);
                let r = sums.moment_kg_m2 * sums.moment_kg_m2;
                let h = regressor(&i.acceleration_rad_s2) + gyroscopic_regressor(&i.rate_rad_s);
                let s = h * p * h.transpose() + Mat::<f64, 3, 3>::identity() * r;
                let k = p * h.transpose() * s.try_inverse().unwrap();
                x += k * (i.torque_n_m - h * x);
                let rest = Mat::<f64, 6, 6>::identity() - k * h;
                p = rest * p * rest.transpose() + k * k.transpose() * r;
            }
            let mut information = sums.information;
            for i in 0..6 {
                let mut row = [0.0; 6];
                row[i] = 1.0 / prior::<f64>().sigma_kg_m2[i];
                information.add(row, row[i] * prior::<f64>().inertia_kg_m2[i]);
            }
            let ours = information.solve().unwrap();
            let factor = information.covariance_factor().unwrap();
            for k in 0..6 {
                prop_assert!((ours[k] - x[k]).abs() < 1e-10);
            }
            prop_assert!((factor * factor.transpose() - p).abs().max() < 1e-10);
        }

        #[test]
        fn a_constant_axis_shows_three_elements_whatever_the_noise(
            noise in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 400),
        ) {
            let mut sums = Regression::<f32>::new(&prior());
            for (k, v) in noise.iter().enumerate() {
                let spin = 0.05 * (0.1 * k as f64).sin();
                let mut i = instant(&INERTIA, [0.0, 0.0, 0.05], [0.0, 0.0, spin]);
                // Uniform noise of the stated sigma.
                i.acceleration_rad_s2 += Vec3::from(*v) * (SIGMA_RAD_S2 * 3.0f64.sqrt());
                sums.add(&narrow(&i));
            }
            let found = sums.solve(Elements::All, &prior());
            let j = found.inertia.elements_kg_m2();
            let seen = observed(&found.covariance_kg2_m4, &prior().sigma_kg_m2);
            // jzz by the acceleration; jxz and jyz by the gyroscopic torque of the same spin.
            prop_assert_eq!(seen.element, [false, false, true, false, true, true]);
            prop_assert_eq!(seen.directions, 3);
            prop_assert!((f64::from(j[2]) - INERTIA[2]).abs() < 0.02);
            for k in [0, 1, 3] {
                let sigma = prior::<f32>().sigma_kg_m2[k];
                prop_assert!((j[k] - prior::<f32>().inertia_kg_m2[k]).abs() < 0.1 * sigma);
                prop_assert!(found.covariance_kg2_m4[(k, k)].sqrt() > 0.9 * sigma);
            }
        }

        #[test]
        fn any_bits_leave_a_finite_solution(
            bits in prop::collection::vec(prop::array::uniform12(any::<u32>()), 40),
        ) {
            let mut sums = Regression::<f32>::new(&prior());
            for b in bits {
                let f = b.map(f32::from_bits);
                sums.add(&Instant {
                    rate_rad_s: Vec3::new(f[0], f[1], f[2]),
                    acceleration_rad_s2: Vec3::new(f[3], f[4], f[5]),
                    torque_n_m: Vec3::new(f[6], f[7], f[8]),
                    acceleration_sigma_rad_s2: f[9],
                    imbalance_n_m: Vec3::new(f[10], f[11], f[10]),
                });
            }
            for elements in [Elements::Moments, Elements::All] {
                let found = sums.solve(elements, &prior());
                prop_assert!(found.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
                prop_assert!(found.covariance_kg2_m4.iter().all(|x| x.is_finite()));
            }
        }
    }

    #[test]
    fn a_known_imbalance_is_owned_up_to() {
        let mut sums = Regression::new(&prior());
        for mut i in tumble(&INERTIA) {
            i.imbalance_n_m = i.rate_rad_s * 0.3;
            i.torque_n_m += i.imbalance_n_m;
            sums.add(&i);
        }
        let found = sums.solve(Elements::All, &prior());
        let mut worst = 0.0f64;
        for k in 0..6 {
            let error = found.inertia.elements_kg_m2()[k] - INERTIA[k];
            worst = worst.max(error.abs());
            assert!(error.abs() < 1.1 * found.covariance_kg2_m4[(k, k)].sqrt());
        }
        assert!(worst > 1e-2, "an imbalance that matters: {worst}");
    }

    #[test]
    fn nothing_seen_is_the_prior() {
        let sums = Regression::<f32>::new(&prior());
        for elements in [Elements::Moments, Elements::All] {
            let found = sums.solve(elements, &prior());
            let seen = observed(&found.covariance_kg2_m4, &prior().sigma_kg_m2);
            assert_eq!(seen.directions, 0);
            for k in 0..6 {
                let error = found.inertia.elements_kg_m2()[k] - prior::<f32>().inertia_kg_m2[k];
                assert!(error.abs() < 1e-6);
            }
        }
    }

    #[test]
    fn forgetting_follows_a_change() {
        let later = INERTIA.map(|x| 1.5 * x);
        let mut sums = Regression::new(&prior());
        for i in tumble(&INERTIA).chain(tumble(&later)) {
            sums.forget(0.95);
            sums.add(&i);
        }
        let found = sums.solve(Elements::All, &prior()).inertia.elements_kg_m2();
        for k in 0..6 {
            assert!((found[k] - later[k]).abs() < 1e-2, "{found:?}");
        }
    }
}
