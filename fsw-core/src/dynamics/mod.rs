//! The physics that every estimator shares: wheels, the gyrostat equation with its Jacobians,
//! and the steps that integrate it.

pub mod gyrostat;
pub mod interval;
pub mod step;
pub mod wheels;
