//! Innovations of a log under a given estimate, for the estimators that have none of their own.
//!
//! A filter of the momentum H, with tensor, hardware, torque and bias of the estimate held fixed. Each reading is
//! predicted from those before it, whose information fades with a memory of [`MEMORY`] readings, \[Sorenson1971\]:
//!
//! ```text
//! Ḣ = τ − ω × H,   ω = J⁻¹ (H − h_w),   z = M ω + b
//! P⁻ = Φ P Φᵀ / λ,   λ = 1 − 1/MEMORY
//! ν = z − M ω⁻ − b,   S = C P⁻ Cᵀ + σ²,   C = M J⁻¹
//! ```
//!
//! An error of the model shows as the rate error that it accumulates within the memory. For the true model ν is white
//! with the variance S, about `σ² (1 + 1/MEMORY)`.
//!
//! \[Sorenson1971\] H. W. Sorenson, J. E. Sacks, "Recursive fading memory filtering", Information Sciences 3 (1971).

use fsw_core::Innovation;
use fsw_core::hardware::Parameter;
use nalgebra::{Matrix3, Vector3, Vector6};

use super::model::{Drive, Unknown};
use super::pass::{Trajectory, tensor};
use super::record::Record;
use crate::estimation::EstimationResult;
use crate::input::Craft;
use crate::input::log::LogRow;

/// Readings in the memory of the filter: the scatter of the prediction is a tenth of the noise.
const MEMORY: f64 = 100.0;
/// Fewest rows: the interpolation of wheel speeds takes four.
const FEWEST_ROWS: usize = 4;

/// Innovation of each row under the result of an estimator; none for the first row, for one after a gap, and where no
/// direction was observed. σ, one sigma of a reading, is measured from differences of the readings: a stated one may be
/// wrong by its tolerance.
pub fn innovations(
    craft: &Craft,
    rows: &[LogRow],
    result: &EstimationResult,
) -> Vec<Option<Innovation<f64>>> {
    let none = vec![None; rows.len()];
    let elements = Vector6::from(result.estimate.inertia.elements_kg_m2());
    let inertia = tensor(&elements);
    let (false, Some(inverse)) = (result.estimate.observed.directions == 0, inertia.try_inverse())
    else {
        return none;
    };
    if rows.len() < FEWEST_ROWS || !elements.iter().all(|element| element.is_finite()) {
        return none;
    }
    let mut record = Record::new(craft, rows);
    for row in record.outliers() {
        record.weight[row] = 0.0;
    }
    let (unknowns, values) = found(craft, &record, result);
    let mut drive = Drive::new(&record, &unknowns, &values, &[], 1.0);
    // The unknowns are fixed.
    drive.columns.clear();
    let mut filter = Filter { record: &record, drive: &drive, inertia, inverse };
    filter.run().unwrap_or(none)
}

/// Parameters of the hardware, torque and bias, with their values by the estimate.
fn found(craft: &Craft, record: &Record, result: &EstimationResult) -> (Vec<Unknown>, Vec<f64>) {
    let hardware = &craft.hardware;
    let averaging_s = if hardware.gyro_averaged { 0.5 * record.period_s() } else { 0.0 };
    let mut delay_s = hardware.gyro_delay_s + averaging_s;
    let mut all: Vec<(Unknown, f64)> = Vec::new();
    let mut common = 0.0;
    for finding in &result.hardware {
        let index = |i: u8| usize::from(i);
        let unknown = match finding.parameter {
            Parameter::GyroScale(i) => Unknown::GyroScale(index(i)),
            Parameter::GyroAxes(i, k) => Unknown::GyroAxes(index(i), index(k)),
            Parameter::WheelInertia(w) => Unknown::WheelInertia(index(w)),
            Parameter::WheelAxis(w, tilt) => Unknown::WheelAxis(index(w), index(tilt)),
            Parameter::TorqueScale => Unknown::TorqueScale,
            Parameter::Delay => {
                delay_s += finding.value;
                continue;
            }
            Parameter::CommonWheelInertia => {
                common = finding.value;
                continue;
            }
            // A turn of all sensors shows in no reading; bias and torque are parts of the estimate.
            // The innovations of a stated mode are those of a rigid body.
            Parameter::Mount(_)
            | Parameter::GyroBias(_)
            | Parameter::DisturbanceTorque(_)
            | Parameter::ModalInertia(..)
            | Parameter::ModeFrequency(_)
            | Parameter::ModeDamping(_) => continue,
        };
        all.push((unknown, finding.value));
    }
    for wheel in 0..record.wheels.len() {
        match all.iter_mut().find(|(unknown, _)| *unknown == Unknown::WheelInertia(wheel)) {
            Some((_, value)) => *value += common,
            None => all.push((Unknown::WheelInertia(wheel), common)),
        }
    }
    let estimate = &result.estimate;
    for i in 0..3 {
        all.extend(estimate.gyro_bias_rad_s.map(|bias| (Unknown::Bias(i), bias[i])));
        all.extend(estimate.disturbance_torque_n_m.map(|torque| (Unknown::Torque(i), torque[i])));
    }
    all.push((Unknown::Delay, delay_s));
    all.into_iter().filter(|(unknown, _)| !unknown.is_wheel_beyond(record.wheels.len())).unzip()
}

struct Filter<'a> {
    record: &'a Record,
    drive: &'a Drive,
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl Filter<'_> {
    /// All rows; none where a matrix has no inverse.
    fn run(&mut self) -> Option<Vec<Option<Innovation<f64>>>> {
        let (record, drive) = (self.record, self.drive);
        let r = Matrix3::identity() * (record.noise_rad_s * record.noise_rad_s);
        let by_reading = self.inertia * drive.reading.try_inverse()?;
        let c = drive.reading * self.inverse;
        let gaps = record.gaps();
        let start = |row: usize| {
            let momentum =
                by_reading * (record.rate_rad_s[row] - drive.bias) + drive.momentum.at[row];
            (momentum, by_reading * r * by_reading.transpose())
        };
        let (mut momentum, mut p) = start(0);
        let mut innovations = vec![None];
        for row in 1..record.len() {
            let (predicted, transition) = self.predicted(row - 1, momentum);
            let is_after_gap =
                gaps.binary_search(&row).is_ok() || record.time_s[row] <= record.time_s[row - 1];
            if is_after_gap || !predicted.iter().all(|h| h.is_finite()) {
                (momentum, p) = start(row);
                innovations.push(None);
                continue;
            }
            momentum = predicted;
            p = transition * p * transition.transpose() / (1.0 - 1.0 / MEMORY);
            let rate = self.inverse * (momentum - drive.momentum.at[row]);
            let innovation = record.rate_rad_s[row] - drive.reading * rate - drive.bias;
            let s = c * p * c.transpose() + r;
            innovations
                .push(Some(Innovation { rate_rad_s: innovation, variance_rad2_s2: s.diagonal() }));
            if record.weight[row] > 0.0 {
                let gain = p * c.transpose() * s.try_inverse()?;
                momentum += gain * innovation;
                p -= gain * c * p;
                p = (p + p.transpose()) * 0.5;
            }
        }
        Some(innovations)
    }

    /// Momentum at the next row, and the transition `Φ` to it.
    fn predicted(&self, row: usize, momentum: Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let mut trajectory = Trajectory::new(self.record, self.drive, self.inverse, momentum);
        trajectory.advance(row);
        (trajectory.momentum(), trajectory.transition())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::{EstimatorName, Method, Precision, Setup, estimate_log, set_up};
    use crate::input::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    /// Innovations of a flight under the result of `window`, over their sigma, and the result.
    fn of(scenario: &str, change: impl Fn(&mut EstimationResult)) -> Vec<Vector3<f64>> {
        let scenario = Scenario::load(scenario).unwrap().of_seed(3);
        let flight = Flight::simulate(&scenario).unwrap();
        let log = log_of(&scenario, &flight, 3);
        let craft = scenario.craft();
        let method = Method { estimator: EstimatorName::Window, precision: Precision::F32 };
        let setup = Setup::for_log(method, &craft, &log).unwrap();
        let mut result = estimate_log(&log, set_up(&setup).unwrap(), |_, _, _| {});
        change(&mut result);
        let all = innovations(&craft, &log, &result);
        let over_sigma = |innovation: Innovation<f64>| {
            innovation.rate_rad_s.component_div(&innovation.variance_rad2_s2.map(f64::sqrt))
        };
        all.into_iter().flatten().map(over_sigma).collect()
    }

    fn mean_square(values: &[Vector3<f64>]) -> f64 {
        values.iter().map(Vector3::norm_squared).sum::<f64>() / (3.0 * values.len() as f64)
    }

    #[test]
    fn innovations_of_the_right_estimate_have_the_predicted_variance() {
        // The mean of 1,800 to 18,000 squares scatters by up to 0.03. The noise is the least of five estimates, each from
        // a median square: some per cent low.
        for scenario in
            ["stsat3-spin-up", "cubesat-pyramid-disturbed", "cubesat-pyramid-data-sheet"]
        {
            let mean = mean_square(&of(scenario, |_| {}));
            assert!((0.9..1.2).contains(&mean), "{scenario}: {mean}");
        }
    }

    #[test]
    fn wrong_tensor_shows_in_the_innovations() {
        let wrong = |result: &mut EstimationResult| {
            let elements = result.estimate.inertia.elements_kg_m2();
            result.estimate.inertia = fsw_core::Inertia::new(elements.map(|element| 1.1 * element));
        };
        let mean = mean_square(&of("cubesat-pyramid", wrong));
        assert!(mean > 2.0, "{mean}");
    }
}
