//! The truth: a spacecraft as physics, and the bound that its motion sets to any estimator.
//!
//! ```text
//! Scenario ─► spacecraft + controller: ẏ = f(t, y) ─► integrate ─► flight: state at each gyro sample
//!                        │                                └─► trajectory: motion at any instant
//!                        └─► bound: sensitivities ─► information ─► Bound
//! ```
//!
//! In: a [`Scenario`](crate::input::Scenario). Out: a [`Flight`]. Double precision, adaptive step.
//! No code is shared with the flight core: equation of motion, regressor and integrator are
//! independent implementations.

pub mod bound;
pub mod controller;
pub mod environment;
mod flexible;
pub mod flight;
pub mod integrate;
pub mod spacecraft;
pub mod state;
#[cfg(test)]
mod torque_free;
pub mod trajectory;

pub use bound::hardware::{Effect, HardwareBound};
pub use bound::information::Bound;
pub use bound::torque_effect::TorqueEffect;
pub use bound::unknowns::Unknowns;
pub use flight::{Flight, Instant, torque_effect};
pub use integrate::IntegrationFailed;
pub use trajectory::Trajectory;
