//! Tables for the terminal.
//!
//! ```text
//! estimate  replay, run      campaign  mc      bound  crlb      target  pil
//! logs      replay of several logs
//! faults    faults         design    design
//! hardware  errors of gyro, wheels and torque in the tables of estimates
//! cells     heading lines and the format of a cell
//! ```

mod bound;
mod campaign;
mod cells;
mod design;
mod estimate;
mod explanation;
mod faults;
mod hardware;
mod logs;
mod target;

pub use bound::crlb;
pub use campaign::mc;
pub(super) use cells::{DIGITS, EMPTY, UNOBSERVED, decimals, element, or, short};
pub use design::{design, trade};
pub use estimate::{replay, run};
pub use explanation::diagnosis;
pub(super) use faults::fault_row;
pub use faults::faults;
pub(super) use hardware::in_words;
pub use logs::logs;
pub use target::pil;
