//! Balance of the momentum of body and wheels over intervals of a log, and its fit over the inertia.

use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

use super::step_s;
use crate::input::Craft;
use crate::input::log::LogRow;

/// Share of the intervals with the largest residuals that is left out, for spikes.
const TRIMMED: f64 = 0.1;
/// Longest interval between rows that is integrated across, median intervals.
const MAX_STEP: f64 = 3.0;

/// Change of momentum over one interval, linear in the elements of `J`.
pub(super) struct Change {
    /// `ω_b − ω_a` and `∫ ω × (J ω) dt` by element of `J`.
    rate: Matrix3x6<f64>,
    product: Matrix3x6<f64>,
    /// `h_b − h_a`, `∫ ω × h dt` and `∫ τ dt`, N m s.
    wheels: Vector3<f64>,
    wheel_product: Vector3<f64>,
    torque: Vector3<f64>,
}

impl Change {
    /// Zero, from this row on.
    fn zero() -> Self {
        Self {
            rate: Matrix3x6::zeros(),
            product: Matrix3x6::zeros(),
            wheels: Vector3::zeros(),
            wheel_product: Vector3::zeros(),
            torque: Vector3::zeros(),
        }
    }

    /// Adds the step from one row to the next, by the trapezoidal rule.
    fn add(&mut self, craft: &Craft, from: &LogRow, to: &LogRow) {
        let half_s = 0.5 * step_s(from, to);
        self.rate += of_elements(&(to.rate_rad_s - from.rate_rad_s));
        self.wheels += momentum(craft, to) - momentum(craft, from);
        for row in [from, to] {
            let rate = row.rate_rad_s;
            self.product += rate.cross_matrix() * of_elements(&rate) * half_s;
            self.wheel_product += rate.cross(&momentum(craft, row)) * half_s;
            self.torque += row.torque_n_m * half_s;
        }
    }

    /// Matrix of `J` and constant part of the balance with these factors.
    fn balance(&self, [product, torque]: [f64; 2]) -> (Matrix3x6<f64>, Vector3<f64>) {
        let of_inertia = self.rate + self.product * product;
        (of_inertia, self.wheels + self.wheel_product * product - self.torque * torque)
    }
}

/// Changes over at most `most` intervals of the log, none across a gap.
pub(super) fn changes(
    craft: &Craft,
    rows: &[LogRow],
    median_step_s: f64,
    most: usize,
) -> Vec<Change> {
    let length = (rows.len() - 1).div_ceil(most).max(1);
    let intervals = rows.windows(length + 1).step_by(length);
    let has_gap = |pair: &[LogRow]| step_s(&pair[0], &pair[1]) > MAX_STEP * median_step_s;
    let changes = intervals.filter(|interval| !interval.windows(2).any(has_gap)).map(|interval| {
        let mut change = Change::zero();
        interval.windows(2).for_each(|pair| change.add(craft, &pair[0], &pair[1]));
        change
    });
    changes.collect()
}

/// Fit of the balance over `J`.
pub(super) struct Fit {
    /// Trimmed sum of squares with the fitted `J`, (N m s)².
    pub unexplained: f64,
    /// The same without `J`.
    without_inertia: f64,
    /// The fitted `J` is positive definite.
    pub is_positive: bool,
}

impl Fit {
    /// Fit of the momentum that wheels and torque supply; without these, fit of the ratios of `J` with
    /// trace 1.
    pub fn of(changes: &[Change], factors: [f64; 2]) -> Self {
        let balances: Vec<_> = changes.iter().map(|change| change.balance(factors)).collect();
        let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
        let is_supplied = balances.iter().any(|(_, constant)| *constant != Vector3::zeros());
        // J = 1/3 + a tensor of trace zero: the last moment follows from the other two.
        let trace_one = Vector6::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0) / 3.0;
        let mut free = Matrix6::identity();
        if !is_supplied {
            free[(2, 2)] = 0.0;
            (free[(2, 0)], free[(2, 1)]) = (-1.0, -1.0);
        }
        let fixed = if is_supplied { Vector6::zeros() } else { trace_one };
        for (of_inertia, constant) in &balances {
            let matrix = of_inertia * free;
            normal += matrix.transpose() * matrix;
            right -= matrix.transpose() * (constant + of_inertia * fixed);
        }
        let smallest = normal.diagonal().max() * 1e-12;
        let solution = normal.svd(true, true).solve(&right, smallest);
        let inertia = fixed + free * solution.unwrap_or_else(|_| Vector6::zeros());
        let [unexplained, without_inertia] = [inertia, fixed].map(|inertia| {
            trimmed(balances.iter().map(|(of, constant)| (of * inertia + constant).norm_squared()))
        });
        let is_positive = tensor(&inertia).symmetric_eigenvalues().min() > 0.0;
        Self { unexplained, without_inertia, is_positive }
    }

    /// Share of the momentum exchanged that `J` leaves unexplained.
    pub fn share(&self) -> f64 {
        self.unexplained / self.without_inertia
    }
}

/// Sum without the largest [`TRIMMED`].
fn trimmed(squares: impl Iterator<Item = f64>) -> f64 {
    let mut squares: Vec<f64> = squares.collect();
    squares.sort_by(f64::total_cmp);
    let kept = squares.len() - (TRIMMED * squares.len() as f64) as usize;
    squares.iter().take(kept).sum()
}

/// Momentum of the wheels relative to the body, N m s.
fn momentum(craft: &Craft, row: &LogRow) -> Vector3<f64> {
    let wheels = craft.wheels.iter().zip(&row.wheel_speed_rad_s);
    wheels.map(|(wheel, speed)| wheel.axis * (wheel.spin_inertia_kg_m2 * speed)).sum()
}

/// Matrix of `J ω` by the elements `jxx jyy jzz jxy jxz jyz`.
fn of_elements(rate: &Vector3<f64>) -> Matrix3x6<f64> {
    let (x, y, z) = (rate.x, rate.y, rate.z);
    #[rustfmt::skip]
    let matrix = Matrix3x6::new(
        x, 0.0, 0.0, y, z, 0.0,
        0.0, y, 0.0, x, 0.0, z,
        0.0, 0.0, z, 0.0, x, y,
    );
    matrix
}

fn tensor(elements: &Vector6<f64>) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz]: [f64; 6] = (*elements).into();
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}
