//! Structs and enums of the header.
//!
//! Flags and enumerations that C writes are `uint32_t`, since a Rust enum with a value outside its variants is
//! undefined behaviour. Those that C reads have the fixed width of `int32_t`, independent of `-fshort-enums`.

use crate::sizes::{FSW_JOINT_EKF_SIZE_U64, FSW_WHEELS, FSW_WINDOW_SIZE_U64};
use core::ffi::c_void;

/// Memory of one `window` estimator. Its contents are not part of the interface.
#[repr(C)]
#[derive(Debug)]
pub struct fsw_window {
    /// Opaque.
    pub memory: [u64; FSW_WINDOW_SIZE_U64],
}

/// Memory of one `joint-ekf` estimator. Its contents are not part of the interface.
#[repr(C)]
#[derive(Debug)]
pub struct fsw_joint_ekf {
    /// Opaque.
    pub memory: [u64; FSW_JOINT_EKF_SIZE_U64],
}

/// Result of a call.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum fsw_result {
    /// Executed.
    Ok = 0,
    /// A pointer is null.
    NullPointer = 1,
    /// A pointer is not aligned for its type; memory of an estimator: FSW_ALIGN.
    Misaligned = 2,
    /// The memory is shorter than the estimator: fsw_window_size(), fsw_joint_ekf_size().
    MemoryShort = 3,
    /// `struct_size` is not the size that this library was built with: header and library differ, or the member
    /// was not set.
    StructSize = 4,
    /// The memory does not hold an estimator of this kind: `init` has not succeeded there.
    Uninitialised = 5,
    /// A configured value is out of its range: fsw_window_config_check() names the field.
    Config = 6,
    /// The words belong to another layout of the state or another version of the library.
    Fingerprint = 7,
    /// A call-back has returned zero: the medium is full, or ends before the state.
    Medium = 8,
    /// A word is not valid, or the checkpoint was written with another configuration.
    State = 9,
}

/// Inertia before any data: expected elements and one sigma of each. The inertia is that of the spacecraft with its
/// wheels locked to the body, spin inertia included.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_prior {
    /// Elements `jxx jyy jzz jxy jxz jyz`, kg m²: of a rigid body.
    pub inertia_kg_m2: [f32; 6],
    /// One sigma of each, kg m², above zero.
    pub sigma_kg_m2: [f32; 6],
}

/// Reaction wheels.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_wheels {
    /// Spin axis of each wheel in body axes, of any length above zero.
    pub axis: [[f32; 3]; FSW_WHEELS],
    /// Moment of inertia about the spin axis, kg m², zero or above; zero for an unused place.
    pub spin_inertia_kg_m2: [f32; FSW_WHEELS],
}

/// Stated errors of gyro, wheels and torque, one sigma each, up to 10; zero for one that is known exactly.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_hardware {
    /// Scale factor of each gyro axis, share.
    pub gyro_scale: f32,
    /// Each of the six errors of the gyro's axes, rad.
    pub gyro_axes_rad: f32,
    /// Known time offset, s, within ±100: a gyro reading shows the motion of `delay_s` before its time stamp.
    pub delay_s: f32,
    /// Error of it, s, up to 100.
    pub delay_sigma_s: f32,
    /// Spin inertia of each wheel, share.
    pub wheel_inertia: [f32; FSW_WHEELS],
    /// Each of the two tilts of a spin axis, rad.
    pub wheel_axis_rad: [f32; FSW_WHEELS],
    /// Error common to all spin inertias, share.
    pub common_wheel_inertia: f32,
    /// Known external torque, share.
    pub torque_scale: f32,
    /// Rate of the clock that stamps the samples, share.
    pub clock: f32,
    /// Turn of gyro and wheels as one against the axes of the tensor, about each axis, rad.
    pub mount_rad: [f32; 3],
}

/// Limits of a usable sample.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_gate {
    /// Longest interval across which the rate is predicted, µs.
    pub max_gap_us: u64,
    /// Range of the gyro, rad/s, above zero: a rate of this magnitude or more is rejected.
    pub range_rad_s: f32,
    /// Equal successive readings that identify a stuck sensor, up to 65535; zero disables the check.
    pub stuck_after: u32,
}

/// Configuration of `window`. Start from fsw_window_config_defaults().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_window_config {
    /// `sizeof(fsw_window_config)`.
    pub struct_size: u32,
    /// 1 where `prior` is set, 0 for none.
    pub has_prior: u32,
    /// Limits of a usable sample.
    pub gate: fsw_gate,
    /// Inertia before any data.
    pub prior: fsw_prior,
    /// Reaction wheels.
    pub wheels: fsw_wheels,
    /// Stated errors of the hardware.
    pub hardware: fsw_hardware,
    /// Gyro noise, one sigma, white, per sample, rad/s; zero: measured.
    pub gyro_noise_rad_s: f32,
    /// One sigma of a constant disturbance torque, N m, each axis; zero: not an unknown.
    pub disturbance_torque_n_m: f32,
    /// One sigma of a torque of fields, which varies as the body turns, N m, each axis.
    pub varying_torque_n_m: f32,
    /// One sigma of a constant gyro bias, rad/s, each axis; zero: not an unknown.
    pub gyro_bias_rad_s: f32,
    /// Random walk of the gyro bias, (rad/s)/√s, each axis.
    pub bias_walk_rad_s_sqrt_s: f32,
    /// Instability of the gyro bias, floor of its Allan deviation, rad/s.
    pub bias_instability_rad_s: f32,
    /// One sigma of the drag rates of a body in air, 1/s, each axis; zero: not an unknown.
    pub drag_per_s: f32,
    /// Random walk of each element of the inertia, kg m²/√s.
    pub inertia_walk_kg_m2_sqrt_s: f32,
    /// Samples of a block at first, above zero.
    pub block_samples: u32,
    /// Largest turn of a block, rad, above zero.
    pub block_turn_rad: f32,
    /// 1 for external torque that is smooth between its samples, 0 for straight lines.
    pub is_torque_smooth: u32,
    /// Slices of work that a step does; zero for a caller that calls fsw_window_work() itself.
    pub slices_per_step: u32,
    /// Time without motion that ends a manoeuvre, s, above zero.
    pub quiet_s: f32,
    /// Not used.
    pub reserved: u32,
}

/// Configuration of `joint-ekf`. Start from fsw_joint_ekf_config_defaults().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_joint_ekf_config {
    /// `sizeof(fsw_joint_ekf_config)`.
    pub struct_size: u32,
    /// 1 where `prior` is set, 0 for none: the filter then aligns on the motion first.
    pub has_prior: u32,
    /// Limits of a usable sample.
    pub gate: fsw_gate,
    /// Inertia before any data.
    pub prior: fsw_prior,
    /// Reaction wheels.
    pub wheels: fsw_wheels,
    /// Stated errors of the hardware: considered, not estimated.
    pub hardware: fsw_hardware,
    /// Considered constant disturbance torque, one sigma on each axis, N m; zero for none.
    pub disturbance_torque_n_m: f32,
    /// Considered constant gyro bias, one sigma on each axis, rad/s; zero for none.
    pub gyro_bias_rad_s: f32,
    /// Gyro noise, one sigma, white, per sample, rad/s, above zero.
    pub gyro_noise_rad_s: f32,
    /// Largest sigma of a prior, as a share of its mean moment, from which the filter starts without alignment.
    pub align_above: f32,
    /// Random walk of the rate by unmodelled torques, (rad/s)/√s.
    pub rate_walk_rad_s_sqrt_s: f32,
    /// Random walk of each inertia element, kg m²/√s.
    pub inertia_walk_kg_m2_sqrt_s: [f32; 6],
    /// Largest accepted innovation on any axis, sigmas, above zero.
    pub spike_limit_sigma: f32,
    /// Consecutive spikes that make a lock-out, up to 65535.
    pub lockout_after: u32,
    /// 1 where `initial_rate_rad_s` is set, 0: the first sample.
    pub has_initial_rate: u32,
    /// Expected rate at the first sample, rad/s, body axes.
    pub initial_rate_rad_s: [f32; 3],
    /// One sigma of it on each axis, rad/s, above zero.
    pub initial_rate_sigma_rad_s: f32,
}

/// One gyro sample with the drive of the body at its instant.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_sample {
    /// `sizeof(fsw_sample)`.
    pub struct_size: u32,
    /// Not used.
    pub reserved: u32,
    /// Time stamp, µs since any epoch.
    pub time_us: u64,
    /// Gyro reading: body rate relative to inertial space, rad/s, body axes.
    pub rate_rad_s: [f32; 3],
    /// Speed of each wheel relative to the body, rad/s, positive about its axis.
    pub wheel_speed_rad_s: [f32; FSW_WHEELS],
    /// External torque without that of the wheels, N m, body axes; zero where unknown.
    pub torque_n_m: [f32; 3],
}

/// Outcome of a step. Below 16 the estimate was updated or kept, from 16 part of the state
/// was initialised.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum fsw_outcome_code {
    /// The sample updated the estimate.
    Updated = 0,
    /// Rejected: a value is infinite or NaN.
    NotFinite = 1,
    /// Rejected: a rate at or beyond the range of the gyro.
    OutOfRange = 2,
    /// Rejected: time stamp not later than that of the last usable sample.
    OutOfOrder = 3,
    /// Rejected: the gyro repeats its reading to the last bit.
    Stuck = 4,
    /// Not used: too far from the prediction.
    Spike = 5,
    /// Used; the motion is not yet sufficient for a first estimate.
    Aligning = 6,
    /// Used for the rate alone. Not returned by the estimators of this interface.
    Refilling = 7,
    /// Attitude missing. Not returned by the estimators of this interface.
    NoAttitude = 8,
    /// The body moves at the start. Not returned by the estimators of this interface.
    WaitingForRest = 9,
    /// Reset: first usable sample.
    ResetFirstSample = 16,
    /// Reset: first estimate of the inertia from the motion.
    ResetAligned = 17,
    /// Reset of the rate after a gap in time; the inertia is kept.
    ResetGap = 18,
    /// Reset of the rate after a change of the clock; the inertia is kept.
    ResetClock = 19,
    /// Reset after a series of spikes.
    ResetLockout = 20,
    /// Reset: a fault in mid-motion has ended; its data are discarded.
    ResetInterrupted = 21,
    /// Reset: newer data contradict the inertia known before, which is discarded.
    ResetChanged = 22,
    /// Reset of a state that was not finite.
    ResetDiverged = 23,
}

/// Result of a step.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_outcome {
    /// `sizeof(fsw_outcome)`, set by the caller.
    pub struct_size: u32,
    /// Use of the sample, and reason.
    pub code: fsw_outcome_code,
    /// 1 where the sample entered the state.
    pub used_sample: u32,
    /// Filtered body rate, rad/s, body axes. `window` does not filter.
    pub rate_rad_s: [f32; 3],
    /// 1 where the sample was predicted, by `joint-ekf`: the innovation is valid.
    pub has_innovation: u32,
    /// Measured minus predicted rate, rad/s.
    pub innovation_rad_s: [f32; 3],
    /// Variance of it on each axis, rad²/s².
    pub innovation_variance_rad2_s2: [f32; 3],
}

/// Work that is left.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum fsw_remaining {
    /// None: the estimate contains everything that it can.
    Nothing = 0,
    /// At least one slice.
    Some = 1,
}

/// Usability of an estimate.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum fsw_status {
    /// Six directions observed, residuals explained: use the tensor with its covariance.
    Converged = 0,
    /// Some directions observed: use the elements of `observed_elements`, each within its sigma.
    Partial = 1,
    /// No direction observed.
    Unobservable = 2,
    /// Residuals not explained: do not use the numbers.
    Diverged = 3,
}

/// Inertia tensor with its covariance.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_estimate {
    /// `sizeof(fsw_estimate)`, set by the caller.
    pub struct_size: u32,
    /// Usability.
    pub status: fsw_status,
    /// Elements `jxx jyy jzz jxy jxz jyz`, kg m², body axes about the centre of mass, wheels locked: the angular
    /// momentum is `J ω + Σ Iₛ Ω a`, Ω relative to the body. `jxy` is the tensor entry, −∫xy dm.
    pub inertia_kg_m2: [f32; 6],
    /// One sigma of each element, kg m².
    pub sigma_kg_m2: [f32; 6],
    /// Covariance of the six elements, kg² m⁴, by rows. It includes the stated errors of the hardware.
    pub covariance_kg2_m4: [[f32; 6]; 6],
    /// 1 where `sigma_random_kg_m2` is set: the hardware is not ideal.
    pub has_sigma_random: u32,
    /// One sigma of each element by the noise alone, kg m².
    pub sigma_random_kg_m2: [f32; 6],
    /// Observed directions in the space of the six elements, 0 to 6.
    pub observed_directions: u32,
    /// Bit i is set where element i is observed: its sigma by the data, to first order, is below a tenth of the mean
    /// moment, a twentieth for products. Where the scale is badly known, `sigma_kg_m2` is larger than that.
    pub observed_elements: u32,
    /// 1 where the trace is observed: the size of the tensor and not only its ratios.
    pub observed_scale: u32,
    /// 1 where `disturbance_torque_n_m` is set.
    pub has_disturbance_torque: u32,
    /// Constant disturbance torque, N m, body axes.
    pub disturbance_torque_n_m: [f32; 3],
    /// 1 where `gyro_bias_rad_s` is set.
    pub has_gyro_bias: u32,
    /// Gyro bias, rad/s, body axes.
    pub gyro_bias_rad_s: [f32; 3],
    /// RMS of measured minus predicted rate, all axes, rad/s.
    pub residual_rms_rad_s: f32,
    /// 1 where the residuals agree with white noise, 0 where not, -1 without a test.
    pub residuals_white: i32,
    /// 1 where the data alone lead to an unphysical tensor: the elements are those of the nearest physical one.
    pub projected: u32,
}

/// Parameter of the hardware.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum fsw_parameter {
    /// Scale factor error of gyro axis `first`, share.
    GyroScale = 0,
    /// Reading of gyro axis `first` of a rate about axis `second`, rad.
    GyroAxes = 1,
    /// Spin inertia of wheel `first`, share.
    WheelInertia = 2,
    /// Tilt of the axis of wheel `first`, direction `second`, rad.
    WheelAxis = 3,
    /// Time offset of the gyro, s.
    Delay = 4,
    /// Scale of the known torque, share.
    TorqueScale = 5,
    /// Common error of the spin inertias, share.
    CommonWheelInertia = 6,
    /// Turn of all sensors as one about axis `first`, rad.
    Mount = 7,
    /// Constant bias of gyro axis `first`, rad/s.
    GyroBias = 8,
    /// Constant disturbance torque about axis `first`, N m.
    DisturbanceTorque = 9,
    /// Element `second` of the modal inertia of mode `first`, kg m². Not returned by this interface.
    ModalInertia = 10,
    /// Frequency of mode `first`, share. Not returned by this interface.
    ModeFrequency = 11,
    /// Damping ratio of mode `first`, share. Not returned by this interface.
    ModeDamping = 12,
}

/// Result on one parameter of the hardware.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fsw_finding {
    /// `sizeof(fsw_finding)`.
    pub struct_size: u32,
    /// The parameter, with its unit.
    pub parameter: fsw_parameter,
    /// First index of the parameter, from zero.
    pub first: u32,
    /// Second index of the parameter, from zero.
    pub second: u32,
    /// Estimate; zero for a parameter that is considered and not estimated.
    pub value: f32,
    /// One sigma after the data.
    pub sigma: f32,
    /// One sigma as stated.
    pub stated: f32,
    /// Shift of the six elements by one sigma of what the data leave of it, kg m².
    pub effect_kg_m2: [f32; 6],
}

/// Takes one word of a state. Returns zero where the medium is full.
pub type fsw_write_word = Option<unsafe extern "C" fn(context: *mut c_void, word: u32) -> i32>;
/// Reads the next word of a state. Returns zero at the end of the medium.
pub type fsw_read_word = Option<unsafe extern "C" fn(context: *mut c_void, word: *mut u32) -> i32>;
/// Takes one finding, valid during the call.
pub type fsw_take_finding =
    Option<unsafe extern "C" fn(context: *mut c_void, finding: *const fsw_finding)>;
