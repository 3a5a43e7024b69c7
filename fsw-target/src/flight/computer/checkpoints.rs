//! Checkpoints of the estimators: brought back at the start, saved now and then, sent to the ground.

use super::Housekeeping;
use crate::flight::selected::SelectedEstimator;
use crate::link::telemetry::{CheckpointPart, CheckpointState, PART_BYTES};
use crate::store::{self, Store};
use embedded_storage::nor_flash::NorFlash;
use fsw_core::checkpoint::{self, Archive, Persist};
use fsw_steps::EstimatorSlot;

/// Between two checkpoints, unless the ground asks, µs: ten minutes. At seven checkpoints of
/// `window` to an erasure of one half of the flash, 10,000 erasures of each last 2.6 years.
const PERIOD_US: u64 = 600_000_000;

/// What the ground has set is kept after so long, so that a reset doesn't undo it, µs: ten seconds, in which all
/// of a few commands in a row have come.
const SOON_US: u64 = 10_000_000;

/// Nobody knows for how long a computer was off: more than any gate takes for a pause between two
/// samples, µs.
const OFF_US: u64 = 60_000_000;

/// Words that a checkpoint takes at most: as many as the largest estimator in memory, and one more for each of
/// what is smaller there than a word.
const MOST_WORDS: u32 = (EstimatorSlot::LARGEST_BYTES / size_of::<u32>() + SMALL_ONES) as u32;
const SMALL_ONES: usize = 128;

/// Checkpoints, and what became of them.
pub struct Checkpoints<F> {
    /// Until it is opened.
    unopened: Option<F>,
    /// None where the flash can't be read.
    store: Option<Store<F>>,
    /// What was in the flash at the start.
    pub found: CheckpointState,
    /// Saved since then.
    pub saved: u32,
    /// Not saved, since the flash failed.
    pub failed: u32,
    next_us: u64,
    /// Whether the next one needs no erasure, as far as can be seen to.
    has_room: bool,
    /// The part that is sent next, while one is.
    dumping: Option<u16>,
}

/// What is kept: the estimators, and when that was.
struct Kept<'a> {
    time_us: u64,
    onboard: &'a mut SelectedEstimator,
}

impl Persist for Kept<'_> {
    fn layout() -> u32 {
        checkpoint::mix(u64::layout(), SelectedEstimator::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        self.time_us.persist(archive);
        self.onboard.persist(archive);
    }
}

impl<F: NorFlash> Checkpoints<F> {
    /// The flash as it is.
    pub fn unopened(flash: F) -> Self {
        Self {
            unopened: Some(flash),
            store: None,
            found: CheckpointState::Failed,
            saved: 0,
            failed: 0,
            next_us: 0,
            has_room: false,
            dumping: None,
        }
    }

    /// Opens the flash, and brings the estimators and the time back from it.
    pub fn restore(&mut self, onboard: &mut SelectedEstimator, board: &mut impl Housekeeping) {
        let opened = self.unopened.take().map(Store::open);
        if let Some(Ok(store)) = opened {
            let store = self.store.insert(store);
            self.found = bring_back(store, onboard, board);
        }
        self.next_us = board.now_us().saturating_add(PERIOD_US);
    }

    /// Whether it is time to save one.
    pub fn is_due(&self, now_us: u64) -> bool {
        now_us >= self.next_us
    }

    /// Has one saved before its time.
    pub fn save_soon(&mut self, now_us: u64) {
        self.next_us = self.next_us.min(now_us.saturating_add(SOON_US));
    }

    /// Saves one; false if that failed. The next one is due a period after.
    pub fn save(&mut self, onboard: &mut SelectedEstimator, board: &mut impl Housekeeping) -> bool {
        let mut kept = Kept { time_us: board.now_us(), onboard };
        let saved = self.store.as_mut().is_some_and(|store| store.save(&mut kept).is_ok());
        let counter = if saved { &mut self.saved } else { &mut self.failed };
        *counter = counter.saturating_add(1);
        self.next_us = board.now_us().saturating_add(PERIOD_US);
        self.has_room = false;
        saved
    }

    /// Whether the next one may need an erasure.
    pub fn needs_room(&self) -> bool {
        !self.has_room
    }

    /// Erases now what the next one would have to erase. If that fails, the next one tries again, and tells.
    #[inline(never)]
    pub fn make_room(&mut self) {
        if let Some(store) = &mut self.store {
            let _ = store.make_room(MOST_WORDS);
        }
        self.has_room = true;
    }

    /// Begins to send the newest checkpoint; false if there is none.
    pub fn begin_dump(&mut self) -> bool {
        let has_one = self.parts() > 0;
        self.dumping = has_one.then_some(0);
        has_one
    }

    fn parts(&self) -> u16 {
        let bytes = self.store.as_ref().map_or(0, Store::newest_bytes);
        u16::try_from(bytes.div_ceil(PART_BYTES as u32)).unwrap_or(u16::MAX)
    }

    pub fn next_part(&mut self) -> Option<CheckpointPart> {
        let index = self.dumping?;
        let parts = self.parts();
        let mut bytes = [0; PART_BYTES];
        let store = self.store.as_mut()?;
        let length = store.read_part(index.into(), &mut bytes).unwrap_or(0);
        let part = CheckpointPart::new(index, parts, bytes.get(..length)?)?;
        self.dumping = index.checked_add(1).filter(|next| *next < parts && length > 0);
        (length > 0).then_some(part)
    }
}

fn bring_back<F: NorFlash>(
    store: &mut Store<F>,
    onboard: &mut SelectedEstimator,
    board: &mut impl Housekeeping,
) -> CheckpointState {
    let mut kept = Kept { time_us: 0, onboard };
    let found = store.load(&mut kept);
    let time_us = kept.time_us;
    match found {
        Ok(None) => CheckpointState::None,
        Ok(Some(found)) => {
            board.resume_at(time_us.saturating_add(OFF_US));
            match found.passed_over {
                0 => CheckpointState::Restored,
                _ => CheckpointState::RestoredOlder,
            }
        }
        Err(why) => {
            // It may be half of one and half of the other.
            let _ = onboard.restart(); // the craft was accepted once
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
    use crate::flight::selected::EstimatorId;
    use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};
    use fsw_core::Prior;
    use fsw_core::checkpoint::ToWords;
    use fsw_core::{Estimator, Sample, Vec3};
    use std::boxed::Box;
    use std::vec;

    /// Words of a checkpoint.
    fn words(onboard: &mut SelectedEstimator) -> u32 {
        let mut words = vec![0; 2 * MOST_WORDS as usize];
        let mut noted = ToWords::new(&mut words);
        checkpoint::transfer(&mut Kept { time_us: 0, onboard }, &mut noted).unwrap();
        noted.written() as u32
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
    fn no_checkpoint_takes_more_than_there_is_made_room_for() {
        let prior = Prior::of_size(0.1);
        for id in EstimatorId::ALL {
            let mut onboard = Box::new(SelectedEstimator::new(CRAFT).unwrap());
            onboard.set_prior(prior).unwrap();
            onboard.select(id).unwrap();
            for (k, row) in (0..).zip(&ROWS) {
                onboard.step(&sample(k, row.rate_rad_s, row.wheel_speed_rad_s));
                assert!(words(&mut onboard) <= MOST_WORDS, "{id:?}, sample {k}");
            }
        }
        // Three quarters of the blocks that there is storage for: more make room.
        let (mut onboard, mut most) = (Box::new(SelectedEstimator::new(CRAFT).unwrap()), 0);
        for k in 0..5_000 {
            let noise = [(k % 7) as f32, (k % 5) as f32, (k % 3) as f32].map(|x| 1e-5 * x);
            onboard.step(&sample(k, noise, [0.0; 4]));
            if k % 10 == 0 {
                most = most.max(words(&mut onboard));
            }
        }
        assert!(most > 3_000 && most <= MOST_WORDS, "{most} of {MOST_WORDS} words");
    }
}
