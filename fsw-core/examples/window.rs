//! The `window` estimator on a made-up motion: the example of the crate page, with a printout.
//!
//! ```text
//! cargo run -p fsw-core --example window
//! ```

use fsw_core::estimator::window::{Config, Window};
use fsw_core::{ConfigError, Estimator, Inertia, Sample, Status, Vec3, WheelArray};

/// Gyro period, µs.
const PERIOD_US: u64 = 100_000;
/// Frequencies of the motion about x, y and z, rad/s.
const FREQUENCY_RAD_S: [f32; 3] = [0.9, 0.6, 0.4];
/// Amplitude of the motion about each axis, rad/s.
const AMPLITUDE_RAD_S: f32 = 0.05;
/// One sigma of the gyro noise, white, per sample, rad/s.
const GYRO_NOISE_RAD_S: f32 = 1e-4;

fn main() -> Result<(), ConfigError> {
    let truth = Inertia::new([1.5, 1.2, 1.8, 0.1, -0.2, 0.05]); // kg m²
    let j = truth.matrix_kg_m2();
    let w = Vec3::from(FREQUENCY_RAD_S);
    let config = Config { is_torque_smooth: true, ..Config::new(GYRO_NOISE_RAD_S) };
    let mut window = Window::<f32, 0, 512, 9>::new(config, WheelArray::new([], [])?)?;
    for k in 0..600 {
        let t = k as f32 * PERIOD_US as f32 * 1e-6;
        let rate = w.map(|w| AMPLITUDE_RAD_S * (w * t).sin());
        let acceleration = w.map(|w| AMPLITUDE_RAD_S * w * (w * t).cos());
        window.step(&Sample {
            time_us: k * PERIOD_US,
            rate_rad_s: rate,
            wheel_speed_rad_s: [],
            torque_n_m: j * acceleration + rate.cross(&(j * rate)), // the torque of this motion
            attitude: None,
        });
    }
    window.finish();
    let estimate = window.estimate();
    println!("status     {:?}", estimate.status);
    println!("true       {:9.5?} kg m²", truth.elements_kg_m2());
    println!("estimate   {:9.5?} kg m²", estimate.inertia.elements_kg_m2());
    println!("one sigma  {:9.5?} kg m²", estimate.sigma_kg_m2());
    assert_eq!(estimate.status, Status::Converged);
    Ok(())
}
