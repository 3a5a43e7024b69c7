//! The flight loop of the inertia estimator, and its firmware for a Cortex-M4F.
//!
//! # The way of a gyro sample
//!
//! ```text
//!  data ready        gyro, wheel tachometers,          fsw_core::Estimator
//!  (time stamp)  ->  torque command               ->   step(sample)          ->  Tick, log
//!  sensors::DataReady   sensors::{Gyro, ...}            app::FlightLoop::tick
//! ```
//!
//! 1. [`sensors`]: what the loop needs of the hardware, as four small traits in SI units. A driver
//!    implements one of them and is the only place that knows its part: those that exist are in
//!    [`drivers`].
//! 2. [`app`]: the flight loop. One [`app::FlightLoop::tick`] per gyro sample reads the sensors,
//!    composes an [`fsw_core::Sample`], steps the estimator and says what happened. A sensor that
//!    fails is counted and its sample skipped; nothing here panics.
//! 3. [`recording`]: a recorded flight that plays the part of every sensor, so that the loop is
//!    the same in a test, in QEMU and on the board.
//! 4. [`replay`]: the committed flight with its estimator, ready to fly. The image `bin/replay`
//!    and the test that compares host and target bit for bit both call it.
//! 5. [`link`]: what goes to the ground and what comes from there, as packets over a serial line.
//! 6. [`store`]: checkpoints in flash, from which the estimator goes on after a reset, bit for bit.
//! 7. [`tunnel`]: all of a board at the other end of a serial line, for the processor in the loop.
//!
//! Below that are the parts that only the chip has (`target_os = "none"`): `board`, the bring-up
//! of the one board that exists, `log`, where a defmt frame goes, `exit`, how an image ends, and
//! `instructions`, which counts what code costs (in QEMU).
//!
//! The loop flies in single precision: `f32` is chosen here, once.

#![no_std]

pub mod docs;

pub mod drivers;
pub mod flight;
pub mod link;
pub mod store;

#[cfg(target_os = "none")]
pub mod arch;
pub mod board;
pub mod runtime;

pub mod stand_in;
