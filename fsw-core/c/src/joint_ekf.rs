//! Functions of `joint-ekf`.

use crate::config::{self, JointEkfStart};
use crate::memory::{Flown, Output, Slot, code, input, six};
use crate::sizes::JointEkfF32;
use crate::types::*;
use crate::{report, words};
use core::ffi::{c_char, c_void};
use fsw_core::checkpoint;
use fsw_core::{ConfigError, Estimator, Prior};

impl Flown for JointEkfF32 {
    type Start = JointEkfStart;
    type Memory = fsw_joint_ekf;

    #[inline(never)]
    unsafe fn construct(place: *mut Self, start: &JointEkfStart) -> Result<(), ConfigError> {
        // SAFETY: as of this function. Built in its place: `in_place` is inlined.
        let filter = unsafe {
            place.write(Self::in_place(start.config, start.wheels));
            &mut *place
        };
        filter.consider(&start.hardware, &start.disturbance)?;
        filter.complete();
        Ok(())
    }

    fn set_prior(start: &mut JointEkfStart, prior: Prior<f32>) {
        start.config.prior = Some(prior);
    }
}

/// Exact size of a `joint-ekf` in this build, bytes: at most FSW_JOINT_EKF_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn fsw_joint_ekf_size() -> usize {
    size_of::<Slot<JointEkfF32>>()
}

/// Fingerprint of the state: first word of a checkpoint. Another layout or version has another one.
#[unsafe(no_mangle)]
pub extern "C" fn fsw_joint_ekf_fingerprint() -> u32 {
    checkpoint::fingerprint::<JointEkfF32>()
}

/// Sets the defaults for a gyro of this noise: no prior, no wheels, ideal hardware.
///
/// `gyro_noise_rad_s`: one sigma, white, per sample, rad/s, above zero.
///
/// Returns OK; NULL_POINTER, MISALIGNED; STRUCT_SIZE unless `config->struct_size` is set.
///
/// # Safety
/// `config` points to a writable struct, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_config_defaults(
    config: *mut fsw_joint_ekf_config,
    gyro_noise_rad_s: f32,
) -> fsw_result {
    code(|| Ok(Output::of(config)?.set(config::joint_ekf_defaults(gyro_noise_rad_s))))
}

/// Checks a configuration, and names the first field that is out of its range.
///
/// `text`: buffer of `bytes` bytes for field and reason with a final zero, such as
/// `prior.sigma_kg_m2: must be above zero`; 80 bytes hold every text, a shorter buffer cuts it. Empty where OK.
///
/// Returns OK; CONFIG; NULL_POINTER, MISALIGNED, STRUCT_SIZE; MEMORY_SHORT for a buffer of no bytes.
///
/// # Safety
/// `config` points to a struct and `text` to `bytes` writable bytes, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_config_check(
    config: *const fsw_joint_ekf_config,
    text: *mut c_char,
    bytes: usize,
) -> fsw_result {
    code(|| report::check_config(config, text, bytes))
}

/// Starts an estimator in the caller's memory. Memory that holds one already is started anew.
///
/// `memory`: aligned to FSW_ALIGN, such as a `fsw_joint_ekf`; `bytes`: its length, at least fsw_joint_ekf_size(). It may hold
/// anything, and belongs to the estimator from then on. A copy of the memory is an estimator of its own.
///
/// Returns OK; NULL_POINTER, MISALIGNED, MEMORY_SHORT, STRUCT_SIZE; CONFIG, with the field named by
/// fsw_joint_ekf_config_check(). Nothing is written unless OK.
///
/// # Safety
/// `memory` points to `bytes` writable bytes and `config` to a struct, or is null. They do not overlap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const fsw_joint_ekf_config,
) -> fsw_result {
    code(|| Slot::<JointEkfF32>::init(memory, bytes, config))
}

/// Takes in one sample, as it arrives. A sample that is not usable is an outcome, not a refusal. Bounded work for any
/// content of the sample.
///
/// Returns OK; NULL_POINTER, MISALIGNED, UNINITIALISED, STRUCT_SIZE of sample or outcome. Nothing is written unless OK.
///
/// # Safety
/// Each pointer points to a struct of its type, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_step(
    joint_ekf: *mut fsw_joint_ekf,
    sample: *const fsw_sample,
    outcome: *mut fsw_outcome,
) -> fsw_result {
    code(|| {
        let slot = Slot::<JointEkfF32>::of_mut(joint_ekf)?;
        let (sample, outcome) = (input(sample)?, Output::of(outcome)?);
        let result = slot.estimator.step(&sample.sample());
        Ok(outcome.set(report::outcome(result, &slot.estimator)))
    })
}

/// Present estimate, valid at any time. Costs an eigenproblem of six: at the rate of telemetry.
///
/// Returns OK; NULL_POINTER, MISALIGNED, UNINITIALISED, STRUCT_SIZE. Nothing is written unless OK.
///
/// # Safety
/// Each pointer points to a struct of its type, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_estimate(
    joint_ekf: *const fsw_joint_ekf,
    estimate: *mut fsw_estimate,
) -> fsw_result {
    code(|| {
        let slot = Slot::<JointEkfF32>::of(joint_ekf)?;
        let estimate = Output::of(estimate)?;
        Ok(estimate.set(report::estimate(&slot.estimator.estimate())))
    })
}

/// Calls `take` with the result on each parameter of the hardware that is estimated or considered: once each, within this
/// call. `take` must not call functions on the same estimator.
///
/// Returns OK; NULL_POINTER, MISALIGNED, UNINITIALISED.
///
/// # Safety
/// `joint_ekf` points to an estimator, or is null; `take` is a function for this `context`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_findings(
    joint_ekf: *const fsw_joint_ekf,
    take: fsw_take_finding,
    context: *mut c_void,
) -> fsw_result {
    code(|| {
        let take = take.ok_or(fsw_result::NullPointer)?;
        let slot = Slot::<JointEkfF32>::of(joint_ekf)?;
        slot.estimator.each_of_hardware(&mut |finding| {
            let finding = report::finding(&finding);
            // SAFETY: a function that the caller passed, with the context that it passed.
            unsafe { take(context, &finding) }
        });
        Ok(fsw_result::Ok)
    })
}

/// Starts the estimator anew with another prior, and the configuration of `init` otherwise.
///
/// `inertia_kg_m2`, `sigma_kg_m2`: six elements and one sigma of each, kg m², as in fsw_prior.
///
/// Returns OK; NULL_POINTER, MISALIGNED, UNINITIALISED; CONFIG for the tensor of no rigid body or a sigma that is not
/// positive. Nothing is written unless OK.
///
/// # Safety
/// `joint_ekf` points to an estimator and the others to six numbers each, or are null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_set_prior(
    joint_ekf: *mut fsw_joint_ekf,
    inertia_kg_m2: *const f32,
    sigma_kg_m2: *const f32,
) -> fsw_result {
    code(|| {
        let slot = Slot::<JointEkfF32>::of_mut(joint_ekf)?;
        let prior = Prior { inertia_kg_m2: six(inertia_kg_m2)?, sigma_kg_m2: six(sigma_kg_m2)? };
        prior.validate().map_err(|_| fsw_result::Config)?;
        JointEkfF32::set_prior(&mut slot.start, prior);
        Ok(slot.restart())
    })
}

/// Writes the state as words, one by one: fingerprint, then the state. FSW_JOINT_EKF_WORDS words hold it.
/// A checksum belongs to the medium.
///
/// Returns OK; NULL_POINTER, MISALIGNED, UNINITIALISED; MEDIUM where `write` has returned zero. The estimator is unchanged
/// in each case.
///
/// # Safety
/// `joint_ekf` points to an estimator, or is null; `write` is a function for this `context`, and calls no function on the same
/// estimator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_save(
    joint_ekf: *mut fsw_joint_ekf,
    write: fsw_write_word,
    context: *mut c_void,
) -> fsw_result {
    words::save::<JointEkfF32>(joint_ekf, write, context)
}

/// Reads a state that fsw_joint_ekf_save() has written, into an estimator that `init` has started with the same configuration.
/// Every later result equals that of the saved estimator, bit for bit, if the time stamps have no gap.
///
/// Returns OK; NULL_POINTER, MISALIGNED, UNINITIALISED, FINGERPRINT, with nothing written; MEDIUM where `read` has returned
/// zero and STATE for a word that is not valid or another configuration. After these two the estimator is started anew.
///
/// # Safety
/// `joint_ekf` points to an estimator, or is null; `read` is a function for this `context`, and calls no function on the same
/// estimator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsw_joint_ekf_restore(
    joint_ekf: *mut fsw_joint_ekf,
    read: fsw_read_word,
    context: *mut c_void,
) -> fsw_result {
    words::restore::<JointEkfF32>(joint_ekf, read, context)
}
