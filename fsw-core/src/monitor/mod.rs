//! 4. Monitor: consistency and observability of an estimate, whichever estimator it comes from.
//!
//! | module | input | output |
//! |---|---|---|
//! | [`innovation`] | innovations and their variances | consistent or not; residual RMS |
//! | [`spikes`] | innovations in a row | spike, lock-out |
//! | [`observability`] | covariance, range before the data | observed directions, 0 to 6 |
//! | [`nearest_physical`] | tensor, covariance | nearest tensor that a body can have |

pub mod innovation;
pub mod nearest_physical;
pub mod observability;
pub mod spikes;
