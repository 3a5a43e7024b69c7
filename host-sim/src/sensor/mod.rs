//! Sensor models: readings from the true motion.
//!
//! | module | in | out |
//! |---|---|---|
//! | [`gyro`] | body rate, rad/s | body rate with noise, bias, quantisation and range |
//! | [`bmi088`] | body rate, rad/s | registers of the chip on SPI or I²C |
//! | [`encoder`] | wheel speeds, rad/s | edges of the encoders, and a capture timer |
//!
//! The last two are the hardware that the flight drivers run against.

pub mod bmi088;
pub mod encoder;
pub mod gyro;
