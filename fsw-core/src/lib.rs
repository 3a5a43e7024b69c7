//! On-board estimation of a spacecraft's inertia tensor, one gyro sample per step.
//!
//! # The way of a sample
//!
//! ```text
//!  1 sample      time-tagged body rate, wheel speeds, external torque, attitude
//!       │
//!  2 gate        finite? in range? in order? stuck? a gap? ──► refused, with the reason
//!       │
//!  3 estimator   step(sample) -> Outcome                       ◄── dynamics, tensor: the physics
//!       │          window: average, fit again and again        ◄── math: UD, square root
//!       │          joint_ekf: align, predict, innovation, correct
//!       │          ekf_sgf: rate_ekf ─► savgol ─► regression
//!       │          momentum: conserved in inertial space
//!  4 monitor     do the innovations fit? which directions has the data shown? could a body have it?
//!       │
//!  5 checkpoint  all of that to and from non-volatile memory, bit for bit
//!       │
//!  6 telemetry   estimate(): tensor, covariance, observed, status; counts of outcomes
//! ```
//!
//! The firmware and the simulator call the same [`Estimator::step`].
//! No allocation, no unsafe code, no panic; every step costs a bounded amount of work. All is
//! generic over [`Real`], `f32` or `f64`.
//!
//! # Conventions
//!
//! Body axes at the spacecraft's centre of mass; rates are relative to inertial space. `J` is the
//! inertia tensor in kg m², wheels included and locked; its six elements are always ordered
//! `Jxx Jyy Jzz Jxy Jxz Jyz`, and an off-diagonal element is the tensor entry. `Ω` is a wheel's
//! speed relative to the body, `h_w = Σ Iₛ Ω a` the wheels' momentum, `τ` the external torque.
//! Equation of motion: `J ω̇ + ḣ_w + ω × (J ω + h_w) = τ`.
//!
//! # Sources
//!
//! * \[Bellar2019\] A. Bellar, M. A. Si Mohammed, *Satellite inertia parameters estimation based
//!   on extended Kalman filter*, J. Aerosp. Technol. Manag. 11, e1619, 2019.
//! * \[Kim2010\] D. H. Kim, D.-G. Choi, H.-S. Oh, *Inertia estimation of spacecraft based on
//!   modified law of conservation of angular momentum*, J. Astron. Space Sci. 27(4), 353-357, 2010.
//! * \[Kim2013\] D. Kim, slides on moments of inertia by extended Kalman filter, causal
//!   Savitzky-Golay filter and recursive least squares, Annual Technical Symposium, May 2013.
//! * \[Kim2016\] D. Kim, S. Yang, S. Lee, *Rigid body inertia estimation using extended Kalman and
//!   Savitzky-Golay filters*, Math. Probl. Eng. 2016, 2962671.
//! * \[Bierman1977\] G. J. Bierman, *Factorization Methods for Discrete Sequential Estimation*,
//!   Academic Press, 1977.
//! * \[Thornton1976\] C. L. Thornton, *Triangular covariance factorizations for Kalman filtering*,
//!   JPL TM 33-798, 1976.
#![no_std]
#![forbid(unsafe_code)]

pub mod docs;

pub mod attitude;
pub mod sample;

pub mod gate;

pub mod estimator;

pub mod monitor;

pub mod estimate;
pub mod outcome;
pub mod prior;

pub mod persist;

pub mod checkpoint;

pub mod dynamics;
pub mod error;
pub mod math;
pub mod tensor;

pub use attitude::Quaternion;
pub use dynamics::wheels::WheelArray;
pub use error::ConfigError;
pub use estimate::{Estimate, Status};
pub use estimator::Estimator;
pub use math::{Mat, Vec3, scalar::Real};
pub use monitor::innovation::Innovation;
pub use outcome::{Coasting, Outcome, Reset};
pub use prior::Prior;
pub use sample::Sample;
pub use tensor::Inertia;

#[cfg(test)]
extern crate std;
