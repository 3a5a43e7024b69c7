//! `CRAFT.toml`: the spacecraft as known before its log is read.
//!
//! ```toml
//! [[wheel]]                           # one per reaction wheel, in the order of the log's columns
//! name = "x"                          # optional label
//! axis = [1.0, 0.0, 0.0]              # normalised on load
//! spin_inertia_kg_m2 = 1.691e-6
//! max_torque_n_m = 1e-3               # optional, as max_speed_rad_s: limits of a manoeuvre
//! [[thruster]]                        # optional: torque sources of a manoeuvre
//! torque_n_m = [0.02, 0.0, 0.0]
//! min_pulse_s = 0.05
//! [gyro]                              # optional, as is each of its keys
//! noise_rad_s = 1.0e-4                # one sigma, white, per sample
//! range_rad_s = 4.36                  # full scale
//! quantum_rad_s = 1.0e-5              # least significant bit
//! scale_sigma = 0.005                 # errors of the hardware, one sigma each: see `hardware`
//! axes_sigma_deg = 0.1
//! [wheels]
//! spin_inertia_sigma = 0.01
//! [prior]                             # optional
//! inertia_kg_m2 = [25, 25, 25, 2, 2, 2]
//! sigma_kg_m2 = [30, 30, 30, 10, 10, 10]
//! [filter]                            # optional, as is each of its keys
//! rate_walk_rad_s_sqrt_s = 1.0e-6     # process noise of the rate
//! inertia_walk_kg_m2_sqrt_hour = 0.02 # process noise of each inertia element
//! torque_is_smooth = true             # smooth torque between samples; else linear
//! [disturbance]                       # optional: further unknowns
//! torque = true
//! gyro_bias = false
//! [log]                               # optional: columns, units and clock of foreign logs
//! time = "timestamp"
//! time_unit = "us"
//! [log.gyro]
//! columns = ["gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"]
//! ```
//!
//! Each table has a file of its own: type, keys, reader and writer.

pub mod disturbance;
pub mod file;
pub mod filter;
pub mod gyro;
pub mod hardware;
pub mod log_format;
pub mod prior;
pub mod thruster;
pub mod wheel;

pub use disturbance::SolveFor;
pub use file::{Craft, InitialEstimate, TABLES};
pub use filter::Filter;
pub use gyro::GyroData;
pub use hardware::{Mode, StatedHardware};
pub use log_format::{LogFormat, SensorFormat, TimeFormat};
pub use prior::Prior;
pub use thruster::Thruster;
pub use wheel::{MAX_WHEELS, Wheel, WheelLimits};
