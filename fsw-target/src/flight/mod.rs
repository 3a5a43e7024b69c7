//! The flight computer, in the order of a sample's path.
//!
//! 1. [`sensors`]: interface to sensors and actuators, implemented by drivers and their substitutes.
//! 2. [`flight_loop`]: one tick per gyro sample, from the sensors to the estimator.
//! 3. [`selected`]: the selected estimator; [`craft`]: the spacecraft that it is configured for;
//!    [`key`]: the key of telecommands; [`manoeuvre`]: torques of the wheels from an uploaded table; [`wheel_check`]: tachometers against commanded motor torques.
//! 4. [`computer`]: the loop of an image, with telemetry, telecommands and checkpoints.
//! 5. [`supervisor`]: permission to feed the watchdog.

pub mod computer;
pub mod craft;
pub mod flight_loop;
pub mod key;
pub mod manoeuvre;
pub mod selected;
pub mod sensors;
pub mod supervisor;
pub mod wheel_check;
