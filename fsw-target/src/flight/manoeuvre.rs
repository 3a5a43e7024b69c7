//! Manoeuvre of the flight computer: upload of its table, storage, and the player on samples.
//!
//! Input: telecommands and readings. Output: torque of each motor, N m; record for the checkpoint. The upload is
//! written to the table word by word, in any order. The table is usable once the checksum over all of its words has been
//! confirmed and the values are valid.
//!
//! | word | content |
//! |---|---|
//! | 0 | time between knots, µs |
//! | 1 | repeats, upper 16 bits; coefficients of each wheel, lower 16 bits |
//! | 2, 3 | limits of rate, rad/s, and of excursion, rad, f32 |
//! | 4 to 7 | torque limit of each wheel, N m, f32; zero for a wheel not used |
//! | 8 to 11 | speed limit of each wheel, rad/s, f32 |
//! | 12 + 4 j + i | coefficient j of wheel i, both from 0, N m, f32 |
//!
//! A segment is [`SEGMENT`] words. Words after the last coefficient are not part of the checksum.

use crate::flight::craft::WHEELS;
use crate::store::CHECKSUM;
use fsw_core::checkpoint::{self, Archive, Persist};
use fsw_core::manoeuvre::{Abort, Player, Progress, Reading, State, Table, TableError};

/// Coefficients of a wheel, at most: a pattern of 80 knots.
pub const SPLINES: usize = 77;
/// Words of a table before its coefficients.
const HEAD: usize = 4 + 2 * WHEELS;
/// Words of the longest table.
pub const WORDS: usize = HEAD + WHEELS * SPLINES;
/// Words of a segment.
pub const SEGMENT: usize = 16;
/// Segments of the longest table.
pub const SEGMENTS: usize = WORDS.div_ceil(SEGMENT);
const _: () = assert!(SEGMENTS <= 32, "one bit each in telemetry");

/// Table of the flight image.
pub type FlightTable = Table<f32, WHEELS, SPLINES>;

/// Reason for a table that is not usable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum LoadError {
    /// Checksum differs: a segment is missing or wrong.
    Checksum,
    /// A value is invalid.
    Invalid(TableError),
}

/// Word of a table; zero beyond its end.
pub fn word(table: &FlightTable, index: usize) -> u32 {
    let limits = &table.limits;
    let of = |values: &[f32; WHEELS], i: usize| values.get(i).map_or(0, |value| value.to_bits());
    match index {
        0 => table.knot_us,
        1 => table.repeats << 16 | table.splines & 0xffff,
        2 => limits.rate_rad_s.to_bits(),
        3 => limits.excursion_rad.to_bits(),
        _ => match index.saturating_sub(4) / WHEELS {
            0 => of(&limits.torque_n_m, index % WHEELS),
            1 => of(&limits.speed_rad_s, index % WHEELS),
            row => {
                let wheel = table.coefficients_n_m.get(index % WHEELS);
                wheel.and_then(|wheel| wheel.get(row - 2)).map_or(0, |value| value.to_bits())
            }
        },
    }
}
// Words 4, 8 and 12 belong to wheel 0.
const _: () = assert!(4 % WHEELS == 0);

/// Sets a word of a table. No effect beyond its end.
pub fn set_word(table: &mut FlightTable, index: usize, word: u32) {
    let value = f32::from_bits(word);
    let limits = &mut table.limits;
    let place = match index {
        0 => return table.knot_us = word,
        1 => return (table.repeats, table.splines) = (word >> 16, word & 0xffff),
        2 => Some(&mut limits.rate_rad_s),
        3 => Some(&mut limits.excursion_rad),
        _ => match index.saturating_sub(4) / WHEELS {
            0 => limits.torque_n_m.get_mut(index % WHEELS),
            1 => limits.speed_rad_s.get_mut(index % WHEELS),
            row => {
                let wheel = table.coefficients_n_m.get_mut(index % WHEELS);
                wheel.and_then(|wheel| wheel.get_mut(row - 2))
            }
        },
    };
    if let Some(place) = place {
        *place = value;
    }
}

/// Number of words of a table, at most [`WORDS`].
pub fn words(table: &FlightTable) -> usize {
    HEAD + WHEELS * (table.splines as usize).min(SPLINES)
}

/// Words of a segment of a table.
pub fn segment(table: &FlightTable, segment: usize) -> [u32; SEGMENT] {
    core::array::from_fn(|i| word(table, segment * SEGMENT + i))
}

/// CRC-32 over the words of a table, each big-endian: polynomial 0x04c11db7, as of checkpoints and of IEEE 802.3.
pub fn checksum(table: &FlightTable) -> u32 {
    let mut digest = CHECKSUM.digest();
    for index in 0..words(table) {
        digest.update(&word(table, index).to_be_bytes());
    }
    digest.finalize()
}

/// Words of a [`Manoeuvre`] in a checkpoint, whatever its state: two flags, checksum, speeds, table.
pub const STORED_WORDS: usize = 3 + WHEELS + WORDS;

/// Table, upload and player of the flight computer.
#[derive(Debug)]
pub struct Manoeuvre {
    table: FlightTable,
    spin_inertia_kg_m2: [f32; WHEELS],
    player: Player<f32, WHEELS>,
    /// Checksum of the table; `None` without a usable one.
    checksum: Option<u32>,
    error: Option<LoadError>,
    /// Segments received since the upload began, a bit each.
    received: u32,
    /// Speeds at the start of a manoeuvre that moves the wheels, rad/s: in the checkpoint.
    moving_from_rad_s: Option<[f32; WHEELS]>,
}

/// Change of the manoeuvre at a step, for the flight computer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// The wheels begin to move.
    TakenOff,
    /// The wheels are commanded no longer.
    Ended,
}

impl Manoeuvre {
    /// Without a table, for wheels of these spin inertias, kg m².
    pub fn new(spin_inertia_kg_m2: [f32; WHEELS]) -> Self {
        Self {
            table: FlightTable::EMPTY,
            spin_inertia_kg_m2,
            player: Player::new(spin_inertia_kg_m2),
            checksum: None,
            error: None,
            received: 0,
            moving_from_rad_s: None,
        }
    }

    /// Takes a segment of an upload. The table is unusable until [`commit`](Self::commit). False during a manoeuvre.
    #[inline(never)]
    pub fn load(&mut self, segment: u8, words: &[u32; SEGMENT]) -> bool {
        if self.player.is_active() || usize::from(segment) >= SEGMENTS {
            return false;
        }
        if self.checksum.take().is_some() || self.error.take().is_some() {
            self.received = 0;
        }
        self.received |= 1 << segment;
        for (index, word) in (usize::from(segment) * SEGMENT..).zip(words) {
            set_word(&mut self.table, index, *word);
        }
        true
    }

    /// Ends an upload: the table is usable if its checksum is this one and its values are valid.
    ///
    /// # Errors
    /// See [`LoadError`]. The table is then unusable; its segments remain, for those that are missing.
    #[inline(never)]
    pub fn commit(&mut self, checksum_of_ground: u32) -> Result<(), LoadError> {
        let result = if checksum(&self.table) == checksum_of_ground {
            self.table.validate(&self.spin_inertia_kg_m2).map_err(LoadError::Invalid)
        } else {
            Err(LoadError::Checksum)
        };
        if !self.player.is_active() {
            self.error = result.err();
            self.checksum = result.ok().map(|()| checksum_of_ground);
        }
        result
    }

    /// Starts the manoeuvre at this time, µs. False without a table, with a flipped bit in it, or during another one.
    #[inline(never)]
    pub fn start(&mut self, at_us: u64) -> bool {
        let is_intact = self.checksum.is_some_and(|crc| crc == checksum(&self.table));
        is_intact && self.player.start(at_us)
    }

    /// Aborts the manoeuvre. False if none waits or flies.
    pub fn abort(&mut self, why: Abort) -> bool {
        self.player.abort(&self.table, why)
    }

    /// After a restart of the computer: returns the wheels to the speeds of a manoeuvre that had moved them.
    #[inline(never)]
    pub fn restore(&mut self) {
        let is_valid = self.table.validate(&self.spin_inertia_kg_m2).is_ok();
        self.checksum = self.checksum.filter(|crc| is_valid && *crc == checksum(&self.table));
        let from = self.moving_from_rad_s.filter(|_| self.checksum.is_some());
        if let Some(from) = from {
            self.player.rest_after_restart(&self.table, from);
        }
    }

    /// Torque of each motor until the next step, N m, and a change of the manoeuvre.
    #[inline(never)]
    pub fn step(
        &mut self,
        time_us: u64,
        reading: &Reading<f32, WHEELS>,
    ) -> ([f32; WHEELS], Option<Event>) {
        let (was_active, was_moving) = (self.player.is_active(), self.player.is_moving());
        let torque_n_m = self.player.step(&self.table, time_us, reading);
        let event = match (self.player.is_active(), self.player.is_moving()) {
            (_, true) if !was_moving => Some(Event::TakenOff),
            (false, _) if was_active => Some(Event::Ended),
            _ => None,
        };
        match event {
            Some(Event::TakenOff) => {
                self.moving_from_rad_s = Some(self.player.progress().start_speed_rad_s);
            }
            Some(Event::Ended) => self.moving_from_rad_s = None,
            None => {}
        }
        (torque_n_m, event)
    }

    /// True from the start of a manoeuvre to its end.
    pub fn is_active(&self) -> bool {
        self.player.is_active()
    }

    /// True if a step is overdue at this time, µs.
    pub fn is_overdue(&self, now_us: u64) -> bool {
        self.player.is_overdue(now_us)
    }

    /// State and what was reached.
    pub fn progress(&self) -> Progress<f32, WHEELS> {
        self.player.progress()
    }

    /// The table.
    pub fn table(&self) -> &FlightTable {
        &self.table
    }

    /// Checksum of the table; `None` without a usable one.
    pub fn checksum(&self) -> Option<u32> {
        self.checksum
    }

    /// True once an upload has begun, or with a table from flash.
    pub fn is_known(&self) -> bool {
        self.received > 0 || self.checksum.is_some() || self.progress().state != State::Idle
    }

    /// Reason why the last upload is not usable.
    pub fn error(&self) -> Option<LoadError> {
        self.error
    }

    /// Segments received since the upload began, a bit each.
    pub fn received(&self) -> u32 {
        self.received
    }
}

/// Table, if it is usable, and speeds of a manoeuvre that moves the wheels. The player itself is not stored: no
/// manoeuvre is resumed.
impl Persist for Manoeuvre {
    fn layout() -> u32 {
        const NAME: u32 = fsw_core::persist::name("Manoeuvre");
        checkpoint::mix(NAME, WORDS as u32)
    }

    #[inline(never)]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let (mut is_usable, mut checksum) =
            (self.checksum.is_some(), self.checksum.unwrap_or_default());
        let (mut has_moved, mut from_rad_s) =
            (self.moving_from_rad_s.is_some(), self.moving_from_rad_s.unwrap_or_default());
        is_usable.persist(archive);
        checksum.persist(archive);
        has_moved.persist(archive);
        from_rad_s.persist(archive);
        self.checksum = is_usable.then_some(checksum);
        self.moving_from_rad_s = has_moved.then_some(from_rad_s);
        // As words: a table in mid-upload may hold any bits.
        for index in 0..WORDS {
            let mut word = word(&self.table, index);
            archive.word(&mut word);
            set_word(&mut self.table, index, word);
        }
    }
}

/// Test table.
#[cfg(test)]
pub mod fixtures {
    use super::*;
    use fsw_core::manoeuvre::Limits;

    /// A manoeuvre of 2.2 s for wheels of 1 mN m.
    pub fn table() -> FlightTable {
        let mut table = FlightTable {
            knot_us: 200_000,
            repeats: 1,
            splines: 8,
            limits: Limits {
                torque_n_m: [1e-3; WHEELS],
                speed_rad_s: [700.0; WHEELS],
                rate_rad_s: 0.5,
                excursion_rad: 0.5,
            },
            ..FlightTable::EMPTY
        };
        for coefficients in &mut table.coefficients_n_m {
            let pattern = [1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0];
            let places = coefficients.iter_mut().zip(pattern);
            places.for_each(|(place, factor)| *place = 5e-4 * factor);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::fixtures::table;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn words_are_those_of_the_documentation() {
        let mut full = table();
        full.splines = SPLINES as u32;
        (0..HEAD).for_each(|index| set_word(&mut full, index, index as u32));
        full.splines = SPLINES as u32;
        full.repeats = 3;
        let list: Vec<u32> = (0..WORDS + 2).map(|index| word(&full, index)).collect();
        assert_eq!(list[1], 3 << 16 | SPLINES as u32);
        assert_eq!((list[2], list[4], list[11]), (2, 4, 11));
        assert_eq!(list[12 + 4 * 7 + 2], full.coefficients_n_m[2][7].to_bits());
        assert_eq!((words(&full), list[WORDS], SEGMENTS), (320, 0, 20));
        let mut copy = FlightTable::EMPTY;
        list.iter().enumerate().for_each(|(index, word)| set_word(&mut copy, index, *word));
        assert_eq!(copy, full);
    }

    #[test]
    fn upload_is_usable_after_its_checksum_alone() {
        let table = table();
        let mut manoeuvre = Manoeuvre::new([1.5e-5; WHEELS]);
        assert!(!manoeuvre.start(0), "no table");
        let count = words(&table).div_ceil(SEGMENT);
        for index in (1..count).rev() {
            assert!(manoeuvre.load(index as u8, &segment(&table, index)));
        }
        let crc = checksum(&table);
        assert_eq!(manoeuvre.commit(crc), Err(LoadError::Checksum), "a segment is missing");
        assert!(!manoeuvre.start(0));
        assert!(!manoeuvre.load(SEGMENTS as u8, &[0; SEGMENT]), "beyond the table");
        assert!(manoeuvre.load(0, &segment(&table, 0)));
        assert_eq!(manoeuvre.commit(crc), Ok(()));
        assert_eq!((manoeuvre.checksum(), manoeuvre.error()), (Some(crc), None));
        manoeuvre.table.coefficients_n_m[1][2] = 4e-4;
        assert!(!manoeuvre.start(0), "a flipped bit");
        manoeuvre.table.coefficients_n_m[1][2] = table.coefficients_n_m[1][2];
        assert!(manoeuvre.start(0));
        assert!(!manoeuvre.load(0, &segment(&table, 0)), "in flight");
        let mut invalid = table;
        invalid.limits.torque_n_m[3] = 1e-4;
        let mut other = Manoeuvre::new([1.5e-5; WHEELS]);
        (0..count).for_each(|i| assert!(other.load(i as u8, &segment(&invalid, i))));
        let error = LoadError::Invalid(TableError::Torque(4));
        assert_eq!(other.commit(checksum(&invalid)), Err(error));
    }
}
