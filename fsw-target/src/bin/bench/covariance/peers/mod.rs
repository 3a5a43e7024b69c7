//! What others do of the same.

pub mod adskalman;
pub mod dense;
pub mod minikalman;
