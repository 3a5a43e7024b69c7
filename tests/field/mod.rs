//! Field campaigns: flights of ordinary logs, with faults, in both precisions, against limits.
//!
//! ```text
//!  campaigns::all ─► Campaign ─► flying: seeds in parallel ─► Run ─► Figures ─► table, limits
//!     scenarios ─► motion: truth, once per scenario ─┐
//!                  fault: damage to the samples ─────┴─► log ─► host_sim::estimation ─► Run
//!                  batch_fit: reference of a short record
//! ```
//!
//! A campaign is a row of [`campaigns::all`]. A flight is a simulated log, damaged by a [`fault`], and
//! passed through an estimator, which then completes its work. Its result is a [`run::Run`]; the
//! [`figures::Figures`] of all runs are compared with the [`campaign::Limits`].

pub mod batch_fit;
pub mod campaign;
pub mod campaigns;
pub mod fault;
pub mod figures;
pub mod flying;
pub mod judge;
pub mod motion;
pub mod run;
pub mod scenarios;
pub mod table;
pub mod tumble;
pub mod varying;
