//! Errors of setting up an estimator.

use fsw_core::ConfigError;
use thiserror::Error;

use super::name::EstimatorName;
use crate::input::craft::MAX_WHEELS;

/// Reason why an estimator cannot be set up for a craft and its log.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SetUpError {
    /// A parameter is outside the range that the flight core accepts.
    #[error("the estimator rejects its configuration: {0}")]
    Config(#[from] ConfigError),
    /// The rate filter requires a nominal inertia, and the craft has no prior.
    #[error(
        "{estimator} needs a nominal inertia: add a [prior] with inertia_kg_m2 = [jxx, jyy, jzz, \
         jxy, jxz, jyz] and sigma_kg_m2 of each"
    )]
    NoNominalInertia {
        /// The estimator.
        estimator: EstimatorName,
    },
    /// The estimator requires the gyro noise, and the craft does not state it.
    #[error("{estimator} needs the gyro noise: add noise_rad_s under [gyro]")]
    NoGyroNoise {
        /// The estimator.
        estimator: EstimatorName,
    },
    /// The gyro noise is not stated and cannot be estimated from the log.
    #[error(
        "the gyro noise cannot be estimated from this log ({reason}); add noise_rad_s under [gyro] \
         in the craft file"
    )]
    UnmeasurableGyroNoise {
        /// The property of the log that prevents it.
        reason: &'static str,
    },
    /// The estimator conserves momentum in inertial axes, and the log has no attitude.
    #[error(
        "{estimator} needs the attitude: add the columns attitude_q1, attitude_q2, attitude_q3, \
         attitude_q4 to the log (inertial to body axes, scalar last)"
    )]
    NoAttitude {
        /// The estimator.
        estimator: EstimatorName,
    },
    /// A fault restarts the estimator, and it has no checkpoints.
    #[error(
        "{estimator} has no checkpoints: choose another estimator, or remove the faults of the kinds \
         reset, cold_reset, power_cut and bit_flip"
    )]
    NotRestorable {
        /// The estimator.
        estimator: EstimatorName,
    },
    /// The craft has more wheels than the estimators are compiled for.
    #[error("{found} wheels: the estimators are compiled for at most {MAX_WHEELS}")]
    TooManyWheels {
        /// Number of wheels of the craft.
        found: usize,
    },
    /// The craft states more modes than the estimator has unknowns for.
    #[error(
        "{found} tables [[mode]]: window has unknowns for at most {most}; join those of like frequency"
    )]
    TooManyModes {
        /// Number of modes of the craft.
        found: usize,
        /// Number that the estimator has unknowns for.
        most: usize,
    },
}
