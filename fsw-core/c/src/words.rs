//! Call-backs as the medium of a checkpoint.
//!
//! Stream: fingerprint of the state's layout, then the words of the state. A checksum belongs to the medium: validation
//! does not detect every flipped bit.

use crate::memory::{Flown, Slot, code};
use crate::types::{fsw_read_word, fsw_result, fsw_write_word};
use core::ffi::c_void;
use fsw_core::checkpoint::{self, Words};

/// Words go to a call-back.
struct Writer {
    write: unsafe extern "C" fn(*mut c_void, u32) -> i32,
    context: *mut c_void,
}

impl Words for Writer {
    fn transfer(&mut self, word: &mut u32) -> bool {
        // SAFETY: a function that the caller of `save` passed, with the context that it passed.
        unsafe { (self.write)(self.context, *word) != 0 }
    }
}

/// Words come from a call-back.
struct Reader {
    read: unsafe extern "C" fn(*mut c_void, *mut u32) -> i32,
    context: *mut c_void,
}

impl Words for Reader {
    fn transfer(&mut self, word: &mut u32) -> bool {
        // SAFETY: a function that the caller of `restore` passed, with the context that it passed and a valid word.
        unsafe { (self.read)(self.context, word) != 0 }
    }
}

/// Writes fingerprint and state of an estimator.
pub(crate) fn save<E: Flown>(
    handle: *mut E::Memory,
    write: fsw_write_word,
    context: *mut c_void,
) -> fsw_result {
    code(|| {
        let write = write.ok_or(fsw_result::NullPointer)?;
        let slot = Slot::<E>::of_mut(handle)?;
        let mut words = Writer { write, context };
        let mut fingerprint = checkpoint::fingerprint::<E>();
        if !words.transfer(&mut fingerprint) {
            return Err(fsw_result::Medium);
        }
        checkpoint::transfer(&mut slot.estimator, &mut words).map_err(refusal)?;
        Ok(fsw_result::Ok)
    })
}

/// Reads a state. After words that are not valid the estimator is started anew.
pub(crate) fn restore<E: Flown>(
    handle: *mut E::Memory,
    read: fsw_read_word,
    context: *mut c_void,
) -> fsw_result {
    code(|| {
        let read = read.ok_or(fsw_result::NullPointer)?;
        let slot = Slot::<E>::of_mut(handle)?;
        let mut words = Reader { read, context };
        let mut fingerprint = 0;
        if !words.transfer(&mut fingerprint) {
            return Err(fsw_result::Medium);
        }
        if fingerprint != checkpoint::fingerprint::<E>() {
            return Err(fsw_result::Fingerprint);
        }
        checkpoint::transfer(&mut slot.estimator, &mut words).map_err(|invalid| {
            // The state is partly overwritten.
            let _ = slot.restart();
            refusal(invalid)
        })?;
        Ok(fsw_result::Ok)
    })
}

fn refusal(invalid: checkpoint::InvalidWord) -> fsw_result {
    if invalid.place == "end" { fsw_result::Medium } else { fsw_result::State }
}
