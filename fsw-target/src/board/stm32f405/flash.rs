//! The last two sectors of the flash, 128 KiB each, for checkpoints: sectors 10 and 11, from
//! 0x080C0000 to the end of the first MiB. `memory.x` keeps code out of them.
//!
//! The chip has one bank of flash, and executes from it: while a word is programmed (16 µs, at most
//! 100 µs) or a sector erased (1 s, at most 2 s; DS8626, flash memory characteristics, 32 bits at
//! a time with 2.7 to 3.6 V) the core waits for its next instruction. So:
//!
//! * An erasure stops everything for a second or two. The watchdog's period is longer than that
//!   (`watchdog.rs`), if it was fed just before.
//! * What happens meanwhile is lost: gyro samples (the stamps that wait are dropped too, since the
//!   gyro holds newer samples then, and nobody knows of when), received bytes and wheel edges beyond
//!   one, which are counted or told as errors. The estimator bridges the gap, and begins anew where
//!   it has to.
//!
//! Whatever was written or erased is read back, and an error if it isn't as it should be. In QEMU
//! programming has no effect, and this is how one is told.
//!
//! Registers: RM0090, chapter 3 (flash).

use super::time::wait_at_most;
use super::{captures, data_ready};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use stm32f4::stm32f405::FLASH;

/// Where the first sector begins.
const START: u32 = 0x080C_0000;
/// Number of the first sector.
const FIRST_SECTOR: u32 = 10;
/// Bytes in a sector.
const SECTOR_BYTES: u32 = 128 * 1024;
/// Sectors for checkpoints.
const SECTORS: u32 = 2;

/// Written to FLASH_KEYR one after the other, these unlock FLASH_CR.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// An erased word.
const ERASED: u32 = u32::MAX;

/// Longest erasure of a sector, and half as much again, µs.
const ERASE_LIMIT_US: u32 = 3_000_000;
/// Longest programming of a word, and ten times that, µs.
const PROGRAM_LIMIT_US: u32 = 1_000;

/// Why the flash did not do it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum FlashFault {
    /// The place isn't within the sectors, or not aligned.
    BadPlace(PlaceFault),
    /// The flash stays locked until the next reset.
    Locked,
    /// It was busy for longer than it may be.
    TimedOut,
    /// It raised error flags: FLASH_SR.
    Refused {
        /// The register.
        status: u32,
    },
    /// What is read back isn't what was written.
    NotAsWritten {
        /// Offset from the first sector, bytes.
        offset: u32,
    },
}

/// What is wrong with a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum PlaceFault {
    /// Not a multiple of the word or the sector.
    NotAligned,
    /// Beyond the end.
    OutOfBounds,
    /// Refused for another reason.
    Other,
}

impl From<NorFlashErrorKind> for FlashFault {
    fn from(kind: NorFlashErrorKind) -> Self {
        Self::BadPlace(match kind {
            NorFlashErrorKind::NotAligned => PlaceFault::NotAligned,
            NorFlashErrorKind::OutOfBounds => PlaceFault::OutOfBounds,
            _ => PlaceFault::Other,
        })
    }
}

impl NorFlashError for FlashFault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::BadPlace(PlaceFault::NotAligned) => NorFlashErrorKind::NotAligned,
            Self::BadPlace(PlaceFault::OutOfBounds) => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The checkpoints' sectors.
pub struct CheckpointFlash {
    flash: FLASH,
}

impl CheckpointFlash {
    pub(super) fn new(flash: FLASH) -> Self {
        Self { flash }
    }

    /// Does `work` with the flash unlocked, and locks it again. Its data cache may hold what was
    /// there before, and is emptied.
    fn unlocked(
        &mut self,
        work: impl FnOnce(&Self) -> Result<(), FlashFault>,
    ) -> Result<(), FlashFault> {
        if self.flash.cr().read().lock().bit_is_set() {
            for key in KEYS {
                self.flash.keyr().write(|w| w.key().set(key));
            }
        }
        if self.flash.cr().read().lock().bit_is_set() {
            return Err(FlashFault::Locked);
        }
        let done = work(self);
        self.flash.cr().write(|w| w.lock().locked());
        self.empty_data_cache();
        done
    }

    fn empty_data_cache(&self) {
        let acr = self.flash.acr();
        let was_on = acr.read().dcen().is_enabled();
        acr.modify(|_, w| w.dcen().disabled());
        acr.modify(|_, w| w.dcrst().reset());
        acr.modify(|_, w| w.dcrst().no_reset().dcen().bit(was_on));
    }

    /// Waits for the operation in work; an error if it takes too long or raised a flag.
    fn finish(&self, limit_us: u32) -> Result<(), FlashFault> {
        wait_at_most(limit_us, || self.flash.sr().read().bsy().bit_is_clear())
            .ok_or(FlashFault::TimedOut)?;
        let status = self.flash.sr().read();
        let refused = status.pgserr().bit_is_set()
            || status.pgperr().bit_is_set()
            || status.pgaerr().bit_is_set()
            || status.wrperr().bit_is_set();
        if refused { Err(FlashFault::Refused { status: status.bits() }) } else { Ok(()) }
    }

    /// Waits for an operation that may still be in work, and clears what it left: its flags would
    /// stop the next one.
    fn get_ready(&self) -> Result<(), FlashFault> {
        if self.finish(ERASE_LIMIT_US) == Err(FlashFault::TimedOut) {
            return Err(FlashFault::TimedOut);
        }
        self.flash.sr().write(|w| {
            w.pgserr().clear().pgperr().clear().pgaerr().clear().wrperr().clear();
            w.operr().clear().eop().clear()
        });
        Ok(())
    }

    fn erase_sector(&self, index: u32) -> Result<(), FlashFault> {
        self.get_ready()?;
        self.flash.cr().write(|w| {
            // SAFETY: sectors 10 and 11 hold no code, see `memory.x`.
            #[allow(unsafe_code, reason = "the field takes any bits")]
            unsafe {
                w.snb().bits((FIRST_SECTOR + index) as u8);
            }
            w.ser().sector_erase().psize().psize32()
        });
        self.flash.cr().modify(|_, w| w.strt().start());
        self.finish(ERASE_LIMIT_US)
    }

    fn program(&self, offset: u32, word: u32) -> Result<(), FlashFault> {
        self.get_ready()?;
        self.flash.cr().write(|w| w.pg().program().psize().psize32());
        // SAFETY: the offset is within the sectors, which hold no code and no variable.
        #[allow(unsafe_code, reason = "flash is programmed by a store to its address")]
        unsafe {
            ((START + offset) as *mut u32).write_volatile(word);
        }
        cortex_m::asm::dsb(); // the store has reached the flash before its status is asked for
        self.finish(PROGRAM_LIMIT_US)
    }

    /// The byte at `offset`, which is within the sectors.
    fn byte(&self, offset: u32) -> u8 {
        // SAFETY: flash within the sectors; volatile, since it changes under the compiler's eyes.
        #[allow(unsafe_code, reason = "flash is memory")]
        unsafe {
            ((START + offset) as *const u8).read_volatile()
        }
    }

    /// The word at `offset`, which is aligned and within the sectors.
    fn word(&self, offset: u32) -> u32 {
        // SAFETY: as in `byte`.
        #[allow(unsafe_code, reason = "flash is memory")]
        unsafe {
            ((START + offset) as *const u32).read_volatile()
        }
    }
}

impl ErrorType for CheckpointFlash {
    type Error = FlashFault;
}

impl ReadNorFlash for CheckpointFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashFault> {
        check_read(self, offset, bytes.len())?;
        for (byte, offset) in bytes.iter_mut().zip(offset..) {
            *byte = self.byte(offset);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        (SECTORS * SECTOR_BYTES) as usize
    }
}

impl NorFlash for CheckpointFlash {
    const WRITE_SIZE: usize = size_of::<u32>();
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    /// Erases whole sectors, each of which stops the core for 1 to 2 s.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashFault> {
        check_erase(self, from, to)?;
        for index in from / SECTOR_BYTES..to / SECTOR_BYTES {
            // The core stops anyway; this keeps it from serving stale interrupts afterwards.
            critical_section::with(|_| {
                let erased = self.unlocked(|flash| flash.erase_sector(index));
                data_ready::drop_pending();
                captures::drop_pending();
                erased
            })?;
        }
        let mut words = (from..to).step_by(size_of::<u32>());
        match words.find(|&offset| self.word(offset) != ERASED) {
            Some(offset) => Err(FlashFault::NotAsWritten { offset }),
            None => Ok(()),
        }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashFault> {
        check_write(self, offset, bytes.len())?;
        let (words, _) = bytes.as_chunks::<4>();
        let words = (offset..).step_by(size_of::<u32>()).zip(words.iter().copied());
        self.unlocked(|flash| {
            words
                .clone()
                .try_for_each(|(offset, word)| flash.program(offset, u32::from_ne_bytes(word)))
        })?;
        match words.clone().find(|&(offset, word)| self.word(offset) != u32::from_ne_bytes(word)) {
            Some((offset, _)) => Err(FlashFault::NotAsWritten { offset }),
            None => Ok(()),
        }
    }
}
