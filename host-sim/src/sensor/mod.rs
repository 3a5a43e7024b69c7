//! What the sensors make of the truth, and what a log tells of its sensor.
//!
//! [`gyro`] and [`noise`] speak of rates. [`bmi088`] and [`encoder`] are parts as a flight computer is
//! wired to them: registers on a bus, edges on a line.

pub mod bmi088;
pub mod encoder;
pub mod gyro;
