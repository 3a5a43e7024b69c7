//! Failures that the code does not handle: a panic, a fault of the core, an overflow of the stack, an
//! interrupt without a handler.
//!
//! Each is logged where it is caught (panics here, faults and interrupts in `arch`) and passed to the
//! image, which states once how it ends:
//!
//! * `fsw_target::ends_by!(fsw_target::arch::exit::end_after)`: with a status, for images that run under
//!   a debugger or in QEMU;
//! * `fsw_target::ends_by!(fsw_target::arch::exit::restart_after)`: with a reset, for flight. The failure
//!   is reported after the restart.

#[cfg(target_os = "none")]
mod panic;

#[cfg(target_os = "none")]
#[allow(unsafe_code, reason = "the image defines this function, by the macro `ends_by`")]
unsafe extern "Rust" {
    safe fn fsw_target_image_ends(failure: Failure) -> !;
}

/// Ends the image, as its `ends_by` states.
#[cfg(target_os = "none")]
pub(crate) fn end_image(failure: Failure) -> ! {
    fsw_target_image_ends(failure)
}

/// Kind of a failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u32)]
pub enum Kind {
    /// A panic.
    Panic = 1,
    /// A fault of the core.
    HardFault = 2,
    /// An overflow of the stack.
    StackOverflow = 3,
    /// An interrupt without a handler.
    UnservedInterrupt = 4,
    /// A reset by the watchdog.
    Watchdog = 5,
}

impl Kind {
    /// The kind of a number; `None` for a number without one.
    pub const fn from_number(number: u32) -> Option<Self> {
        match number {
            1 => Some(Self::Panic),
            2 => Some(Self::HardFault),
            3 => Some(Self::StackOverflow),
            4 => Some(Self::UnservedInterrupt),
            5 => Some(Self::Watchdog),
            _ => None,
        }
    }
}

/// A failure and its location.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Failure {
    /// Kind.
    pub kind: Kind,
    /// Address of the instruction; line of a panic; number of an interrupt. 0 if unknown.
    pub at: u32,
    /// Return address of the function; address of the file name of a panic. 0 if unknown.
    pub from: u32,
}

/// Restart record: end of the last run, and number of failures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct LastRun {
    /// The failure that ended the last run; `None` after a reset of another cause.
    pub failure: Option<Failure>,
    /// Failures since power-on; saturates.
    pub failures: u32,
    /// Runs in a row that a failure ended before they were long
    /// ([`LONG_LIFE_US`](crate::flight::computer::LONG_LIFE_US)); saturates.
    pub short_lives: u32,
}

/// Short lives in the record of a long run, whose failure begins a new row at 0.
const LONG: u32 = u32::MAX;

/// [`LastRun`] as words: kind (0: none), at, from, failures, short lives, check.
pub type Words = [u32; 6];

/// Start value of the check: RAM that is all zeros or all ones does not pass.
const CHECK_START: u32 = 0x5afe_b007;

impl LastRun {
    /// The record as words, with its check.
    pub fn to_words(&self) -> Words {
        let (kind, at, from) = self
            .failure
            .map_or((0, 0, 0), |failure| (failure.kind as u32, failure.at, failure.from));
        let fields = [kind, at, from, self.failures, self.short_lives];
        [kind, at, from, self.failures, self.short_lives, check(fields)]
    }

    /// The record of these words; `None` if their check is wrong, as after power-on.
    pub fn from_words([kind, at, from, failures, short_lives, sum]: Words) -> Option<Self> {
        if check([kind, at, from, failures, short_lives]) != sum {
            return None;
        }
        let failure = Kind::from_number(kind).map(|kind| Failure { kind, at, from });
        Some(Self { failure, failures, short_lives })
    }

    /// The record after a run that `failure` ended.
    pub fn followed_by(&self, failure: Failure) -> Self {
        let short_lives = match self.short_lives {
            LONG => 0,
            short_lives => short_lives.saturating_add(1),
        };
        Self { failure: Some(failure), failures: self.failures.saturating_add(1), short_lives }
    }

    /// The record at a start, by its reset. A reset by the watchdog is a failure, unless the code has
    /// recorded another one; a run without a failure ends a row of short lives.
    pub fn at_start(self, by_watchdog: bool) -> Self {
        match self.failure {
            None if by_watchdog => {
                self.followed_by(Failure { kind: Kind::Watchdog, at: 0, from: 0 })
            }
            None => Self { short_lives: 0, ..self },
            Some(_) => self,
        }
    }

    /// The record of a run that has become long.
    pub fn of_long_life(self) -> Self {
        Self { short_lives: LONG, ..self }
    }
}

/// Check word: depends on every bit and on the order of the words.
fn check(words: [u32; 5]) -> u32 {
    words.into_iter().fold(CHECK_START, |sum, word| sum.rotate_left(5) ^ word)
}

/// Defines how the image ends after a failure: by a `fn(Failure) -> !`.
#[macro_export]
macro_rules! ends_by {
    ($end:path) => {
        #[allow(unsafe_code, reason = "the library calls this function by its name")]
        // SAFETY: no other function of the image has this name, and this is its type.
        #[unsafe(no_mangle)]
        fn fsw_target_image_ends(failure: $crate::runtime::failure::Failure) -> ! {
            $end(failure)
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAULT: Failure = Failure { kind: Kind::HardFault, at: 0x0800_1234, from: 0x0800_5678 };

    #[test]
    fn a_record_is_restored_from_its_words() {
        for failure in [None, Some(FAULT), Some(Failure { kind: Kind::Panic, at: 17, from: 0 })] {
            let run = LastRun { failure, failures: 3, short_lives: 2 };
            assert_eq!(LastRun::from_words(run.to_words()), Some(run));
        }
    }

    #[test]
    fn constant_ram_is_no_record() {
        assert_eq!(LastRun::from_words([0; 6]), None);
        assert_eq!(LastRun::from_words([u32::MAX; 6]), None);
    }

    #[test]
    fn a_wrong_bit_invalidates_the_record() {
        let words = LastRun { failure: Some(FAULT), failures: 1, short_lives: 0 }.to_words();
        for (word, bit) in (0..words.len()).flat_map(|word| (0..32).map(move |bit| (word, bit))) {
            let mut broken = words;
            broken[word] ^= 1 << bit;
            assert_eq!(LastRun::from_words(broken), None, "word {word} bit {bit}");
        }
    }

    #[test]
    fn failures_accumulate_over_restarts() {
        let first = LastRun::default().followed_by(FAULT);
        let quiet = LastRun { failure: None, ..first };
        let second = LastRun { failure: Some(FAULT), failures: 2, short_lives: 2 };
        assert_eq!(quiet.followed_by(FAULT), second);
    }

    /// The record over a start and the run after it.
    fn next(record: LastRun, by_watchdog: bool, is_long: bool, end: Option<Failure>) -> LastRun {
        let run = record.at_start(by_watchdog);
        let run = LastRun { failure: None, ..run };
        let run = if is_long { run.of_long_life() } else { run };
        end.map_or(run, |failure| run.followed_by(failure))
    }

    #[test]
    fn short_lives_are_counted_until_a_long_one() {
        let mut record = LastRun::default();
        for lives in 1..=3 {
            record = next(record, false, false, Some(FAULT));
            assert_eq!(record.at_start(false).short_lives, lives);
        }
        record = next(record, false, true, Some(FAULT));
        assert_eq!(record.at_start(false).short_lives, 0, "a long life");
        record = next(record, false, false, Some(FAULT));
        assert_eq!(record.at_start(false).short_lives, 1);
        record = next(record, false, false, None);
        assert_eq!(record.at_start(false).short_lives, 0, "a reset by the pin");
    }

    #[test]
    fn reset_by_the_watchdog_is_a_failure() {
        let mut record = LastRun::default();
        for lives in 1..=3 {
            let start = record.at_start(true);
            assert_eq!(start.failure.map(|failure| failure.kind), Some(Kind::Watchdog));
            assert_eq!((start.failures, start.short_lives), (lives, lives));
            record = LastRun { failure: None, ..start };
        }
    }
}
