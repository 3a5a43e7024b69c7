//! `SCENARIO.toml`: a spacecraft and what happens to it, for the simulator.
//!
//! ```toml
//! name = "stsat3-spin-up"
//! duration_s = 600.0
//! [spacecraft]
//! inertia_kg_m2 = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016]   # wheels locked and included
//! rate_rad_s = [0.0, 0.0, 0.0]                                 # initial
//! attitude_deg = [0.0, 0.0, 0.0]                               # initial roll, pitch, yaw (3-2-1)
//! [[wheel]]                                                    # none is fine
//! axis = [1.0, 0.0, 0.0]
//! spin_inertia_kg_m2 = 4.113e-4
//! speed_rad_s = 0.0                                            # initial, relative to the body
//! torque = { kind = "constant", value_n_m = 1e-3 }             # optional: see `profile`
//! [torque]                                                     # external, body axes; optional
//! kind = "constant"
//! value_n_m = [1e-3, 1e-3, -2e-3]
//! [control]                                                    # optional: see `control`
//! natural_frequency_rad_s = 0.043
//! damping_ratio = 0.707
//! [gyro]
//! rate_hz = 10.0
//! noise_rad_s = 1.8151e-4                                      # one sigma, white, per sample
//! bias_rad_s = [0.0, 0.0, 0.0]                                 # optional, as all that follow
//! bias_walk_rad_s_sqrt_s = 0.0
//! quantum_rad_s = 0.0                                          # zero: none
//! range_rad_s = 4.36
//! [disturbance]                                                # optional, as each of its keys
//! torque = false                                               # solve for it
//! gyro_bias = false                                            # solve for it
//! torque_n_m = [0.0, 0.0, 0.0]                                 # the truth, untold to the estimator
//! [filter]                                                     # optional
//! rate_walk_rad_s_sqrt_s = 1.0e-6                              # process noise, where there is one
//! inertia_walk_kg_m2_sqrt_hour = 0.02                          # of each element: one sigma after an hour
//! [prior]                                                      # optional
//! inertia_kg_m2 = [25, 25, 25, 2, 2, 2]
//! sigma_kg_m2 = [30, 30, 30, 10, 10, 10]
//! ```
//!
//! How the inertia changes in flight: see [`change`]. What differs from run to run of a campaign: see
//! [`dispersion`], and [`random_spacecraft`] where each run has a spacecraft of its own.

mod built_in;
pub mod change;
mod control;
pub mod dispersion;
mod file;
mod profile;
mod profile_file;
pub mod random_spacecraft;

use std::path::Path;

use fsw_core::Inertia;
use nalgebra::{UnitQuaternion, Vector3};

use super::craft::{Craft, GyroData, InitialEstimate, Prior, SolveFor, Wheel};
use super::error::{InputError, Place, Problem};
use super::toml_source::TomlSource;

pub use built_in::{DEFAULT_SCENARIO, built_in_names};
pub use change::Changes;
pub use control::Control;
pub use dispersion::Dispersion;
pub use profile::{ExternalTorque, Sine, TorqueProfile};
pub use random_spacecraft::RandomSpacecraft;

/// Most samples a simulation may have: twelve days at 10 Hz, a gigabyte or so of memory.
pub const MAX_SAMPLES: f64 = 1e7;
/// Highest gyro rate, Hz. Samples are stamped to a microsecond, which is a tenth of a period here.
pub const MAX_RATE_HZ: f64 = 1e5;

/// A spacecraft and what happens to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// What reports call it.
    pub name: String,
    /// How long the simulation lasts, s.
    pub duration_s: f64,
    /// The body at the start.
    pub spacecraft: Spacecraft,
    /// How its inertia changes in flight.
    pub changes: Changes,
    /// The reaction wheels, in the order of the estimator's wheel speeds.
    pub wheels: Vec<SimulatedWheel>,
    /// External torque that is commanded, hence known to the estimator.
    pub torque: ExternalTorque,
    /// What the wheels' motors do besides their own torque profiles, if the loop is closed.
    pub control: Option<Control>,
    /// The gyro's properties.
    pub gyro: SimulatedGyro,
    /// True constant external torque the estimator is not told, body axes, N m.
    pub disturbance_torque_n_m: Vector3<f64>,
    /// What the estimator is asked for besides the inertia.
    pub solve_for: SolveFor,
    /// Inertia the estimator is told beforehand, if any.
    pub prior: Option<Prior>,
    /// Process noise of the rate that filters are told, (rad/s)/√s; each has its own if none.
    pub rate_walk_rad_s_sqrt_s: Option<f64>,
    /// Random walk of each element of the inertia that filters are told, kg m²/√h; none if none.
    pub inertia_walk_kg_m2_sqrt_hour: Option<f64>,
    /// What differs from run to run of a campaign.
    pub dispersion: Dispersion,
    /// Where the estimator of this run starts, once drawn: see [`Scenario::of_seed`].
    pub initial_estimate: Option<InitialEstimate>,
}

/// The true body.
#[derive(Clone, Debug, PartialEq)]
pub struct Spacecraft {
    /// `jxx jyy jzz jxy jxz jyz` about the centre of mass, wheels included and locked, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Initial rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Initial attitude: the rotation that takes body axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
}

/// A wheel, its initial speed and its motor.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedWheel {
    /// Axis and spin inertia, which the estimator is told.
    pub wheel: Wheel,
    /// Initial speed relative to the body, rad/s.
    pub speed_rad_s: f64,
    /// Torque of the motor on the wheel, about its axis, N m; the body feels the opposite. A
    /// controller's comes on top.
    pub torque: TorqueProfile,
}

/// The simulated gyro.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedGyro {
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// White noise of one sample, one sigma per axis, rad/s.
    pub noise_rad_s: f64,
    /// Bias at the start, body axes, rad/s.
    pub bias_rad_s: Vector3<f64>,
    /// Random walk of the bias: one sigma per axis after one second, rad/s/√s.
    pub bias_walk_rad_s_sqrt_s: f64,
    /// Least significant bit, rad/s; none if the output is continuous.
    pub quantum_rad_s: Option<f64>,
    /// Largest rate shown per axis, where the output saturates, rad/s; none if unlimited.
    pub range_rad_s: Option<f64>,
}

impl Scenario {
    /// Reads and checks a scenario: the file of that path if there is one or the name ends in
    /// `.toml`, else the built-in scenario of that name.
    pub fn load(name_or_path: &str) -> Result<Self, InputError> {
        let path = Path::new(name_or_path);
        if path.is_file() || path.extension().is_some_and(|extension| extension == "toml") {
            let folder = path.parent().unwrap_or(Path::new(""));
            return file::read(&TomlSource::read(path)?, folder);
        }
        match built_in::text(name_or_path) {
            Some(text) => Self::from_toml(name_or_path, text, Path::new("")),
            None => Err(InputError {
                place: Place { file: name_or_path.to_owned(), line: None },
                problem: Problem::UnknownScenario {
                    built_in: built_in_names().map(str::to_owned).collect(),
                },
            }),
        }
    }

    /// Reads and checks the text of a `SCENARIO.toml`; `file` is what errors call it, and `folder`
    /// is where the files it names are.
    pub fn from_toml(file: &str, text: &str, folder: &Path) -> Result<Self, InputError> {
        file::read(&TomlSource::new(file, text), folder)
    }

    /// What the estimator is told of this spacecraft: all but inertia, bias and disturbance.
    ///
    /// An initial estimate that a body can have takes the place of the prior.
    pub fn craft(&self) -> Craft {
        let drawn = self.initial_estimate.as_ref().map(|start| Prior {
            inertia_kg_m2: start.inertia_kg_m2,
            sigma_kg_m2: start.sigma_kg_m2,
        });
        let physical = drawn.filter(|start| Inertia::new(start.inertia_kg_m2).check().is_ok());
        Craft {
            wheels: self.wheels.iter().map(|simulated| simulated.wheel.clone()).collect(),
            gyro: GyroData {
                noise_rad_s: Some(self.gyro.noise_rad_s),
                range_rad_s: self.gyro.range_rad_s,
                quantum_rad_s: self.gyro.quantum_rad_s,
            },
            prior: physical.or_else(|| self.prior.clone()),
            rate_walk_rad_s_sqrt_s: self.rate_walk_rad_s_sqrt_s,
            inertia_walk_kg_m2_sqrt_hour: self.inertia_walk_kg_m2_sqrt_hour,
            is_torque_smooth: self.torque.is_smooth(),
            solve_for: self.solve_for,
            initial_estimate: self.initial_estimate.clone(),
        }
    }
}
