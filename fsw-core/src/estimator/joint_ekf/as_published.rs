//! The filter as \[Bellar2019\] prints it: AB2 propagation, first-order transition, `(1 − K H) P`.
//!
//! Departures from the paper: wheels act through the change of their momentum over the interval
//! (the paper has none); the Adams-Bashforth rule and Eq. (5) take the length of each interval,
//! which the paper has constant; no gyro bias b of Eq. (15), which the paper's filter does not
//! estimate either.
//!
//! | symbol | meaning | equation |
//! |---|---|---|
//! | `F` | Jacobian of the dynamics by the nine states | (6), (7) |
//! | `Φ` | `1 + F Δt` | (5) |
//! | `s` | spectral amplitude of the rate's process noise, rad²/s³ | (11) |
//! | `Q` | process noise over one step | (13), (14) |
//! | `H` | `[1 0]`, measurement matrix | (17) |
//! | `K` | gain | (20) |
//!
//! The form considers no parameters of the hardware: it passes no [`Prediction`] and no [`Gain`] on.
//!
//! Known weaknesses, kept since this form is for comparison: the covariance loses symmetry, and
//! then positivity, to rounding; the inertia decays by 0.06 % of a moment over 600 s, three times
//! the Cramér-Rao bound of the paper's scenario.

use super::considered::{Gain, Prediction};
use super::{Config, Form, State};
use crate::dynamics::gyrostat::{Gyrostat, Jacobians};
use crate::dynamics::interval::Interval;
use crate::dynamics::step::AdamsBashforth2;
use crate::math::{Mat, Vec3, inverse_symmetric, scalar::Real, ud::Ud};
use crate::tensor::Inertia;

/// `τ_m`, `τ_p` of \[Bellar2019\] Table 2: time constants of the Gauss-Markov moments and products,
/// s.
const TIME_CONSTANT_S: [f64; 6] = [1.0e6, 1.0e6, 1.0e6, 1.0e5, 1.0e5, 1.0e5];

/// Full 9×9 covariance (rad²/s², rad/s kg m², kg² m⁴), with the memory of the Adams-Bashforth rule.
#[derive(Clone, Copy, Debug)]
pub struct AsPublished<T: Real> {
    covariance: Mat<T, 9, 9>,
    rule: AdamsBashforth2<T, 9>,
}

crate::persist!([T: Real] AsPublished<T> { covariance, rule });

impl<T: Real> AsPublished<T> {
    /// `x⁻ = x⁺ + ½ (3 ẋₖ − ẋₖ₋₁) Δt` for all nine states, \[Bellar2019\] Eqs. (2), (18), and
    /// `− J⁻¹ Δh_w`, the wheels' part (rad/s).
    ///
    /// `slope`: ω̇ at the start of the interval without `ḣ_w`, rad/s².
    fn propagate_state(&mut self, state: &mut State<T>, slope: &Vec3<T>, wheels: &Vec3<T>, dt: T) {
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
    }
}

impl<T: Real> AsPublished<T> {
    /// `P⁻ = Φ P⁺ Φᵀ + Q`, with the Jacobians at the start of the interval.
    fn propagate_covariance(
        &mut self,
        body: &Gyrostat<T>,
        start_rad_s: &Vec3<T>,
        acceleration_rad_s2: &Vec3<T>,
        interval: &Interval<T>,
        config: &Config<T>,
    ) {
        let dt = interval.duration_s;
        let wheels = &interval.start.wheel_momentum_n_m_s;
        let f = body.jacobians(start_rad_s, acceleration_rad_s2, wheels);
        let transition = transition(&f, dt);
        self.covariance = transition * self.covariance * transition.transpose();
        let q = process_noise(&f.rate, config.rate_walk_rad_s_sqrt_s, dt);
        for i in 0..3 {
            for k in 0..3 {
                self.covariance[(i, k)] += q[(i, k)];
            }
        }
    }
}

impl<T: Real> Form<T> for AsPublished<T> {
    fn new(covariance: &Ud<T, 9>) -> Self {
        Self { covariance: covariance.covariance(), rule: AdamsBashforth2::default() }
    }

    /// State by Eq. (18); `P⁻ = Φ P⁺ Φᵀ + Q`, \[Bellar2019\] Eq. (19), with Φ of Eq. (5) and Q of
    /// Eqs. (13), (14).
    fn predict(
        &mut self,
        state: &mut State<T>,
        interval: &Interval<T>,
        config: &Config<T>,
        _visit: impl FnOnce(&Prediction<'_, T>),
    ) -> Option<()> {
        let body = Gyrostat::new(&state.inertia)?;
        let dt = interval.duration_s;
        let (rate, start) = (state.rate_rad_s, &interval.start);
        let wheels =
            body.inverse() * (interval.end.wheel_momentum_n_m_s - start.wheel_momentum_n_m_s);
        let slope = body.acceleration_rad_s2(&rate, &start.wheel_momentum_n_m_s, &start.torque_n_m);
        self.propagate_state(state, &slope, &wheels, dt);
        let acceleration = slope - wheels * (T::one() / dt);
        self.propagate_covariance(&body, &rate, &acceleration, interval, config);
        Some(())
    }

    /// With the mean acceleration of the interval.
    fn predict_covariance(
        &mut self,
        body: &Gyrostat<T>,
        (start_rad_s, end_rad_s): (&Vec3<T>, &Vec3<T>),
        interval: &Interval<T>,
        config: &Config<T>,
    ) {
        let acceleration = (end_rad_s - start_rad_s) * (T::one() / interval.duration_s);
        self.propagate_covariance(body, start_rad_s, &acceleration, interval, config);
    }

    /// The first three diagonal elements, rad²/s².
    fn rate_variance(&self) -> Vec3<T> {
        Vec3::from_fn(|i, _| self.covariance[(i, i)])
    }

    /// \[Bellar2019\] Eqs. (20) to (22) with `H = [1 0]`:
    ///
    /// `K = P⁻ Hᵀ (H P⁻ Hᵀ + R)⁻¹`, `x⁺ = x⁻ + K (y − H x⁻)`, `P⁺ = (1 − K H) P⁻`
    ///
    /// A covariance without an inverse is marked invalid by a negative variance, see
    /// [`is_valid`](Form::is_valid); the caller restarts.
    fn update(
        &mut self,
        state: &mut State<T>,
        measured_rad_s: &Vec3<T>,
        noise_variance: T,
        _choose: impl FnMut(&Gain<T>) -> Option<[T; 9]>,
    ) {
        let p = self.covariance;
        let s: Mat<T, 3, 3> =
            Mat::from_fn(|i, k| p[(i, k)] + if i == k { noise_variance } else { T::zero() });
        let Some(s_inverse) = inverse_symmetric(&s) else {
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

    /// Clears the rows and columns of the rate, and the memory of the Adams-Bashforth rule.
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

    /// Checks the diagonal alone: rounding may have made the rest indefinite unnoticed.
    fn is_valid(&self) -> bool {
        self.covariance.iter().all(|x| x.is_finite())
            && (0..9).all(|i| self.covariance[(i, i)] >= T::zero())
    }
}

/// `Φ ≈ 1 + F Δt`, \[Bellar2019\] Eq. (5), with F of Eq. (7): `∂ω̇/∂ω` (1/s), `∂ω̇/∂j`
/// (rad/s² per kg m²), and `−1/τ` on the diagonal of the inertia.
fn transition<T: Real>(f: &Jacobians<T>, dt: T) -> Mat<T, 9, 9> {
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
    transition
}

/// Process noise of the rate over one interval, rad²/s², \[Bellar2019\] Eq. (14):
///
/// `q = s Δt + (s Fᵀ + F s) Δt²/2 + F s Fᵀ Δt³/3`
///
/// with `F = ∂ω̇/∂ω` (1/s) and the spectral amplitude `s = rate_walk²` (rad²/s³), the same on each
/// axis.
fn process_noise<T: Real>(f: &Mat<T, 3, 3>, rate_walk: T, dt: T) -> Mat<T, 3, 3> {
    let ft = f.transpose();
    let series = Mat::<T, 3, 3>::identity() * dt
        + (ft + f) * (dt * dt * T::lit(0.5))
        + f * ft * (dt * dt * dt * T::lit(1.0 / 3.0));
    series * (rate_walk * rate_walk)
}
