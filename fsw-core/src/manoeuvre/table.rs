//! Table of a manoeuvre: cubic B-splines on equal knots, and the limits of the motion.

use crate::math::scalar::Real;
use core::fmt;

/// Most repeats of a pattern.
pub const MOST_REPEATS: u32 = 1_000;
/// Longest manoeuvre, µs: one hour, below 2³² µs, so that a step divides in 32 bits.
const LONGEST_US: u64 = 3_600_000_000;
/// Shortest time between knots, µs: 10 ms, a sample at 100 Hz.
const SHORTEST_KNOT_US: u32 = 10_000;
/// Largest torque limit, N m, above the wheels of small satellites.
const MOST_TORQUE_N_M: f64 = 100.0;
/// Largest speed limit, rad/s: 95,000 rpm.
const MOST_SPEED_RAD_S: f64 = 1.0e4;
/// Largest rate limit, rad/s.
const MOST_RATE_RAD_S: f64 = 10.0;
/// Largest excursion limit, rad: a quarter turn.
const MOST_EXCURSION_RAD: f64 = 1.571;
/// Allowance for rounding of a torque at its limit, share of the limit, in units of ε. Four products of coefficients up
/// to 3/2 of their spline round by at most 8 ε.
const ROUNDING: f64 = 16.0;

/// Limits of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<T: Real, const W: usize> {
    /// Largest torque of each motor, N m, 0 to 100; zero for a wheel that is not used.
    pub torque_n_m: [T; W],
    /// Largest speed of each wheel relative to the body, rad/s, up to 10⁴.
    pub speed_rad_s: [T; W],
    /// Largest body rate relative to the mean one while waiting, rad/s, up to 10.
    pub rate_rad_s: T,
    /// Largest rotation from the attitude at the start, rad, up to a quarter turn.
    pub excursion_rad: T,
}

/// Torque of `W` wheels over time, up to `N` coefficients each.
///
/// The torque of a wheel is `u(x) = Σ cⱼ B(x − j)` with time `x` in knots from the start of the pattern and the cardinal
/// cubic B-spline `B` with support `[0, 4)`, \[deBoor2001\] chapter IX. The pattern of `n` coefficients is `n + 3` knots
/// long: torque, slope and curvature are zero at both ends. Patterns follow one another [`repeats`](Self::repeats)
/// times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table<T: Real, const W: usize, const N: usize> {
    /// Time between knots, µs, from 10 ms.
    pub knot_us: u32,
    /// Number of times the pattern is flown, 1 to 1,000.
    pub repeats: u32,
    /// Coefficients of each wheel, 1 to `N`.
    pub splines: u32,
    /// Limits of the motion.
    pub limits: Limits<T, W>,
    /// Coefficients, N m, in the order of time.
    pub coefficients_n_m: [[T; N]; W],
}

crate::persist!([T: Real, const W: usize] Limits<T, W> {
    torque_n_m, speed_rad_s, rate_rad_s, excursion_rad
});
crate::persist!([T: Real, const W: usize, const N: usize] Table<T, W, N> {
    knot_us, repeats, splines, limits, coefficients_n_m
});

/// Reason for an invalid table. Wheels are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TableError {
    /// Time between knots below 10 ms.
    Knot,
    /// Number of coefficients zero, or above the capacity.
    Splines,
    /// Number of repeats outside 1 to 1,000.
    Repeats,
    /// Longer than an hour.
    Duration,
    /// Rate limit not in (0, 10] rad/s.
    RateLimit,
    /// Excursion limit not in (0, 1.571] rad.
    ExcursionLimit,
    /// Torque limit not in [0, 100] N m.
    TorqueLimit(u8),
    /// Speed limit not in (0, 10⁴] rad/s.
    SpeedLimit(u8),
    /// Torque for a place without a wheel.
    NoWheel(u8),
    /// Coefficient not finite.
    Coefficient(u8),
    /// Torque beyond its limit.
    Torque(u8),
}

impl TableError {
    /// Wheel of the error, from 1; zero for an error of the whole table.
    pub fn wheel(self) -> u8 {
        match self {
            Self::TorqueLimit(wheel)
            | Self::SpeedLimit(wheel)
            | Self::NoWheel(wheel)
            | Self::Coefficient(wheel)
            | Self::Torque(wheel) => wheel,
            _ => 0,
        }
    }
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            Self::Knot => "time between knots below 10 ms",
            Self::Splines => "number of coefficients zero or above the capacity",
            Self::Repeats => "number of repeats outside 1 to 1,000",
            Self::Duration => "longer than an hour",
            Self::RateLimit => "rate limit not in (0, 10] rad/s",
            Self::ExcursionLimit => "excursion limit not in (0, 1.571] rad",
            Self::TorqueLimit(_) => "torque limit not in [0, 100] N m",
            Self::SpeedLimit(_) => "speed limit not in (0, 10000] rad/s",
            Self::NoWheel(_) => "torque for a place without a wheel",
            Self::Coefficient(_) => "coefficient not finite",
            Self::Torque(_) => "torque beyond its limit",
        };
        match self.wheel() {
            0 => f.write_str(what),
            wheel => write!(f, "wheel {wheel}: {what}"),
        }
    }
}

impl core::error::Error for TableError {}

/// True if `x` is in `(0, most]`; NaN is not.
fn in_range<T: Real>(x: T, most: f64) -> bool {
    x > T::zero() && x <= T::lit(most)
}

impl<T: Real, const W: usize, const N: usize> Table<T, W, N> {
    /// A table without a manoeuvre. It is not valid.
    pub const EMPTY: Self = Self {
        knot_us: 0,
        repeats: 0,
        splines: 0,
        limits: Limits {
            torque_n_m: [T::ZERO; W],
            speed_rad_s: [T::ZERO; W],
            rate_rad_s: T::ZERO,
            excursion_rad: T::ZERO,
        },
        coefficients_n_m: [[T::ZERO; N]; W],
    };

    /// Validates the table for wheels of these spin inertias, kg m²; zero for a place without a wheel.
    ///
    /// Knots are equal, hence in order; the torque at both ends is zero by the splines. The largest torque is that of
    /// the spline, not of its coefficients.
    ///
    /// # Errors
    /// The first [`TableError`] in its order.
    pub fn validate(&self, spin_inertia_kg_m2: &[T; W]) -> Result<(), TableError> {
        if self.knot_us < SHORTEST_KNOT_US {
            return Err(TableError::Knot);
        }
        if self.splines == 0 || self.splines as usize > N {
            return Err(TableError::Splines);
        }
        if !(1..=MOST_REPEATS).contains(&self.repeats) {
            return Err(TableError::Repeats);
        }
        if self.duration_in_64_us() > LONGEST_US {
            return Err(TableError::Duration);
        }
        if !in_range(self.limits.rate_rad_s, MOST_RATE_RAD_S) {
            return Err(TableError::RateLimit);
        }
        if !in_range(self.limits.excursion_rad, MOST_EXCURSION_RAD) {
            return Err(TableError::ExcursionLimit);
        }
        let wheels = self.limits.torque_n_m.iter().zip(&self.limits.speed_rad_s);
        let wheels = wheels.zip(spin_inertia_kg_m2).zip(&self.coefficients_n_m);
        for (wheel, (((torque, speed), spin), coefficients)) in (1..).zip(wheels) {
            let used = coefficients.get(..self.splines as usize).unwrap_or_default();
            validate_wheel(wheel, *torque, *speed, *spin, used)?;
        }
        Ok(())
    }

    fn duration_in_64_us(&self) -> u64 {
        let knots = (u64::from(self.splines) + 3).saturating_mul(self.repeats.into());
        knots.saturating_mul(self.knot_us.into())
    }

    /// Duration of all repeats, µs. That of a valid table is at most an hour.
    pub fn duration_us(&self) -> u32 {
        u32::try_from(self.duration_in_64_us()).unwrap_or(u32::MAX)
    }

    /// Repeat, knot and share of the knot at a time since the start, µs.
    pub fn place(&self, time_us: u32) -> (u32, u32, T) {
        let pattern_us = self.splines.saturating_add(3).saturating_mul(self.knot_us).max(1);
        let (within_us, knot_us) = (time_us % pattern_us, self.knot_us.max(1));
        let share = T::count(within_us % knot_us) / T::count(knot_us);
        (time_us / pattern_us, within_us / knot_us, share)
    }

    /// Torque of each wheel at a time since the start, µs, N m; zero after the end.
    pub fn torque_n_m(&self, time_us: u32) -> [T; W] {
        if time_us >= self.duration_us() {
            return [T::zero(); W];
        }
        let (_, knot, x) = self.place(time_us);
        // [deBoor2001] chapter IX, uniform knots; x in [0, 1).
        let (x2, y) = (x * x, T::one() - x);
        let x3 = x2 * x;
        let sixth = T::lit(1.0 / 6.0);
        let basis = [
            y * y * y * sixth,
            T::lit(0.5) * x3 - x2 + T::lit(2.0 / 3.0),
            T::lit(0.5) * (x + x2 - x3) + sixth,
            x3 * sixth,
        ];
        let splines = self.splines as usize;
        self.coefficients_n_m.each_ref().map(|coefficients| {
            let used = coefficients.get(..splines).unwrap_or_default();
            let four = segment(used, knot as usize);
            four.iter().zip(&basis).fold(T::zero(), |sum, (c, b)| sum + *c * *b)
        })
    }

    /// Longest time to rest, s: from one speed limit to the other at the torque limit, a quarter of it for drag and motor
    /// constant, and ten time constants of the law of [`State::Resting`](super::State::Resting).
    pub fn rest_s(&self, spin_inertia_kg_m2: &[T; W]) -> T {
        let limits = self.limits.torque_n_m.iter().zip(&self.limits.speed_rad_s);
        let longest = limits.zip(spin_inertia_kg_m2).fold(T::zero(), |most, ((u, speed), spin)| {
            if *u > T::zero() { most.max(*speed * *spin / *u) } else { most }
        });
        T::lit(2.5) * longest + T::lit(10.0 * super::player::REST_S)
    }
}

/// The four coefficients that act from a knot to the next.
fn segment<T: Real>(coefficients: &[T], knot: usize) -> [T; 4] {
    core::array::from_fn(|i| {
        let spline = (knot + i).checked_sub(3);
        spline.and_then(|spline| coefficients.get(spline)).copied().unwrap_or(T::zero())
    })
}

fn validate_wheel<T: Real>(
    wheel: u8,
    torque_n_m: T,
    speed_rad_s: T,
    spin_inertia_kg_m2: T,
    coefficients: &[T],
) -> Result<(), TableError> {
    if !(torque_n_m >= T::zero() && torque_n_m <= T::lit(MOST_TORQUE_N_M)) {
        return Err(TableError::TorqueLimit(wheel));
    }
    let is_used = torque_n_m > T::zero() || coefficients.iter().any(|c| *c != T::zero());
    if is_used && !in_range(spin_inertia_kg_m2, f64::from(f32::MAX)) {
        return Err(TableError::NoWheel(wheel));
    }
    if is_used && !in_range(speed_rad_s, MOST_SPEED_RAD_S) {
        return Err(TableError::SpeedLimit(wheel));
    }
    if !coefficients.iter().all(|c| c.is_finite()) {
        return Err(TableError::Coefficient(wheel));
    }
    let most = torque_n_m * (T::one() + T::lit(ROUNDING) * T::EPSILON);
    let segments = 0..coefficients.len() + 3;
    let is_within =
        |knot: usize| largest(&segment(coefficients, knot)).is_some_and(|largest| largest <= most);
    if segments.clone().all(is_within) { Ok(()) } else { Err(TableError::Torque(wheel)) }
}

/// Largest magnitude of a segment, N m: at its ends, and where its slope `a₁ + 2 a₂ x + 3 a₃ x²` is zero. `None` where it
/// is not finite.
fn largest<T: Real>([c0, c1, c2, c3]: &[T; 4]) -> Option<T> {
    let (half, third, sixth) = (T::lit(0.5), T::lit(1.0 / 3.0), T::lit(1.0 / 6.0));
    let a0 = (*c0 + T::lit(4.0) * *c1 + *c2) * sixth;
    let a1 = (*c2 - *c0) * half;
    let a2 = (*c0 - *c1 - *c1 + *c2) * half;
    let a3 = (*c3 - *c0) * sixth + (*c1 - *c2) * half;
    let at = |x: T| a0 + x * (a1 + x * (a2 + x * a3));
    let mut most = a0.abs().max(at(T::one()).abs());
    let root = (a2 * a2 - T::lit(3.0) * a3 * a1).max(T::zero()).sqrt();
    let q = if a2 < T::zero() { root - a2 } else { -(a2 + root) };
    // An infinite or undefined root is outside.
    for x in [q / a3 * third, a1 / q] {
        if x > T::zero() && x < T::one() {
            most = most.max(at(x).abs());
        }
    }
    let sum = *c0 + *c1 + *c2 + *c3;
    (sum.is_finite() && most.is_finite()).then_some(most)
}
