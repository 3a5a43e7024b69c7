//! Considered parameters: errors of gyro, wheels and torque that widen the covariance without being
//! estimated.
//!
//! Each parameter p of the stated [`Hardware`], and each [`Disturbance`], carries a column
//! `Γ = ∂(x − x̂)/∂p`: the error of the nine states that a parameter of one would cause. With the deviation `σ_p` of each, errors of different
//! parameters independent, the covariance of the error is
//!
//! `P + Σ_p σ_p² Γ Γᵀ`,
//!
//! P that of the noise, in the factors of the form. It holds for any gain, and is exact as far as the
//! filter is linear. The gain is the one that makes it least, of \[Schmidt1966\]: where the hardware is
//! what limits, a reading changes the estimate less than noise alone would allow.
//!
//! # Equations
//!
//! With the true motion `x₁ = f(x₀, p)`, reading `y = h(x, p) + v`, and a filter that takes p as zero,
//!
//! ```text
//! prediction   Γ⁻ = Φ Γ⁺ + ∂f/∂p              error of the prediction: Φ (x − x̂) + ∂f/∂p p
//! innovation   g  = H Γ⁻ + ∂h/∂p              ν = H (x − x̂) + ∂h/∂p p + v
//! its variance S_total = S + Σ_p σ_p² g²      S = H P⁻ Hᵀ + R
//! gain         K  = (P⁻ Hᵀ + Σ_p σ_p² Γ⁻ g) / S_total
//! correction   Γ⁺ = Γ⁻ − K g                  x − x̂ less K ν
//!              P⁺ = (1 − K H) P⁻ (1 − K H)ᵀ + K R Kᵀ
//! ```
//!
//! `Φ = [[A, B], [0, 1]]` is the filter's transition, `H = [1 0]` of one axis: the last four lines follow for
//! each axis in turn, with a scalar innovation. Columns are stored times `σ_p`, in rad/s and kg m². The form of
//! the covariance takes any gain ([`StructuredUd`](super::StructuredUd)).
//!
//! Derivation of the gain: error and innovation have the covariance `P⁻ Hᵀ + Σ σ_p² Γ⁻ g`, and the least variance
//! after a linear correction is left by their ratio. Without parameters it is the gain of the ideal filter.
//!
//! Derivatives, by the model of [`hardware`](crate::hardware). Of the reading:
//!
//! | parameter | `∂h/∂p` |
//! |---|---|
//! | scale factor of axis i | `ωᵢ` on axis i |
//! | reading of axis i of a rate about axis k | `ω_k` on axis i |
//! | time offset | `−ω̇`, at the end of the interval |
//! | bias of axis i | 1 on axis i |
//!
//! Of the motion, `∂f/∂p = N q`, `N = ½ (1 + A) J⁻¹`, with q the impulse (N m s) that an interval of
//! length Δt adds to the equation of motion `J ω̇ = τ − ḣ_w − ω × (J ω + h_w)`. For a part `η d` of the
//! wheel momentum, with d constant, it is `q = −d Δη − (ω × d) η Δt`, ω and η at the middle:
//!
//! | parameter | q |
//! |---|---|
//! | spin inertia of wheel i | that of `d = aᵢ`, `η = Iₛᵢ Ωᵢ` |
//! | tilt of its axis | that of `d = e₁` or `e₂`, the same η |
//! | common spin inertia | `−Δh_w − (ω × h_w) Δt` |
//! | known torque | `τ Δt` |
//! | disturbance torque about axis i | `Δt` on axis i |
//!
//! Each is of second order in the step, as the transition is. A turn of all sensors as one is not shown by any
//! motion: it has no column, and turns the tensor in the covariance alone.
//!
//! # Start
//!
//! From a prior, the errors of the inertia do not depend on the hardware: its rows of Γ are zero. A
//! rate that is taken from a reading has the reading's error, `Γ_ω = −∂h/∂p`.
//!
//! An alignment depends on the hardware too, in a way that is not accumulated. Its values are taken over, its
//! rows of Γ are zero, and its covariance is widened, so that data after it decide:
//!
//! | part | added sigma | reason |
//! |---|---|---|
//! | rate | e, the error of a reading that the hardware explains | the rate agrees with the readings |
//! | each element | 10 e / ω of the mean moment, at most the tenth that ends an alignment | motion that determines the products weakly amplifies, by 4 of 0.1° of the gyro's axes on the STSAT-3 spin-up (measured with the gain of noise alone); the rest is margin |
//! | common scale | 3 times the sigma of scale factors, spin inertias and torque | the same error that the columns contain; counted as independent at three times its size it narrows them by 5 % |
//!
//! Information is lost where an alignment takes a large part of the flight: it ends after 346 of 600 s of the
//! STSAT-3 spin-up.
//!
//! # Monitors
//!
//! Spike gate, shift test and mean NIS allow the parameters three sigma. The test of whiteness takes the same as
//! explained: it shows what the stated hardware does not.
//!
//! # Cost
//!
//! About 110 multiplications and 510 instructions of a Cortex-M4F a step for each parameter, and 1,000 instructions
//! for the factors. The number P of columns is part of the type;
//! without columns nothing of this is compiled.

use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::Interval;
use crate::dynamics::step::Transition;
use crate::dynamics::wheels::{Momenta, WheelArray};
use crate::error::{ConfigError, Invalid};
use crate::hardware::{Disturbance, Finding, Hardware, Parameter, tilt_directions, turned_by};
use crate::math::{Mat, Vec3, column, norm, scalar::Real};
use crate::sample::Sample;
use crate::tensor::Inertia;

/// Prediction over one interval, for its columns.
#[derive(Clone, Copy, Debug)]
pub struct Prediction<'a, T: Real> {
    /// Body of the predicted inertia.
    pub body: &'a Gyrostat<T>,
    /// Rate at the start and at the end, rad/s.
    pub rates_rad_s: [Vec3<T>; 2],
    /// Drive over the interval.
    pub interval: &'a Interval<T>,
    /// Transition of the errors of rate and inertia.
    pub transition: &'a Transition<T>,
}

/// Gain of one axis for ideal hardware.
#[derive(Clone, Copy, Debug)]
pub struct Gain<'a, T: Real> {
    /// The axis, 0 to 2.
    pub axis: usize,
    /// Variance S of the innovation, rad²/s².
    pub variance: T,
    /// Gain of the nine states, 1 and kg m² per rad/s.
    pub gain: &'a [T; 9],
}

/// Sensitivity of the filter to one parameter, times one sigma of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Column<T: Real> {
    /// The parameter; none in an unused place.
    parameter: Option<Parameter>,
    /// One sigma, in its unit.
    sigma: T,
    /// d of a parameter of one wheel, times sigma.
    direction: Vec3<T>,
    /// Γ of rate (rad/s) and inertia (kg m²).
    state: [T; 9],
    /// `∂h/∂p` at the last sample, rad/s.
    reading: Vec3<T>,
    /// η of a parameter of one wheel at the last sample, N m s.
    momentum: T,
}

crate::persist!([T: Real] Column<T> { state, reading, momentum; unchanged parameter, sigma, direction });

impl<T: Real> Column<T> {
    /// Place without a parameter.
    const UNUSED: Self = Self {
        parameter: None,
        sigma: T::ZERO,
        direction: zero_vector(),
        state: [T::ZERO; 9],
        reading: zero_vector(),
        momentum: T::ZERO,
    };

    /// Column of a parameter before any sample.
    fn of<const W: usize>(parameter: Parameter, sigma: T, wheels: &WheelArray<T, W>) -> Self {
        let axis = |wheel: u8| column(wheels.axes(), usize::from(wheel));
        let direction = match parameter {
            Parameter::WheelInertia(wheel) => axis(wheel),
            Parameter::WheelAxis(wheel, tilt) => {
                let [first, second] = tilt_directions(&axis(wheel));
                if tilt == 0 { first } else { second }
            }
            _ => Vec3::zeros(),
        };
        let parameter = Some(parameter);
        Self { parameter, sigma, direction: direction * sigma, ..Self::UNUSED }
    }

    /// Index of the wheel that the parameter belongs to.
    fn wheel(&self) -> Option<usize> {
        match self.parameter? {
            Parameter::WheelInertia(wheel) | Parameter::WheelAxis(wheel, _) => {
                Some(usize::from(wheel))
            }
            _ => None,
        }
    }

    /// Sets `∂h/∂p` for this rate (rad/s) and acceleration (rad/s²).
    fn set_reading(&mut self, rate_rad_s: &Vec3<T>, acceleration_rad_s2: &Vec3<T>) {
        let entry = |axis: u8, about: u8| (usize::from(axis), usize::from(about));
        let (axis, about) = match self.parameter {
            Some(Parameter::GyroScale(axis)) => entry(axis, axis),
            Some(Parameter::GyroAxes(axis, about)) => entry(axis, about),
            Some(Parameter::Delay) => {
                self.reading = acceleration_rad_s2 * -self.sigma;
                return;
            }
            Some(Parameter::GyroBias(axis)) => {
                self.reading = axis_vector(axis) * self.sigma;
                return;
            }
            _ => return,
        };
        if axis < 3 && about < 3 {
            self.reading[axis] = rate_rad_s[about] * self.sigma;
        }
    }

    /// Impulse q of an interval, N m s, times sigma; `None` where the parameter does not act on the
    /// motion. Takes over the momentum of the wheel at the end.
    #[inline]
    fn impulse<const W: usize>(
        &mut self,
        rate_rad_s: &Vec3<T>,
        interval: &Interval<T>,
        momenta: &Momenta<T, W>,
    ) -> Option<Vec3<T>> {
        let dt = interval.duration_s;
        match self.parameter? {
            Parameter::WheelInertia(wheel) | Parameter::WheelAxis(wheel, _) => {
                let end = momentum_of(momenta, usize::from(wheel));
                let (change, sum) = (end - self.momentum, end + self.momentum);
                self.momentum = end;
                let half_dt = dt * T::lit(0.5);
                let turned = rate_rad_s.cross(&self.direction) * (sum * half_dt);
                Some(-(self.direction * change + turned))
            }
            Parameter::CommonWheelInertia => {
                let (start, end) = (&interval.start, &interval.end);
                let change = end.wheel_momentum_n_m_s - start.wheel_momentum_n_m_s;
                let turned = rate_rad_s.cross(&interval.middle.wheel_momentum_n_m_s) * dt;
                Some((change + turned) * -self.sigma)
            }
            Parameter::TorqueScale => Some(interval.middle.torque_n_m * (dt * self.sigma)),
            Parameter::DisturbanceTorque(axis) => Some(axis_vector(axis) * (dt * self.sigma)),
            Parameter::GyroScale(_)
            | Parameter::GyroAxes(..)
            | Parameter::GyroBias(_)
            | Parameter::Mount(_)
            | Parameter::ModalInertia(..)
            | Parameter::ModeFrequency(_)
            | Parameter::ModeDamping(_)
            | Parameter::Delay => None,
        }
    }

    /// `Γ ← Φ Γ`, and `N q` where there is an impulse.
    #[inline]
    fn propagate(&mut self, transition: &Transition<T>, added_rad_s: Option<Vec3<T>>) {
        let mut rate = added_rad_s.unwrap_or(Vec3::zeros());
        for i in 0..3 {
            for k in 0..3 {
                rate[i] += transition.rate[(i, k)] * self.state[k];
            }
            for k in 0..6 {
                rate[i] += transition.inertia[(i, k)] * self.state[3 + k];
            }
        }
        for i in 0..3 {
            self.state[i] = rate[i];
        }
    }

    /// `h Γ` of a combination of the states.
    fn along(&self, h: &[T; 9]) -> T {
        let mut sum = T::zero();
        for i in 0..9 {
            sum += h[i] * self.state[i];
        }
        sum
    }

    /// g of one axis, rad/s.
    #[inline]
    fn innovation(&self, axis: usize) -> T {
        self.state[axis] + self.reading[axis]
    }
}

const fn zero_vector<T: Real>() -> Vec3<T> {
    Vec3::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; 3]]))
}

/// Unit vector of an axis; zero beyond the third.
fn axis_vector<T: Real>(axis: u8) -> Vec3<T> {
    Vec3::from_fn(|i, _| if i == usize::from(axis) { T::one() } else { T::zero() })
}

/// Momentum of one wheel about its own axis, N m s; zero beyond the last.
fn momentum_of<T: Real, const W: usize>(momenta: &Momenta<T, W>, wheel: usize) -> T {
    momenta.as_slice().get(wheel).copied().unwrap_or(T::zero())
}

/// Columns of up to P parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Considered<T: Real, const P: usize> {
    columns: [Column<T>; P],
    /// The rate has been taken from the last reading: the part of a time offset in it, `ω̇ δ`, follows with the
    /// acceleration over the next interval.
    is_reading: bool,
    /// Known time offset, s.
    delay_s: T,
    /// Turn of all sensors as one about each axis, one sigma, rad.
    mount_rad: [T; 3],
}

crate::persist!([T: Real, const P: usize] Considered<T, P> { columns, is_reading; unchanged delay_s, mount_rad });

impl<T: Real, const P: usize> Considered<T, P> {
    /// Hardware that is known exactly: a constant, built in its place and not on the stack.
    pub const NOTHING: Self = Self {
        columns: [Column::UNUSED; P],
        is_reading: false,
        delay_s: T::ZERO,
        mount_rad: [T::ZERO; 3],
    };

    /// Columns of all parameters with a sigma above zero, before any sample.
    ///
    /// # Errors
    /// A sigma out of its range; more parameters than P. The columns are unchanged then.
    #[inline(never)]
    pub fn set<const W: usize>(
        &mut self,
        (hardware, disturbance): (&Hardware<T, W>, &Disturbance<T>),
        wheels: &WheelArray<T, W>,
    ) -> Result<(), ConfigError> {
        hardware.validate()?;
        disturbance.validate()?;
        let stated = || {
            let all = hardware.parameters().chain(disturbance.parameters());
            all.filter(|(_, sigma)| *sigma > T::zero())
        };
        if stated().count() > P {
            return Err(ConfigError { field: "hardware", reason: Invalid::NoRoom });
        }
        let mut stated = stated();
        for column in &mut self.columns {
            *column = match stated.next() {
                Some((parameter, sigma)) => Column::of(parameter, sigma, wheels),
                None => Column::UNUSED,
            };
        }
        self.is_reading = false;
        (self.delay_s, self.mount_rad) = (hardware.delay_s, hardware.mount_rad);
        Ok(())
    }

    /// Known time offset that is to be corrected, s; `None` where it is zero.
    pub fn delay_s(&self) -> Option<T> {
        (P > 0 && self.delay_s != T::zero()).then_some(self.delay_s)
    }

    /// True where the covariance is that of the noise.
    pub fn is_ideal(&self) -> bool {
        self.is_empty() && self.mount_rad == [T::zero(); 3]
    }

    /// True without any column.
    fn is_empty(&self) -> bool {
        self.active().next().is_none()
    }

    fn active(&self) -> impl Iterator<Item = &Column<T>> {
        self.columns.iter().take_while(|column| column.parameter.is_some())
    }

    fn active_mut(&mut self) -> impl Iterator<Item = &mut Column<T>> {
        self.columns.iter_mut().take_while(|column| column.parameter.is_some())
    }

    /// Start from a state that does not depend on the parameters.
    pub fn restart(&mut self) {
        for column in self.active_mut() {
            column.state = [T::zero(); 9];
        }
    }

    /// Start of the rate, with these momenta of the wheels, N m s. From a reading, rad/s, its rows of Γ become
    /// `−∂h/∂p`; otherwise zero.
    pub fn restart_rate<const W: usize>(
        &mut self,
        reading_rad_s: Option<&Vec3<T>>,
        momenta: &Momenta<T, W>,
    ) {
        let none = Vec3::zeros();
        self.is_reading = reading_rad_s.is_some();
        for column in self.active_mut() {
            column.reading = none;
            column.set_reading(reading_rad_s.unwrap_or(&none), &none);
            for i in 0..3 {
                column.state[i] = -column.reading[i];
            }
            column.momentum = column.wheel().map_or(T::zero(), |wheel| momentum_of(momenta, wheel));
        }
    }

    /// Common relative error of all elements by the parameters that scale momentum or torque, one sigma: root sum of
    /// squares, as for wheels or a torque that set the scale alone.
    pub fn scale_error(&self) -> T {
        let mut square = T::zero();
        for column in self.active() {
            let scales = matches!(
                column.parameter,
                Some(
                    Parameter::GyroScale(_)
                        | Parameter::WheelInertia(_)
                        | Parameter::CommonWheelInertia
                        | Parameter::TorqueScale
                )
            );
            if scales {
                square += column.sigma * column.sigma;
            }
        }
        square.sqrt()
    }

    /// Rate error of a reading that the parameters explain, one sigma, rad/s, for an integral over `duration_s` (s)
    /// up to this sample, and a body of this mean moment `J̄`, kg m²:
    ///
    /// | parameter | error |
    /// |---|---|
    /// | gyro scale and axes, bias, time offset | `σ abs(ω)`, `σ`, `σ abs(ω)` for a motion of 1 rad/s |
    /// | wheels | `σ abs(h) / J̄` |
    /// | torque | `σ abs(τ) t / J̄`, `σ t / J̄` |
    pub fn rate_error_rad_s<const W: usize>(
        &self,
        sample: &Sample<T, W>,
        wheels: &WheelArray<T, W>,
        (mean_moment_kg_m2, duration_s): (T, T),
    ) -> T {
        let momenta = wheels.momenta_n_m_s(&sample.wheel_speed_rad_s);
        let (rate, torque) = (norm(&sample.rate_rad_s), norm(&sample.torque_n_m));
        let by_moment = T::one() / mean_moment_kg_m2;
        let mut square = T::zero();
        for column in self.active() {
            let size = match column.parameter {
                None
                | Some(
                    Parameter::Mount(_)
                    | Parameter::ModalInertia(..)
                    | Parameter::ModeFrequency(_)
                    | Parameter::ModeDamping(_),
                ) => T::zero(),
                Some(Parameter::GyroBias(_)) => T::one(),
                Some(Parameter::GyroScale(_) | Parameter::GyroAxes(..) | Parameter::Delay) => rate,
                Some(Parameter::WheelInertia(wheel) | Parameter::WheelAxis(wheel, _)) => {
                    momentum_of(&momenta, usize::from(wheel)) * by_moment
                }
                Some(Parameter::CommonWheelInertia) => norm(&(wheels.axes() * momenta)) * by_moment,
                Some(Parameter::TorqueScale) => torque * duration_s * by_moment,
                Some(Parameter::DisturbanceTorque(_)) => duration_s * by_moment,
            };
            square += size * size * column.sigma * column.sigma;
        }
        square.sqrt()
    }

    /// Columns over an interval that ends with these momenta of the wheels, N m s, and `∂h/∂p` at its end.
    #[inline(never)]
    pub fn predict<const W: usize>(
        &mut self,
        prediction: &Prediction<'_, T>,
        momenta: &Momenta<T, W>,
    ) {
        let Prediction { body, rates_rad_s: [start, end], interval, transition } = prediction;
        let half = T::lit(0.5);
        let by_impulse = (Mat::identity() + transition.rate) * body.inverse() * half;
        let rate = (start + end) * half;
        let acceleration = acceleration_at_end(body, end, interval);
        if core::mem::take(&mut self.is_reading) {
            self.start_of_delay(&((end - start) * (T::one() / interval.duration_s)));
        }
        for column in self.active_mut() {
            let added = column.impulse(&rate, interval, momenta).map(|q| by_impulse * q);
            column.propagate(transition, added);
            column.set_reading(end, &acceleration);
        }
    }

    /// Adds the error of a start from a late reading at this acceleration, rad/s².
    fn start_of_delay(&mut self, acceleration_rad_s2: &Vec3<T>) {
        for column in self.active_mut().filter(|c| c.parameter == Some(Parameter::Delay)) {
            for axis in 0..3 {
                column.state[axis] += acceleration_rad_s2[axis] * column.sigma;
            }
        }
    }

    /// Variance of an innovation on each axis by the parameters, `Σ σ_p² g²`, rad²/s².
    #[inline(never)]
    pub fn innovation_variance(&self) -> Vec3<T> {
        let mut variance = Vec3::zeros();
        for column in self.active() {
            for axis in 0..3 {
                let g = column.innovation(axis);
                variance[axis] += g * g;
            }
        }
        variance
    }

    /// Correction of the columns by the innovation of one axis. Returns the gain; `None` without parameters, where it is
    /// that of the ideal filter.
    #[inline(never)]
    pub fn correct(&mut self, ideal: &Gain<'_, T>) -> Option<[T; 9]> {
        let axis = ideal.axis;
        if self.is_empty() || axis >= 3 {
            return None;
        }
        let mut sum = ideal.gain.map(|k| k * ideal.variance);
        let mut variance = ideal.variance;
        for column in self.active() {
            let g = column.innovation(axis);
            variance += g * g;
            for i in 0..9 {
                sum[i] += column.state[i] * g;
            }
        }
        let scale = T::one() / variance;
        let gain = sum.map(|x| x * scale);
        for column in self.active_mut() {
            let g = column.innovation(axis);
            for i in 0..9 {
                column.state[i] -= gain[i] * g;
            }
        }
        Some(gain)
    }

    /// As [`correct`](Self::correct), by the measurement of a combination h of the inertia with the columns `h Γ₀` of
    /// its own: `g = h Γ − h Γ₀`, kg m².
    #[inline(never)]
    pub fn correct_along(
        &mut self,
        h: &[T; 9],
        of_measured: &[T; P],
        (ideal, ideal_variance): (&[T; 9], T),
    ) -> Option<[T; 9]> {
        if self.is_empty() {
            return None;
        }
        let mut sum = ideal.map(|k| k * ideal_variance);
        let mut variance = ideal_variance;
        for (column, of_measured) in self.active().zip(of_measured) {
            let g = column.along(h) - *of_measured;
            variance += g * g;
            for i in 0..9 {
                sum[i] += column.state[i] * g;
            }
        }
        let scale = T::one() / variance;
        let gain = sum.map(|x| x * scale);
        for (column, of_measured) in self.active_mut().zip(of_measured) {
            let g = column.along(h) - *of_measured;
            for i in 0..9 {
                column.state[i] -= gain[i] * g;
            }
        }
        Some(gain)
    }

    /// Columns of the inertia, kg m²; zeros in unused places.
    pub fn of_inertia(&self) -> [[T; 6]; P] {
        core::array::from_fn(|place| {
            let [_, _, _, inertia @ ..] = self.columns[place].state;
            inertia
        })
    }

    /// True where all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.active().all(|column| {
            let mut sum = T::zero();
            column.state.iter().for_each(|x| sum += *x);
            sum.is_finite()
        })
    }

    /// Adds the covariance of the six elements by the parameters, kg² m⁴.
    pub fn add_to(&self, covariance: &mut Mat<T, 6, 6>, inertia: &Inertia<T>) {
        self.each(inertia, &mut |finding| {
            let effect = finding.effect_kg_m2;
            for i in 0..6 {
                for k in 0..6 {
                    covariance[(i, k)] += effect[i] * effect[k];
                }
            }
        });
    }

    /// Calls `visit` with each parameter: value zero, the stated sigma, and its effect on this inertia.
    pub fn each(&self, inertia: &Inertia<T>, visit: &mut dyn FnMut(Finding<T>)) {
        if P == 0 {
            return;
        }
        let finding = |parameter, sigma, effect_kg_m2| Finding {
            parameter,
            value: T::zero(),
            sigma,
            stated: sigma,
            effect_kg_m2,
        };
        for (axis, sigma) in (0u8..).zip(self.mount_rad) {
            if sigma > T::zero() {
                let effect = turned_by(inertia, usize::from(axis)).map(|by| by * sigma);
                visit(finding(Parameter::Mount(axis), sigma, effect));
            }
        }
        for column in self.active() {
            let Some(parameter) = column.parameter else { return };
            let [_, _, _, effect @ ..] = column.state;
            visit(finding(parameter, column.sigma, effect));
        }
    }
}

/// Acceleration at the end of an interval, rad/s²: the gyrostat equation, with the derivative of the parabola
/// through the three momenta of the wheels, `ḣ_w = (h₀ − 4 h_½ + 3 h₁) / Δt`.
fn acceleration_at_end<T: Real>(
    body: &Gyrostat<T>,
    rate_rad_s: &Vec3<T>,
    interval: &Interval<T>,
) -> Vec3<T> {
    let [h0, middle, h1] =
        [&interval.start, &interval.middle, &interval.end].map(|drive| drive.wheel_momentum_n_m_s);
    let slope = (h0 - middle * T::lit(4.0) + h1 * T::lit(3.0)) * (T::one() / interval.duration_s);
    body.acceleration_rad_s2(rate_rad_s, &h1, &(interval.end.torque_n_m - slope))
}
