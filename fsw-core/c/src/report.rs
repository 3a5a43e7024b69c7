//! Outcome, estimate and findings of `fsw-core` to structs of C.

use crate::config::Configures;
use crate::memory::{SizedStruct, input, set_text};
use crate::sizes::FSW_WHEELS;
use crate::types::*;
use core::ffi::c_char;
use fsw_core::error::Invalid;
use fsw_core::gate::Rejection;
use fsw_core::hardware::{Finding, Parameter};
use fsw_core::{Coasting, ConfigError, Estimate, Estimator, Outcome, Reset, Sample, Status, Vec3};

impl fsw_sample {
    /// Sample for an estimator.
    pub(crate) fn sample(&self) -> Sample<f32, FSW_WHEELS> {
        Sample {
            time_us: self.time_us,
            rate_rad_s: Vec3::from(self.rate_rad_s),
            wheel_speed_rad_s: self.wheel_speed_rad_s,
            torque_n_m: Vec3::from(self.torque_n_m),
            attitude: None,
        }
    }
}

/// Outcome with rate and innovation of the estimator after the step.
pub(crate) fn outcome(
    outcome: Outcome,
    estimator: &impl Estimator<f32, FSW_WHEELS>,
) -> fsw_outcome {
    let innovation = estimator.innovation();
    let [rate, variance] = innovation.map_or([[0.0; 3]; 2], |innovation| {
        [innovation.rate_rad_s.into(), innovation.variance_rad2_s2.into()]
    });
    fsw_outcome {
        struct_size: size_of::<fsw_outcome>() as u32,
        code: outcome_code(outcome),
        used_sample: outcome.used_sample().into(),
        rate_rad_s: estimator.rate_rad_s().into(),
        has_innovation: innovation.is_some().into(),
        innovation_rad_s: rate,
        innovation_variance_rad2_s2: variance,
    }
}

fn outcome_code(outcome: Outcome) -> fsw_outcome_code {
    match outcome {
        Outcome::Updated => fsw_outcome_code::Updated,
        Outcome::Coasting(coasting) => match coasting {
            Coasting::Rejected(Rejection::NotFinite) => fsw_outcome_code::NotFinite,
            Coasting::Rejected(Rejection::OutOfRange) => fsw_outcome_code::OutOfRange,
            Coasting::Rejected(Rejection::OutOfOrder) => fsw_outcome_code::OutOfOrder,
            Coasting::Rejected(Rejection::Stuck) => fsw_outcome_code::Stuck,
            Coasting::Spike => fsw_outcome_code::Spike,
            Coasting::Aligning => fsw_outcome_code::Aligning,
            Coasting::Refilling => fsw_outcome_code::Refilling,
            Coasting::NoAttitude(_) => fsw_outcome_code::NoAttitude,
            Coasting::WaitingForRest => fsw_outcome_code::WaitingForRest,
        },
        Outcome::Reset(reset) => match reset {
            Reset::FirstSample => fsw_outcome_code::ResetFirstSample,
            Reset::Aligned => fsw_outcome_code::ResetAligned,
            Reset::Gap => fsw_outcome_code::ResetGap,
            Reset::Clock => fsw_outcome_code::ResetClock,
            Reset::Lockout => fsw_outcome_code::ResetLockout,
            Reset::Interrupted => fsw_outcome_code::ResetInterrupted,
            Reset::Changed => fsw_outcome_code::ResetChanged,
            Reset::Diverged => fsw_outcome_code::ResetDiverged,
        },
    }
}

/// Estimate for C.
pub(crate) fn estimate(estimate: &Estimate<f32>) -> fsw_estimate {
    let covariance = &estimate.covariance_kg2_m4;
    let elements = estimate.observed.element.iter().enumerate();
    fsw_estimate {
        struct_size: size_of::<fsw_estimate>() as u32,
        status: match estimate.status {
            Status::Converged => fsw_status::Converged,
            Status::Partial => fsw_status::Partial,
            Status::Unobservable => fsw_status::Unobservable,
            Status::Diverged => fsw_status::Diverged,
        },
        inertia_kg_m2: estimate.inertia.elements_kg_m2(),
        sigma_kg_m2: estimate.sigma_kg_m2(),
        covariance_kg2_m4: core::array::from_fn(|i| core::array::from_fn(|k| covariance[(i, k)])),
        has_sigma_random: estimate.sigma_random_kg_m2.is_some().into(),
        sigma_random_kg_m2: estimate.sigma_random_kg_m2.unwrap_or_default(),
        observed_directions: estimate.observed.directions.into(),
        observed_elements: elements.fold(0, |bits, (i, is)| bits | u32::from(*is) << i),
        observed_scale: estimate.observed.scale.into(),
        has_disturbance_torque: estimate.disturbance_torque_n_m.is_some().into(),
        disturbance_torque_n_m: estimate.disturbance_torque_n_m.map_or([0.0; 3], Into::into),
        has_gyro_bias: estimate.gyro_bias_rad_s.is_some().into(),
        gyro_bias_rad_s: estimate.gyro_bias_rad_s.map_or([0.0; 3], Into::into),
        residual_rms_rad_s: estimate.residual_rms_rad_s,
        residuals_white: estimate.residuals_white.map_or(-1, i32::from),
        projected: estimate.projected.into(),
    }
}

/// Finding for C.
pub(crate) fn finding(finding: &Finding<f32>) -> fsw_finding {
    let (parameter, first, second) = match finding.parameter {
        Parameter::GyroScale(axis) => (fsw_parameter::GyroScale, axis, 0),
        Parameter::GyroAxes(axis, about) => (fsw_parameter::GyroAxes, axis, about),
        Parameter::WheelInertia(wheel) => (fsw_parameter::WheelInertia, wheel, 0),
        Parameter::WheelAxis(wheel, direction) => (fsw_parameter::WheelAxis, wheel, direction),
        Parameter::Delay => (fsw_parameter::Delay, 0, 0),
        Parameter::TorqueScale => (fsw_parameter::TorqueScale, 0, 0),
        Parameter::CommonWheelInertia => (fsw_parameter::CommonWheelInertia, 0, 0),
        Parameter::Mount(axis) => (fsw_parameter::Mount, axis, 0),
        Parameter::GyroBias(axis) => (fsw_parameter::GyroBias, axis, 0),
        Parameter::DisturbanceTorque(axis) => (fsw_parameter::DisturbanceTorque, axis, 0),
        Parameter::ModalInertia(mode, element) => (fsw_parameter::ModalInertia, mode, element),
        Parameter::ModeFrequency(mode) => (fsw_parameter::ModeFrequency, mode, 0),
        Parameter::ModeDamping(mode) => (fsw_parameter::ModeDamping, mode, 0),
    };
    fsw_finding {
        struct_size: size_of::<fsw_finding>() as u32,
        parameter,
        first: first.into(),
        second: second.into(),
        value: finding.value,
        sigma: finding.sigma,
        stated: finding.stated,
        effect_kg_m2: finding.effect_kg_m2,
    }
}

/// Checks a configuration, and writes field and reason of a refusal, a wrong `struct_size` included.
pub(crate) fn check_config<C: Configures + SizedStruct>(
    config: *const C,
    text: *mut c_char,
    bytes: usize,
) -> Result<fsw_result, fsw_result> {
    let (result, parts) = match input(config) {
        Err(fsw_result::StructSize) => {
            (fsw_result::StructSize, ["struct_size", ": ", "is not that of this library"])
        }
        Err(refused) => return Err(refused),
        Ok(config) => match config.start() {
            Ok(_) => (fsw_result::Ok, [""; 3]),
            Err(error) => (fsw_result::Config, refusal(&error)),
        },
    };
    set_text(text, bytes, &parts).map(|()| result)
}

/// Field and reason of a refused configuration, to be written one after the other. Without `core::fmt`, which an image
/// may not contain otherwise.
pub(crate) fn refusal(error: &ConfigError) -> [&'static str; 3] {
    let reason = match error.reason {
        Invalid::NotFinite => "must be a finite number",
        Invalid::NotPositive => "must be above zero",
        Invalid::Negative => "must not be negative",
        Invalid::AboveOne => "must not be above one",
        Invalid::OutOfRange { .. } => "is beyond the largest permitted value",
        Invalid::ZeroAxis => "an axis must have a length above zero",
        Invalid::NoRoom => "has no place: see FSW_WINDOW_UNKNOWNS",
        Invalid::NotPhysical(_) => "is the tensor of no rigid body",
    };
    [error.field, ": ", reason]
}
