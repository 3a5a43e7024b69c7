//! The motions that the runs of a campaign fly, each with its bound.

use std::borrow::Cow;

use crate::input::Scenario;
use crate::truth::{Flight, IntegrationFailed};

use super::statistics::Yardstick;

/// A motion, and what its runs are measured with.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The true inertia and its bound.
    pub yardstick: Yardstick,
    /// The motion.
    pub flight: Flight,
}

/// Every truth of a scenario.
#[derive(Clone, Debug)]
pub enum Truths {
    /// The few that the scenario's dispersion makes, in its order.
    Few(Vec<Truth>),
    /// Each run's own, which exists only while it is flown.
    OfEachRun,
}

impl Truth {
    fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let flight = Flight::simulate(scenario)?;
        let yardstick = Yardstick {
            truth_kg_m2: scenario.final_inertia_kg_m2(),
            bound_kg_m2: flight.bound.sigma_kg_m2,
        };
        Ok(Self { yardstick, flight })
    }
}

impl Truths {
    /// Simulates the few there are, unless each run has its own.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        if scenario.dispersion.spacecraft.is_some() {
            return Ok(Self::OfEachRun);
        }
        let one = |index| Truth::simulate(&scenario.of_truth(index));
        Ok(Self::Few((0..scenario.dispersion.truths()).map(one).collect::<Result<_, _>>()?))
    }

    /// That of a run, by its seed and the scenario of that seed.
    pub fn of_run(
        &self,
        scenario: &Scenario,
        seed: u64,
    ) -> Result<Cow<'_, Truth>, IntegrationFailed> {
        match self {
            Self::Few(all) => {
                Ok(Cow::Borrowed(&all[scenario.dispersion.truth_of(seed) % all.len()]))
            }
            Self::OfEachRun => Truth::simulate(scenario).map(Cow::Owned),
        }
    }

    /// What stands for all of them in a report; of truths that are each run's own, for those that
    /// these `flown` runs had.
    pub fn typical(&self, flown: impl Iterator<Item = Yardstick>) -> Yardstick {
        match self {
            Self::Few(all) => typical(all.iter().map(|truth| truth.yardstick).collect()),
            Self::OfEachRun => typical(flown.collect()),
        }
    }
}

/// The mean of the true elements, and the RMS of the bounds, where all have one.
fn typical(all: Vec<Yardstick>) -> Yardstick {
    let mean = |of: &dyn Fn(&Yardstick) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let has_bound = |i: usize| all.iter().all(|yardstick| yardstick.bound_kg_m2[i].is_some());
    let square = |y: &Yardstick, i: usize| y.bound_kg_m2[i].map_or(0.0, |bound| bound * bound);
    Yardstick {
        truth_kg_m2: std::array::from_fn(|i| mean(&|y| y.truth_kg_m2[i])),
        bound_kg_m2: std::array::from_fn(|i| has_bound(i).then(|| mean(&|y| square(y, i)).sqrt())),
    }
}
