//! Format of the journal: chunks of eight little-endian words.
//!
//! | chunk | words |
//! |---|---|
//! | mark of an erased half | `MARK`, number of erasures, four zeros, complement of the second, seal |
//! | head of a checkpoint | `HEAD`, sequence number, fingerprint, length of the state in words, three zeros, seal |
//! | state | eight words each, the last chunk padded with zeros |
//! | tail of a checkpoint | CRC-32 of head and state, its complement, six zeros |
//!
//! A seal is the CRC-32 of the words before it in the chunk. The tail is written last; a record without
//! a valid tail is not a checkpoint.

use super::Error;
use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

/// Length of a chunk, bytes: a multiple of the write sizes of flash memories, 1 to 32 bytes.
pub const CHUNK: u32 = 32;
/// Length of a chunk, words.
pub const WORDS: usize = 8;

/// Readings of a tail, all of which must match. A power failure during its write leaves bits that read
/// otherwise each time; each reading matches with a probability of at most a half where one of them is. Such a
/// record must not count as the newest: the one before it is erased for the next.
const TAIL_READINGS: u32 = 16;

/// Words of a chunk.
pub type Chunk = [u32; WORDS];

/// Erased flash.
const ERASED: Chunk = [u32::MAX; WORDS];

const MARK: u32 = 0x6b72_614d; // "Mark"
const HEAD: u32 = 0x6461_6548; // "Head"

/// CRC-32 of IEEE 802.3. Detects every error burst of up to 32 bits, and all but one in 4·10⁹ of other
/// errors.
pub static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// A record in flash, by its head. It is a checkpoint if [`Record::is_whole`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Offset of its head.
    pub at: u32,
    /// Sequence number, ascending.
    pub sequence: u32,
    /// Type of the state: [`fsw_core::checkpoint::fingerprint`].
    pub fingerprint: u32,
    /// Length of the state, words.
    pub words: u32,
}

impl Record {
    /// Length of a record with a state of `words` words, bytes.
    pub fn length(words: u32) -> u32 {
        words.div_ceil(WORDS as u32).saturating_add(2).saturating_mul(CHUNK)
    }

    /// Offset after the record.
    pub fn end(&self) -> u32 {
        self.at.saturating_add(Self::length(self.words))
    }

    /// Order of records, the newest last. A head whose write was interrupted may have read as none when the
    /// next record took its number: two of a number have their order by the offset.
    pub fn order(&self) -> (u32, u32) {
        (self.sequence, self.at)
    }

    /// Offset of the tail.
    fn tail(&self) -> u32 {
        self.end().saturating_sub(CHUNK)
    }

    /// Head.
    pub fn head(&self) -> Chunk {
        sealed([HEAD, self.sequence, self.fingerprint, self.words, 0, 0, 0])
    }

    /// Record of the head at this offset; `None` if the chunk is not a head.
    pub fn of_head(at: u32, chunk: &Chunk) -> Option<Self> {
        let [HEAD, sequence, fingerprint, words, ..] = *chunk else { return None };
        let record = Self { at, sequence, fingerprint, words };
        (record.head() == *chunk).then_some(record)
    }

    /// True if the tail's CRC matches head and state, in each of [`TAIL_READINGS`].
    pub fn is_whole<F: NorFlash>(&self, flash: &mut F) -> Result<bool, Error<F::Error>> {
        if is_erased(&read(flash, self.tail())?) {
            return Ok(false);
        }
        let mut digest = CRC.digest();
        let mut at = self.at;
        while at < self.tail() {
            digest.update(&bytes_of(&read(flash, at)?));
            at = at.saturating_add(CHUNK);
        }
        let expected = tail_of(digest);
        for _ in 0..TAIL_READINGS {
            if read(flash, self.tail())? != expected {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Mark of an erased half, with the number of erasures of the journal.
pub fn mark(erasures: u32) -> Chunk {
    sealed([MARK, erasures, 0, 0, 0, 0, !erasures])
}

/// Number of erasures of a mark; `None` if the chunk is not a mark.
pub fn erasures_of(chunk: &Chunk) -> Option<u32> {
    let [MARK, erasures, ..] = *chunk else { return None };
    (mark(erasures) == *chunk).then_some(erasures)
}

/// True if the chunk is erased.
pub fn is_erased(chunk: &Chunk) -> bool {
    *chunk == ERASED
}

/// Chunk of seven words and their seal.
#[inline(never)]
fn sealed([a, b, c, d, e, f, g]: [u32; WORDS - 1]) -> Chunk {
    let unsealed = bytes_of(&[a, b, c, d, e, f, g, 0]);
    [a, b, c, d, e, f, g, CRC.checksum(&unsealed)]
}

/// Tail of a record with this CRC.
pub fn tail_of(digest: Digest<'static, u32, NoTable>) -> Chunk {
    let crc = digest.finalize();
    [crc, !crc, 0, 0, 0, 0, 0, 0]
}

/// Bytes of a chunk.
#[inline(never)]
pub fn bytes_of(chunk: &Chunk) -> [u8; CHUNK as usize] {
    let mut bytes = [0; CHUNK as usize];
    for (place, word) in bytes.chunks_exact_mut(4).zip(chunk) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// Reads the chunk at an offset.
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
