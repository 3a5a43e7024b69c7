//! What really happens: the spacecraft as physics, integrated in double precision by an adaptive
//! solver that shares nothing with the flight core, and the bound that this motion sets to any
//! estimator.

pub mod bound;
pub mod controller;
pub mod flight;
pub mod integrate;
pub mod spacecraft;
pub mod unmodelled;

pub use bound::{Bound, Unknowns};
pub use flight::{Flight, Instant};
pub use integrate::IntegrationFailed;
pub use unmodelled::TorqueEffect;
