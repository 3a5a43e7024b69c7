//! A campaign: what is flown, what is done to the flight, and the limits that must hold.

use host_sim::estimation::{EstimatorName, Precision};

use super::batch_fit::Scale;
use super::fault::Fault;
use super::motion::Source;

/// Seconds from an event to the last instant at which the estimate may still be wrong unannounced.
pub const MAX_WRONG_S: f64 = 10.0;

/// One campaign, flown in each of its precisions.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// Name: item, motion and damage, separated by `/` and `-`.
    pub name: String,
    /// Item of the list of requirements, 2 to 11.
    pub item: u8,
    /// Truth.
    pub source: Source,
    /// Length of the log, samples; none for the whole flight.
    pub samples: Option<usize>,
    /// Damage to the samples.
    pub fault: Fault,
    /// Gyro noise that the estimator is configured with.
    pub noise: StatedNoise,
    /// Estimator under test.
    pub estimator: EstimatorName,
    /// Precisions, each with a row of the table.
    pub precisions: &'static [Precision],
    /// Number of runs.
    pub runs: u64,
    /// Number of runs of the small version; zero where it is too long for it.
    pub small: u64,
    /// Comparison beyond the estimate at the end of the log.
    pub check: Check,
    /// Limits.
    pub limits: Limits,
    /// The limits hold at present: the test asserts them.
    pub held: bool,
}

/// Both precisions.
pub const BOTH: &[Precision] = &[Precision::F32, Precision::F64];
/// Single precision alone.
pub const SINGLE: &[Precision] = &[Precision::F32];

/// Gyro noise that the estimator is configured with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StatedNoise {
    /// The true noise times this factor.
    Times(f64),
    /// None: to be estimated from the log.
    Unstated,
}

/// Comparison beyond the estimate at the end of the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Check {
    /// None.
    Final,
    /// Error against that of the flight with the same noise and no fault.
    Clean,
    /// Error against that of a batch fit in double precision from the truth.
    BatchFit(Scale),
    /// Estimate against that of double precision from the same log.
    Double,
    /// Estimate of the log cut at each multiple of this number of samples.
    Prefixes(usize),
    /// Estimate at each whole second after an event, which lasts from the first to the second time,
    /// s since the start.
    EachSecond([f64; 2]),
    /// The scale is unobserved: neither observed, nor more certain than by the prior.
    NoScale,
    /// Wheels turn freely: no sigma below the bound.
    WithinBound,
    /// The log has no information at all: nothing is observed.
    NoInformation,
}

/// Limits of the figures; none where a figure has no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least share of runs with status converged.
    pub converged: Option<f64>,
    /// Least share of runs with status converged or partial.
    pub found: Option<f64>,
    /// Largest share of runs with status diverged.
    pub diverged: Option<f64>,
    /// Largest RMS error over bound, of the worst element.
    pub over_bound: Option<f64>,
    /// Range of the mean NEES per degree of freedom.
    pub nees: Option<[f64; 2]>,
    /// Largest RMS error over that of the reference of [`Check`].
    pub over_reference: Option<f64>,
    /// Least share of the visible faults that are counted as rejected samples or resets.
    pub told: Option<f64>,
    /// Most samples of one run that are rejected as out of order.
    pub out_of_order: Option<u32>,
    /// Largest share of runs with a change, an interruption or a lockout.
    pub changes: Option<f64>,
    /// Largest share of runs with an unannounced wrong estimate.
    pub silent: f64,
    /// Longest time from an event to the last unannounced wrong estimate, s.
    pub wrong_s: Option<f64>,
    /// Longest time from the end of an event until the estimate is right for good, s.
    pub recovery_s: Option<f64>,
}

impl Limits {
    /// No unannounced wrong estimate, no other limit.
    pub const HONEST: Self = Self {
        converged: None,
        found: None,
        diverged: None,
        over_bound: None,
        nees: None,
        over_reference: None,
        told: None,
        out_of_order: None,
        changes: None,
        silent: 0.0,
        wrong_s: None,
        recovery_s: None,
    };
}

impl Campaign {
    /// A campaign of the default estimator in both precisions, noise stated, without fault and
    /// further comparison.
    pub fn new(item: u8, name: impl Into<String>, source: Source, runs: u64) -> Self {
        Self {
            name: name.into(),
            item,
            source,
            samples: None,
            fault: Fault::None,
            noise: StatedNoise::Times(1.0),
            estimator: EstimatorName::Window,
            precisions: BOTH,
            runs,
            small: 0,
            check: Check::Final,
            limits: Limits::HONEST,
            held: false,
        }
    }

    /// The same with a number of runs in the small version.
    pub fn small(self, small: u64) -> Self {
        Self { small, ..self }
    }

    /// The same, with its limits asserted by the test.
    pub fn held(self) -> Self {
        Self { held: true, ..self }
    }
}
