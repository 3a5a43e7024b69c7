//! What becomes of a failure that the code did not foresee: a panic, a fault, an overflow of the
//! stack, an interrupt without a handler.
//!
//! Each is logged where it is caught, here, and given to the image, which says once how it ends:
//!
//! * `fsw_target::ends_by!(fsw_target::arch::exit::failed)`: with a status, for images that run under a
//!   debugger or in QEMU (`exit.rs`);
//! * `fsw_target::ends_by!(fsw_target::runtime::restart::failed)`: with a reset that is told of after the
//!   restart, for flight (`restart.rs`).

#[cfg(target_os = "none")]
mod handlers;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[repr(u32)]
pub enum Kind {
    /// A panic.
    Panic = 1,
    /// A fault of the core.
    HardFault = 2,
    /// The stack outgrew its memory.
    StackOverflow = 3,
    /// An interrupt that nobody serves.
    UnservedInterrupt = 4,
}

impl Kind {
    /// The kind of this number.
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

/// A failure, and where it happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct Failure {
    /// What happened.
    pub kind: Kind,
    /// Address of the instruction; a panic's line; an interrupt's number. 0 if it isn't known.
    pub at: u32,
    /// Where the function was called from; address of the name of a panic's file. 0 if it isn't
    /// known.
    pub from: u32,
}

/// What is kept over a restart, for the life after it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct LastLife {
    /// The failure that ended it, if one did.
    pub failure: Option<Failure>,
    /// Failures since power-on. Stops at its maximum.
    pub failures: u32,
}

/// [`LastLife`] as words: kind (0: none), at, from, failures, check.
pub type Words = [u32; 5];

/// Where the check starts: keeps RAM that is all zeros or all ones from passing.
const CHECK_START: u32 = 0x5afe_b007;

impl LastLife {
    /// As words.
    pub fn to_words(&self) -> Words {
        let (kind, at, from) = self
            .failure
            .map_or((0, 0, 0), |failure| (failure.kind as u32, failure.at, failure.from));
        let kept = [kind, at, from, self.failures];
        [kind, at, from, self.failures, check(kept)]
    }

    /// From words; `None` if they are not such, as after power-on.
    pub fn from_words([kind, at, from, failures, sum]: Words) -> Option<Self> {
        if check([kind, at, from, failures]) != sum {
            return None;
        }
        let failure = Kind::from_number(kind).map(|kind| Failure { kind, at, from });
        Some(Self { failure, failures })
    }

    /// The record of the life that ends with `failure`, after this one.
    pub fn followed_by(&self, failure: Failure) -> Self {
        Self { failure: Some(failure), failures: self.failures.saturating_add(1) }
    }
}

/// A sum that depends on every word and on their order.
fn check(words: [u32; 4]) -> u32 {
    words.into_iter().fold(CHECK_START, |sum, word| sum.rotate_left(5) ^ word)
}

/// Says how the image ends after a failure: by a `fn(Failure) -> !`.
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
    fn a_record_comes_back_as_it_was() {
        for failure in [None, Some(FAULT), Some(Failure { kind: Kind::Panic, at: 17, from: 0 })] {
            let life = LastLife { failure, failures: 3 };
            assert_eq!(LastLife::from_words(life.to_words()), Some(life));
        }
    }

    #[test]
    fn what_the_ram_holds_after_power_on_is_no_record() {
        assert_eq!(LastLife::from_words([0; 5]), None);
        assert_eq!(LastLife::from_words([u32::MAX; 5]), None);
    }

    #[test]
    fn a_record_with_any_bit_wrong_is_none() {
        let words = LastLife { failure: Some(FAULT), failures: 1 }.to_words();
        for (word, bit) in (0..words.len()).flat_map(|word| (0..32).map(move |bit| (word, bit))) {
            let mut broken = words;
            broken[word] ^= 1 << bit;
            assert_eq!(LastLife::from_words(broken), None, "word {word} bit {bit}");
        }
    }

    #[test]
    fn failures_are_counted_over_restarts() {
        let first = LastLife::default().followed_by(FAULT);
        let quiet = LastLife { failure: None, ..first };
        assert_eq!(quiet.followed_by(FAULT), LastLife { failure: Some(FAULT), failures: 2 });
    }
}
