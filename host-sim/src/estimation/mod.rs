//! Estimation: any estimator of the flight core, in either precision, over a log.
//!
//! ```text
//! name: table of estimators ─┐
//! input::Craft ──────────────┴─► setup ──► system/…: configuration ──► adapter: AnyEstimator
//! input::log ──────────────────────────────────────────────────────► stream ──► EstimationResult
//! ```
//!
//! In: a [`Setup`] (estimator, precision, craft, gyro noise, sample period) and the rows of a log.
//! Out: the estimate after the last sample, the number of samples by outcome, and the events.
//!
//! Quantities are `f64` in SI units, body axes. A sample is rounded once to the chosen precision
//! when it enters the core.

mod adapter;
mod error;
mod events;
mod gyro_noise;
mod hardware;
mod health;
mod log_setup;
mod name;
mod setup;
mod stream;
mod system;
mod wheel_error;

pub use adapter::{Acceleration, AnyEstimator, any_estimator};
pub use error::SetUpError;
pub use events::Events;
pub use hardware::{key, kind_named, largest_systematic, name as parameter_name, squared_norm};
pub use health::{HealthChange, HealthHistory};
pub use name::{EstimatorName, Method, Precision, Properties};
pub use setup::Setup;
pub use stream::{EstimationResult, estimate_log, median_period_s};
pub use system::set_up;
pub use wheel_error::with_wheel_error;
