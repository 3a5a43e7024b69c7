//! Memory of the estimator in a slot, as bytes.

use fsw_roster::EstimatorSlot;

/// Bytes of the estimator in this slot, padding included.
pub fn bytes(slot: &EstimatorSlot) -> usize {
    slot.selected().map_or(0, size_of_val)
}

/// A byte of the estimator in a slot, by its address.
#[derive(Clone, Copy)]
pub struct Byte(*mut u8);

/// A byte of the estimator in this slot; none beyond it.
pub fn byte(slot: &mut EstimatorSlot, index: usize) -> Option<Byte> {
    let selected = slot.selected_mut()?;
    let first = std::ptr::from_mut(selected).cast::<u8>();
    (index < size_of_val(selected)).then(|| Byte(first.wrapping_add(index)))
}

impl Byte {
    /// Flips a bit of the byte, whatever has been borrowed since: as an upset does.
    pub fn flip(self, bit: u8) {
        #[allow(unsafe_code, reason = "an upset changes memory without regard to types")]
        // SAFETY: the byte belongs to an estimator that the flight keeps in its place. Its value may be invalid for
        // its type afterwards, which is the subject of the campaign: the process ends with the flights.
        unsafe {
            self.0.write_volatile(self.0.read_volatile() ^ (1 << (bit & 7)));
        }
    }
}
