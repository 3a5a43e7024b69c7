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
            Self::Shared(all) | Self::PerHardware(all) => {
                typical(all.iter().map(|truth| truth.reference).collect())
            }
            Self::PerRun => typical(of_runs.collect()),
        }
    }
}

/// Mean of the true elements and RMS of the bounds; no bound where any reference has none.
fn typical(all: Vec<Reference>) -> Reference {
    let mean = |of: &dyn Fn(&Reference) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let rms = |of: fn(&Reference) -> &[Option<f64>; 6], i: usize| {
        let square = |r: &Reference| of(r)[i].map_or(0.0, |bound| bound * bound);
        all.iter().all(|r| of(r)[i].is_some()).then(|| mean(&square).sqrt())
    };
    Reference {
        truth_kg_m2: std::array::from_fn(|i| mean(&|r| r.truth_kg_m2[i])),
        bound_kg_m2: std::array::from_fn(|i| rms(|r| &r.bound_kg_m2, i)),
        joint_bound_kg_m2: std::array::from_fn(|i| rms(|r| &r.joint_bound_kg_m2, i)),
    }
}
