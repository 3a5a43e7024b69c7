//! Identity of the library.

use crate::sizes::{JointEkfF32, WindowF32};
use crate::types::{
    fsw_estimate, fsw_joint_ekf_config, fsw_outcome, fsw_sample, fsw_window_config,
};
use core::ffi::c_char;
use fsw_core::checkpoint::{fingerprint, mix};
use fsw_core::persist::name;

/// Version of the library, text with a final zero.
#[unsafe(no_mangle)]
pub extern "C" fn fsw_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Fingerprint of the build, for telemetry: of version, layout of both states, sizes of the structs and width of a
/// pointer. Two builds with equal fingerprints exchange checkpoints and structs.
#[unsafe(no_mangle)]
pub extern "C" fn fsw_build_fingerprint() -> u32 {
    [
        fingerprint::<WindowF32>(),
        fingerprint::<JointEkfF32>(),
        size_of::<fsw_window_config>() as u32,
        size_of::<fsw_joint_ekf_config>() as u32,
        size_of::<fsw_sample>() as u32,
        size_of::<fsw_outcome>() as u32,
        size_of::<fsw_estimate>() as u32,
        usize::BITS,
    ]
    .into_iter()
    .fold(const { name(env!("CARGO_PKG_VERSION")) }, mix)
}
