//! Weights of a Savitzky-Golay filter.
//!
//! Least-squares fit of a polynomial of order p to n evenly spaced samples `yᵢ`, differentiated d
//! times and evaluated at `t` (sample periods after the oldest sample): a weighted sum `Σ wᵢ yᵢ`.
//! With polynomials `p₀ … p_p` that are orthogonal over the samples,
//!
//! `wᵢ = Σₖ pₖ(xᵢ) pₖ⁽ᵈ⁾(x(t)) (dx/dt)ᵈ / ‖pₖ‖²`, `x = (t − (n−1)/2) / ((n−1)/2)`.
//!
//! | symbol | meaning | range |
//! |---|---|---|
//! | n | samples in the window | 2 to [`LARGEST_WINDOW`] |
//! | p | order of the polynomial | 0 to n − 1, at most [`LARGEST_ORDER`] |
//! | d | order of the derivative | 0 smooths |
//! | t | evaluation point, sample periods | finite; 0 is the oldest sample, n − 1 the newest |
//! | x | the same, from −1 at the oldest sample to 1 at the newest | – |
//!
//! # Recurrence
//!
//! The formula above is that of \[Kim2016\] Eqs. (8), (9) without its normal matrix `BᵀB` of
//! monomials, whose condition number exceeds single precision. The `pₖ` of even spacing are Gram's
//! polynomials (\[Gorry1990\]), given by a three-term recurrence:
//!
//! `pₖ₊₁ = x pₖ − bₖ² pₖ₋₁`, `bₖ² = k² (n² − k²) / ((4k² − 1) (n−1)²)`, `p₀ = 1`,
//!
//! `‖pₖ‖² = n b₁² … bₖ²`.
//!
//! Differentiated m times, the recurrence gains the term `m pₖ⁽ᵐ⁻¹⁾` on the right. The weights need
//! no more memory than a few windows, and no square root.
//!
//! # Noise and delay
//!
//! White noise of variance σ² in the samples gives an output of variance `σ² Σ wᵢ²`
//! ([`Kernel::noise_gain`]). For a straight line or a parabola in the middle of the window:
//!
//! | output | variance over σ² |
//! |---|---|
//! | mean, `p = 0` or `1` | `1 / n` |
//! | first derivative, `p = 1` or `2`, per period² | `12 / (n (n² − 1))` |
//!
//! A longer window reduces the variance of a derivative with the third power of its length, and
//! averages the motion over that length: a signal `sin ωt` is attenuated once `ω (n − 1) Δt`
//! approaches 1.
//!
//! # Weights of common windows
//!
//! | window | weights of the first derivative, `p = 1` or `2`, centred |
//! |---|---|
//! | 3 | (−1 0 1) / 2 |
//! | 4 | (−3 −1 1 3) / 10 |
//! | 5 | (−2 −1 0 1 2) / 10 |
//! | 6 | (−5 −3 −1 1 3 5) / 35 |
//! | 7 | (−3 −2 −1 0 1 2 3) / 28 |

use crate::error::ConfigError;
use crate::math::range::{finite, within};
use crate::math::scalar::Real;

/// Largest number of samples in a window.
pub const LARGEST_WINDOW: usize = 64;

/// Highest order of the polynomial.
///
/// Above it the recurrence loses digits at the ends of a short window, and a polynomial through
/// evenly spaced samples oscillates between them.
pub const LARGEST_ORDER: usize = 12;

/// Polynomial and evaluation point of a fit.
///
/// ```
/// use fsw_core::math::savgol::{Fit, Kernel};
///
/// // First derivative in the middle of five samples, by a parabola: (−2 −1 0 1 2) / 10.
/// let kernel = Kernel::<f64, 8>::new(&Fit::centred(5, 2, 1))?;
/// let expected = [-0.2, -0.1, 0.0, 0.1, 0.2];
/// assert!(kernel.weights().iter().zip(expected).all(|(w, e)| (w - e).abs() < 1e-15));
/// # Ok::<(), fsw_core::ConfigError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit<T: Real> {
    /// Samples n, 2 to [`LARGEST_WINDOW`], odd or even.
    pub window: usize,
    /// Order p of the polynomial, below `window` and at most [`LARGEST_ORDER`].
    pub order: usize,
    /// Order d of the derivative; 0 smooths. Above `order` all weights are zero.
    pub derivative: usize,
    /// Evaluation point t, sample periods after the oldest sample.
    pub at: T,
}

impl<T: Real> Fit<T> {
    /// Evaluation in the middle of the window: at a sample for an odd window, between two for an
    /// even one.
    ///
    /// The delay is `(n − 1) / 2` sample periods, and the noise gain of the derivative is the
    /// smallest.
    ///
    /// ```
    /// use fsw_core::math::savgol::Fit;
    ///
    /// assert_eq!(Fit::<f32>::centred(6, 2, 1).at, 2.5);
    /// assert_eq!(Fit::<f32>::newest(6, 2, 1).at, 5.0);
    /// ```
    pub fn centred(window: usize, order: usize, derivative: usize) -> Self {
        let at = periods::<T>(window) * T::lit(0.5);
        Self { window, order, derivative, at }
    }

    /// Evaluation at the newest sample: no delay, and the largest noise gain.
    pub fn newest(window: usize, order: usize, derivative: usize) -> Self {
        Self { window, order, derivative, at: periods(window) }
    }

    /// Range check of the fit, for a window of up to `capacity` samples.
    ///
    /// # Errors
    /// `window` outside 2 to `capacity`, `order` outside 0 to `window − 1`, `at` not finite.
    pub fn validate(&self, capacity: usize) -> Result<(), ConfigError> {
        within("window", self.window, 2, capacity.min(LARGEST_WINDOW))?;
        within("order", self.order, 0, LARGEST_ORDER.min(self.window - 1))?;
        finite("at", self.at)
    }
}

/// Sample periods from the oldest sample to the newest, n − 1.
fn periods<T: Real>(window: usize) -> T {
    T::count(window.saturating_sub(1) as u32)
}

/// Weights of a window of up to C samples, oldest first.
///
/// A derivative of order d has the unit of the samples per sample periodᵈ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel<T: Real, const C: usize> {
    /// Weights; zeros from `window` on.
    pub(crate) weights: [T; C],
    /// Samples n.
    pub(crate) window: usize,
}

impl<T: Real, const C: usize> Kernel<T, C> {
    /// Weights of a fit, in about `n p` products.
    ///
    /// # Errors
    /// `window`, `order` or `at` out of its range, as in [`Fit::validate`].
    pub fn new(fit: &Fit<T>) -> Result<Self, ConfigError> {
        fit.validate(C)?;
        Ok(Self::of_valid(fit))
    }

    /// Weights of a fit that has passed [`Fit::validate`].
    pub(super) fn of_valid(fit: &Fit<T>) -> Self {
        let [kernel] = Self::of_derivatives::<ORDERS, 1>(fit, [fit.derivative]);
        kernel
    }

    /// Smoothing and first derivative of the same valid fit, at little more than the cost of one of
    /// them.
    pub(super) fn value_and_slope(fit: &Fit<T>) -> [Self; 2] {
        Self::of_derivatives::<2, 2>(fit, [0, 1])
    }

    /// Kernels of several derivatives, each of an order below D.
    fn of_derivatives<const D: usize, const K: usize>(
        fit: &Fit<T>,
        orders: [usize; K],
    ) -> [Self; K] {
        let n = fit.window;
        let half = periods::<T>(n) * T::lit(0.5);
        let abscissa = |t: T| (t - half) / half;
        // bₖ², and pₖ⁽ᵈ⁾ at the evaluation point over ‖pₖ‖², for each d of `orders`.
        let mut terms = [(T::zero(), [T::zero(); K]); ORDERS];
        let mut at = Gram::<T, D>::constant();
        let mut inverse_norm_square = T::one() / T::count(n as u32);
        for (k, (b_square, there)) in terms.iter_mut().enumerate().take(fit.order + 1) {
            if k > 0 {
                *b_square = recurrence(n, k);
                inverse_norm_square /= *b_square;
                at.advance(abscissa(fit.at), *b_square);
            }
            for (there, order) in there.iter_mut().zip(orders) {
                let derivative = at.derivatives.get(order).copied().unwrap_or(T::zero());
                *there = derivative * inverse_norm_square;
            }
        }
        let mut kernels = [Self { weights: [T::zero(); C], window: n }; K];
        for i in 0..n.min(C) {
            let x = abscissa(T::count(i as u32));
            let mut sample = Gram::<T, 1>::constant();
            let mut weight = [T::zero(); K];
            for (k, (b_square, there)) in terms.iter().enumerate().take(fit.order + 1) {
                if k > 0 {
                    sample.advance(x, *b_square);
                }
                for d in 0..K {
                    weight[d] += sample.derivatives[0] * there[d];
                }
            }
            for d in 0..K {
                for _ in 0..orders[d] {
                    weight[d] /= half;
                }
                kernels[d].weights[i] = weight[d];
            }
        }
        kernels
    }

    /// One weight per sample, oldest first, per sample periodᵈ for a derivative of order d.
    pub fn weights(&self) -> &[T] {
        self.weights.get(..self.window).unwrap_or(&self.weights)
    }

    /// Noise gain `Σᵢⱼ wᵢ wⱼ ρ^|i−j|`: variance of the output for noise of unit variance.
    ///
    /// `correlation` ρ, 0 (white) to 1, is that of successive samples; noise is taken as a
    /// first-order lag.
    ///
    /// ```
    /// use fsw_core::math::savgol::{Fit, Kernel};
    ///
    /// // The mean of four samples divides the variance of white noise by four.
    /// let mean = Kernel::<f32, 4>::new(&Fit::centred(4, 0, 0))?;
    /// assert!((mean.noise_gain(0.0) - 0.25).abs() < 1e-6);
    /// assert!((mean.noise_gain(1.0) - 1.0).abs() < 1e-6);
    /// # Ok::<(), fsw_core::ConfigError>(())
    /// ```
    pub fn noise_gain(&self, correlation: T) -> T {
        let (mut squares, mut crosses, mut before) = (T::zero(), T::zero(), T::zero());
        for w in self.weights() {
            squares += *w * *w;
            crosses += *w * before;
            before = (before + *w) * correlation;
        }
        squares + crosses + crosses
    }
}

/// Number of derivatives, 0 to [`LARGEST_ORDER`].
const ORDERS: usize = LARGEST_ORDER + 1;

/// Polynomial `pₖ` at one place with its first D − 1 derivatives, and `pₖ₋₁`.
#[derive(Clone, Copy)]
struct Gram<T: Real, const D: usize> {
    derivatives: [T; D],
    before: [T; D],
    /// `bₖ²`.
    b_square: T,
}

impl<T: Real, const D: usize> Gram<T, D> {
    /// Polynomial `p₀ = 1`.
    fn constant() -> Self {
        let o = T::zero();
        let mut derivatives = [o; D];
        derivatives[0] = T::one();
        Self { derivatives, before: [o; D], b_square: o }
    }

    /// Recurrence from `pₖ` to `pₖ₊₁` at x, with `bₖ₊₁²`.
    fn advance(&mut self, x: T, b_square: T) {
        let now = self.derivatives;
        for m in 0..D {
            let by_slope = if m == 0 { T::zero() } else { T::count(m as u32) * now[m - 1] };
            self.derivatives[m] = x * now[m] + by_slope - self.b_square * self.before[m];
        }
        (self.before, self.b_square) = (now, b_square);
    }
}

/// Coefficient `bₖ²` of n samples from −1 to 1.
fn recurrence<T: Real>(n: usize, k: usize) -> T {
    let (n, k) = (n as u32, k as u32);
    // Both below 2²⁴, so exact in single precision: only the quotient is rounded.
    let (top, bottom) = (k * k * (n * n - k * k), (4 * k * k - 1) * (n - 1) * (n - 1));
    T::count(top) / T::count(bottom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Invalid;
    use proptest::prelude::*;

    /// Bound on the error against exact rational weights, in units of ε.
    const ROUNDINGS: f64 = 16.0;

    /// Compares weights with `integers / norm`.
    fn assert_weights<T: Real>(fit: &Fit<T>, integers: &[i32], norm: i32) {
        let kernel = Kernel::<T, 64>::new(fit).unwrap();
        let tolerance = ROUNDINGS * T::EPSILON.to_f64();
        assert_eq!(kernel.weights().len(), integers.len());
        for (w, i) in kernel.weights().iter().zip(integers) {
            let exact = f64::from(*i) / f64::from(norm);
            assert!((w.to_f64() - exact).abs() < tolerance, "{:?}", kernel.weights());
        }
    }

    /// Tables of \[Kim2016\], \[Kim2013\] and \[Savitzky1964\] as integers over a common
    /// denominator.
    fn published_tables<T: Real>() {
        // [Kim2016] Table 2, printed as quartic: the straight line's or the parabola's.
        for order in [1, 2] {
            assert_weights::<T>(&Fit::centred(4, order, 1), &[-3, -1, 1, 3], 10);
            assert_weights::<T>(&Fit::centred(6, order, 1), &[-5, -3, -1, 1, 3, 5], 35);
            assert_weights::<T>(&Fit::centred(8, order, 1), &[-7, -5, -3, -1, 1, 3, 5, 7], 84);
            // [Kim2013].
            assert_weights::<T>(&Fit::centred(7, order, 1), &[-3, -2, -1, 0, 1, 2, 3], 28);
            assert_weights::<T>(&Fit::centred(5, order, 1), &[-2, -1, 0, 1, 2], 10);
        }
        assert_weights::<T>(&Fit::centred(2, 1, 1), &[-1, 1], 1);
        // Smoothing and second derivatives of the original tables.
        assert_weights::<T>(&Fit::centred(5, 2, 0), &[-3, 12, 17, 12, -3], 35);
        assert_weights::<T>(&Fit::centred(7, 3, 0), &[-2, 3, 6, 7, 6, 3, -2], 21);
        assert_weights::<T>(&Fit::centred(5, 3, 1), &[1, -8, 0, 8, -1], 12);
        assert_weights::<T>(&Fit::centred(5, 2, 2), &[2, -1, -2, -1, 2], 7);
        // At the newest sample: the line through five, the parabola through three.
        assert_weights::<T>(&Fit::newest(5, 1, 0), &[-2, 0, 2, 4, 6], 10);
        assert_weights::<T>(&Fit::newest(3, 2, 1), &[1, -4, 3], 2);
    }

    /// Weights in both precisions against published tables.
    #[test]
    fn weights_are_those_of_the_published_tables() {
        published_tables::<f32>();
        published_tables::<f64>();
    }

    /// \[Kim2016\] Table 2 is printed as that of a quartic; its weights are those of a straight
    /// line or a parabola.
    #[test]
    fn kim_2016_table_2_differs_from_a_quartic() {
        let kernel = Kernel::<f64, 6>::new(&Fit::centred(6, 4, 1)).unwrap();
        assert!((kernel.weights()[5] - 5.0 / 35.0).abs() > 0.1);
    }

    /// Error of the derivative of `Σₘ aₘ xᵐ` (x from −1 to 1 over the window) over `Σ |wᵢ|`, in
    /// units of ε: 1 corresponds to the rounding of each sample.
    fn error_over_rounding<T: Real>(fit: &Fit<T>, coefficients: &[f64]) -> f64 {
        let half = (fit.window - 1) as f64 / 2.0;
        let abscissa = |t: f64| (t - half) / half;
        let power = |m: usize, d: usize, x: f64| {
            (0..d).map(|i| (m as f64 - i as f64) / half).product::<f64>()
                * if m >= d { x.powi((m - d) as i32) } else { 0.0 }
        };
        let polynomial = |t: f64, d: usize| {
            let x = abscissa(t);
            coefficients.iter().enumerate().map(|(m, a)| a * power(m, d, x)).sum::<f64>()
        };
        let kernel = Kernel::<T, 64>::new(fit).unwrap();
        let (mut sum, mut scale) = (0.0, 0.0);
        for (i, w) in kernel.weights().iter().enumerate() {
            sum += w.to_f64() * polynomial(i as f64, 0);
            scale += w.to_f64().abs();
        }
        (sum - polynomial(fit.at.to_f64(), fit.derivative)).abs() / (scale * T::EPSILON.to_f64())
    }

    /// Bound on [`error_over_rounding`] for up to 13 coefficients of up to 1. The worst of all
    /// windows, orders, derivatives and eight places, with each monomial's error added up, is 392
    /// (twelfth order through 13 samples, f32).
    const POLYNOMIAL_ROUNDINGS: f64 = 500.0;

    proptest! {
        /// A polynomial of the fitted order is reproduced to rounding, at any place and for any
        /// derivative.
        #[test]
        fn a_polynomial_up_to_the_order_is_differentiated_exactly(
            window in 2..=64usize, order in 0..=12usize, derivative in 0..=4usize,
            place in 0.0..=1.0f64, a in prop::collection::vec(-1.0..1.0f64, 13),
        ) {
            let order = order.min(window - 1);
            let derivative = derivative.min(order);
            // To 1/64 of a period: exact in both precisions.
            let at = (place * (window - 1) as f64 * 64.0).round() / 64.0;
            let a = &a[..=order];
            let double = Fit { window, order, derivative, at };
            prop_assert!(error_over_rounding(&double, a) < POLYNOMIAL_ROUNDINGS);
            let single = Fit { window, order, derivative, at: at as f32 };
            prop_assert!(error_over_rounding(&single, a) < POLYNOMIAL_ROUNDINGS);
            let newest = Fit::<f32>::newest(window, order, derivative);
            prop_assert!(error_over_rounding(&newest, a) < POLYNOMIAL_ROUNDINGS);
            let middle = Fit::<f32>::centred(window, order, derivative);
            prop_assert!(error_over_rounding(&middle, a) < POLYNOMIAL_ROUNDINGS);
        }

        /// Recursive sum against the double sum of its definition.
        #[test]
        fn the_noise_gain_is_the_double_sum(window in 2..=16usize, rho in 0.0..1.0f64) {
            let kernel = Kernel::<f64, 16>::new(&Fit::centred(window, 1, 1)).unwrap();
            let w = kernel.weights();
            let mut sum = 0.0;
            for i in 0..window {
                for j in 0..window {
                    sum += w[i] * w[j] * rho.powi(i.abs_diff(j) as i32);
                }
            }
            prop_assert!((kernel.noise_gain(rho) - sum).abs() < 1e-13);
        }
    }

    /// The third derivative of a parabola.
    #[test]
    fn a_derivative_above_the_order_is_zero() {
        let kernel = Kernel::<f32, 8>::new(&Fit::centred(6, 2, 3)).unwrap();
        assert_eq!(kernel.weights(), [0.0; 6]);
    }

    /// One value beyond each limit.
    #[test]
    fn an_error_names_the_parameter_out_of_range() {
        let refused = |fit: Fit<f32>| Kernel::<f32, 8>::new(&fit).unwrap_err();
        let out = |least, most| Invalid::OutOfRange { least, most };
        let e = refused(Fit::centred(1, 0, 0));
        assert_eq!((e.field, e.reason), ("window", out(2, 8)));
        assert_eq!(refused(Fit::centred(9, 2, 1)).reason, out(2, 8));
        let e = refused(Fit::centred(6, 6, 1));
        assert_eq!((e.field, e.reason), ("order", out(0, 5)));
        let e = Kernel::<f32, 64>::new(&Fit::centred(64, 13, 1)).unwrap_err();
        assert_eq!((e.field, e.reason), ("order", out(0, 12)));
        let e = refused(Fit { at: f32::NAN, ..Fit::centred(6, 2, 1) });
        assert_eq!((e.field, e.reason), ("at", Invalid::NotFinite));
    }
}
