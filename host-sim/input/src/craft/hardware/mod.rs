//! Stated hardware: errors of gyro, wheels and torque as one sigma each, in craft files and
//! scenarios.
//!
//! ```text
//! CRAFT.toml ────┐
//!                ├──► Statements ──► StatedHardware ──► estimator: considered or solved
//! SCENARIO.toml ─┘                        └──────────► simulator: truth of a run, by its seed
//! ```
//!
//! An absent key has the value of [`DATA_SHEET`] in a craft file, where it is listed in
//! [`StatedHardware::assumed`], and zero in a scenario.
//!
//! Error model, with `ω` the body rate and `z` the reading, both in body axes, rad/s:
//!
//! ```text
//! z(t)  = (1 + E) ω(t − d) + b,   E = [ s_x  a_xy a_xz ]
//!                                     [ a_yx s_y  a_yz ]
//!                                     [ a_zx a_zy s_z  ]
//! h_w(t) = Σ Iₛᵢ (1 + εᵢ + ε_c) Ωᵢ(t) (aᵢ + θᵢ₁ e₁ + θᵢ₂ e₂)
//! τ(t)  = (1 + g) τ_stated(t)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `s` | gyro scale error of each axis | 1 |
//! | `a` | misalignment and non-orthogonality, in the order `xy xz yx yz zx zy` | rad |
//! | `d` | delay of the gyro against wheel speeds and torque; positive if the gyro is late | s |
//! | `b` | gyro bias | rad/s |
//! | `εᵢ`, `ε_c` | error of each spin inertia, and of all in common | 1 |
//! | `θᵢ` | tilt of each wheel axis along the directions of [`tilt_directions`] | rad |
//! | `g` | scale error of the torque, the same for all axes | 1 |

mod keys;
mod read;
mod tachometer;
mod write;

use nalgebra::{Matrix3, Vector3};

pub use keys::{
    AVERAGED, AXES_SIGMA, AXIS_SIGMA, Assumption, BIAS_INSTABILITY, BIAS_SIGMA, BIAS_WALK,
    CLOCK_SIGMA, COMMON_SPIN_INERTIA_SIGMA, DATA_SHEET, DELAY, DELAY_SIGMA, EACH_AXIS_SIGMA,
    EACH_SPIN_INERTIA_SIGMA, EACH_TACHOMETER, KNOWN_AXES, KNOWN_SCALE, MODE_TABLE, MOUNT_SIGMA,
    MOUNT_TABLE, NOISE_TOLERANCE, SCALE_SIGMA, SPIN_INERTIA_SIGMA, TACHOMETER, TORQUE_SCALE_SIGMA,
    TORQUE_SIGMA, TORQUE_TABLE, VARYING_TORQUE_SIGMA, WHEELS_TABLE,
};
pub use read::{
    GyroStatements, ModeFile, MountFile, Statements, TorqueScaleFile, Unstated, WheelStatements,
    WheelsFile,
};
pub use tachometer::{
    TACHOMETER_KEYS, TACHOMETER_TABLE, TACHOMETERS_TABLE, Tachometer, TachometerFile,
    TachometerKind,
};

/// Errors of the hardware as known to the estimator: known parts, and one sigma of the rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedHardware {
    /// Known scale error of each gyro axis, share: corrected in the readings.
    pub gyro_scale: [f64; 3],
    /// Known misalignment of the gyro in the order `xy xz yx yz zx zy`, rad: corrected in the
    /// readings.
    pub gyro_axes_rad: [f64; 6],
    /// Scale error of a gyro axis, one sigma, share.
    pub gyro_scale_sigma: f64,
    /// Each of the six misalignments of the gyro, one sigma, rad.
    pub gyro_axes_sigma_rad: f64,
    /// Known delay of the gyro, s: a reading stamped `t` shows the rate at `t − delay`, wheel speeds
    /// and torque are those at `t`. Not corrected in the log: the mean of the estimator's time offset.
    pub gyro_delay_s: f64,
    /// Unknown part of the delay, one sigma, s.
    pub gyro_delay_sigma_s: f64,
    /// A reading is the mean over the sample interval that ends with it.
    pub gyro_averaged: bool,
    /// Error of the stated gyro noise, one sigma, share.
    pub gyro_noise_tolerance: f64,
    /// Error of the rate of the clock that stamps the samples, one sigma, share.
    pub clock_sigma: f64,
    /// Gyro bias of each axis, one sigma, rad/s; an unknown of the estimator if present.
    pub bias_sigma_rad_s: Option<f64>,
    /// Random walk of the bias: one sigma per axis after 1 s, (rad/s)/√s.
    pub bias_walk_rad_s_sqrt_s: f64,
    /// Instability of the bias, floor of its Allan deviation, rad/s.
    pub bias_instability_rad_s: f64,
    /// Error of each wheel's spin inertia, one sigma, share; independent from wheel to wheel.
    pub wheel_spin_inertia_sigma: Vec<f64>,
    /// Tilt of each wheel's axis along each of its two [`tilt_directions`], one sigma, rad.
    pub wheel_axis_sigma_rad: Vec<f64>,
    /// Tachometer of each wheel.
    pub tachometers: Vec<Tachometer>,
    /// Error that all spin inertias have in common, one sigma, share.
    pub common_spin_inertia_sigma: f64,
    /// Scale error of the external torque, the same for all axes, one sigma, share.
    pub torque_scale_sigma: f64,
    /// Constant disturbance torque about each axis, one sigma, N m; an unknown of the estimator if
    /// present.
    pub torque_sigma_n_m: Option<f64>,
    /// Torque of fields about each axis, which varies as the body turns against them, one sigma, N m; an unknown of the
    /// estimator if not zero.
    pub varying_torque_sigma_n_m: f64,
    /// Turn of gyro and wheels as one against the axes of the tensor, about each axis, one sigma, rad.
    pub mount_sigma_rad: [f64; 3],
    /// Flexible modes and sloshing liquids, each an unknown of the estimator.
    pub modes: Vec<Mode>,
    /// Keys of [`DATA_SHEET`] that the craft file leaves out and that took the value there.
    pub assumed: Vec<&'static str>,
}

/// An oscillator of stated frequency and damping, of unknown modal inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Undamped frequency with the body held, Hz.
    pub frequency_hz: f64,
    /// Damping ratio, 0 to 1.
    pub damping: f64,
    /// Error of the frequency, one sigma, share.
    pub frequency_sigma: f64,
    /// Error of the damping ratio, one sigma, share.
    pub damping_sigma: f64,
}

impl StatedHardware {
    /// Ideal hardware with this number of wheels.
    pub fn ideal(wheels: usize) -> Self {
        Self {
            wheel_spin_inertia_sigma: vec![0.0; wheels],
            wheel_axis_sigma_rad: vec![0.0; wheels],
            tachometers: vec![Tachometer::default(); wheels],
            ..Self::default()
        }
    }

    /// True if every known error and every sigma is zero, and no mode is stated.
    pub fn is_ideal(&self) -> bool {
        *self == Self::ideal(self.wheel_spin_inertia_sigma.len())
    }

    /// `1 + E` of the known part of the gyro's error.
    pub fn known_gyro_matrix(&self) -> Matrix3<f64> {
        gyro_matrix(&self.gyro_scale, &self.gyro_axes_rad)
    }

    /// Body rate of a reading: `(1 + E)⁻¹ z` with the known part of the error, rad/s. Readings of a
    /// gyro without known error are unchanged to the last bit.
    pub fn corrected_rate_rad_s(&self, reading_rad_s: &Vector3<f64>) -> Vector3<f64> {
        if self.gyro_scale == [0.0; 3] && self.gyro_axes_rad == [0.0; 6] {
            return *reading_rad_s;
        }
        // The ranges of the keys make the matrix diagonally dominant, hence invertible.
        self.known_gyro_matrix()
            .try_inverse()
            .map_or(*reading_rad_s, |inverse| inverse * reading_rad_s)
    }
}

/// `1 + E` of a gyro with these scale errors, shares, and misalignments in the order
/// `xy xz yx yz zx zy`, rad.
pub fn gyro_matrix(scale: &[f64; 3], axes_rad: &[f64; 6]) -> Matrix3<f64> {
    let [x, y, z] = *scale;
    let [xy, xz, yx, yz, zx, zy] = *axes_rad;
    Matrix3::new(1.0 + x, xy, xz, yx, 1.0 + y, yz, zx, zy, 1.0 + z)
}

/// The two directions along which the error of a unit axis `a` is stated: `e₁ = a × ê / |a × ê|` with
/// `ê` the coordinate axis of the smallest component of `a`, the first of equals; `e₂ = a × e₁`.
pub fn tilt_directions(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let unit = [Vector3::x(), Vector3::y(), Vector3::z()][axis.iamin()];
    let first = axis.cross(&unit).normalize();
    [first, axis.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correction_inverts_the_known_error() {
        let hardware = StatedHardware {
            gyro_scale: [0.01, -0.02, 0.003],
            gyro_axes_rad: [0.001, 0.002, -0.003, 0.004, 0.005, -0.006],
            ..StatedHardware::default()
        };
        let rate = Vector3::new(0.3, -0.2, 0.5);
        let reading = Vector3::new(
            1.01 * 0.3 + 0.001 * -0.2 + 0.002 * 0.5,
            -0.003 * 0.3 + 0.98 * -0.2 + 0.004 * 0.5,
            0.005 * 0.3 - 0.006 * -0.2 + 1.003 * 0.5,
        );
        assert!((hardware.corrected_rate_rad_s(&reading) - rate).norm() < 1e-15);
        assert_eq!(StatedHardware::default().corrected_rate_rad_s(&reading), reading);
    }

    #[test]
    fn tilt_directions_are_orthonormal_with_the_axis() {
        for axis in [Vector3::x(), -Vector3::z(), Vector3::new(1.0, -1.0, 1.0).normalize()] {
            let [first, second] = tilt_directions(&axis);
            let triad = Matrix3::from_columns(&[axis, first, second]);
            assert!((triad.transpose() * triad - Matrix3::identity()).norm() < 1e-15);
        }
    }
}
