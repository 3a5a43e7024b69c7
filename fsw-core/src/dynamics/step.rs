//! Integration of the gyrostat equation over one interval, and its transition matrices.
//!
//! Input: rate at the start, [`Interval`]. Output: rate at the end; derivatives of it by the rate
//! at the start and by the inertia.
//!
//! | item | order | use |
//! |---|---|---|
//! | [`runge_kutta_4`] | error of a step `O(Δt⁵)` | prediction of the rate |
//! | [`AdamsBashforth2`] | error of a step `O(Δt³)` | prediction as published in \[Bellar2019\] |
//! | [`Transition`] | error `O(Δt³)` | prediction of the covariance |
//!
//! Total momentum `H = J ω + h_w` obeys `Ḣ = τ − ω × H`. In inertial space this is `dH/dt = τ`:
//! wheel torque is internal and drops out. Integration of H therefore needs the wheels' speed at
//! three instants of the interval, and no acceleration of a wheel.

use crate::dynamics::gyrostat::{Gyrostat, Jacobians};
use crate::dynamics::interval::Interval;
use crate::math::{Mat, Vec3, rotated, scalar::Real};

/// Rate at the end of the interval by the classical Runge-Kutta method of fourth order.
/// \[Hairer1993\] section II.1
///
/// State of the integration: total momentum, `Ḣ = τ − ω × H`, `ω = J⁻¹ (H − h_w)`: a measured wheel
/// speed is used directly and never differentiated. Sums run over the *change* of momentum, which
/// keeps single precision where the wheels carry much more momentum than the body.
///
/// Error per step about `(|ω| Δt)⁵ / 120` of the rate; valid up to half a radian per step.
///
/// ```
/// use fsw_core::dynamics::gyrostat::Gyrostat;
/// use fsw_core::dynamics::interval::{Drive, Interval};
/// use fsw_core::dynamics::step::runge_kutta_4;
/// use fsw_core::{Inertia, Vec3};
///
/// // 1 N m about a principal axis of 2 kg m² for 0.1 s: 0.05 rad/s.
/// let body = Gyrostat::new(&Inertia::new([2.0f64, 2.0, 1.0, 0.0, 0.0, 0.0])).unwrap();
/// let drive = Drive { torque_n_m: Vec3::x(), wheel_momentum_n_m_s: Vec3::zeros() };
/// let interval = Interval { duration_s: 0.1, start: drive, middle: drive, end: drive };
/// let rate_rad_s = runge_kutta_4(&body, &Vec3::zeros(), &interval);
/// assert!((rate_rad_s - Vec3::new(0.05, 0.0, 0.0)).norm() < 1e-15);
/// ```
pub fn runge_kutta_4<T: Real>(
    body: &Gyrostat<T>,
    rate_rad_s: &Vec3<T>,
    interval: &Interval<T>,
) -> Vec3<T> {
    let (dt, half, sixth) = (interval.duration_s, T::lit(0.5), T::lit(1.0 / 6.0));
    let (start, middle, end) = (&interval.start, &interval.middle, &interval.end);
    let h0 = start.wheel_momentum_n_m_s;
    let momentum = rotated(body.inertia_kg_m2(), rate_rad_s) + h0;
    let turned = |change: &Vec3<T>, wheel_change: &Vec3<T>| {
        rate_rad_s + rotated(body.inverse(), &(change - wheel_change))
    };
    let slope = |change: &Vec3<T>, wheel_change: &Vec3<T>, torque: &Vec3<T>| {
        torque - turned(change, wheel_change).cross(&(momentum + change))
    };
    let to_middle = middle.wheel_momentum_n_m_s - h0;
    let to_end = end.wheel_momentum_n_m_s - h0;
    let k1 = start.torque_n_m - rate_rad_s.cross(&momentum);
    let k2 = slope(&(k1 * (dt * half)), &to_middle, &middle.torque_n_m);
    let k3 = slope(&(k2 * (dt * half)), &to_middle, &middle.torque_n_m);
    let k4 = slope(&(k3 * dt), &to_end, &end.torque_n_m);
    let change = (k1 + (k2 + k3) * T::lit(2.0) + k4) * (dt * sixth);
    turned(&change, &to_end)
}

/// Two-step Adams-Bashforth rule, `x₁ = x₀ + (3 ẋ₀ − ẋ₋₁) Δt / 2`, \[Bellar2019\] Eq. (18).
///
/// Written for steps of unequal length, since a sensor's clock jitters: with `r = Δt₀ / 2 Δt₋₁`,
///
/// `x₁ = x₀ + ((1 + r) ẋ₀ − r ẋ₋₁) Δt₀`.
///
/// For equal steps it is the printed formula. Derivation: integral over the step of the straight
/// line through the last two slopes.
///
/// ```
/// use fsw_core::dynamics::step::AdamsBashforth2;
///
/// // Exact where the slope is linear in time: ẋ = 2 t, x = t².
/// let mut rule = AdamsBashforth2::<f64, 1>::default();
/// rule.change([0.0], 1.0); // from t = 0, Euler's rule
/// assert_eq!(rule.change([2.0], 1.0), [3.0]); // from t = 1: 2² − 1²
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdamsBashforth2<T: Real, const N: usize> {
    /// Slope at the start of the last step, unit/s, and the length of that step, s.
    last: Option<([T; N], T)>,
}

crate::persist!([T: Real, const N: usize] AdamsBashforth2<T, N> { last });

impl<T: Real, const N: usize> Default for AdamsBashforth2<T, N> {
    fn default() -> Self {
        Self { last: None }
    }
}

impl<T: Real, const N: usize> AdamsBashforth2<T, N> {
    /// Change over a step of `duration_s` with the derivative `slope` at its start, unit/s. The
    /// first step is Euler's.
    pub fn change(&mut self, slope: [T; N], duration_s: T) -> [T; N] {
        let before = self.last.replace((slope, duration_s));
        let Some((last_slope, last_s)) = before else {
            return slope.map(|x| x * duration_s);
        };
        let back = duration_s / last_s * T::lit(0.5);
        let mut change = slope;
        for i in 0..N {
            change[i] = ((T::one() + back) * slope[i] - back * last_slope[i]) * duration_s;
        }
        change
    }

    /// Discards the last slope: the next step is Euler's.
    pub fn restart(&mut self) {
        self.last = None;
    }
}

/// Transition of errors over an interval: `δω₁ = A δω₀ + B δj`.
///
/// The covariance of rate and inertia follows as `Φ P Φᵀ`, `Φ = [[A, B], [0, 1]]`
/// ([`Ud::transform_first`](crate::math::ud::Ud::transform_first)).
///
/// ```
/// use fsw_core::dynamics::gyrostat::Gyrostat;
/// use fsw_core::dynamics::interval::{Drive, Interval};
/// use fsw_core::dynamics::step::Transition;
/// use fsw_core::{Inertia, Vec3};
///
/// // A sphere without wheels: errors of the rate are constant.
/// let body = Gyrostat::new(&Inertia::spherical(2.0f64)).unwrap();
/// let drive = Drive { torque_n_m: Vec3::x(), wheel_momentum_n_m_s: Vec3::zeros() };
/// let interval = Interval { duration_s: 0.1, start: drive, middle: drive, end: drive };
/// let end = Vec3::new(0.05, 0.0, 0.0);
/// let transition = Transition::between(&body, &Vec3::zeros(), &end, &interval);
/// assert!((transition.rate.trace() - 3.0).abs() < 1e-15);
/// // The rate gained, τ Δt / Jxx = 0.05 rad/s, falls by 0.025 rad/s per kg m² of Jxx.
/// assert!((transition.inertia[(0, 0)] + 0.025).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition<T: Real> {
    /// Matrix `A = ∂ω₁/∂ω₀`, 3×3.
    pub rate: Mat<T, 3, 3>,
    /// Matrix `B = ∂ω₁/∂j`, 3×6, rad/s per kg m².
    pub inertia: Mat<T, 3, 6>,
}

impl<T: Real> Transition<T> {
    /// Transition to second order in the step, with the Jacobians `F = ∂ω̇/∂ω` and `F_j = ∂ω̇/∂j`
    /// taken half-way:
    ///
    /// `A = 1 + F Δt (1 + F Δt / 2)`, `B = (1 + F Δt / 2) F_j Δt`.
    ///
    /// \[Bellar2019\] Eq. (5) stops at first order with the Jacobian of the start, which biases the
    /// sensitivities for a step that turns the body by more than a few milliradians.
    pub fn between(
        body: &Gyrostat<T>,
        rate_start_rad_s: &Vec3<T>,
        rate_end_rad_s: &Vec3<T>,
        interval: &Interval<T>,
    ) -> Self {
        let (dt, half) = (interval.duration_s, T::lit(0.5));
        let rate = (rate_start_rad_s + rate_end_rad_s) * half;
        let acceleration = (rate_end_rad_s - rate_start_rad_s) * (T::one() / dt);
        let Jacobians { rate: f, inertia: f_j } =
            body.jacobians(&rate, &acceleration, &interval.middle.wheel_momentum_n_m_s);
        let turn = f * dt;
        let half_way = Mat::identity() + turn * half;
        Self { rate: Mat::identity() + turn * half_way, inertia: half_way * f_j * dt }
    }

    /// Matrix A alone.
    pub fn of_rate(
        body: &Gyrostat<T>,
        rate_start_rad_s: &Vec3<T>,
        rate_end_rad_s: &Vec3<T>,
        interval: &Interval<T>,
    ) -> Mat<T, 3, 3> {
        let rate = (rate_start_rad_s + rate_end_rad_s) * T::lit(0.5);
        let f = body.rate_jacobian(&rate, &interval.middle.wheel_momentum_n_m_s);
        let turn = f * interval.duration_s;
        Mat::identity() + turn * (Mat::identity() + turn * T::lit(0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::interval::Drive;
    use crate::tensor::Inertia;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];

    /// Interval with a wheel whose speed is a parabola and a torque that is linear in time:
    /// interpolation is exact for both.
    fn interval(t0: f64, dt: f64) -> Interval<f64> {
        let drive = |t: f64| Drive {
            torque_n_m: Vec3::new(0.1 + 0.05 * t, -0.2, 0.1 * t),
            wheel_momentum_n_m_s: Vec3::new(0.3 * t * t, 0.5 - 0.2 * t, 0.1),
        };
        let (start, middle, end) = (drive(t0), drive(t0 + 0.5 * dt), drive(t0 + dt));
        Interval { duration_s: dt, start, middle, end }
    }

    fn fly(inertia: [f64; 6], rate: Vec3<f64>, steps: usize) -> Vec3<f64> {
        let body = Gyrostat::new(&Inertia::new(inertia)).unwrap();
        let dt = 1.0 / steps as f64;
        (0..steps).fold(rate, |w, k| runge_kutta_4(&body, &w, &interval(k as f64 * dt, dt)))
    }

    #[test]
    fn runge_kutta_converges_with_the_fourth_power() {
        let rate = Vec3::new(0.4, -0.3, 0.5);
        let fine = fly(INERTIA, rate, 512);
        let (e8, e16) =
            ((fly(INERTIA, rate, 8) - fine).norm(), (fly(INERTIA, rate, 16) - fine).norm());
        let order = (e8 / e16).log2();
        assert!((3.7..4.3).contains(&order), "order {order}");
    }

    /// Length of the total momentum over 1000 steps, relative to 1e-10.
    #[test]
    fn the_magnitude_of_momentum_is_conserved_without_torque() {
        let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
        let mut w = Vec3::new(0.4, -0.3, 0.5);
        let still = Vec3::new(0.1, 0.2, -0.1);
        let drive = Drive { torque_n_m: Vec3::zeros(), wheel_momentum_n_m_s: still };
        let interval = Interval { duration_s: 0.01, start: drive, middle: drive, end: drive };
        let length = |w: &Vec3<f64>| (body.inertia_kg_m2() * w + still).norm();
        let before = length(&w);
        for _ in 0..1000 {
            w = runge_kutta_4(&body, &w, &interval);
        }
        assert!((length(&w) / before - 1.0).abs() < 1e-10);
    }

    /// Central differences of the step against both matrices, at two step lengths: the error falls
    /// with the third power.
    #[test]
    fn the_transition_is_the_derivative_of_the_step_to_third_order() {
        let rate = Vec3::new(0.4, -0.3, 0.5);
        let error = |dt: f64| {
            let iv = interval(0.0, dt);
            let step = |j: [f64; 6], w: &Vec3<f64>| {
                runge_kutta_4(&Gyrostat::new(&Inertia::new(j)).unwrap(), w, &iv)
            };
            let body = Gyrostat::new(&Inertia::new(INERTIA)).unwrap();
            let end = step(INERTIA, &rate);
            let t = Transition::between(&body, &rate, &end, &iv);
            assert_eq!(Transition::of_rate(&body, &rate, &end, &iv), t.rate);
            let h = 1e-5;
            let mut worst = 0.0f64;
            for i in 0..3 {
                let mut d = Vec3::zeros();
                d[i] = h;
                let slope = (step(INERTIA, &(rate + d)) - step(INERTIA, &(rate - d))) / (2.0 * h);
                worst = worst.max((t.rate.column(i) - slope).norm());
            }
            for i in 0..6 {
                let (mut up, mut down) = (INERTIA, INERTIA);
                up[i] += h;
                down[i] -= h;
                let slope = (step(up, &rate) - step(down, &rate)) / (2.0 * h);
                worst = worst.max((t.inertia.column(i) - slope).norm());
            }
            worst
        };
        let order = (error(0.2) / error(0.1)).log2();
        assert!((2.6..3.5).contains(&order), "order {order}");
    }

    /// The rule integrates a linear slope exactly, at steps of 0.3 s and 0.1 s.
    #[test]
    fn adams_bashforth_is_exact_for_a_parabola_at_unequal_steps() {
        let mut rule = AdamsBashforth2::<f64, 1>::default();
        let slope = |t: f64| [2.0 + 3.0 * t];
        rule.change(slope(0.0), 0.3);
        let change = rule.change(slope(0.3), 0.1)[0];
        let exact = 2.0 * 0.1 + 1.5 * (0.16 - 0.09);
        assert!((change - exact).abs() < 1e-15);
    }

    /// Equal steps: \[Bellar2019\] Eq. (18).
    #[test]
    fn adams_bashforth_is_the_printed_formula_at_equal_steps() {
        let mut rule = AdamsBashforth2::<f64, 1>::default();
        rule.change([5.0], 0.1);
        assert!((rule.change([7.0], 0.1)[0] - 0.5 * (3.0 * 7.0 - 5.0) * 0.1).abs() < 1e-15);
    }
}
