//! Checkpoints of the selected estimator: restored at the start, saved periodically, sent on request.

use super::parts::Housekeeping;
use crate::flight::manoeuvre::{Manoeuvre, STORED_WORDS};
use crate::flight::selected::SelectedEstimator;
use crate::link::telemetry::{CheckpointPart, CheckpointState, PART_BYTES};
use crate::store::{self, Store};
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checkpoint::{self, Archive, Persist};
use fsw_roster::EstimatorSlot;

/// Period of checkpoints, µs: half an hour. With three checkpoints of `window` per erasure of one half of
/// the flash, an endurance of 10,000 erasures of each half lasts 3.4 years.
const PERIOD_US: u64 = 1_800_000_000;

/// Delay from a telecommand that changes the estimator to a checkpoint, µs: 10 s. The checkpoint
/// keeps the change over a reset; the delay merges several telecommands into one checkpoint.
const SOON_US: u64 = 10_000_000;

/// Assumed time without power, µs: longer than the longest pause between samples that a gate accepts,
/// since the true time is unknown.
const OFF_US: u64 = 60_000_000;

/// Upper bound of a checkpoint, words: the size of the largest estimator, one word for each field that is smaller
/// than a word in memory, and the manoeuvre. A fixed number: sizes depend on those of pointers, and host and target are to
/// erase at the same instants.
const MAX_WORDS: u32 = 54 * 1024 / size_of::<u32>() as u32;
const SMALL_FIELDS: usize = 128;
const _: () = {
    let words = EstimatorSlot::LARGEST_BYTES / size_of::<u32>() + SMALL_FIELDS + STORED_WORDS;
    assert!(words <= MAX_WORDS as usize, "a checkpoint exceeds its upper bound");
};

/// Upper bound of a checkpoint, bytes.
#[cfg(test)]
pub const MAX_BYTES: usize = MAX_WORDS as usize * size_of::<u32>();

/// Checkpoints in flash, with their counts.
pub struct Checkpoints<F> {
    /// The flash before [`restore`](Self::restore).
    unopened: Option<F>,
    /// `None` if the flash cannot be read.
    store: Option<Store<F>>,
    /// Result of [`restore`](Self::restore).
    pub found: CheckpointState,
    /// Checkpoints saved since the start; saturates.
    pub saved: u32,
    /// Checkpoints not saved after a flash error; saturates.
    pub failed: u32,
    /// Time of the next save, µs.
    next_us: u64,
    /// True once space for the next save has been erased.
    erased_ahead: bool,
    /// Index of the next part to send, during a dump.
    next_part: Option<u16>,
}

/// Content of a checkpoint: time, estimator and manoeuvre.
struct Content<'a> {
    time_us: u64,
    estimator: &'a mut SelectedEstimator,
    /// `None`: the stored one is left out of a load.
    manoeuvre: Option<&'a mut Manoeuvre>,
}

impl Persist for Content<'_> {
    fn layout() -> u32 {
        let layout = checkpoint::mix(u64::layout(), SelectedEstimator::layout());
        checkpoint::mix(layout, Manoeuvre::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.time_us.persist(archive);
        self.estimator.persist(archive);
        match &mut self.manoeuvre {
            Some(manoeuvre) => manoeuvre.persist(archive),
            None => (0..STORED_WORDS).for_each(|_| archive.word(&mut 0)),
        }
    }
}

impl<F: NorFlash> Checkpoints<F> {
    /// The flash before [`restore`](Self::restore).
    pub fn unopened(flash: F) -> Self {
        Self {
            unopened: Some(flash),
            store: None,
            found: CheckpointState::Failed,
            saved: 0,
            failed: 0,
            next_us: 0,
            erased_ahead: false,
            next_part: None,
        }
    }

    /// Opens the flash and restores estimator and time from the newest valid checkpoint, unless
    /// `is_skipped`.
    pub fn restore(
        &mut self,
        estimator: &mut SelectedEstimator,
        manoeuvre: &mut Manoeuvre,
        board: &mut impl Housekeeping,
        is_skipped: bool,
    ) {
        let opened = self.unopened.take().map(Store::open);
        if let Some(Ok(store)) = opened {
            let store = self.store.insert(store);
            self.found = match is_skipped && store.newest_bytes() > 0 {
                true => CheckpointState::Skipped,
                false => restore_newest(store, estimator, manoeuvre, board),
            };
        }
        self.next_us = board.now_us().saturating_add(PERIOD_US);
    }

    /// Restores a rebuilt estimator from the newest checkpoint, in flight: time and manoeuvre go on. Without a usable one the
    /// estimator stays as it was rebuilt.
    pub fn reload(&mut self, estimator: &mut SelectedEstimator) {
        let Some(store) = &mut self.store else { return };
        if store.load(&mut Content { time_us: 0, estimator, manoeuvre: None }).is_err() {
            // Partly overwritten. No error: the craft has been accepted before.
            let _ = estimator.restart();
        }
    }

    /// True if a checkpoint is due.
    pub fn is_due(&self, now_us: u64) -> bool {
        now_us >= self.next_us
    }

    /// Schedules a checkpoint before the end of the period.
    pub fn save_soon(&mut self, now_us: u64) {
        self.next_us = self.next_us.min(now_us.saturating_add(SOON_US));
    }

    /// Saves a checkpoint; false after a flash error. The next one is due one period later.
    pub fn save(
        &mut self,
        estimator: &mut SelectedEstimator,
        manoeuvre: &mut Manoeuvre,
        board: &mut impl Housekeeping,
    ) -> bool {
        let manoeuvre = Some(manoeuvre);
        let mut content = Content { time_us: board.now_us(), estimator, manoeuvre };
        let saved = self.store.as_mut().is_some_and(|store| store.save(&mut content).is_ok());
        let counter = if saved { &mut self.saved } else { &mut self.failed };
        *counter = counter.saturating_add(1);
        self.next_us = board.now_us().saturating_add(PERIOD_US);
        self.erased_ahead = false;
        saved
    }

    /// True if the next save may need an erasure.
    pub fn may_need_erasure(&self) -> bool {
        !self.erased_ahead
    }

    /// Erases the space of the next save. After an error, that save repeats the erasure and reports.
    #[inline(never)]
    pub fn erase_ahead(&mut self) {
        if let Some(store) = &mut self.store {
            let _ = store.make_room(MAX_WORDS);
        }
        self.erased_ahead = true;
    }

    /// Starts a dump of the newest checkpoint; false if there is none.
    pub fn begin_dump(&mut self) -> bool {
        let exists = self.parts() > 0;
        self.next_part = exists.then_some(0);
        exists
    }

    /// Number of parts of the newest checkpoint; 0 without one.
    fn parts(&self) -> u16 {
        let bytes = self.store.as_ref().map_or(0, Store::newest_bytes);
        u16::try_from(bytes.div_ceil(PART_BYTES as u32)).unwrap_or(u16::MAX)
    }

    /// The next part of a dump; `None` outside a dump.
    pub fn next_part(&mut self) -> Option<CheckpointPart> {
        let index = self.next_part?;
        let parts = self.parts();
        let mut bytes = [0; PART_BYTES];
        let store = self.store.as_mut()?;
        let length = store.read_part(index.into(), &mut bytes).unwrap_or(0);
        let part = CheckpointPart::new(index, parts, bytes.get(..length)?)?;
        self.next_part = index.checked_add(1).filter(|next| *next < parts && length > 0);
        (length > 0).then_some(part)
    }
}

fn restore_newest<F: NorFlash>(
    store: &mut Store<F>,
    estimator: &mut SelectedEstimator,
    manoeuvre: &mut Manoeuvre,
    board: &mut impl Housekeeping,
) -> CheckpointState {
    let mut content = Content { time_us: 0, estimator, manoeuvre: Some(manoeuvre) };
    let found = store.load(&mut content);
    let time_us = content.time_us;
    match found {
        Ok(None) if store.newest_bytes() > 0 => CheckpointState::OtherImage,
        Ok(None) => CheckpointState::None,
        Ok(Some(found)) => {
            board.resume_at(time_us.saturating_add(OFF_US));
            match found.passed_over {
                0 => CheckpointState::Restored,
                _ => CheckpointState::RestoredOlder,
            }
        }
        Err(why) => {
            // The state may be partly overwritten.
            let _ = estimator.restart(); // no error: the craft has been accepted before
            match why {
                store::Error::Invalid(_) => CheckpointState::Unusable,
                _ => CheckpointState::Failed,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::flight::computer::SLICES_PER_SAMPLE;
    use crate::flight::selected::EstimatorId;
    use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};
    use fsw_core::Prior;
    use fsw_core::checkpoint::ToWords;
    use fsw_core::{Estimator, Sample, Vec3};
    use std::boxed::Box;
    use std::vec;

    /// Number of words of a checkpoint.
    fn words(estimator: &mut SelectedEstimator) -> u32 {
        let mut words = vec![0; 2 * MAX_WORDS as usize];
        let mut archive = ToWords::new(&mut words);
        let mut manoeuvre = Manoeuvre::new([0.0; 4]);
        let manoeuvre = Some(&mut manoeuvre);
        let mut content = Content { time_us: 0, estimator, manoeuvre };
        checkpoint::transfer(&mut content, &mut archive).unwrap();
        archive.written() as u32
    }

    fn sample(k: u64, rate_rad_s: [f32; 3], wheel_speed_rad_s: [f32; 4]) -> Sample<f32, 4> {
        Sample {
            time_us: k * 100_000,
            rate_rad_s: Vec3::from(rate_rad_s),
            wheel_speed_rad_s,
            torque_n_m: Vec3::zeros(),
            attitude: None,
        }
    }

    #[test]
    fn no_checkpoint_exceeds_the_erased_space() {
        let prior = Prior::of_size(0.1);
        for id in EstimatorId::ALL {
            let mut estimator = Box::new(SelectedEstimator::new(CRAFT).unwrap());
            estimator.set_prior(prior).unwrap();
            estimator.select(id).unwrap();
            for (k, row) in (0..).zip(&ROWS) {
                estimator.step(&sample(k, row.rate_rad_s, row.wheel_speed_rad_s));
                estimator.work(SLICES_PER_SAMPLE);
                assert!(words(&mut estimator) <= MAX_WORDS, "{id:?}, sample {k}");
            }
        }
        // Up to three quarters of the block storage, beyond which the window frees blocks.
        let (mut estimator, mut most) = (Box::new(SelectedEstimator::new(CRAFT).unwrap()), 0);
        for k in 0..5_000 {
            let noise = [(k % 7) as f32, (k % 5) as f32, (k % 3) as f32].map(|x| 1e-5 * x);
            estimator.step(&sample(k, noise, [0.0; 4]));
            estimator.work(SLICES_PER_SAMPLE);
            if k % 10 == 0 {
                most = most.max(words(&mut estimator));
            }
        }
        assert!(most > 3_000 && most <= MAX_WORDS, "{most} of {MAX_WORDS} words");
    }
}
