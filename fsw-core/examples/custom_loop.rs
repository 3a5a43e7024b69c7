//! A control loop of one's own that owns an estimator of its choice.
//!
//! ```text
//! cargo run -p fsw-core --example custom_loop [window|joint-ekf]
//! ```
//!
//! ```text
//!  gyro ─► RateLoop::step ─► torque command ─► body
//!              │  estimator.step(sample) -> Outcome
//!              ▼
//!          adopt_estimate, every 30 s: Status -> inertia in the feedback, excitation on or off
//! ```
//!
//! The loop is generic over [`Estimator`]. It damps the body rate, adds an excitation while the
//! inertia is unknown, and takes the estimate into its feedback once the status allows it. Each
//! [`Outcome`] is acted on: a rejected sample leaves the last torque, a lockout or a change restarts
//! the excitation.

use fsw_core::dynamics::gyrostat::Gyrostat;
use fsw_core::dynamics::interval::{Drive, DriveHistory};
use fsw_core::dynamics::step::runge_kutta_4;
use fsw_core::estimator::joint_ekf::{self, JointEkfUd};
use fsw_core::estimator::window::{self, Window};
use fsw_core::{ConfigError, Estimator, Inertia, Outcome, Reset, Sample, Status, Vec3, WheelArray};

/// Control period, µs.
const PERIOD_US: u64 = 100_000;
/// Control period, s.
const PERIOD_S: f32 = 0.1;
/// One sigma of the gyro noise, white, per sample, rad/s.
const GYRO_NOISE_RAD_S: f32 = 1e-4;
/// Nominal moment about every axis before the estimate is used, kg m².
const NOMINAL_KG_M2: f32 = 1.0;
/// Bandwidth of the rate loop, rad/s.
const BANDWIDTH_RAD_S: f32 = 0.2;
/// Amplitude of the excitation torque on each axis, N m.
const EXCITATION_N_M: f32 = 0.03;
/// Frequencies of the excitation about x, y and z, rad/s.
const EXCITATION_RAD_S: [f32; 3] = [0.9, 0.6, 0.4];

/// Rate loop with an on-board inertia estimate.
struct RateLoop<E> {
    /// Estimator of the inertia, owned by the loop.
    estimator: E,
    /// Inertia in the feedback; the nominal one until an estimate has converged.
    inertia: Inertia<f32>,
    /// Excitation torque on or off.
    is_exciting: bool,
    /// Last torque command, N m, body axes.
    torque_n_m: Vec3<f32>,
}

impl<E: Estimator<f32, 0>> RateLoop<E> {
    /// Loop with the nominal inertia, excitation on.
    fn new(estimator: E) -> Self {
        let inertia = Inertia::spherical(NOMINAL_KG_M2);
        Self { estimator, inertia, is_exciting: true, torque_n_m: Vec3::zeros() }
    }

    /// One period: gyro reading in, torque command out, N m in body axes.
    fn step(&mut self, time_us: u64, gyro_rad_s: Vec3<f32>) -> Vec3<f32> {
        let sample = Sample {
            time_us,
            rate_rad_s: gyro_rad_s,
            wheel_speed_rad_s: [],
            torque_n_m: self.torque_n_m, // the torque that acts at this instant
            attitude: None,
        };
        match self.estimator.step(&sample) {
            Outcome::Updated => {}
            // No new rate: the last torque stays.
            Outcome::Coasting(why) => {
                if !Outcome::Coasting(why).used_sample() {
                    return self.torque_n_m;
                }
            }
            // The body has changed, or the filter diverged: excite again.
            Outcome::Reset(Reset::Lockout | Reset::Changed | Reset::Diverged) => {
                self.is_exciting = true;
            }
            Outcome::Reset(
                Reset::FirstSample
                | Reset::Aligned
                | Reset::Gap
                | Reset::Clock
                | Reset::Interrupted,
            ) => {}
        }
        let rate = self.estimator.rate_rad_s();
        self.torque_n_m = self.inertia.matrix_kg_m2() * rate * -BANDWIDTH_RAD_S;
        if self.is_exciting {
            let t = time_us as f32 * 1e-6;
            self.torque_n_m += Vec3::from(EXCITATION_RAD_S.map(|w| EXCITATION_N_M * (w * t).sin()));
        }
        self.torque_n_m
    }

    /// At a lower rate than [`step`](Self::step): an estimate costs an eigenproblem of six.
    fn adopt_estimate(&mut self) -> Status {
        let estimate = self.estimator.estimate();
        match estimate.status {
            Status::Converged if estimate.inertia.check().is_ok() => {
                self.inertia = estimate.inertia;
                self.is_exciting = false;
            }
            Status::Converged | Status::Partial | Status::Unobservable => {}
            Status::Diverged => self.is_exciting = true,
        }
        estimate.status
    }
}

/// Simulated body: 1.2 to 1.8 kg m², no wheels, a gyro with uniform noise.
struct Body {
    /// Equation of motion.
    gyrostat: Gyrostat<f32>,
    /// Torque between samples.
    drive: DriveHistory<f32>,
    /// True rate, rad/s.
    rate_rad_s: Vec3<f32>,
    /// State of the noise generator.
    noise: u32,
}

impl Body {
    /// True elements, kg m².
    const ELEMENTS_KG_M2: [f32; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];

    fn new() -> Option<Self> {
        let gyrostat = Gyrostat::new(&Inertia::new(Self::ELEMENTS_KG_M2))?;
        let rate_rad_s = Vec3::new(0.02, -0.03, 0.01);
        Some(Self { gyrostat, drive: DriveHistory::default(), rate_rad_s, noise: 1 })
    }

    /// Moves the body over the period that ends with this torque.
    fn advance(&mut self, torque_n_m: Vec3<f32>) {
        let drive = Drive { torque_n_m, wheel_momentum_n_m_s: Vec3::zeros() };
        let interval = self.drive.advance(drive, PERIOD_S);
        self.rate_rad_s = runge_kutta_4(&self.gyrostat, &self.rate_rad_s, &interval);
    }

    /// Gyro reading with uniform noise of the stated sigma, rad/s.
    fn gyro_rad_s(&mut self) -> Vec3<f32> {
        self.rate_rad_s.map(|rate| {
            self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let uniform = (self.noise >> 8) as f32 / (1 << 23) as f32 - 1.0;
            rate + GYRO_NOISE_RAD_S * 3f32.sqrt() * uniform
        })
    }
}

/// Flies two minutes with this estimator and prints a line every 30 s.
fn fly(estimator: impl Estimator<f32, 0>) {
    let Some(mut body) = Body::new() else { return };
    let mut rate_loop = RateLoop::new(estimator);
    for k in 1..=1200 {
        let gyro_rad_s = body.gyro_rad_s();
        let torque_n_m = rate_loop.step(k * PERIOD_US, gyro_rad_s);
        body.advance(torque_n_m);
        if k % 300 == 0 {
            let status = rate_loop.adopt_estimate();
            println!(
                "{:4} s  {status:?}, excitation {}, inertia in the loop {:.3?} kg m²",
                k / 10,
                if rate_loop.is_exciting { "on" } else { "off" },
                rate_loop.inertia.elements_kg_m2()
            );
        }
    }
    println!("true inertia {:.3?} kg m²", Body::ELEMENTS_KG_M2);
}

fn main() -> Result<(), ConfigError> {
    let wheels = WheelArray::new([], [])?;
    match std::env::args().nth(1).as_deref() {
        None | Some("window") => {
            fly(Window::<f32, 0, 512, 9>::new(window::Config::new(GYRO_NOISE_RAD_S), wheels)?);
        }
        Some("joint-ekf") => {
            fly(JointEkfUd::<f32, 0>::new(joint_ekf::Config::new(GYRO_NOISE_RAD_S), wheels)?);
        }
        Some(other) => println!("no estimator named {other}: window or joint-ekf"),
    }
    Ok(())
}
