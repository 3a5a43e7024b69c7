//! Flash of the counters of telecommands (sectors 8 and 9) and of the checkpoints (sectors 10 and 11): 128 KiB
//! each, from 0x08080000 to the end of the first MiB. `memory.x` keeps code out of them.
//!
//! The chip has one bank of flash and executes from it. The core stalls while a word is programmed (16 µs,
//! at most 100 µs) or a sector erased (1 s, at most 2 s; DS8626, flash memory characteristics, 32-bit
//! parallelism at 2.7 to 3.6 V):
//!
//! * An erasure stops the core for one to two seconds. The period of the watchdog is longer
//!   (`watchdog.rs`), if it was fed before.
//! * Events during the stall are lost: gyro samples, received bytes beyond one, and wheel edges beyond one.
//!   Bytes are counted, edges reported as errors. Pending time stamps are discarded, since the gyro then
//!   holds a newer sample of unknown time. The estimator bridges the gap or resets.
//!
//! No operation begins while the supply detector reports a low supply (`supply.rs`).
//!
//! Every write and erasure is verified by reading back. In QEMU programming has no effect, which this
//! verification reports.
//!
//! Registers: RM0090, chapter 3 (flash).

use super::time::wait_at_most;
use super::{captures, data_ready, supply};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use stm32f4::stm32f405::{FLASH, Peripherals};

/// Two sectors.
struct Place {
    /// Address of the first sector.
    start: u32,
    /// Number of the first sector.
    first_sector: u32,
}

/// Counters of telecommands.
const COUNTERS: Place = Place { start: 0x0808_0000, first_sector: 8 };
/// Checkpoints.
const CHECKPOINTS: Place = Place { start: 0x080C_0000, first_sector: 10 };
/// Size of a sector, bytes.
const SECTOR_BYTES: u32 = 128 * 1024;
/// Number of sectors of a place.
const SECTORS: u32 = 2;

/// Unlock sequence of FLASH_CR, written to FLASH_KEYR.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// An erased word.
const ERASED: u32 = u32::MAX;

/// Time limit of an erasure, µs: 1.5 times the longest.
const ERASE_LIMIT_US: u32 = 3_000_000;
/// Time limit of programming a word, µs: ten times the longest.
const PROGRAM_LIMIT_US: u32 = 1_000;

/// Error of a flash operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum FlashFault {
    /// Address range outside the sectors, or not aligned.
    BadRange(RangeFault),
    /// The supply is too low: nothing was begun.
    SupplyLow,
    /// The flash stays locked until the next reset.
    Locked,
    /// The operation exceeded its time limit.
    TimedOut,
    /// Error flags of the operation.
    Refused {
        /// FLASH_SR.
        status: u32,
    },
    /// Verification failed.
    NotAsWritten {
        /// Offset from the first sector, bytes.
        offset: u32,
    },
}

/// Error of an address range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum RangeFault {
    /// Not a multiple of word or sector.
    NotAligned,
    /// Beyond the last sector.
    OutOfBounds,
    /// Any other error.
    Other,
}

impl From<NorFlashErrorKind> for FlashFault {
    fn from(kind: NorFlashErrorKind) -> Self {
        Self::BadRange(match kind {
            NorFlashErrorKind::NotAligned => RangeFault::NotAligned,
            NorFlashErrorKind::OutOfBounds => RangeFault::OutOfBounds,
            _ => RangeFault::Other,
        })
    }
}

impl NorFlashError for FlashFault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::BadRange(RangeFault::NotAligned) => NorFlashErrorKind::NotAligned,
            Self::BadRange(RangeFault::OutOfBounds) => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// Two sectors of the flash.
pub struct SectorPair {
    flash: FLASH,
    place: Place,
}

impl SectorPair {
    /// Flash of checkpoints, and flash of counters.
    pub(super) fn both(flash: FLASH) -> (Self, Self) {
        // SAFETY: both are used by the main loop alone, and each operation is complete before the next
        // one of either begins.
        #[allow(unsafe_code, reason = "one peripheral for two places")]
        let same = unsafe { Peripherals::steal() }.FLASH;
        (Self { flash, place: CHECKPOINTS }, Self { flash: same, place: COUNTERS })
    }

    /// Runs `work` with the flash unlocked, then locks it and clears its data cache, which may hold the
    /// previous content.
    fn unlocked(
        &mut self,
        work: impl FnOnce(&Self) -> Result<(), FlashFault>,
    ) -> Result<(), FlashFault> {
        if supply::is_low() {
            return Err(FlashFault::SupplyLow);
        }
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
        self.clear_data_cache();
        done
    }

    fn clear_data_cache(&self) {
        let acr = self.flash.acr();
        let was_on = acr.read().dcen().is_enabled();
        acr.modify(|_, w| w.dcen().disabled());
        acr.modify(|_, w| w.dcrst().reset());
        acr.modify(|_, w| w.dcrst().no_reset().dcen().bit(was_on));
    }

    /// Waits for the current operation.
    ///
    /// # Errors
    /// [`FlashFault::TimedOut`], [`FlashFault::Refused`].
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

    /// Waits for an unfinished operation and clears its error flags, which would prevent the next one.
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
            // SAFETY: the sectors of both places hold no code, see `memory.x`.
            #[allow(unsafe_code, reason = "the field takes any bits")]
            unsafe {
                w.snb().bits((self.place.first_sector + index) as u8);
            }
            w.ser().sector_erase().psize().psize32()
        });
        self.flash.cr().modify(|_, w| w.strt().start());
        self.finish(ERASE_LIMIT_US)
    }

    fn program(&self, offset: u32, word: u32) -> Result<(), FlashFault> {
        self.get_ready()?;
        self.flash.cr().write(|w| w.pg().program().psize().psize32());
        // SAFETY: the offset lies within the sectors, which hold no code and no variable.
        #[allow(unsafe_code, reason = "flash is programmed by a store to its address")]
        unsafe {
            ((self.place.start + offset) as *mut u32).write_volatile(word);
        }
        cortex_m::asm::dsb(); // the store completes before the status is read
        self.finish(PROGRAM_LIMIT_US)
    }

    /// The byte at `offset`, bytes from the first sector; must lie within the sectors.
    fn byte(&self, offset: u32) -> u8 {
        // SAFETY: flash within the sectors; volatile, since programming changes it.
        #[allow(unsafe_code, reason = "flash is memory")]
        unsafe {
            ((self.place.start + offset) as *const u8).read_volatile()
        }
    }

    /// The word at `offset`, bytes from the first sector; must be aligned and lie within the sectors.
    fn word(&self, offset: u32) -> u32 {
        // SAFETY: as in `byte`.
        #[allow(unsafe_code, reason = "flash is memory")]
        unsafe {
            ((self.place.start + offset) as *const u32).read_volatile()
        }
    }
}

impl ErrorType for SectorPair {
    type Error = FlashFault;
}

impl ReadNorFlash for SectorPair {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashFault> {
        check_read(self, offset, bytes.len())?;
        // Repeated readings are of the cells (`store/record.rs`).
        self.clear_data_cache();
        if !offset.is_multiple_of(size_of::<u32>() as u32) {
            for (byte, offset) in bytes.iter_mut().zip(offset..) {
                *byte = self.byte(offset);
            }
            return Ok(());
        }
        // By words: a quarter of the accesses, of five wait states each.
        let words = (offset..).step_by(size_of::<u32>());
        for (place, offset) in bytes.chunks_mut(size_of::<u32>()).zip(words) {
            for (byte, read) in place.iter_mut().zip(self.word(offset).to_ne_bytes()) {
                *byte = read;
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        (SECTORS * SECTOR_BYTES) as usize
    }
}

impl NorFlash for SectorPair {
    const WRITE_SIZE: usize = size_of::<u32>();
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    /// Erases whole sectors; each stops the core for 1 to 2 s.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashFault> {
        check_erase(self, from, to)?;
        for index in from / SECTOR_BYTES..to / SECTOR_BYTES {
            // Keeps stale interrupts from being served after the stall.
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
