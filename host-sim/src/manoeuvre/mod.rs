//! Design of a manoeuvre for the estimation of the inertia, within limits of wheels and pointing.
//!
//! ```text
//! Scenario, Request ─► problem ─► samples of the prior, fixed manoeuvres ─► starts
//!   spline variables ─► command ─► motion (adjoint) ─► information ─► size of the covariance ─┐
//!                                     └─► limits ─────────────────────► augmented Lagrangian ◄┘
//!   L-BFGS, rounds ─► scale: largest factor within the limits at every extreme inertia ─► Design
//! ```
//!
//! The information of a motion is that of [`bound`](crate::truth::bound). Torque is a cubic spline; gradients
//! are exact derivatives of the integration by its adjoint. No limit is exceeded for any inertia of the prior
//! (see [`samples`]).

mod columns;
mod command;
mod design;
pub mod fixed;
mod information;
mod limits;
mod motion;
mod objective;
mod optimise;
mod problem;
mod pulses;
pub mod samples;
mod scale;
mod series;
mod subject;
#[cfg(test)]
mod tests;
mod trade;
mod upload;

pub use columns::Treatment;
pub use command::Table;
pub use design::{Design, Manoeuvre, Progress, design};
pub use information::Criterion;
pub use limits::{KeepOut, Kind as LimitKind, Limits};
pub use problem::{DesignError, Effort, Request};
pub use scale::MARGIN;
pub use series::{Accuracy, SeriesRow, accuracy, series};
pub(crate) use subject::stamp_s;
pub use subject::{SubjectError, flown, subject};
pub use trade::{Trade, TradeRow, trade};
pub use upload::{NotFlown, flight_table};
