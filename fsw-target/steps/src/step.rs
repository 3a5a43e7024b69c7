//! Types of the estimators and their steps, `f32`, for up to four wheels.

use fsw_core::dynamics::step::Transition;
use fsw_core::estimator::ekf_sgf::EkfSgf;
use fsw_core::estimator::joint_ekf::{self, Form, JointEkfUd, State, StructuredUd};
use fsw_core::estimator::window::Window;
use fsw_core::{Estimate, Estimator, Innovation, Outcome, Sample, Vec3};

/// Number of wheels of the flight image. A spacecraft with fewer sets the spin inertia of the others to
/// zero.
pub const WHEELS: usize = 4;
/// Blocks of a window: up to 48 turns of the body.
pub const BLOCKS: usize = 512;

/// `window` with nine unknowns: angular momentum and inertia.
pub type Window9 = Window<f32, WHEELS, BLOCKS, 9>;
/// `window` with 18 unknowns: torque, gyro bias and drag as well.
pub type Window18 = Window<f32, WHEELS, BLOCKS, 18>;
/// `window` for stated hardware, 15 unknowns: momentum and inertia, and time offset, torque scale and common spin inertia.
/// It considers seven groups of three parameters: gyro 9, wheels 3 each.
pub type WindowOfHardware = Window<f32, WHEELS, BLOCKS, 15, { 3 + WHEELS }>;
/// `joint-ekf`.
pub type JointEkf = JointEkfUd<f32, WHEELS>;
/// Parameters that `joint-ekf` considers: gyro 9, wheels 3 each, time offset, common spin inertia, torque scale.
pub const CONSIDERED: usize = 12 + 3 * WHEELS;
/// `joint-ekf` for stated hardware.
pub type JointEkfOfHardware = JointEkfUd<f32, WHEELS, CONSIDERED>;
/// `ekf-sgf-rls`.
pub type EkfSgfRls = EkfSgf<f32, WHEELS>;

/// An estimator whose step is compiled in this crate.
pub trait Step: Estimator<f32, WHEELS> {
    /// [`Estimator::step`], bit for bit; that of a window without slices of work, [`Window::step_alone`].
    fn step_fast(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome;
}

/// Adapter for code that takes any [`Estimator`]: its step is [`Step::step_fast`].
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

    fn finish(&mut self) {
        self.0.finish();
    }
}

macro_rules! step_fast {
    ($step:path: $($estimator:ty),*) => {
        $(impl Step for $estimator {
            #[inline(never)]
            fn step_fast(&mut self, sample: &Sample<f32, WHEELS>) -> Outcome {
                $step(self, sample)
            }
        })*
    };
}

step_fast!(Window::step_alone: Window9, Window18, WindowOfHardware);
step_fast!(Estimator::step: JointEkf, JointEkfOfHardware, EkfSgfRls);

/// Prediction and update of the covariance of `joint-ekf` alone, for the bench.
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
    form.update(state, measured_rad_s, noise * noise, |_| None);
}
