//! The table of fault kinds: one row a kind.

use flight_input::key::{ANY, FINITE, Key, NOT_NEGATIVE, POSITIVE, Range};

use super::{AXIS, DURATION, MAGNITUDE, SHARE, WHEEL};

const FACTOR: Range = Range::new("1 or above, and finite", |x| x.is_finite() && x >= 1.0);
const PART: Range = Range::new("0 to 1", |x| (0.0..=1.0).contains(&x));
const BITS: Range = Range::new("1 to 1000", |x| (1.0..=1000.0).contains(&x));
const JUMP: Range = Range::new("other than 0, within ±1e6", |x| x != 0.0 && x.abs() <= 1e6);

/// Kind of a fault. [`FaultKind::properties`] has its row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table has name and meaning of each")]
pub enum FaultKind {
    GyroSpike,
    GyroStuck,
    GyroZero,
    GyroDropout,
    GyroSaturation,
    GyroBias,
    GyroNoise,
    GyroNan,
    GyroInfinite,
    StampJump,
    ClockSet,
    Duplicate,
    Reordered,
    TachometerDropout,
    TachometerFreeze,
    TachometerSign,
    TachometerEdges,
    TachometerFactor,
    TachometerLate,
    TorqueNotExecuted,
    TorqueNotReported,
    Reset,
    ColdReset,
    PowerCut,
    BitFlip,
}

/// One row of the table of kinds.
#[derive(Clone, Copy, Debug)]
pub struct KindProperties {
    /// The kind.
    pub kind: FaultKind,
    /// Value of `kind` in a scenario file. Stable.
    pub name: &'static str,
    /// Meaning of the magnitude; empty if the kind has none.
    pub magnitude: &'static str,
    /// Unit of the magnitude; empty for a pure number.
    pub unit: &'static str,
    /// Valid magnitudes.
    pub range: Range,
    /// Keys that the kind takes besides `kind`, `start_s` and `latest_start_s`.
    pub takes: &'static [&'static Key],
    /// Effect, a noun phrase or a sentence.
    pub meaning: &'static str,
}

/// A row: name, magnitude, its unit and range, keys, meaning.
const fn row(
    kind: FaultKind,
    name: &'static str,
    (magnitude, unit, range): (&'static str, &'static str, Range),
    takes: &'static [&'static Key],
    meaning: &'static str,
) -> KindProperties {
    KindProperties { kind, name, magnitude, unit, range, takes, meaning }
}

/// Of a kind without magnitude.
const NONE: (&str, &str, Range) = ("", "", ANY);

const READING: &[&Key] = &[&MAGNITUDE, &DURATION, &SHARE, &AXIS];
const READING_ALONE: &[&Key] = &[&DURATION, &SHARE, &AXIS];
const SAMPLE: &[&Key] = &[&DURATION, &SHARE];
const SPEED: &[&Key] = &[&MAGNITUDE, &DURATION, &SHARE, &WHEEL];
const SPEED_ALONE: &[&Key] = &[&DURATION, &SHARE, &WHEEL];

/// The kinds, in the order of [`FaultKind`].
pub const KINDS: [KindProperties; 25] = [
    row(
        FaultKind::GyroSpike,
        "gyro_spike",
        ("size", "rad/s", POSITIVE),
        READING,
        "Error of this size and of random sign, independent from sample to sample",
    ),
    row(
        FaultKind::GyroStuck,
        "gyro_stuck",
        NONE,
        &[&DURATION, &AXIS],
        "The reading at the start is repeated",
    ),
    row(FaultKind::GyroZero, "gyro_zero", NONE, READING_ALONE, "Readings of exactly zero"),
    row(FaultKind::GyroDropout, "gyro_dropout", NONE, SAMPLE, "Samples are lost"),
    row(
        FaultKind::GyroSaturation,
        "gyro_saturation",
        ("limit", "rad/s", POSITIVE),
        READING,
        "Readings end at plus and minus the limit",
    ),
    row(
        FaultKind::GyroBias,
        "gyro_bias",
        ("jump", "rad/s", FINITE),
        READING,
        "Constant error that begins and ends as a step",
    ),
    row(
        FaultKind::GyroNoise,
        "gyro_noise",
        ("factor k", "", FACTOR),
        READING,
        "White noise of k times the stated sigma",
    ),
    row(FaultKind::GyroNan, "gyro_nan", NONE, READING_ALONE, "Readings that are NaN"),
    row(
        FaultKind::GyroInfinite,
        "gyro_infinite",
        NONE,
        READING_ALONE,
        "Infinite readings of random sign",
    ),
    row(
        FaultKind::StampJump,
        "stamp_jump",
        ("offset", "s", JUMP),
        &[&MAGNITUDE, &DURATION, &SHARE],
        "Time stamps are off by this, later ones are right",
    ),
    row(
        FaultKind::ClockSet,
        "clock_set",
        ("offset", "s", JUMP),
        &[&MAGNITUDE],
        "The clock is set: every later stamp is off by this",
    ),
    row(FaultKind::Duplicate, "duplicate", NONE, SAMPLE, "Samples arrive twice"),
    row(
        FaultKind::Reordered,
        "reordered",
        NONE,
        SAMPLE,
        "Samples arrive after the following sample, with their own stamp",
    ),
    row(
        FaultKind::TachometerDropout,
        "tachometer_dropout",
        NONE,
        SPEED_ALONE,
        "No edges: the speed reads zero",
    ),
    row(
        FaultKind::TachometerFreeze,
        "tachometer_freeze",
        NONE,
        &[&DURATION, &WHEEL],
        "The speed at the start is repeated",
    ),
    row(
        FaultKind::TachometerSign,
        "tachometer_sign",
        NONE,
        SPEED_ALONE,
        "The sign of the speed is reversed",
    ),
    row(
        FaultKind::TachometerEdges,
        "tachometer_edges",
        ("share", "", PART),
        SPEED,
        "This share of the edges is missing: the speed is low by it",
    ),
    row(
        FaultKind::TachometerFactor,
        "tachometer_factor",
        ("factor", "", FINITE),
        SPEED,
        "The speed is multiplied",
    ),
    row(
        FaultKind::TachometerLate,
        "tachometer_late",
        ("delay", "s", NOT_NEGATIVE),
        SPEED,
        "The speed is that of an earlier sample",
    ),
    row(
        FaultKind::TorqueNotExecuted,
        "torque_not_executed",
        ("torque", "N m", FINITE),
        &[&MAGNITUDE, &DURATION, &AXIS],
        "External torque that is commanded, and does not act: the reported torque is high by it",
    ),
    row(
        FaultKind::TorqueNotReported,
        "torque_not_reported",
        ("share", "", PART),
        &[&MAGNITUDE, &DURATION, &AXIS],
        "This share of the external torque acts without being reported",
    ),
    row(
        FaultKind::Reset,
        "reset",
        ("period of checkpoints", "s", POSITIVE),
        &[&MAGNITUDE, &DURATION],
        "The computer is off, then restores the estimator from the newest checkpoint",
    ),
    row(
        FaultKind::ColdReset,
        "cold_reset",
        NONE,
        &[&DURATION],
        "The computer is off, then starts the estimator without a checkpoint",
    ),
    row(
        FaultKind::PowerCut,
        "power_cut",
        ("period of checkpoints", "s", POSITIVE),
        &[&MAGNITUDE, &DURATION],
        "Power ends during the save of a checkpoint: the one before it is restored",
    ),
    row(
        FaultKind::BitFlip,
        "bit_flip",
        ("bits", "", BITS),
        &[&MAGNITUDE],
        "Random bits of the sealed state are inverted; the newest checkpoint, of every 30 s, is restored",
    ),
];

impl FaultKind {
    /// The kind's row of the table.
    pub fn properties(self) -> &'static KindProperties {
        &KINDS[self as usize]
    }

    /// The kind of this name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        KINDS.iter().find(|row| row.name == name).map(|row| row.kind)
    }

    /// True for a fault of the computer, which restarts the estimator or alters its state.
    pub fn is_of_the_computer(self) -> bool {
        matches!(self, Self::Reset | Self::ColdReset | Self::PowerCut | Self::BitFlip)
    }
}

impl KindProperties {
    /// True if the kind takes the key.
    pub fn takes(&self, key: &Key) -> bool {
        self.takes.iter().any(|taken| taken.name == key.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_follow_the_order_of_the_enumeration() {
        for (index, row) in KINDS.iter().enumerate() {
            assert_eq!(row.kind as usize, index, "{}", row.name);
            assert_eq!(FaultKind::from_name(row.name), Some(row.kind));
            assert_eq!(row.takes(&MAGNITUDE), !row.magnitude.is_empty(), "{}", row.name);
        }
    }
}
