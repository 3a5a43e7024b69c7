//! Benchmark of designed manoeuvres: three satellites within limits of excursion, momentum, duration and
//! prior, against the best fixed manoeuvre.
//!
//! ```text
//! Satellite + Case ─► Scenario, Request ─► host_sim::manoeuvre ─► Score
//! ```

pub mod case;
pub mod random;

pub use case::{Case, SATELLITES, Satellite, Score};
