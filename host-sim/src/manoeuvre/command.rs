//! A commanded manoeuvre on a grid, from a spline or a table: torque and axial momentum of the wheels, level of the
//! pairs of thrusters.
//!
//! The channels are the wheels, then the pairs. The level of a pair is its mean torque over that of its first
//! thruster: 1 for the first on, −1 for the second on.

use nalgebra::{DMatrix, DVector};

/// Channels on a grid of equal steps. Momentum and level are given at half steps too.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Command {
    pub step_s: f64,
    pub steps: usize,
    channels: usize,
    /// Axial momentum `hᵢ` of a wheel, N m s, or level of a pair, by half step and channel.
    momentum: Vec<f64>,
    /// Torque of the motor on a wheel, N m, or level of a pair, by step and channel.
    torque: Vec<f64>,
}

impl Command {
    pub(super) fn momentum(&self, half_step: usize) -> &[f64] {
        &self.momentum[half_step * self.channels..][..self.channels]
    }

    pub(super) fn torque(&self, step: usize) -> &[f64] {
        &self.torque[step * self.channels..][..self.channels]
    }

    pub(super) fn channels(&self) -> usize {
        self.channels
    }
}

/// Torques at equal steps, linear in between, as the scenario and the flight computer play them.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Time between two rows, s.
    pub step_s: f64,
    /// Torque of each motor on its wheel, N m, one row a step.
    pub torque_n_m: Vec<Vec<f64>>,
    /// Level of each pair of thrusters, one row a step: 1 for the first thruster on, −1 for the second, 0 for none. A
    /// change between two rows stands for a switch halfway, which has the same impulse.
    pub level: Vec<Vec<f64>>,
}

impl Table {
    /// The same times a factor.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let row = |row: &Vec<f64>| row.iter().map(|torque| torque * factor).collect();
        Self {
            step_s: self.step_s,
            torque_n_m: self.torque_n_m.iter().map(row).collect(),
            level: self.level.iter().map(row).collect(),
        }
    }

    /// The command with this momentum of the wheels at the start, N m s: the integral of the lines
    /// between the rows.
    pub(super) fn command(&self, start: &[f64]) -> Command {
        let (wheels, step_s) = (start.len(), self.step_s);
        let steps = self.torque_n_m.len().saturating_sub(1);
        let level = |row: usize| self.level.get(row).map_or(&[][..], Vec::as_slice);
        let channels = wheels + level(0).len();
        let mut momentum = [start, level(0)].concat();
        let mut now = start.to_vec();
        for (row, pair) in self.torque_n_m.windows(2).enumerate() {
            let (from, to) = (&pair[0], &pair[1]);
            for i in 0..wheels {
                momentum.push(now[i] + step_s * (3.0 * from[i] + to[i]) / 8.0);
            }
            momentum.extend(level(row).iter().zip(level(row + 1)).map(|(a, b)| (a + b) / 2.0));
            for i in 0..wheels {
                now[i] += step_s * (from[i] + to[i]) / 2.0;
                momentum.push(now[i]);
            }
            momentum.extend(level(row + 1));
        }
        let rows = self.torque_n_m.iter().enumerate();
        let torque = rows.flat_map(|(row, wheels)| wheels.iter().chain(level(row))).copied();
        Command { step_s, steps, channels, momentum, torque: torque.collect() }
    }
}

/// Parametrisation of the torque of a wheel, or of the level of a pair: a cubic spline on equal knots.
///
/// Only the B-splines with their whole support inside the manoeuvre are used, so that torque, its slope
/// and its curvature are zero at both ends. The coefficients are confined to the subspace of
/// `∫ u dt = 0`, by which the momentum returns, and `∫∫ u dt² = 0`, by which the rotation vanishes to
/// first order.
///
/// A mirrored spline has `u(T − t) = u(t)`, hence `h(T − t) = −h(t)` about its start. From rest without
/// total momentum, `ω = −J_b⁻¹ Σ hᵢ aᵢ` at every instant, so that the body retraces its path in the second
/// half: rate and attitude return for every inertia.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    pub step_s: f64,
    pub steps: usize,
    /// Torque at the steps, torque and momentum at the half steps, by variable.
    torque: DMatrix<f64>,
    half_torque: DMatrix<f64>,
    momentum: DMatrix<f64>,
    /// B-spline coefficients by variable.
    coefficients: DMatrix<f64>,
}

/// Steps of the integration from knot to knot: a cubic over eight steps of the Runge-Kutta method, whose
/// error is far below that of the gyro (tested).
pub(super) const STEPS_PER_KNOT: usize = 8;
/// Eigenvalue of `LᵀL` over its trace below which a direction satisfies the constraints `L c = 0`.
const NULL_SHARE: f64 = 1e-12;

/// Cardinal cubic B-spline with support `[0, 4)`, sum of all shifts 1.
pub(super) fn b_spline(x: f64) -> f64 {
    let y = (x - 2.0).abs();
    match y {
        ..1.0 => 2.0 / 3.0 - y * y + 0.5 * y * y * y,
        1.0..2.0 => (2.0 - y).powi(3) / 6.0,
        _ => 0.0,
    }
}

impl Spline {
    /// A spline over this number of knot intervals of this length, s.
    pub(super) fn new(intervals: usize, knot_s: f64, is_mirrored: bool) -> Self {
        let splines = intervals.saturating_sub(3);
        let coefficients = null_space(splines, is_mirrored);
        let (steps, step_s) = (intervals * STEPS_PER_KNOT, knot_s / STEPS_PER_KNOT as f64);
        let at = |half_steps: f64, spline: usize| {
            b_spline(half_steps / (2 * STEPS_PER_KNOT) as f64 - spline as f64)
        };
        let torque = DMatrix::from_fn(steps + 1, splines, |k, j| at(2.0 * k as f64, j));
        let half_torque = DMatrix::from_fn(2 * steps + 1, splines, |k, j| at(k as f64, j));
        let mut momentum = DMatrix::zeros(2 * steps + 1, splines);
        for j in 0..splines {
            for k in 0..2 * steps {
                // Simpson's rule is exact for the cubic between two half steps.
                let from = k as f64;
                let sum = at(from, j) + 4.0 * at(from + 0.5, j) + at(from + 1.0, j);
                momentum[(k + 1, j)] = momentum[(k, j)] + 0.5 * step_s / 6.0 * sum;
            }
        }
        Self {
            step_s,
            steps,
            torque: torque * &coefficients,
            half_torque: half_torque * &coefficients,
            momentum: momentum * &coefficients,
            coefficients,
        }
    }

    /// Variables of a wheel.
    pub(super) fn variables(&self) -> usize {
        self.coefficients.ncols()
    }

    /// B-spline coefficients of a wheel.
    pub(super) fn coefficients(&self, variables: &[f64]) -> Vec<f64> {
        (&self.coefficients * DVector::from_column_slice(variables)).as_slice().to_vec()
    }

    /// Variables whose spline is nearest to these torques at the steps.
    pub(super) fn fit(&self, torque: &[f64]) -> Vec<f64> {
        let target = DVector::from_column_slice(torque);
        let normal = self.torque.tr_mul(&self.torque);
        let side = self.torque.tr_mul(&target);
        normal.cholesky().map_or_else(
            || vec![0.0; self.variables()],
            |factor| factor.solve(&side).as_slice().to_vec(),
        )
    }

    /// The command of the variables of all channels, one after the other, in units of `scale`, N m for a wheel; `start`
    /// is the momentum of the wheels at the start, and the channels beyond are pairs.
    pub(super) fn command(&self, variables: &[f64], scale: &[f64], start: &[f64]) -> Command {
        let channels = scale.len();
        let mut momentum = vec![0.0; (2 * self.steps + 1) * channels];
        let mut torque = vec![0.0; (self.steps + 1) * channels];
        for channel in 0..channels {
            let own = self.of_channel(variables, channel) * scale[channel];
            let at_start = start.get(channel).copied().unwrap_or(0.0);
            for (k, value) in (self.halves(channel, start.len()) * &own).iter().enumerate() {
                momentum[k * channels + channel] = at_start + value;
            }
            for (k, value) in (&self.torque * &own).iter().enumerate() {
                torque[k * channels + channel] = *value;
            }
        }
        Command { step_s: self.step_s, steps: self.steps, channels, momentum, torque }
    }

    /// Momentum of a wheel, level of a pair, at the half steps.
    fn halves(&self, channel: usize, wheels: usize) -> &DMatrix<f64> {
        if channel < wheels { &self.momentum } else { &self.half_torque }
    }

    fn of_channel(&self, variables: &[f64], channel: usize) -> DVector<f64> {
        let count = self.variables();
        DVector::from_column_slice(&variables[channel * count..][..count])
    }

    /// Derivatives by the variables from those by momentum and torque of a [`Self::command`].
    pub(super) fn pull(
        &self,
        by_momentum: &[f64],
        by_torque: &[f64],
        scale: &[f64],
        wheels: usize,
    ) -> Vec<f64> {
        let channels = scale.len();
        let mut gradient = Vec::with_capacity(channels * self.variables());
        for channel in 0..channels {
            let of = |all: &[f64]| {
                let own: Vec<f64> = all.iter().skip(channel).step_by(channels).copied().collect();
                DVector::from_vec(own)
            };
            let halves = self.halves(channel, wheels).tr_mul(&of(by_momentum));
            let sum = halves + self.torque.tr_mul(&of(by_torque));
            gradient.extend((sum * scale[channel]).iter());
        }
        gradient
    }
}

/// Orthonormal basis of the coefficients with `∫ u dt = 0` and `∫∫ u dt² = 0`, mirrored if asked for.
fn null_space(splines: usize, is_mirrored: bool) -> DMatrix<f64> {
    let middle = (splines as f64 - 1.0) / 2.0;
    let mut rows = vec![DVector::repeat(splines, 1.0)];
    rows.push(DVector::from_fn(splines, |j, _| (j as f64 - middle) / middle.max(1.0)));
    if is_mirrored {
        rows.extend((0..splines / 2).map(|j| {
            let mut row = DVector::zeros(splines);
            (row[j], row[splines - 1 - j]) = (1.0, -1.0);
            row
        }));
    }
    let normal =
        rows.iter().fold(DMatrix::zeros(splines, splines), |sum, row| sum + row * row.transpose());
    let limit = NULL_SHARE * normal.trace();
    let eigen = normal.symmetric_eigen();
    let free: Vec<usize> = (0..splines).filter(|i| eigen.eigenvalues[*i].abs() < limit).collect();
    eigen.eigenvectors.select_columns(&free)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn momentum_and_its_integral_return_and_the_table_keeps_both() {
        for is_mirrored in [false, true] {
            let spline = Spline::new(20, 0.8, is_mirrored);
            let variables: Vec<f64> =
                (0..spline.variables()).map(|i| (1.0 + i as f64).sin()).collect();
            let command = spline.command(&variables, &[0.3], &[0.1]);
            let rows: Vec<Vec<f64>> =
                (0..=command.steps).map(|k| command.torque(k).to_vec()).collect();
            let step_s = command.step_s;
            let table = Table { step_s, torque_n_m: rows, level: Vec::new() }.command(&[0.1]);
            for command in [&command, &table] {
                let end = command.momentum(2 * command.steps)[0];
                assert!((end - 0.1).abs() < 1e-12, "{end}");
                let half = command.step_s / 2.0;
                // Simpson's rule from step to step.
                let integral: f64 = (0..command.steps)
                    .map(|k| {
                        let h = |i| command.momentum(2 * k + i)[0] - 0.1;
                        (h(0) + 4.0 * h(1) + h(2)) * half / 3.0
                    })
                    .sum();
                assert!(integral.abs() < 1e-9, "{integral}");
            }
            if is_mirrored {
                for k in 0..=command.steps {
                    let mirror = command.torque(command.steps - k)[0];
                    assert!((command.torque(k)[0] - mirror).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn fit_of_a_spline_is_that_spline() {
        let spline = Spline::new(12, 0.5, false);
        let variables: Vec<f64> = (0..spline.variables()).map(|i| (1.7 * i as f64).cos()).collect();
        let command = spline.command(&variables, &[1.0], &[0.0]);
        let torque: Vec<f64> = (0..=command.steps).map(|k| command.torque(k)[0]).collect();
        let found = spline.fit(&torque);
        assert!(variables.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
