//! Who may feed the watchdog: a loop all of whose tasks have done their work.
//!
//! Input: each task's report. Output: a [`FeedPermit`], the only thing that a board's watchdog
//! takes, and no more than one for each round of reports. A loop that spins without doing its
//! work, or a task that is never reached, earns none, and the watchdog ends it.
//!
//! A task reports that it came to its end, not that its part is healthy: a gyro that doesn't
//! answer is a task done, with an error that telemetry tells. A reset would not mend it.

/// The work that the flight computer's loop has to do again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u8)]
pub enum Task {
    /// Took the sample that was ready, if any, and stepped the estimator.
    Sampling = 0,
    /// Emptied the queue of received bytes.
    Commanding = 1,
    /// Filled the transmitter, if there was anything to send.
    Reporting = 2,
}

impl Task {
    /// All of them.
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

/// Proof that every task has reported since the last one. Only a [`Supervisor`] makes them.
#[derive(Debug, PartialEq, Eq)]
#[must_use]
pub struct FeedPermit(());

/// Listens to the tasks.
#[derive(Debug, Clone, Copy, Default)]
pub struct Supervisor {
    reported: u32,
}

impl Supervisor {
    /// One that has heard nobody yet.
    pub const fn new() -> Self {
        Self { reported: 0 }
    }

    /// `task` has done its work.
    pub fn report(&mut self, task: Task) {
        self.reported |= task.bit();
    }

    /// Leave to feed the watchdog, if all tasks have reported since the last leave.
    pub fn permit(&mut self) -> Option<FeedPermit> {
        if self.reported != ALL_BITS {
            return None;
        }
        self.reported = 0;
        Some(FeedPermit(()))
    }

    /// Whether `task` has yet to report before there is another leave.
    pub fn awaits(&self, task: Task) -> bool {
        self.reported & task.bit() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permit_takes_a_report_of_every_task() {
        for missing in Task::ALL {
            let mut supervisor = Supervisor::new();
            for task in Task::ALL.into_iter().filter(|&task| task != missing) {
                supervisor.report(task);
                supervisor.report(task); // twice is no more than once
            }
            assert_eq!(supervisor.permit(), None, "without {missing:?}");
            assert!(supervisor.awaits(missing));

            supervisor.report(missing);
            assert!(!supervisor.awaits(missing));
            assert!(supervisor.permit().is_some());
        }
    }

    #[test]
    fn a_round_of_reports_is_good_for_one_permit() {
        let mut supervisor = Supervisor::new();
        Task::ALL.into_iter().for_each(|task| supervisor.report(task));
        assert!(supervisor.permit().is_some());
        assert_eq!(supervisor.permit(), None);
        assert!(Task::ALL.into_iter().all(|task| supervisor.awaits(task)));
    }

    #[test]
    fn every_task_has_a_bit_of_its_own() {
        assert_eq!(ALL_BITS.count_ones() as usize, Task::ALL.len());
    }
}
