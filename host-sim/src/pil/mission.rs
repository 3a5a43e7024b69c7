//! Input of a flight: scenario, estimator, telecommands, faults.

use fsw_target::drivers::gyro::bmi088::register;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::command::Command;

use super::answering::Answering;
use crate::input::Scenario;
use crate::truth::Flight;

/// A flight of both computers.
#[derive(Clone, Copy, Debug)]
pub struct Mission<'a> {
    /// Scenario.
    pub scenario: &'a Scenario,
    /// True motion of the scenario.
    pub flight: &'a Flight,
    /// Seed of the gyro noise.
    pub seed: u64,
    /// Estimator.
    pub estimator: EstimatorId,
    /// Number of samples before a power cut: both computers save a checkpoint, restart and resume.
    pub restart_at: Option<usize>,
    /// Telecommands, each with the number of samples before it.
    pub commands: &'a [(usize, Command)],
    /// Wheels that answer the torques of the flight computer; `None`: they follow the scenario.
    pub answering: Option<Answering>,
}

/// A bit error in one gyro reading of the firmware, to verify that the comparison detects it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrokenBit {
    /// Index of the sample.
    pub sample: usize,
    /// Index of the byte in the reading: lower and upper byte of x, y, z.
    pub byte: usize,
    /// Index of the bit, 0 to 7.
    pub bit: u8,
}

impl BrokenBit {
    /// Inverts the bit if `bytes` answers the reading of this sample. `announced` is the number of
    /// samples announced, `written` the bytes written to the gyro.
    pub(super) fn invert(&self, announced: usize, written: &[u8], bytes: &mut [u8]) {
        let is_reading = written == [register::RATE_X_LSB | 0x80];
        if is_reading
            && announced == self.sample + 1
            && let Some(byte) = bytes.get_mut(self.byte)
        {
            *byte ^= 1 << (self.bit % 8);
        }
    }
}
