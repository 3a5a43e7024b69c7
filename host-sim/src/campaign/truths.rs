//! True motions of a campaign, each with its reference.

use std::borrow::Cow;

use super::score::Reference;
use crate::input::Scenario;
use crate::truth::{Flight, IntegrationFailed};

/// A true motion and the reference of its runs.
#[derive(Clone, Debug)]
pub struct Truth {
    /// True inertia and bound.
    pub reference: Reference,
    /// Motion.
    pub flight: Flight,
}

/// All truths of a scenario.
#[derive(Clone, Debug)]
pub enum Truths {
    /// Truths shared by the runs, one per inertia factor of the scenario's dispersion, in its order.
    Shared(Vec<Truth>),
    /// Truths of the undrawn hardware, in the same order. The motion is simulated with each run, from
    /// its drawn hardware; truth and bound are those of the undrawn.
    PerHardware(Vec<Truth>),
    /// Each run draws its own spacecraft; its truth is simulated with the run.
    PerRun,
}

impl Truth {
    fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let flight = Flight::simulate(scenario)?;
        let reference = Reference {
            truth_kg_m2: scenario.final_inertia_kg_m2(),
            bound_kg_m2: flight.bound.sigma_kg_m2,
            joint_bound_kg_m2: flight.bound.joint_kg_m2(),
        };
        Ok(Self { reference, flight })
    }
}

impl Truths {
    /// Simulates the shared truths; nothing if each run draws its own spacecraft.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        if scenario.dispersion.spacecraft.is_some() {
            return Ok(Self::PerRun);
        }
        let one = |index| Truth::simulate(&scenario.of_truth(index));
        let all = (0..scenario.dispersion.truths()).map(one).collect::<Result<_, _>>()?;
        Ok(if scenario.draws_motion() { Self::PerHardware(all) } else { Self::Shared(all) })
    }

    /// Truth of the run with this seed. `scenario` is the scenario of that seed.
    pub fn of_run(
        &self,
        scenario: &Scenario,
        seed: u64,
    ) -> Result<Cow<'_, Truth>, IntegrationFailed> {
        match self {
            Self::Shared(all) => {
                Ok(Cow::Borrowed(&all[scenario.dispersion.truth_of(seed) % all.len()]))
            }
            Self::PerHardware(all) => {
                let undrawn = &all[scenario.dispersion.truth_of(seed) % all.len()];
                let flight = Flight::with_bound(scenario, undrawn.flight.bound.clone())?;
                Ok(Cow::Owned(Truth { reference: undrawn.reference, flight }))
            }
            Self::PerRun => Truth::simulate(scenario).map(Cow::Owned),
        }
    }

    /// Mean of the true elements and RMS of the bounds, for a report. Where each run draws its own
    /// spacecraft, `of_runs` are the references averaged.
    pub fn typical(&self, of_runs: impl Iterator<Item = Reference>) -> Reference {
        match self {
            Self::Shared(_) | Self::PerHardware(_) => self.shared(),
            Self::PerRun => None,
        }
        .unwrap_or_else(|| Typical::of(of_runs).reference())
    }

    /// Mean of the true elements and RMS of the bounds of the shared truths; none if each run draws its own spacecraft.
    pub fn shared(&self) -> Option<Reference> {
        match self {
            Self::Shared(all) | Self::PerHardware(all) => {
                Some(Typical::of(all.iter().map(|truth| truth.reference)).reference())
            }
            Self::PerRun => None,
        }
    }
}

/// Sums of references: mean of the true elements, RMS of the bounds, no bound where any reference has none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Typical {
    count: usize,
    truth_kg_m2: [f64; 6],
    /// Sums of squares, kg² m⁴.
    bound: [Option<f64>; 6],
    joint_bound: [Option<f64>; 6],
}

impl Default for Typical {
    fn default() -> Self {
        let sums = [Some(0.0); 6];
        Self { count: 0, truth_kg_m2: [0.0; 6], bound: sums, joint_bound: sums }
    }
}

impl Typical {
    fn of(references: impl Iterator<Item = Reference>) -> Self {
        let mut sums = Self::default();
        references.for_each(|reference| sums.add(&reference));
        sums
    }

    pub(super) fn add(&mut self, reference: &Reference) {
        let square = |sum: Option<f64>, bound: Option<f64>| Some(sum? + bound? * bound?);
        self.count += 1;
        for i in 0..6 {
            self.truth_kg_m2[i] += reference.truth_kg_m2[i];
            self.bound[i] = square(self.bound[i], reference.bound_kg_m2[i]);
            self.joint_bound[i] = square(self.joint_bound[i], reference.joint_bound_kg_m2[i]);
        }
    }

    pub(super) fn reference(&self) -> Reference {
        let count = self.count as f64;
        let rms = |sum: Option<f64>| sum.map(|sum| (sum / count).sqrt());
        Reference {
            truth_kg_m2: self.truth_kg_m2.map(|sum| sum / count),
            bound_kg_m2: self.bound.map(rms),
            joint_bound_kg_m2: self.joint_bound.map(rms),
        }
    }
}
