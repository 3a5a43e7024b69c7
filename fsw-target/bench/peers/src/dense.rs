//! Textbook equations with dense matrices of nalgebra.

use crate::{Filter, Problem};
use nalgebra::{SMatrix, SVector};

/// State, covariance, and matrices of the model.
pub struct Dense {
    x: SVector<f32, 9>,
    p: SMatrix<f32, 9, 9>,
    phi: SMatrix<f32, 9, 9>,
    q: SMatrix<f32, 9, 9>,
    h: SMatrix<f32, 3, 9>,
    r: SMatrix<f32, 3, 3>,
}

impl Dense {
    /// The filter before its first step.
    pub fn new(problem: &Problem) -> Self {
        Self {
            x: SVector::zeros(),
            p: SMatrix::from_diagonal(&SVector::from(problem.sigma.map(|s| s * s))),
            phi: problem.transition,
            q: problem.process_noise,
            h: SMatrix::identity(),
            r: SMatrix::identity() * (problem.measurement_noise * problem.measurement_noise),
        }
    }
}

impl Filter for Dense {
    #[allow(non_snake_case, reason = "symbols of the equations")]
    fn step(&mut self, measured: &SVector<f32, 3>) {
        let (F, H) = (&self.phi, &self.h);
        let P = F * self.p * F.transpose() + self.q;
        let S = H * P * H.transpose() + self.r;
        let Some(inverse) = S.try_inverse() else { return };
        let K = P * H.transpose() * inverse;
        self.x = K * measured;
        self.p = (SMatrix::<f32, 9, 9>::identity() - K * H) * P;
    }

    fn variances(&self) -> [f32; 9] {
        self.p.diagonal().into()
    }
}
