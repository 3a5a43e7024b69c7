//! Minimisation of an objective within its limits, from one start: rounds of L-BFGS (crate `argmin`) on the
//! augmented Lagrangian.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};

use argmin::core::{CostFunction, Error, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;

use super::limits::Kind;
use super::objective::{Evaluation, Lagrangian, Objective};

/// Vectors of the L-BFGS method.
const MEMORY: usize = 12;
/// Weight of the limits in the first round: a limit exceeded by a tenth (`c = 0.2`) at ten instants then costs
/// as much as a sigma larger by a fifth.
const FIRST_WEIGHT: f64 = 1.0;
/// Growth of the weight from round to round.
const GROWTH: f64 = 2.0;
/// Decrease of the function in one iteration at which a round ends.
const TOLERANCE: f64 = 1e-7;

/// Minimisation from one start.
pub(super) struct Minimisation<'a> {
    objective: &'a Objective<'a>,
    stop: &'a AtomicBool,
    lagrangian: Lagrangian,
    /// Variables at the end of the last round.
    pub variables: Vec<f64>,
    /// Kind of each limit with its multiplier, at the end of the last round.
    pub multipliers: Vec<(Kind, f64)>,
}

impl<'a> Minimisation<'a> {
    pub(super) fn new(
        objective: &'a Objective<'a>,
        stop: &'a AtomicBool,
        variables: Vec<f64>,
    ) -> Self {
        let lagrangian = Lagrangian { multipliers: Vec::new(), weight: FIRST_WEIGHT };
        Self { objective, stop, lagrangian, variables, multipliers: Vec::new() }
    }

    /// One round: L-BFGS with these multipliers, then new multipliers `λ ← max(0, λ + μ c)` and a larger weight.
    pub(super) fn round(&mut self, iterations: u64) {
        let best = RefCell::new(None);
        let function = Function {
            objective: self.objective,
            lagrangian: &self.lagrangian,
            stop: self.stop,
            last: RefCell::new(None),
            best: &best,
        };
        let start = self.variables.clone();
        let search = MoreThuenteLineSearch::new();
        let method = LBFGS::new(search, MEMORY).with_tolerance_cost(TOLERANCE);
        if let Ok(method) = method {
            // A line search that finds no lower value ends the round; the best point is kept.
            let _ = Executor::new(function, method)
                .configure(|state| state.param(start).max_iters(iterations))
                .run();
        }
        let Some((variables, evaluation)) = best.into_inner() else { return };
        self.variables = variables;
        self.update(&evaluation);
    }

    fn update(&mut self, evaluation: &Evaluation) {
        let Lagrangian { multipliers, weight } = &mut self.lagrangian;
        multipliers.resize(evaluation.limits.len(), 0.0);
        for (multiplier, (_, c)) in multipliers.iter_mut().zip(&evaluation.limits) {
            *multiplier = (*multiplier + *weight * c).max(0.0);
        }
        *weight *= GROWTH;
        let kinds = evaluation.limits.iter().map(|(kind, _)| *kind);
        self.multipliers = kinds.zip(multipliers.iter().copied()).collect();
    }
}

type Point = (Vec<f64>, Evaluation);
/// Variables, value and gradient of the last evaluation.
type Last = (Vec<f64>, f64, Vec<f64>);

/// The augmented Lagrangian as `argmin` asks for it: value and gradient one after the other, at the same point.
struct Function<'a> {
    objective: &'a Objective<'a>,
    lagrangian: &'a Lagrangian,
    stop: &'a AtomicBool,
    last: RefCell<Option<Last>>,
    /// Point of the lowest value.
    best: &'a RefCell<Option<Point>>,
}

impl Function<'_> {
    fn at(&self, variables: &[f64]) -> Result<(f64, Vec<f64>), Error> {
        if let Some((point, value, gradient)) = &*self.last.borrow()
            && point == variables
        {
            return Ok((*value, gradient.clone()));
        }
        if self.stop.load(Ordering::Relaxed) {
            return Err(Error::msg("stopped"));
        }
        let found = self.objective.evaluate(variables, self.lagrangian);
        let evaluation = found.ok_or_else(|| Error::msg("no covariance"))?;
        let (value, gradient) = (evaluation.value, evaluation.gradient.clone());
        *self.last.borrow_mut() = Some((variables.to_vec(), value, gradient.clone()));
        let is_better = self.best.borrow().as_ref().is_none_or(|(_, best)| value < best.value);
        if is_better {
            *self.best.borrow_mut() = Some((variables.to_vec(), evaluation));
        }
        Ok((value, gradient))
    }
}

impl CostFunction for Function<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, variables: &Self::Param) -> Result<f64, Error> {
        self.at(variables).map(|(value, _)| value)
    }
}

impl Gradient for Function<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, variables: &Self::Param) -> Result<Vec<f64>, Error> {
        self.at(variables).map(|(_, gradient)| gradient)
    }
}
