//! `[hardware]` of a scenario: true errors of gyro, clock, wheels, tachometers and torque, and effects
//! that act on the body. All unknown to the estimator.
//!
//! ```toml
//! [hardware.gyro]                 # fixed errors, named as the key of one sigma without `_sigma`
//! scale = [0.005, -0.005, 0.005]
//! lag_s = 0.005                   # and errors that have no sigma
//! [[hardware.wheel]]              # one per [[wheel]], in its order
//! spin_inertia = 0.01
//! [[hardware.mode]]               # a flexible appendage
//! frequency_hz = 0.5
//! damping = 0.01
//! inertia_share = 0.03
//! ```
//!
//! The error model is that of [`flight_input::craft::hardware`]. The errors of a run are the fixed ones
//! plus those drawn from the stated sigmas by the run's seed: see [`draw`](mod@draw).

pub mod draw;
mod keys;
mod read;

use flight_input::craft::hardware::{Tachometer, gyro_matrix, tilt_directions};
use nalgebra::{Matrix3, Unit, Vector3};

use super::wheel::SimulatedWheel;
pub(super) use keys::TABLES;
pub(super) use read::{Carrier, HardwareFile};

/// True errors of a scenario's hardware. The default is ideal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrueHardware {
    /// Gyro.
    pub gyro: GyroErrors,
    /// Clock of the samples.
    pub clock: ClockErrors,
    /// Wheels, in the order of the scenario's; ideal beyond the end of the list.
    pub wheels: Vec<WheelErrors>,
    /// Error that all spin inertias have in common, share.
    pub common_spin_inertia: f64,
    /// Tachometers of all wheels, in place of the stated ones unless ideal.
    pub tachometer: Tachometer,
    /// Scale error of the external torque: the true one is `1 + torque_scale` times the commanded.
    pub torque_scale: f64,
    /// Orbit, for torques of the environment.
    pub orbit: Option<Orbit>,
    /// Thruster pulses that are not in the log.
    pub pulses: Vec<Pulse>,
    /// Flexible appendages and sloshing liquids.
    pub modes: Vec<TrueMode>,
}

/// Errors of the gyro. `z = M y + b + …` with `y` the filtered rate.
#[derive(Clone, Debug, PartialEq)]
pub struct GyroErrors {
    /// Scale error of each axis, share.
    pub scale: Vector3<f64>,
    /// Misalignment in the order `xy xz yx yz zx zy`, rad.
    pub axes_rad: [f64; 6],
    /// Delay, s: a reading stamped `t` shows the rate at `t − delay`. Wheel speeds are without.
    pub delay_s: f64,
    /// Time constant of a first-order low-pass filter, s.
    pub lag_s: f64,
    /// A reading is the mean over the sample interval that ends with it.
    pub averaged: bool,
    /// True noise over the stated one.
    pub noise_factor: f64,
    /// Correlation of the noise of two successive samples, of a first-order autoregressive process
    /// whose standard deviation is that of the white noise.
    pub noise_correlation: f64,
    /// Bias instability: floor of the Allan deviation, rad/s.
    pub flicker_rad_s: f64,
    /// Probability of an outlier, per sample and axis.
    pub outlier_share: f64,
    /// Smallest and largest size of an outlier, sigmas of the stated noise.
    pub outlier_sigma: [f64; 2],
}

impl Default for GyroErrors {
    fn default() -> Self {
        Self {
            scale: Vector3::zeros(),
            axes_rad: [0.0; 6],
            delay_s: 0.0,
            lag_s: 0.0,
            averaged: false,
            noise_factor: 1.0,
            noise_correlation: 0.0,
            flicker_rad_s: 0.0,
            outlier_share: 0.0,
            outlier_sigma: DEFAULT_OUTLIER_SIGMA,
        }
    }
}

/// Size of outliers where none is given, sigmas.
pub(super) const DEFAULT_OUTLIER_SIGMA: [f64; 2] = [10.0, 50.0];

impl GyroErrors {
    /// `1 + E`: reading without bias and noise from the filtered rate.
    pub fn matrix(&self) -> Matrix3<f64> {
        gyro_matrix(&self.scale.into(), &self.axes_rad)
    }
}

/// Errors of the clock that stamps the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockErrors {
    /// Drift: true time elapses `1 + drift` times as fast as the stamps.
    pub drift: f64,
    /// Jitter: each sample is taken within ± this share of the period about its time.
    pub jitter: f64,
}

/// Errors of one wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelErrors {
    /// Error of the spin inertia, share.
    pub spin_inertia: f64,
    /// Tilt of the axis along each of its two [`tilt_directions`], rad.
    pub axis_rad: [f64; 2],
    /// Static imbalance, mass times offset from the axis, kg m.
    pub static_imbalance_kg_m: f64,
    /// Centre of the rotor from the centre of mass, body axes, m: lever of the static imbalance.
    pub position_m: Vector3<f64>,
    /// Dynamic imbalance, product of inertia of the rotor, kg m².
    pub dynamic_imbalance_kg_m2: f64,
}

/// Circular orbit about the Earth, and properties of the body that its environment acts on.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// Height above the equatorial radius, km.
    pub altitude_km: f64,
    /// Inclination to the plane of inertial x and y, rad.
    pub inclination_rad: f64,
    /// Angle from the inertial x axis at the start, rad.
    pub phase_rad: f64,
    /// Gravity-gradient torque acts.
    pub gravity_gradient: bool,
    /// Residual dipole, body axes, A m².
    pub dipole_a_m2: Vector3<f64>,
    /// Density of the air, kg/m³.
    pub air_density_kg_m3: f64,
    /// Area against the flow, m².
    pub drag_area_m2: f64,
    /// Centre of pressure from the centre of mass, body axes, m.
    pub pressure_centre_m: Vector3<f64>,
}

/// A torque for a short time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Start, s.
    pub time_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Torque, body axes, N m.
    pub torque_n_m: Vector3<f64>,
}

/// A linear oscillator coupled to the rotation of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueMode {
    /// Undamped frequency with the body held, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Modal inertia as a share of the body's moment about the axis.
    pub inertia_share: f64,
    /// Axis of the rotation that excites it, body axes; none until drawn.
    pub axis: Option<Unit<Vector3<f64>>>,
}

impl TrueHardware {
    /// Errors of a wheel.
    pub fn wheel(&self, index: usize) -> WheelErrors {
        self.wheels.get(index).copied().unwrap_or_default()
    }

    /// The true wheel for a stated one. Equal to the last bit if its errors are zero.
    pub(super) fn true_wheel(&self, index: usize, stated: &SimulatedWheel) -> SimulatedWheel {
        let errors = self.wheel(index);
        let mut simulated = stated.clone();
        let share = errors.spin_inertia + self.common_spin_inertia;
        simulated.wheel.spin_inertia_kg_m2 *= 1.0 + share;
        if errors.axis_rad != [0.0; 2] {
            let axis = &mut simulated.wheel.axis;
            let [first, second] = tilt_directions(axis);
            let [along_first, along_second] = errors.axis_rad;
            *axis = (*axis + first * along_first + second * along_second).normalize();
        }
        simulated
    }

    /// True if a reading depends on the motion between the samples.
    pub fn needs_trajectory(&self) -> bool {
        let gyro = &self.gyro;
        gyro.delay_s != 0.0
            || gyro.lag_s != 0.0
            || gyro.averaged
            || self.clock != ClockErrors::default()
    }

    /// True if a wheel has an imbalance.
    pub fn has_imbalance(&self) -> bool {
        let is_unbalanced = |wheel: &WheelErrors| {
            wheel.static_imbalance_kg_m != 0.0 || wheel.dynamic_imbalance_kg_m2 != 0.0
        };
        self.wheels.iter().any(is_unbalanced)
    }
}
