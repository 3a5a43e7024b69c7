//! Exact scaling: the largest factor of a torque table that keeps every limit at every inertia of the
//! prior's [`extremes`](super::samples).

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::columns::Columns;
use super::command::Table;
use super::limits::{Kind, values};
use super::problem::Problem;

/// Share by which a limit is kept: what lies between two samples, between the inertias flown, and between the
/// Runge-Kutta method and the truth is below it (tested on random designs).
pub const MARGIN: f64 = 0.01;
/// Inertias of largest motion that the search flies; all are flown at the end.
const WORST: usize = 8;
/// Halvings of the factor's interval.
const HALVINGS: usize = 14;
/// Reduction of the factor when an inertia that the search left out exceeds a limit.
const REDUCTION: f64 = 0.995;
/// Reductions after which no factor is found.
const REDUCTIONS: usize = 40;

/// Largest `c` of each kind of limit, and the largest body rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Usage {
    largest: [f64; Kind::ALL.len()],
    /// Largest body rate, rad/s, whether it is limited or not.
    pub rate_rad_s: f64,
    /// Largest body rate at the end, rad/s.
    pub end_rate_rad_s: f64,
}

impl Usage {
    const NONE: Self = Self {
        largest: [f64::NEG_INFINITY; Kind::ALL.len()],
        rate_rad_s: 0.0,
        end_rate_rad_s: 0.0,
    };

    pub(super) fn and(self, other: &Self) -> Self {
        Self {
            largest: std::array::from_fn(|i| self.largest[i].max(other.largest[i])),
            rate_rad_s: self.rate_rad_s.max(other.rate_rad_s),
            end_rate_rad_s: self.end_rate_rad_s.max(other.end_rate_rad_s),
        }
    }

    /// Share of a limit that is used: 1 at the limit; none without such a limit. For a cone, one plus `c`.
    pub(super) fn share(&self, kind: Kind) -> Option<f64> {
        let c = self.largest[kind as usize];
        match kind {
            Kind::Cone => c.is_finite().then_some(1.0 + c),
            _ => c.is_finite().then(|| (1.0 + c).max(0.0).sqrt()),
        }
    }

    fn is_within(&self, checks_return: bool) -> bool {
        Kind::ALL.into_iter().all(|kind| {
            kind == Kind::Return && !checks_return
                || self.share(kind).is_none_or(|share| share <= 1.0 - MARGIN)
        })
    }
}

/// Usage of the limits by a table of pulses for one inertia. That of duty is left out.
fn usage(problem: &Problem, table: &Table, inertia_kg_m2: &[f64; 6]) -> Option<Usage> {
    let columns = Columns::none();
    let model = problem.model(&columns, inertia_kg_m2)?;
    let command = table.command(&problem.start_momentum());
    let mut usage = Usage::NONE;
    for (step, state) in model.fly(&command, problem.start(&model)).iter().enumerate() {
        let output = model.output(state, command.momentum(2 * step), command.torque(step));
        usage.end_rate_rad_s = output.rate.norm();
        usage.rate_rad_s = usage.rate_rad_s.max(usage.end_rate_rad_s);
        let values = values(problem, &command, step, &output).into_iter();
        for value in values.filter(|value| value.kind != Kind::Duty) {
            let largest = &mut usage.largest[value.kind as usize];
            // Not a number exceeds every limit.
            *largest = if value.c.is_nan() { f64::INFINITY } else { largest.max(value.c) };
        }
    }
    Some(usage)
}

/// Usage by a table, its levels rounded to pulses, for all inertias.
pub(super) fn usage_of_all(
    problem: &Problem,
    table: &Table,
    inertias: &[[f64; 6]],
) -> Option<Vec<Usage>> {
    let flown = problem.in_pulses(table);
    let duty = table.level.iter().flatten().fold(0.0f64, |most, level| most.max(level.abs()));
    let of = |inertia| {
        let mut usage = usage(problem, &flown, inertia)?;
        if !problem.pairs.is_empty() {
            usage.largest[Kind::Duty as usize] = duty * duty - 1.0;
        }
        Some(usage)
    };
    inertias.par_iter().map(of).collect()
}

/// A scaled table, and what it uses of the limits.
pub(super) struct Scaled {
    pub factor: f64,
    pub usage: Usage,
}

/// Largest factor within the limits; none if there is none. `checks_return` includes the rotation left at the
/// end.
pub(super) fn largest_factor(
    problem: &Problem,
    table: &Table,
    extremes: &[[f64; 6]],
    checks_return: bool,
) -> Option<Scaled> {
    let first = usage_of_all(problem, table, extremes)?;
    let worst = worst(&first, extremes);
    let is_within = |factor: f64| -> Option<bool> {
        let all = usage_of_all(problem, &table.scaled(factor), &worst)?;
        Some(all.iter().all(|usage| usage.is_within(checks_return)))
    };
    let (mut low, mut high) = (0.0, 1.0);
    while is_within(high)? {
        (low, high) = (high, 2.0 * high);
        if high > 1e12 {
            return None;
        }
    }
    for _ in 0..HALVINGS {
        let middle = if low == 0.0 { high / 8.0 } else { 0.5 * (low + high) };
        if is_within(middle)? { low = middle } else { high = middle }
    }
    for _ in 0..REDUCTIONS {
        let all = usage_of_all(problem, &table.scaled(low), extremes)?;
        let usage = all.iter().fold(Usage::NONE, |sum, usage| sum.and(usage));
        if low > 0.0 && usage.is_within(checks_return) {
            return Some(Scaled { factor: low, usage });
        }
        low *= REDUCTION;
    }
    None
}

/// Inertias with the largest use of any kind of limit: the mean, and the most used of each kind in turn.
pub(super) fn worst(usages: &[Usage], inertias: &[[f64; 6]]) -> Vec<[f64; 6]> {
    let mut chosen = vec![0];
    for rank in 0..inertias.len() {
        for kind in [Kind::Excursion, Kind::Rate, Kind::Cone, Kind::Momentum, Kind::Return] {
            let mut order: Vec<usize> = (0..usages.len()).collect();
            let c = |i: &usize| usages[*i].largest[kind as usize];
            order.sort_by(|a, b| c(b).total_cmp(&c(a)).then(a.cmp(b)));
            let is_new = chosen.len() < WORST && !chosen.contains(&order[rank]);
            if is_new && c(&order[rank]).is_finite() {
                chosen.push(order[rank]);
            }
        }
        if chosen.len() >= WORST.min(inertias.len()) {
            break;
        }
    }
    chosen.into_iter().map(|i| inertias[i]).collect()
}
