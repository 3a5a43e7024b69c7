//! The estimators' steps as they fly: `f32`, four wheels.
//!
//! What runs with each sample is compiled for speed, all else of the firmware for size. A compiler
//! decides that crate by crate, and generic code is compiled where it is first used with a type: so
//! the steps are used here, and the profile `firmware` (`Cargo.toml` of the workspace) compiles this
//! crate for speed. Functions here are generic in nothing, and never inlined elsewhere.

#![no_std]
#![forbid(unsafe_code)]

use fsw_core::dynamics::step::Transition;
use fsw_core::estimator::ekf_sgf::EkfSgf;
use fsw_core::estimator::joint_ekf::{self, Form, JointEkfUd, State, StructuredUd};
use fsw_core::estimator::window::Window;
use fsw_core::{Estimate, Estimator, Innovation, Outcome, Sample, Vec3};

mod roster;

pub use roster::{EstimatorId, EstimatorSlot, InitialData, Refused, Selected};

/// Wheels that the flight image has room for. A spacecraft with fewer has some of no spin inertia.
pub const WHEELS: usize = 4;
/// Blocks that a window keeps: up to 48 turns of the body.
pub const BLOCKS: usize = 512;

/// `window` of inertia alone.
pub type Window9 = Window<f32, WHEELS, BLOCKS, 9>;
/// `window` with a torque that is tested, held at zero.
pub type Window12 = Window<f32, WHEELS, BLOCKS, 12>;
/// `window` with torque and bias.
pub type Window15 = Window<f32, WHEELS, BLOCKS, 15>;
/// `window` with torque, bias and drag.
pub type Window18 = Window<f32, WHEELS, BLOCKS, 18>;
/// `joint-ekf`.
pub type JointEkf = JointEkfUd<f32, WHEELS>;
/// `ekf-sgf-rls`.
pub type EkfSgfRls = EkfSgf<f32, WHEELS>;

/// An estimator whose step is compiled here.
pub trait Step: Estimator<f32, WHEELS> {
    /// As [`Estimator::step`], to the last bit.
    fn step_fast(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome;
}

/// An estimator that is stepped so, for code that takes any estimator.
#[derive(Debug, Clone)]
pub struct Fast<E>(pub E);

impl<E: Step> Estimator<f32, WHEELS> for Fast<E> {
    fn step(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome {
        self.0.step_fast(sample)
    }

    fn estimate(&self) -> Estimate<f32> {
        self.0.estimate()
    }

    fn rate_rad_s(&self) -> Vec3<f32> {
        self.0.rate_rad_s()
    }

    fn innovation(&self) -> Option<Innovation<f32>> {
        self.0.innovation()
    }
}

macro_rules! step_fast {
    ($($estimator:ty),*) => {
        $(impl Step for $estimator {
            #[inline(never)]
            fn step_fast(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome {
                Estimator::step(self, sample)
            }
        })*
    };
}

step_fast!(Window9, Window12, Window15, Window18, JointEkf, EkfSgfRls);

/// The covariance of `joint-ekf` alone, for the bench: predict and update.
#[inline(never)]
pub fn step_covariance(
    form: &mut StructuredUd<f32>,
    state: &mut State<f32>,
    transition: &Transition<f32>,
    duration_s: f32,
    config: &joint_ekf::Config<f32>,
    measured_rad_s: &Vec3<f32>,
) {
    form.propagate(transition, duration_s, config);
    let noise = config.gyro_noise_rad_s;
    form.update(state, measured_rad_s, noise * noise);
}
