//! Limits of a manoeuvre, and the share of each that a motion uses.
//!
//! A limit is a function `c ≤ 0` of the motion at one instant, `c = (x/x_max)² − 1` but for cones, so that
//! it is smooth where `x` changes its sign:
//!
//! | limit | quantity |
//! |---|---|
//! | torque | motor torque of a wheel, N m |
//! | speed | speed of a wheel relative to the body, rad/s |
//! | excursion | `sin(θ/2)` of the rotation from the attitude at the start |
//! | rate | body rate, rad/s |
//! | cone | cosine of the angle from boresight to direction, `c = (cos θ − cos α) / (1 − cos α)` |
//! | return | `sin(θ/2)` at the end |
//! | duty | level of a pair of thrusters before it is rounded to pulses: the share of the time on |

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::command::Command;
use super::motion::{Output, Seed};
use super::problem::Problem;

/// A cone about an inertial direction that a boresight stays out of.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepOut {
    /// Direction fixed in the body, unit length.
    pub boresight: Vector3<f64>,
    /// Direction in inertial axes, unit length.
    pub direction: Vector3<f64>,
    /// Half angle of the cone, rad.
    pub half_angle_rad: f64,
}

impl KeepOut {
    /// Angle from the boresight to the direction in this attitude, rad.
    pub fn angle_rad(&self, attitude: &UnitQuaternion<f64>) -> f64 {
        (attitude * self.boresight).angle(&self.direction)
    }
}

/// Limits of the motion. Those of the wheels are in the craft file.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Largest rotation from the attitude at the start, rad.
    pub excursion_rad: f64,
    /// Largest body rate, rad/s; none if unlimited.
    pub rate_rad_s: Option<f64>,
    /// Share of the largest torque of each wheel that may be used.
    pub torque_share: f64,
    /// Share of the largest speed of each wheel that may be used.
    pub momentum_share: f64,
    /// Largest rotation left at the end, rad.
    pub return_rad: f64,
    /// Forbidden cones.
    pub keep_out: Vec<KeepOut>,
}

/// Kind of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Torque of a wheel.
    Torque,
    /// Speed, hence momentum, of a wheel.
    Momentum,
    /// Rotation from the attitude at the start.
    Excursion,
    /// Body rate.
    Rate,
    /// A keep-out cone.
    Cone,
    /// Rotation left at the end.
    Return,
    /// Share of the time that a thruster is on.
    Duty,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Torque,
        Self::Momentum,
        Self::Excursion,
        Self::Rate,
        Self::Cone,
        Self::Return,
        Self::Duty,
    ];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Torque => "torque",
            Self::Momentum => "momentum",
            Self::Excursion => "excursion",
            Self::Rate => "rate",
            Self::Cone => "cone",
            Self::Return => "return",
            Self::Duty => "duty",
        }
    }
}

/// One limit at one instant.
pub(super) struct Value {
    pub kind: Kind,
    pub c: f64,
    /// Derivative by the quantities of the instant, to be scaled by the derivative by `c`.
    derivative: Derivative,
}

enum Derivative {
    /// Torque of a wheel, level of a pair.
    Channel {
        channel: usize,
        by: f64,
    },
    Speed {
        wheel: usize,
        by: f64,
    },
    Attitude([f64; 4]),
    Rate(Vector3<f64>),
}

impl Value {
    /// Adds the derivatives of `weight · c`.
    pub(super) fn pull(&self, problem: &Problem, weight: f64, seed: &mut Seed) {
        match &self.derivative {
            Derivative::Channel { channel, by } => seed.torque[*channel] += weight * by,
            Derivative::Speed { wheel, by } => {
                // Ω = h/Iₛ − a · ω.
                let own = &problem.wheels[*wheel];
                seed.momentum[*wheel] += weight * by / own.spin_inertia_kg_m2;
                seed.rate -= own.axis * (weight * by);
            }
            Derivative::Attitude(by) => {
                for i in 0..4 {
                    seed.attitude[i] += weight * by[i];
                }
            }
            Derivative::Rate(by) => seed.rate += by * weight,
        }
    }
}

/// Limits at one instant, in a fixed order.
pub(super) fn values(
    problem: &Problem,
    command: &Command,
    step: usize,
    output: &Output,
) -> Vec<Value> {
    let limits = &problem.limits;
    let mut all = Vec::with_capacity(2 * problem.channels() + 3 + limits.keep_out.len());
    let square =
        |kind, x: f64, limit: f64| (kind, (x / limit).powi(2) - 1.0, 2.0 * x / (limit * limit));
    for (i, wheel) in problem.wheels.iter().enumerate() {
        let (kind, c, by) = square(Kind::Torque, command.torque(step)[i], wheel.max_torque_n_m);
        all.push(Value { kind, c, derivative: Derivative::Channel { channel: i, by } });
        let momentum = command.momentum(2 * step)[i];
        let speed = momentum / wheel.spin_inertia_kg_m2 - wheel.axis.dot(&output.rate);
        let (kind, c, by) = square(Kind::Momentum, speed, wheel.max_speed_rad_s);
        all.push(Value { kind, c, derivative: Derivative::Speed { wheel: i, by } });
    }
    for channel in problem.wheels.len()..problem.channels() {
        let (kind, c, by) = square(Kind::Duty, command.torque(step)[channel], 1.0);
        all.push(Value { kind, c, derivative: Derivative::Channel { channel, by } });
    }
    all.push(rotation(problem, output, Kind::Excursion, limits.excursion_rad));
    if let Some(limit) = limits.rate_rad_s {
        let c = output.rate.norm_squared() / (limit * limit) - 1.0;
        let by = output.rate * (2.0 / (limit * limit));
        all.push(Value { kind: Kind::Rate, c, derivative: Derivative::Rate(by) });
    }
    all.extend(limits.keep_out.iter().map(|cone| of_cone(cone, output)));
    if step == command.steps {
        all.push(rotation(problem, output, Kind::Return, limits.return_rad));
    }
    all
}

/// Rotation from the attitude at the start, by the vector part `v` of `q₀* ⊗ q`.
fn rotation(problem: &Problem, output: &Output, kind: Kind, limit_rad: f64) -> Value {
    let [w, x, y, z] = output.attitude;
    let start = problem.attitude.quaternion();
    let v = (start.conjugate() * Quaternion::new(w, x, y, z)).imag();
    let limit = (limit_rad / 2.0).sin().powi(2);
    // v is linear in q, so that ∂|v|²/∂q = 2 q₀ ⊗ (0, v).
    let by = start * Quaternion::from_imag(v * (2.0 / limit));
    let by = [by.w, by.i, by.j, by.k];
    Value { kind, c: v.norm_squared() / limit - 1.0, derivative: Derivative::Attitude(by) }
}

/// Cosine of the angle between boresight `b` and direction `d`: `d · (q b q*)`, quadratic in `q`.
fn of_cone(cone: &KeepOut, output: &Output) -> Value {
    let [w, x, y, z] = output.attitude;
    let q = Quaternion::new(w, x, y, z);
    let b = Quaternion::from_imag(cone.boresight);
    let d = Quaternion::from_imag(cone.direction);
    let cosine = (q * b * q.conjugate()).imag().dot(&cone.direction);
    let scale = 1.0 / (1.0 - cone.half_angle_rad.cos());
    // d · (q b q*) = −Re(d q b q*); its derivative by q is −2 d ⊗ q ⊗ b, since d, b are imaginary.
    let by = (d * q * b) * (-2.0 * scale);
    Value {
        kind: Kind::Cone,
        c: (cosine - cone.half_angle_rad.cos()) * scale,
        derivative: Derivative::Attitude([by.w, by.i, by.j, by.k]),
    }
}
