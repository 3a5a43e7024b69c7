//! Errors of the BMI088 driver. `E` is the error of the bus, passed through unchanged.

/// Reason for a failed start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartError<E> {
    /// Bus error.
    Bus(E),
    /// GYRO_CHIP_ID is not 0x0F. A value of 0x00 or 0xFF means that no chip answers.
    WrongIdentity {
        /// Value of the identity register.
        found: u8,
    },
    /// A register does not read back as written.
    NotAccepted(Differs),
    /// `Settings::body_from_sensor` is not a rotation.
    NotARotation,
}

/// A register that differs from its setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Differs {
    /// Register number.
    pub register: u8,
    /// Value written.
    pub expected: u8,
    /// Value read.
    pub found: u8,
}

/// Reason for a missing reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReadError<E> {
    /// Bus error.
    Bus(E),
    /// All bits of all axes are set: an undriven bus.
    NoAnswer,
    /// Range or bandwidth differ from the settings: the chip has been reset, or was never
    /// configured. Every reading fails until [`Bmi088::restart`](crate::Bmi088::restart).
    SettingsLost(Differs),
}

/// Reason for a failed self-test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SelfTestError<E> {
    /// Bus error.
    Bus(E),
    /// No end after 0.1 s.
    TimedOut,
    /// Failure of the built-in self-test.
    Failed,
    /// Fault in the continuous background check.
    RateNotOk,
}
