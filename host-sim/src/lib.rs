//! Simulator of a spacecraft on a PC, around the estimators that fly.
//!
//! ```text
//!  SCENARIO.toml ─► truth ──► sensor ──► simulation ─┐
//!  (input)          physics   gyro       a log       ├─► estimation ──► report
//!  LOG.csv, CRAFT.toml ──────────────────────────────┘   fsw-core       table, JSON, plots
//!  (input)           └─ truth::bound: Cramér-Rao bound
//! ```
//!
//! | module | content |
//! |---|---|
//! | [`input`] | scenario and craft files, recorded logs |
//! | [`truth`] | motion of the spacecraft, and its Cramér-Rao bound |
//! | [`sensor`] | gyro and wheel encoders, as rates and at register level |
//! | [`simulation`] | log of a simulated flight |
//! | [`estimation`] | any estimator of the flight core over a log |
//! | [`campaign`] | Monte Carlo: simulation and estimation repeated, statistics of the errors |
//! | [`fault`] | faults between sensors and estimator, and their matrix |
//! | [`diagnosis`] | single causes that explain residuals, ranked |
//! | [`manoeuvre`] | design of a manoeuvre within limits |
//! | [`papers`] | published results reproduced |
//! | [`pil`] | processor in the loop: the firmware in QEMU with the models of `sensor` |
//! | [`ground`] | telemetry packets from the bytes of a serial line |
//! | [`report`] | tables, JSON, CSV, plots |
//! | [`cli`] | command line, one file per verb |
//!
//! All quantities are `f64` in SI units, body axes, until a sample enters the flight core.

pub mod docs;

pub mod campaign;
pub mod cli;
pub mod diagnosis;
pub mod estimation;
pub mod fault;
pub mod ground;
pub mod input;
pub mod manoeuvre;
pub mod papers;
#[cfg(unix)]
pub mod pil;
pub mod report;
pub mod sensor;
pub mod simulation;
pub mod truth;
