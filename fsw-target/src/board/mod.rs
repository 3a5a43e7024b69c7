//! The board: the only place that names a chip, its pins and its peripherals.
//!
//! # Porting to another Cortex-M
//!
//! 1. `memory.x`: where the chip has flash and RAM. Keep the stack below the statics, and the end of the
//!    flash for checkpoints: two halves of whole pages, of at least 20 KiB each, and of words of at most
//!    32 bytes ([`crate::store`]).
//! 2. A folder beside `stm32f405` that offers what is in the table, re-exported here. The wiring
//!    table of that folder's page, its list of rules and its division into files are worth copying.
//! 3. A chip other than this: its name in `fsw-target/tools/src/bin/board.rs` and in the runner of
//!    `.cargo/config.toml`, its registers in `fsw-target/Cargo.toml`. A core other than the Cortex-M4F:
//!    `target-cpu` in `.cargo/config.toml`; and if that needs another target, there and in
//!    `fsw-target/tools/src/toolchain.rs` and `tests/check.sh`.
//! 4. Flash `bringup`, which says of each part whether it works; then `replay`, which must come to
//!    the bits that the host comes to; then `flight`.
//!
//! | part of `Board` | is | for |
//! |---|---|---|
//! | `link` | [`embedded_hal_nb::serial::Read`] and `Write` | telemetry and commands |
//! | `gyro_bus` | [`embedded_hal::spi::SpiDevice`], or an I²C bus with `bus::TwoWire` | the gyro's driver |
//! | `data_ready` | [`crate::flight::sensors::DataReady`] | when each sample was taken |
//! | `captures` | [`crate::drivers::wheel_tach::CaptureTimer`], once started | wheel speeds |
//! | `flash` | [`embedded_storage::nor_flash::NorFlash`] | checkpoints |
//! | `watchdog` | takes a [`crate::flight::supervisor::FeedPermit`] | a loop that hangs |
//! | `syst` | the core's timer | `bench` |
//! | `tunnel` | [`crate::stand_in::tunnel::Port`] | the processor in the loop |
//!
//! `Board::take` brings it all up once, and `Board::report` says what came of it. Beside the parts `Services` is
//! the computer's [`crate::flight::computer::Housekeeping`]: a clock of 32 bits of microseconds or more, a delay, the
//! watchdog, whose period is longer than the longest erasure. `LogPort` sends the log of images that end by
//! themselves, `Delay` waits and `now_us` tells the time. What restarts tell each other is in RAM that a reset
//! leaves alone (`.uninit`).

#[cfg(all(target_os = "none", feature = "stm32f405"))]
pub mod stm32f405;
#[cfg(all(target_os = "none", feature = "stm32f405"))]
pub use stm32f405::*;

#[cfg(all(target_os = "none", not(any(feature = "stm32f405"))))]
compile_error!("no board is selected: enable the cargo feature of one, for example `stm32f405`");

/// The part of the board that is pure arithmetic, for its tests on the host.
#[cfg(all(test, not(target_os = "none")))]
#[path = "stm32f405/rates.rs"]
mod rates;
