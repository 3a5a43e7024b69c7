//! Physics shared by all estimators: a rigid body with reaction wheels.
//!
//! | module | content |
//! |---|---|
//! | [`wheels`] | momentum of the wheels from their speeds |
//! | [`gyrostat`] | equation of motion, Jacobians |
//! | [`interval`] | torque and wheel momentum between two samples |
//! | [`step`] | integration over an interval, transition matrices |
//!
//! Assumptions: the body is rigid; wheels are balanced, axisymmetric and fixed in the body; torque
//! and momentum are given in body axes about the centre of mass.

pub mod gyrostat;
pub mod interval;
pub mod step;
pub mod wheels;
