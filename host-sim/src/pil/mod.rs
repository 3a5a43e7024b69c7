//! Processor in the loop: the flight computer on its processor, in QEMU, with sensors simulated at
//! register level, compared bit by bit with the same software on the host.
//!
//! ```text
//!  scenario ─► truth ─► Hardware: chip, encoders, flash ◄─ requests ─ bin/pil in QEMU ─► telemetry ─┐
//!                  └──► Hardware, another copy ◄───────── Software: the same code ─────► telemetry ─┤
//!                                                                      after each sample: compare
//! ```
//!
//! 1. [`mission`]: input of a flight.
//! 2. [`setup`]: craft data of the flight computer.
//! 3. [`hardware`], [`flash`]: the hardware, from sample to sample; [`answering`]: wheels that the flight computer
//!    commands.
//! 4. [`software`]: the flight computer on the host, connected to the chip's bus directly.
//! 5. [`firmware`]: the image in QEMU, its requests and its telemetry.
//! 6. [`compare`]: the first difference, by name.
//! 7. [`lockstep`]: both computers, sample by sample.
//! 8. [`manoeuvre`]: manoeuvres of tests, and what a flight with one reached.
//! 9. `result`: the flight, or the error that ended it.
//!
//! The flight computer on the host does not use the tunnel through which the firmware reads its
//! sensors. A tunnel that alters data is therefore detected. At the end of a flight both computers
//! save a checkpoint, which holds the whole state of the estimator, and the two flash memories are
//! compared.

pub mod answering;
pub mod compare;
pub mod firmware;
pub mod flash;
pub mod hardware;
pub mod lockstep;
pub mod manoeuvre;
pub mod mission;
mod result;
pub mod setup;
pub mod software;

pub use answering::Answering;
pub use lockstep::fly;
pub use mission::{BrokenBit, Mission};
pub use result::{PilFailed, PilFlight, Progress};

#[cfg(test)]
mod tests;
