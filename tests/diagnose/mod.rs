//! Campaign of `diagnose`: one planted error at a time, and the share of flights in which it is named first.
//!
//! ```text
//!  scenario ─► Flight ─► log ─► plant: error in log or craft ─► diagnose ─► name
//!                                                  └─► window: shift of the estimate in sigmas
//! ```
//!
//! A flight counts where the error shows: an element of the estimate of `window` moves by more than five of its sigmas
//! from that of the log without error, there is no estimate, or it is called diverged or its residuals are not white.
//! An error that leaves the residuals as they are, such as a factor on all wheels, moves the estimate and is not found
//! without a prior: the last column of the table is then `nothing`.

pub mod plant;

use anyhow::Result;
use fsw_core::{Estimate, Status};
use host_sim::diagnosis::diagnose;
use host_sim::estimation::{
    EstimationResult, EstimatorName, Method, Precision, Setup, estimate_log, set_up,
};
use host_sim::input::craft::Prior;
use host_sim::input::log::LogRow;
use host_sim::input::{Craft, Scenario};
use host_sim::simulation::log_of;
use host_sim::truth::Flight;
use rayon::prelude::*;

use plant::{Planted, planted};

/// Scenarios of the campaign.
pub const SCENARIOS: [&str; 3] = ["cubesat-pyramid", "microsat-slew", "stsat3-spin-up"];
/// Shift of an element that counts, sigmas.
const MOVED_SIGMAS: f64 = 5.0;
/// Sigma of the stated prior: share of each moment, and of the mean moment for products.
const PRIOR_SHARE: [f64; 2] = [0.2, 0.1];

/// Result of one flight.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The error shows in the estimate or its residuals.
    pub shows: bool,
    /// It is the first explanation.
    pub is_first: bool,
    /// It is the first, or not distinguished from it.
    pub is_named: bool,
    /// The first explanation, and the share it explains.
    pub first: String,
}

/// Results of one planted error in one scenario.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// Name of the planted error.
    pub error: &'static str,
    /// A mistake of people; an error of the hardware otherwise.
    pub is_mistake: bool,
    /// Each flight.
    pub outcomes: Vec<Outcome>,
}

impl Row {
    /// Number of flights in which the error shows, in which it is first, and in which it is named.
    pub fn counts(&self) -> [usize; 3] {
        let shown: Vec<&Outcome> = self.outcomes.iter().filter(|o| o.shows).collect();
        let first = shown.iter().filter(|o| o.is_first).count();
        [shown.len(), first, shown.iter().filter(|o| o.is_named).count()]
    }

    /// The most frequent wrong explanation.
    pub fn mistaken_for(&self) -> Option<&str> {
        let wrong: Vec<&str> = self
            .outcomes
            .iter()
            .filter(|o| o.shows && !o.is_named)
            .map(|o| o.first.as_str())
            .collect();
        let count = |name: &str| wrong.iter().filter(|other| **other == name).count();
        wrong.iter().copied().max_by_key(|name| count(name))
    }
}

/// Flies `runs` flights of every planted error that the scenario has, with seeds from `seed` on.
///
/// # Errors
/// A scenario that cannot be simulated.
pub fn fly(
    scenario_name: &'static str,
    runs: u64,
    seed: u64,
    with_prior: bool,
    is_selected: impl Fn(&str) -> bool,
) -> Result<Vec<Row>> {
    let scenario = Scenario::load(scenario_name)?;
    let errors = planted(&scenario).into_iter().filter(|error| is_selected(error.name));
    let flight = Flight::simulate(&scenario)?;
    let mut craft = scenario.craft();
    if with_prior {
        craft.prior = Some(prior(&scenario.spacecraft.inertia_kg_m2));
    }
    let seeds: Vec<u64> = (seed..seed + runs).collect();
    let of_clean = |seed: &u64| estimate(&craft, &log_of(&scenario, &flight, *seed));
    let clean: Vec<_> = seeds.par_iter().map(of_clean).collect::<Result<_>>()?;
    let mut rows = Vec::new();
    for error in errors {
        let own = error.flight(&scenario)?;
        let own = own.as_ref().unwrap_or(&flight);
        let fly = |(seed, clean): (&u64, _)| {
            fly_one(log_of(&scenario, own, *seed), craft.clone(), &error, *seed, clean)
        };
        let outcomes = seeds.par_iter().zip(&clean).map(fly).collect::<Result<_>>()?;
        rows.push(Row {
            scenario: scenario_name,
            error: error.name,
            is_mistake: error.is_mistake,
            outcomes,
        });
    }
    Ok(rows)
}

/// Plants the error in a log and its craft, and diagnoses it. `clean` is the estimate without error.
fn fly_one(
    mut log: Vec<LogRow>,
    mut craft: Craft,
    error: &Planted,
    seed: u64,
    clean: &EstimationResult,
) -> Result<Outcome> {
    let expected = error.plant(&mut log, &mut craft, seed);
    let found = estimate(&craft, &log)?;
    let diagnosis = diagnose(&craft, &log);
    let explanations = diagnosis.map(|d| d.explanations).unwrap_or_default();
    let first = explanations.first();
    let is_first = first.is_some_and(|e| e.name == expected);
    Ok(Outcome {
        shows: shows(clean, &found),
        is_first,
        is_named: is_first || first.is_some_and(|e| e.same_as.contains(&expected)),
        first: first.map_or("nothing".to_owned(), |e| e.name.clone()),
    })
}

/// The prior of a design: the true inertia with the sigma of [`PRIOR_SHARE`].
fn prior(truth: &[f64; 6]) -> Prior {
    let mean = truth[..3].iter().sum::<f64>() / 3.0;
    let sigma = |i: usize| if i < 3 { PRIOR_SHARE[0] * truth[i] } else { PRIOR_SHARE[1] * mean };
    Prior { inertia_kg_m2: *truth, sigma_kg_m2: std::array::from_fn(sigma) }
}

fn estimate(craft: &Craft, log: &[LogRow]) -> Result<EstimationResult> {
    let method = Method { estimator: EstimatorName::Window, precision: Precision::F64 };
    let setup = Setup::for_log(method, craft, log)?;
    Ok(estimate_log(log, set_up(&setup)?, |_, _, _| ()))
}

fn shows(reference: &EstimationResult, found: &EstimationResult) -> bool {
    let (before, after) = (&reference.estimate, &found.estimate);
    let (a, b) = (before.inertia.elements_kg_m2(), after.inertia.elements_kg_m2());
    let (s, t) = (before.sigma_kg_m2(), after.sigma_kg_m2());
    let is_moved = |i: usize| (a[i] - b[i]).abs() > MOVED_SIGMAS * s[i].max(t[i]);
    let has_none = |estimate: &Estimate<f64>| estimate.observed.directions == 0;
    after.status == Status::Diverged
        || has_none(after) && !has_none(before)
        || after.residuals_white == Some(false)
        || (0..6).any(is_moved)
}
