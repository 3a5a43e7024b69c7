//! The estimators as they fly, each on each flight.

use crate::tally::Tally;
use core::cell::RefCell;
use critical_section::Mutex;
use fsw_core::estimator::Prior;
use fsw_core::estimator::chain::{self, Chain};
use fsw_core::estimator::joint_ekf::{self, JointEkfUd};
use fsw_core::estimator::window::{self, Window};
use fsw_core::{ConfigError, Estimator, Sample, Vec3, WheelArray};
use fsw_target::instructions::InstructionCounter;
use fsw_target::recording::Row;
use fsw_target::recording::cubesat_pyramid::{CRAFT, ROWS, WHEELS};

/// Blocks that a window stores in flight.
const BLOCKS: usize = 512;

/// What the window may be asked for besides: one sigma of the ranges that are searched, far above
/// what a small satellite has.
const DISTURBANCE_TORQUE_N_M: f32 = 1e-4;
const GYRO_BIAS_RAD_S: f32 = 1e-2;

/// What a drawing of this CubeSat might say: moments a tenth off, no products.
const PRIOR: Prior<f32> = Prior {
    inertia_kg_m2: [0.06, 0.1, 0.11, 0.0, 0.0, 0.0],
    sigma_kg_m2: [0.006, 0.01, 0.01, 0.004, 0.004, 0.004],
};

type Place<E> = Mutex<RefCell<Option<E>>>;

/// Too large for the stack.
static WINDOW_9: Place<Window<f32, WHEELS, BLOCKS, 9>> = Mutex::new(RefCell::new(None));
static WINDOW_15: Place<Window<f32, WHEELS, BLOCKS, 15>> = Mutex::new(RefCell::new(None));

/// Flies them one after the other; one line of the log for each.
pub fn fly_all(counter: &InstructionCounter) -> Result<(), ConfigError> {
    let wheels = WheelArray::new(CRAFT.wheel_axes.map(Vec3::from), CRAFT.spin_inertia_kg_m2)?;
    let noise = CRAFT.gyro_noise_rad_s;

    let config = joint_ekf::Config::new(noise);
    fly(counter, "joint-ekf", &mut JointEkfUd::<f32, WHEELS>::new(config, wheels)?);
    let config = joint_ekf::Config { prior: Some(PRIOR), ..config };
    fly(counter, "joint-ekf-prior", &mut JointEkfUd::<f32, WHEELS>::new(config, wheels)?);

    let config = chain::Config::kim_2013(noise, PRIOR);
    fly(counter, "ekf-sgf-rls", &mut Chain::<f32, WHEELS>::new(config, wheels)?);

    let config = window::Config::new(noise);
    fly_in(counter, "window-9", &WINDOW_9, Window::new(config, wheels)?);
    let config = window::Config {
        disturbance_torque_n_m: Some(DISTURBANCE_TORQUE_N_M),
        gyro_bias_rad_s: Some(GYRO_BIAS_RAD_S),
        ..config
    };
    fly_in(counter, "window-15", &WINDOW_15, Window::new(config, wheels)?);
    Ok(())
}

fn fly_in<E: Estimator<f32, WHEELS>>(
    counter: &InstructionCounter,
    name: &'static str,
    place: &Place<E>,
    estimator: E,
) {
    critical_section::with(|cs| {
        let mut place = place.borrow_ref_mut(cs);
        fly(counter, name, place.insert(estimator));
    });
}

fn fly<E: Estimator<f32, WHEELS>>(
    counter: &InstructionCounter,
    name: &'static str,
    estimator: &mut E,
) {
    let mut tally = Tally::<{ ROWS.len() }>::new();
    for row in &ROWS {
        let sample = sample(row);
        tally.add(counter.count(|| step(estimator, &sample)));
    }
    tally.report(name, "recorded");
}

/// One whole step, as the flight loop calls it.
#[inline(never)]
fn step<E: Estimator<f32, WHEELS>>(estimator: &mut E, sample: &Sample<f32, WHEELS>) {
    let _ = core::hint::black_box(estimator.step(core::hint::black_box(sample)));
}

fn sample(row: &Row<WHEELS>) -> Sample<f32, WHEELS> {
    Sample {
        time_us: row.time_us,
        rate_rad_s: Vec3::from(row.rate_rad_s),
        wheel_speed_rad_s: row.wheel_speed_rad_s,
        torque_n_m: Vec3::from(row.torque_n_m),
        attitude: None,
    }
}
