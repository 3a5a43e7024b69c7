//! Craft data of the flight computer for a scenario, and the mounting of its gyro.

use fsw_target::drivers::gyro::bmi088::Range;
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::authentication::Key;
use fsw_target::stand_in::tunnel::setup::Unfit;
use fsw_target::stand_in::tunnel::{Setup, Stated};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use thiserror::Error;

use super::hardware::START_US;
use super::mission::Mission;
use crate::input::scenario::SimulatedGyro;
use crate::sensor::encoder::EncoderData;

/// Time without an edge after which a wheel counts as stopped, s: below 0.52 rad/s with 24 edges a
/// turn.
const ZERO_AFTER_S: f32 = 0.5;

/// Master key of both computers: their telecommands have a tag, as in flight.
pub const MASTER_KEY: Key = Key::new(*b"key of the bench");

/// Margin of the gyro's range above the fastest rate, sigmas of its noise.
const NOISE_SIGMAS: f64 = 8.0;

/// A scenario that the flight computer cannot fly.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NotFlown {
    /// More wheels than the flight image supports.
    #[error("{found} wheels: the flight image supports {WHEELS}")]
    TooManyWheels {
        /// Number of wheels of the scenario.
        found: usize,
    },
    /// `ekf-sgf-rls` without a nominal inertia.
    #[error(
        "ekf-sgf-rls needs a nominal inertia: add a [prior] with inertia_kg_m2 and sigma_kg_m2 to \
         the scenario"
    )]
    NoNominalInertia,
    /// Craft data that the flight software rejects.
    #[error("the flight software rejects this spacecraft: {0:?}")]
    Unfit(Unfit),
    /// Power cut outside the flight.
    #[error("--restart-at {at}: the flight has {samples} samples; give one from 1 to {}", samples - 1)]
    NoSuchSample {
        /// Requested number of samples before the power cut.
        at: usize,
        /// Number of samples of the flight.
        samples: usize,
    },
}

/// Rotation from gyro axes to body axes: 40° about an axis in no coordinate plane, so that each body
/// axis has a component on each gyro axis.
pub fn body_from_sensor() -> Matrix3<f64> {
    let axis = Unit::new_normalize(Vector3::new(1.0, -2.0, 3.0));
    *Rotation3::from_axis_angle(&axis, 40f64.to_radians()).matrix()
}

/// Craft data of a mission.
///
/// # Errors
/// See [`NotFlown`].
pub fn of(mission: &Mission<'_>) -> Result<Setup, NotFlown> {
    let craft = mission.scenario.craft();
    if craft.wheels.len() > WHEELS {
        return Err(NotFlown::TooManyWheels { found: craft.wheels.len() });
    }
    if mission.estimator == EstimatorId::EkfSgfRls && craft.prior.is_none() {
        return Err(NotFlown::NoNominalInertia);
    }
    let samples = mission.flight.instants.len();
    if let Some(at) = mission.restart_at.filter(|at| !(1..samples).contains(at)) {
        return Err(NotFlown::NoSuchSample { at, samples });
    }
    let range = range(mission);
    let encoder = EncoderData::default();
    let wheel = |i: usize| craft.wheels.get(i);
    let mounting = body_from_sensor();
    Ok(Setup {
        now_us: START_US,
        wheel_axes: std::array::from_fn(|i| {
            wheel(i).map_or([1.0, 0.0, 0.0], |wheel| narrow(&wheel.axis))
        }),
        spin_inertia_kg_m2: std::array::from_fn(|i| {
            wheel(i).map_or(0.0, |wheel| wheel.spin_inertia_kg_m2 as f32)
        }),
        gyro_noise_rad_s: noise_rad_s(&mission.scenario.gyro, range) as f32,
        prior_kg_m2: craft.prior.as_ref().map(|prior| {
            [prior.inertia_kg_m2, prior.sigma_kg_m2].map(|row| row.map(|element| element as f32))
        }),
        range: range as u8,
        body_from_sensor: std::array::from_fn(|row| narrow(&mounting.row(row).transpose())),
        edges_per_turn: std::array::from_fn(|i| wheel(i).map_or(0, |_| encoder.edges_per_turn)),
        zero_after_s: ZERO_AFTER_S,
        ticks_per_s: encoder.ticks_per_s,
        master_key: Some(*MASTER_KEY.bytes()),
    })
}

/// Errors of the hardware as the scenario states them. Bias, disturbance torque and known errors of the gyro have no
/// counterpart in the flight computer. An averaging gyro is half an interval old.
pub fn stated(mission: &Mission<'_>) -> Stated {
    let (scenario, stated) = (mission.scenario, &mission.scenario.hardware);
    let period_s = 1.0 / scenario.gyro.rate_hz;
    let averaging_s = if stated.gyro_averaged { 0.5 * period_s } else { 0.0 };
    let of_wheels = |sigma: &[f64]| -> [f32; WHEELS] {
        std::array::from_fn(|i| sigma.get(i).map_or(0.0, |sigma| *sigma as f32))
    };
    Stated {
        gyro_scale: stated.gyro_scale_sigma as f32,
        gyro_axes_rad: stated.gyro_axes_sigma_rad as f32,
        delay_s: (stated.gyro_delay_s + averaging_s) as f32,
        delay_sigma_s: stated.gyro_delay_sigma_s as f32,
        wheel_inertia: of_wheels(&stated.wheel_spin_inertia_sigma),
        wheel_axis_rad: of_wheels(&stated.wheel_axis_sigma_rad),
        common_wheel_inertia: stated.common_spin_inertia_sigma as f32,
        torque_scale: stated.torque_scale_sigma as f32,
        clock: stated.clock_sigma as f32,
        mount_rad: stated.mount_sigma_rad.map(|sigma| sigma as f32),
    }
}

/// A vector in single precision.
fn narrow(vector: &Vector3<f64>) -> [f32; 3] {
    [vector.x, vector.y, vector.z].map(|element| element as f32)
}

/// One sigma of the scenario's noise and the quantisation of the chip, rad/s.
fn noise_rad_s(gyro: &SimulatedGyro, range: Range) -> f64 {
    let quantum_rad_s = Some(f64::from(range.quantum_rad_s()));
    SimulatedGyro { quantum_rad_s, ..gyro.clone() }.reading_variance_rad2_s2().sqrt()
}

/// Finest range without saturation; the widest range if there is none.
fn range(mission: &Mission<'_>) -> Range {
    let gyro = &mission.scenario.gyro;
    let fastest = mission.flight.instants.iter().map(|instant| instant.rate_rad_s.norm());
    let errors = &mission.scenario.true_hardware.gyro;
    let noise_rad_s = gyro.noise_rad_s * errors.noise_factor;
    let margin = gyro.bias_rad_s.norm() + NOISE_SIGMAS * noise_rad_s;
    let gain = errors.matrix().norm() / Matrix3::<f64>::identity().norm();
    let most_rad_s = fastest.fold(0.0, f64::max) * gain.max(1.0) + margin;
    let fits = |range: &Range| most_rad_s < f64::from(range.full_scale_rad_s());
    Range::ALL.into_iter().find(fits).unwrap_or(Range::DegS2000)
}
