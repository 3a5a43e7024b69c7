//! The crate `minikalman`. The count includes its prediction of the state, `Φ x`.

use crate::{Filter, Problem};
use minikalman::prelude::*;
use minikalman::regular::{RegularKalmanBuilder, RegularObservationBuilder};
use minikalman::{
    impl_buffer_A, impl_buffer_H, impl_buffer_K, impl_buffer_P, impl_buffer_Q_direct,
    impl_buffer_R, impl_buffer_S, impl_buffer_temp_HP, impl_buffer_temp_KHP, impl_buffer_temp_P,
    impl_buffer_temp_PHt, impl_buffer_temp_S_inv, impl_buffer_temp_x, impl_buffer_x, impl_buffer_y,
    impl_buffer_z,
};
use nalgebra::SVector;

const STATES: usize = 9;
const MEASUREMENTS: usize = 3;

/// The filter before its first step.
#[allow(non_snake_case, reason = "the names of the crate's buffers")]
pub fn new(problem: &Problem) -> impl Filter + use<> {
    impl_buffer_x!(x, STATES, f32, 0.0);
    impl_buffer_A!(mut A, STATES, f32, 0.0);
    impl_buffer_P!(mut P, STATES, f32, 0.0);
    impl_buffer_Q_direct!(mut Q, STATES, f32, 0.0);
    impl_buffer_temp_x!(temp_x, STATES, f32, 0.0);
    impl_buffer_temp_P!(temp_P, STATES, f32, 0.0);
    impl_buffer_H!(mut H, MEASUREMENTS, STATES, f32, 0.0);
    impl_buffer_z!(z, MEASUREMENTS, f32, 0.0);
    impl_buffer_R!(mut R, MEASUREMENTS, f32, 0.0);
    impl_buffer_y!(y, MEASUREMENTS, f32, 0.0);
    impl_buffer_S!(S, MEASUREMENTS, f32, 0.0);
    impl_buffer_K!(K, STATES, MEASUREMENTS, f32, 0.0);
    impl_buffer_temp_S_inv!(temp_S_inv, MEASUREMENTS, f32, 0.0);
    impl_buffer_temp_HP!(temp_HP, MEASUREMENTS, STATES, f32, 0.0);
    impl_buffer_temp_PHt!(temp_PHt, STATES, MEASUREMENTS, f32, 0.0);
    impl_buffer_temp_KHP!(temp_KHP, STATES, f32, 0.0);

    let (phi, q) = (problem.transition, problem.process_noise);
    for i in 0..STATES {
        for k in 0..STATES {
            A.as_matrix_mut().set_at(i, k, phi[(i, k)]);
            Q.as_matrix_mut().set_at(i, k, q[(i, k)]);
        }
        P.as_matrix_mut().set_at(i, i, problem.sigma[i] * problem.sigma[i]);
    }
    for i in 0..MEASUREMENTS {
        H.as_matrix_mut().set_at(i, i, 1.0);
        R.as_matrix_mut().set_at(i, i, problem.measurement_noise * problem.measurement_noise);
    }
    Minikalman {
        filter: RegularKalmanBuilder::new::<STATES, f32>(A, x, P, Q, temp_x, temp_P),
        observation: RegularObservationBuilder::new::<STATES, MEASUREMENTS, f32>(
            H, z, R, y, S, K, temp_S_inv, temp_HP, temp_PHt, temp_KHP,
        ),
    }
}

/// Filter and observation, of types named only by the crate's macros.
struct Minikalman<F, M> {
    filter: F,
    observation: M,
}

impl<F, M> Filter for Minikalman<F, M>
where
    F: KalmanFilter<STATES, f32>,
    M: KalmanFilterObservation<STATES, MEASUREMENTS, f32>,
{
    fn step(&mut self, measured: &SVector<f32, 3>) {
        self.filter.predict();
        let z = self.observation.measurement_vector_mut().as_matrix_mut();
        for i in 0..MEASUREMENTS {
            z.set_row(i, measured[i]);
        }
        self.filter.correct(&mut self.observation);
    }

    fn variances(&self) -> [f32; 9] {
        let p = self.filter.estimate_covariance().as_matrix();
        core::array::from_fn(|i| p.get_at(i, i))
    }
}
