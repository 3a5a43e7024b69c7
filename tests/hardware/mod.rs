//! The catalogue of imperfections: one at a time, stated at the level flown, and all at once.
//!
//! ```text
//!  catalogue::all ─► Case: a scenario with one imperfection ─► host_sim::campaign ─► Cell ─► matrix, limits
//! ```
//!
//! An imperfection with a key of one sigma is drawn from it by the seed of a flight. Others are fixed, and what
//! a data sheet says of them is stated: a filter's lag as a time offset, an orbit's torque as a disturbance.

pub mod catalogue;
pub mod cell;
