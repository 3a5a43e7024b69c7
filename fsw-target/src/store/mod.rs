//! Checkpoints in flash: what an estimator knows survives a reset, bit for bit.
//!
//! Input: a state that can be kept ([`Persist`]), and a flash memory in two halves. Output: the state,
//! as it was when it was last saved; or the one saved before, if the last one didn't get to its end.
//!
//! A journal. Checkpoints are appended to one half (`record.rs` has their form) until one doesn't fit
//! any more; then the other half is erased and written. The half that holds the newest whole checkpoint
//! is never erased, so that at each instant at which the power may fail there is at least one. Each is
//! read back before it counts. Erasures go to and fro between the halves, and what was erased is marked
//! as such only afterwards: an erasure that was cut short is done again.
//!
//! Nothing is held in memory but one chunk of 32 bytes: a state goes word by word to the flash and comes
//! back from it in place. It is only touched once its CRC has been seen to be right.
//!
//! # Why not a crate
//!
//! The flight image has no code that panics. `sequential-storage` 8.0.2 leaves `assert_failed`,
//! `unwrap_failed`, `panic` and `panic_fmt` in it, and takes 11.4 KB of flash, where this takes 7.4 and
//! leaves none: both in a small image built as the flight image is, with a queue of 256-byte chunks that
//! are pushed and iterated, and with a state of four words that is saved, loaded and read out. `ekv` 1.0
//! has pages of at most 64 KiB, where the STM32F405's have 128, and erases at least one of many in each
//! transaction. Both take a value as one slice, for which there is no memory.
//!
//! # What it takes
//!
//! On an STM32F405 a word typically takes 16 µs to program and a sector of 128 KiB 1 s to erase (DS8626,
//! flash memory programming), and the core stands still meanwhile, since it runs from the same flash. A
//! checkpoint of 16 KiB so takes 70 ms, and each eighth one an erasure, for which a flight computer may
//! rather choose a time at which nothing moves: [`Store::make_room`].

mod record;
#[cfg(test)]
mod tests;

use core::mem;
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checkpoint::{Invalid, Persist, fingerprint};
use record::{CHUNK, Record, Stream};

/// Why nothing was saved or loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Error<E> {
    /// The flash memory failed.
    Flash(E),
    /// It isn't two halves of whole pages, each large enough for something.
    Geometry,
    /// The state is larger than a half.
    TooLarge,
    /// The state has a value that can't be kept, or was kept under another configuration. What was
    /// loaded into must be started afresh.
    Invalid(Invalid),
    /// What was written reads otherwise. The next attempt goes elsewhere.
    NotStored,
}

impl<E> From<Invalid> for Error<E> {
    fn from(why: Invalid) -> Self {
        Self::Invalid(why)
    }
}

/// A checkpoint that was saved or loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Checkpoint {
    /// The newer, the higher.
    pub sequence: u32,
    /// 32-bit words of state.
    pub words: u32,
    /// Newer ones that were passed over: torn, or broken.
    pub passed_over: u32,
}

/// One half of the flash.
#[derive(Debug, Clone, Copy)]
struct Half {
    start: u32,
    end: u32,
    /// The offset after all that is written in it; none where it must be erased first.
    used: Option<u32>,
}

impl Half {
    fn contains(&self, record: &Record) -> bool {
        (self.start..self.end).contains(&record.at)
    }
}

/// Checkpoints in the flash `F`.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    /// The one that is written.
    active: Half,
    other: Half,
    /// Of all halves so far.
    erasures: u32,
    next_sequence: u32,
    newest: Option<Record>,
    /// What is being read out.
    read_out: Option<Record>,
}

impl<F: NorFlash> Store<F> {
    const GEOMETRY: () = {
        assert!((CHUNK as usize).is_multiple_of(F::WRITE_SIZE), "words of more than 32 bytes");
        assert!((CHUNK as usize).is_multiple_of(F::READ_SIZE), "words of more than 32 bytes");
        assert!(F::ERASE_SIZE.is_multiple_of(CHUNK as usize), "pages that aren't made of chunks");
    };

    /// Finds out what is in the flash. Writes nothing.
    ///
    /// # Errors
    /// [`Error::Geometry`], and the flash's own.
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

    /// Saves a state. It must not change meanwhile: call it between two steps.
    ///
    /// # Errors
    /// All of [`Error`]. The checkpoint before is then still there.
    pub fn save<P: Persist>(&mut self, state: &mut P) -> Result<Checkpoint, Error<F::Error>> {
        let words = Stream::count(&mut self.flash, state)?;
        let at = self.room_for(words)?;
        let sequence = self.next_sequence;
        let record = Record { at, sequence, fingerprint: fingerprint::<P>(), words };
        // Whatever happens, what comes next doesn't go to the same place.
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

    /// Erases now what the next [`save`](Self::save) of a state of at most so many words would have to
    /// erase, and says whether it did.
    ///
    /// # Errors
    /// As for `save`.
    pub fn make_room(&mut self, words: u32) -> Result<bool, Error<F::Error>> {
        let erasures = self.erasures;
        self.room_for(words)?;
        Ok(self.erasures != erasures)
    }

    /// Brings the newest whole checkpoint of this state back; `None` if there is none.
    ///
    /// # Errors
    /// [`Error::Invalid`] if there are some, but the state accepts none. Where the state has been
    /// touched, there is an error or a checkpoint, never `None`.
    pub fn load<P: Persist>(
        &mut self,
        state: &mut P,
    ) -> Result<Option<Checkpoint>, Error<F::Error>> {
        let (mut before, mut passed_over, mut refused) = (None, 0, None);
        // Each is older than the one before, so that this ends.
        while let Some(record) = self.newest_before(before, Some(fingerprint::<P>()))? {
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
            before = Some(record.sequence);
        }
        refused.map_or(Ok(None), |why| Err(Error::Invalid(why)))
    }

    /// Reads the newest whole checkpoint out, as it stands in the flash, in parts of as many chunks of
    /// 32 bytes as `part` has room for: says how many bytes of it are valid, fewer at the end and 0 after
    /// that. All parts are of the checkpoint that was the newest when part 0 was read.
    ///
    /// # Errors
    /// The flash's own.
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

    /// Length of the newest whole checkpoint as it stands in the flash, bytes; 0 if there is none.
    pub fn newest_bytes(&self) -> u32 {
        self.newest.map_or(0, |record| record.end().saturating_sub(record.at))
    }

    /// How often one half or the other has been erased.
    pub fn erasures(&self) -> u32 {
        self.erasures
    }

    /// Notes what is where.
    fn survey(&mut self) -> Result<(), Error<F::Error>> {
        let (mut newest_head, mut halves) = (None, [self.active, self.other]);
        for half in &mut halves {
            let mark = record::erasures_of(&record::read(&mut self.flash, half.start)?);
            self.erasures = self.erasures.max(mark.unwrap_or(0));
            let used =
                scan(&mut self.flash, half, &mut |record| keep_newest(&mut newest_head, record))?;
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
            candidate = self.newest_before(Some(record.sequence), None)?;
        }
        self.newest = candidate;
        Ok(())
    }

    /// The newest checkpoint, whole or not, that is older than this one and has this fingerprint, if
    /// that matters.
    #[inline(never)]
    fn newest_before(
        &mut self,
        sequence: Option<u32>,
        fingerprint: Option<u32>,
    ) -> Result<Option<Record>, Error<F::Error>> {
        let mut newest = None;
        for half in [self.active, self.other] {
            scan(&mut self.flash, &half, &mut |record| {
                let is_older = sequence.is_none_or(|sequence| record.sequence < sequence);
                if is_older && fingerprint.is_none_or(|print| record.fingerprint == print) {
                    keep_newest(&mut newest, record);
                }
            })?;
        }
        Ok(newest)
    }

    /// Where a state of so many words goes: behind what was written last, or into the other half.
    #[inline(never)]
    fn room_for(&mut self, words: u32) -> Result<u32, Error<F::Error>> {
        let length = Record::length(words);
        let Half { start, end, .. } = self.active;
        if length > end.saturating_sub(start).saturating_sub(CHUNK) {
            return Err(Error::TooLarge);
        }
        if let Some(at) = self.free(length)? {
            return Ok(at);
        }
        // The half that holds the newest whole checkpoint is never erased.
        if !self.newest.is_some_and(|newest| self.other.contains(&newest)) {
            mem::swap(&mut self.active, &mut self.other);
        }
        if let Some(at) = self.free(length)? {
            return Ok(at);
        }
        self.erase()?;
        self.free(length)?.ok_or(Error::NotStored)
    }

    /// Where so many bytes are free in the half that is written, if anywhere.
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

/// Shows all checkpoints of a half, whole or not, and returns the offset after all that is written.
///
/// What is no head is passed over chunk by chunk, so that a broken one hides itself alone.
#[inline(never)]
fn scan<F: NorFlash>(
    flash: &mut F,
    half: &Half,
    show: &mut dyn FnMut(Record),
) -> Result<u32, Error<F::Error>> {
    let mut at = half.start.saturating_add(CHUNK);
    let mut used = at;
    while at < half.end {
        let chunk = record::read(flash, at)?;
        match Record::of_head(at, &chunk).filter(|record| record.end() <= half.end) {
            Some(record) => {
                show(record);
                at = record.end();
                used = at;
            }
            None => {
                at = at.saturating_add(CHUNK);
                if !record::is_erased(&chunk) {
                    used = at;
                }
            }
        }
    }
    Ok(used)
}

fn keep_newest(newest: &mut Option<Record>, record: Record) {
    if newest.is_none_or(|newest| record.sequence > newest.sequence) {
        *newest = Some(record);
    }
}
