//! Fit of the motion to blocks: Gauss-Newton from a linear start, with prior knowledge.
//!
//! | module | content |
//! |---|---|
//! | [`start`] | first point, linear in shape and scale |
//! | [`pass`] | prediction, sensitivities and residuals of all blocks at a point |
//! | [`descent`] | step after a pass, and end of the descent |
//! | [`belief`] | prior, earlier fits and ranges as rows of the factor |
//! | [`drift`] | gyro bias and disturbance torque that walk |
//! | [`front`] | result, carried on block by block |

pub mod belief;
pub mod descent;
pub mod drift;
pub mod front;
pub mod pass;
pub mod start;
