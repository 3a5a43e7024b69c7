//! Batch fit of a short record in double precision, started at the truth: the reference of what the
//! record contains.
//!
//! Maximum likelihood for white gyro noise of known sigma: Gauss-Newton over the raw samples, with
//! the rates predicted from the first instant on,
//!
//! ```text
//! Ḣ = τ + τ_d − ω × H,   ω = J⁻¹ (H − h_w(t)),   z = ω + b + ν
//! ```
//!
//! and the Jacobian by central differences. No code is shared with the estimators.
//!
//! | unknown | number |
//! |---|---|
//! | initial rate, rad/s | 3 |
//! | inertia `J`, kg m²; at the true trace where the scale is unobserved | 6 or 5 |
//! | torque `τ_d`, N m, if asked for | 3 |
//! | gyro bias `b`, rad/s, if asked for | 3 |
//!
//! Assumption: wheel speeds and torque are without error, and smooth between samples: `h_w` is a
//! cubic through four samples.

use host_sim::input::Scenario;
use host_sim::input::craft::SolveFor;
use host_sim::input::log::LogRow;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 40;
/// Largest number of halvings of one step.
const MAX_HALVINGS: usize = 12;
/// Newton decrement, in sigmas squared, below which the fit has converged.
const CONVERGED: f64 = 1e-8;
/// Step of the central differences, as a share of the scale of each unknown.
const DIFFERENCE: f64 = 1e-6;
/// Largest rotation per integration step, rad.
const STEP_RAD: f64 = 0.03;

/// The scale of the tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Observed, by wheels or torque.
    Observed,
    /// Unobserved: the trace is held at its true value.
    Unobserved,
}

/// Result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// `jxx jyy jzz jxy jxz jyz`, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each, kg m².
    pub sigma_kg_m2: [f64; 6],
}

/// Data of a fit, and the unknowns.
struct Problem<'a> {
    rows: &'a [LogRow],
    /// `h_w`, N m s, at each sample.
    wheel_momentum: Vec<Vector3<f64>>,
    noise_rad_s: f64,
    scale: Scale,
    /// Trace of the true tensor, kg m².
    trace: f64,
    solve_for: SolveFor,
}

/// Fit of a log from its truth; none where the iteration does not converge or an unknown is
/// unobserved. `rate_rad_s` is the true rate at the first sample.
pub fn fit(
    rows: &[LogRow],
    scenario: &Scenario,
    rate_rad_s: &Vector3<f64>,
    scale: Scale,
) -> Option<Fit> {
    let truth = scenario.spacecraft.inertia_kg_m2;
    let problem = Problem {
        rows,
        wheel_momentum: rows.iter().map(|row| wheel_momentum(scenario, row)).collect(),
        noise_rad_s: scenario.gyro.noise_rad_s,
        scale,
        trace: truth[..3].iter().sum(),
        solve_for: scenario.solve_for,
    };
    let (start, size) = problem.start(scenario, rate_rad_s, &truth);
    let (unknowns, factor) = problem.iterate(start, &size)?;
    problem.result(&unknowns, &factor, &size)
}

fn wheel_momentum(scenario: &Scenario, row: &LogRow) -> Vector3<f64> {
    let wheels = scenario.wheels.iter().zip(&row.wheel_speed_rad_s);
    wheels.map(|(w, speed)| w.wheel.axis * (w.wheel.spin_inertia_kg_m2 * speed)).sum()
}

impl Problem<'_> {
    /// Unknowns at the truth, and the scale of each.
    fn start(
        &self,
        scenario: &Scenario,
        rate: &Vector3<f64>,
        truth: &[f64; 6],
    ) -> (DVector<f64>, DVector<f64>) {
        let fastest = self.rows.iter().map(|row| row.rate_rad_s.norm()).fold(1e-3, f64::max);
        let mut start: Vec<f64> = rate.iter().copied().collect();
        let mut size = vec![fastest; 3];
        start.extend(self.elements_to_unknowns(truth));
        size.resize(start.len(), self.trace / 3.0);
        if self.solve_for.torque {
            start.extend(scenario.disturbance_torque_n_m.iter());
            size.extend([self.trace / 3.0 * fastest * fastest; 3]);
        }
        if self.solve_for.gyro_bias {
            start.extend(scenario.gyro.bias_rad_s.iter());
            size.extend([fastest; 3]);
        }
        (DVector::from_vec(start), DVector::from_vec(size))
    }

    /// Elements that are unknowns: without `jzz` where the trace is held.
    fn elements_to_unknowns(&self, j: &[f64; 6]) -> Vec<f64> {
        match self.scale {
            Scale::Observed => j.to_vec(),
            Scale::Unobserved => vec![j[0], j[1], j[3], j[4], j[5]],
        }
    }

    /// Elements as a function of the unknowns.
    fn elements(&self, x: &DVector<f64>) -> [f64; 6] {
        match self.scale {
            Scale::Observed => std::array::from_fn(|i| x[3 + i]),
            Scale::Unobserved => [x[3], x[4], self.trace - x[3] - x[4], x[5], x[6], x[7]],
        }
    }

    /// Gauss-Newton with halved steps: unknowns and triangular factor of the scaled Jacobian.
    fn iterate(
        &self,
        mut x: DVector<f64>,
        size: &DVector<f64>,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let mut residual = self.residual(&x)?;
        for _ in 0..MAX_ITERATIONS {
            let qr = self.jacobian(&x, size)?.qr();
            let (q, factor) = (qr.q(), qr.r());
            let step = factor.solve_upper_triangular(&(q.transpose() * &residual))?;
            let decrement = (&factor * &step).norm_squared();
            if !decrement.is_finite() {
                return None;
            }
            if decrement < CONVERGED {
                return Some((x, factor));
            }
            (x, residual) = self.halved_step(&x, &step.component_mul(size), &residual)?;
        }
        None
    }

    /// The largest of the halved steps that lowers the sum of squares.
    fn halved_step(
        &self,
        x: &DVector<f64>,
        step: &DVector<f64>,
        residual: &DVector<f64>,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        (0..MAX_HALVINGS).find_map(|halvings| {
            let candidate = x + step * 0.5f64.powi(halvings as i32);
            let found = self.residual(&candidate)?;
            (found.norm_squared() <= residual.norm_squared()).then_some((candidate, found))
        })
    }

    /// Derivative of the predictions, in sigmas, with respect to the scaled unknowns.
    fn jacobian(&self, x: &DVector<f64>, size: &DVector<f64>) -> Option<DMatrix<f64>> {
        let columns: Option<Vec<DVector<f64>>> = (0..x.len())
            .map(|i| {
                let mut shifted = x.clone();
                shifted[i] = x[i] + DIFFERENCE * size[i];
                let above = self.residual(&shifted)?;
                shifted[i] = x[i] - DIFFERENCE * size[i];
                Some((self.residual(&shifted)? - above) / (2.0 * DIFFERENCE))
            })
            .collect();
        Some(DMatrix::from_columns(&columns?))
    }

    /// Measured minus predicted rates, in sigmas; none for a tensor without inverse.
    fn residual(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        let inertia = matrix(&self.elements(x));
        let inverse = inertia.try_inverse()?;
        let (torque, bias) = self.disturbances(x);
        let mut momentum = inertia * vector(x, 0) + self.wheel_momentum[0];
        let mut residual = DVector::zeros(3 * self.rows.len());
        for (k, row) in self.rows.iter().enumerate() {
            if k > 0 {
                momentum = self.advance(k, momentum, &inverse, &torque);
            }
            let rate = inverse * (momentum - self.wheel_momentum[k]);
            let difference = (row.rate_rad_s - rate - bias) / self.noise_rad_s;
            residual.fixed_rows_mut::<3>(3 * k).copy_from(&difference);
        }
        residual.iter().all(|r| r.is_finite()).then_some(residual)
    }

    /// Torque, N m, and gyro bias, rad/s; zero where not asked for.
    fn disturbances(&self, x: &DVector<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let mut next = 3 + self.elements_to_unknowns(&[0.0; 6]).len();
        let mut take = |is_unknown: bool| {
            if !is_unknown {
                return Vector3::zeros();
            }
            next += 3;
            vector(x, next - 3)
        };
        (take(self.solve_for.torque), take(self.solve_for.gyro_bias))
    }

    /// Momentum at sample `k` from that at the sample before, N m s, by Runge-Kutta steps of fourth
    /// order.
    fn advance(
        &self,
        k: usize,
        mut momentum: Vector3<f64>,
        inverse: &Matrix3<f64>,
        disturbance: &Vector3<f64>,
    ) -> Vector3<f64> {
        let (from, to) = (&self.rows[k - 1], &self.rows[k]);
        let time_s = (to.time_us - from.time_us) as f64 * 1e-6;
        let slope = |share: f64, h: Vector3<f64>| {
            let torque = from.torque_n_m.lerp(&to.torque_n_m, share) + disturbance;
            torque + h.cross(&(inverse * (h - self.wheel_momentum_within(k, share))))
        };
        let rate = inverse * (momentum - self.wheel_momentum[k - 1]);
        let steps = (rate.norm() * time_s / STEP_RAD).ceil().clamp(1.0, 100.0);
        let (step, step_s) = (1.0 / steps, time_s / steps);
        for i in 0..steps as u32 {
            let share = f64::from(i) * step;
            let a = slope(share, momentum);
            let b = slope(share + step / 2.0, momentum + a * (step_s / 2.0));
            let c = slope(share + step / 2.0, momentum + b * (step_s / 2.0));
            let d = slope(share + step, momentum + c * step_s);
            momentum += (a + (b + c) * 2.0 + d) * (step_s / 6.0);
        }
        momentum
    }

    /// `h_w` at this share of the interval that ends at sample `k`, N m s: Lagrange's cubic through
    /// the four nearest samples.
    fn wheel_momentum_within(&self, k: usize, share: f64) -> Vector3<f64> {
        let h = &self.wheel_momentum;
        if h.len() < 4 {
            return h[k - 1].lerp(&h[k], share);
        }
        let first = k.saturating_sub(2).min(h.len() - 4);
        let t = (k - 1 - first) as f64 + share;
        let weight = |i: usize| -> f64 {
            (0..4).filter(|j| *j != i).map(|j| (t - j as f64) / (i as f64 - j as f64)).product()
        };
        (0..4).map(|i| h[first + i] * weight(i)).sum()
    }

    /// Elements and sigmas.
    fn result(&self, x: &DVector<f64>, factor: &DMatrix<f64>, size: &DVector<f64>) -> Option<Fit> {
        let identity = DMatrix::identity(x.len(), x.len());
        let inverse = factor.solve_upper_triangular(&identity)?;
        let covariance = DMatrix::from_diagonal(size) * &inverse * inverse.transpose();
        let covariance = covariance * DMatrix::from_diagonal(size);
        let mut selection = DMatrix::zeros(6, x.len());
        for unknown in 0..x.len() {
            let mut unit = DVector::zeros(x.len());
            unit[unknown] = 1.0;
            let (at, origin) = (self.elements(&unit), self.elements(&DVector::zeros(x.len())));
            for i in 0..6 {
                selection[(i, unknown)] = at[i] - origin[i];
            }
        }
        let elements = &selection * covariance * selection.transpose();
        let sigma_kg_m2: [f64; 6] = std::array::from_fn(|i| elements[(i, i)].max(0.0).sqrt());
        let is_finite = sigma_kg_m2.iter().all(|sigma| sigma.is_finite());
        is_finite.then(|| Fit { inertia_kg_m2: self.elements(x), sigma_kg_m2 })
    }
}

fn vector(x: &DVector<f64>, first: usize) -> Vector3<f64> {
    Vector3::new(x[first], x[first + 1], x[first + 2])
}

fn matrix(j: &[f64; 6]) -> Matrix3<f64> {
    Matrix3::new(j[0], j[3], j[4], j[3], j[1], j[5], j[4], j[5], j[2])
}
