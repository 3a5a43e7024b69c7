//! Checkpoint store: estimator states in flash, restored bit for bit after a reset.
//!
//! Input: a state that implements [`Persist`], and a flash memory in two halves. Output: the state as
//! last saved, or the one saved before if the last save was interrupted.
//!
//! The store is a journal. Checkpoints (format: `record.rs`) are appended to one half until the next
//! does not fit; then the other half is erased and continues. The half with the newest intact
//! checkpoint is never erased, so at least one survives a power failure at any instant. Each
//! checkpoint is read back before it counts as saved. Erasures alternate between the halves. An erased
//! half is marked after its erasure; without the mark it is erased again.
//!
//! RAM: one chunk of 32 bytes. A state is streamed to the flash and back word by word. Loading changes
//! the state only after its CRC has been verified.
//!
//! # Alternatives
//!
//! The flight image contains no panicking code. `sequential-storage` 8.0.2 adds `assert_failed`,
//! `unwrap_failed`, `panic` and `panic_fmt`, and takes 11.4 KB of flash against 7.4 KB here, both in
//! a small image with the flight image's profile: a queue of 256-byte chunks, pushed and iterated,
//! against a state of four words that is saved, loaded and read out. `ekv` 1.0 supports pages of up to
//! 64 KiB, the STM32F405 has 128 KiB, and each of its transactions erases at least one of many pages.
//! Both need the whole value in one buffer (38 KiB for `window`), for which the image has no RAM.
//!
//! # Timing
//!
//! STM32F405, typical: 16 µs to program a word, 1 s to erase a sector of 128 KiB (DS8626, flash memory
//! programming). The core stalls meanwhile, since it runs from the same flash. A checkpoint of 38 KiB
//! takes 160 ms, and every third one an erasure. [`Store::make_room`] erases ahead, at a time that
//! the flight computer chooses.

mod half;
mod record;
mod stream;
#[cfg(test)]
mod tests;

use core::mem;
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checkpoint::{InvalidWord, Persist, fingerprint};
use half::{Half, keep_newest};
pub(crate) use record::CRC as CHECKSUM;
use record::{CHUNK, Record};
use stream::Stream;

/// Reason for a failed save or load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Error<E> {
    /// Error of the flash memory.
    Flash(E),
    /// The flash is not two halves of whole pages, each with room for a checkpoint.
    Geometry,
    /// The state exceeds a half.
    TooLarge,
    /// The state has an invalid value, or was saved under another configuration. After a load the
    /// state is unspecified and must be reset.
    Invalid(InvalidWord),
    /// The flash does not read back as written. The next save uses another place.
    NotStored,
}

impl<E> From<InvalidWord> for Error<E> {
    fn from(why: InvalidWord) -> Self {
        Self::Invalid(why)
    }
}

/// A saved or loaded checkpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Checkpoint {
    /// Sequence number, ascending.
    pub sequence: u32,
    /// Length of the state, 32-bit words.
    pub words: u32,
    /// Newer checkpoints skipped as torn or corrupt.
    pub passed_over: u32,
}

/// Checkpoint store in the flash `F`.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    /// Half that is written.
    active: Half,
    other: Half,
    /// Erasures of both halves.
    erasures: u32,
    next_sequence: u32,
    newest: Option<Record>,
    /// Checkpoint of the current read-out.
    read_out: Option<Record>,
}

impl<F: NorFlash> Store<F> {
    const GEOMETRY: () = {
        assert!((CHUNK as usize).is_multiple_of(F::WRITE_SIZE), "write size must divide 32 bytes");
        assert!((CHUNK as usize).is_multiple_of(F::READ_SIZE), "read size must divide 32 bytes");
        assert!(
            F::ERASE_SIZE.is_multiple_of(CHUNK as usize),
            "page must be a multiple of 32 bytes"
        );
    };

    /// Reads the journal. Writes nothing.
    ///
    /// # Errors
    /// [`Error::Geometry`] and [`Error::Flash`].
    pub fn open(flash: F) -> Result<Self, Error<F::Error>> {
        const { Self::GEOMETRY };
        let half = u32::try_from(flash.capacity() / 2).map_err(|_| Error::Geometry)?;
        let (page, capacity) = (F::ERASE_SIZE as u32, half.checked_mul(2).ok_or(Error::Geometry)?);
        if !half.is_multiple_of(page) || half < Record::length(1) + CHUNK {
            return Err(Error::Geometry);
        }
        let mut store = Self {
            flash,
            active: Half { start: 0, end: half, used: None },
            other: Half { start: half, end: capacity, used: None },
            erasures: 0,
            next_sequence: 0,
            newest: None,
            read_out: None,
        };
        store.survey()?;
        Ok(store)
    }

    /// Saves a state. The state must not change during the call.
    ///
    /// # Errors
    /// All of [`Error`]. The checkpoint before remains.
    pub fn save<P: Persist>(&mut self, state: &mut P) -> Result<Checkpoint, Error<F::Error>> {
        self.save_as(fingerprint::<P>(), state)
    }

    /// As [`save`](Self::save), of any type: one copy in the image.
    #[inline(never)]
    fn save_as(
        &mut self,
        fingerprint: u32,
        state: &mut dyn Persist,
    ) -> Result<Checkpoint, Error<F::Error>> {
        let words = Stream::count(&mut self.flash, state)?;
        let at = self.allocate(words)?;
        let sequence = self.next_sequence;
        let record = Record { at, sequence, fingerprint, words };
        // A failed save occupies its place, so the next one uses another.
        self.active.used = Some(record.end());
        self.next_sequence = sequence.saturating_add(1);
        Stream::write(&mut self.flash, &record, state)?;
        if record::read(&mut self.flash, at)? != record.head()
            || !record.is_whole(&mut self.flash)?
        {
            return Err(Error::NotStored);
        }
        self.newest = Some(record);
        Ok(Checkpoint { sequence, words, passed_over: 0 })
    }

    /// Erases ahead what the next [`save`](Self::save) of at most `words` words would erase. Returns
    /// whether it erased.
    ///
    /// # Errors
    /// As for `save`.
    pub fn make_room(&mut self, words: u32) -> Result<bool, Error<F::Error>> {
        let erasures = self.erasures;
        self.allocate(words)?;
        Ok(self.erasures != erasures)
    }

    /// Restores the newest intact checkpoint of this type of state; `None` without one.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the state rejects every checkpoint. `Ok(None)` implies an unchanged
    /// state.
    pub fn load<P: Persist>(
        &mut self,
        state: &mut P,
    ) -> Result<Option<Checkpoint>, Error<F::Error>> {
        self.load_as(fingerprint::<P>(), state)
    }

    /// As [`load`](Self::load), of any type: one copy in the image.
    #[inline(never)]
    fn load_as(
        &mut self,
        fingerprint: u32,
        state: &mut dyn Persist,
    ) -> Result<Option<Checkpoint>, Error<F::Error>> {
        let (mut before, mut passed_over, mut refused) = (None, 0, None);
        // Terminates: each record is older than the one before.
        while let Some(record) = self.newest_before(before, Some(fingerprint))? {
            if record.is_whole(&mut self.flash)? {
                match Stream::read(&mut self.flash, &record, state) {
                    Ok(()) => {
                        let Record { sequence, words, .. } = record;
                        return Ok(Some(Checkpoint { sequence, words, passed_over }));
                    }
                    Err(Error::Invalid(why)) => refused = Some(why),
                    Err(other) => return Err(other),
                }
            }
            passed_over += 1;
            before = Some(record);
        }
        refused.map_or(Ok(None), |why| Err(Error::Invalid(why)))
    }

    /// Reads out the newest intact checkpoint, as stored in flash, in parts of whole chunks of 32
    /// bytes. Returns the number of valid bytes in `part`: fewer in the last part, then 0. Reading
    /// part 0 selects the checkpoint for all parts.
    ///
    /// # Errors
    /// [`Error::Flash`].
    pub fn read_part(&mut self, index: u32, part: &mut [u8]) -> Result<usize, Error<F::Error>> {
        if index == 0 {
            self.read_out = self.newest;
        }
        let Some(record) = self.read_out else { return Ok(0) };
        let places = part.chunks_exact_mut(CHUNK as usize);
        let before = index.saturating_mul(places.len() as u32);
        let (mut at, mut valid) = (record.at.saturating_add(before.saturating_mul(CHUNK)), 0);
        for place in places {
            if at >= record.end() {
                break;
            }
            self.flash.read(at, place).map_err(Error::Flash)?;
            at = at.saturating_add(CHUNK);
            valid += place.len();
        }
        Ok(valid)
    }

    /// Length of the newest intact checkpoint in flash, bytes; 0 without one.
    pub fn newest_bytes(&self) -> u32 {
        self.newest.map_or(0, |record| record.end().saturating_sub(record.at))
    }

    /// Erasures of both halves since the flash was new.
    pub fn erasures(&self) -> u32 {
        self.erasures
    }

    /// Finds the journal's end, its newest checkpoint and its erasures.
    fn survey(&mut self) -> Result<(), Error<F::Error>> {
        let (mut newest_head, mut halves) = (None, [self.active, self.other]);
        for half in &mut halves {
            let mark = record::erasures_of(&record::read(&mut self.flash, half.start)?);
            self.erasures = self.erasures.max(mark.unwrap_or(0));
            let used =
                half.scan(&mut self.flash, &mut |record| keep_newest(&mut newest_head, record))?;
            half.used = mark.map(|_| used);
        }
        [self.active, self.other] = halves;
        if let Some(head) = newest_head {
            self.next_sequence = head.sequence.saturating_add(1);
            if self.other.contains(&head) {
                mem::swap(&mut self.active, &mut self.other);
            }
        }
        let mut candidate = newest_head;
        while let Some(record) = candidate {
            if record.is_whole(&mut self.flash)? {
                break;
            }
            candidate = self.newest_before(Some(record), None)?;
        }
        self.newest = candidate;
        Ok(())
    }

    /// Newest checkpoint, intact or not. Optional filters: older than `before`, and this `fingerprint`.
    #[inline(never)]
    fn newest_before(
        &mut self,
        before: Option<Record>,
        fingerprint: Option<u32>,
    ) -> Result<Option<Record>, Error<F::Error>> {
        let mut newest = None;
        for half in [self.active, self.other] {
            half.scan(&mut self.flash, &mut |record| {
                let is_older = before.is_none_or(|before| record.order() < before.order());
                if is_older && fingerprint.is_none_or(|print| record.fingerprint == print) {
                    keep_newest(&mut newest, record);
                }
            })?;
        }
        Ok(newest)
    }

    /// Offset for a state of `words` words: after the last record, or in the other half.
    #[inline(never)]
    fn allocate(&mut self, words: u32) -> Result<u32, Error<F::Error>> {
        let length = Record::length(words);
        let Half { start, end, .. } = self.active;
        if length > end.saturating_sub(start).saturating_sub(CHUNK) {
            return Err(Error::TooLarge);
        }
        if let Some(at) = self.free(length)? {
            return Ok(at);
        }
        // The half with the newest intact checkpoint is never erased.
        if !self.newest.is_some_and(|newest| self.other.contains(&newest)) {
            mem::swap(&mut self.active, &mut self.other);
        }
        if let Some(at) = self.free(length)? {
            return Ok(at);
        }
        self.erase()?;
        self.free(length)?.ok_or(Error::NotStored)
    }

    /// Offset of `length` free bytes in the active half.
    #[inline(never)]
    fn free(&mut self, length: u32) -> Result<Option<u32>, Error<F::Error>> {
        let Some(used) = self.active.used else { return Ok(None) };
        let end = used.saturating_add(length);
        if end > self.active.end {
            return Ok(None);
        }
        let mut at = used;
        while at < end {
            if !record::is_erased(&record::read(&mut self.flash, at)?) {
                return Ok(None);
            }
            at = at.saturating_add(CHUNK);
        }
        Ok(Some(used))
    }

    #[inline(never)]
    fn erase(&mut self) -> Result<(), Error<F::Error>> {
        let Half { start, end, .. } = self.active;
        self.active.used = None;
        self.flash.erase(start, end).map_err(Error::Flash)?;
        self.erasures = self.erasures.saturating_add(1);
        record::write(&mut self.flash, start, &record::mark(self.erasures))?;
        self.active.used = Some(start.saturating_add(CHUNK));
        Ok(())
    }
}
