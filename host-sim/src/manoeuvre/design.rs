//! A design from start to end: grid, starts, minimisation, scaling, comparison.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::command::{STEPS_PER_KNOT, Spline, Table, b_spline};
use super::fixed;
use super::limits::Kind;
use super::objective::{Objective, covariance};
use super::optimise::Minimisation;
use super::problem::{DesignError, Problem, Request};
use super::scale::{Scaled, largest_factor, usage_of_all, worst};
use crate::input::Scenario;

/// Knots in one period of the motion that torque and excursion allow. More knots follow changes of sign of the
/// torque more closely: 8 knots cost 8 to 25 % of sigma (satellites of the benchmark), 16 gain nothing.
const KNOTS_PER_PERIOD: f64 = 12.0;
/// Fewest knots in a manoeuvre: 32 cost 3 % of sigma at an excursion of 20 deg, 16 cost 14 %.
const FEWEST_KNOTS: f64 = 48.0;
/// Fewest pulses of a thruster from knot to knot.
const PULSES_PER_KNOT: usize = 2;
/// Most knots in a pattern. A longer manoeuvre repeats its pattern.
const MOST_KNOTS: usize = 80;

/// Pattern of a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub knots: usize,
    pub samples_per_knot: usize,
    pub repeats: usize,
}

impl Grid {
    /// Knots short enough for the motion, and no shorter than the samples of a Runge-Kutta step each.
    ///
    /// The period is that of an oscillation whose amplitudes are the limits of torque and excursion,
    /// `2π √(θ/a)`, or of rate and excursion, `2π θ/ω`, whichever is longer.
    pub(super) fn new(problem: &Problem) -> Self {
        let j = problem.prior.inertia_kg_m2;
        let least = |of: &dyn Fn(&super::problem::DesignWheel, f64) -> f64| {
            let wheels = problem.wheels.iter().map(|wheel| {
                let moment: f64 = (0..3).map(|i| wheel.axis[i].powi(2) * j[i]).sum();
                of(wheel, moment)
            });
            wheels.fold(f64::INFINITY, f64::min)
        };
        let of_pair = |pair: &super::problem::Pair| {
            let norm = pair.torque_n_m.norm();
            let moment: f64 = (0..3).map(|i| (pair.torque_n_m[i] / norm).powi(2) * j[i]).sum();
            norm / moment
        };
        let acceleration = problem
            .pairs
            .iter()
            .map(of_pair)
            .fold(least(&|wheel, moment| wheel.max_torque_n_m / moment), f64::min);
        let by_momentum =
            least(&|wheel, moment| wheel.spin_inertia_kg_m2 * wheel.max_speed_rad_s / moment);
        let rate = by_momentum.min(problem.limits.rate_rad_s.unwrap_or(f64::INFINITY));
        let excursion = problem.limits.excursion_rad;
        let turns = (excursion / acceleration).sqrt().max(excursion / rate);
        let period_s = std::f64::consts::TAU * turns;
        let samples = (problem.duration_s * problem.rate_hz).round();
        let wanted = (period_s / KNOTS_PER_PERIOD * problem.rate_hz).min(samples / FEWEST_KNOTS);
        let pulse = problem.pairs.iter().map(|pair| pair.pulse_samples).max().unwrap_or(0);
        let least = (PULSES_PER_KNOT * pulse).div_ceil(STEPS_PER_KNOT).max(1);
        let samples_per_knot = STEPS_PER_KNOT * ((wanted as usize) / STEPS_PER_KNOT).max(least);
        let knots = samples as usize / samples_per_knot;
        let repeats = knots.div_ceil(MOST_KNOTS);
        Self { knots: knots / repeats, samples_per_knot, repeats }
    }

    fn knot_s(&self, problem: &Problem) -> f64 {
        self.samples_per_knot as f64 / problem.rate_hz
    }

    /// The spline, mirrored if the motion then returns for every inertia.
    fn spline(&self, problem: &Problem) -> Spline {
        Spline::new(self.knots, self.knot_s(problem), problem.is_without_momentum())
    }
}

/// A manoeuvre with its accuracy.
#[derive(Clone, Debug)]
pub struct Manoeuvre {
    /// Name.
    pub name: String,
    /// Torque of the wheels at the samples of the gyro.
    pub table: Table,
    /// Mean over the samples of the prior of the logarithm of the size of the covariance, which is in units
    /// of the mean moment.
    pub log_size: f64,
    /// Share of each limit used at the inertia where it is most used; none without such a limit.
    pub usage: Vec<(Kind, Option<f64>)>,
    /// Largest body rate, at the inertia where it is largest, rad/s.
    pub peak_rate_rad_s: f64,
    /// Largest body rate at the end, rad/s: of second order in the excursion with thrusters, without them zero.
    pub end_rate_rad_s: f64,
}

/// Result of a design.
#[derive(Clone, Debug)]
pub struct Design {
    /// The designed manoeuvre.
    pub best: Manoeuvre,
    /// Spline of the pattern, N m: coefficients of each wheel.
    pub coefficients_n_m: Vec<Vec<f64>>,
    /// Time between knots, s.
    pub knot_s: f64,
    /// Number of times that the pattern is flown.
    pub repeats: usize,
    /// Share of each kind of limit in what limits the design, largest first: its multipliers over those of all.
    pub limiting: Vec<(Kind, f64)>,
    /// Standard manoeuvres, best first. Those that observe nothing are last.
    pub fixed: Vec<Manoeuvre>,
    /// Cosines of the best frequency.
    pub tuned: Option<Manoeuvre>,
    /// Starts that were completed, of those asked for.
    pub starts: [usize; 2],
}

impl Design {
    /// Size of sigma of the best standard manoeuvre over that of the design.
    pub fn gain(&self) -> f64 {
        self.fixed.first().map_or(f64::INFINITY, |fixed| self.gain_over(fixed))
    }

    /// Size of sigma of a manoeuvre over that of the design.
    pub fn gain_over(&self, other: &Manoeuvre) -> f64 {
        (other.log_size - self.best.log_size).exp()
    }
}

/// Progress of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Rounds that were completed.
    pub done: usize,
    /// Rounds of all starts.
    pub of: usize,
    /// Gain of the best manoeuvre found over the best standard one.
    pub gain: f64,
}

/// Result of one start.
struct Found {
    variables: Vec<f64>,
    factor: f64,
    manoeuvre: Manoeuvre,
    limiting: Vec<(Kind, f64)>,
}

/// Parts that all starts share.
struct Search<'a> {
    problem: &'a Problem,
    objective: Objective<'a>,
    grid: Grid,
    extremes: Vec<[f64; 6]>,
    stop: &'a AtomicBool,
}

/// Designs a manoeuvre for the spacecraft of a scenario. Its own torques, controller and faults are left out.
///
/// The same request gives the same result on any number of threads. If `stop` is set, the search ends and
/// returns its best manoeuvre.
///
/// # Errors
/// See [`DesignError`].
pub fn design(
    scenario: &Scenario,
    request: &Request,
    stop: &AtomicBool,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Design, DesignError> {
    let problem = Problem::new(scenario, request)?;
    let extremes = problem.extremes(request.seed)?;
    let samples = problem.samples(request.effort.samples, request.seed)?;
    let bounding = bounding(&problem, &extremes).ok_or(DesignError::Nothing)?;
    let candidates = fixed_manoeuvres(&problem, &samples, &bounding);
    let unit = unit(candidates.first().ok_or(DesignError::Nothing)?);
    let grid = Grid::new(&problem);
    let spline = grid.spline(&problem);
    let objective = Objective {
        problem: &problem,
        spline: &spline,
        scale: (problem.wheels.iter().map(|wheel| unit * wheel.max_torque_n_m))
            .chain(problem.pairs.iter().map(|_| unit))
            .collect(),
        repeats: grid.repeats as f64,
        samples,
        bounding,
    };
    let search = Search { problem: &problem, objective, grid, extremes, stop };
    let starts = search.starts(&candidates, request);
    let (tuned, fixed): (Vec<Manoeuvre>, Vec<Manoeuvre>) =
        candidates.into_iter().partition(|of| of.name.starts_with(fixed::COSINES));
    let reference = fixed.first().map_or(f64::INFINITY, |fixed| fixed.log_size);
    let (found, completed) = search.run(&starts, request, reference, progress);
    let is_stopped = stop.load(Ordering::Relaxed);
    let none = if is_stopped { DesignError::Stopped } else { DesignError::Nothing };
    let found = found.ok_or(none)?;
    let coefficients_n_m = (0..problem.wheels.len())
        .map(|wheel| search.coefficients(&found.variables, wheel, found.factor))
        .collect();
    Ok(Design {
        coefficients_n_m,
        best: found.manoeuvre,
        knot_s: grid.knot_s(&problem),
        repeats: grid.repeats,
        limiting: found.limiting,
        fixed,
        tuned: tuned.into_iter().next(),
        starts: [completed, starts.len()],
    })
}

/// Unit of the torque over a wheel's limit, for variables of the size one: the share that the best fixed manoeuvre
/// uses. A small excursion takes a small share.
fn unit(best_fixed: &Manoeuvre) -> f64 {
    let used = |wanted: Kind| best_fixed.usage.iter().find(|(kind, _)| *kind == wanted)?.1;
    let largest = used(Kind::Torque).into_iter().chain(used(Kind::Duty)).fold(0.0, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// Inertias of largest motion: those of a rotation about each axis in turn.
fn bounding(problem: &Problem, extremes: &[[f64; 6]]) -> Option<Vec<[f64; 6]>> {
    let all = fixed::all(problem);
    let slews = all.iter().find(|fixed| fixed.name == fixed::SEQUENTIAL_SLEWS)?;
    let mean = &problem.prior.inertia_kg_m2;
    // The slews are scaled at the mean: the order of the inertias does not depend on the size of the motion.
    let factor = largest_factor(problem, &slews.table, &[*mean], false)?.factor;
    let usages = usage_of_all(problem, &slews.table.scaled(factor), extremes)?;
    Some(worst(&usages, extremes))
}

/// Fixed manoeuvres within the limits at these inertias, best first.
fn fixed_manoeuvres(
    problem: &Problem,
    samples: &[[f64; 6]],
    bounding: &[[f64; 6]],
) -> Vec<Manoeuvre> {
    let of = |fixed: &fixed::Fixed| {
        let scaled = largest_factor(problem, &fixed.table, bounding, false)?;
        let table = problem.in_pulses(&fixed.table.scaled(scaled.factor));
        Some(manoeuvre(problem, fixed.name.clone(), table, samples, &scaled))
    };
    let all: Vec<Option<Manoeuvre>> = fixed::all(problem).par_iter().map(of).collect();
    let mut all: Vec<Manoeuvre> = all.into_iter().flatten().collect();
    // The sort is stable: equal ones remain in the order of the list.
    all.sort_by(|a, b| a.log_size.total_cmp(&b.log_size));
    all
}

fn manoeuvre(
    problem: &Problem,
    name: String,
    table: Table,
    samples: &[[f64; 6]],
    scaled: &Scaled,
) -> Manoeuvre {
    let log_size = log_size(problem, &table, samples);
    let usage = Kind::ALL.into_iter().map(|kind| (kind, scaled.usage.share(kind))).collect();
    let peak_rate_rad_s = scaled.usage.rate_rad_s;
    let end_rate_rad_s = scaled.usage.end_rate_rad_s;
    Manoeuvre { name, table, log_size, usage, peak_rate_rad_s, end_rate_rad_s }
}

/// Mean over samples of the logarithm of the size of the covariance; infinite if one has none.
pub(super) fn log_size(problem: &Problem, table: &Table, samples: &[[f64; 6]]) -> f64 {
    let command = table.command(&problem.start_momentum());
    let of = |sample: &[f64; 6]| {
        let c = covariance(problem, sample, &command, 1.0)?;
        let size = problem.criterion.log_size(&c.total);
        size.is_finite().then_some(size)
    };
    let sizes: Option<Vec<f64>> = samples.par_iter().map(of).collect();
    sizes.map_or(f64::INFINITY, |sizes| sizes.iter().sum::<f64>() / samples.len() as f64)
}

impl Search<'_> {
    /// Variables at which the optimiser starts: the best fixed manoeuvres as splines, and random ones, each
    /// scaled to the limits; best first.
    fn starts(&self, fixed: &[Manoeuvre], request: &Request) -> Vec<Vec<f64>> {
        let spline = self.objective.spline;
        let mut candidates: Vec<Vec<f64>> = fixed
            .iter()
            .take(2 * request.effort.starts)
            .map(|fixed| self.fit(&fixed.table))
            .collect();
        let mut random = Pcg64::seed_from_u64(request.seed);
        let count = spline.variables() * self.problem.channels();
        for _ in 0..2 * request.effort.starts {
            candidates.push((0..count).map(|_| random.random::<f64>() - 0.5).collect());
        }
        let of = |variables: &Vec<f64>| {
            let (factor, found) = self.scaled(variables, &self.objective.bounding)?;
            let scaled = variables.iter().map(|x| x * factor).collect();
            Some((found.log_size, scaled))
        };
        let scaled: Vec<Option<(f64, Vec<f64>)>> = candidates.par_iter().map(of).collect();
        let mut scaled: Vec<(f64, Vec<f64>)> = scaled.into_iter().flatten().collect();
        scaled.sort_by(|a, b| a.0.total_cmp(&b.0));
        scaled.into_iter().take(request.effort.starts).map(|(_, variables)| variables).collect()
    }

    /// The first pattern of a table as variables.
    fn fit(&self, table: &Table) -> Vec<f64> {
        let spline = self.objective.spline;
        let per_step = self.grid.samples_per_knot / STEPS_PER_KNOT;
        let torque = |channel: usize| -> Vec<f64> {
            let wheels = self.problem.wheels.len();
            let (rows, column) = match channel < wheels {
                true => (&table.torque_n_m, channel),
                false => (&table.level, channel - wheels),
            };
            let row = |step: usize| rows.get(step * per_step);
            let scale = self.objective.scale[channel];
            let of = |step| row(step).map_or(0.0, |row| row[column] / scale);
            (0..=spline.steps).map(of).collect()
        };
        (0..self.problem.channels()).flat_map(|channel| spline.fit(&torque(channel))).collect()
    }

    /// Largest factor of these variables within the limits at these inertias, and the manoeuvre.
    fn scaled(&self, variables: &[f64], inertias: &[[f64; 6]]) -> Option<(f64, Manoeuvre)> {
        let whole = self.table(variables, self.grid.repeats);
        // A pattern that returns exactly repeats the same motion.
        let is_same = self.problem.is_without_momentum() && self.problem.pairs.is_empty();
        let flown = if is_same { &self.table(variables, 1) } else { &whole };
        let scaled = largest_factor(self.problem, flown, inertias, true)?;
        let factor = scaled.factor;
        let table = self.problem.in_pulses(&whole.scaled(factor));
        let name = "design".to_owned();
        let found = manoeuvre(self.problem, name, table, &self.objective.samples, &scaled);
        found.log_size.is_finite().then_some((factor, found))
    }

    /// B-spline coefficients of a channel: of a wheel, N m; of a pair, its level.
    fn coefficients(&self, variables: &[f64], channel: usize, factor: f64) -> Vec<f64> {
        let Objective { spline, scale, .. } = &self.objective;
        let own = &variables[channel * spline.variables()..][..spline.variables()];
        spline.coefficients(own).iter().map(|c| c * scale[channel] * factor).collect()
    }

    /// Table at the samples of the gyro, the pattern repeated, at rest to the end of the duration.
    fn table(&self, variables: &[f64], repeats: usize) -> Table {
        let (wheels, channels) = (self.problem.wheels.len(), self.problem.channels());
        let coefficients: Vec<Vec<f64>> =
            (0..channels).map(|channel| self.coefficients(variables, channel, 1.0)).collect();
        let Grid { knots, samples_per_knot, .. } = self.grid;
        let pattern = knots * samples_per_knot;
        let all = (self.problem.duration_s * self.problem.rate_hz).round() as usize;
        let rows = if repeats == self.grid.repeats { all } else { pattern * repeats };
        let row = |sample: usize| -> Vec<f64> {
            if sample >= pattern * repeats {
                return vec![0.0; channels];
            }
            let knot = (sample % pattern) as f64 / samples_per_knot as f64;
            let first = (knot as usize).saturating_sub(3);
            let of = |own: &Vec<f64>| {
                let near = own.iter().enumerate().skip(first).take(4);
                near.map(|(j, c)| c * b_spline(knot - j as f64)).sum()
            };
            coefficients.iter().map(of).collect()
        };
        let rows: Vec<Vec<f64>> = (0..=rows).map(row).collect();
        Table {
            step_s: 1.0 / self.problem.rate_hz,
            torque_n_m: rows.iter().map(|row| row[..wheels].to_vec()).collect(),
            level: rows.iter().map(|row| row[wheels..].to_vec()).collect(),
        }
    }

    /// Minimises from each start. Returns the best, and the number of starts completed.
    fn run(
        &self,
        starts: &[Vec<f64>],
        request: &Request,
        fixed_log_size: f64,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> (Option<Found>, usize) {
        let rounds = request.effort.rounds;
        let shown = Mutex::new(Progress { done: 0, of: rounds * starts.len(), gain: 0.0 });
        let show = |log_size: f64| {
            if let Ok(mut shown) = shown.lock() {
                shown.done += 1;
                shown.gain = shown.gain.max((fixed_log_size - log_size).exp());
                progress(*shown);
            }
        };
        let of = |start: &Vec<f64>| self.minimise(start.clone(), request, &show);
        let found: Vec<(Option<Found>, bool)> = starts.par_iter().with_max_len(1).map(of).collect();
        let completed = found.iter().filter(|(_, is_complete)| *is_complete).count();
        let best = found.into_iter().filter_map(|(found, _)| found).reduce(|best, other| {
            if other.manoeuvre.log_size < best.manoeuvre.log_size { other } else { best }
        });
        (best, completed)
    }

    /// Minimises from one start. Returns the best manoeuvre of its rounds, and true if all were completed.
    fn minimise(
        &self,
        start: Vec<f64>,
        request: &Request,
        show: &(dyn Fn(f64) + Sync),
    ) -> (Option<Found>, bool) {
        let mut minimisation = Minimisation::new(&self.objective, self.stop, start);
        let mut best: Option<Found> = None;
        for round in 0..=request.effort.rounds {
            let inertias = &self.objective.bounding;
            if let Some((factor, manoeuvre)) = self.scaled(&minimisation.variables, inertias)
                && best.as_ref().is_none_or(|b| manoeuvre.log_size < b.manoeuvre.log_size)
            {
                let variables = minimisation.variables.clone();
                let limiting = limiting(&minimisation.multipliers);
                best = Some(Found { variables, factor, manoeuvre, limiting });
            }
            if round > 0 {
                show(best.as_ref().map_or(f64::INFINITY, |b| b.manoeuvre.log_size));
            }
            if self.stop.load(Ordering::Relaxed) {
                return (self.proven(best), false);
            }
            if round < request.effort.rounds {
                minimisation.round(request.effort.iterations);
            }
        }
        (self.proven(best), true)
    }

    /// The same scaled to the limits at every extreme inertia.
    fn proven(&self, found: Option<Found>) -> Option<Found> {
        let found = found?;
        let (factor, manoeuvre) = self.scaled(&found.variables, &self.extremes)?;
        Some(Found { factor, manoeuvre, ..found })
    }
}

/// Multipliers of each kind over their sum. A multiplier is the change of the objective by its limit.
fn limiting(multipliers: &[(Kind, f64)]) -> Vec<(Kind, f64)> {
    let of = |wanted: Option<Kind>| -> f64 {
        let own =
            multipliers.iter().filter(|(kind, _)| wanted.is_none_or(|wanted| *kind == wanted));
        own.map(|(_, multiplier)| multiplier).sum()
    };
    let all = of(None).max(f64::MIN_POSITIVE);
    let mut shares: Vec<(Kind, f64)> =
        Kind::ALL.into_iter().map(|kind| (kind, of(Some(kind)) / all)).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    shares
}
