//! Covariance of the inertia from the information of a manoeuvre, its size, and the derivative of that size
//! by the information.
//!
//! With the information `F = Σ Zᵀ Z / σ² + diag(prior)` over the unknowns `x` and the considered errors
//! `c` of covariance `Σ`, `C = F_xx⁻¹` and `K = C F_xc`, the covariance is `C + K Σ Kᵀ` (Schmidt; see
//! [`bound`](crate::truth::bound::hardware)). For a function with derivative `W` by the covariance of the
//! unknowns,
//!
//! ```text
//! ∂/∂F_xx = −C W C − (K Σ Kᵀ W C + C W K Σ Kᵀ),   ∂/∂F_xc = 2 C W K Σ
//! ```

use nalgebra::{DMatrix, Matrix6};

use super::columns::{Columns, Kind};

/// Measure of the covariance `C` of the six elements, in units of the mean moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Criterion {
    /// Sum of the variances, `tr C`.
    #[default]
    A,
    /// Volume of the confidence ellipsoid, `det C`.
    D,
    /// Variance of the worst direction, the largest eigenvalue of `C`.
    E,
}

/// Exponent of the sum of powers that stands for the largest eigenvalue, which has no derivative where two
/// are equal: `(Σ λ⁸)^⅛` exceeds the largest by at most a quarter (6 equal eigenvalues).
const LARGEST_POWER: i32 = 8;

impl Criterion {
    /// Natural logarithm of the size, one sigma.
    pub(super) fn log_size(self, c: &Matrix6<f64>) -> f64 {
        self.size(c).0
    }

    /// Natural logarithm of the size, one sigma, and its derivative by the covariance.
    fn size(self, c: &Matrix6<f64>) -> (f64, Matrix6<f64>) {
        match self {
            Self::A => (0.5 * c.trace().ln(), Matrix6::identity() / (2.0 * c.trace())),
            Self::D => {
                let (inverse, determinant) =
                    c.cholesky().map_or((Matrix6::zeros(), f64::INFINITY), |factor| {
                        (factor.inverse(), factor.l().diagonal().map(f64::ln).sum() * 2.0)
                    });
                (determinant / 12.0, inverse / 12.0)
            }
            Self::E => {
                let power = c.symmetric_eigen();
                let largest = power.eigenvalues.max();
                let shares = power.eigenvalues.map(|value| value / largest);
                let sum: f64 = shares.iter().map(|share| share.powi(LARGEST_POWER)).sum();
                let weights =
                    shares.map(|share| share.powi(LARGEST_POWER - 1) / (2.0 * sum * largest));
                let v = &power.eigenvectors;
                let size = 0.5 * (largest.ln() + sum.ln() / f64::from(LARGEST_POWER));
                (size, v * Matrix6::from_diagonal(&weights) * v.transpose())
            }
        }
    }
}

/// Information of some data, without priors, in units of one over the noise variance.
pub(super) struct Information<'a> {
    columns: &'a Columns,
    f: DMatrix<f64>,
}

/// Covariance of the six elements, in units of the mean moment squared.
pub(super) struct Covariance {
    /// By noise and solved errors.
    pub random: Matrix6<f64>,
    /// With considered errors.
    pub total: Matrix6<f64>,
}

/// Parts of the computation of a covariance that its derivative needs.
struct Parts {
    solved: Vec<usize>,
    considered: Vec<usize>,
    /// Position of the six elements among the solved columns.
    inertia: usize,
    c: DMatrix<f64>,
    /// `K √Σ`.
    k: DMatrix<f64>,
}

impl<'a> Information<'a> {
    pub(super) fn new(columns: &'a Columns) -> Self {
        let count = columns.all.len();
        Self { columns, f: DMatrix::zeros(count, count) }
    }

    /// Adds rows, 3 × columns, this number of times.
    pub(super) fn add(&mut self, rows: &DMatrix<f64>, times: f64) {
        self.f.gemm_tr(times, rows, rows, 1.0);
    }

    /// Covariance for noise of this sigma, rad/s; none if it is not a number.
    pub(super) fn covariance(&self, noise_rad_s: f64) -> Option<Covariance> {
        let parts = self.parts(noise_rad_s)?;
        let random = parts.of_inertia(&parts.c);
        let total = random + parts.of_inertia(&(&parts.k * parts.k.transpose()));
        Some(Covariance { random, total })
    }

    /// Size of the covariance, and its derivative by the information added; none if it is not a number.
    pub(super) fn size(
        &self,
        noise_rad_s: f64,
        criterion: Criterion,
    ) -> Option<(f64, DMatrix<f64>)> {
        let parts = self.parts(noise_rad_s)?;
        let spread = &parts.k * parts.k.transpose();
        let (size, w6) = criterion.size(&parts.of_inertia(&(&parts.c + &spread)));
        let count = parts.solved.len();
        let mut w = DMatrix::zeros(count, count);
        w.view_mut((parts.inertia, parts.inertia), (6, 6)).copy_from(&w6);
        let cw = &parts.c * &w;
        let cross = &cw * &spread;
        let by_solved = -(&cw * &parts.c) - &cross - cross.transpose();
        let sigma: Vec<f64> =
            parts.considered.iter().map(|i| self.columns.all[*i].prior_sigma).collect();
        let all = self.columns.all.len();
        let mut by_f = DMatrix::zeros(all, all);
        for (a, i) in parts.solved.iter().enumerate() {
            for (b, j) in parts.solved.iter().enumerate() {
                by_f[(*i, *j)] = by_solved[(a, b)];
            }
        }
        let by_cross = &cw * &parts.k;
        for (a, i) in parts.solved.iter().enumerate() {
            for (b, j) in parts.considered.iter().enumerate() {
                by_f[(*i, *j)] = by_cross[(a, b)] * sigma[b];
                by_f[(*j, *i)] = by_f[(*i, *j)];
            }
        }
        size.is_finite().then(|| (size, by_f / (noise_rad_s * noise_rad_s)))
    }

    fn parts(&self, noise_rad_s: f64) -> Option<Parts> {
        let columns = &self.columns.all;
        let is_considered = |i: &usize| columns[*i].is_considered;
        let (considered, solved): (Vec<usize>, Vec<usize>) =
            (0..columns.len()).partition(is_considered);
        let weight = 1.0 / (noise_rad_s * noise_rad_s);
        let mut f = self.f.select_rows(&solved).select_columns(&solved) * weight;
        for (a, i) in solved.iter().enumerate() {
            f[(a, a)] += 1.0 / columns[*i].prior_sigma.powi(2);
        }
        let c = scaled_inverse(&f)?;
        let cross = self.f.select_rows(&solved).select_columns(&considered) * weight;
        let mut k = &c * cross;
        for (b, j) in considered.iter().enumerate() {
            k.column_mut(b).scale_mut(columns[*j].prior_sigma);
        }
        let is_first = |i: &usize| columns[*i].kind == Kind::Inertia(0);
        let inertia = solved.iter().position(is_first)?;
        Some(Parts { solved, considered, inertia, c, k })
    }
}

impl Parts {
    fn of_inertia(&self, all: &DMatrix<f64>) -> Matrix6<f64> {
        all.fixed_view::<6, 6>(self.inertia, self.inertia).into_owned()
    }
}

/// Inverse of a positive definite matrix, its diagonal scaled to one first: the columns differ by orders of
/// magnitude.
fn scaled_inverse(f: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = f.diagonal().map(|x| 1.0 / x.sqrt());
    let scaled = DMatrix::from_fn(f.nrows(), f.ncols(), |i, j| f[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    let c = DMatrix::from_fn(f.nrows(), f.ncols(), |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    c.iter().all(|x| x.is_finite()).then_some(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;
    use crate::manoeuvre::columns::Treatment;

    #[test]
    fn derivative_of_each_size_is_that_of_finite_differences() {
        let scenario = Scenario::load("cubesat-pyramid-data-sheet").unwrap();
        for treatment in [Treatment::Considered, Treatment::Solved] {
            let columns = Columns::new(&scenario, treatment, None, 0.03);
            let count = columns.all.len();
            let mut information = Information::new(&columns);
            for k in 0..40 {
                // Rows without a pattern, so that the information has full rank.
                let entry = |i, j| {
                    ((k * 97 + 31 * i + 7 * j * j + j) as f64 * 12.9898).sin() * 43.758 % 1e-3
                };
                information.add(&DMatrix::from_fn(3, count, entry), 1.0);
            }
            for criterion in [Criterion::A, Criterion::D, Criterion::E] {
                let (_, by_f) = information.size(1e-4, criterion).unwrap();
                for (i, j) in [(0, 0), (3, 4), (5, 5), (4, count - 1), (8, 12)] {
                    let step = 1e-7 * information.f[(i, i)];
                    let at = |sign: f64| {
                        let mut moved = Information { columns: &columns, f: information.f.clone() };
                        moved.f[(i, j)] += sign * step;
                        if i != j {
                            moved.f[(j, i)] += sign * step;
                        }
                        moved.size(1e-4, criterion).unwrap().0
                    };
                    let found = (at(1.0) - at(-1.0)) / (2.0 * step);
                    let expected = if i == j { by_f[(i, j)] } else { by_f[(i, j)] + by_f[(j, i)] };
                    let tolerance = 1e-4 * expected.abs().max(1e-3 * by_f.amax());
                    assert!((found - expected).abs() < tolerance, "{found} {expected}");
                }
            }
        }
    }
}
