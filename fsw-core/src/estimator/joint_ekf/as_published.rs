//! The filter as \[Bellar2019\] prints it.
//!
//! Departures, each named: wheels act through the change of their momentum over the interval
//! (the paper has none); the Adams-Bashforth rule and Eq. (5) take each interval's own length.

use super::{Config, Form, State};
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::Interval;
use crate::dynamics::step::AdamsBashforth2;
use crate::math::{Mat, Vec3, inverse_symmetric, scalar::Real, ud::Ud};
use crate::tensor::Inertia;

/// τ_m, τ_p of \[Bellar2019\] Table 2: time constants of the Gauss-Markov moments and products, s.
const TIME_CONSTANT_S: [f64; 6] = [1.0e6, 1.0e6, 1.0e6, 1.0e5, 1.0e5, 1.0e5];

/// A full 9×9 covariance, corrected as `(1 − K H) P`: it loses symmetry, and then positivity, to
/// rounding. Kept because people will compare.
#[derive(Clone, Copy, Debug)]
pub struct AsPublished<T: Real> {
    covariance: Mat<T, 9, 9>,
    rule: AdamsBashforth2<T, 9>,
}

crate::persist!([T: Real] AsPublished<T> { covariance, rule });

impl<T: Real> Form<T> for AsPublished<T> {
    fn new(covariance: &Ud<T, 9>) -> Self {
        Self { covariance: covariance.covariance(), rule: AdamsBashforth2::default() }
    }

    /// \[Bellar2019\] Eqs. (5), (14), (18), (19).
    fn predict(
        &mut self,
        state: &mut State<T>,
        interval: &Interval<T>,
        config: &Config<T>,
    ) -> Option<()> {
        let body = Gyrostat::new(&state.inertia)?;
        let dt = interval.duration_s;
        let (rate, start) = (state.rate_rad_s, &interval.start);
        let wheels =
            body.inverse() * (interval.end.wheel_momentum_n_m_s - start.wheel_momentum_n_m_s);
        let slope = body.acceleration_rad_s2(&rate, &start.wheel_momentum_n_m_s, &start.torque_n_m);
        let acceleration = slope - wheels * (T::one() / dt);
        let f = body.jacobians(&rate, &acceleration, &start.wheel_momentum_n_m_s);

        // Eq. (5), Φ ≈ 1 + F Δt, with F of Eq. (7).
        let mut transition = Mat::<T, 9, 9>::identity();
        for i in 0..3 {
            for k in 0..3 {
                transition[(i, k)] += f.rate[(i, k)] * dt;
            }
            for k in 0..6 {
                transition[(i, 3 + k)] = f.inertia[(i, k)] * dt;
            }
        }
        for k in 0..6 {
            transition[(3 + k, 3 + k)] -= dt / T::lit(TIME_CONSTANT_S[k]);
        }

        // Eq. (18), all nine states.
        let elements = state.inertia.elements_kg_m2();
        let mut slopes = [T::zero(); 9];
        for i in 0..3 {
            slopes[i] = slope[i];
        }
        for k in 0..6 {
            slopes[3 + k] = -elements[k] / T::lit(TIME_CONSTANT_S[k]);
        }
        let change = self.rule.change(slopes, dt);
        state.rate_rad_s += Vec3::new(change[0], change[1], change[2]) - wheels;
        state.inertia = Inertia::new(core::array::from_fn(|k| elements[k] + change[3 + k]));

        // Eq. (19).
        self.covariance = transition * self.covariance * transition.transpose();
        let q = process_noise(&f.rate, config.rate_walk_rad_s_sqrt_s, dt);
        for i in 0..3 {
            for k in 0..3 {
                self.covariance[(i, k)] += q[(i, k)];
            }
        }
        Some(())
    }

    fn rate_variance(&self) -> Vec3<T> {
        Vec3::from_fn(|i, _| self.covariance[(i, i)])
    }

    /// \[Bellar2019\] Eqs. (20) to (22).
    fn update(&mut self, state: &mut State<T>, measured_rad_s: &Vec3<T>, noise_variance: T) {
        let p = self.covariance;
        let s: Mat<T, 3, 3> =
            Mat::from_fn(|i, k| p[(i, k)] + if i == k { noise_variance } else { T::zero() });
        let Some(s_inverse) = inverse_symmetric(&s) else {
            // A covariance past repair: the caller sees it, and starts over.
            self.covariance[(0, 0)] = -T::one();
            return;
        };
        let p_ht: Mat<T, 9, 3> = Mat::from_fn(|i, k| p[(i, k)]);
        let gain = p_ht * s_inverse;
        let change = gain * (measured_rad_s - state.rate_rad_s);
        state.rate_rad_s += Vec3::new(change[0], change[1], change[2]);
        let elements = state.inertia.elements_kg_m2();
        state.inertia = Inertia::new(core::array::from_fn(|k| elements[k] + change[3 + k]));
        let h_p: Mat<T, 3, 9> = Mat::from_fn(|i, k| p[(i, k)]);
        self.covariance = p - gain * h_p;
    }

    fn restart_rate(&mut self, variance: T) {
        for i in 0..3 {
            for k in 0..9 {
                self.covariance[(i, k)] = T::zero();
                self.covariance[(k, i)] = T::zero();
            }
            self.covariance[(i, i)] = variance;
        }
        self.rule.restart();
    }

    fn covariance(&self) -> Mat<T, 9, 9> {
        self.covariance
    }

    fn is_valid(&self) -> bool {
        self.covariance.iter().all(|x| x.is_finite())
            && (0..9).all(|i| self.covariance[(i, i)] >= T::zero())
    }
}

/// \[Bellar2019\] Eq. (14): `s Δt + (s Fᵀ + F s) Δt²/2 + F s Fᵀ Δt³/3`, the same s on each axis.
fn process_noise<T: Real>(f: &Mat<T, 3, 3>, rate_walk: T, dt: T) -> Mat<T, 3, 3> {
    let ft = f.transpose();
    let series = Mat::<T, 3, 3>::identity() * dt
        + (ft + f) * (dt * dt * T::lit(0.5))
        + f * ft * (dt * dt * dt * T::lit(1.0 / 3.0));
    series * (rate_walk * rate_walk)
}
