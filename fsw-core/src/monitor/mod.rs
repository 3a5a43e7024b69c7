//! 4. Monitor: consistency and observability of an estimate, whichever estimator it comes from.
//!
//! | module | input | output |
//! |---|---|---|
//! | [`outliers`] | raw gyro samples | accepted, or refused and bridged; gyro noise |
//! | [`innovation`] | innovations and their variances | consistent or not; residual RMS |
//! | [`spikes`] | squared test ratio of each innovation | accept, reject, lock out |
//! | [`shift`] | innovations and their variances | accept, coast, lock out |
//! | [`whiteness`] | innovations and their variances | white or not |
//! | [`transients`] | innovations and their variances, spikes | white or not, outside of transients of noise |
//! | [`residuals`] | recursive residuals of blocks | weight of each block; correlation, outliers, begin of a change |
//! | [`curvature`] | residuals of blocks, and their mean rates | part of the residuals along the second derivative of the rate |
//! | [`observability`] | covariance, range before the data | observed directions, 0 to 6 |
//! | [`health`] | outcomes, estimates: the verdicts of the others | nominal, degraded, lost |
//! | [`nearest_physical`] | tensor, covariance | nearest tensor that a body can have |
//!
//! No module here depends on an estimator. An estimator owns the state of its monitors and decides
//! on the reaction.

pub mod curvature;
pub mod health;
pub mod innovation;
pub mod nearest_physical;
pub mod observability;
pub mod outliers;
pub mod residuals;
pub mod shift;
pub mod spikes;
pub mod transients;
pub mod whiteness;
