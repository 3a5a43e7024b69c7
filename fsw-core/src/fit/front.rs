//! The front: the last fit, carried on block by block.

use super::pass::Pass;
use crate::math::scalar::Real;
use crate::monitor::observability::Observed;
use crate::trajectory::unknowns::shape_of;

/// A fit that has ended, and its judgement.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// First block of it.
    pub from: usize,
    /// True where the descent ended at a minimum.
    pub is_settled: bool,
    /// The same, and the residuals agree with the noise throughout.
    pub is_good: bool,
    /// True where the data determine the shape.
    pub is_shape_observed: bool,
    /// Directions that it observes, with earlier windows; none before the judgement.
    pub observed: Option<Observed>,
}

crate::persist!([] Fit { from, is_settled, is_good, is_shape_observed, observed });

impl Fit {
    /// A fit that has ended, before its judgement.
    pub fn ended(from: usize, is_settled: bool) -> Self {
        Self { from, is_settled, is_good: false, is_shape_observed: false, observed: None }
    }
}

/// Fit that takes in further blocks.
#[derive(Clone, Copy, Debug)]
pub struct Front<T: Real, const W: usize, const U: usize, const M: usize> {
    pub pass: Pass<T, W, U, M>,
    /// True where the descent ended at a minimum.
    pub is_settled: bool,
    /// True where the data determine the shape: the next fit starts from this point.
    pub is_shape_observed: bool,
    /// Directions that the fit itself observed, or the front when it was judged anew. What further blocks seem to add is only linearised about
    /// its point: an estimate that was uncertain there needs another fit.
    pub observed: Observed,
    /// Information of the fit, octaves.
    octaves: u32,
}

crate::persist!([T: Real, const W: usize, const U: usize, const M: usize] Front<T, W, U, M> { pass, is_settled, is_shape_observed, observed, octaves });

/// Growth of the information on the six unknowns of the inertia, octaves in all, at which an uncertain
/// estimate is linearised anew: each sigma has shrunk by a quarter or so, one of them by much more.
const GROWN: u32 = 6;

impl<T: Real, const W: usize, const U: usize, const M: usize> Front<T, W, U, M> {
    /// Front at the end of a fit. Inlined, so that it is built in its place and not on the stack.
    #[inline(always)]
    pub fn new(pass: &Pass<T, W, U, M>, fit: &Fit) -> Self {
        let Fit { is_settled, is_shape_observed, .. } = *fit;
        let observed = fit.observed.unwrap_or_default();
        let octaves = octaves(pass);
        Self { pass: *pass, is_settled, is_shape_observed, observed, octaves }
    }

    /// True where further blocks have changed an estimate that was uncertain.
    pub fn is_outgrown(&self) -> bool {
        self.observed.directions < 6 && octaves(&self.pass) >= self.octaves.saturating_add(GROWN)
    }
}

/// Binary logarithm of the information on the six unknowns of the inertia, each given the later ones, summed
/// and truncated.
fn octaves<T: Real, const W: usize, const U: usize, const M: usize>(
    pass: &Pass<T, W, U, M>,
) -> u32 {
    let rows = pass.factor.factor.iter().enumerate().skip(shape_of(U));
    let diagonal = rows.filter_map(|(i, row)| row.get(i));
    diagonal.map(|element| (element.to_f32().to_bits() >> 23) & 0xff).sum()
}
