//! Covariance form of `joint-ekf`.

use super::{
    DURATION_S, Filter, GYRO_NOISE_RAD_S, INERTIA_KG_M2, Problem, RATE_WALK_RAD_S_SQRT_S, SIGMA,
};
use fsw_core::dynamics::step::Transition;
use fsw_core::estimator::joint_ekf::{Config, Form, State, structured_ud};
use fsw_core::math::ud::Ud;
use fsw_core::{Inertia, Vec3};

/// Structured UD form with the inputs of a step.
pub struct StructuredUd {
    form: structured_ud::StructuredUd<f32>,
    transition: Transition<f32>,
    config: Config<f32>,
}

impl StructuredUd {
    /// The filter before its first step.
    pub fn new(problem: &Problem) -> Self {
        let config = Config {
            rate_walk_rad_s_sqrt_s: RATE_WALK_RAD_S_SQRT_S,
            inertia_walk_kg_m2_sqrt_s: [problem.inertia_walk_kg_m2_sqrt_s; 6],
            ..Config::new(GYRO_NOISE_RAD_S)
        };
        let form = structured_ud::StructuredUd::new(&Ud::diagonal(SIGMA.map(|s| s * s)));
        Self { form, transition: problem.transition, config }
    }
}

impl Filter for StructuredUd {
    fn step(&mut self, measured_rad_s: &Vec3<f32>) {
        let mut state = State { rate_rad_s: Vec3::zeros(), inertia: Inertia::new(INERTIA_KG_M2) };
        fsw_steps::step_covariance(
            &mut self.form,
            &mut state,
            &self.transition,
            DURATION_S,
            &self.config,
            measured_rad_s,
        );
        core::hint::black_box(&state);
    }

    fn variances(&self) -> [f32; 9] {
        self.form.covariance().diagonal().into()
    }
}
