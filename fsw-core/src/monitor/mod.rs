//! 4. Watching the estimate: do the innovations fit, and what has the data shown?

pub mod innovation;
pub mod nearest_physical;
pub mod observability;
pub mod spikes;
