//! True motions: one per scenario, shared by its runs, or one per run.

use std::borrow::Cow;
use std::sync::Arc;

use anyhow::Result;
use host_sim::campaign::{Truth, Truths};
use host_sim::input::Scenario;

use super::tumble::Tumbles;
use super::varying::Varying;

/// Number of scenarios whose truths are kept, for the campaigns that follow.
const KEPT: usize = 3;

/// Origin of the true motion of a campaign.
#[derive(Clone, Debug)]
pub enum Source {
    /// A scenario, with the truths and bounds of the simulator.
    Scenario(Box<Scenario>),
    /// A body, a gyro and a tumble of its own for each seed, without bound.
    Tumbles(Box<Tumbles>),
    /// A scenario, with an inertia that varies in its own way for each seed.
    Varying(Box<Varying>),
}

/// Truths of a campaign, simulated once.
pub enum Motions {
    /// Of the simulator.
    Simulated(Box<Scenario>, Arc<Truths>),
    /// Drawn with the run.
    Drawn(Box<Tumbles>),
    /// With a course of the inertia that is drawn with the run.
    Varied(Box<Varying>),
}

/// Scenario and truth of one run.
pub struct Motion<'a> {
    /// The scenario of the run's seed.
    pub scenario: Scenario,
    /// Truth, and true inertia with its bound.
    pub truth: Cow<'a, Truth>,
}

impl Motions {
    /// Scenario and truth of the run with this seed.
    ///
    /// # Errors
    /// The motion cannot be integrated.
    pub fn of_run(&self, seed: u64) -> Result<Motion<'_>> {
        match self {
            Self::Simulated(scenario, truths) => {
                let scenario = scenario.of_seed(seed);
                let truth = truths.of_run(&scenario, seed)?;
                Ok(Motion { scenario, truth })
            }
            Self::Drawn(tumbles) => {
                let (scenario, truth) = tumbles.draw(seed);
                Ok(Motion { scenario, truth: Cow::Owned(truth) })
            }
            Self::Varied(varying) => {
                let (scenario, truth) = varying.draw(seed)?;
                Ok(Motion { scenario, truth: Cow::Owned(truth) })
            }
        }
    }
}

/// Truths of the last scenarios.
#[derive(Default)]
pub struct Library {
    kept: Vec<(Scenario, Arc<Truths>)>,
}

impl Library {
    /// Truths of a campaign's source.
    ///
    /// # Errors
    /// The motion cannot be integrated.
    pub fn motions(&mut self, source: &Source) -> Result<Motions> {
        let scenario = match source {
            Source::Tumbles(tumbles) => return Ok(Motions::Drawn(tumbles.clone())),
            Source::Varying(varying) => return Ok(Motions::Varied(varying.clone())),
            Source::Scenario(scenario) => scenario,
        };
        let known = self.kept.iter().find(|(kept, _)| kept == scenario.as_ref());
        if let Some((_, truths)) = known {
            return Ok(Motions::Simulated(scenario.clone(), Arc::clone(truths)));
        }
        let truths = Arc::new(Truths::simulate(scenario)?);
        if self.kept.len() == KEPT {
            self.kept.remove(0);
        }
        self.kept.push((scenario.as_ref().clone(), Arc::clone(&truths)));
        Ok(Motions::Simulated(scenario.clone(), truths))
    }
}
