//! What the flight loop needs of the hardware: four small traits, in SI units and body axes.
//!
//! A driver converts counts to these units in one place and passes its bus error through; the
//! loop counts the errors. A second gyro is one file with one `impl Gyro`.

use fsw_core::Vec3;

/// When a gyro sample was taken: the data-ready interrupt, or its stand-in.
pub trait DataReady {
    /// Takes the time stamp of the newest sample that has not been handled yet, microseconds since
    /// an arbitrary start; `None` if there is none. Never waits.
    ///
    /// The stamp is that of the sample, not of the moment when the loop came to read it, so that a
    /// late loop costs no accuracy. A loop that is late by more than a sample loses those before
    /// the newest, since a gyro's registers hold no other: the estimator bridges the gap.
    fn take_us(&mut self) -> Option<u64>;

    /// Whether a sample has come since the last [`DataReady::take_us`]. What was read of the gyro
    /// in between may then be the newer one's.
    fn has_newer(&mut self) -> bool;

    /// Throws away what was announced and hasn't been taken: the gyro has been set up anew, and holds nothing
    /// of it.
    fn forget(&mut self);

    /// Samples that were announced and lost since the start, because the loop came too late.
    fn overruns(&self) -> u32;
}

/// A three-axis rate gyro.
pub trait Gyro {
    /// The error of the bus or of the part.
    type Error;

    /// Body rate relative to inertial space, rad/s, of the sample that was announced last.
    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, Self::Error>;
}

/// The tachometers of `W` reaction wheels.
pub trait WheelTachometers<const W: usize> {
    /// The error of the bus or of the part.
    type Error;

    /// Speed of each wheel about its spin axis relative to the body, rad/s.
    fn speed_rad_s(&mut self) -> Result<[f32; W], Self::Error>;
}

/// The external torque that acts, as far as it is known (thrusters, magnetorquers).
pub trait TorqueCommand {
    /// External torque in body axes, N m; zero if none is known. Wheel torques are internal
    /// and do not belong here: the tachometers show them.
    fn torque_n_m(&mut self) -> Vec3<f32>;

    /// The ground commands this torque from now on. Ignored by what has it from elsewhere.
    fn command(&mut self, torque_n_m: Vec3<f32>);
}

/// A torque that the ground commands, and nothing else: it acts until the next command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandedTorque {
    torque_n_m: Vec3<f32>,
}

impl Default for CommandedTorque {
    fn default() -> Self {
        Self { torque_n_m: Vec3::zeros() }
    }
}

impl TorqueCommand for CommandedTorque {
    fn torque_n_m(&mut self) -> Vec3<f32> {
        self.torque_n_m
    }

    fn command(&mut self, torque_n_m: Vec3<f32>) {
        self.torque_n_m = torque_n_m;
    }
}
