//! Each refusal of the interface, by its code, and nothing written.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]
#![allow(
    unsafe_code,
    reason = "calls of the C interface, with the pointers that are to be refused"
)]

use core::ffi::{c_char, c_int, c_void};
use fsw_core_c::joint_ekf::*;
use fsw_core_c::sizes::*;
use fsw_core_c::window::*;
use fsw_core_c::*;
use std::ptr::{null, null_mut};

/// Byte of memory that must not be written.
const CANARY: u8 = 0xa5;
/// Gyro noise, rad/s.
const NOISE: f32 = 1e-4;

/// Zeroed struct with its size as first member, as a caller in C has it.
fn sized<T>() -> T {
    // SAFETY: structs of numbers, and of enums with a variant of zero.
    unsafe {
        let mut value: T = std::mem::zeroed();
        (&raw mut value).cast::<u32>().write(size_of::<T>() as u32);
        value
    }
}

fn config() -> fsw_window_config {
    let mut config = sized::<fsw_window_config>();
    // SAFETY: a valid pointer.
    assert_eq!(unsafe { fsw_window_config_defaults(&mut config, NOISE) }, fsw_result::Ok);
    config
}

/// Memory with canaries in each byte.
fn memory() -> Box<fsw_window> {
    let word = u64::from_ne_bytes([CANARY; 8]);
    Box::new(fsw_window { memory: [word; FSW_WINDOW_SIZE_U64] })
}

fn started() -> Box<fsw_window> {
    let mut memory = memory();
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_init((&raw mut *memory).cast(), FSW_WINDOW_SIZE, &config()) };
    assert_eq!(result, fsw_result::Ok);
    memory
}

fn bytes<T>(value: &T) -> Vec<u8> {
    // SAFETY: bytes of an object; the structs here have no padding that a test compares.
    unsafe { std::slice::from_raw_parts((&raw const *value).cast(), size_of::<T>()) }.to_vec()
}

/// The call is refused by this code, and leaves the memory as it was.
fn refused<T>(memory: &mut T, code: fsw_result, call: impl FnOnce(*mut T) -> fsw_result) {
    let before = bytes(memory);
    assert_eq!(call(memory), code);
    assert!(bytes(memory) == before, "written to in spite of {code:?}");
}

#[test]
fn init_refuses_null_short_and_misaligned_memory() {
    let config = config();
    // SAFETY (all of the test): pointers are null, or to the memory stated.
    let init = |memory: *mut c_void, bytes, config: *const _| unsafe {
        fsw_window_init(memory, bytes, config)
    };
    assert_eq!(init(null_mut(), FSW_WINDOW_SIZE, &config), fsw_result::NullPointer);
    let short = fsw_window_size() - 1;
    refused(&mut *memory(), fsw_result::MemoryShort, |m| init(m.cast(), short, &config));
    refused(&mut *memory(), fsw_result::MemoryShort, |m| init(m.cast(), 0, &config));
    for offset in [1, 2, 4] {
        refused(&mut *memory(), fsw_result::Misaligned, |m| {
            init(m.wrapping_byte_add(offset).cast(), FSW_WINDOW_SIZE - 8, &config)
        });
    }
    refused(&mut *memory(), fsw_result::NullPointer, |m| init(m.cast(), FSW_WINDOW_SIZE, null()));
}

/// One byte less than needed is refused, and the exact size is enough: nothing is written beyond it.
#[test]
fn init_keeps_within_the_exact_size() {
    let mut memory = memory();
    let size = fsw_window_size();
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_init((&raw mut *memory).cast(), size, &config()) };
    assert_eq!(result, fsw_result::Ok);
    let mut outcome = sized::<fsw_outcome>();
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_step(&mut *memory, &sized::<fsw_sample>(), &mut outcome) };
    assert_eq!((result, outcome.code), (fsw_result::Ok, fsw_outcome_code::ResetFirstSample));
    assert!(bytes(&*memory)[size..].iter().all(|byte| *byte == CANARY));
}

#[test]
fn a_wrong_struct_size_is_refused_by_each_function() {
    let wrong = |size: u32| [0, size - 4, size + 4, u32::MAX];
    for size in wrong(FSW_WINDOW_CONFIG_SIZE as u32) {
        let mut config = fsw_window_config { struct_size: size, ..config() };
        // SAFETY: valid pointers, here and below.
        refused(&mut *memory(), fsw_result::StructSize, |m| unsafe {
            fsw_window_init(m.cast(), FSW_WINDOW_SIZE, &config)
        });
        refused(&mut config, fsw_result::StructSize, |c| unsafe {
            fsw_window_config_defaults(c, NOISE)
        });
    }
    for size in wrong(FSW_SAMPLE_SIZE as u32) {
        let sample = fsw_sample { struct_size: size, ..sized() };
        let mut outcome = sized::<fsw_outcome>();
        refused(&mut *started(), fsw_result::StructSize, |w| unsafe {
            fsw_window_step(w, &sample, &mut outcome)
        });
        assert_eq!(outcome.used_sample, 0, "outcome not written");
    }
    for size in wrong(FSW_OUTCOME_SIZE as u32) {
        let mut outcome = fsw_outcome { struct_size: size, ..sized() };
        refused(&mut *started(), fsw_result::StructSize, |w| unsafe {
            fsw_window_step(w, &sized(), &mut outcome)
        });
    }
    for size in wrong(FSW_ESTIMATE_SIZE as u32) {
        let mut estimate = fsw_estimate { struct_size: size, ..sized() };
        let window = started();
        refused(&mut estimate, fsw_result::StructSize, |e| unsafe {
            fsw_window_estimate(&*window, e)
        });
    }
}

unsafe extern "C" fn must_not_write(_: *mut c_void, _: u32) -> c_int {
    panic!("called")
}

unsafe extern "C" fn must_not_read(_: *mut c_void, _: *mut u32) -> c_int {
    panic!("called")
}

/// Every function of a handle: null, misaligned, memory that was never initialised, and memory of the other estimator.
#[test]
fn a_handle_is_checked_by_each_function() {
    type Call<'a> = Box<dyn Fn(*mut fsw_window) -> fsw_result + 'a>;
    let six = [1.0f32; 6];
    // SAFETY: handles that are refused; other pointers are valid.
    let calls: [Call; 9] = unsafe {
        [
            Box::new(|w| fsw_window_step(w, &sized(), &mut sized())),
            Box::new(|w| fsw_window_work(w, 1, &mut fsw_remaining::Nothing)),
            Box::new(|w| fsw_window_finish(w)),
            Box::new(|w| fsw_window_close(w)),
            Box::new(|w| fsw_window_estimate(w, &mut sized())),
            Box::new(|w| fsw_window_findings(w, Some(take), null_mut())),
            Box::new(|w| fsw_window_set_prior(w, six.as_ptr(), six.as_ptr())),
            Box::new(|w| fsw_window_save(w, Some(must_not_write), null_mut())),
            Box::new(|w| fsw_window_restore(w, Some(must_not_read), null_mut())),
        ]
    };
    for call in &calls {
        assert_eq!(call(null_mut()), fsw_result::NullPointer);
        refused(&mut *started(), fsw_result::Misaligned, |w| call(w.wrapping_byte_add(4)));
        refused(&mut *memory(), fsw_result::Uninitialised, call);
        let mut zeros = Box::new(fsw_window { memory: [0; FSW_WINDOW_SIZE_U64] });
        refused(&mut *zeros, fsw_result::Uninitialised, call);
        let mut other = memory();
        let mut filter = sized::<fsw_joint_ekf_config>();
        // SAFETY: valid pointers.
        unsafe {
            assert_eq!(fsw_joint_ekf_config_defaults(&mut filter, NOISE), fsw_result::Ok);
            let place = (&raw mut *other).cast();
            assert_eq!(fsw_joint_ekf_init(place, FSW_WINDOW_SIZE, &filter), fsw_result::Ok);
        }
        refused(&mut *other, fsw_result::Uninitialised, call);
    }
}

unsafe extern "C" fn take(_: *mut c_void, _: *const fsw_finding) {}

#[test]
fn null_arguments_are_refused_and_nothing_is_written() {
    let six = [1.0f32; 6];
    // SAFETY: null or valid pointers.
    unsafe {
        let code = fsw_result::NullPointer;
        let mut outcome = sized();
        refused(&mut *started(), code, |w| fsw_window_step(w, null(), &mut outcome));
        refused(&mut *started(), code, |w| fsw_window_step(w, &sized(), null_mut()));
        refused(&mut *started(), code, |w| fsw_window_work(w, 1, null_mut()));
        refused(&mut *started(), code, |w| fsw_window_estimate(w, null_mut()));
        refused(&mut *started(), code, |w| fsw_window_set_prior(w, null(), six.as_ptr()));
        refused(&mut *started(), code, |w| fsw_window_set_prior(w, six.as_ptr(), null()));
        refused(&mut *started(), code, |w| fsw_window_save(w, None, null_mut()));
        refused(&mut *started(), code, |w| fsw_window_restore(w, None, null_mut()));
        refused(&mut *started(), code, |w| fsw_window_findings(w, None, null_mut()));
        assert_eq!(fsw_window_config_defaults(null_mut(), NOISE), code);
        assert_eq!(fsw_window_config_check(&config(), null_mut(), 80), code);
    }
}

fn text_of(config: &fsw_window_config) -> (fsw_result, String) {
    let mut text = [CANARY as c_char; 80];
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_config_check(config, text.as_mut_ptr(), text.len()) };
    // SAFETY: a text with a final zero.
    let text = unsafe { core::ffi::CStr::from_ptr(text.as_ptr()) };
    (result, text.to_str().unwrap().into())
}

#[test]
fn a_value_out_of_its_range_is_refused_by_name() {
    let good = config();
    assert_eq!(text_of(&good), (fsw_result::Ok, String::new()));
    let refused_text = |change: fn(&mut fsw_window_config)| {
        let mut bad = good;
        change(&mut bad);
        refused(&mut *memory(), fsw_result::Config, |m| {
            // SAFETY: valid pointers.
            unsafe { fsw_window_init(m.cast(), FSW_WINDOW_SIZE, &bad) }
        });
        let (result, text) = text_of(&bad);
        assert_eq!(result, fsw_result::Config);
        text
    };
    let text = refused_text(|c| c.gyro_noise_rad_s = -1.0);
    assert_eq!(text, "gyro_noise_rad_s: must be above zero");
    let text = refused_text(|c| c.gyro_noise_rad_s = f32::NAN);
    assert_eq!(text, "gyro_noise_rad_s: must be a finite number");
    let text = refused_text(|c| c.wheels.axis[2] = [0.0; 3]);
    assert_eq!(text, "wheel.axis: an axis must have a length above zero");
    let text = refused_text(|c| c.gate.stuck_after = 65_536);
    assert_eq!(text, "gate.stuck_after: is beyond the largest permitted value");
    let text = refused_text(|c| {
        (c.has_prior, c.prior.inertia_kg_m2) = (1, [1.0, 1.0, 3.0, 0.0, 0.0, 0.0])
    });
    assert_eq!(text, "prior.inertia_kg_m2: is the tensor of no rigid body");
    let text = refused_text(|c| {
        (c.disturbance_torque_n_m, c.gyro_bias_rad_s, c.drag_per_s) = (1.0, 1.0, 1.0);
        c.hardware.gyro_scale = 0.01;
    });
    assert_eq!(text, "hardware: has no place: see FSW_WINDOW_UNKNOWNS");
}

/// A prior that is refused leaves the estimator as it was.
#[test]
fn an_unphysical_prior_is_refused() {
    let (bad, sigma) = ([1.0, 1.0, 3.0, 0.0, 0.0, 0.0f32], [0.1f32; 6]);
    refused(&mut *started(), fsw_result::Config, |w| {
        // SAFETY: valid pointers.
        unsafe { fsw_window_set_prior(w, bad.as_ptr(), sigma.as_ptr()) }
    });
}

/// A short buffer cuts the text and nothing is written beyond it.
#[test]
fn a_text_is_cut_to_its_buffer() {
    let mut config = config();
    config.quiet_s = -1.0;
    let mut text = [CANARY as c_char; 16];
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_config_check(&config, text.as_mut_ptr(), 6) };
    assert_eq!(result, fsw_result::Config);
    assert_eq!(text[..6], b"quiet\0".map(|byte| byte as c_char));
    assert!(text[6..].iter().all(|byte| *byte == CANARY as c_char));
}
