//! Configuration of C to that of `fsw-core`, and the name of a refused field.
//!
//! | in C | in `fsw-core` |
//! |---|---|
//! | zero where the header has "zero: not an unknown", "zero: measured" | `None` |
//! | `has_prior` 0 | `None` |
//! | flag other than 0 | true |
//! | count beyond 65535 | refused: the field's name |

use crate::sizes::{CONSIDERED, FSW_WHEELS, FSW_WINDOW_UNKNOWNS, PARAMETERS};
use crate::types::*;
use fsw_core::error::Invalid;
use fsw_core::estimator::{joint_ekf, window};
use fsw_core::hardware::{Disturbance, Hardware};
use fsw_core::monitor::spikes;
use fsw_core::{ConfigError, Prior, Vec3, WheelArray, gate};

pub(crate) type Wheels = WheelArray<f32, FSW_WHEELS>;

/// Start of a `window`, checked.
#[derive(Clone, Copy)]
pub(crate) struct WindowStart {
    pub config: window::Config<f32, FSW_WHEELS>,
    pub wheels: Wheels,
}

/// Start of a `joint-ekf`, checked.
#[derive(Clone, Copy)]
pub(crate) struct JointEkfStart {
    pub config: joint_ekf::Config<f32>,
    pub wheels: Wheels,
    pub hardware: Hardware<f32, FSW_WHEELS>,
    pub disturbance: Disturbance<f32>,
}

/// A configuration of C that starts an estimator.
pub(crate) trait Configures {
    type Start: Copy;

    /// Converts and checks.
    ///
    /// # Errors
    /// Names the first field that is out of its range.
    fn start(&self) -> Result<Self::Start, ConfigError>;
}

impl Configures for fsw_window_config {
    type Start = WindowStart;

    fn start(&self) -> Result<WindowStart, ConfigError> {
        let config = window::Config {
            prior: prior(self.has_prior, &self.prior),
            gyro_noise_rad_s: unless_zero(self.gyro_noise_rad_s),
            disturbance_torque_n_m: unless_zero(self.disturbance_torque_n_m),
            varying_torque_n_m: self.varying_torque_n_m,
            gyro_bias_rad_s: unless_zero(self.gyro_bias_rad_s),
            bias_walk_rad_s_sqrt_s: self.bias_walk_rad_s_sqrt_s,
            bias_instability_rad_s: self.bias_instability_rad_s,
            drag_per_s: unless_zero(self.drag_per_s),
            inertia_walk_kg_m2_sqrt_s: self.inertia_walk_kg_m2_sqrt_s,
            block_samples: self.block_samples,
            block_turn_rad: self.block_turn_rad,
            is_torque_smooth: self.is_torque_smooth != 0,
            slices_per_step: self.slices_per_step,
            quiet_s: self.quiet_s,
            hardware: hardware(&self.hardware),
            gate: gate(&self.gate)?,
            ..window::Config::of_unknown_noise()
        };
        config.validate::<FSW_WINDOW_UNKNOWNS, CONSIDERED, 0>()?;
        Ok(WindowStart { config, wheels: wheels(&self.wheels)? })
    }
}

impl Configures for fsw_joint_ekf_config {
    type Start = JointEkfStart;

    fn start(&self) -> Result<JointEkfStart, ConfigError> {
        let initial_rate = (self.has_initial_rate != 0).then(|| joint_ekf::InitialRate {
            rate_rad_s: Vec3::from(self.initial_rate_rad_s),
            sigma_rad_s: self.initial_rate_sigma_rad_s,
        });
        let config = joint_ekf::Config {
            prior: prior(self.has_prior, &self.prior),
            align_above: self.align_above,
            initial_rate,
            rate_walk_rad_s_sqrt_s: self.rate_walk_rad_s_sqrt_s,
            inertia_walk_kg_m2_sqrt_s: self.inertia_walk_kg_m2_sqrt_s,
            spikes: spikes::Config {
                limit_sigma: self.spike_limit_sigma,
                lockout_after: short("spikes.lockout_after", self.lockout_after)?,
            },
            gate: gate(&self.gate)?,
            ..joint_ekf::Config::new(self.gyro_noise_rad_s)
        };
        config.validate()?;
        let hardware = hardware(&self.hardware);
        let disturbance = Disturbance {
            torque_n_m: self.disturbance_torque_n_m,
            gyro_bias_rad_s: self.gyro_bias_rad_s,
        };
        hardware.validate()?;
        disturbance.validate()?;
        // Room for every parameter: `JointEkf::consider` refuses nothing beyond these checks.
        const { assert!(PARAMETERS >= 12 + 3 * FSW_WHEELS + 6) };
        Ok(JointEkfStart { config, wheels: wheels(&self.wheels)?, hardware, disturbance })
    }
}

/// Defaults of `window` for a gyro of this noise, without wheels.
pub(crate) fn window_defaults(gyro_noise_rad_s: f32) -> fsw_window_config {
    let config = window::Config::<f32, FSW_WHEELS>::of_unknown_noise();
    fsw_window_config {
        struct_size: size_of::<fsw_window_config>() as u32,
        has_prior: 0,
        gate: gate_of(&config.gate),
        prior: prior_of(&Prior::unknown()),
        wheels: no_wheels(),
        hardware: ideal(),
        gyro_noise_rad_s,
        disturbance_torque_n_m: 0.0,
        varying_torque_n_m: config.varying_torque_n_m,
        gyro_bias_rad_s: 0.0,
        bias_walk_rad_s_sqrt_s: config.bias_walk_rad_s_sqrt_s,
        bias_instability_rad_s: config.bias_instability_rad_s,
        drag_per_s: 0.0,
        inertia_walk_kg_m2_sqrt_s: config.inertia_walk_kg_m2_sqrt_s,
        block_samples: config.block_samples,
        block_turn_rad: config.block_turn_rad,
        is_torque_smooth: config.is_torque_smooth.into(),
        slices_per_step: config.slices_per_step,
        quiet_s: config.quiet_s,
        reserved: 0,
    }
}

/// Defaults of `joint-ekf` for a gyro of this noise, without wheels.
pub(crate) fn joint_ekf_defaults(gyro_noise_rad_s: f32) -> fsw_joint_ekf_config {
    let config = joint_ekf::Config::<f32>::new(gyro_noise_rad_s);
    fsw_joint_ekf_config {
        struct_size: size_of::<fsw_joint_ekf_config>() as u32,
        has_prior: 0,
        gate: gate_of(&config.gate),
        prior: prior_of(&Prior::unknown()),
        wheels: no_wheels(),
        hardware: ideal(),
        disturbance_torque_n_m: 0.0,
        gyro_bias_rad_s: 0.0,
        gyro_noise_rad_s,
        align_above: config.align_above,
        rate_walk_rad_s_sqrt_s: config.rate_walk_rad_s_sqrt_s,
        inertia_walk_kg_m2_sqrt_s: config.inertia_walk_kg_m2_sqrt_s,
        spike_limit_sigma: config.spikes.limit_sigma,
        lockout_after: config.spikes.lockout_after.into(),
        has_initial_rate: 0,
        initial_rate_rad_s: [0.0; 3],
        initial_rate_sigma_rad_s: 0.0,
    }
}

fn unless_zero(value: f32) -> Option<f32> {
    // NaN is kept, and refused with the field's name.
    if value == 0.0 { None } else { Some(value) }
}

fn prior(has_prior: u32, prior: &fsw_prior) -> Option<Prior<f32>> {
    let fsw_prior { inertia_kg_m2, sigma_kg_m2 } = *prior;
    (has_prior != 0).then_some(Prior { inertia_kg_m2, sigma_kg_m2 })
}

fn prior_of(prior: &Prior<f32>) -> fsw_prior {
    fsw_prior { inertia_kg_m2: prior.inertia_kg_m2, sigma_kg_m2: prior.sigma_kg_m2 }
}

fn wheels(wheels: &fsw_wheels) -> Result<Wheels, ConfigError> {
    WheelArray::new(wheels.axis.map(Vec3::from), wheels.spin_inertia_kg_m2)
}

/// Four unused places.
fn no_wheels() -> fsw_wheels {
    fsw_wheels { axis: [[0.0, 0.0, 1.0]; FSW_WHEELS], spin_inertia_kg_m2: [0.0; FSW_WHEELS] }
}

fn hardware(stated: &fsw_hardware) -> Hardware<f32, FSW_WHEELS> {
    let fsw_hardware {
        gyro_scale,
        gyro_axes_rad,
        delay_s,
        delay_sigma_s,
        wheel_inertia,
        wheel_axis_rad,
        common_wheel_inertia,
        torque_scale,
        clock,
        mount_rad,
    } = *stated;
    Hardware {
        gyro_scale,
        gyro_axes_rad,
        delay_s,
        delay_sigma_s,
        wheel_inertia,
        wheel_axis_rad,
        common_wheel_inertia,
        torque_scale,
        clock,
        mount_rad,
    }
}

fn ideal() -> fsw_hardware {
    fsw_hardware {
        gyro_scale: 0.0,
        gyro_axes_rad: 0.0,
        delay_s: 0.0,
        delay_sigma_s: 0.0,
        wheel_inertia: [0.0; FSW_WHEELS],
        wheel_axis_rad: [0.0; FSW_WHEELS],
        common_wheel_inertia: 0.0,
        torque_scale: 0.0,
        clock: 0.0,
        mount_rad: [0.0; 3],
    }
}

fn gate(limits: &fsw_gate) -> Result<gate::Config<f32>, ConfigError> {
    Ok(gate::Config {
        range_rad_s: limits.range_rad_s,
        max_gap_us: limits.max_gap_us,
        stuck_after: short("gate.stuck_after", limits.stuck_after)?,
    })
}

fn gate_of(config: &gate::Config<f32>) -> fsw_gate {
    fsw_gate {
        max_gap_us: config.max_gap_us,
        range_rad_s: config.range_rad_s,
        stuck_after: config.stuck_after.into(),
    }
}

/// A count of 16 bits.
fn short(field: &'static str, count: u32) -> Result<u16, ConfigError> {
    let reason = Invalid::OutOfRange { least: 0, most: u16::MAX.into() };
    u16::try_from(count).map_err(|_| ConfigError { field, reason })
}
