//! Compile-time sizes: the only place to change for another spacecraft. The header follows by regeneration.
//!
//! Memory is stated as a constant that holds on 32-bit and 64-bit processors, since state contains indices. The
//! exact size of a build is a function (`fsw_window_size`).

use crate::memory::Slot;
use fsw_core::estimator::joint_ekf::JointEkfUd;
use fsw_core::estimator::window::Window;

/// Number of wheels. A spacecraft with fewer sets the spin inertia of the others to zero.
pub const FSW_WHEELS: usize = 4;

/// Blocks of a window: up to 48 turns of the body.
const BLOCKS: usize = 512;
/// Unknowns of a window: momentum and inertia 9, three groups of three. Disturbance torque, gyro bias and drag take one
/// each where they are asked for. Stated errors of the hardware need one: time offset, torque scale and common spin inertia.
pub const FSW_WINDOW_UNKNOWNS: usize = 18;
/// Groups of hardware errors that a window considers: gyro 3, one for each wheel.
pub(crate) const CONSIDERED: usize = 3 + FSW_WHEELS;
/// Parameters that `joint-ekf` considers: gyro 9, wheels 3 each, time offset, common spin inertia, torque scale; gyro
/// bias 3, disturbance torque 3.
pub(crate) const PARAMETERS: usize = 12 + 3 * FSW_WHEELS + 6;

pub(crate) type WindowF32 = Window<f32, FSW_WHEELS, BLOCKS, FSW_WINDOW_UNKNOWNS, CONSIDERED>;
pub(crate) type JointEkfF32 = JointEkfUd<f32, FSW_WHEELS, PARAMETERS>;

/// Alignment of the memory of an estimator, bytes.
pub const FSW_ALIGN: usize = 8;
/// Memory of `window` on any processor, bytes. A build needs fsw_window_size() of them.
pub const FSW_WINDOW_SIZE: usize = 55_296;
/// The same in words of 64 bits.
pub const FSW_WINDOW_SIZE_U64: usize = 6_912;
/// Memory of `joint-ekf` on any processor, bytes. A build needs fsw_joint_ekf_size() of them.
pub const FSW_JOINT_EKF_SIZE: usize = 8_192;
/// The same in words of 64 bits.
pub const FSW_JOINT_EKF_SIZE_U64: usize = 1_024;
/// Words of a medium for a checkpoint of `window`, fingerprint included. The longest one measured has 10,299, of storage
/// full of blocks.
pub const FSW_WINDOW_WORDS: usize = 13_312;
/// Words of a medium for a checkpoint of `joint-ekf`, fingerprint included. The longest one measured has 1,487.
pub const FSW_JOINT_EKF_WORDS: usize = 2_048;

/// `sizeof(fsw_window_config)`.
pub const FSW_WINDOW_CONFIG_SIZE: usize = 264;
/// `sizeof(fsw_joint_ekf_config)`.
pub const FSW_JOINT_EKF_CONFIG_SIZE: usize = 280;
/// `sizeof(fsw_sample)`.
pub const FSW_SAMPLE_SIZE: usize = 56;
/// `sizeof(fsw_outcome)`.
pub const FSW_OUTCOME_SIZE: usize = 52;
/// `sizeof(fsw_estimate)`.
pub const FSW_ESTIMATE_SIZE: usize = 284;
/// `sizeof(fsw_finding)`.
pub const FSW_FINDING_SIZE: usize = 52;

// The same assertions stand at the foot of the header.
const _: () = {
    use crate::types::*;
    assert!(FSW_WINDOW_SIZE == 8 * FSW_WINDOW_SIZE_U64);
    assert!(FSW_JOINT_EKF_SIZE == 8 * FSW_JOINT_EKF_SIZE_U64);
    assert!(size_of::<fsw_window>() == FSW_WINDOW_SIZE);
    assert!(size_of::<fsw_joint_ekf>() == FSW_JOINT_EKF_SIZE);
    assert!(size_of::<Slot<WindowF32>>() <= FSW_WINDOW_SIZE);
    assert!(size_of::<Slot<JointEkfF32>>() <= FSW_JOINT_EKF_SIZE);
    assert!(align_of::<Slot<WindowF32>>() <= FSW_ALIGN);
    assert!(align_of::<Slot<JointEkfF32>>() <= FSW_ALIGN);
    assert!(align_of::<fsw_window>() == FSW_ALIGN);
    assert!(size_of::<fsw_window_config>() == FSW_WINDOW_CONFIG_SIZE);
    assert!(size_of::<fsw_joint_ekf_config>() == FSW_JOINT_EKF_CONFIG_SIZE);
    assert!(size_of::<fsw_sample>() == FSW_SAMPLE_SIZE);
    assert!(size_of::<fsw_outcome>() == FSW_OUTCOME_SIZE);
    assert!(size_of::<fsw_estimate>() == FSW_ESTIMATE_SIZE);
    assert!(size_of::<fsw_finding>() == FSW_FINDING_SIZE);
};
