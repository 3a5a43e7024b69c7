//! `SCENARIO.toml`: a spacecraft and its flight, for the simulator.
//!
//! ```toml
//! name = "stsat3-spin-up"
//! duration_s = 600.0
//! [spacecraft]
//! inertia_kg_m2 = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016]   # wheels included and locked
//! [[wheel]]                                                    # none is valid
//! axis = [1.0, 0.0, 0.0]
//! spin_inertia_kg_m2 = 4.113e-4
//! torque = { kind = "constant", value_n_m = 1e-3 }             # of the motor
//! [torque]                                                     # external
//! kind = "constant"
//! value_n_m = [1e-3, 1e-3, -2e-3]
//! [gyro]
//! rate_hz = 10.0
//! noise_rad_s = 1.8151e-4                                      # one sigma, white, per sample
//! ```
//!
//! [`keys`](super::keys) lists every key. Each table has a file of its own with its type, keys and
//! checks; `file` combines them.

mod built_in;
pub mod change;
mod control;
mod definition;
pub mod dispersion;
mod disturbance;
mod draw;
mod drawn;
pub mod fault;
mod file;
mod gyro;
pub mod hardware;
mod limits;
mod load;
mod problem;
pub mod profile;
mod random_draw;
pub mod random_spacecraft;
mod spacecraft;
mod thruster;
mod wheel;

pub use built_in::{DEFAULT_SCENARIO, FAULTS_SCENARIO, built_in_names, built_in_summary};
pub use change::Changes;
pub use control::Control;
pub use definition::Scenario;
pub use dispersion::Dispersion;
pub use fault::Fault;
pub use file::TABLES;
pub use gyro::SimulatedGyro;
pub use hardware::TrueHardware;
pub use limits::{MAX_RATE_HZ, MAX_SAMPLES};
pub use load::{SourceFile, sources};
pub use problem::ScenarioProblem;
pub use profile::{ExternalTorque, Sine, TorqueProfile};
pub use random_spacecraft::RandomSpacecraft;
pub use spacecraft::Spacecraft;
pub use thruster::SimulatedThruster;
pub use wheel::SimulatedWheel;
