//! Memory of the estimator in a slot, as bytes.

use fsw_roster::EstimatorSlot;

/// Bytes of the estimator in this slot, padding included.
pub fn bytes(slot: &EstimatorSlot) -> usize {
    slot.selected().map_or(0, |selected| size_of_val(selected))
}

/// Flips a bit of the estimator in this slot. A byte beyond it is left alone.
pub fn flip(slot: &mut EstimatorSlot, byte: usize, bit: u8) {
    let Some(selected) = slot.selected_mut() else { return };
    if byte >= size_of_val(selected) {
        return;
    }
    let first = std::ptr::from_mut(selected).cast::<u8>();
    #[allow(unsafe_code, reason = "an upset changes memory without regard to types")]
    // SAFETY: the byte belongs to the estimator, which is borrowed mutably. The value that it becomes part of may be
    // invalid for its type, which is the subject of the campaign: the process ends with the flight.
    unsafe {
        let byte = first.add(byte);
        byte.write_volatile(byte.read_volatile() ^ (1 << (bit & 7)));
    }
}
