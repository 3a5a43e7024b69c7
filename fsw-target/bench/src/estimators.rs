//! Instruction counts of the estimators, each on each flight.

use crate::counter::Counter;
use crate::flights::{self, Flight};
use crate::slices::SliceTally;
use crate::tally::Tally;
use fsw_core::estimator::ekf_sgf;
use fsw_core::estimator::joint_ekf;
use fsw_core::estimator::window::{self, Slice, Window};
use fsw_core::hardware::{Disturbance, Hardware};
use fsw_core::{Coasting, Prior};
use fsw_core::{ConfigError, Outcome, Sample, Status, WheelArray};
use fsw_roster::Work;
use fsw_steps::{
    BLOCKS, EkfSgfRls, JointEkf, JointEkfOfHardware, Step, Window9, Window18, WindowOfHardware,
};
use fsw_target::flight::computer::SLICES_PER_SAMPLE;
use fsw_target::flight::craft::WHEELS;
use fsw_target::stand_in::recording::cubesat_pyramid::CRAFT;

/// Disturbances estimated by `window-15` and `window-18`, one sigma: far above those of a small
/// satellite.
const DISTURBANCE_TORQUE_N_M: f32 = 1e-4;
const GYRO_BIAS_RAD_S: f32 = 1e-2;

/// Prior as from a CAD model of the CubeSat: moments within a tenth, no products.
const PRIOR: Prior<f32> = Prior {
    inertia_kg_m2: [0.06, 0.1, 0.11, 0.0, 0.0, 0.0],
    sigma_kg_m2: [0.006, 0.01, 0.01, 0.004, 0.004, 0.004],
};

/// Prior too wide for a start without alignment.
const VAGUE: Prior<f32> = Prior {
    inertia_kg_m2: [0.1, 0.1, 0.1, 0.0, 0.0, 0.0],
    sigma_kg_m2: [0.05, 0.05, 0.05, 0.02, 0.02, 0.02],
};

/// Random walk of propellant use: 1 % of a moment per hour.
const INERTIA_WALK_KG_M2_SQRT_S: f32 = 1e-3 / 60.0;

/// Errors of a consumer gyro and of small wheels: 22 parameters.
const HARDWARE: Hardware<f32, WHEELS> = Hardware {
    gyro_scale: 5e-3,
    gyro_axes_rad: 1.7e-3,
    delay_s: 0.0,
    delay_sigma_s: 5e-3,
    wheel_inertia: [0.01; WHEELS],
    wheel_axis_rad: [3.5e-3; WHEELS],
    common_wheel_inertia: 0.0,
    torque_scale: 0.0,
    clock: 0.0,
    mount_rad: [0.0; 3],
};

/// Data too large for the stack.
pub struct Places {
    /// Tally of the current flight.
    pub tally: Tally,
    slices: SliceTally,
    estimator: AnyEstimator,
}

impl Places {
    /// Places without estimators.
    pub const fn new() -> Self {
        Self { tally: Tally::new(), slices: SliceTally::new(), estimator: AnyEstimator::None }
    }
}

/// Steps every estimator through every flight, and logs the counts.
pub fn fly_all(counter: &mut Counter, places: &mut Places) -> Result<(), ConfigError> {
    let wheels = CRAFT.wheels()?;
    let noise = CRAFT.gyro_noise_rad_s;
    let Places { tally, slices, estimator: place } = places;
    let mut bench = Bench { counter, tally, slices };

    let config = joint_ekf::Config::new(noise);
    bench.fly("joint-ekf", place, |place| place.joint(config, wheels))?;
    let config = joint_ekf::Config { prior: Some(VAGUE), ..config };
    bench.fly("joint-ekf-vague", place, |place| place.joint(config, wheels))?;
    let config = joint_ekf::Config { prior: Some(PRIOR), ..config };
    bench.fly("joint-ekf-prior", place, |place| place.joint(config, wheels))?;
    let walk = [INERTIA_WALK_KG_M2_SQRT_S; 6];
    let config = joint_ekf::Config { inertia_walk_kg_m2_sqrt_s: walk, ..config };
    bench.fly("joint-ekf-walk", place, |place| place.joint(config, wheels))?;

    let config = joint_ekf::Config::new(noise);
    bench.fly("joint-ekf-hardware", place, |place| place.of_hardware(config, wheels))?;
    let config = joint_ekf::Config { prior: Some(PRIOR), ..config };
    bench.fly("joint-ekf-hardware-prior", place, |place| place.of_hardware(config, wheels))?;

    let config = ekf_sgf::Config::kim_2013(noise, PRIOR);
    bench.fly("ekf-sgf-rls", place, |place| place.regression(config, wheels))?;

    // As in the flight image: the slices are the caller's.
    let config = window::Config { slices_per_step: 0, ..window::Config::new(noise) };
    bench.fly("window-9", place, |place| begin(place.nine(wheels), config))?;
    let config = window::Config {
        disturbance_torque_n_m: Some(DISTURBANCE_TORQUE_N_M),
        gyro_bias_rad_s: Some(GYRO_BIAS_RAD_S),
        ..config
    };
    bench.fly("window-18", place, |place| begin(place.eighteen(wheels), config))?;
    let config =
        window::Config { slices_per_step: 0, hardware: HARDWARE, ..window::Config::new(noise) };
    bench.fly("window-hardware", place, |place| begin(place.of_stated(wheels), config))
}

/// The window in its place, started again.
fn begin<const U: usize, const C: usize>(
    window: Option<&mut Window<f32, WHEELS, BLOCKS, U, C>>,
    config: window::Config<f32, 4>,
) -> Result<Option<&mut Window<f32, WHEELS, BLOCKS, U, C>>, ConfigError> {
    if let Some(window) = window {
        window.reset(config)?;
        return Ok(Some(window));
    }
    Ok(None)
}

/// An estimator of any type: one place for all, built in place, since most exceed the stack.
#[allow(clippy::large_enum_variant, reason = "one place for all")]
enum AnyEstimator {
    None,
    Joint(JointEkf),
    OfHardware(JointEkfOfHardware),
    Regression(EkfSgfRls),
    Nine(Window9),
    Eighteen(Window18),
    OfStated(WindowOfHardware),
}

/// Windows in their place, to be reset.
macro_rules! in_place {
    ($($function:ident: $variant:ident($window:ty)),+) => {
        impl AnyEstimator {
            $(
                #[inline(never)]
                fn $function(&mut self, wheels: WheelArray<f32, WHEELS>) -> Option<&mut $window> {
                    if !matches!(self, Self::$variant(_)) {
                        *self = Self::$variant(<$window>::in_place(wheels));
                    }
                    match self {
                        Self::$variant(window) => Some(window),
                        _ => None,
                    }
                }
            )+
        }
    };
}

in_place! {
    nine: Nine(Window9), eighteen: Eighteen(Window18), of_stated: OfStated(WindowOfHardware)
}

impl AnyEstimator {
    /// `joint-ekf`, started.
    fn joint(
        &mut self,
        config: joint_ekf::Config<f32>,
        wheels: WheelArray<f32, WHEELS>,
    ) -> Result<Option<&mut JointEkf>, ConfigError> {
        config.validate()?;
        self.place_joint(config, wheels);
        let Self::Joint(filter) = self else { return Ok(None) };
        filter.complete();
        Ok(Some(filter))
    }

    #[inline(never)]
    fn place_joint(&mut self, config: joint_ekf::Config<f32>, wheels: WheelArray<f32, WHEELS>) {
        *self = Self::Joint(JointEkf::in_place(config, wheels));
    }

    /// `joint-ekf` for stated hardware, started.
    fn of_hardware(
        &mut self,
        config: joint_ekf::Config<f32>,
        wheels: WheelArray<f32, WHEELS>,
    ) -> Result<Option<&mut JointEkfOfHardware>, ConfigError> {
        config.validate()?;
        self.place_of_hardware(config, wheels);
        let Self::OfHardware(filter) = self else { return Ok(None) };
        filter.consider(&HARDWARE, &Disturbance::none())?;
        filter.complete();
        Ok(Some(filter))
    }

    #[inline(never)]
    fn place_of_hardware(
        &mut self,
        config: joint_ekf::Config<f32>,
        wheels: WheelArray<f32, WHEELS>,
    ) {
        *self = Self::OfHardware(JointEkfOfHardware::in_place(config, wheels));
    }

    /// `ekf-sgf-rls`, started.
    fn regression(
        &mut self,
        config: ekf_sgf::Config<f32>,
        wheels: WheelArray<f32, WHEELS>,
    ) -> Result<Option<&mut EkfSgfRls>, ConfigError> {
        let rate = EkfSgfRls::check(&config)?;
        self.place_regression(config, &rate, wheels);
        let Self::Regression(estimator) = self else { return Ok(None) };
        Ok(Some(estimator))
    }

    #[inline(never)]
    fn place_regression(
        &mut self,
        config: ekf_sgf::Config<f32>,
        rate: &ekf_sgf::rate_ekf::RateEkf<f32>,
        wheels: WheelArray<f32, WHEELS>,
    ) {
        *self = Self::Regression(EkfSgfRls::of_valid(config, rate, wheels));
    }
}

/// An estimator with its next slice of work.
trait Sliced: Step + Work {
    /// Kind of the next slice; `None` where nothing is left, or where all is done in the step.
    fn next_slice(&self) -> Option<Slice> {
        None
    }
}

impl<const U: usize, const C: usize> Sliced for Window<f32, WHEELS, BLOCKS, U, C>
where
    Self: Step + Work,
{
    fn next_slice(&self) -> Option<Slice> {
        Window::next_slice(self)
    }
}

impl Sliced for JointEkf {}
impl Sliced for JointEkfOfHardware {}
impl Sliced for EkfSgfRls {}

struct Bench<'a> {
    counter: &'a mut Counter,
    tally: &'a mut Tally,
    slices: &'a mut SliceTally,
}

impl Bench<'_> {
    /// Counts an estimator in `place`, started again by `begin` for each flight.
    fn fly<E: Sliced>(
        &mut self,
        name: &'static str,
        place: &mut AnyEstimator,
        begin: impl Fn(&mut AnyEstimator) -> Result<Option<&mut E>, ConfigError>,
    ) -> Result<(), ConfigError> {
        if let Some(estimator) = begin(place)? {
            self.count(name, "recorded", flights::recorded(), estimator);
        }
        let others: &[_] = &[&flights::MISSION, &flights::TUMBLE];
        for plan in if cfg!(feature = "one-flight") { &[] } else { others } {
            let flight = Flight::new(plan, CRAFT.wheels()?);
            if let Some(estimator) = begin(place)? {
                self.count(name, plan.name, flight, estimator);
            }
        }
        Ok(())
    }

    /// Counts and logs one flight.
    fn count<E: Sliced>(
        &mut self,
        name: &'static str,
        flight: &'static str,
        samples: impl Iterator<Item = Sample<f32, WHEELS>>,
        estimator: &mut E,
    ) {
        self.tally.clear();
        self.slices.clear();
        for sample in samples {
            let mut outcome = Outcome::Coasting(Coasting::Aligning);
            let instructions = self.counter.count(|| outcome = step(estimator, &sample));
            self.tally.add_outcome(instructions, &outcome);
            for _ in 0..SLICES_PER_SAMPLE {
                let Some(kind) = estimator.next_slice() else { break };
                let instructions = self.counter.count(|| slice(estimator));
                self.slices.add(kind, instructions);
            }
            self.slices.end_sample(estimator.next_slice().is_some());
        }
        let status = match estimator.estimate().status {
            Status::Converged => "converged",
            Status::Partial => "partial",
            Status::Unobservable => "unobservable",
            Status::Diverged => "diverged",
        };
        self.tally.report(name, flight, status);
        self.slices.report(name, flight);
    }
}

/// One whole step, called as by the flight loop.
#[inline(never)]
fn step<E: Step>(estimator: &mut E, sample: &Sample<f32, WHEELS>) -> Outcome {
    core::hint::black_box(estimator).step_fast(core::hint::black_box(sample))
}

/// One slice of work.
#[inline(never)]
fn slice<E: Work>(estimator: &mut E) {
    let _ = core::hint::black_box(estimator).work_in_slices(1);
}
