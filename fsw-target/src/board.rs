//! The board: the only place that names a chip, its pins and its peripherals.
//!
//! # Porting to another Cortex-M
//!
//! 1. `memory.x`: where the chip has flash and RAM. Keep the stack below the statics, and two
//!    erase units at the end of the flash for checkpoints.
//! 2. A folder beside `stm32f405` that offers what is in the table, re-exported here. The wiring
//!    table of that folder's page, its list of rules and its division into files are worth copying.
//! 3. A core other than the Cortex-M4F: the target in `.cargo/config.toml` and
//!    `target-tools/src/toolchain.rs`. A probe: the `--chip` of the runner in the former.
//! 4. Flash `bringup`, which says of each part whether it works; then `replay`, which must come to
//!    the bits that the host comes to; then `flight`.
//!
//! | part of `Board` | is | for |
//! |---|---|---|
//! | `link` | [`embedded_hal_nb::serial::Read`] and `Write` | telemetry and commands |
//! | `gyro_bus` | [`embedded_hal::spi::SpiDevice`], or an I²C bus with `bus::TwoWire` | the gyro's driver |
//! | `data_ready` | [`crate::sensors::DataReady`] | when each sample was taken |
//! | `captures` | [`crate::drivers::wheel_tach::CaptureTimer`], once started | wheel speeds |
//! | `flash` | [`embedded_storage::nor_flash::NorFlash`] | checkpoints |
//! | `watchdog` | takes a [`crate::supervisor::FeedPermit`] | a loop that hangs |
//! | `syst` | the core's timer | `bench` |
//! | `tunnel` | as `link` | the processor in the loop |
//!
//! Beside them `LogPort` sends the log of images that end by themselves, `Delay` waits and
//! `now_us` tells the time.

#[cfg(target_os = "none")]
pub mod stm32f405;
#[cfg(target_os = "none")]
pub use stm32f405::*;

/// Of the board's files, the one that the host can test.
#[cfg(all(test, not(target_os = "none")))]
#[path = "board/stm32f405/rates.rs"]
mod rates;
