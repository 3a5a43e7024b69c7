//! The Cramér-Rao bound of a flight, by variational equations along the true motion.
//!
//! For a given motion, noise and set of unknowns, the covariance of any unbiased estimate is at least
//!
//! ```text
//! C = (Σₖ Sₖᵀ R⁻¹ Sₖ)⁻¹,   Sₖ = ∂z(tₖ)/∂θ
//! ```
//!
//! with `z` the measured body rate, rad/s, `R` its noise covariance and `θ` the [`unknowns`]: initial
//! rate and inertia, and disturbance torque and gyro bias where they are estimated
//! (see [`sensitivities`] for `S`, [`information`] for the sum). Source: \[Kay1993\]
//! section 3.9, for Gaussian noise of known covariance.
//!
//! Assumptions:
//! - The wheel speeds are measured, hence known functions of time, in a closed loop too: the
//!   reaction of the controller to another inertia does not enter.
//! - After a sudden change of the inertia, the sum starts again: the bound is of the data after the
//!   last change, without knowledge from before.
//! - A drift of the inertia is known: the unknown is a constant offset of its course. No estimator
//!   has this knowledge, so that its error may exceed the bound by some factor. NEES is the measure
//!   in this case.
//!
//! [`hardware`] adds stated errors of gyro, wheels and torque: the bound with these considered, or solved
//! with their sigma as prior, and the effect of each. [`Bound::sigma_kg_m2`](information::Bound) remains
//! that of ideal hardware.
//!
//! [`torque_effect`] has the error that an unmodelled constant torque causes.

pub mod hardware;
pub mod information;
pub mod sensitivities;
pub mod torque_effect;
pub mod unknowns;
