//! Estimate report: result of the selected estimator.

use crate::flight::craft::WHEELS;
use crate::link::packet::ESTIMATE;
use crate::link::wire::{codes, record};
use fsw_core::attitude::NoAttitude;
use fsw_core::gate::Rejection;
use fsw_core::hardware::{Finding, Parameter};
use fsw_core::monitor::health::{Driver, Health, HealthMonitor};
use fsw_core::{Coasting, Estimator, Outcome, Reset, Status};
use fsw_roster::EstimatorId;

record! {
    /// Result of the selected estimator after its last step.
    struct EstimateReport {
        /// Time stamp of the last sample stepped, on the clock of the packet time; 0 before the first.
        sample_time_us: u64, "µs";
        /// The selected estimator.
        estimator: EstimatorId, "–";
        /// Usability of the estimate.
        status: Status, "–";
        /// Outcome of the last sample.
        outcome: Option<Outcome>, "–";
        /// Health: the estimator's service, by outcomes, residuals, covariance and wheels.
        health: Health, "–";
        /// Evidence of the last change of `health` for the worse; absent before the first.
        health_driver: Option<Driver>, "–";
        /// True for each wheel whose speed follows its commanded motor torque, or whose command is unknown.
        wheel_follows: [bool; WHEELS], "–";
        /// True if a rigid body can have this tensor.
        physical: bool, "–";
        /// True if the data alone gives an impossible tensor, and the estimate is the nearest physical one.
        projected: bool, "–";
        /// True if the residuals are consistent with white gyro noise; absent if untested.
        residuals_white: Option<bool>, "–";
        /// Number of independent directions observed in the space of the six elements, 0 to 6.
        observed_directions: u8, "–";
        /// True for each observed element: `jxx jyy jzz jxy jxz jyz`.
        element_observed: [bool; 6], "–";
        /// True if the scale of the tensor, its trace, is observed.
        scale_observed: bool, "–";
        /// Inertia tensor about the centre of mass, body axes, locked wheels included: `jxx jyy jzz jxy jxz jyz`.
        inertia_kg_m2: [f32; 6], "kg m²";
        /// Standard deviation of each element.
        sigma_kg_m2: [f32; 6], "kg m²";
        /// Filtered body rate relative to inertial space, body axes.
        rate_rad_s: [f32; 3], "rad/s";
        /// RMS of measured minus predicted rate over the samples used, all axes.
        residual_rms_rad_s: f32, "rad/s";
        /// Normalised innovation squared of the last predicted sample, summed over the axes; mean 3. Absent if it is not finite.
        nis: Option<f32>, "–";
        /// Constant disturbance torque, body axes; absent if not estimated.
        disturbance_torque_n_m: Option<[f32; 3]>, "N m";
        /// Gyro bias, body axes; absent if not estimated.
        gyro_bias_rad_s: Option<[f32; 3]>, "rad/s";
        /// Part of `sigma_kg_m2` by the stated errors of the hardware, the rest is random: root sum of squares; absent for hardware without errors.
        sigma_systematic_kg_m2: Option<[f32; 6]>, "kg m²";
        /// Error of the hardware that adds most to `sigma_systematic_kg_m2`; absent without any.
        largest_systematic: Option<HardwareError>, "–";
        /// Its number from 1: axis, wheel, or of the gyro axes `xy xz yx yz zx zy`; 0 for an error without a number.
        largest_systematic_number: u8, "–";
        /// Time offset of the gyro beyond the stated one, and one sigma of it; absent if not estimated.
        time_offset_s: Option<[f32; 2]>, "s";
    }
}

report!(EstimateReport, ESTIMATE);

impl EstimateReport {
    /// Report of `estimator` after the sample at `sample_time_us` with this outcome. Costs a 6 × 6
    /// eigenproblem, as [`Estimator::estimate`] does. `health` takes in the estimate: it shows from the next sample on.
    #[inline(never)]
    pub fn of<E: Estimator<f32, W>, const W: usize>(
        id: EstimatorId,
        estimator: &E,
        sample_time_us: u64,
        outcome: Option<Outcome>,
        health: &mut HealthMonitor,
        wheel_follows: [bool; WHEELS],
    ) -> Self {
        // In sequence: their stacks do not add up.
        let hardware = OfHardware::of(estimator);
        let estimate = estimator.estimate();
        health.estimate(&estimate);
        let has_errors = estimate.sigma_random_kg_m2.is_some();
        let (largest, number) = match hardware.largest {
            Some((parameter, _)) => {
                let (error, number) = HardwareError::of(parameter);
                (Some(error), number)
            }
            None => (None, 0),
        };
        Self {
            sample_time_us,
            estimator: id,
            status: estimate.status,
            outcome,
            health: health.health(),
            health_driver: health.driver(),
            wheel_follows,
            physical: estimate.inertia.check().is_ok(),
            projected: estimate.projected,
            residuals_white: estimate.residuals_white,
            observed_directions: estimate.observed.directions,
            element_observed: estimate.observed.element,
            scale_observed: estimate.observed.scale,
            inertia_kg_m2: estimate.inertia.elements_kg_m2(),
            sigma_kg_m2: estimate.sigma_kg_m2(),
            rate_rad_s: estimator.rate_rad_s().into(),
            residual_rms_rad_s: estimate.residual_rms_rad_s,
            nis: estimator
                .innovation()
                .map(|innovation| innovation.nis())
                .filter(|nis| nis.is_finite()),
            disturbance_torque_n_m: estimate.disturbance_torque_n_m.map(Into::into),
            gyro_bias_rad_s: estimate.gyro_bias_rad_s.map(Into::into),
            sigma_systematic_kg_m2: has_errors.then(|| estimate.sigma_systematic_kg_m2()),
            largest_systematic: largest,
            largest_systematic_number: number,
            time_offset_s: hardware.time_offset_s,
        }
    }
}

/// Results on the hardware for a report.
struct OfHardware {
    /// Parameter with the largest effect on the tensor, and the square of its Frobenius norm, kg² m⁴.
    largest: Option<(Parameter, f32)>,
    /// Estimate of the time offset and one sigma, s.
    time_offset_s: Option<[f32; 2]>,
}

impl OfHardware {
    #[inline(never)]
    fn of<E: Estimator<f32, W>, const W: usize>(estimator: &E) -> Self {
        let mut this = Self { largest: None, time_offset_s: None };
        estimator.each_of_hardware(&mut |finding| this.add(&finding));
        this
    }

    fn add(&mut self, finding: &Finding<f32>) {
        // Frobenius norm: a product stands in the tensor twice.
        let squares = finding.effect_kg_m2.map(|effect| effect * effect);
        let [xx, yy, zz, xy, xz, yz] = squares;
        let square = xx + yy + zz + 2.0 * (xy + xz + yz);
        if square.is_finite() && square > self.largest.map_or(0.0, |(_, square)| square) {
            self.largest = Some((finding.parameter, square));
        }
        if finding.parameter == Parameter::Delay {
            self.time_offset_s = Some([finding.value, finding.sigma]);
        }
    }
}

/// Kind of an error of the hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HardwareError {
    /// Scale factor of a gyro axis.
    GyroScale,
    /// Misalignment or non-orthogonality of the gyro.
    GyroAxes,
    /// Spin inertia of a wheel.
    WheelInertia,
    /// Tilt of a wheel's axis.
    WheelAxis,
    /// Time offset of the gyro.
    TimeOffset,
    /// Scale of the known torque.
    TorqueScale,
    /// Error common to all spin inertias.
    CommonWheelInertia,
    /// Turn of all sensors as one about an axis.
    Mount,
    /// Bias of a gyro axis.
    GyroBias,
    /// Disturbance torque about an axis.
    DisturbanceTorque,
    /// Modal inertia, frequency or damping of a mode.
    Mode,
}

impl HardwareError {
    /// Kind and number of a parameter, as in [`EstimateReport::largest_systematic_number`].
    fn of(parameter: Parameter) -> (Self, u8) {
        match parameter {
            Parameter::GyroScale(axis) => (Self::GyroScale, axis.saturating_add(1)),
            Parameter::GyroAxes(axis, about) => {
                // Each axis has two errors, in the order of the axes that they are about.
                let second = u8::from(about > 1 || (about == 1 && axis == 2));
                (Self::GyroAxes, axis.saturating_mul(2).saturating_add(second).saturating_add(1))
            }
            Parameter::WheelInertia(wheel) => (Self::WheelInertia, wheel.saturating_add(1)),
            Parameter::WheelAxis(wheel, _) => (Self::WheelAxis, wheel.saturating_add(1)),
            Parameter::Delay => (Self::TimeOffset, 0),
            Parameter::TorqueScale => (Self::TorqueScale, 0),
            Parameter::CommonWheelInertia => (Self::CommonWheelInertia, 0),
            Parameter::Mount(axis) => (Self::Mount, axis.saturating_add(1)),
            Parameter::GyroBias(axis) => (Self::GyroBias, axis.saturating_add(1)),
            Parameter::DisturbanceTorque(axis) => (Self::DisturbanceTorque, axis.saturating_add(1)),
            Parameter::ModalInertia(mode, _)
            | Parameter::ModeFrequency(mode)
            | Parameter::ModeDamping(mode) => (Self::Mode, mode.saturating_add(1)),
        }
    }
}

codes! { HardwareError {
    0 "gyro_scale" => GyroScale;
    1 "gyro_axes" => GyroAxes;
    2 "wheel_spin_inertia" => WheelInertia;
    3 "wheel_axis" => WheelAxis;
    4 "time_offset" => TimeOffset;
    5 "torque_scale" => TorqueScale;
    6 "common_wheel_spin_inertia" => CommonWheelInertia;
    7 "mount" => Mount;
    8 "gyro_bias" => GyroBias;
    9 "disturbance_torque" => DisturbanceTorque;
    10 "mode" => Mode;
} }

codes! { Status {
    0 "unobservable" => Unobservable;
    1 "partial" => Partial;
    2 "converged" => Converged;
    3 "diverged" => Diverged;
} }

codes! { Outcome {
    0 "updated" => Updated;
    16 "not_finite" => Coasting(Coasting::Rejected(Rejection::NotFinite));
    17 "out_of_range" => Coasting(Coasting::Rejected(Rejection::OutOfRange));
    18 "out_of_order" => Coasting(Coasting::Rejected(Rejection::OutOfOrder));
    19 "stuck" => Coasting(Coasting::Rejected(Rejection::Stuck));
    20 "spike" => Coasting(Coasting::Spike);
    21 "aligning" => Coasting(Coasting::Aligning);
    22 "refilling" => Coasting(Coasting::Refilling);
    23 "attitude_missing" => Coasting(Coasting::NoAttitude(NoAttitude::Missing));
    24 "attitude_not_finite" => Coasting(Coasting::NoAttitude(NoAttitude::NotFinite));
    25 "attitude_not_unit" => Coasting(Coasting::NoAttitude(NoAttitude::NotUnit));
    26 "waiting_for_rest" => Coasting(Coasting::WaitingForRest);
    32 "reset_first_sample" => Reset(Reset::FirstSample);
    33 "reset_aligned" => Reset(Reset::Aligned);
    34 "reset_gap" => Reset(Reset::Gap);
    35 "reset_lockout" => Reset(Reset::Lockout);
    36 "reset_changed" => Reset(Reset::Changed);
    37 "reset_diverged" => Reset(Reset::Diverged);
    38 "reset_clock" => Reset(Reset::Clock);
    39 "reset_interrupted" => Reset(Reset::Interrupted);
} }

codes! { Health {
    0 "nominal" => Nominal;
    1 "degraded" => Degraded;
    2 "lost" => Lost;
} }

codes! { Driver {
    0 "gate" => Gate;
    1 "prediction" => Prediction;
    2 "gap" => Gap;
    3 "contradiction" => Contradiction;
    4 "residuals" => Residuals;
    5 "excitation" => Excitation;
    6 "wheel" => Wheel;
    7 "model" => Model;
    8 "numbers" => Numbers;
} }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::Coded;

    #[test]
    fn gyro_axes_are_numbered_by_rows() {
        let axes = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
        for (number, (axis, about)) in (1..).zip(axes) {
            let of = HardwareError::of(Parameter::GyroAxes(axis, about));
            assert_eq!(of, (HardwareError::GyroAxes, number));
        }
    }

    #[test]
    fn health_has_its_names_in_the_core() {
        assert!(
            Health::CODES
                .iter()
                .all(|(code, word)| Health::of_code(*code).unwrap().name() == *word)
        );
        assert!(
            Driver::CODES
                .iter()
                .all(|(code, word)| Driver::of_code(*code).unwrap().name() == *word)
        );
    }

    #[test]
    fn outcomes_have_their_names_in_the_core() {
        for (code, word) in Outcome::CODES {
            let outcome = Outcome::of_code(*code).unwrap();
            assert_eq!(outcome.name(), *word);
            assert_eq!(outcome.code(), (*code, *word));
        }
    }
}
