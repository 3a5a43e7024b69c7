//! What an interrupt and the loop share: a part that only one of them can hold at a time.

use core::cell::RefCell;
use critical_section::Mutex;

/// A place for a part, empty until the part has been brought up.
pub struct Shared<T>(Mutex<RefCell<Option<T>>>);

impl<T: Send> Shared<T> {
    /// An empty place.
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// Puts the part in.
    pub fn put(&self, part: T) {
        self.hold(|place| *place = Some(part));
    }

    /// Does `work` on the part with interrupts masked: keep it short. `None` if the place is empty.
    pub fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Option<R> {
        self.hold(|place| place.as_mut().map(work)).flatten()
    }

    /// The place is free whenever interrupts are masked; should it not be, nothing is done, which
    /// is better than a panic.
    fn hold<R>(&self, work: impl FnOnce(&mut Option<T>) -> R) -> Option<R> {
        critical_section::with(|section| {
            self.0.borrow(section).try_borrow_mut().ok().map(|mut place| work(&mut place))
        })
    }
}
