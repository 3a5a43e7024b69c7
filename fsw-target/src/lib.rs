//! Flight software of the inertia estimator: flight loop, drivers, link and storage, and the firmware
//! images for a Cortex-M board. Single precision throughout.
//!
//! # The path of a gyro sample
//!
//! ```text
//!                    drivers::wheel_tach ── wheel speeds ──┐        telecommands
//!                                                          ▼              │
//!  board ── data ready ──► drivers::gyro ── rate ──► flight::flight_loop  │
//!           (time stamp)                                   │              │
//!                                                       Sample            ▼
//!                                                          ▼        link::uplink
//!                      store ◄── checkpoint ── flight::selected ◄── link::command
//!                     (flash) ── at start ───►  (fsw_roster)
//!                                                          │
//!                                                 estimate, outcome
//!                                                          ▼
//!                                  link::telemetry ──► link::downlink ──► serial port
//! ```
//!
//! 1. The data-ready interrupt of the [`board`] stamps the sample ([`runtime::stamps`]).
//! 2. [`flight::flight_loop`] takes the stamp, reads the gyro and the wheel tachometers by their
//!    [`drivers`], adds the known external torque, and steps the estimator with the
//!    [`fsw_core::Sample`].
//! 3. [`flight::selected`] is the estimator: one of the roster of [`fsw_roster`]. Its step is in [`fsw_steps`], compiled for speed.
//! 4. [`flight::computer`] strings these together with the [`link`] to the ground and the [`store`] of
//!    checkpoints: its `poll` is the loop of the image. [`flight::supervisor`] permits the watchdog to be
//!    fed after each complete round.
//!
//! # Modules
//!
//! | module | contents | uses |
//! |---|---|---|
//! | [`runtime`] | failures, log, restart record, stack measurement, time stamps | – |
//! | [`link`] | telemetry and telecommands as packets on a serial line | `runtime` |
//! | [`store`] | checkpoints in flash | – |
//! | [`flight`] | sensor interface, flight loop, selected estimator, computer | `link`, `store`, `runtime` |
//! | [`drivers`] | gyro and wheel tachometers | `flight::sensors` |
//! | [`stand_in`] | sensors of a recording, or of a simulator on a serial line | `flight`, `drivers`, `link`, `runtime` |
//! | `arch` | what the Cortex-M core decides: faults, stack guard, reset | `runtime` |
//! | [`board`] | what the board decides: chip, pins, peripherals | all above |
//! | `bin/` | one image per purpose | all |
//!
//! A module depends only on modules above it in this table. All but `arch` and the inside of
//! `board` compile for the host, where tests and the simulator run the same flight software.
//!
//! # Features
//!
//! * `stm32f405` (default): the board. It has no effect on the host.
//! * `window`, `joint-ekf`, `ekf-sgf-rls` (default: all three): the estimators that are built in.

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
