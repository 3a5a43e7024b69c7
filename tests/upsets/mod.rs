//! Single-event upsets: one flipped bit in the memory of an estimator, one per flight.
//!
//! The bit is drawn from all bytes of the estimator as it lies in memory: numbers, counters, tags, unused
//! places of buffers and padding. The flight continues from a copy of the clean flight at the drawn sample. An
//! invalid enum is undefined behaviour in Rust: a flight may end in a panic, an abort or a hang, so that
//! flights run in a process of their own ([`campaign`]).

pub mod campaign;
mod memory;

use anyhow::{Context, Result, anyhow};
use fsw_core::hardware::Hardware;
use fsw_core::{Coasting, Estimate, Outcome, Prior, Reset, Sample, Status, Vec3, WheelArray};
use fsw_roster::{EstimatorId, EstimatorSlot, InitialData};
use fsw_target::flight::computer::SLICES_PER_SAMPLE;
use fsw_target::flight::craft::WHEELS;
use fsw_target::runtime::sealed::Sealed;
use host_sim::input::Scenario;
use host_sim::simulation::log_of;
use host_sim::truth::Flight;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Scenario of the flights, cut to this duration, s.
const SCENARIO: &str = "fault-matrix";
const DURATION_S: f64 = 120.0;
/// Samples between two checkpoints: 30 s.
const CHECKPOINT: usize = 300;
/// Largest difference from the final estimate of the clean flight that is harmless, in its sigmas.
const HARMLESS_SIGMAS: f32 = 2.0;

/// Effect of a flipped bit on a flight that returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Every element within two sigmas of the clean flight.
    Harmless,
    /// Beyond, and reported: a rejected sample, a reset, a worse status, or residuals that are not white.
    Detected,
    /// Beyond, and not reported.
    Silent,
    /// A panic.
    Panic,
}

impl Effect {
    /// Number of a code.
    pub const ALL: [Self; 4] = [Self::Harmless, Self::Detected, Self::Silent, Self::Panic];

    /// One letter.
    pub const fn code(self) -> &'static str {
        match self {
            Self::Harmless => "h",
            Self::Detected => "d",
            Self::Silent => "s",
            Self::Panic => "p",
        }
    }
}

/// Memory of the estimator between steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// As fsw-core leaves it.
    Bare,
    /// Sealed and checked, as the flight computer does ([`fsw_target::runtime::sealed`]).
    Sealed,
}

/// The clean flight of one estimator, with its state before each sample.
pub struct CleanFlight {
    samples: Vec<Sample<f32, WHEELS>>,
    states: Vec<EstimatorSlot>,
    outcomes: Vec<Outcome>,
    last: Estimate<f32>,
}

/// One flipped bit.
#[derive(Clone, Copy, Debug)]
pub struct Flip {
    /// Sample before which the bit flips.
    pub sample: usize,
    /// Byte of the estimator.
    pub byte: usize,
    /// Bit of the byte.
    pub bit: u8,
}

impl CleanFlight {
    /// Flies without a flip.
    ///
    /// # Errors
    /// A scenario or data that the estimator rejects.
    pub fn new(estimator: EstimatorId) -> Result<Self> {
        let mut scenario = Scenario::load(SCENARIO)?;
        scenario.duration_s = DURATION_S;
        let craft = scenario.craft();
        let log = log_of(&scenario, &Flight::simulate(&scenario)?, 1);
        let wheel = |i: usize| craft.wheels.get(i).context("four wheels");
        let mut axes = [Vec3::zeros(); WHEELS];
        let mut spin_kg_m2 = [0.0; WHEELS];
        for i in 0..WHEELS {
            axes[i] = wheel(i)?.axis.map(|x| x as f32);
            spin_kg_m2[i] = wheel(i)?.spin_inertia_kg_m2 as f32;
        }
        let prior = craft.prior.as_ref().context("a prior")?;
        let from = InitialData {
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s().context("gyro noise")? as f32,
            wheels: WheelArray::new(axes, spin_kg_m2).map_err(|error| anyhow!("{error:?}"))?,
            hardware: Hardware::ideal(),
            prior: Some(Prior {
                inertia_kg_m2: prior.inertia_kg_m2.map(|x| x as f32),
                sigma_kg_m2: prior.sigma_kg_m2.map(|x| x as f32),
            }),
        };
        let samples: Vec<_> = log
            .iter()
            .map(|row| Sample {
                time_us: row.time_us,
                rate_rad_s: row.rate_rad_s.map(|x| x as f32),
                wheel_speed_rad_s: std::array::from_fn(|i| row.wheel_speed_rad_s[i] as f32),
                torque_n_m: row.torque_n_m.map(|x| x as f32),
                attitude: None,
            })
            .collect();
        let mut slot = EstimatorSlot::default();
        slot.start(estimator, &from).map_err(|refused| anyhow!("{refused:?}"))?;
        let (mut states, mut outcomes) = (Vec::new(), Vec::new());
        for sample in &samples {
            states.push(slot.clone());
            outcomes.push(step(&mut slot, sample));
        }
        let last = end(&mut slot);
        Ok(Self { samples, states, outcomes, last })
    }

    /// Bytes of the estimator.
    pub fn bytes(&self) -> usize {
        self.states.first().map_or(0, memory::bytes)
    }

    /// The flip of a run.
    pub fn flip(&self, run: u64) -> Flip {
        let mut random = Pcg64::seed_from_u64(run);
        Flip {
            sample: random.random_range(1..self.samples.len()),
            byte: random.random_range(0..self.bytes()),
            bit: random.random_range(0..8),
        }
    }

    /// Flies from the flip to the end. A panic passes through.
    pub fn fly(&self, flip: Flip, memory: Memory) -> Effect {
        let mut slot = self.states[flip.sample].clone();
        let byte = memory::byte(&mut slot, flip.byte);
        let mut sealed = Sealed::new(&mut slot);
        sealed.seal();
        if let Some(byte) = byte {
            byte.flip(flip.bit);
        }
        let mut is_reported = false;
        if memory == Memory::Sealed && !sealed.open() {
            // A restored checkpoint has the bits of the saved state (fsw-core, `checkpoint`).
            sealed.get_mut().clone_from(&self.states[flip.sample / CHECKPOINT * CHECKPOINT]);
            is_reported = true;
        }
        let clean = self.samples.iter().zip(&self.outcomes).skip(flip.sample);
        for (sample, clean) in clean {
            let outcome = step(&mut slot, sample);
            is_reported |= outcome != *clean && is_event(&outcome);
        }
        let estimate = end(&mut slot);
        is_reported |= is_worse(&estimate, &self.last);
        if self.is_close(&estimate) {
            Effect::Harmless
        } else if is_reported {
            Effect::Detected
        } else {
            Effect::Silent
        }
    }

    fn is_close(&self, estimate: &Estimate<f32>) -> bool {
        let of = |estimate: &Estimate<f32>| estimate.inertia.elements_kg_m2();
        let pairs = of(estimate).into_iter().zip(of(&self.last)).zip(self.last.sigma_kg_m2());
        pairs.into_iter().all(|((x, clean), sigma)| (x - clean).abs() <= HARMLESS_SIGMAS * sigma)
    }
}

/// A step and the work that the flight computer does after it.
fn step(slot: &mut EstimatorSlot, sample: &Sample<f32, WHEELS>) -> Outcome {
    let Some(selected) = slot.selected_mut() else { return Outcome::Coasting(Coasting::Aligning) };
    let outcome = selected.step(sample);
    selected.work(SLICES_PER_SAMPLE);
    outcome
}

/// Completes the work; the final estimate.
fn end(slot: &mut EstimatorSlot) -> Estimate<f32> {
    if let Some(window) = slot.window_mut() {
        fsw_core::Estimator::finish(window);
    }
    slot.estimate()
}

fn is_event(outcome: &Outcome) -> bool {
    match outcome {
        Outcome::Coasting(Coasting::Rejected(_) | Coasting::Spike) => true,
        Outcome::Reset(why) => !matches!(why, Reset::FirstSample | Reset::Aligned),
        Outcome::Updated | Outcome::Coasting(_) => false,
    }
}

/// True where the estimate reports a fault that the clean one does not.
fn is_worse(estimate: &Estimate<f32>, clean: &Estimate<f32>) -> bool {
    let rank = |status: Status| match status {
        Status::Converged => 0,
        Status::Partial => 1,
        Status::Unobservable => 2,
        Status::Diverged => 3,
    };
    let is_not_white = |estimate: &Estimate<f32>| estimate.residuals_white == Some(false);
    rank(estimate.status) > rank(clean.status) || (is_not_white(estimate) && !is_not_white(clean))
}
