//! Part of a log that is fitted: arrays by row, wheels, gyro noise, rows in use.

use nalgebra::Vector3;

use crate::input::Craft;
use crate::input::log::LogRow;

/// Most rows of a fit. A longer log is averaged over equal numbers of rows.
pub(super) const MOST_ROWS: usize = 3_000;
/// Most rows of the first stage of a fit.
pub(super) const MOST_COARSE_ROWS: usize = 800;
/// Rows at each end whose readings are not fitted: the reach of a shift and of the interpolation.
pub(super) const MARGIN: usize = 6;
/// Interval between rows beyond which the log has a gap, median intervals.
const GAP: f64 = 3.5;
/// Deviation of a reading from its neighbours that makes it an outlier, sigmas of the deviation.
const OUTLIER: f64 = 7.0;
/// Median of the square of a standard normal variable.
const MEDIAN_SQUARE: f64 = 0.4549;

/// A wheel: unit axis and spin inertia, kg m².
#[derive(Clone, Copy, Debug)]
pub(super) struct Wheel {
    pub axis: Vector3<f64>,
    pub inertia_kg_m2: f64,
}

/// A log with the data of its craft.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// Time of each row, s.
    pub time_s: Vec<f64>,
    /// Readings of the gyro, rad/s.
    pub rate_rad_s: Vec<Vector3<f64>>,
    /// Speed of each wheel, by wheel, rad/s.
    pub wheel_rad_s: Vec<Vec<f64>>,
    /// External torque, N m.
    pub torque_n_m: Vec<Vector3<f64>>,
    /// Number of readings that a row stands for; zero for one that is not fitted.
    pub weight: Vec<f64>,
    /// The wheels.
    pub wheels: Vec<Wheel>,
    /// One sigma of a reading, rad/s.
    pub noise_rad_s: f64,
}

impl Record {
    /// The rows of a log. The noise is measured.
    pub(super) fn new(craft: &Craft, rows: &[LogRow]) -> Self {
        let rate_rad_s: Vec<_> = rows.iter().map(|row| row.rate_rad_s).collect();
        let speed =
            |wheel: usize, row: &LogRow| row.wheel_speed_rad_s.get(wheel).copied().unwrap_or(0.0);
        Self {
            time_s: rows.iter().map(|row| row.time_us as f64 * 1e-6).collect(),
            wheel_rad_s: (0..craft.wheels.len())
                .map(|wheel| rows.iter().map(|row| speed(wheel, row)).collect())
                .collect(),
            torque_n_m: rows.iter().map(|row| row.torque_n_m).collect(),
            weight: vec![1.0; rows.len()],
            wheels: craft
                .wheels
                .iter()
                .map(|wheel| Wheel { axis: wheel.axis, inertia_kg_m2: wheel.spin_inertia_kg_m2 })
                .collect(),
            noise_rad_s: noise_rad_s(&rate_rad_s),
            rate_rad_s,
        }
    }

    /// Number of rows.
    pub(super) fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True if any row has an external torque.
    pub(super) fn has_torque(&self) -> bool {
        self.torque_n_m.iter().any(|torque| *torque != Vector3::zeros())
    }

    /// Rows whose reading deviates from the cubic through its neighbours, `d = x₀ − (−x₋₂ + 4 x₋₁ + 4 x₁ − x₂)/6`,
    /// by more than [`OUTLIER`] sigmas of d, and most among these neighbours. Variance of d for white noise:
    /// `(1 + 34/36) σ²`.
    pub(super) fn outliers(&self) -> Vec<usize> {
        let z = &self.rate_rad_s;
        let sigma = self.noise_rad_s * (1.0_f64 + 34.0 / 36.0).sqrt();
        let deviation = |k: usize| {
            let around = (z[k - 1] + z[k + 1]) * 4.0 - z[k - 2] - z[k + 2];
            (z[k] - around / 6.0).amax()
        };
        if z.len() < 9 {
            return Vec::new();
        }
        let deviations: Vec<f64> = (2..z.len() - 2).map(deviation).collect();
        // The curvature of the motion itself.
        let typical = median(deviations.clone());
        let limit = OUTLIER * sigma.max(typical);
        let is_outlier = |i: &usize| {
            let near = &deviations[i.saturating_sub(2)..(i + 3).min(deviations.len())];
            deviations[*i] > limit && near.iter().all(|near| *near <= deviations[*i])
        };
        (0..deviations.len()).filter(is_outlier).map(|i| i + 2).collect()
    }

    /// The record averaged over as many rows as bring it to `most`. An average of rates, momenta and torques
    /// of the same instants obeys the same equation to second order in the interval.
    pub(super) fn averaged(&self, most: usize) -> Self {
        let length = self.len().div_ceil(most);
        if length <= 1 {
            return self.clone();
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let means = |values: &[f64]| values.chunks_exact(length).map(mean).collect::<Vec<_>>();
        let vectors = |values: &[Vector3<f64>]| {
            let sums = values.chunks_exact(length).map(|part| part.iter().sum::<Vector3<f64>>());
            sums.map(|sum| sum / length as f64).collect::<Vec<_>>()
        };
        let is_whole = |part: &[f64]| part.iter().all(|weight| *weight > 0.0);
        let weights = self.weight.chunks_exact(length);
        Self {
            time_s: means(&self.time_s),
            rate_rad_s: vectors(&self.rate_rad_s),
            wheel_rad_s: self.wheel_rad_s.iter().map(|speeds| means(speeds)).collect(),
            torque_n_m: vectors(&self.torque_n_m),
            weight: weights.map(|part| if is_whole(part) { length as f64 } else { 0.0 }).collect(),
            wheels: self.wheels.clone(),
            noise_rad_s: self.noise_rad_s,
        }
    }

    /// The record without the rows whose reading repeats that of the row before.
    pub(super) fn without_repeated(&self) -> Self {
        let rates = &self.rate_rad_s;
        let fresh: Vec<usize> =
            (0..self.len()).filter(|row| *row == 0 || rates[*row] != rates[row - 1]).collect();
        let numbers = |values: &[f64]| fresh.iter().map(|row| values[*row]).collect::<Vec<_>>();
        let vectors = |values: &[Vector3<f64>]| fresh.iter().map(|row| values[*row]).collect();
        Self {
            time_s: numbers(&self.time_s),
            rate_rad_s: vectors(rates),
            wheel_rad_s: self.wheel_rad_s.iter().map(|speeds| numbers(speeds)).collect(),
            torque_n_m: vectors(&self.torque_n_m),
            weight: numbers(&self.weight),
            wheels: self.wheels.clone(),
            noise_rad_s: self.noise_rad_s,
        }
    }

    /// Number of scalar readings that are fitted.
    pub(super) fn readings(&self) -> f64 {
        let fitted = MARGIN..self.len().saturating_sub(MARGIN).max(MARGIN);
        3.0 * self.weight[fitted].iter().filter(|weight| **weight > 0.0).count() as f64
    }

    fn intervals_s(&self) -> Vec<f64> {
        self.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// Median interval between rows, s.
    pub(super) fn period_s(&self) -> f64 {
        median(self.intervals_s())
    }

    /// First rows after gaps, ascending.
    pub(super) fn gaps(&self) -> Vec<usize> {
        let steps = self.intervals_s();
        let limit = GAP * self.period_s();
        (0..steps.len()).filter(|k| steps[*k] > limit).map(|k| k + 1).collect()
    }
}

/// Median; zero of nothing.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// White noise of one reading, one sigma, rad/s: the least of the estimates from differences of order 2 to 6. A
/// difference of order n has the variance `C(2n, n) σ²` and is zero for a polynomial of a lower degree; its
/// median square is insensitive to outliers. Repeated readings are passed over.
fn noise_rad_s(rates: &[Vector3<f64>]) -> f64 {
    let mut differences: Vec<Vector3<f64>> = rates.to_vec();
    differences.dedup();
    let (mut least, mut gain) = (f64::INFINITY, 1.0);
    for order in 1..=6_u32 {
        differences = differences.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let n = f64::from(order);
        // C(2n, n) = C(2n − 2, n − 1) · 2 (2n − 1) / n
        gain *= 2.0 * (2.0 * n - 1.0) / n;
        if order >= 2 && !differences.is_empty() {
            let squares = differences.iter().flat_map(|d| [d.x * d.x, d.y * d.y, d.z * d.z]);
            least = (median(squares.collect()) / (MEDIAN_SQUARE * gain)).sqrt().min(least);
        }
    }
    let largest = rates.iter().map(|rate| rate.amax()).fold(0.0, f64::max);
    // Rounding of the readings, where their differences are zero.
    if least.is_finite() { least.max(1e-9 * largest) } else { 1e-9 * largest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    fn record() -> Record {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let flight = Flight::simulate(&scenario).unwrap();
        Record::new(&scenario.craft(), &log_of(&scenario, &flight, 1))
    }

    #[test]
    fn noise_is_measured_within_some_per_cent() {
        // The least of five estimates from 1,800 correlated differences.
        assert!((0.85e-4..1.1e-4).contains(&record().noise_rad_s));
    }

    #[test]
    fn outliers_are_found_and_nothing_else() {
        let mut record = record();
        assert!(record.outliers().is_empty());
        record.rate_rad_s[100].y += 0.002;
        record.rate_rad_s[300].z -= 0.05;
        assert_eq!(record.outliers(), [100, 300]);
    }

    #[test]
    fn averages_keep_the_ends_within_and_drop_incomplete_blocks() {
        let mut record = record();
        record.weight[7] = 0.0;
        let averaged = record.averaged(200);
        assert_eq!((averaged.len(), averaged.wheel_rad_s[0].len()), (150, 150));
        assert_eq!((averaged.weight[1], averaged.weight[2]), (0.0, 4.0));
        assert!((averaged.time_s[1] - 0.55).abs() < 1e-12);
    }

    #[test]
    fn gaps_are_the_rows_after_them() {
        let mut record = record();
        record.time_s.iter_mut().skip(200).for_each(|t| *t += 1.0);
        assert_eq!(record.gaps(), [200]);
    }

    #[test]
    fn repeated_readings_are_removed() {
        let mut record = record();
        for row in 1..record.len() {
            record.rate_rad_s[row] = record.rate_rad_s[row - row % 2];
        }
        assert_eq!(record.without_repeated().len(), 301);
    }
}
