//! Faults of the chip and of its bus.

use fsw_target::drivers::gyro::bmi088::CHIP_ID;

/// Faults of a chip. The default is a healthy chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Faults {
    /// Content of GYRO_CHIP_ID.
    pub identity: u8,
    /// The rate registers keep their last value.
    pub is_stuck: bool,
    /// The chip does not respond: SPI floats, and I²C is not acknowledged.
    pub is_dead: bool,
    /// Number of successful transactions before one that fails. The fault occurs once.
    pub bus_fails_in: Option<u32>,
    /// Register that ignores writes.
    pub stuck_register: Option<u8>,
    /// Result of the built-in self-test.
    pub self_test: SelfTest,
}

/// Result of the built-in self-test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfTest {
    /// Complete, passed.
    Passes,
    /// Complete, failed.
    Fails,
    /// Never complete.
    Hangs,
    /// Complete and passed, while the continuous check reports a fault (`rate_ok` is clear).
    RateNotOk,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            identity: CHIP_ID,
            is_stuck: false,
            is_dead: false,
            bus_fails_in: None,
            stuck_register: None,
            self_test: SelfTest::Passes,
        }
    }
}

/// Failed transaction: the fault [`Faults::bus_fails_in`], or a missing
/// acknowledge on I²C.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFault;
