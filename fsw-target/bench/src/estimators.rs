//! Instruction counts of the estimators, each on each flight.

use crate::counter::Counter;
use crate::flights::{self, Flight};
use crate::tally::Tally;
use fsw_core::estimator::ekf_sgf::{self, EkfSgf};
use fsw_core::estimator::joint_ekf::{self, JointEkfUd};
use fsw_core::estimator::window::{self, Window};
use fsw_core::{Coasting, Prior};
use fsw_core::{ConfigError, Outcome, Sample, Status, WheelArray};
use fsw_steps::{BLOCKS, Step, Window9, Window12, Window15, Window18};
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

/// Data too large for the stack.
pub struct Places {
    /// Tally of the current flight.
    pub tally: Tally,
    window_9: Option<Window9>,
    window_12: Option<Window12>,
    window_15: Option<Window15>,
    window_18: Option<Window18>,
}

impl Places {
    /// Places without estimators.
    pub const fn new() -> Self {
        Self {
            tally: Tally::new(),
            window_9: None,
            window_12: None,
            window_15: None,
            window_18: None,
        }
    }
}

/// Steps every estimator through every flight, and logs the counts.
pub fn fly_all(counter: &mut Counter, places: &mut Places) -> Result<(), ConfigError> {
    let wheels = CRAFT.wheels()?;
    let noise = CRAFT.gyro_noise_rad_s;
    let Places { tally, window_9, window_12, window_15, window_18 } = places;
    let mut bench = Bench { counter, tally };

    let config = joint_ekf::Config::new(noise);
    let new = |config| move || JointEkfUd::<f32, WHEELS>::new(config, wheels);
    bench.fly_new("joint-ekf", new(config))?;
    let config = joint_ekf::Config { prior: Some(VAGUE), ..config };
    bench.fly_new("joint-ekf-vague", new(config))?;
    let config = joint_ekf::Config { prior: Some(PRIOR), ..config };
    bench.fly_new("joint-ekf-prior", new(config))?;
    let walk = [INERTIA_WALK_KG_M2_SQRT_S; 6];
    let config = joint_ekf::Config { inertia_walk_kg_m2_sqrt_s: walk, ..config };
    bench.fly_new("joint-ekf-walk", new(config))?;

    let config = ekf_sgf::Config::kim_2013(noise, PRIOR);
    bench.fly_new("ekf-sgf-rls", || EkfSgf::<f32, WHEELS>::new(config, wheels))?;

    let config = window::Config::new(noise);
    bench.fly("window-9", window_9, |place| in_place(place, wheels).reset(config))?;
    bench.fly("window-12", window_12, |place| in_place(place, wheels).reset(config))?;
    let config = window::Config {
        disturbance_torque_n_m: Some(DISTURBANCE_TORQUE_N_M),
        gyro_bias_rad_s: Some(GYRO_BIAS_RAD_S),
        ..config
    };
    bench.fly("window-15", window_15, |place| in_place(place, wheels).reset(config))?;
    bench.fly("window-18", window_18, |place| in_place(place, wheels).reset(config))
}

/// The window in this place, built in place: it exceeds the stack.
fn in_place<const U: usize>(
    place: &mut Option<Window<f32, WHEELS, BLOCKS, U>>,
    wheels: WheelArray<f32, WHEELS>,
) -> &mut Window<f32, WHEELS, BLOCKS, U> {
    place.insert(Window::of_unknown_noise(wheels))
}

struct Bench<'a> {
    counter: &'a mut Counter,
    tally: &'a mut Tally,
}

impl Bench<'_> {
    /// Counts an estimator in `place`, started again by `begin` for each flight.
    fn fly<E: Step>(
        &mut self,
        name: &'static str,
        place: &mut Option<E>,
        begin: impl Fn(&mut Option<E>) -> Result<(), ConfigError>,
    ) -> Result<(), ConfigError> {
        begin(place)?;
        if let Some(estimator) = place {
            self.count(name, "recorded", flights::recorded(), estimator);
        }
        let others: &[_] = &[&flights::MISSION, &flights::TUMBLE];
        for plan in if cfg!(feature = "one-flight") { &[] } else { others } {
            let flight = Flight::new(plan, CRAFT.wheels()?);
            begin(place)?;
            if let Some(estimator) = place {
                self.count(name, plan.name, flight, estimator);
            }
        }
        Ok(())
    }

    /// As [`fly`](Self::fly), for an estimator that fits the stack.
    fn fly_new<E: Step>(
        &mut self,
        name: &'static str,
        new: impl Fn() -> Result<E, ConfigError>,
    ) -> Result<(), ConfigError> {
        self.fly(name, &mut None, |place| {
            *place = Some(new()?);
            Ok(())
        })
    }

    /// Counts and logs one flight.
    fn count<E: Step>(
        &mut self,
        name: &'static str,
        flight: &'static str,
        samples: impl Iterator<Item = Sample<f32, WHEELS>>,
        estimator: &mut E,
    ) {
        self.tally.clear();
        for sample in samples {
            let mut outcome = Outcome::Coasting(Coasting::Aligning);
            let instructions = self.counter.count(|| outcome = step(estimator, &sample));
            self.tally.add_outcome(instructions, &outcome);
        }
        let status = match estimator.estimate().status {
            Status::Converged => "converged",
            Status::Partial => "partial",
            Status::Unobservable => "unobservable",
            Status::Diverged => "diverged",
        };
        self.tally.report(name, flight, status);
    }
}

/// One whole step, called as by the flight loop.
#[inline(never)]
fn step<E: Step>(estimator: &mut E, sample: &Sample<f32, WHEELS>) -> Outcome {
    core::hint::black_box(estimator).step_fast(core::hint::black_box(sample))
}
