//! Manoeuvre: torques of the wheels from a table, within limits, with a known path to rest.
//!
//! ```text
//!  Table (coefficients, limits) ─► Player ─► torque of each wheel, N m
//!  rate, wheel speeds, time ─────►   │
//!                                    └─► Progress: state, reason, peaks
//! ```
//!
//! Input: a [`Table`] of B-spline coefficients, and rate and wheel speeds once per sample. Output: the torque of each
//! motor on its wheel until the next sample. No allocation; the time of a step is bounded.
//!
//! | state | torque | next state |
//! |---|---|---|
//! | idle | zero | waiting, by [`Player::start`] |
//! | waiting for the start time | zero | flying; ended, where speeds or rate are unknown or outside the limits |
//! | flying | spline of the table | resting, at the end of the table or at an [`Abort`] |
//! | resting | towards the speeds at the start | ended, with the wheels at these speeds, or after [`Table::rest_s`] |
//! | ended | zero | waiting |
//!
//! Rate and excursion are measured relative to the mean rate while waiting: the bias of the gyro has no part in them. With
//! noise σ per sample and n samples of waiting, the excursion of T seconds is uncertain by `σ T / √n` on each axis.
//!
//! An abort and a completed manoeuvre take the same path: [`State::Resting`]. Its law for wheel i is
//!
//! ```text
//! uᵢ = Iₛᵢ (Ω₀ᵢ − Ωᵢ) / τ,   |uᵢ| ≤ uᵢ,max,   τ = 0.5 s
//! ```
//!
//! with spin inertia `Iₛ`, kg m², speed `Ω` relative to the body and speed at the start `Ω₀`, rad/s. It needs no gyro. A
//! wheel without a reading is propagated by its torque. Internal torques leave the total momentum as it is: with the
//! wheels at the speeds of the start, the rate of a body without external torque is of the magnitude of the start.

mod player;
mod table;
#[cfg(test)]
mod tests;

pub use player::{Abort, LONGEST_GAP_US, MOST_REJECTED, Player, Progress, Reading, State};
pub use table::{Limits, MOST_REPEATS, Table, TableError};
