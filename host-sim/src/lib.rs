//! The simulator: a spacecraft on a PC around the same core that flies.
//!
//! ```text
//!  SCENARIO.toml ─► truth ──► sensor ──► simulation ─┐
//!  (input)          physics   gyro       a log       ├─► estimation ──► report
//!  LOG.csv, CRAFT.toml ──────────────────────────────┘   fsw-core       table, JSON, plots
//!  (input)           └─ truth::bound: what nobody can beat
//! ```
//!
//! `campaign` goes from simulation to estimation many times, and to statistics of the results;
//! `papers` does so with the published systems, and sets the results beside what was printed.
//!
//! `ground` is the other end of the flight computer's serial line: telemetry from bytes, and what is
//! missing of it.
//! `pil` flies the firmware itself, in QEMU, with the sensors of `sensor` at its wires.
//!
//! `cli` has a file for each verb, which strings these together.

pub mod docs;

pub mod campaign;
pub mod cli;
pub mod estimation;
pub mod ground;
pub mod input;
pub mod papers;
#[cfg(unix)]
pub mod pil;
pub mod recording;
pub mod report;
pub mod sensor;
pub mod simulation;
pub mod truth;
