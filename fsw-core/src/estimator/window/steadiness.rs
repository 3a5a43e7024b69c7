//! Steadiness of the estimate: the front's inertia against its own of some blocks before.
//!
//! The data of the later estimate contain those of the earlier one. As long as one tensor explains all blocks, the two
//! differ by a normal variable of covariance `P₁ − P₂`, the difference of theirs, and
//!
//! `χ² = dᵀ (P₁ − P₂)⁻¹ d`
//!
//! has six degrees of freedom. A change of the inertia shows in it first: a fit of many blocks leaves a change to its
//! weakly observed directions, which move by many of their sigmas before the residuals exceed the noise.
//!
//! | estimate compared with the present one | age, blocks of the front |
//! |---|---|
//! | newer | 2 to 6 |
//! | older | 8 to 12 |
//!
//! An estimate that contradicts the present one is kept, and the residuals are not called white, until both agree or
//! a fit over all blocks ends. A fit weighs blocks anew and is linear about another point: its estimate does not compare
//! with those before it.

use super::Window;
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Entries, Mat, quadratic_over, scalar::Real};
use crate::trajectory::unknowns::shape_of;

/// Blocks of the front from one comparison to the next, and comparisons from one earlier estimate to the next.
const EVERY: u8 = 2;
const KEPT: u8 = 3;
/// χ² of six degrees of freedom that contradicts. Chance exceeds it once in 230,000 comparisons,
/// `e^(−x/2) (1 + x/2 + x²/8)`: in less than one of 460 windows of 500 blocks, whose 500 comparisons are not independent.
const CONTRADICTED: f64 = 35.0;
/// χ² up to which a contradiction has ended: chance exceeds it once in 1,000.
const AGREED: f64 = 22.5;
/// Share of the earlier covariance that is added to the difference: robust weights differ from fit to fit, and a
/// direction on which the later blocks add less has no statistic.
const FLOOR: f64 = 0.02;
/// Rounding errors of a variance, in ε.
const ROUNDINGS: f64 = 64.0;

/// Estimate of shape and inverse trace, 1/(kg m²), by the blocks of a window up to an instant.
#[derive(Clone, Copy, Debug)]
struct Snapshot<T> {
    estimate: [T; 6],
    /// Lower triangle of the covariance for a sample of unit variance, by rows.
    covariance: [T; 21],
}

crate::persist!([T: Real] Snapshot<T> { estimate, covariance });

/// Earlier estimates of the present window, and the result of the last comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steadiness<T: Real> {
    /// Newer and older one.
    earlier: [Option<Snapshot<T>>; 2],
    /// Blocks since the last comparison, and comparisons since the newer estimate.
    blocks: u8,
    comparisons: u8,
    is_contradicted: bool,
}

crate::persist!([T: Real] Steadiness<T> { earlier, blocks, comparisons, is_contradicted });

impl<T: Real> Snapshot<T> {
    fn new(estimate: [T; 6], of: &Mat<T, 6, 6>) -> Self {
        let mut covariance = [T::zero(); 21];
        let mut elements = covariance.iter_mut();
        for row in 0..6 {
            for column in 0..row + 1 {
                if let Some(element) = elements.next() {
                    *element = of.at(row, column);
                }
            }
        }
        Self { estimate, covariance }
    }

    /// χ² of a later estimate for a sample of unit variance; zero where the difference of the covariances is not
    /// positive definite.
    #[inline(never)]
    fn chi_square(&self, later: &Self) -> T {
        let mut apart = Mat::<T, 6, 6>::zeros();
        let mut elements = self.covariance.iter().zip(&later.covariance);
        for row in 0..6 {
            for column in 0..row + 1 {
                let Some((before, after)) = elements.next() else { break };
                let mut difference = *before * T::lit(1.0 + FLOOR) - *after;
                if row == column {
                    difference += *before * (T::EPSILON * T::lit(ROUNDINGS));
                }
                *apart.at_mut(row, column) = difference;
            }
        }
        let mut moved = later.estimate;
        for (moved, before) in moved.iter_mut().zip(&self.estimate) {
            *moved -= *before;
        }
        quadratic_over(&mut apart, moved).unwrap_or(T::zero())
    }
}

impl<T: Real> Steadiness<T> {
    /// No estimate yet.
    pub(super) const fn none() -> Self {
        Self { earlier: [None; 2], blocks: 0, comparisons: 0, is_contradicted: false }
    }

    /// True where an earlier estimate of the window contradicts the present one.
    pub(super) fn is_contradicted(&self) -> bool {
        self.is_contradicted
    }

    /// Counts a block of the front. True where a comparison is due.
    fn count(&mut self) -> bool {
        self.blocks = self.blocks.saturating_add(1);
        if self.blocks < EVERY {
            return false;
        }
        self.blocks = 0;
        true
    }

    /// Compares an estimate of a sample of this variance with the earlier ones, and keeps it in turn.
    #[inline(never)]
    fn compare(&mut self, present: Snapshot<T>, variance: T) {
        let most = if self.is_contradicted { AGREED } else { CONTRADICTED };
        let most = T::lit(most) * variance;
        let mut earlier = self.earlier.iter().flatten();
        self.is_contradicted = earlier.any(|earlier| earlier.chi_square(&present) > most);
        self.comparisons = self.comparisons.saturating_add(1);
        if self.comparisons >= KEPT && !self.is_contradicted {
            self.comparisons = 0;
            let [newer, older] = &mut self.earlier;
            *older = newer.replace(present);
        }
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// Counts a block of the front, and compares its estimate with earlier ones where that is due.
    #[inline(never)]
    pub(super) fn watch_steadiness(&mut self) {
        if self.config.is_walking() || !self.steadiness.count() {
            return;
        }
        if let Some((present, variance)) = self.snapshot() {
            self.steadiness.compare(present, variance);
        }
    }

    /// Estimate by the blocks of the front alone, and variance of a sample; none where they do not determine it, and where
    /// the effect of considered hardware moves it.
    #[inline(never)]
    fn snapshot(&self) -> Option<(Snapshot<T>, T)> {
        let front = self.front.as_ref().filter(|f| f.is_settled && f.observed.directions == 6)?;
        if self.considers() {
            return None;
        }
        let (pass, unit) = (&front.pass, front.pass.unit_per_kg_m2);
        let mut factor = SquareRootInformation::default();
        let noise = self.window_alone(pass, &mut factor);
        let sigma = noise.max(self.noise_rad_s());
        self.beliefs(unit).add_hardware(&mut factor, &pass.point);
        let mut covariance = Mat::<T, 6, 6>::zeros();
        let step = factor.solve().filter(|_| factor.covariance_of_last(&mut covariance))?;
        for i in 0..6 {
            *covariance.at_mut(5, i) *= unit;
            *covariance.at_mut(i, 5) *= unit;
        }
        let first = shape_of(U);
        let mut estimate = [T::zero(); 6];
        for (k, (value, step)) in estimate.iter_mut().zip(step.iter().skip(first)).enumerate() {
            let unit = if k == 5 { unit } else { T::one() };
            *value = (pass.point.value(first + k) + *step) * unit;
        }
        Some((Snapshot::new(estimate, &covariance), sigma * sigma))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WheelArray;
    use crate::estimator::Estimator;
    use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
    use crate::estimator::test_hardware::normal;
    use crate::estimator::window::Config;
    use crate::math::Vec3;

    /// χ² of an estimate of six constants from this number of rows on an earlier one, after a change of the first constant
    /// by this number of sigmas of a row.
    fn chi_square(seed: u64, rows: [usize; 2], change: f32) -> f32 {
        let mut normal = normal(seed + 1);
        let mut factor = SquareRootInformation::<f32, 6>::default();
        let snapshot = |factor: &SquareRootInformation<f32, 6>| {
            let mut covariance = Mat::zeros();
            assert!(factor.covariance_of_last(&mut covariance));
            Snapshot::new(factor.solve().unwrap(), &covariance)
        };
        let mut earlier = None;
        for k in 0..rows[1] {
            let row: [f32; 6] = core::array::from_fn(|_| normal() as f32);
            let by_change = if k < rows[0] { 0.0 } else { row[0] * change };
            factor.add(row, normal() as f32 + by_change);
            if k + 1 == rows[0] {
                earlier = Some(snapshot(&factor));
            }
        }
        earlier.unwrap().chi_square(&snapshot(&factor))
    }

    /// Mean within four sampling errors of 400 estimates, less what the floor takes: 2 % of the earlier covariance beside
    /// the half of it by which that shrinks.
    #[test]
    fn noise_alone_has_six_degrees_of_freedom() {
        let mean = (0..400).map(|seed| chi_square(seed, [60, 120], 0.0)).sum::<f32>() / 400.0;
        let expected = 6.0 / (1.0 + 2.0 * FLOOR as f32);
        assert!((mean - expected).abs() < 4.0 * (12.0f32 / 400.0).sqrt(), "{mean}");
        let largest = (0..400).map(|seed| chi_square(seed, [60, 66], 0.0)).fold(0.0, f32::max);
        assert!(largest < CONTRADICTED as f32, "{largest}");
        assert!((0..400).all(|seed| chi_square(seed, [60, 120], 2.0) > CONTRADICTED as f32));
    }

    /// Residuals that pass all other tests are not called white while an earlier estimate contradicts the present one.
    #[test]
    fn an_estimate_that_moves_too_far_is_not_called_white() {
        let body = TestFlight {
            inertia_kg_m2: [1.5, 1.2, 1.8, 0.1, -0.2, 0.05],
            initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
            wheels: WheelArray::new([], []).unwrap(),
            period_us: 100_000,
            samples: 1200,
        };
        let config = Config { is_torque_smooth: true, slices_per_step: 16, ..Config::new(1e-3) };
        let wheels = WheelArray::new([], []).unwrap();
        let mut window = Window::<f32, 0, 512, 12>::new(config, wheels).unwrap();
        let mut normal = normal(1);
        for mut sample in body.fly(|_| [], tumbling_torque_n_m) {
            sample.rate_rad_s += Vec3::from_fn(|_, _| normal() as f32 * 1e-3);
            window.step(&sample);
        }
        assert!(!window.steadiness.is_contradicted());
        assert_eq!(window.estimate().residuals_white, Some(true));
        let [Some(newer), Some(_)] = window.steadiness.earlier else { panic!("none kept") };
        // By ten sigmas of the scale.
        let mut moved = newer;
        moved.estimate[5] += 10.0 * newer.covariance[20].sqrt() * 1e-3;
        window.steadiness.earlier[0] = Some(moved);
        let (present, variance) = window.snapshot().unwrap();
        window.steadiness.compare(present, variance);
        assert_eq!(window.estimate().residuals_white, Some(false));
        window.steadiness.earlier[0] = Some(newer);
        window.steadiness.compare(present, variance);
        assert_eq!(window.estimate().residuals_white, Some(true));
    }
}
