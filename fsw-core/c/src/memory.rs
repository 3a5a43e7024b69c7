//! Pointers of C to references: every check, and every dereference, of the interface.
//!
//! ```text
//!  memory of C   ┌ seal, 2 words ┬ start data ┬ estimator ┐
//!                └───────────────┴────────────┴───────────┘ Slot
//! ```
//!
//! The seal is written last by `init` and depends on the kind of the estimator and the layout of its state: memory that
//! was never initialised, and memory of another kind or another version, is refused. By chance it is present once in
//! 2⁶⁴.

use crate::config::Configures;
use crate::types::*;
use core::ffi::c_void;
use core::ptr::{addr_of, addr_of_mut};
use fsw_core::checkpoint::{self, Persist};
use fsw_core::{ConfigError, Estimator, Prior};

/// An estimator of this interface.
pub(crate) trait Flown:
    Persist + Estimator<f32, { crate::sizes::FSW_WHEELS }> + Sized
{
    /// Configuration and wheels, checked.
    type Start: Copy;

    /// Memory as C declares it.
    type Memory;

    /// Constructs the estimator in its place, without a copy on the stack.
    ///
    /// # Safety
    /// `place` is valid for writes and aligned.
    unsafe fn construct(place: *mut Self, start: &Self::Start) -> Result<(), ConfigError>;

    /// Replaces the prior.
    fn set_prior(start: &mut Self::Start, prior: Prior<f32>);
}

/// An estimator with its start data.
#[repr(C)]
pub(crate) struct Slot<E: Flown> {
    seal: [u32; 2],
    pub start: E::Start,
    pub estimator: E,
}

impl<E: Flown> Slot<E> {
    /// Seal of an initialised estimator of this kind.
    fn seal() -> [u32; 2] {
        let first = checkpoint::fingerprint::<E>();
        [first, !first.rotate_left(16)]
    }

    /// Checks memory and configuration, then initialises the memory of C.
    ///
    /// # Errors
    /// As the results of `init` in the header.
    pub fn init<C: Configures<Start = E::Start> + SizedStruct>(
        memory: *mut c_void,
        bytes: usize,
        config: *const C,
    ) -> Result<fsw_result, fsw_result> {
        Self::check_memory(memory, bytes)?;
        let start = input(config)?.start().map_err(|_| fsw_result::Config)?;
        Ok(Self::fill(memory, &start))
    }

    /// Initialises the memory of C.
    fn fill(memory: *mut c_void, start: &E::Start) -> fsw_result {
        let slot = memory.cast::<Self>();
        // SAFETY: `check_memory` has found the pointer aligned and the memory long enough; C states that it is
        // writable. Members are written by raw pointers, since the memory holds no valid slot yet.
        unsafe {
            addr_of_mut!((*slot).seal).write([0; 2]);
            addr_of_mut!((*slot).start).write(*start);
            if E::construct(addr_of_mut!((*slot).estimator), start).is_err() {
                return fsw_result::Config;
            }
            addr_of_mut!((*slot).seal).write(Self::seal());
        }
        fsw_result::Ok
    }

    /// Checks the memory for an estimator.
    fn check_memory(memory: *const c_void, bytes: usize) -> Result<(), fsw_result> {
        check_pointer(memory.cast::<E::Memory>())?;
        if bytes < size_of::<Self>() { Err(fsw_result::MemoryShort) } else { Ok(()) }
    }

    /// Checks a handle.
    fn check(handle: *const E::Memory) -> Result<(), fsw_result> {
        check_pointer(handle)?;
        // SAFETY: not null and aligned; C states that it points to memory of the handle's type, whose first words
        // these are. Any bits are valid for an integer.
        let seal = unsafe { addr_of!((*handle.cast::<Self>()).seal).read() };
        if seal == Self::seal() { Ok(()) } else { Err(fsw_result::Uninitialised) }
    }

    /// The estimator of a handle.
    ///
    /// # Errors
    /// Null, misaligned or uninitialised.
    pub fn of<'a>(handle: *const E::Memory) -> Result<&'a Self, fsw_result> {
        Self::check(handle)?;
        // SAFETY: the seal shows a slot that `init` has completed. C states that no other call uses the estimator
        // at the same time.
        Ok(unsafe { &*handle.cast::<Self>() })
    }

    /// As [`of`](Self::of), mutable.
    pub fn of_mut<'a>(handle: *mut E::Memory) -> Result<&'a mut Self, fsw_result> {
        Self::check(handle)?;
        // SAFETY: as in `of`.
        Ok(unsafe { &mut *handle.cast::<Self>() })
    }

    /// Starts the estimator anew with the present start data.
    pub fn restart(&mut self) -> fsw_result {
        // SAFETY: a reference is a valid place. The previous state needs no drop: estimators own no resources.
        let started = unsafe { E::construct(&raw mut self.estimator, &self.start) };
        if started.is_err() { fsw_result::Config } else { fsw_result::Ok }
    }
}

/// Null and alignment.
fn check_pointer<T>(pointer: *const T) -> Result<(), fsw_result> {
    if pointer.is_null() {
        Err(fsw_result::NullPointer)
    } else if !pointer.is_aligned() {
        Err(fsw_result::Misaligned)
    } else {
        Ok(())
    }
}

/// Struct whose first member is its size.
///
/// # Safety
/// `repr(C)`, first member `u32`.
pub(crate) unsafe trait SizedStruct {}

macro_rules! sized_struct {
    ($($type:ty),*) => { $(
        // SAFETY: `repr(C)` with the member `struct_size: u32` first.
        unsafe impl SizedStruct for $type {}
    )* };
}

sized_struct!(fsw_window_config, fsw_joint_ekf_config, fsw_sample, fsw_outcome, fsw_estimate);

/// Null, alignment and size.
fn check_struct<T: SizedStruct>(pointer: *const T) -> Result<(), fsw_result> {
    check_pointer(pointer)?;
    // SAFETY: not null and aligned; the first member of such a struct is its size, and C states that the pointer is
    // to a struct.
    let size = unsafe { pointer.cast::<u32>().read() };
    if size as usize == size_of::<T>() { Ok(()) } else { Err(fsw_result::StructSize) }
}

/// A struct that C passes in.
///
/// # Errors
/// Null, misaligned, or of another size.
pub(crate) fn input<'a, T: SizedStruct>(pointer: *const T) -> Result<&'a T, fsw_result> {
    check_struct(pointer)?;
    // SAFETY: not null, aligned and of the right size. All members of an input are numbers, for which any bits are
    // valid.
    Ok(unsafe { &*pointer })
}

/// Place of a struct that C receives. Written as a whole: its previous contents may be anything.
pub(crate) struct Output<T>(*mut T);

impl<T: SizedStruct> Output<T> {
    /// Checks the pointer and the `struct_size` that the caller has set.
    ///
    /// # Errors
    /// Null, misaligned, or of another size.
    pub fn of(pointer: *mut T) -> Result<Self, fsw_result> {
        check_struct(pointer)?;
        Ok(Self(pointer))
    }
}

impl<T> Output<T> {
    /// Checks the pointer to a number.
    ///
    /// # Errors
    /// Null or misaligned.
    pub fn of_number(pointer: *mut T) -> Result<Self, fsw_result> {
        check_pointer(pointer)?;
        Ok(Self(pointer))
    }

    pub fn set(self, value: T) -> fsw_result {
        // SAFETY: `of` has checked the pointer; C states that the struct is writable.
        unsafe { self.0.write(value) };
        fsw_result::Ok
    }
}

/// Six numbers of C.
///
/// # Errors
/// Null or misaligned.
pub(crate) fn six(pointer: *const f32) -> Result<[f32; 6], fsw_result> {
    check_pointer(pointer)?;
    // SAFETY: not null and aligned; C states that six numbers follow.
    Ok(unsafe { pointer.cast::<[f32; 6]>().read() })
}

/// Copies text to a buffer of C, cut to its length, with a final zero.
///
/// # Errors
/// Null; a buffer without place for the zero.
pub(crate) fn set_text(
    buffer: *mut core::ffi::c_char,
    bytes: usize,
    parts: &[&str],
) -> Result<(), fsw_result> {
    check_pointer(buffer)?;
    let Some(last) = bytes.checked_sub(1) else { return Err(fsw_result::MemoryShort) };
    let text = parts.iter().flat_map(|part| part.bytes()).take(last);
    for (index, byte) in text.chain(core::iter::once(0)).enumerate() {
        // SAFETY: `index` is at most `last`, within the buffer whose length C states.
        unsafe { buffer.add(index).cast::<u8>().write(byte) };
    }
    Ok(())
}

/// Code of a call that returns early by `?`.
pub(crate) fn code(body: impl FnOnce() -> Result<fsw_result, fsw_result>) -> fsw_result {
    body().unwrap_or_else(|refused| refused)
}
