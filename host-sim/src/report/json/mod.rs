//! JSON documents. Names and shapes are stable; fields may only be added.
//!
//! ```text
//! estimate  replay, run      campaign  mc      bound  crlb      target  pil
//! faults    faults         design    design
//! hardware  one parameter of the hardware             tensor    six elements as a matrix
//! ```

mod bound;
mod campaign;
mod design;
mod estimate;
#[cfg(test)]
pub(super) mod examples;
mod explanation;
mod faults;
mod hardware;
mod log;
mod target;
mod tensor;

pub use bound::{CrlbReport, EffectRow};
pub use campaign::McReport;
pub use design::{DesignReport, FixedRow, LimitRow, TradeReport};
pub use estimate::{HealthChange, ReplayReport, RunReport, Spikes, Status};
pub use explanation::{DiagnosisReport, ExplanationReport};
pub use faults::{FaultCell, FaultsReport};
pub use hardware::HardwareResult;
pub use log::LogReport;
pub use target::{PilReport, TargetReport};
pub use tensor::{elements, matrix};

#[cfg(test)]
mod tests;
