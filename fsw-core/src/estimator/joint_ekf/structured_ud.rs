//! The filter that flies: UD factors, and the structure of this problem used throughout.
//!
//! The nine states split into rate and inertia. The transition is `[[A, B], [0, 1]]`, the
//! measurement `[1 0]`: a prediction leaves the inertia's factors as they are, and a measurement is
//! three scalar updates of Bierman's ([`Ud`]). No square root, and no full 9×9 product.
//!
//! Departures from \[Bellar2019\]: Runge-Kutta instead of AB2; a transition to second order,
//! taken half-way; constant inertia instead of one that decays with 10⁵ to 10⁶ s (over 600 s that
//! decay is 0.06 % of a moment, three times the Cramér-Rao bound of the paper's scenario), with an
//! optional random walk; process noise of the rate to first order, `s Δt`.

use super::{Config, Form, State};
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::Interval;
use crate::dynamics::step::{Transition, runge_kutta_4};
use crate::math::{Mat, Vec3, scalar::Real, ud::Ud};
use crate::tensor::Inertia;

/// A correction that would make the inertia indefinite is halved, at most this often, and then
/// left out.
const HALVINGS: u32 = 3;

/// The covariance's UD factors, rate first.
#[derive(Clone, Copy, Debug)]
pub struct StructuredUd<T: Real> {
    factors: Ud<T, 9>,
}

crate::persist!([T: Real] StructuredUd<T> { factors });

impl<T: Real> StructuredUd<T> {
    /// Propagates the covariance over an interval of this length, s: transition and process noise.
    #[inline]
    pub fn propagate(&mut self, transition: &Transition<T>, duration_s: T, config: &Config<T>) {
        self.factors.transform_first(&transition.rate, &transition.inertia);
        let walk = config.rate_walk_rad_s_sqrt_s;
        for i in 0..3 {
            self.factors.inflate(i, walk * walk * duration_s);
        }
        for (i, walk) in config.inertia_walk_kg_m2_sqrt_s.into_iter().enumerate() {
            self.factors.inflate(3 + i, walk * walk * duration_s);
        }
    }
}

impl<T: Real> Form<T> for StructuredUd<T> {
    fn new(covariance: &Ud<T, 9>) -> Self {
        Self { factors: *covariance }
    }

    fn predict(
        &mut self,
        state: &mut State<T>,
        interval: &Interval<T>,
        config: &Config<T>,
    ) -> Option<()> {
        let body = Gyrostat::new(&state.inertia)?;
        let rate_start = state.rate_rad_s;
        state.rate_rad_s = runge_kutta_4(&body, &rate_start, interval);
        let transition = Transition::between(&body, &rate_start, &state.rate_rad_s, interval);
        self.propagate(&transition, interval.duration_s, config);
        Some(())
    }

    fn rate_variance(&self) -> Vec3<T> {
        Vec3::from_fn(|i, _| self.factors.variance(i))
    }

    fn update(&mut self, state: &mut State<T>, measured_rad_s: &Vec3<T>, noise_variance: T) {
        let mut change = [T::zero(); 6];
        for axis in 0..3 {
            let innovation = measured_rad_s[axis] - state.rate_rad_s[axis];
            let gain = self.factors.observe(axis, noise_variance);
            for i in 0..3 {
                state.rate_rad_s[i] += gain[i] * innovation;
            }
            for k in 0..6 {
                change[k] += gain[3 + k] * innovation;
            }
        }
        state.inertia = corrected(&state.inertia, change);
    }

    fn restart_rate(&mut self, variance: T) {
        for i in 0..3 {
            self.factors.set_d(i, variance);
            for k in i + 1..9 {
                self.factors.set_u(i, k, T::zero());
            }
        }
    }

    fn covariance(&self) -> Mat<T, 9, 9> {
        self.factors.covariance()
    }

    fn is_valid(&self) -> bool {
        self.factors.is_valid()
    }
}

/// `inertia + change`, the change shortened where the sum would not be positive definite: the
/// next prediction needs an inverse, and noise on a wide prior can overshoot. An inertia that isn't
/// positive definite itself (see [`Config::initial_inertia_kg_m2`]) takes any change.
fn corrected<T: Real>(inertia: &Inertia<T>, change: [T; 6]) -> Inertia<T> {
    let elements = inertia.elements_kg_m2();
    let moved = |share: T| Inertia::new(core::array::from_fn(|k| elements[k] + share * change[k]));
    let whole = moved(T::one());
    if whole.is_positive_definite() || !inertia.is_positive_definite() {
        return whole;
    }
    let mut share = T::one();
    for _ in 0..HALVINGS {
        share *= T::lit(0.5);
        let sum = moved(share);
        if sum.is_positive_definite() {
            return sum;
        }
    }
    *inertia
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn random_form(x: &[f64; 32]) -> StructuredUd<f64> {
        let mut factors = Ud::diagonal(core::array::from_fn(|i| x[i] + 1.5));
        for k in 1..9 {
            for i in 0..k {
                factors.set_u(i, k, x[(7 * i + 11 * k) % 32]);
            }
        }
        StructuredUd::new(&factors)
    }

    proptest! {
        #[test]
        fn restarting_the_rate_keeps_the_inertia(x in prop::array::uniform32(-1.0..1.0f64)) {
            let mut form = random_form(&x);
            let before = form.covariance();
            form.restart_rate(0.25);
            let after = form.covariance();
            let inertia = |p: &Mat<f64, 9, 9>| p.fixed_view::<6, 6>(3, 3).into_owned();
            prop_assert!((inertia(&before) - inertia(&after)).abs().max() < 1e-12);
            prop_assert_eq!(form.rate_variance(), Vec3::repeat(0.25));
            prop_assert_eq!(after.fixed_view::<3, 6>(0, 3).into_owned(), Mat::<f64, 3, 6>::zeros());
        }
    }

    #[test]
    fn a_correction_never_makes_the_inertia_indefinite() {
        let inertia = Inertia::new([1.0f32, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let halved = corrected(&inertia, [-1.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(halved.elements_kg_m2()[0], 0.25);
        assert_eq!(corrected(&inertia, [-100.0; 6]), inertia);
        assert_eq!(corrected(&inertia, [f32::NAN; 6]), inertia);
    }

    #[test]
    fn an_inertia_that_is_indefinite_already_takes_any_correction() {
        let inertia = Inertia::new([-3.0f32, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let moved = corrected(&inertia, [1.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
        assert_eq!(moved.elements_kg_m2(), [-2.0, 1.0, 1.0, 0.5, 0.0, 0.0]);
    }
}
