//! The objective of a design with its limits, as one function of the spline's variables, and its gradient.
//!
//! The objective is the mean over samples of the prior of the logarithm of the size of the covariance. The
//! limits enter by the augmented Lagrangian (Nocedal and Wright, *Numerical Optimization*, 2006, section
//! 17.4, for inequalities) with multipliers `λ ≥ 0` and weight `μ`:
//!
//! ```text
//! L(y) = f(y) + Σ μ/2 (max(0, c + λ/μ)² − (λ/μ)²)
//! ```

use nalgebra::DMatrix;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::columns::{Columns, Kind};
use super::command::{Command, Spline};
use super::information::{Covariance, Information};
use super::limits::{Kind as LimitKind, values};
use super::motion::{Model, Output, Seed};
use super::problem::Problem;
use crate::truth::bound::hardware::Error;

/// Sensitivities of a reading to all columns at one instant, 3 × columns.
pub(super) fn rows(columns: &Columns, output: &Output) -> DMatrix<f64> {
    let mut rows = DMatrix::zeros(3, columns.all.len());
    for (index, sensitivity) in output.sensitivities.iter().enumerate() {
        rows.column_mut(index).copy_from(sensitivity);
    }
    for (index, column) in columns.all.iter().enumerate().skip(columns.dynamic) {
        match column.kind {
            Kind::Bias(axis) => rows[(axis, index)] = 1.0,
            Kind::Hardware(Error::GyroScale(axis)) => rows[(axis, index)] = output.rate[axis],
            Kind::Hardware(Error::GyroAxes(row, other)) => rows[(row, index)] = output.rate[other],
            Kind::Hardware(Error::Delay) => {
                rows.column_mut(index).copy_from(&-output.acceleration);
            }
            _ => {}
        }
    }
    rows
}

/// Adjoint of [`rows`].
fn pull_rows(columns: &Columns, by_rows: &DMatrix<f64>, seed: &mut Seed) {
    for (index, sensitivity) in seed.sensitivities.iter_mut().enumerate() {
        *sensitivity += by_rows.column(index);
    }
    for (index, column) in columns.all.iter().enumerate().skip(columns.dynamic) {
        match column.kind {
            Kind::Hardware(Error::GyroScale(axis)) => seed.rate[axis] += by_rows[(axis, index)],
            Kind::Hardware(Error::GyroAxes(row, other)) => {
                seed.rate[other] += by_rows[(row, index)];
            }
            Kind::Hardware(Error::Delay) => seed.acceleration -= by_rows.column(index),
            _ => {}
        }
    }
}

/// Covariance after a command that is repeated this number of times, for one inertia.
pub(super) fn covariance(
    problem: &Problem,
    inertia_kg_m2: &[f64; 6],
    command: &Command,
    repeats: f64,
) -> Option<Covariance> {
    let model = problem.model(&problem.columns, inertia_kg_m2)?;
    let states = model.fly(command, problem.start(&model));
    let mut information = Information::new(&problem.columns);
    let times = repeats * command.step_s * problem.rate_hz;
    for (step, state) in states.iter().enumerate() {
        let output = model.output(state, command.momentum(2 * step), command.torque(step));
        information.add(&rows(&problem.columns, &output), times);
    }
    information.covariance(problem.noise_rad_s)
}

/// The function to be minimised.
pub(super) struct Objective<'a> {
    pub problem: &'a Problem,
    pub spline: &'a Spline,
    /// Unit of the torque of each wheel, N m, and of the level of each pair.
    pub scale: Vec<f64>,
    /// Number of times that the spline is flown.
    pub repeats: f64,
    /// Inertias of the objective.
    pub samples: Vec<[f64; 6]>,
    /// Inertias at which the limits hold.
    pub bounding: Vec<[f64; 6]>,
}

/// Multipliers of all limits and their weight.
#[derive(Clone, Debug)]
pub(super) struct Lagrangian {
    /// In the order of [`Evaluation::limits`]; empty for zero.
    pub multipliers: Vec<f64>,
    pub weight: f64,
}

/// Value, gradient, and the parts of the value.
pub(super) struct Evaluation {
    pub value: f64,
    pub gradient: Vec<f64>,
    /// Kind and `c` of each limit: by inertia, by instant.
    pub limits: Vec<(LimitKind, f64)>,
}

/// Value, derivatives by momentum and torque, and limits of one inertia.
struct Part {
    value: f64,
    by_momentum: Vec<f64>,
    by_torque: Vec<f64>,
    limits: Vec<(LimitKind, f64)>,
}

impl Objective<'_> {
    /// The function at these variables; none where the covariance is not a number.
    pub(super) fn evaluate(
        &self,
        variables: &[f64],
        lagrangian: &Lagrangian,
    ) -> Option<Evaluation> {
        let command = self.spline.command(variables, &self.scale, &self.problem.start_momentum());
        let share = 1.0 / self.samples.len() as f64;
        let tasks: Vec<(bool, usize)> = (0..self.samples.len())
            .map(|i| (true, i))
            .chain((0..self.bounding.len()).map(|i| (false, i)))
            .collect();
        let of = |&(is_sample, i): &(bool, usize)| match is_sample {
            true => self.size(&command, &self.samples[i], share),
            false => self.limits(&command, i, lagrangian),
        };
        // Collected in order, hence the same sum on any number of threads.
        let parts: Vec<Part> = tasks.par_iter().map(of).collect::<Option<_>>()?;
        let mut by_momentum = vec![0.0; (2 * command.steps + 1) * command.channels()];
        let mut by_torque = vec![0.0; (command.steps + 1) * command.channels()];
        for part in &parts {
            by_momentum.iter_mut().zip(&part.by_momentum).for_each(|(sum, x)| *sum += x);
            by_torque.iter_mut().zip(&part.by_torque).for_each(|(sum, x)| *sum += x);
        }
        Some(Evaluation {
            value: parts.iter().map(|part| part.value).sum(),
            gradient: self.spline.pull(
                &by_momentum,
                &by_torque,
                &self.scale,
                self.problem.wheels.len(),
            ),
            limits: parts.into_iter().flat_map(|part| part.limits).collect(),
        })
    }

    /// Logarithm of the size of the covariance, times `share`.
    fn size(&self, command: &Command, inertia_kg_m2: &[f64; 6], share: f64) -> Option<Part> {
        let (problem, columns) = (self.problem, &self.problem.columns);
        let model = problem.model(columns, inertia_kg_m2)?;
        let states = model.fly(command, problem.start(&model));
        let times = self.repeats * command.step_s * problem.rate_hz;
        let mut information = Information::new(columns);
        let all_rows: Vec<DMatrix<f64>> = (states.iter().enumerate())
            .map(|(k, state)| {
                rows(columns, &model.output(state, command.momentum(2 * k), command.torque(k)))
            })
            .collect();
        all_rows.iter().for_each(|rows| information.add(rows, times));
        let (value, by_f) = information.size(problem.noise_rad_s, problem.criterion)?;
        let by_f = by_f * (2.0 * times * share);
        let seeds: Vec<Seed> = all_rows
            .iter()
            .map(|rows| {
                let mut seed = Seed::zero(command.channels(), columns.dynamic);
                pull_rows(columns, &(rows * &by_f), &mut seed);
                seed
            })
            .collect();
        Some(pulled(&model, command, &states, &seeds, value * share, Vec::new()))
    }

    /// Terms of the limits at one inertia.
    fn limits(&self, command: &Command, index: usize, lagrangian: &Lagrangian) -> Option<Part> {
        let columns = Columns::none();
        let model = self.problem.model(&columns, &self.bounding[index])?;
        let states = model.fly(command, self.problem.start(&model));
        let (mut value, mut limits, mut seeds) = (0.0, Vec::new(), Vec::new());
        for (step, state) in states.iter().enumerate() {
            let output = model.output(state, command.momentum(2 * step), command.torque(step));
            let mut seed = Seed::zero(command.channels(), 0);
            for limit in values(self.problem, command, step, &output) {
                let at = index * self.limits_of_inertia(command) + limits.len();
                let multiplier = lagrangian.multipliers.get(at).copied().unwrap_or(0.0);
                let lead = multiplier / lagrangian.weight;
                let active = (limit.c + lead).max(0.0);
                value += 0.5 * lagrangian.weight * (active * active - lead * lead);
                limit.pull(self.problem, lagrangian.weight * active, &mut seed);
                limits.push((limit.kind, limit.c));
            }
            seeds.push(seed);
        }
        Some(pulled(&model, command, &states, &seeds, value, limits))
    }

    /// Number of limits of one inertia: those of each instant, and the return.
    fn limits_of_inertia(&self, command: &Command) -> usize {
        let Problem { wheels, pairs, limits, .. } = self.problem;
        let of_channels = 2 * wheels.len() + pairs.len();
        let each =
            of_channels + 1 + usize::from(limits.rate_rad_s.is_some()) + limits.keep_out.len();
        each * (command.steps + 1) + 1
    }
}

fn pulled(
    model: &Model<'_>,
    command: &Command,
    states: &[Vec<f64>],
    seeds: &[Seed],
    value: f64,
    limits: Vec<(LimitKind, f64)>,
) -> Part {
    let mut by_momentum = vec![0.0; (2 * command.steps + 1) * command.channels()];
    let mut by_torque = vec![0.0; (command.steps + 1) * command.channels()];
    model.pull(command, states, seeds, &mut by_momentum, &mut by_torque);
    Part { value, by_momentum, by_torque, limits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;
    use crate::input::scenario::{SimulatedThruster, TorqueProfile};
    use crate::manoeuvre::{Criterion, Effort, KeepOut, Limits, Request, Table, Treatment};
    use crate::truth::Flight;
    use flight_input::craft::Thruster;
    use nalgebra::Vector3;

    fn request(treatment: Treatment) -> Request {
        Request {
            duration_s: 24.0,
            limits: Limits {
                excursion_rad: 0.1,
                rate_rad_s: Some(0.03),
                torque_share: 1.0,
                momentum_share: 1.0,
                return_rad: 0.01,
                keep_out: vec![KeepOut {
                    boresight: Vector3::z(),
                    direction: Vector3::new(1.0, 0.3, 0.6).normalize(),
                    half_angle_rad: 0.5,
                }],
            },
            criterion: Criterion::A,
            treatment,
            uses_prior: true,
            seed: 0,
            effort: Effort::default(),
        }
    }

    /// A satellite at rest whose wheels have a momentum bias, with stated errors of every kind.
    fn scenario(speed_rad_s: f64) -> Scenario {
        let mut scenario = Scenario::load("microsat-slew-data-sheet").unwrap();
        scenario.control = None;
        for wheel in &mut scenario.wheels {
            wheel.wheel.limits.max_torque_n_m = Some(0.02);
            wheel.wheel.limits.max_speed_rad_s = Some(600.0);
            wheel.speed_rad_s = speed_rad_s;
        }
        scenario.hardware.common_spin_inertia_sigma = 0.01;
        scenario
    }

    /// The same with pairs of thrusters about two axes, their scale uncertain.
    fn with_thrusters(mut scenario: Scenario) -> Scenario {
        for torque in [[0.02, 0.003, 0.0], [0.0, 0.0, 0.01]] {
            for torque_n_m in [Vector3::from(torque), -Vector3::from(torque)] {
                let thruster = Thruster { torque_n_m, min_pulse_s: 0.1 };
                let on_s = Vec::new();
                scenario.torque.thrusters.push(SimulatedThruster { thruster, on_s });
            }
        }
        scenario.hardware.torque_scale_sigma = 0.02;
        scenario
    }

    fn variables(count: usize) -> Vec<f64> {
        (0..count).map(|i| 0.3 * (2.3 * i as f64 + 0.4).sin()).collect()
    }

    #[test]
    fn gradient_is_that_of_finite_differences() {
        let (wheels, both) = (scenario(100.0), with_thrusters(scenario(100.0)));
        let alone = Scenario { wheels: Vec::new(), ..with_thrusters(scenario(0.0)) };
        for (scenario, treatment, scale) in [
            (&wheels, Treatment::Considered, vec![0.02; 3]),
            (&wheels, Treatment::Solved, vec![0.02; 3]),
            (&both, Treatment::Considered, vec![0.02, 0.02, 0.02, 0.5, 0.7]),
            (&both, Treatment::Solved, vec![0.02, 0.02, 0.02, 0.5, 0.7]),
            (&alone, Treatment::Considered, vec![0.5, 0.7]),
        ] {
            let problem = Problem::new(scenario, &request(treatment)).unwrap();
            let spline = Spline::new(10, 2.4, false);
            let mut heavier = problem.prior.inertia_kg_m2;
            heavier[1] *= 1.1;
            let objective = Objective {
                problem: &problem,
                spline: &spline,
                scale: scale.clone(),
                repeats: 2.0,
                samples: vec![problem.prior.inertia_kg_m2, heavier],
                bounding: vec![heavier],
            };
            let y = variables(scale.len() * spline.variables());
            let mut lagrangian = Lagrangian { multipliers: Vec::new(), weight: 1e-3 };
            let first = objective.evaluate(&y, &lagrangian).unwrap();
            lagrangian.multipliers =
                (0..first.limits.len()).map(|i| 1e-4 * (i as f64).sin().max(0.0)).collect();
            let found = objective.evaluate(&y, &lagrangian).unwrap();
            for i in 0..y.len() {
                let at = |step: f64| {
                    let mut moved = y.clone();
                    moved[i] += step;
                    objective.evaluate(&moved, &lagrangian).unwrap().value
                };
                let step = 1e-5;
                let slope = (8.0 * (at(step) - at(-step)) - at(2.0 * step) + at(-2.0 * step))
                    / (12.0 * step);
                let largest = found.gradient.iter().fold(0.0f64, |most, x| most.max(x.abs()));
                let error = (slope - found.gradient[i]).abs();
                assert!(error < 1e-6 * largest, "{i}: {slope} {}", found.gradient[i]);
            }
        }
    }

    /// A command as a table of three rows a step.
    fn three_rows_a_step(command: &Command) -> Table {
        let row = |k: usize| -> Vec<f64> {
            let (from, part) = (k / 3, (k % 3) as f64 / 3.0);
            let to = (from + 1).min(command.steps);
            let (from, to) = (command.torque(from), command.torque(to));
            from.iter().zip(to).map(|(a, b)| a + part * (b - a)).collect()
        };
        let torque_n_m = (0..=3 * command.steps).map(row).collect();
        Table { step_s: command.step_s / 3.0, torque_n_m, level: Vec::new() }
    }

    /// The information of the design is that of the truth: bound of noise, of solved and of considered
    /// errors.
    #[test]
    fn covariance_is_the_bound_of_the_truth() {
        for speed_rad_s in [0.0, 100.0] {
            let mut scenario = scenario(speed_rad_s);
            scenario.duration_s = 24.0;
            let spline = Spline::new(10, 2.4, false);
            let y = variables(3 * spline.variables());
            let start: Vec<f64> = scenario
                .wheels
                .iter()
                .map(|w| w.wheel.spin_inertia_kg_m2 * w.speed_rad_s)
                .collect();
            let coarse = spline.command(&y, &[0.02; 3], &start);
            let table = three_rows_a_step(&coarse);
            assert!((table.step_s * scenario.gyro.rate_hz - 1.0).abs() < 1e-9);
            for (i, wheel) in scenario.wheels.iter_mut().enumerate() {
                wheel.torque = TorqueProfile::Table {
                    time_s: (0..table.torque_n_m.len()).map(|k| k as f64 * table.step_s).collect(),
                    value_n_m: table.torque_n_m.iter().map(|row| row[i]).collect(),
                };
            }
            let bound = Flight::simulate(&scenario).unwrap().bound.hardware.unwrap();
            for treatment in [Treatment::Considered, Treatment::Solved] {
                let request = Request { uses_prior: false, ..request(treatment) };
                let problem = Problem::new(&scenario, &request).unwrap();
                let command = table.command(&start);
                let inertia = problem.prior.inertia_kg_m2;
                let c = covariance(&problem, &inertia, &command, 1.0).unwrap();
                for i in 0..6 {
                    let sigma = c.total[(i, i)].sqrt() * problem.unit_kg_m2;
                    let expected = match treatment {
                        Treatment::Considered => bound.considered_kg_m2[i],
                        Treatment::Solved => bound.solved_kg_m2[i],
                    };
                    let Some(expected) = expected else { continue };
                    assert!((sigma / expected - 1.0).abs() < 1e-3, "{i}: {sigma} {expected}");
                }
            }
        }
    }
}
