//! What is known of momentum and inertia at the start of a window, before its first block.

use crate::estimator::Prior;
use crate::math::{Vec3, scalar::Real};
use crate::tensor::{Inertia, regressor};

/// Unknowns of a pass: momentum h₀ at the start of the window, then the six elements. The
/// inertia comes last, so that the last six rows of a triangular factor are the information on
/// it alone.
pub const UNKNOWNS: usize = 9;
/// Where the six elements begin.
pub const INERTIA: usize = 3;

/// Weight of the reading from which momentum starts after a gap: it will be counted in full in its
/// block, and so far must only keep the solution from being undetermined.
const FAINT: f64 = 0.01;

/// Values of the unknowns, in units of a typical inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<T: Real> {
    /// h₀, rad/s.
    pub momentum: Vec3<T>,
    /// Six elements.
    pub inertia: [T; 6],
}

impl<T: Real> Point<T> {
    /// A step further.
    pub fn plus(&self, step: &[T; UNKNOWNS]) -> Self {
        Self {
            momentum: self.momentum + Vec3::new(step[0], step[1], step[2]),
            inertia: core::array::from_fn(|i| self.inertia[i] + step[INERTIA + i]),
        }
    }

    /// The step from another point to this one.
    pub fn minus(&self, other: &Self) -> [T; UNKNOWNS] {
        let h = self.momentum - other.momentum;
        core::array::from_fn(|i| match i {
            0..INERTIA => h[i],
            _ => self.inertia[i - INERTIA] - other.inertia[i - INERTIA],
        })
    }
}

/// Rows of information: `R (θ − θ₀) − y` has zero mean and the variance of a gyro sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known<T: Real> {
    /// θ₀.
    pub point: Point<T>,
    /// R, row by row; a row of zeros says nothing.
    pub rows: [[T; UNKNOWNS]; UNKNOWNS],
    /// y.
    pub right: [T; UNKNOWNS],
}

impl<T: Real> Known<T> {
    /// Of the inertia alone, from a prior in units of the inertia whose inverse is `per`, for
    /// gyro noise of one sigma per sample, rad/s.
    pub fn from_prior(prior: &Prior<T>, noise_rad_s: T, per: T) -> Self {
        let mut rows = [[T::zero(); UNKNOWNS]; UNKNOWNS];
        for i in 0..6 {
            rows[INERTIA + i][INERTIA + i] = noise_rad_s / (prior.sigma_kg_m2[i] * per);
        }
        let inertia = prior.inertia_kg_m2.map(|x| x * per);
        let point = Point { momentum: Vec3::zeros(), inertia };
        Self { point, rows, right: [T::zero(); UNKNOWNS] }
    }

    /// What stays of it where the momentum is no longer known, but a reading is at hand, in units
    /// of the typical inertia: the inertia, whose information the factor's last rows are, and
    /// hardly more than that `h = J ω + h_w`.
    pub fn after_gap(mut self, rate_rad_s: &Vec3<T>, wheel_momentum: &Vec3<T>) -> Self {
        let j = Inertia::new(self.point.inertia).matrix_kg_m2();
        self.point.momentum = j * rate_rad_s + wheel_momentum;
        let weight = T::lit(FAINT);
        let g = regressor(rate_rad_s) * -weight;
        for i in 0..INERTIA {
            self.rows[i] = core::array::from_fn(|c| match c {
                0..INERTIA if c == i => weight,
                0..INERTIA => T::zero(),
                _ => g[(i, c - INERTIA)],
            });
            self.right[i] = T::zero();
        }
        self
    }

    /// How many unknowns the rows determine.
    pub fn rank(&self) -> u32 {
        let says_something = |row: &&[T; UNKNOWNS]| row.iter().any(|x| *x != T::zero());
        self.rows.iter().filter(says_something).count() as u32
    }
}
