//! Kalman filters of other crates on the problem of `joint-ekf`'s covariance, nine states and three
//! measurements, counted by the image `bench` for comparison.
//!
//! A crate of its own, so that it is compiled for speed, as the estimator steps are, and not for size
//! as the rest of the firmware.

#![no_std]
#![forbid(unsafe_code)]

mod adskalman;
mod dense;
mod minikalman;

use nalgebra::{SMatrix, SVector};

/// Problem of all filters.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// Transition matrix Φ.
    pub transition: SMatrix<f32, 9, 9>,
    /// Process noise covariance Q.
    pub process_noise: SMatrix<f32, 9, 9>,
    /// Square roots of the diagonal of the initial covariance P.
    pub sigma: [f32; 9],
    /// Square root of the diagonal of R, equal for all axes.
    pub measurement_noise: f32,
}

/// A filter about zero: its state is the deviation from the prediction.
pub trait Filter {
    /// Predicts, then updates with the measured deviation.
    fn step(&mut self, measured: &SVector<f32, 3>);
    /// Variances of the nine states.
    fn variances(&self) -> [f32; 9];
}

/// Passes each filter to `visit`, by its name, before its first step. Not generic, so that all code
/// is compiled in this crate.
pub fn each(problem: &Problem, visit: &mut dyn FnMut(&'static str, &mut dyn Filter)) {
    visit("dense-nalgebra", &mut dense::Dense::new(problem));
    visit("adskalman", &mut adskalman::Adskalman::plain(problem));
    visit("adskalman-joseph", &mut adskalman::Adskalman::joseph(problem));
    visit("minikalman", &mut minikalman::new(problem));
}
