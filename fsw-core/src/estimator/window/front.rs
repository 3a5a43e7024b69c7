//! The front: the last fit, carried on block by block.

use super::pass::Pass;
use crate::math::scalar::Real;

/// Fit that takes in further blocks.
#[derive(Clone, Copy, Debug)]
pub struct Front<T: Real, const W: usize, const U: usize> {
    pub pass: Pass<T, W, U>,
    /// True where the descent ended at a minimum.
    pub is_settled: bool,
    /// True where the data determine the shape: the point is worth starting from again.
    pub is_shape_observed: bool,
}

crate::persist!([T: Real, const W: usize, const U: usize] Front<T, W, U> { pass, is_settled, is_shape_observed });
