//! Interface of the flight software to sensors and actuators: small traits, in SI units and body axes.
//!
//! A driver implements one of them. It is the one place that converts counts to these units, and it
//! passes bus errors through; the flight loop counts them.

use embedded_hal::delay::DelayNs;
use fsw_core::Vec3;

/// Announcement of gyro samples: the data-ready line, or its substitute.
pub trait DataReady {
    /// Takes the time stamp of the newest pending sample, µs since an arbitrary epoch; `None` if none is
    /// pending. Never blocks.
    ///
    /// The stamp is the time of the sample, not of this call, so that a late loop costs no accuracy. A
    /// loop that is late by more than one sample loses all but the newest, since the registers of a gyro
    /// hold one sample; the estimator bridges the gap.
    fn take_us(&mut self) -> Option<u64>;

    /// True if a sample has arrived since the last [`take_us`](Self::take_us): a gyro reading in between
    /// may belong to the newer sample.
    fn has_newer(&mut self) -> bool;

    /// Discards pending samples without counting them, after the gyro has been configured again.
    fn discard(&mut self);

    /// Announced samples that were lost since the start, because the loop was late.
    fn overruns(&self) -> u32;
}

/// A three-axis rate gyro.
pub trait Gyro {
    /// Error of the bus or of the part.
    type Error;

    /// Body rate relative to inertial space at the last announced sample, body axes, rad/s.
    fn rate_rad_s(&mut self) -> Result<Vec3<f32>, Self::Error>;

    /// Delay of a reading, µs: the rate is that of the body this time before the announcement of the sample.
    fn delay_us(&self) -> u32 {
        0
    }
}

/// A gyro chip that can be configured and tested, at power-up and in flight.
pub trait RateGyro: Gyro {
    /// Value of its identity register.
    const IDENTITY: u8;

    /// Reason for a failed start.
    type StartError;
    /// Reason for a failed self-test, or for one that could not run.
    type SelfTestError;

    /// Resets the chip, checks its identity and configures it. For power-up, and in flight after
    /// failed readings or missing data-ready: a chip that reset itself (brown-out, single event) has
    /// lost its settings. Takes less than 0.1 s, all of it in `delay`.
    fn restart(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::StartError>;

    /// Runs the chip's self-test, in bounded time. Readings during the test are invalid.
    fn self_test(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::SelfTestError>;

    /// Largest rate of a reading on a sensor axis, rad/s.
    fn range_rad_s(&self) -> f32;

    /// Rate per count, rad/s.
    fn quantum_rad_s(&self) -> f32;
}

/// Reason for a failed start, common to all gyros: for telemetry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum StartFault {
    /// Bus error.
    Bus,
    /// Another part, or no part.
    WrongIdentity {
        /// Value of the identity register.
        found: u8,
    },
    /// A register does not read back as written.
    NotAsSet,
    /// Invalid settings.
    WrongSettings,
}

/// The tachometers of `W` reaction wheels.
pub trait WheelTachometers<const W: usize> {
    /// Error of the bus or of the part.
    type Error;

    /// Speed of each wheel about its spin axis, relative to the body, rad/s.
    fn speed_rad_s(&mut self) -> Result<[f32; W], Self::Error>;

    /// Mean commanded torque of each motor on its wheel since the last reading of the speeds, about the spin axis, N m;
    /// `None` where this computer does not know it. With it, each sensor is checked against the motion of its wheel
    /// ([`wheel_check`](crate::flight::wheel_check)).
    fn motor_torque_n_m(&mut self) -> [Option<f32>; W] {
        [None; W]
    }

    /// True for each wheel that had a speed at the last reading, or is not fitted.
    fn are_valid(&self) -> [bool; W] {
        [true; W]
    }

    /// Assumes this speed of a wheel, rad/s, in place of its sensor's; `None`: its sensor's again. False if
    /// the wheel has no sensor.
    fn assume(&mut self, wheel: usize, speed_rad_s: Option<f32>) -> bool {
        let _ = (wheel, speed_rad_s);
        false
    }
}

/// Commanded torque of the motors of `W` reaction wheels, beside their edges: of a board's capture timer
/// ([`crate::drivers::wheel_tach`]).
pub trait MotorTorque<const W: usize> {
    /// [`WheelTachometers::motor_torque_n_m`]; unknown by default.
    fn motor_torque_n_m(&mut self) -> [Option<f32>; W] {
        [None; W]
    }
}

/// The motors of `W` reaction wheels.
pub trait WheelMotors<const W: usize> {
    /// Sets the torque of each motor on its wheel, about the spin axis, N m, which acts until the next call. False if a
    /// motor does not take it.
    fn set_torque_n_m(&mut self, torque_n_m: &[f32; W]) -> bool;
}

/// Wheels that another unit commands: no torque is taken.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoMotors;

impl<const W: usize> WheelMotors<W> for NoMotors {
    fn set_torque_n_m(&mut self, _: &[f32; W]) -> bool {
        false
    }
}

/// Known external torque, as of thrusters or magnetorquers.
pub trait TorqueCommand {
    /// External torque on the body, body axes, N m; zero if unknown. Wheel torques are internal: they
    /// are part of the wheel speeds.
    fn torque_n_m(&mut self) -> Vec3<f32>;

    /// Sets the torque of a telecommand, which acts until the next one. Ignored by an implementation with
    /// another source of the torque.
    fn command(&mut self, torque_n_m: Vec3<f32>);
}

/// External torque from telecommands alone: constant until the next one.
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
