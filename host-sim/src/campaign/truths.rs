//! The motions that the runs of a campaign fly: each is simulated once, with its bound.

use crate::input::Scenario;
use crate::truth::{Flight, IntegrationFailed};

use super::statistics::Yardstick;

/// Every truth that a scenario's dispersion makes, in its order.
#[derive(Clone, Debug)]
pub struct Truths {
    all: Vec<(Yardstick, Flight)>,
}

impl Truths {
    /// Simulates each.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let one = |index| {
            let scenario = scenario.of_truth(index);
            let flight = Flight::simulate(&scenario)?;
            let yardstick = Yardstick {
                truth_kg_m2: scenario.final_inertia_kg_m2(),
                bound_kg_m2: flight.bound.sigma_kg_m2,
            };
            Ok((yardstick, flight))
        };
        Ok(Self { all: (0..scenario.dispersion.truths()).map(one).collect::<Result<_, _>>()? })
    }

    /// One of them, by its number modulo how many there are, and what its runs are measured with.
    pub fn get(&self, index: usize) -> (&Yardstick, &Flight) {
        let (yardstick, flight) = &self.all[index % self.all.len()];
        (yardstick, flight)
    }

    /// What stands for all of them in a report: the mean of the true elements, and the RMS of the
    /// bounds, where all have one.
    pub fn typical(&self) -> Yardstick {
        let mean = |of: &dyn Fn(&Yardstick) -> f64| {
            self.all.iter().map(|(yardstick, _)| of(yardstick)).sum::<f64>() / self.all.len() as f64
        };
        let has_bound =
            |i: usize| self.all.iter().all(|(yardstick, _)| yardstick.bound_kg_m2[i].is_some());
        let square = |y: &Yardstick, i: usize| y.bound_kg_m2[i].map_or(0.0, |bound| bound * bound);
        Yardstick {
            truth_kg_m2: std::array::from_fn(|i| mean(&|y| y.truth_kg_m2[i])),
            bound_kg_m2: std::array::from_fn(|i| {
                has_bound(i).then(|| mean(&|y| square(y, i)).sqrt())
            }),
        }
    }
}
