//! Board support: chip, pins and peripherals. No other module depends on them.
//!
//! A cargo feature selects the board, exactly one: `stm32f405` by default. The host has none.
//!
//! | feature | board | core | images |
//! |---|---|---|---|
//! | `stm32f405` | STM32F405RG, gyro on SPI, four wheels | Cortex-M4F | all |
//! | `mps2-an500` | Arm MPS2, FPGA image AN500 | Cortex-M7 | `replay`, `pil` |
//! | `mps2-an505` | Arm MPS2, FPGA image AN505 | Cortex-M33, secure state | `replay`, `pil`, `failures` |
//!
//! The two MPS2 boards have run in QEMU alone. `docs/porting.md` follows them from file to file.
//!
//! # Porting to another Cortex-M
//!
//! 1. A folder beside `stm32f405` that offers the items of the table below, and its `mod` and `use` at the end of
//!    `board/mod.rs`. Models: `mps2` for the images in its rows, `stm32f405` for all. In it `memory.x`: flash and RAM of the
//!    chip. The stack lies below the statics; the end of the flash is for checkpoints, in two halves of whole pages, of at
//!    least 20 KiB each, with words of at most 32 bytes ([`crate::store`]).
//! 2. Its feature in `fsw-target/Cargo.toml`, which enables the register crate of the chip, the feature of its core
//!    (`v7m`: Cortex-M3, M4, M7; `v8m`: Cortex-M33) and, with all parts of the table, `flight-parts`. Another core is a
//!    folder beside `arch/v7m`.
//! 3. Its row in `fsw-target/build/board.rs`: target of the compiler, folder. The build stops at none or several boards and
//!    at the target of another core.
//! 4. A board that QEMU has: its row in `fsw-target/tools/src/board.rs`. A board with a debug probe: the name of the chip in
//!    `fsw-target/tools/src/bin/board.rs` and in the runner of `.cargo/config.toml`. Another target: its `target-cpu` in
//!    `.cargo/config.toml`.
//! 5. Flash `bringup`, which tests each part of the board; then `replay`, whose bits must be those of the host; then
//!    `flight`.
//!
//! Images `replay` and `pil` need the fields `link`, `tunnel` and `syst` alone.
//!
//! | field of `Board` | type | used by |
//! |---|---|---|
//! | `link` | [`embedded_hal_nb::serial::Read`] and `Write` | telemetry and telecommands |
//! | `gyro_bus` | [`embedded_hal::spi::SpiDevice`], or an I²C bus with `bus::TwoWire` | gyro driver |
//! | `data_ready` | [`crate::flight::sensors::DataReady`] | time stamps of samples |
//! | `captures` | [`crate::drivers::wheel_tach::CaptureTimer`], after its start | wheel speeds |
//! | `flash` | [`embedded_storage::nor_flash::NorFlash`] | checkpoints |
//! | `counter_flash` | [`embedded_storage::nor_flash::NorFlash`], two halves | counters of telecommands |
//! | `watchdog` | takes a [`crate::flight::supervisor::FeedPermit`] | supervision |
//! | `syst` | timer of the core | `bench`, sleep of the loop |
//! | `tunnel` | [`crate::stand_in::tunnel::Port`] | processor in the loop |
//!
//! `Board::take` starts all parts once, `Board::report` returns the result. Beside the parts:
//!
//! * `Services` is the [`crate::flight::computer::Housekeeping`] of the computer: a clock of at least 32 bits
//!   of microseconds, a delay, and the watchdog, whose period exceeds the longest erasure of the flash.
//! * `Link::into_log_output` makes the link the output of the log, for images without telemetry.
//! * `Delay` is a delay, `now_us` the on-board time.
//!
//! The restart record lies in RAM that a reset leaves unchanged (section `.uninit`).

#[cfg(all(target_os = "none", feature = "mps2"))]
pub mod mps2;
#[cfg(all(target_os = "none", feature = "mps2"))]
pub use mps2::*;
#[cfg(all(target_os = "none", feature = "stm32f405"))]
pub mod stm32f405;
#[cfg(all(target_os = "none", feature = "stm32f405"))]
pub use stm32f405::*;

/// The parts of the board that are pure arithmetic, for their tests on the host.
#[cfg(all(test, not(target_os = "none")))]
#[path = "stm32f405/option_bytes.rs"]
mod option_bytes;
#[cfg(all(test, not(target_os = "none")))]
#[path = "stm32f405/rates.rs"]
mod rates;
