//! C interface of `fsw-core`: the estimators `window` and `joint-ekf` in the caller's memory, `f32`, up to four
//! wheels.
//!
//! ```text
//!  C: memory, config ─► fsw_*_init ─► fsw_*_step(sample) ─► outcome
//!                                     fsw_window_work(slices), in idle time
//!                                     fsw_*_estimate, at the rate of telemetry
//!                                     fsw_*_save, fsw_*_restore: words by call-back
//! ```
//!
//! # Contract
//!
//! * No allocation, no global state, no panic. An estimator is the memory that its pointer points to.
//! * `struct_size` is the first member of each struct that crosses the interface: its `sizeof` in C. Another value is
//!   refused.
//! * A refused call returns a code other than [`fsw_result::Ok`] and has written nothing. The one exception is
//!   `fsw_*_restore`, which starts the estimator anew once the words have been found invalid.
//! * An estimator is used by one task at a time. Two estimators are independent.
//! * Units, frames and symbols are those of `fsw-core`: SI, body axes, elements in the order `jxx jyy jzz jxy jxz jyz`.
//!
//! # Modules
//!
//! | module | contents |
//! |---|---|
//! | [`sizes`] | numbers of wheels, blocks, unknowns; memory of an estimator |
//! | [`types`] | structs and enums of the header |
//! | `config` | configuration of C to that of `fsw-core` |
//! | `memory` | checks of pointers; the estimator in the caller's memory |
//! | `report` | outcome, estimate and findings of `fsw-core` to structs of C |
//! | `words` | call-backs as a medium of a checkpoint |
//! | [`window`], [`joint_ekf`], [`version`] | functions of the header |
//!
//! The header `include/fsw_core.h` is generated from these modules by cbindgen.
#![no_std]
#![allow(non_camel_case_types, reason = "names of the header")]

#[cfg(feature = "std")]
extern crate std;

mod config;
#[allow(unsafe_code, reason = "functions without mangled names")]
pub mod joint_ekf;
#[allow(unsafe_code, reason = "pointers of C, each with its checks")]
mod memory;
mod report;
pub mod sizes;
pub mod types;
#[allow(unsafe_code, reason = "functions without mangled names")]
pub mod version;
#[allow(unsafe_code, reason = "functions without mangled names")]
pub mod window;
#[allow(unsafe_code, reason = "call-backs")]
mod words;

pub use types::*;

/// A static library needs a handler although no function of this crate panics: the linker removes it. A panic of
/// other code halts here until a watchdog resets the processor.
#[cfg(all(feature = "panic-handler", not(feature = "std")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
