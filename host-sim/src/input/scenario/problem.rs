//! Faults that only a scenario can have.

use flight_input::ELEMENT_NAMES;
use flight_input::error::Problem;
use flight_input::words::{list, numbers};
use thiserror::Error;

/// Fault of a scenario.
#[derive(Debug, Error)]
pub enum ScenarioProblem {
    /// Neither a file nor a built-in scenario of this name.
    #[error(
        "neither a file nor a built-in scenario; give the path of a .toml file, or one of: {}",
        list(.built_in)
    )]
    UnknownScenario {
        /// The names of the built-in scenarios.
        built_in: Vec<String>,
    },

    /// A craft file in place of a scenario.
    #[error(
        "a craft file, not a scenario: a scenario also has `duration_s`, [spacecraft] and `gyro.rate_hz`; \
         `host-sim init DIR` writes an example of each, and `replay --craft` takes a craft file"
    )]
    CraftFile,

    /// More samples than a simulation may have.
    #[error(
        "`duration_s` times `gyro.rate_hz` gives {samples:.3e} samples, but at most {limit:.0e} \
         are supported; shorten the flight or lower the rate"
    )]
    TooManySamples {
        /// Samples of this scenario.
        samples: f64,
        /// Samples supported.
        limit: f64,
    },

    /// Wheels with more spin inertia than the spacecraft that contains them.
    #[error(
        "`{key}` includes the wheels (locked), but without their spin inertia its principal \
         moments are {}; each must be positive: check `spin_inertia_kg_m2` of the wheels",
        numbers(.principal_moments_kg_m2)
    )]
    WheelsOutweighBody {
        /// The key of the inertia.
        key: String,
        /// Eigenvalues of `J − Σ Iₛ a aᵀ`, ascending, kg m².
        principal_moments_kg_m2: [f64; 3],
    },

    /// A change to an inertia that no rigid body with these wheels has.
    #[error(
        "`{key}` leads to principal moments {} kg m² at t = {time_s} s, which no body that carries \
         these wheels has; check the numbers and their order ({})",
        numbers(.principal_moments_kg_m2),
        ELEMENT_NAMES.join(" ")
    )]
    UnphysicalChange {
        /// The key of the change.
        key: String,
        /// Time since the start, s.
        time_s: f64,
        /// Eigenvalues of the tensor at that time, ascending, kg m².
        principal_moments_kg_m2: [f64; 3],
    },

    /// None or several of keys that exclude each other.
    #[error("`{key}` takes exactly one of {}; keep one", list(.keys))]
    NotOneOf {
        /// The table.
        key: String,
        /// The keys.
        keys: [&'static str; 2],
    },

    /// A controller with wheels that do not span three dimensions.
    #[error(
        "[control] turns the body with its wheels, but the axes of the {found} [[wheel]] tables do \
         not span three dimensions; give three or more wheels with independent axes"
    )]
    WheelsDoNotSpan {
        /// Number of wheels.
        found: usize,
    },

    /// Gains from a natural frequency beside gains per axis.
    #[error(
        "`control` has gains of both kinds; give either natural_frequency_rad_s and \
         damping_ratio, or attitude_gain_n_m and rate_gain_n_m_s"
    )]
    TwoKindsOfGains,

    /// A key of craft files that a scenario determines from other keys.
    #[error("`{key}` is a key of craft files; a scenario derives it from its torque: remove it")]
    KeyOfCraftFile {
        /// The key.
        key: String,
    },

    /// Errors of more wheels than there are.
    #[error(
        "{found} [[hardware.wheel]] tables, but {wheels} wheels; give one for each wheel, in their order"
    )]
    SurplusWheelErrors {
        /// Number of tables.
        found: usize,
        /// Number of wheels.
        wheels: usize,
    },

    /// A pulse that a thruster cannot give.
    #[error(
        "`{key}` has a pulse from {from_s} to {to_s} s, shorter than `min_pulse_s`, {min_pulse_s} s"
    )]
    ShortPulse {
        /// The key of the pulses.
        key: String,
        /// Start of the pulse, s.
        from_s: f64,
        /// Its end, s.
        to_s: f64,
        /// Shortest pulse, s.
        min_pulse_s: f64,
    },

    /// A key of the external torque at a wheel's motor.
    #[error(
        "`{key}` belongs to the external [torque]; the speed of a wheel is measured, and the scale of \
         its motor torque has no effect on the estimate: remove it"
    )]
    KeyOfExternalTorque {
        /// The key.
        key: String,
    },

    /// A key of another kind of torque profile.
    #[error("`{key}` does not belong to kind = \"{kind}\", which takes: {}; remove it", list(.takes))]
    KeyOfOtherKind {
        /// The surplus key.
        key: String,
        /// The kind of the profile.
        kind: &'static str,
        /// The keys of this kind.
        takes: Vec<&'static str>,
    },

    /// Lists of different length that belong together.
    #[error("`{key}` has {found} entries, but `{other}` has {required}; make them equal")]
    UnequalLengths {
        /// One list.
        key: String,
        /// Its length.
        found: usize,
        /// The list that it belongs to.
        other: String,
        /// The length of that one.
        required: usize,
    },
}

impl From<ScenarioProblem> for Problem {
    fn from(problem: ScenarioProblem) -> Self {
        Self::Other(Box::new(problem))
    }
}
