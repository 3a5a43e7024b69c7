//! Streams between a state and its record in flash.
//!
//! A state is passed word by word through one chunk, so a save or a load takes 32 bytes of RAM.

use super::Error;
use super::record::{CHUNK, CRC, Chunk, Record, WORDS, bytes_of, read, tail_of, write};
use crc::{Digest, NoTable};
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checkpoint::{self, InvalidWord, Persist, Words};

/// Passage of a state, word by word.
pub struct Stream<'a, F: NorFlash> {
    flash: &'a mut F,
    direction: Direction,
    at: u32,
    chunk: Chunk,
    /// Words of the chunk filled or taken.
    used: usize,
    /// Words passed.
    words: u32,
    /// Length of the state, words.
    end: u32,
    digest: Digest<'static, u32, NoTable>,
    /// Error of the flash that ended the stream.
    failure: Option<F::Error>,
}

/// Direction of the passage.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    /// Counts words, without flash.
    Count,
    /// Writes words to flash.
    Save,
    /// Reads words from flash.
    Load,
}

impl<'a, F: NorFlash> Stream<'a, F> {
    fn new(flash: &'a mut F, direction: Direction, at: u32, end: u32) -> Self {
        let (chunk, digest) = ([0; WORDS], CRC.digest());
        Self { flash, direction, at, chunk, used: 0, words: 0, end, digest, failure: None }
    }

    /// Length of a state, words.
    pub fn count(flash: &'a mut F, state: &mut dyn Persist) -> Result<u32, Error<F::Error>> {
        let mut stream = Self::new(flash, Direction::Count, 0, u32::MAX);
        stream.pass_all(state)?;
        Ok(stream.words)
    }

    /// Writes a checkpoint of the state.
    pub fn write(
        flash: &'a mut F,
        record: &Record,
        state: &mut dyn Persist,
    ) -> Result<(), Error<F::Error>> {
        let mut stream = Self::new(flash, Direction::Save, record.at, record.words);
        stream.chunk = record.head();
        stream.put_chunk()?;
        stream.pass_all(state)?;
        if stream.used > 0 {
            stream.put_chunk()?;
        }
        write(stream.flash, stream.at, &tail_of(stream.digest))
    }

    /// Restores the state of a checkpoint.
    pub fn read(
        flash: &'a mut F,
        record: &Record,
        state: &mut dyn Persist,
    ) -> Result<(), Error<F::Error>> {
        let first = record.at.saturating_add(CHUNK);
        let mut stream = Self::new(flash, Direction::Load, first, record.words);
        stream.used = WORDS;
        stream.pass_all(state)
    }

    fn pass_all(&mut self, state: &mut dyn Persist) -> Result<(), Error<F::Error>> {
        let passed = checkpoint::transfer(state, self);
        if let Some(failure) = self.failure.take() {
            return Err(Error::Flash(failure));
        }
        passed?;
        if self.direction != Direction::Count && self.words != self.end {
            return Err(Error::Invalid(InvalidWord { place: "length" }));
        }
        Ok(())
    }

    fn put_chunk(&mut self) -> Result<(), Error<F::Error>> {
        self.digest.update(&bytes_of(&self.chunk));
        write(self.flash, self.at, &self.chunk)?;
        self.at = self.at.saturating_add(CHUNK);
        (self.chunk, self.used) = ([0; WORDS], 0);
        Ok(())
    }

    fn take_chunk(&mut self) -> Result<(), Error<F::Error>> {
        self.chunk = read(self.flash, self.at)?;
        self.at = self.at.saturating_add(CHUNK);
        self.used = 0;
        Ok(())
    }

    /// True if the operation succeeded; keeps the error of the flash.
    fn is_done(&mut self, result: Result<(), Error<F::Error>>) -> bool {
        if let Err(Error::Flash(failure)) = result {
            self.failure = Some(failure);
            return false;
        }
        true
    }
}

impl<F: NorFlash> Words for Stream<'_, F> {
    fn transfer(&mut self, word: &mut u32) -> bool {
        if self.words >= self.end {
            return false;
        }
        self.words += 1;
        if self.direction == Direction::Count {
            return true;
        }
        if self.direction == Direction::Load && self.used == WORDS {
            let taken = self.take_chunk();
            if !self.is_done(taken) {
                return false;
            }
        }
        let Some(place) = self.chunk.get_mut(self.used) else { return false };
        self.used += 1;
        if self.direction == Direction::Load {
            *word = *place;
            return true;
        }
        *place = *word;
        if self.used < WORDS {
            return true;
        }
        let put = self.put_chunk();
        self.is_done(put)
    }
}
