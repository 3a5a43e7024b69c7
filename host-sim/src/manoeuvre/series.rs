//! A manoeuvre over time, and its accuracy at the end, for the expected inertia.

use flight_input::inertia::tensor;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::design::Manoeuvre;
use super::information::{Covariance, Information};
use super::objective::rows;
use super::problem::{DesignError, Problem, Request};
use crate::campaign::MAX_OBSERVED_SHARE;
use crate::input::Scenario;

/// Most rows of a series.
const MOST_ROWS: usize = 600;

/// State and accuracy at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesRow {
    /// Time since the start, s.
    pub time_s: f64,
    /// Torque of each motor on its wheel, N m.
    pub torque_n_m: Vec<f64>,
    /// Speed of each wheel relative to the body, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Body rate, rad/s.
    pub rate_rad_s: [f64; 3],
    /// Rotation from the attitude at the start, rad.
    pub excursion_rad: f64,
    /// One sigma of each element from the data up to this time, kg m²; none where it is not finite.
    pub sigma_kg_m2: Option<[f64; 6]>,
    /// Directions with a sigma below a tenth of the mean moment.
    pub observed_directions: usize,
}

/// Accuracy before and after a manoeuvre.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// Expected inertia, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of the prior, kg m²; none if the inertia is known.
    pub before_kg_m2: Option<[f64; 6]>,
    /// One sigma after the manoeuvre, kg m².
    pub after_kg_m2: [f64; 6],
    /// Part of it without considered errors of the hardware.
    pub random_kg_m2: [f64; 6],
    /// One sigma of the direction of each principal axis, ascending moments, rad; none above a quarter turn.
    pub axes_before_rad: [Option<f64>; 3],
    /// The same after the manoeuvre.
    pub axes_after_rad: [Option<f64>; 3],
    /// Time at which the first, second, … sixth direction has a sigma below a tenth of the mean moment, s; none if
    /// it never has.
    pub observed_s: [Option<f64>; 6],
}

/// Series of a manoeuvre, at most 600 rows, the last at its end.
///
/// # Errors
/// See [`DesignError`].
pub fn series(
    scenario: &Scenario,
    request: &Request,
    manoeuvre: &Manoeuvre,
) -> Result<Vec<SeriesRow>, DesignError> {
    let problem = Problem::new(scenario, request)?;
    let mut series = Vec::new();
    walk(&problem, manoeuvre, |row, _| series.push(row)).ok_or(DesignError::Nothing)?;
    Ok(series)
}

/// Accuracy of a manoeuvre.
///
/// # Errors
/// See [`DesignError`].
pub fn accuracy(
    scenario: &Scenario,
    request: &Request,
    manoeuvre: &Manoeuvre,
) -> Result<Accuracy, DesignError> {
    let problem = Problem::new(scenario, request)?;
    let mut observed_s = [None; 6];
    let mut last: Option<Covariance> = None;
    walk(&problem, manoeuvre, |row, covariance| {
        let newly = observed_s.iter_mut().take(row.observed_directions);
        newly.for_each(|time_s| *time_s = time_s.or(Some(row.time_s)));
        last = covariance;
    })
    .ok_or(DesignError::Nothing)?;
    let Covariance { random, total } = last.ok_or(DesignError::Nothing)?;
    let prior = &problem.prior;
    let j = tensor(&prior.inertia_kg_m2);
    let before = Matrix6::from_diagonal(&Vector6::from(prior.sigma_kg_m2).map(|s| s * s));
    let unit = problem.unit_kg_m2;
    Ok(Accuracy {
        inertia_kg_m2: prior.inertia_kg_m2,
        before_kg_m2: (!problem.is_known()).then_some(prior.sigma_kg_m2),
        after_kg_m2: sigmas(&total, unit),
        random_kg_m2: sigmas(&random, unit),
        axes_before_rad: if problem.is_known() { [None; 3] } else { axes(&j, &before) },
        axes_after_rad: axes(&j, &(total * (unit * unit))),
        observed_s,
    })
}

/// Calls `each` with up to [`MOST_ROWS`] rows and their covariance; none if the motion has none.
fn walk(
    problem: &Problem,
    manoeuvre: &Manoeuvre,
    mut each: impl FnMut(SeriesRow, Option<Covariance>),
) -> Option<()> {
    let model = problem.model(&problem.columns, &problem.prior.inertia_kg_m2)?;
    let command = manoeuvre.table.command(&problem.start_momentum());
    let states = model.fly(&command, problem.start(&model));
    let mut information = Information::new(&problem.columns);
    let stride = states.len().div_ceil(MOST_ROWS);
    let start = problem.attitude.quaternion().conjugate();
    for (step, state) in states.iter().enumerate() {
        let momentum = command.momentum(2 * step);
        let output = model.output(state, momentum, command.torque(step));
        information.add(&rows(&problem.columns, &output), command.step_s * problem.rate_hz);
        if step % stride != 0 && step != command.steps {
            continue;
        }
        let covariance = information.covariance(problem.noise_rad_s);
        let total = covariance.as_ref().map(|covariance| &covariance.total);
        let [w, x, y, z] = output.attitude;
        let turned = (start * nalgebra::Quaternion::new(w, x, y, z)).imag().norm();
        let speeds = problem.wheels.iter().zip(momentum);
        let row = SeriesRow {
            time_s: step as f64 * command.step_s,
            torque_n_m: command.torque(step).to_vec(),
            wheel_speed_rad_s: speeds
                .map(|(wheel, h)| h / wheel.spin_inertia_kg_m2 - wheel.axis.dot(&output.rate))
                .collect(),
            rate_rad_s: output.rate.into(),
            excursion_rad: 2.0 * turned.min(1.0).asin(),
            sigma_kg_m2: total.map(|total| sigmas(total, problem.unit_kg_m2)),
            observed_directions: total.map_or(0, observed),
        };
        each(row, covariance);
    }
    Some(())
}

fn sigmas(covariance: &Matrix6<f64>, unit_kg_m2: f64) -> [f64; 6] {
    std::array::from_fn(|i| covariance[(i, i)].max(0.0).sqrt() * unit_kg_m2)
}

fn observed(covariance: &Matrix6<f64>) -> usize {
    let variances = covariance.symmetric_eigenvalues();
    variances.iter().filter(|v| v.max(0.0).sqrt() < MAX_OBSERVED_SHARE).count()
}

/// One sigma of the direction of each principal axis: with the axes `v` and moments `J`, to first order a
/// change `δJ` turns axis i by `vⱼ · δJ vᵢ / (Jᵢ − Jⱼ)` towards each other axis j.
fn axes(j: &Matrix3<f64>, covariance_kg2_m4: &Matrix6<f64>) -> [Option<f64>; 3] {
    let eigen = j.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let axis = |i: usize| -> Vector3<f64> { eigen.eigenvectors.column(i).into_owned() };
    let variance = |i: usize, k: usize| {
        let (a, b) = (axis(i), axis(k));
        let by = Vector6::new(
            a.x * b.x,
            a.y * b.y,
            a.z * b.z,
            a.x * b.y + a.y * b.x,
            a.x * b.z + a.z * b.x,
            a.y * b.z + a.z * b.y,
        );
        let gap = eigen.eigenvalues[i] - eigen.eigenvalues[k];
        by.dot(&(covariance_kg2_m4 * by)) / (gap * gap)
    };
    order.map(|i| {
        let others = (0..3).filter(|k| *k != i);
        let sigma = others.map(|k| variance(i, k)).sum::<f64>().sqrt();
        (sigma < std::f64::consts::FRAC_PI_2).then_some(sigma)
    })
}
