//! Linear start of the fit: momentum balance integrated over short segments.
//!
//! `G(ω) j + ∫ ω × G(ω) dt j − H₀ = ∫ τ dt − h_w − ∫ ω × h_w dt` with measured rates, per segment; the initial momentum
//! H₀ is eliminated by the mean. The noise of the rates adds `σ² diag(1 1 1 2 2 2)` per row to the normal matrix, which
//! is removed.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::model::Drive;
use super::pass::{Segments, of_elements, tensor};
use super::record::Record;

/// Weight of the row `trace = 3`, in sigmas, that fixes the scale where nothing else does.
const TRACE_WEIGHT: f64 = 1e-3;
/// Smallest moment of a start, largest moments.
const SMALLEST_MOMENT: f64 = 0.1;

/// Starts of the inertia over the scale: that of the linear fit, and a sphere of the same trace.
pub(super) fn starts(record: &Record, drive: &Drive, segments: &Segments) -> Vec<Vector6<f64>> {
    let sphere = |moment: f64| Vector6::new(moment, moment, moment, 0.0, 0.0, 0.0);
    let Some(linear) = linear(record, drive, segments) else { return vec![sphere(1.0)] };
    let moment = (linear[0] + linear[1] + linear[2]) / 3.0;
    let moment = if moment.is_finite() && moment > 1e-6 { moment } else { 1.0 };
    vec![with_positive_moments(&linear), sphere(moment)]
}

/// Least squares of the balance.
fn linear(record: &Record, drive: &Drive, segments: &Segments) -> Option<Vector6<f64>> {
    let mut normal = Matrix6::zeros();
    let mut right = Vector6::zeros();
    let trace = Vector6::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0);
    for (segment, start) in segments.starts.iter().enumerate() {
        let end = segments.starts.get(segment + 1).copied().unwrap_or(segments.end);
        add_segment(record, drive, *start..end, &mut normal, &mut right);
    }
    let weight = TRACE_WEIGHT / record.noise_rad_s;
    normal += trace * trace.transpose() * (weight * weight);
    right += trace * (3.0 * weight * weight);
    let size = normal.diagonal().amax();
    let solution = normal.svd(true, true).solve(&right, size * 1e-14).ok()?;
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

fn add_segment(
    record: &Record,
    drive: &Drive,
    rows: std::ops::Range<usize>,
    normal: &mut Matrix6<f64>,
    right: &mut Vector6<f64>,
) {
    let per_variance = 1.0 / (record.noise_rad_s * record.noise_rad_s);
    let balances = balances(record, drive, rows);
    let count = balances.len() as f64;
    if count < 3.0 {
        return;
    }
    let mean_matrix = balances.iter().map(|(matrix, _)| *matrix).sum::<nalgebra::Matrix3x6<f64>>();
    let mean_right = balances.iter().map(|(_, right)| *right).sum::<Vector3<f64>>() / count;
    let mean_matrix = mean_matrix / count;
    for (matrix, value) in &balances {
        let (matrix, value) = (matrix - mean_matrix, value - mean_right);
        *normal += matrix.transpose() * matrix * per_variance;
        *right += matrix.transpose() * value * per_variance;
    }
    let of_noise = Vector6::new(1.0, 1.0, 1.0, 2.0, 2.0, 2.0) * (count - 1.0);
    let removed = Matrix6::from_diagonal(&of_noise);
    // No more than half of any diagonal entry.
    let share = (0..6).map(|i| 0.5 * normal[(i, i)] / of_noise[i]).fold(1.0, f64::min);
    *normal -= removed * share.max(0.0);
}

/// Matrix and right side of the balance at each row in use.
fn balances(
    record: &Record,
    drive: &Drive,
    rows: std::ops::Range<usize>,
) -> Vec<(nalgebra::Matrix3x6<f64>, Vector3<f64>)> {
    let inverse = drive.reading.try_inverse().unwrap_or_else(Matrix3::identity);
    let rate = |row: usize| inverse * (record.rate_rad_s[row] - drive.bias);
    let terms = |row: usize| {
        let rate = rate(row);
        let h = drive.momentum.at[row];
        (rate.cross_matrix() * of_elements(&rate), drive.torque[row] - rate.cross(&h))
    };
    let mut integral = nalgebra::Matrix3x6::zeros();
    let mut driven = Vector3::zeros();
    let mut all = Vec::with_capacity(rows.len());
    let first = rows.start;
    for row in rows {
        if row > first {
            let half_s = 0.5 * (record.time_s[row] - record.time_s[row - 1]);
            let ((a, b), (c, d)) = (terms(row - 1), terms(row));
            integral += (a + c) * half_s;
            driven += (b + d) * half_s;
        }
        if record.weight[row] > 0.0 {
            all.push((of_elements(&rate(row)) + integral, driven - drive.momentum.at[row]));
        }
    }
    all
}

/// The tensor with each principal moment at least [`SMALLEST_MOMENT`] of the largest.
fn with_positive_moments(j: &Vector6<f64>) -> Vector6<f64> {
    let eigen = tensor(j).symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let moments = eigen.eigenvalues.map(|moment| moment.abs().max(SMALLEST_MOMENT * largest));
    let t = eigen.eigenvectors * Matrix3::from_diagonal(&moments) * eigen.eigenvectors.transpose();
    Vector6::new(t[(0, 0)], t[(1, 1)], t[(2, 2)], t[(0, 1)], t[(0, 2)], t[(1, 2)])
}
