//! The flight computer: sensor traits, flight loop, selected estimator, telemetry and telecommand
//! handling, supervisor.

pub mod computer;
pub mod craft;
pub mod flight_loop;
pub mod selected;
pub mod sensors;
pub mod supervisor;
