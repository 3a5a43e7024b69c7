//! Option bytes of the chip: those of a flight board, and their check at the start.
//!
//! | option | value | reason |
//! |---|---|---|
//! | BOR_LEV | level 3, reset below 2.7 V | 168 MHz with five wait states and 32-bit programming of the flash hold at 2.7 to 3.6 V only; delivered: off |
//! | WDG_SW | hardware watchdog | a start that stops before it reaches the watchdog is reset |
//! | nWRP0 to nWRP5 | write protection | the image; sectors 8 to 11 stay writable for counters and checkpoints |
//! | RDP | level 1 or 2 | the debug port cannot read the master key |
//!
//! The firmware reads and reports them, and never writes them: a power failure during that write could leave
//! a chip that does not start. How to set them: `docs/board.md`.
//!
//! Registers: RM0090, section 3.9.10 (FLASH_OPTCR). QEMU reads 0.

use crate::link::telemetry::BrownOutLevel;

/// BOR_LEV, two bits: 3 is off.
const BOR_LEV_SHIFT: u32 = 2;
/// WDG_SW: 0 is the hardware watchdog.
const WDG_SW: u32 = 1 << 5;
/// RDP, eight bits.
const RDP_SHIFT: u32 = 8;
/// RDP without protection.
const RDP_LEVEL_0: u32 = 0xaa;
/// nWRP of sector 0: 0 is protected.
const NWRP_SHIFT: u32 = 16;
/// Sectors of the image: 256 KiB.
const IMAGE_SECTORS: u32 = 0b11_1111;
/// Sectors that the image writes.
const DATA_SECTORS: u32 = 0b1111_0000_0000;
/// OPTLOCK, always 1 before an unlock sequence: 0 means that the register is not there.
const OPTLOCK: u32 = 1;

/// Option bytes in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct OptionBytes {
    register: u32,
}

impl OptionBytes {
    /// From the value of FLASH_OPTCR.
    pub const fn new(register: u32) -> Self {
        Self { register }
    }

    fn is_readable(self) -> bool {
        self.register & OPTLOCK != 0
    }

    /// Brown-out level.
    pub fn brown_out(self) -> BrownOutLevel {
        match self.register >> BOR_LEV_SHIFT & 3 {
            _ if !self.is_readable() => BrownOutLevel::Unknown,
            0 => BrownOutLevel::Level3,
            1 => BrownOutLevel::Level2,
            2 => BrownOutLevel::Level1,
            _ => BrownOutLevel::Off,
        }
    }

    /// True if the watchdog runs from reset on.
    pub fn has_hardware_watchdog(self) -> bool {
        self.is_readable() && self.register & WDG_SW == 0
    }

    /// True if all are those of a flight board.
    pub fn are_as_set(self) -> bool {
        let unprotected = self.register >> NWRP_SHIFT;
        self.brown_out() == BrownOutLevel::Level3
            && self.has_hardware_watchdog()
            && unprotected & IMAGE_SECTORS == 0
            && unprotected & DATA_SECTORS == DATA_SECTORS
            && self.register >> RDP_SHIFT & 0xff != RDP_LEVEL_0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reset value of FLASH_OPTCR (RM0090, section 3.9.10).
    const DELIVERED: u32 = 0x0fff_aaed;
    /// As in the table above: level 1 of RDP, sectors 0 to 5 protected.
    const FLIGHT: u32 = 0x0fc0_55c1;

    #[test]
    fn chip_as_delivered_is_reported() {
        let delivered = OptionBytes::new(DELIVERED);
        assert_eq!(delivered.brown_out(), BrownOutLevel::Off);
        assert!(!delivered.has_hardware_watchdog() && !delivered.are_as_set());
    }

    #[test]
    fn each_option_of_a_flight_board_is_required() {
        assert!(OptionBytes::new(FLIGHT).are_as_set());
        for (option, register) in [
            ("level 2", FLIGHT | 1 << BOR_LEV_SHIFT),
            ("off", FLIGHT | 3 << BOR_LEV_SHIFT),
            ("software watchdog", FLIGHT | WDG_SW),
            ("sector 0 unprotected", FLIGHT | 1 << NWRP_SHIFT),
            ("sector 5 unprotected", FLIGHT | 1 << (NWRP_SHIFT + 5)),
            ("sector 8 protected", FLIGHT & !(1 << (NWRP_SHIFT + 8))),
            ("sector 11 protected", FLIGHT & !(1 << (NWRP_SHIFT + 11))),
            ("no read-out protection", FLIGHT & !0xff00 | RDP_LEVEL_0 << RDP_SHIFT),
            ("no register, as in QEMU", 0),
        ] {
            assert!(!OptionBytes::new(register).are_as_set(), "{option}");
        }
        assert_eq!(OptionBytes::new(0).brown_out(), BrownOutLevel::Unknown);
    }

    #[test]
    fn levels_are_those_of_the_manual() {
        use BrownOutLevel::{Level1, Level2, Level3, Off};
        let level = |bits: u32| OptionBytes::new(OPTLOCK | bits << BOR_LEV_SHIFT).brown_out();
        assert_eq!([0, 1, 2, 3].map(level), [Level3, Level2, Level1, Off]);
    }
}
