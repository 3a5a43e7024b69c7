//! The store on a flash with power failures and wrong bits.

extern crate std;
use super::*;
use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS, WHEELS};
use embedded_storage::nor_flash::{
    ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use fsw_core::estimator::ekf_sgf::{self, EkfSgf};
use fsw_core::estimator::joint_ekf::{self, JointEkfUd};
use fsw_core::estimator::window::{self, Window};
use fsw_core::{Estimator, Sample, Vec3, WheelArray};
use fsw_core::{Outcome, Prior};
use proptest::prelude::*;
use std::vec::Vec;

/// Lengths of a flash word and of a page, bytes.
const WORD: usize = 4;
const PAGE: usize = 256;
/// Two halves of two pages.
const CAPACITY: usize = 4 * PAGE;

/// A NOR flash with power failures and single writes per word, unlike embedded-storage-inmemory.
#[derive(Clone)]
struct Flash {
    bytes: Vec<u8>,
    /// Words programmed since their last erasure.
    programmed: Vec<bool>,
    /// Erasures of each page.
    erasures: Vec<u32>,
    /// Words and pages until the power fails, during the last of them.
    power: Option<u32>,
    /// State of the generator for the content of an interrupted word or page.
    noise: u64,
    /// False: the bits of an interrupted word or page that were about to change read otherwise each time.
    settles: bool,
    /// Bits that read at random.
    unsettled: Vec<u8>,
    /// A bit that stays 1.
    stuck_bit: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Failure {
    NoPower,
    WrittenTwice,
    Misused(NorFlashErrorKind),
}

impl NorFlashError for Failure {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl Flash {
    fn erased(capacity: usize) -> Self {
        Self {
            bytes: std::vec![0xff; capacity],
            programmed: std::vec![false; capacity / WORD],
            erasures: std::vec![0; capacity / PAGE],
            power: None,
            noise: 1,
            settles: true,
            unsettled: std::vec![0; capacity],
            stuck_bit: None,
        }
    }

    /// Pseudo-random byte from a linear congruential generator.
    fn random(&mut self) -> u8 {
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.noise >> 56) as u8
    }

    /// Changes a byte of a word or page. Without power to its end, each bit has changed or not, or is
    /// unsettled.
    fn change(&mut self, at: usize, to: u8, lasts: bool) {
        let changing = if lasts { 0 } else { self.bytes[at] ^ to };
        let unchanged = if self.settles { self.random() & changing } else { 0 };
        self.bytes[at] = to ^ unchanged;
        self.unsettled[at] = if self.settles { 0 } else { changing };
    }

    /// True if the power lasts for one more word or page.
    fn lasts(&mut self) -> Result<bool, Failure> {
        match &mut self.power {
            None => Ok(true),
            Some(0) => Err(Failure::NoPower),
            Some(left) => {
                *left -= 1;
                Ok(*left > 0)
            }
        }
    }
}

impl ErrorType for Flash {
    type Error = Failure;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        check_read(self, offset, bytes.len()).map_err(Failure::Misused)?;
        // Unsettled bits read as changed, as unchanged, or at random.
        let reading = self.random() % 3;
        for (k, byte) in bytes.iter_mut().enumerate() {
            let at = offset as usize + k;
            let noise = match reading {
                0 => 0,
                1 => u8::MAX,
                _ => self.random(),
            };
            *byte = self.bytes[at] ^ noise & self.unsettled[at];
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failure> {
        check_erase(self, from, to).map_err(Failure::Misused)?;
        for page in from as usize / PAGE..to as usize / PAGE {
            let lasts = self.lasts()?;
            self.erasures[page] += 1;
            for at in page * PAGE..(page + 1) * PAGE {
                self.change(at, 0xff, lasts);
                self.programmed[at / WORD] = !lasts;
            }
            if !lasts {
                return Err(Failure::NoPower);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        check_write(self, offset, bytes.len()).map_err(Failure::Misused)?;
        for (k, word) in bytes.chunks_exact(WORD).enumerate() {
            let lasts = self.lasts()?;
            let at = offset as usize + k * WORD;
            if self.programmed[at / WORD] {
                return Err(Failure::WrittenTwice);
            }
            self.programmed[at / WORD] = true;
            for (i, byte) in word.iter().enumerate() {
                self.change(at + i, *byte, lasts);
            }
            if let Some(bit) = self.stuck_bit {
                self.bytes[bit / 8] |= 1 << (bit % 8);
            }
            if !lasts {
                return Err(Failure::NoPower);
            }
        }
        Ok(())
    }
}

/// A state with the same number in every word, in two lengths: a mixture of two states is visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct State {
    words: [u32; 5],
    more: Option<[u32; 14]>,
}

fsw_core::persist!([] State { words, more });

fn state(number: u32) -> State {
    let more = number.is_multiple_of(3).then_some([number; 14]);
    State { words: [number; 5], more }
}

fn open(flash: Flash) -> Store<Flash> {
    Store::open(flash).unwrap()
}

fn loaded(store: &mut Store<Flash>) -> Option<State> {
    let mut found = State::default();
    store.load(&mut found).unwrap().map(|_| found)
}

/// Saves states of these numbers until the power fails. Returns the last one saved completely.
fn save_all(store: &mut Store<Flash>, numbers: std::ops::Range<u32>) -> Option<u32> {
    let mut last = None;
    for number in numbers {
        if store.save(&mut state(number)).is_err() {
            break;
        }
        last = Some(number);
    }
    last
}

#[test]
fn empty_flash_has_no_checkpoint() {
    assert_eq!(loaded(&mut open(Flash::erased(CAPACITY))), None);
    let mut noise = Flash::erased(CAPACITY);
    for at in 0..CAPACITY {
        noise.bytes[at] = noise.random();
    }
    noise.programmed.fill(true);
    let mut store = open(noise);
    assert_eq!(loaded(&mut store), None);
    store.save(&mut state(1)).unwrap();
    assert_eq!(loaded(&mut store), Some(state(1)));
}

#[test]
fn newest_checkpoint_is_loaded_after_a_reset() {
    let mut store = open(Flash::erased(CAPACITY));
    for number in 0..50 {
        let saved = store.save(&mut state(number)).unwrap();
        assert_eq!(saved.sequence, number);
        assert_eq!(loaded(&mut store), Some(state(number)));
        store = open(store.flash);
        assert_eq!(loaded(&mut store), Some(state(number)));
    }
}

#[test]
fn both_halves_wear_alike_and_resets_wear_nothing() {
    let wear = |is_reset: fn(u32) -> bool| {
        let mut store = open(Flash::erased(CAPACITY));
        for number in 0..400 {
            store.save(&mut state(number)).unwrap();
            if is_reset(number) {
                store = open(store.flash);
            }
        }
        let pages = store.flash.erasures.clone();
        assert_eq!(store.erasures(), pages.iter().sum::<u32>() / 2);
        assert_eq!(open(store.flash).erasures(), pages.iter().sum::<u32>() / 2);
        pages
    };
    let pages = wear(|_| false);
    let (least, most) = (pages.iter().min().unwrap(), pages.iter().max().unwrap());
    // A half holds three checkpoints, of 160, 96 and 96 bytes: 400 / 3 erasures of two halves.
    assert!(most - least <= 1 && (66..=67).contains(most), "{least} to {most}");
    assert_eq!(wear(|number| number % 7 == 0), pages);
    assert_eq!(wear(|_| true), pages);
}

/// The power fails during each word and each page in turn. Bits that do not settle: each of several starts
/// reads them otherwise.
#[test]
fn any_power_failure_leaves_the_last_checkpoint_or_the_one_before() {
    const SAVES: u32 = 14;
    const STARTS: usize = 4;
    let words_and_pages = {
        let mut flash = Flash::erased(CAPACITY);
        flash.power = Some(u32::MAX);
        let mut store = open(flash);
        assert_eq!(save_all(&mut store, 1..SAVES), Some(SAVES - 1));
        assert!(store.erasures() > 3);
        u32::MAX - store.flash.power.unwrap()
    };
    for (noise, settles, cut) in (0..4)
        .flat_map(|noise| [(noise, true), (noise, false)])
        .flat_map(|(noise, settles)| (1..=words_and_pages).map(move |cut| (noise, settles, cut)))
    {
        let mut flash = Flash::erased(CAPACITY);
        (flash.power, flash.noise, flash.settles) = (Some(cut), noise, settles);
        let mut store = open(flash);
        let last = save_all(&mut store, 1..SAVES);
        store.flash.power = None;
        for _ in 0..STARTS {
            store = open(store.flash);
            let found = loaded(&mut store);
            let next = state(last.unwrap_or(0) + 1);
            let is_one = found == last.map(state) || found == Some(next);
            assert!(is_one, "cut {cut}: {found:?} after {last:?}");
        }
        // Saving continues. A word that is unsettled and reads as erased takes no other word: one save fails,
        // and the next uses another place.
        let mut failed = 0;
        for last in 100..110 {
            if store.save(&mut state(last)).is_err() {
                failed += 1;
                store.save(&mut state(last)).unwrap();
            }
            for _ in 0..STARTS {
                store = open(store.flash);
                assert_eq!(loaded(&mut store), Some(state(last)), "cut {cut}");
            }
        }
        assert!(failed <= u32::from(!settles), "cut {cut}: {failed} saves failed");
    }
}

/// A record as one of a pair: its state in flash.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kept {
    Whole,
    TornHead,
    TornState,
    TornTail,
    OtherLayout,
}

/// Every pair of records in one half or in both, of any order of their numbers, up to the last number: the newest whole one
/// of the layout is loaded, the survey has the newest whole one of any, and the next save is the newest.
#[test]
fn every_pair_of_records_loads_the_newest_whole_one() {
    use super::record::{self, CHUNK, Record};
    use Kept::{OtherLayout, TornHead, TornState, TornTail, Whole};
    const HALF: u32 = (CAPACITY / 2) as u32;
    let kinds = [Whole, TornHead, TornState, TornTail, OtherLayout];
    let numbers = [(0, 1), (1, 0), (7, 7), (u32::MAX - 1, u32::MAX), (u32::MAX, 0), (5, u32::MAX)];
    let pairs = kinds.into_iter().flat_map(|first| kinds.map(|second| (first, second)));
    for ((first, second), (places, numbers)) in pairs
        .flat_map(|pair| [[0, 0], [0, HALF], [HALF, 0]].map(|places| (pair, places)))
        .flat_map(|(pair, places)| numbers.map(|numbers| (pair, (places, numbers))))
    {
        let mut flash = Flash::erased(CAPACITY);
        for half in [0, HALF] {
            record::write(&mut flash, half, &record::mark(1)).unwrap();
        }
        let mut end = [CHUNK; 2];
        let mut records = Vec::new();
        for (kind, (half, sequence)) in
            [first, second].into_iter().zip(places.into_iter().zip([numbers.0, numbers.1]))
        {
            let used = &mut end[usize::from(half != 0)];
            let mut source = open(Flash::erased(CAPACITY));
            // The contents of a record of this number: state 1 or 2.
            let content = records.len() as u32 + 1;
            source.next_sequence = sequence;
            source.save(&mut state(content)).unwrap();
            let saved = source.newest.unwrap();
            let fingerprint = saved.fingerprint ^ u32::from(kind == OtherLayout);
            let record = Record { at: half + *used, fingerprint, ..saved };
            let mut digest = record::CRC.digest();
            let mut at = 0;
            while saved.at + at < saved.end() {
                let mut chunk = record::read(&mut source.flash, saved.at + at).unwrap();
                let is_tail = saved.at + at + CHUNK == saved.end();
                if at == 0 {
                    chunk = record.head();
                }
                if !is_tail {
                    digest.update(&record::bytes_of(&chunk));
                } else {
                    chunk = record::tail_of(digest.clone());
                }
                let is_torn = match kind {
                    TornHead => at == 0,
                    TornState => at == CHUNK,
                    TornTail => is_tail,
                    Whole | OtherLayout => false,
                };
                chunk[0] ^= u32::from(is_torn);
                record::write(&mut flash, record.at + at, &chunk).unwrap();
                at += CHUNK;
            }
            *used = record.end() - half;
            records.push((record, kind, content));
        }
        let newest = |is: &dyn Fn(Kept) -> bool| {
            let known = records.iter().filter(|(_, kind, _)| is(*kind));
            known.max_by_key(|(record, _, _)| record.order()).map(|(_, _, content)| *content)
        };
        let mut store = open(flash);
        let what = std::format!("{first:?} {second:?} at {places:?}, numbers {numbers:?}");
        let of_layout = newest(&|kind| kind == Whole);
        assert_eq!(loaded(&mut store), of_layout.map(state), "{what}");
        let of_any = newest(&|kind| matches!(kind, Whole | OtherLayout));
        assert_eq!(store.newest_bytes() > 0, of_any.is_some(), "{what}");
        // Numbers end after 4·10⁹ checkpoints, 245,000 years at one in half an hour.
        if numbers.0.max(numbers.1) < u32::MAX {
            store.save(&mut state(9)).unwrap();
            assert_eq!(loaded(&mut store), Some(state(9)), "{what}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]
    /// Repeated power failures that leave bits unsettled: an interrupted save may read as complete at one
    /// start and not at the next, but no state saved completely is lost for it, mixed or forged.
    #[test]
    fn unsettled_bits_lose_no_complete_save(
        cuts in prop::collection::vec(1..120u32, 1..40),
        noise in any::<u64>(),
    ) {
        let mut flash = Flash::erased(CAPACITY);
        (flash.noise, flash.settles) = (noise, false);
        let (mut saved, mut number) = (0, 0);
        for cut in cuts {
            flash.power = Some(cut);
            let mut store = open(flash);
            while store.flash.power != Some(0) {
                number += 1;
                if store.save(&mut state(number)).is_ok() {
                    saved = number;
                }
            }
            flash = store.flash;
            flash.power = None;
            for _ in 0..4 {
                let mut store = open(flash);
                let found = loaded(&mut store);
                flash = store.flash;
                let newest = found.map_or(0, |found| found.words[0]);
                prop_assert!((saved..=number).contains(&newest), "{newest} after {saved}");
                prop_assert!(found.is_none_or(|found| found == state(newest)));
            }
        }
    }

    /// Repeated power failures.
    #[test]
    fn saved_state_is_never_lost(
        cuts in prop::collection::vec(1..120u32, 1..40),
        noise in any::<u64>(),
    ) {
        let mut flash = Flash::erased(CAPACITY);
        flash.noise = noise;
        let (mut saved, mut number) = (None, 0);
        for cut in cuts {
            flash.power = Some(cut);
            let mut store = open(flash);
            prop_assert_eq!(loaded(&mut store), saved.map(state));
            while store.flash.power != Some(0) {
                number += 1;
                if store.save(&mut state(number)).is_ok() {
                    saved = Some(number);
                }
            }
            flash = store.flash;
            flash.power = None;
            // The interrupted save may be complete.
            let found = loaded(&mut open(flash.clone()));
            prop_assert!(found == saved.map(state) || found == Some(state(number)));
            saved = found.map(|found| found.words[0]);
        }
    }
}

#[test]
fn flipped_bit_loses_the_newest_checkpoint_at_most() {
    let mut store = open(Flash::erased(CAPACITY));
    save_all(&mut store, 1..8);
    let mut before = 0;
    for bit in 0..8 * CAPACITY {
        let mut flash = store.flash.clone();
        flash.bytes[bit / 8] ^= 1 << (bit % 8);
        let mut flipped = open(flash);
        let found = loaded(&mut flipped);
        assert!(found == Some(state(7)) || found == Some(state(6)), "bit {bit}: {found:?}");
        before += u32::from(found == Some(state(6)));
        // The next save succeeds, including where the flipped bit resembles a record.
        flipped.save(&mut state(8)).unwrap();
        assert_eq!(loaded(&mut open(flipped.flash)), Some(state(8)), "bit {bit}");
    }
    // Every bit of the newest checkpoint is covered by its CRC.
    assert_eq!(before, 8 * Record::length(6));
}

#[test]
fn skipped_checkpoints_are_counted() {
    let mut store = open(Flash::erased(CAPACITY));
    save_all(&mut store, 1..3);
    let newest = store.newest.unwrap();
    store.flash.bytes[newest.at as usize + 40] ^= 1;
    let checkpoint = store.load(&mut State::default()).unwrap().unwrap();
    assert_eq!((checkpoint.sequence, checkpoint.passed_over), (newest.sequence - 1, 1));
}

#[test]
fn checkpoint_that_does_not_read_back_does_not_count() {
    let mut store = open(Flash::erased(CAPACITY));
    store.save(&mut state(1)).unwrap();
    let next = store.active.used.unwrap() as usize;
    // In the state, at a bit that is 0.
    store.flash.stuck_bit = Some(8 * (next + 40));
    assert_eq!(store.save(&mut state(2)), Err(Error::NotStored));
    assert_eq!(loaded(&mut store), Some(state(1)));
    store.save(&mut state(4)).unwrap();
    assert_eq!(loaded(&mut open(store.flash)), Some(state(4)));
}

#[test]
fn only_the_own_layout_is_loaded() {
    let mut store = open(Flash::erased(CAPACITY));
    store.save(&mut state(1)).unwrap();
    let mut other = [0u32; 6];
    assert_eq!(store.load(&mut other), Ok(None));
    store.save(&mut [7u32; 6]).unwrap();
    assert_eq!(loaded(&mut store), Some(state(1)));
}

#[test]
fn impossible_operations_are_errors() {
    let odd = Store::open(Flash::erased(3 * PAGE));
    assert_eq!(odd.err(), Some(Error::Geometry));
    let mut store = open(Flash::erased(CAPACITY));
    assert_eq!(store.save(&mut [0u32; 120]), Err(Error::TooLarge));
    store.save(&mut [0u32; 8 * (512 / 32 - 3)]).unwrap();
    let not_a_number = Error::Invalid(InvalidWord { place: "f32" });
    assert_eq!(store.save(&mut [f32::NAN]), Err(not_a_number));
}

#[test]
fn room_is_made_ahead() {
    let mut store = open(Flash::erased(CAPACITY));
    let mut asked = 0;
    for number in 0..40 {
        let mut state = state(number);
        asked += u32::from(store.make_room(5 + 1 + 14).unwrap());
        let before = store.erasures();
        store.save(&mut state).unwrap();
        assert_eq!(store.erasures(), before, "erased in {number}");
        assert_eq!(loaded(&mut store), Some(state));
    }
    assert_eq!(asked, store.erasures());
}

/// The ground writes the received bytes to a flash of its own, after the mark.
#[test]
fn checkpoint_read_out_in_parts_can_be_loaded_elsewhere() {
    let mut store = open(Flash::erased(CAPACITY));
    assert_eq!((store.newest_bytes(), store.read_part(0, &mut [0; 64])), (0, Ok(0)));
    save_all(&mut store, 1..10);
    let length = store.newest_bytes();
    let (mut sent, mut part, mut index) = (Vec::new(), [0; 70], 0);
    loop {
        let valid = store.read_part(index, &mut part).unwrap();
        if valid == 0 {
            break;
        }
        sent.extend_from_slice(&part[..valid]);
        index += 1;
        if index == 1 {
            // Saved during the read-out, and not part of it.
            store.save(&mut state(10)).unwrap();
        }
    }
    assert_eq!(sent.len() as u32, length);
    let mut ground = Flash::erased(CAPACITY);
    ground.bytes[32..32 + sent.len()].copy_from_slice(&sent);
    assert_eq!(loaded(&mut open(ground)), Some(state(9)));
}

fn wheels() -> WheelArray<f32, WHEELS> {
    CRAFT.wheels().unwrap()
}

fn joint_ekf() -> JointEkfUd<f32, WHEELS> {
    JointEkfUd::new(joint_ekf::Config::new(CRAFT.gyro_noise_rad_s), wheels()).unwrap()
}

fn ekf_sgf_rls() -> EkfSgf<f32, WHEELS> {
    let prior = Prior { inertia_kg_m2: [0.05, 0.05, 0.03, 0.0, 0.0, 0.0], sigma_kg_m2: [0.02; 6] };
    EkfSgf::new(ekf_sgf::Config::kim_2013(CRAFT.gyro_noise_rad_s, prior), wheels()).unwrap()
}

fn window() -> fsw_steps::Window9 {
    Window::new(window::Config::new(CRAFT.gyro_noise_rad_s), wheels()).unwrap()
}

/// Steps the recording with a reset after each of these samples.
fn continues_after_resets<E: Estimator<f32, WHEELS> + Persist>(
    fresh: impl Fn() -> E,
    resets: &[usize],
) {
    let (mut without, mut with) = (fresh(), fresh());
    let mut store = open(Flash::erased(256 * PAGE));
    for (k, row) in ROWS.iter().enumerate() {
        let sample = Sample {
            time_us: row.time_us,
            rate_rad_s: Vec3::from(row.rate_rad_s),
            wheel_speed_rad_s: row.wheel_speed_rad_s,
            torque_n_m: Vec3::from(row.torque_n_m),
            attitude: None,
        };
        let (a, b): (Outcome, Outcome) = (without.step(&sample), with.step(&sample));
        assert_eq!(a, b, "sample {k}");
        if resets.contains(&k) {
            store.save(&mut with).unwrap();
            store = open(store.flash);
            with = fresh();
            store.load(&mut with).unwrap().unwrap();
        }
    }
    assert_eq!(without.estimate(), with.estimate());
}

#[test]
fn estimators_continue_bit_for_bit_after_resets() {
    let resets: Vec<usize> = (0..600).step_by(13).collect();
    continues_after_resets(joint_ekf, &resets);
    continues_after_resets(ekf_sgf_rls, &resets);
    continues_after_resets(window, &resets);
}
