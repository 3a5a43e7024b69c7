//! What the sensors make of the truth, and what a log tells of its sensor.

pub mod gyro;
pub mod noise;
