//! State that an interrupt handler and the loop share, accessed with interrupts masked.

use core::cell::RefCell;
use critical_section::Mutex;

/// Shared state; empty until [`put`](Self::put).
pub struct Shared<T>(Mutex<RefCell<Option<T>>>);

impl<T: Send> Shared<T> {
    /// Empty.
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// Sets the state.
    pub fn put(&self, state: T) {
        self.borrow(|place| *place = Some(state));
    }

    /// Runs `work` on the state with interrupts masked, for short work only. `None` if empty.
    pub fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> Option<R> {
        self.borrow(|place| place.as_mut().map(work)).flatten()
    }

    /// Borrows the state, which is free whenever interrupts are masked. A nested borrow would do nothing,
    /// rather than panic.
    fn borrow<R>(&self, work: impl FnOnce(&mut Option<T>) -> R) -> Option<R> {
        critical_section::with(|section| {
            self.0.borrow(section).try_borrow_mut().ok().map(|mut place| work(&mut place))
        })
    }
}
