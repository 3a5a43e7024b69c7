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
}

impl Kind {
    /// The kind of a number; `None` for a number without one.
    pub const fn from_number(number: u32) -> Option<Self> {
        match number {
            1 => Some(Self::Panic),
            2 => Some(Self::HardFault),
            3 => Some(Self::StackOverflow),
            4 => Some(Self::UnservedInterrupt),
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
}

/// [`LastRun`] as words: kind (0: none), at, from, failures, check.
pub type Words = [u32; 5];

/// Start value of the check: RAM that is all zeros or all ones does not pass.
const CHECK_START: u32 = 0x5afe_b007;

impl LastRun {
    /// The record as words, with its check.
    pub fn to_words(&self) -> Words {
        let (kind, at, from) = self
            .failure
            .map_or((0, 0, 0), |failure| (failure.kind as u32, failure.at, failure.from));
        let fields = [kind, at, from, self.failures];
        [kind, at, from, self.failures, check(fields)]
    }

    /// The record of these words; `None` if their check is wrong, as after power-on.
    pub fn from_words([kind, at, from, failures, sum]: Words) -> Option<Self> {
        if check([kind, at, from, failures]) != sum {
            return None;
        }
        let failure = Kind::from_number(kind).map(|kind| Failure { kind, at, from });
        Some(Self { failure, failures })
    }

    /// The record of the next run, ended by `failure`.
    pub fn followed_by(&self, failure: Failure) -> Self {
        Self { failure: Some(failure), failures: self.failures.saturating_add(1) }
    }
}

/// Check word: depends on every bit and on the order of the words.
fn check(words: [u32; 4]) -> u32 {
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
            let run = LastRun { failure, failures: 3 };
            assert_eq!(LastRun::from_words(run.to_words()), Some(run));
        }
    }

    #[test]
    fn constant_ram_is_no_record() {
        assert_eq!(LastRun::from_words([0; 5]), None);
        assert_eq!(LastRun::from_words([u32::MAX; 5]), None);
    }

    #[test]
    fn a_wrong_bit_invalidates_the_record() {
        let words = LastRun { failure: Some(FAULT), failures: 1 }.to_words();
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
        assert_eq!(quiet.followed_by(FAULT), LastRun { failure: Some(FAULT), failures: 2 });
    }
}
