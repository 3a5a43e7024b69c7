//! Registers of the gyro in a BMI088, as the data sheet BST-BMI088-DS001 names and numbers them.

/// Address on I²C, pin SDO2 at ground.
pub const I2C_ADDRESS: u8 = 0x68;
/// Address on I²C, pin SDO2 at the supply.
pub const I2C_ADDRESS_SDO2_HIGH: u8 = 0x69;

/// Value of GYRO_CHIP_ID.
pub const CHIP_ID: u8 = 0x0F;

/// Register numbers (section 5.4).
pub mod register {
    #![allow(missing_docs, reason = "the names are the data sheet's")]
    pub const CHIP_ID: u8 = 0x00;
    pub const RATE_X_LSB: u8 = 0x02;
    pub const INT_STAT_1: u8 = 0x0A;
    pub const RANGE: u8 = 0x0F;
    pub const BANDWIDTH: u8 = 0x10;
    pub const LPM1: u8 = 0x11;
    pub const SOFTRESET: u8 = 0x14;
    pub const INT_CTRL: u8 = 0x15;
    pub const INT3_INT4_IO_CONF: u8 = 0x16;
    pub const INT3_INT4_IO_MAP: u8 = 0x18;
    pub const SELF_TEST: u8 = 0x3C;
}

/// Command in GYRO_SOFTRESET: return to the state after power-up.
pub const SOFT_RESET: u8 = 0xB6;
/// Bit of GYRO_INT_STAT_1: new sample.
pub const DATA_READY: u8 = 0x80;
/// Bit of GYRO_INT_CTRL: interrupt on a new sample.
pub const DATA_READY_ON: u8 = 0x80;
/// Bit of GYRO_SELF_TEST: start of the built-in self-test.
pub const SELF_TEST_START: u8 = 0x01;
/// Bit of GYRO_SELF_TEST: end of the built-in self-test.
pub const SELF_TEST_DONE: u8 = 0x02;
/// Bit of GYRO_SELF_TEST: failure of the built-in self-test.
pub const SELF_TEST_FAILED: u8 = 0x04;
/// Bit of GYRO_SELF_TEST: no fault in the continuous background check.
pub const SELF_TEST_RATE_OK: u8 = 0x10;

/// Start-up time after power-up and after a soft reset, ms.
pub(super) const RESET_MS: u32 = 30;
/// Idle time of the interface after a write, µs (t_IDLE_wacc_nm, normal mode).
pub(super) const WRITE_US: u32 = 2;
/// Time between two polls of the self-test, ms. The data sheet gives no duration of the test; this
/// driver waits 0.1 s.
pub(super) const SELF_TEST_POLL_MS: u32 = 5;
/// Polls before the self-test counts as hung.
pub(super) const SELF_TEST_POLLS: u32 = 20;

/// Largest count. A reading of either sign at this count is a lower bound of the rate.
pub const FULL_SCALE: i16 = 32_767;
