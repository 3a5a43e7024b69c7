//! The crate `adskalman`. The count includes its prediction of the state, `Φ x`.

use crate::{Filter, Problem};
use adskalman::{
    CovarianceUpdateMethod, KalmanFilterNoControl, ObservationModel, StateAndCovariance,
    TransitionModelLinearNoControl,
};
use nalgebra::{Const, SMatrix, SVector};

/// Filter with transition and observation model.
pub struct Adskalman {
    estimate: StateAndCovariance<f32, Const<9>>,
    transition: Transition,
    observation: Observation,
    method: CovarianceUpdateMethod,
}

struct Transition {
    f: SMatrix<f32, 9, 9>,
    ft: SMatrix<f32, 9, 9>,
    q: SMatrix<f32, 9, 9>,
}

struct Observation {
    h: SMatrix<f32, 3, 9>,
    ht: SMatrix<f32, 9, 3>,
    r: SMatrix<f32, 3, 3>,
}

impl Adskalman {
    /// With the update `P ← (1 − K H) P`.
    pub fn plain(problem: &Problem) -> Self {
        Self::new(problem, CovarianceUpdateMethod::OptimalKalman)
    }

    /// With Joseph's form of the update, the default of the crate.
    pub fn joseph(problem: &Problem) -> Self {
        Self::new(problem, CovarianceUpdateMethod::JosephForm)
    }

    fn new(problem: &Problem, method: CovarianceUpdateMethod) -> Self {
        let p = SMatrix::from_diagonal(&SVector::from(problem.sigma.map(|s| s * s)));
        let (f, h) = (problem.transition, SMatrix::<f32, 3, 9>::identity());
        let r = SMatrix::identity() * (problem.measurement_noise * problem.measurement_noise);
        Self {
            estimate: StateAndCovariance::new(SVector::zeros(), p),
            transition: Transition { f, ft: f.transpose(), q: problem.process_noise },
            observation: Observation { h, ht: h.transpose(), r },
            method,
        }
    }
}

impl TransitionModelLinearNoControl<f32, Const<9>> for Transition {
    fn F(&self) -> &SMatrix<f32, 9, 9> {
        &self.f
    }

    fn FT(&self) -> &SMatrix<f32, 9, 9> {
        &self.ft
    }

    fn Q(&self) -> &SMatrix<f32, 9, 9> {
        &self.q
    }
}

impl ObservationModel<f32, Const<9>, Const<3>> for Observation {
    fn H(&self) -> &SMatrix<f32, 3, 9> {
        &self.h
    }

    fn HT(&self) -> &SMatrix<f32, 9, 3> {
        &self.ht
    }

    fn R(&self) -> &SMatrix<f32, 3, 3> {
        &self.r
    }
}

impl Filter for Adskalman {
    fn step(&mut self, measured: &SVector<f32, 3>) {
        let filter = KalmanFilterNoControl::new(&self.transition, &self.observation);
        let after = filter.step_with_options(&self.estimate, measured, self.method);
        if let Ok(estimate) = after {
            self.estimate = estimate;
        }
    }

    fn variances(&self) -> [f32; 9] {
        self.estimate.covariance().diagonal().into()
    }
}
