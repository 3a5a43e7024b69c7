//! Sensor models: readings from the true motion.
//!
//! | module | in | out |
//! |---|---|---|
//! | [`gyro`] | body rate, rad/s | body rate with noise, bias, quantisation and range |
//! | [`rate_filter`] | motion between the samples | body rate with delay, low-pass filter and averaging |
//! | [`gyro_errors`] | body rate, rad/s | its axes, flicker, coloured noise, outliers |
//! | [`tachometer`] | wheel speeds, rad/s | wheel speeds by edges or mean, late, held, rounded |
//! | [`clock`] | time stamps | true times |
//! | [`bmi088`] | body rate, rad/s | registers of the chip on SPI or I²C |
//! | [`encoder`] | wheel speeds, rad/s | edges of the encoders, and a capture timer |
//!
//! The last two are the hardware that the flight drivers run against.

pub mod bmi088;
pub mod clock;
pub mod encoder;
pub mod gyro;
pub mod gyro_errors;
pub mod rate_filter;
pub mod tachometer;
