//! Authentication of packets: AES-128-CMAC tags, key slots, counters of telecommands.
//!
//! Input: bytes of a packet, and the master key of the image. Output: its tag, or the verdict on it. Threat
//! model and what it does not cover: `docs/security.md`.
//!
//! * Tag: AES-128-CMAC (NIST SP 800-38B, RFC 4493), all 16 bytes.
//! * Slots: slot 0 manages keys, the others carry telecommands. The key of a slot is derived from the master
//!   key, the slot and its generation by the KDF in counter mode of NIST SP 800-108r1, section 4.1, with
//!   CMAC. Neither a key nor material of one is ever on the line.
//! * Counter: 32 bits per slot, ascending, kept in flash ([`Ledger`]). A telecommand is accepted once.
//! * Key change: [`Ledger::change_key`]. The new generation is the counter of the telecommand that
//!   changes the key. Slot 0 never repeats a counter, hence no slot repeats a key.

use super::wire::codes;
use fsw_core::checkpoint::{Archive, Persist, mix};

pub use fsw_tags::{KEY_BYTES, Key, TAG_BYTES, Tag};

/// Key slots. Slot 0 manages the keys of the others.
pub const SLOTS: usize = 3;

/// Slot whose telecommands may change keys. Its own key changes with the image only.
pub const MANAGEMENT: u8 = 0;

/// Largest advance of a counter by one telecommand.
///
/// 2²⁰ is more than twelve days of a telecommand per second without a reading of the counter. It bounds the
/// damage of a mistaken counter: at least 2³² / 2²⁰ = 4,096 correctly tagged telecommands exhaust a slot. A
/// ground station without telemetry and without a record of its counter sends pings with the
/// counters 2²⁰, 2·2²⁰, …, of which exactly one is 1 to 2²⁰ ahead.
pub const MAX_ADVANCE: u32 = 1 << 20;

/// State of a key slot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slot {
    /// Counter of the last accepted telecommand; 0 before the first.
    pub counter: u32,
    /// Generation of the key; 0 for the first.
    pub generation: u32,
}

/// Counters and key generations of all slots: the state that is kept in flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ledger {
    slots: [Slot; SLOTS],
    /// Slot that tags telemetry, plus one; 0: telemetry is not tagged.
    telemetry: u32,
}

/// Reason for a refused counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CounterFault {
    /// Not ahead of the last accepted counter.
    Replayed,
    /// More than [`MAX_ADVANCE`] ahead.
    FarAhead,
}

impl Ledger {
    /// No telecommand accepted, first keys, telemetry without a tag.
    pub const INITIAL: Self =
        Self { slots: [Slot { counter: 0, generation: 0 }; SLOTS], telemetry: 0 };

    /// The slots.
    pub fn slots(&self) -> &[Slot; SLOTS] {
        &self.slots
    }

    /// State of a slot; `None` for a number without a slot.
    pub fn slot(&self, slot: u8) -> Option<&Slot> {
        self.slots.get(usize::from(slot))
    }

    /// Slot that tags telemetry; `None` for telemetry without a tag.
    pub fn telemetry_slot(&self) -> Option<u8> {
        let slot = u8::try_from(self.telemetry.checked_sub(1)?).ok()?;
        self.slot(slot).map(|_| slot)
    }

    /// Checks the counter of a telecommand against that of its slot.
    ///
    /// # Errors
    /// See [`CounterFault`].
    pub fn check(slot: &Slot, counter: u32) -> Result<(), CounterFault> {
        match counter.checked_sub(slot.counter) {
            None | Some(0) => Err(CounterFault::Replayed),
            Some(1..=MAX_ADVANCE) => Ok(()),
            Some(_) => Err(CounterFault::FarAhead),
        }
    }

    /// Stores the counter of an accepted telecommand.
    pub fn accept(&mut self, slot: u8, counter: u32) {
        if let Some(slot) = self.slots.get_mut(usize::from(slot)) {
            slot.counter = counter;
        }
    }

    /// Gives the slot `target` its next key, by a telecommand of the slot `by` with this counter. The
    /// counter of the target starts again. False if it is not permitted: slot 0 alone changes keys, and not
    /// its own.
    pub fn change_key(&mut self, by: u8, counter: u32, target: u8) -> bool {
        let permitted = by == MANAGEMENT && target != MANAGEMENT;
        match self.slots.get_mut(usize::from(target)).filter(|_| permitted) {
            Some(slot) => {
                *slot = Slot { counter: 0, generation: counter };
                true
            }
            None => false,
        }
    }

    /// Tags telemetry with the key of this slot from now on, or with none.
    pub fn tag_telemetry(&mut self, slot: Option<u8>) {
        self.telemetry = slot.map_or(0, |slot| u32::from(slot) + 1);
    }
}

/// Name of the layout of a stored ledger, "Ledg".
const LAYOUT: u32 = 0x4c65_6467;

/// All bits of a word are valid: [`Ledger::telemetry_slot`] treats an unknown slot as none.
impl Persist for Ledger {
    fn layout() -> u32 {
        mix(LAYOUT, <[u32; 2 * SLOTS + 1]>::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        for slot in &mut self.slots {
            slot.counter.persist(archive);
            slot.generation.persist(archive);
        }
        self.telemetry.persist(archive);
    }
}

/// Authentication of telecommands by this image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Authentication {
    /// The image has no key: telecommands are accepted without a tag.
    Off,
    /// Telecommands need a tag; counters are kept in flash.
    Required,
    /// Telecommands need a tag. The last counter is not in flash: after a restart the telecommands since the
    /// last stored one could be replayed.
    NotStored,
}

codes! { Authentication {
    0 "off" => Off;
    1 "required" => Required;
    2 "not_stored" => NotStored;
} }

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_accepted_once_and_within_the_advance() {
        let slot = Slot { counter: 100, generation: 0 };
        for (counter, verdict) in [
            (0, Err(CounterFault::Replayed)),
            (100, Err(CounterFault::Replayed)),
            (101, Ok(())),
            (100 + MAX_ADVANCE, Ok(())),
            (101 + MAX_ADVANCE, Err(CounterFault::FarAhead)),
            (u32::MAX, Err(CounterFault::FarAhead)),
        ] {
            assert_eq!(Ledger::check(&slot, counter), verdict, "{counter}");
        }
        let last = Slot { counter: u32::MAX, generation: 0 };
        assert_eq!(Ledger::check(&last, 0), Err(CounterFault::Replayed), "no wrap");
    }

    /// The procedure of `MAX_ADVANCE`, for a ground station that knows nothing.
    #[test]
    fn ground_without_its_counter_is_accepted_after_at_most_4096_pings() {
        for counter in [0, 1, MAX_ADVANCE - 1, MAX_ADVANCE, 12_345_678, u32::MAX - MAX_ADVANCE] {
            let slot = Slot { counter, generation: 0 };
            let pings = (1..4_096).map(|turn| turn * MAX_ADVANCE);
            let accepted = pings.filter(|ping| Ledger::check(&slot, *ping).is_ok()).count();
            assert_eq!(accepted, 1, "counter {counter}");
        }
    }

    #[test]
    fn slot_0_alone_changes_keys_and_not_its_own() {
        let mut ledger = Ledger::INITIAL;
        ledger.accept(1, 50);
        assert!(!ledger.change_key(1, 51, 1));
        assert!(!ledger.change_key(1, 51, 2));
        assert!(!ledger.change_key(0, 7, 0));
        assert!(!ledger.change_key(0, 7, SLOTS as u8));
        assert_eq!(ledger.slot(1), Some(&Slot { counter: 50, generation: 0 }));
        assert!(ledger.change_key(0, 7, 1));
        assert_eq!(ledger.slot(1), Some(&Slot { counter: 0, generation: 7 }));
    }

    #[test]
    fn unknown_slot_in_flash_tags_no_telemetry() {
        let of = |telemetry| Ledger { telemetry, ..Ledger::INITIAL }.telemetry_slot();
        assert_eq!(of(0), None);
        assert_eq!(of(SLOTS as u32), Some(SLOTS as u8 - 1));
        assert_eq!(of(SLOTS as u32 + 1), None);
        assert_eq!(of(u32::MAX), None);
    }
}
