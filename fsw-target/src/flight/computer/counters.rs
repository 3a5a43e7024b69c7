//! Counters of telecommands in flash: read at the start, written before a telecommand is executed.
//!
//! Endurance: a record takes 96 bytes, 1,365 fit in a sector of 128 KiB, and the journal of two sectors with
//! 10,000 erasures each takes 27 million telecommands: one a minute for 51 years.
//!
//! A write takes 0.4 ms, and one in 1,365 also an erasure (1 to 2 s), unless space was erased ahead.

use crate::link::authentication::{Authentication, Ledger};
use crate::store::Store;
use embedded_storage::nor_flash::NorFlash;

/// Length of a stored ledger, words, with reserve.
const MAX_WORDS: u32 = 16;

/// Ledger in flash.
pub struct StoredCounters<F> {
    /// The flash before [`restore`](Self::restore); `None` in an image without a key.
    unopened: Option<F>,
    /// `None` in an image without a key, or if the flash cannot be read.
    store: Option<Store<F>>,
    /// State of the authentication.
    pub state: Authentication,
    /// True once space for the next record has been erased.
    erased_ahead: bool,
}

impl<F: NorFlash> StoredCounters<F> {
    /// The flash before [`restore`](Self::restore). Never opened in an image without a key.
    pub fn unopened(flash: F, has_key: bool) -> Self {
        let state = if has_key { Authentication::NotStored } else { Authentication::Off };
        Self { unopened: has_key.then_some(flash), store: None, state, erased_ahead: !has_key }
    }

    /// Opens the flash and returns the last stored ledger: the initial one if there is none.
    pub fn restore(&mut self) -> Ledger {
        let mut ledger = Ledger::INITIAL;
        if let Some(Ok(mut store)) = self.unopened.take().map(Store::open) {
            if store.load(&mut ledger).is_ok() {
                self.state = Authentication::Required;
            }
            self.store = Some(store);
        }
        ledger
    }

    /// Stores the ledger. No effect in an image without a key.
    #[inline(never)]
    pub fn save(&mut self, ledger: &Ledger) {
        if self.state == Authentication::Off {
            return;
        }
        let mut copy = *ledger;
        let stored = self.store.as_mut().is_some_and(|store| store.save(&mut copy).is_ok());
        self.state = if stored { Authentication::Required } else { Authentication::NotStored };
        self.erased_ahead = false;
    }

    /// True if the next record may need an erasure.
    pub fn may_need_erasure(&self) -> bool {
        !self.erased_ahead
    }

    /// Erases the space of the next record. After an error, its save repeats the erasure.
    #[inline(never)]
    pub fn erase_ahead(&mut self) {
        if let Some(store) = &mut self.store {
            let _ = store.make_room(MAX_WORDS);
        }
        self.erased_ahead = true;
    }
}
