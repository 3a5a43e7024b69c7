//! Flight with errors of the hardware at the level of data sheets, for the tests of the estimators.

use super::test_flight::{TestFlight, tumbling_torque_n_m};
use crate::dynamics::wheels::WheelArray;
use crate::estimate::Estimate;
use crate::hardware::{Disturbance, Hardware, Parameter, tilt_directions};
use crate::math::{Mat, Vec3};
use crate::sample::Sample;
use std::vec::Vec;

/// Body, kg m², and its wheel.
pub const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
pub const SPIN_INERTIA: f64 = 1e-3;
pub const AXIS: [f64; 3] = [0.6, 0.0, 0.8];
pub const NOISE_RAD_S: f64 = 1e-4;
pub const PERIOD_S: f64 = 0.1;

/// Hardware at the level of data sheets.
pub const HARDWARE: Hardware<f64, 1> = Hardware {
    gyro_scale: 5e-3,
    gyro_axes_rad: 1.7e-3,
    delay_s: 0.0,
    delay_sigma_s: 5e-3,
    wheel_inertia: [0.01],
    wheel_axis_rad: [3.5e-3],
    common_wheel_inertia: 5e-3,
    torque_scale: 0.02,
    clock: 0.0,
    mount_rad: [0.0; 3],
};
pub const DISTURBANCE: Disturbance<f64> =
    Disturbance { torque_n_m: 1e-5, gyro_bias_rad_s: NOISE_RAD_S };

/// Two minutes under torque and wheel, without noise.
pub fn flight() -> Vec<Sample<f64, 1>> {
    let flight = TestFlight {
        inertia_kg_m2: INERTIA,
        initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
        wheels: WheelArray::new([Vec3::from(AXIS)], [SPIN_INERTIA]).unwrap(),
        period_us: (PERIOD_S * 1e6) as u64,
        samples: 1200,
    };
    let samples = flight.fly(|t| [60.0 * (0.7 * t).sin() + 20.0], tumbling_torque_n_m);
    let wide = |s: Sample<f32, 1>| Sample {
        time_us: s.time_us,
        rate_rad_s: s.rate_rad_s.map(f64::from),
        wheel_speed_rad_s: s.wheel_speed_rad_s.map(f64::from),
        torque_n_m: s.torque_n_m.map(f64::from),
        attitude: None,
    };
    samples.into_iter().map(wide).collect()
}

pub fn unit(axis: u8) -> Vec3<f64> {
    Vec3::from_fn(|i, _| if i == usize::from(axis) { 1.0 } else { 0.0 })
}

/// The flight with an error of one parameter, by what a filter measures or knows of it.
pub fn with_error(
    samples: &[Sample<f64, 1>],
    wheel: &mut (Vec3<f64>, f64),
    parameter: Parameter,
    error: f64,
) -> Vec<Sample<f64, 1>> {
    let mut changed = samples.to_vec();
    let last = samples.len() - 1;
    for (k, sample) in changed.iter_mut().enumerate() {
        let rate = sample.rate_rad_s;
        match parameter {
            Parameter::GyroScale(i) => sample.rate_rad_s += unit(i) * (rate.dot(&unit(i)) * error),
            Parameter::GyroAxes(i, j) => {
                sample.rate_rad_s += unit(i) * (rate.dot(&unit(j)) * error)
            }
            Parameter::GyroBias(i) => sample.rate_rad_s += unit(i) * error,
            Parameter::Delay => {
                let (from, to) = (k.max(1) - 1, (k + 1).min(last));
                let change = samples[to].rate_rad_s - samples[from].rate_rad_s;
                sample.rate_rad_s -= change * (error / ((to - from) as f64 * PERIOD_S));
            }
            Parameter::TorqueScale => sample.torque_n_m /= 1.0 + error,
            Parameter::DisturbanceTorque(i) => sample.torque_n_m -= unit(i) * error,
            _ => {}
        }
    }
    match parameter {
        Parameter::WheelInertia(_) | Parameter::CommonWheelInertia => wheel.1 /= 1.0 + error,
        Parameter::WheelAxis(_, tilt) => {
            wheel.0 -= tilt_directions(&wheel.0)[usize::from(tilt)] * error;
        }
        _ => {}
    }
    changed
}

/// Standard normal numbers by xorshift and Box-Muller.
pub fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut x = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut flat = move || {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        ((x >> 11) as f64 / (1u64 << 53) as f64).max(1e-300)
    };
    move || {
        let (a, b) = (flat(), flat());
        libm::sqrt(-2.0 * libm::log(a)) * libm::cos(core::f64::consts::TAU * b)
    }
}

/// Readings of the flight with all errors of the hardware drawn, in single precision, and the wheel that is known.
pub fn drawn(samples: &[Sample<f64, 1>], seed: u64) -> (Vec<Sample<f32, 1>>, WheelArray<f32, 1>) {
    let mut draw = normal(seed);
    let mut wheel = (Vec3::from(AXIS), SPIN_INERTIA);
    let mut changed = samples.to_vec();
    for (parameter, sigma) in HARDWARE.parameters().chain(DISTURBANCE.parameters()) {
        changed = with_error(&changed, &mut wheel, parameter, sigma * draw());
    }
    let narrow = |s: &Sample<f64, 1>, draw: &mut dyn FnMut() -> f64| Sample {
        time_us: s.time_us,
        rate_rad_s: s.rate_rad_s.map(|x| (x + NOISE_RAD_S * draw()) as f32),
        wheel_speed_rad_s: s.wheel_speed_rad_s.map(|x| x as f32),
        torque_n_m: s.torque_n_m.map(|x| x as f32),
        attitude: None,
    };
    let axis = wheel.0.map(|x| x as f32);
    let known = WheelArray::new([axis], [wheel.1 as f32]).unwrap();
    (changed.iter().map(|sample| narrow(sample, &mut draw)).collect(), known)
}

/// The stated errors in single precision.
pub fn stated() -> (Hardware<f32, 1>, Disturbance<f32>) {
    let h = &HARDWARE;
    let hardware = Hardware {
        gyro_scale: h.gyro_scale as f32,
        gyro_axes_rad: h.gyro_axes_rad as f32,
        delay_s: 0.0,
        delay_sigma_s: h.delay_sigma_s as f32,
        wheel_inertia: h.wheel_inertia.map(|x| x as f32),
        wheel_axis_rad: h.wheel_axis_rad.map(|x| x as f32),
        common_wheel_inertia: h.common_wheel_inertia as f32,
        torque_scale: h.torque_scale as f32,
        clock: h.clock as f32,
        mount_rad: [0.0; 3],
    };
    let (torque, bias) = (DISTURBANCE.torque_n_m as f32, DISTURBANCE.gyro_bias_rad_s as f32);
    (hardware, Disturbance { torque_n_m: torque, gyro_bias_rad_s: bias })
}

/// Error of an estimate over its covariance, per degree of freedom.
pub fn nees(estimate: &Estimate<f32>) -> f64 {
    let found = estimate.inertia.elements_kg_m2();
    let error = Mat::<f64, 6, 1>::from_fn(|i, _| f64::from(found[i]) - INERTIA[i]);
    let covariance = estimate.covariance_kg2_m4.map(f64::from);
    (error.transpose() * covariance.try_inverse().unwrap() * error)[(0, 0)] / 6.0
}
