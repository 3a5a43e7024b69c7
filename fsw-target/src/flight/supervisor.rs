//! Supervision of the loop: the watchdog is fed only after every task has completed.
//!
//! Input: one report per completed task. Output: one [`FeedPermit`] per round of reports, which the
//! watchdog of a board requires. A loop that skips a task, or a task that does not complete, gets no
//! permit, and the watchdog resets the chip.
//!
//! A report means that the task has completed, not that its hardware works. A gyro that does not answer
//! is a completed task with an error in telemetry: a reset would not repair it.

/// Task of one round of the flight computer's loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u8)]
pub enum Task {
    /// Read the pending sample, if any, and stepped the estimator.
    Sampling = 0,
    /// Processed the received bytes.
    Commanding = 1,
    /// Passed pending telemetry to the transmitter.
    Reporting = 2,
}

impl Task {
    /// All tasks.
    pub const ALL: [Self; 3] = [Self::Sampling, Self::Commanding, Self::Reporting];

    const fn bit(self) -> u32 {
        1 << self as u8
    }
}

/// All tasks, as bits.
const ALL_BITS: u32 = {
    let mut bits = 0;
    let mut index = 0;
    while index < Task::ALL.len() {
        bits |= Task::ALL[index].bit();
        index += 1;
    }
    bits
};

/// Stage of the start of the flight computer, in order. Each may take as long as the watchdog's period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// Checkpoints read, and the newest one restored or passed over.
    Restored = 1,
    /// Counters of telecommands read.
    CountersRead = 2,
    /// Space for the next checkpoint erased.
    CheckpointErased = 3,
    /// Space for the next counters erased.
    CountersErased = 4,
    /// Gyro started and tested.
    GyroStarted = 5,
}

/// Proof that every task has reported since the last permit, or that a stage of the start has completed.
/// Issued only by a [`Supervisor`].
#[derive(Debug, PartialEq, Eq)]
#[must_use]
pub struct FeedPermit(());

/// Reports of the current round.
#[derive(Debug, Clone, Copy, Default)]
pub struct Supervisor {
    reported: u32,
    /// Last completed stage of the start; 0 before the first.
    stage: u8,
}

impl Supervisor {
    /// A round without reports.
    pub const fn new() -> Self {
        Self { reported: 0, stage: 0 }
    }

    /// Permit after a stage of the start. Each stage has one, in order: a start that repeats a stage is not
    /// permitted to feed the watchdog.
    pub fn stage_permit(&mut self, stage: Stage) -> Option<FeedPermit> {
        let is_next = stage as u8 == self.stage.saturating_add(1);
        is_next.then(|| {
            self.stage = stage as u8;
            FeedPermit(())
        })
    }

    /// Records that `task` has completed.
    pub fn report(&mut self, task: Task) {
        self.reported |= task.bit();
    }

    /// The permit of this round, once all tasks have reported; begins the next round.
    pub fn permit(&mut self) -> Option<FeedPermit> {
        if self.reported != ALL_BITS {
            return None;
        }
        self.reported = 0;
        Some(FeedPermit(()))
    }

    /// True while the report of `task` is missing in this round.
    pub fn awaits(&self, task: Task) -> bool {
        self.reported & task.bit() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permit_requires_a_report_of_every_task() {
        for missing in Task::ALL {
            let mut supervisor = Supervisor::new();
            for task in Task::ALL.into_iter().filter(|&task| task != missing) {
                supervisor.report(task);
                supervisor.report(task); // a second report has no effect
            }
            assert_eq!(supervisor.permit(), None, "without {missing:?}");
            assert!(supervisor.awaits(missing));

            supervisor.report(missing);
            assert!(!supervisor.awaits(missing));
            assert!(supervisor.permit().is_some());
        }
    }

    #[test]
    fn a_round_of_reports_gives_one_permit() {
        let mut supervisor = Supervisor::new();
        Task::ALL.into_iter().for_each(|task| supervisor.report(task));
        assert!(supervisor.permit().is_some());
        assert_eq!(supervisor.permit(), None);
        assert!(Task::ALL.into_iter().all(|task| supervisor.awaits(task)));
    }

    #[test]
    fn each_stage_of_the_start_has_one_permit_in_order() {
        let mut supervisor = Supervisor::new();
        assert_eq!(supervisor.stage_permit(Stage::CountersRead), None, "too early");
        assert!(supervisor.stage_permit(Stage::Restored).is_some());
        assert_eq!(supervisor.stage_permit(Stage::Restored), None, "repeated");
        assert!(supervisor.stage_permit(Stage::CountersRead).is_some());
        assert_eq!(supervisor.stage_permit(Stage::GyroStarted), None, "stages left out");
    }

    #[test]
    fn every_task_has_its_own_bit() {
        assert_eq!(ALL_BITS.count_ones() as usize, Task::ALL.len());
    }
}
