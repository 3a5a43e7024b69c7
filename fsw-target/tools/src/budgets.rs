//! Budgets of the firmware: instructions, flash, RAM and stack. The only place of these numbers.
//!
//! Cortex-M4F, `f32`, profile `firmware`. The numbers are requirements, not measurements. A step of
//! 6,000 instructions at 168 MHz and 100 Hz takes well below 1 % of the time.

/// Figure under a budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// Instructions of the most expensive step over all flights.
    WorstStep,
    /// Ratio of the most expensive step to the median step of the same flight.
    Spread,
    /// Instructions of the most expensive slice of work over all flights.
    WorstSlice,
}

/// Limit of one figure of the image `bench`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Name in the log of the bench.
    pub name: &'static str,
    /// Figure under the limit.
    pub figure: Figure,
    /// Requirement: instructions, or a ratio.
    pub at_most: f64,
    /// Limit of the check: the requirement if it is met, otherwise a value slightly above the
    /// measured one, to detect a regression.
    pub held: f64,
}

const fn worst_step(name: &'static str, at_most: f64) -> Budget {
    Budget { name, figure: Figure::WorstStep, at_most, held: at_most }
}

/// Not met: held at the measured value.
const fn worst_step_held(name: &'static str, at_most: f64, held: f64) -> Budget {
    Budget { name, figure: Figure::WorstStep, at_most, held }
}

const fn spread(name: &'static str, at_most: f64) -> Budget {
    Budget { name, figure: Figure::Spread, at_most, held: at_most }
}

const fn worst_slice(name: &'static str, at_most: f64) -> Budget {
    Budget { name, figure: Figure::WorstSlice, at_most, held: at_most }
}

const fn worst_slice_held(name: &'static str, at_most: f64, held: f64) -> Budget {
    Budget { name, figure: Figure::WorstSlice, at_most, held }
}

/// Instruction budgets, counted in QEMU.
pub const INSTRUCTIONS: [Budget; 17] = [
    worst_step("covariance-ud", 3_600.0),
    worst_step("covariance-ud-walk", 4_600.0),
    worst_step("joint-ekf", 6_000.0),
    worst_step("joint-ekf-prior", 6_000.0),
    worst_step("joint-ekf-walk", 6_000.0),
    worst_step_held("joint-ekf-hardware", 8_000.0, 18_000.0),
    spread("joint-ekf", 1.5),
    spread("joint-ekf-prior", 1.5),
    spread("joint-ekf-walk", 1.5),
    worst_step("ekf-sgf-rls", 4_000.0),
    worst_step("window-9", 6_000.0),
    worst_step("window-18", 6_000.0),
    worst_step("window-hardware", 8_000.0),
    worst_step("manoeuvre", 4_000.0),
    worst_slice_held("window-9", 100_000.0, 170_000.0),
    worst_slice("window-18", 150_000.0),
    worst_slice("window-hardware", 240_000.0),
];

/// Limit in bytes; fields as in [`Budget`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bytes {
    /// Requirement.
    pub at_most: u64,
    /// Limit of the check.
    pub held: u64,
}

/// Flash of the flight image with all estimators.
pub const FLIGHT_FLASH: Bytes = Bytes { at_most: 128 * 1024, held: 259 * 1024 };

/// Flash of flight images with one estimator, by the feature of fsw-target.
pub const FLIGHT_FLASH_WITH_ONE: [(&str, Bytes); 3] = [
    ("window", Bytes { at_most: 96 * 1024, held: 181 * 1024 }),
    ("joint-ekf", Bytes { at_most: 64 * 1024, held: 118 * 1024 }),
    ("ekf-sgf-rls", Bytes { at_most: 64 * 1024, held: 73 * 1024 }),
];

/// Instructions of the verification of a telecommand: key of its slot, and tag of the longest telecommand.
/// 2 ms at 168 MHz, a fifth of a sample interval.
pub const TELECOMMAND_TAG: u32 = 300_000;

/// Instructions of one check of the estimator's memory; a round has two. Below a slice of work, the unit of the time
/// beside the steps.
pub const MEMORY_CHECK: u32 = 36_000;

/// Static RAM of the flight image, bytes.
pub const FLIGHT_STATIC_RAM: Bytes = Bytes { at_most: 64 * 1024, held: 64 * 1024 };
/// Largest stack depth of the flight image, bytes. 16 KiB are set aside.
pub const FLIGHT_STACK: Bytes = Bytes { at_most: 4_096, held: 6_144 };
/// Stack of nested interrupts, bytes. Four priorities can nest: serial port, captures, data ready,
/// clock failure. Each takes 104 bytes for registers, those of the FPU included, four for alignment,
/// and the frame of its handler: 16, 56, 16 and 8.
///
/// A measured high-water mark rarely includes an interrupt at the deepest point of the loop. The mark
/// must therefore stay below the limit of [`FLIGHT_STACK`] minus this number.
pub const INTERRUPTS_STACK: u64 = 4 * 108 + 16 + 56 + 16 + 8;
