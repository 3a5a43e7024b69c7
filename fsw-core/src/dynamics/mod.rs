//! Physics shared by all estimators: a rigid body with reaction wheels.
//!
//! | module | content |
//! |---|---|
//! | [`wheels`] | momentum of the wheels from their speeds |
//! | [`gyrostat`] | equation of motion, Jacobians |
//! | [`interval`] | torque and wheel momentum between two samples |
//! | [`step`] | integration over an interval, transition matrices |
//!
//! ```text
//!  wheel speeds ─► wheels ─► interval ─► step ─► rate at the next sample
//!  torque ──────────────────►    ▲        ▲
//!                      two samples        gyrostat: J, J⁻¹
//! ```
//!
//! # Assumptions
//!
//! * The body is rigid. Flexible appendages and slosh appear as an unmodelled torque.
//! * Wheels are balanced, axisymmetric and fixed in the body.
//! * Torque and momentum are given in body axes about the centre of mass.
//! * The centre of mass and the inertia are constant over an interval.
//!
//! # Validity
//!
//! A step may turn the body by up to half a radian ([`step::runge_kutta_4`]). At a rate of 1 rad/s
//! the sample period is therefore at most 0.5 s.

pub mod gyrostat;
pub mod interval;
pub mod step;
pub mod wheels;
