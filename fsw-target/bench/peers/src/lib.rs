//! Other Kalman filters on the work of `joint-ekf`'s covariance, which the image `bench` counts beside
//! ours: nine states, three measured.
//!
//! A crate of its own, so that they are compiled for speed, as our steps are, and not for size as the
//! rest of the firmware.

#![no_std]
#![forbid(unsafe_code)]

mod adskalman;
mod dense;
mod minikalman;

use nalgebra::{SMatrix, SVector};

/// What all of them are given.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// Φ.
    pub transition: SMatrix<f32, 9, 9>,
    /// Q.
    pub process_noise: SMatrix<f32, 9, 9>,
    /// Square root of P at the start, its diagonal.
    pub sigma: [f32; 9],
    /// Square root of R, of each axis.
    pub measurement_noise: f32,
}

/// A filter about zero: its state is the deviation from what is predicted.
pub trait Filter {
    /// Predicts, and updates with a measured deviation.
    fn step(&mut self, measured: &SVector<f32, 3>);
    /// Variances of the nine states.
    fn variances(&self) -> [f32; 9];
}

/// Shows each of them to `visit`, by its name, before its first step. Generic in nothing, so that all
/// of it is compiled here.
pub fn each(problem: &Problem, visit: &mut dyn FnMut(&'static str, &mut dyn Filter)) {
    visit("dense-nalgebra", &mut dense::Dense::new(problem));
    visit("adskalman", &mut adskalman::Adskalman::plain(problem));
    visit("adskalman-joseph", &mut adskalman::Adskalman::joseph(problem));
    visit("minikalman", &mut minikalman::new(problem));
}
