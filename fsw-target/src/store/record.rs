//! What stands in the flash: chunks of eight words, and the streams between them and a state.
//!
//! | chunk | words |
//! |---|---|
//! | mark of an erased half | `MARK`, erasures so far, four zeros, inverse of the second, seal |
//! | head of a checkpoint | `HEAD`, sequence number, fingerprint, words of state, three zeros, seal |
//! | state | eight words each, the last one filled up with zeros |
//! | tail of a checkpoint | CRC-32 of head and state, its inverse, six zeros |
//!
//! Little-endian. A seal is the CRC-32 of the words before it, in the same chunk. The tail is written
//! last: without it there is no checkpoint.

use super::Error;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use fsw_core::checkpoint::{self, Invalid, Persist, Words};

/// Bytes of a chunk. A multiple of what flash memories are programmed by, 1 to 32 bytes.
pub const CHUNK: u32 = 32;
/// Words of it.
const WORDS: usize = 8;

/// Eight words.
pub type Chunk = [u32; WORDS];

/// What erased flash reads as.
const ERASED: Chunk = [u32::MAX; WORDS];

const MARK: u32 = 0x6b72_614d; // "Mark"
const HEAD: u32 = 0x6461_6548; // "Head"

/// CRC-32 of IEEE 802.3: any burst of up to 32 bits is found, and of others all but one in 4·10⁹.
static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// A checkpoint in the flash, by its head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Offset of its head.
    pub at: u32,
    /// The newer, the higher.
    pub sequence: u32,
    /// See [`fsw_core::checkpoint::fingerprint`].
    pub fingerprint: u32,
    /// Words of state.
    pub words: u32,
}

impl Record {
    /// Bytes that a checkpoint of so many words takes.
    pub fn length(words: u32) -> u32 {
        words.div_ceil(WORDS as u32).saturating_add(2).saturating_mul(CHUNK)
    }

    /// The offset after it.
    pub fn end(&self) -> u32 {
        self.at.saturating_add(Self::length(self.words))
    }

    /// The offset of its tail.
    fn tail(&self) -> u32 {
        self.end().saturating_sub(CHUNK)
    }

    /// Its head.
    pub fn head(&self) -> Chunk {
        sealed([HEAD, self.sequence, self.fingerprint, self.words, 0, 0, 0])
    }

    /// The record of the head at this offset, if it is one.
    pub fn of_head(at: u32, chunk: &Chunk) -> Option<Self> {
        let [HEAD, sequence, fingerprint, words, ..] = *chunk else { return None };
        let record = Self { at, sequence, fingerprint, words };
        (record.head() == *chunk).then_some(record)
    }

    /// Whether head, state and tail belong together, to the last bit.
    pub fn is_whole<F: NorFlash>(&self, flash: &mut F) -> Result<bool, Error<F::Error>> {
        let tail = read(flash, self.tail())?;
        if tail == ERASED {
            return Ok(false);
        }
        let mut digest = CRC.digest();
        let mut at = self.at;
        while at < self.tail() {
            digest.update(&bytes_of(&read(flash, at)?));
            at = at.saturating_add(CHUNK);
        }
        Ok(tail == tail_of(digest))
    }
}

/// The mark of a half that was erased, the journal's so many-th erasure.
pub fn mark(erasures: u32) -> Chunk {
    sealed([MARK, erasures, 0, 0, 0, 0, !erasures])
}

/// The erasures that a mark tells, if it is one.
pub fn erasures_of(chunk: &Chunk) -> Option<u32> {
    let [MARK, erasures, ..] = *chunk else { return None };
    (mark(erasures) == *chunk).then_some(erasures)
}

/// Whether nothing has been written there.
pub fn is_erased(chunk: &Chunk) -> bool {
    *chunk == ERASED
}

#[inline(never)]
fn sealed([a, b, c, d, e, f, g]: [u32; WORDS - 1]) -> Chunk {
    let unsealed = bytes_of(&[a, b, c, d, e, f, g, 0]);
    [a, b, c, d, e, f, g, CRC.checksum(&unsealed)]
}

fn tail_of(digest: Digest<'static, u32, NoTable>) -> Chunk {
    let crc = digest.finalize();
    [crc, !crc, 0, 0, 0, 0, 0, 0]
}

#[inline(never)]
fn bytes_of(chunk: &Chunk) -> [u8; CHUNK as usize] {
    let mut bytes = [0; CHUNK as usize];
    for (place, word) in bytes.chunks_exact_mut(4).zip(chunk) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// The chunk at an offset.
pub fn read<F: ReadNorFlash>(flash: &mut F, at: u32) -> Result<Chunk, Error<F::Error>> {
    let mut bytes = [0; CHUNK as usize];
    flash.read(at, &mut bytes).map_err(Error::Flash)?;
    let mut chunk = ERASED;
    for (place, word) in chunk.iter_mut().zip(bytes.chunks_exact(4)) {
        *place = word.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
    }
    Ok(chunk)
}

/// Writes a chunk to erased flash.
pub fn write<F: NorFlash>(flash: &mut F, at: u32, chunk: &Chunk) -> Result<(), Error<F::Error>> {
    flash.write(at, &bytes_of(chunk)).map_err(Error::Flash)
}

/// A state on its way: counted, to the flash, or back from it.
pub struct Stream<'a, F: NorFlash> {
    flash: &'a mut F,
    way: Way,
    at: u32,
    chunk: Chunk,
    /// Words of the chunk that are filled, or taken.
    used: usize,
    /// Words so far, and how many there are in all.
    words: u32,
    end: u32,
    digest: Digest<'static, u32, NoTable>,
    /// Why the stream ended, where the flash is the reason.
    failure: Option<F::Error>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Count,
    There,
    Back,
}

impl<'a, F: NorFlash> Stream<'a, F> {
    fn new(flash: &'a mut F, way: Way, at: u32, end: u32) -> Self {
        let (chunk, digest) = ([0; WORDS], CRC.digest());
        Self { flash, way, at, chunk, used: 0, words: 0, end, digest, failure: None }
    }

    /// How many words a state takes.
    pub fn count<P: Persist>(flash: &'a mut F, state: &mut P) -> Result<u32, Error<F::Error>> {
        let mut stream = Self::new(flash, Way::Count, 0, u32::MAX);
        stream.pass_all(state)?;
        Ok(stream.words)
    }

    /// Writes a checkpoint of the state.
    pub fn write<P: Persist>(
        flash: &'a mut F,
        record: &Record,
        state: &mut P,
    ) -> Result<(), Error<F::Error>> {
        let mut stream = Self::new(flash, Way::There, record.at, record.words);
        stream.chunk = record.head();
        stream.put_chunk()?;
        stream.pass_all(state)?;
        if stream.used > 0 {
            stream.put_chunk()?;
        }
        write(stream.flash, stream.at, &tail_of(stream.digest))
    }

    /// Brings the state of a checkpoint back.
    pub fn read<P: Persist>(
        flash: &'a mut F,
        record: &Record,
        state: &mut P,
    ) -> Result<(), Error<F::Error>> {
        let first = record.at.saturating_add(CHUNK);
        let mut stream = Self::new(flash, Way::Back, first, record.words);
        stream.used = WORDS;
        stream.pass_all(state)
    }

    fn pass_all<P: Persist>(&mut self, state: &mut P) -> Result<(), Error<F::Error>> {
        let passed = checkpoint::transfer(state, self);
        if let Some(failure) = self.failure.take() {
            return Err(Error::Flash(failure));
        }
        passed?;
        if self.way != Way::Count && self.words != self.end {
            return Err(Error::Invalid(Invalid { place: "length" }));
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

    /// Whether it went well; if not, the failure is noted.
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
        if self.way == Way::Count {
            return true;
        }
        if self.way == Way::Back && self.used == WORDS {
            let taken = self.take_chunk();
            if !self.is_done(taken) {
                return false;
            }
        }
        let Some(place) = self.chunk.get_mut(self.used) else { return false };
        self.used += 1;
        if self.way == Way::Back {
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
