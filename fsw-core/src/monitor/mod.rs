//! 4. Watching the estimate: do the innovations fit, and what has the data shown?

pub mod innovation;
pub mod observability;
