//! Keys of the stated hardware, and the data-sheet values of a craft file's absent keys.

use crate::key::{
    ANY, FINITE, FLAG, Key, NOT_NEGATIVE, NUMBER, POSITIVE, Range, TABLE, Table, VECTOR,
};

/// Largest share: the linear error model has errors of its square.
const LARGEST_SHARE: f64 = 0.5;
/// Largest angle, deg: small angles.
const LARGEST_ANGLE_DEG: f64 = 10.0;

/// One sigma of a share.
const SHARE_SIGMA: Range =
    Range::new("zero or positive, at most 0.5", |x| (0.0..=LARGEST_SHARE).contains(&x));
/// A share of either sign. With [`ANGLE`], a gyro matrix is diagonally dominant: 0.5 > 2 × 10°.
pub(super) const SHARE: Range = Range::new("above -0.5 and below 0.5", |x| x.abs() < LARGEST_SHARE);
/// One sigma of a small angle.
const ANGLE_SIGMA: Range =
    Range::new("zero or positive, at most 10", |x| (0.0..=LARGEST_ANGLE_DEG).contains(&x));
/// A small angle of either sign.
pub(super) const ANGLE: Range = Range::new("-10 to 10", |x| x.abs() <= LARGEST_ANGLE_DEG);
/// A damping ratio.
const DAMPING_RATIO: Range = Range::new("zero or positive, below 1", |x| (0.0..1.0).contains(&x));

const ZERO_LIST: &str = "zeros";

/// Known scale error of the gyro.
pub const KNOWN_SCALE: Key = Key::required(
    "scale",
    VECTOR,
    "",
    SHARE,
    "Known scale error of each axis, share; corrected: `z = (1 + E) ω`",
)
.or(ZERO_LIST);
/// Known misalignment of the gyro.
pub const KNOWN_AXES: Key = Key::required(
    "axes_deg",
    "6 numbers",
    "deg",
    ANGLE,
    "Known misalignment in the order `xy xz yx yz zx zy` (reading of x from rate about y, …); corrected",
)
.or(ZERO_LIST);
/// Unknown scale error of the gyro.
pub const SCALE_SIGMA: Key = Key::required(
    "scale_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Scale error of each axis, one sigma, share",
)
.or("0.005, assumed");
/// Unknown misalignment of the gyro.
pub const AXES_SIGMA: Key = Key::required(
    "axes_sigma_deg",
    NUMBER,
    "deg",
    ANGLE_SIGMA,
    "Misalignment and non-orthogonality, one sigma of each of six",
)
.or("0.1, assumed");
/// Known delay of the gyro.
pub const DELAY: Key = Key::required(
    "delay_s",
    NUMBER,
    "s",
    FINITE,
    "Known delay d of the gyro: a reading stamped t shows the rate at t − d, wheel speeds and torque \
     are those at t. Positive: the gyro is late",
)
.or("0");
/// Unknown delay of the gyro.
pub const DELAY_SIGMA: Key =
    Key::required("delay_sigma_s", NUMBER, "s", NOT_NEGATIVE, "Unknown part of it, one sigma")
        .or("0.005, assumed");
/// Averaging gyro.
pub const AVERAGED: Key = Key::required(
    "averaged",
    FLAG,
    "",
    ANY,
    "A reading is the mean over the sample interval that ends with it",
)
.or("false");
/// Gyro bias to solve for.
pub const BIAS_SIGMA: Key = Key::required(
    "bias_sigma_rad_s",
    NUMBER,
    "rad/s",
    POSITIVE,
    "Bias of each axis, one sigma; estimated if present",
)
.or("no bias");
/// Bias random walk.
pub const BIAS_WALK: Key = Key::required(
    "bias_walk_rad_s_sqrt_s",
    NUMBER,
    "(rad/s)/√s",
    NOT_NEGATIVE,
    "Random walk of the bias: one sigma per axis after 1 s",
)
.or("0");
/// Bias instability.
pub const BIAS_INSTABILITY: Key = Key::required(
    "bias_instability_rad_s",
    NUMBER,
    "rad/s",
    NOT_NEGATIVE,
    "Bias instability: floor of the Allan deviation. 1 deg/h is 4.848e-6 rad/s",
)
.or("0");
/// Error of the clock.
pub const CLOCK_SIGMA: Key = Key::required(
    "clock_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error of the rate of the clock that stamps the samples, one sigma, share. 100 ppm is 1e-4",
)
.or("0");
/// Error of the stated noise.
pub const NOISE_TOLERANCE: Key = Key::required(
    "noise_tolerance",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error of `noise_rad_s`, one sigma, share",
)
.or("0.2, assumed");

/// Error of one wheel's spin inertia.
pub const SPIN_INERTIA_SIGMA: Key = Key::required(
    "spin_inertia_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error of the spin inertia, one sigma, share",
)
.or("that of `[wheels]`");
/// Tilt of one wheel's axis.
pub const AXIS_SIGMA: Key = Key::required(
    "axis_sigma_deg",
    NUMBER,
    "deg",
    ANGLE_SIGMA,
    "Tilt of the axis, one sigma in each of two directions",
)
.or("that of `[wheels]`");
/// Error of each wheel's spin inertia.
pub const EACH_SPIN_INERTIA_SIGMA: Key = Key::required(
    "spin_inertia_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error of the spin inertia of each wheel, independent of the others, one sigma, share",
)
.or("0.01, assumed");
/// Tilt of each wheel's axis.
pub const EACH_AXIS_SIGMA: Key = Key::required(
    "axis_sigma_deg",
    NUMBER,
    "deg",
    ANGLE_SIGMA,
    "Tilt of the axis of each wheel, one sigma in each of two directions",
)
.or("0.2, assumed");
/// Common error of all spin inertias.
pub const COMMON_SPIN_INERTIA_SIGMA: Key = Key::required(
    "common_spin_inertia_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error that all spin inertias have in common, as of wheels of one make, one sigma, share",
)
.or("0");
/// Scale error of the torque.
pub const TORQUE_SCALE_SIGMA: Key = Key::required(
    "scale_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "External torque: scale error common to its axes, one sigma, share",
)
.or("0.05, assumed");
/// Disturbance torque to solve for.
pub const TORQUE_SIGMA: Key = Key::required(
    "torque_sigma_n_m",
    NUMBER,
    "N m",
    POSITIVE,
    "Constant disturbance torque about each axis, one sigma; estimated if present",
)
.or("that of the estimator");
/// Torque of fields.
pub const VARYING_TORQUE_SIGMA: Key = Key::required(
    "varying_torque_sigma_n_m",
    NUMBER,
    "N m",
    NOT_NEGATIVE,
    "Torque that varies as the body turns (magnetic dipole, gravity gradient, air), one sigma about each axis; estimated \
     if above zero",
)
.or("0");
/// Turn of gyro and wheels as one.
pub const MOUNT_SIGMA: Key = Key::required(
    "sigma_deg",
    VECTOR,
    "deg",
    ANGLE_SIGMA,
    "Turn of gyro and wheels as one against the axes in which the tensor is wanted, about each axis, one sigma",
)
.or(ZERO_LIST);
const FREQUENCY: Key =
    Key::required("frequency_hz", NUMBER, "Hz", POSITIVE, "Undamped frequency with the body held");
const DAMPING: Key = Key::required("damping", NUMBER, "", DAMPING_RATIO, "Damping ratio");
const FREQUENCY_SIGMA: Key = Key::required(
    "frequency_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error of the frequency, one sigma, share",
)
.or("0.05, assumed");
const DAMPING_SIGMA: Key = Key::required(
    "damping_sigma",
    NUMBER,
    "",
    SHARE_SIGMA,
    "Error of the damping ratio, one sigma, share",
)
.or("0.25, assumed");

/// Tachometers of all wheels.
pub const EACH_TACHOMETER: Key =
    Key::required("tachometer", TABLE, "", ANY, "Tachometers of all wheels").or("ideal");
/// Tachometer of one wheel.
pub const TACHOMETER: Key =
    Key::required("tachometer", TABLE, "", ANY, "Tachometer").or("that of `[wheels]`");

/// The keys of `[wheels]`.
pub const WHEELS_TABLE: Table = Table {
    header: "[wheels]",
    about: "Errors of all wheels. Those of a single wheel are keys of its `[[wheel]]`. Optional.",
    keys: &[EACH_SPIN_INERTIA_SIGMA, EACH_AXIS_SIGMA, COMMON_SPIN_INERTIA_SIGMA, EACH_TACHOMETER],
};
/// The keys of `[torque]` in a craft file.
pub const TORQUE_TABLE: Table = Table {
    header: "[torque]",
    about: "The torque columns of the log. Optional.",
    keys: &[TORQUE_SCALE_SIGMA],
};
/// The keys of `[mount]`.
pub const MOUNT_TABLE: Table = Table {
    header: "[mount]",
    about: "A unit of gyro and wheels on a body: no motion shows how it is turned, and the tensor turns with it. \
            Optional.",
    keys: &[MOUNT_SIGMA],
};
/// The keys of `[[mode]]`.
pub const MODE_TABLE: Table = Table {
    header: "[[mode]]",
    about: "A flexible appendage or a sloshing liquid, as a linear oscillator. Its modal inertia is \
            an unknown of the estimator. Optional.",
    keys: &[FREQUENCY, DAMPING, FREQUENCY_SIGMA, DAMPING_SIGMA],
};

pub(super) const MODE_FREQUENCY: Key = FREQUENCY;
pub(super) const MODE_DAMPING: Key = DAMPING;
pub(super) const MODE_FREQUENCY_SIGMA: Key = FREQUENCY_SIGMA;
pub(super) const MODE_DAMPING_SIGMA: Key = DAMPING_SIGMA;

/// Value of a key that a craft file leaves out.
#[derive(Clone, Copy, Debug)]
pub struct Assumption {
    /// Path of the key.
    pub path: &'static str,
    /// The key; its default has the value in words.
    pub key: Key,
    /// The value, in the unit of the key.
    pub value: f64,
    /// Class of hardware and source of the value.
    pub source: &'static str,
}

/// Values of keys that a craft file leaves out: consumer MEMS gyro, small reaction wheels, thrusters.
///
/// A data sheet gives a limit rather than a sigma; the limit is taken as two sigma.
pub const DATA_SHEET: [Assumption; 9] = [
    Assumption {
        path: "gyro.scale_sigma",
        key: SCALE_SIGMA,
        value: 0.005,
        source: "BMI088 class: sensitivity tolerance ±1 % (BST-BMI088-DS001); STIM300 class: 500 ppm",
    },
    Assumption {
        path: "gyro.axes_sigma_deg",
        key: AXES_SIGMA,
        value: 0.1,
        source: "mounting and die, aligned once: 0.05° to 0.5°",
    },
    Assumption {
        path: "gyro.delay_sigma_s",
        key: DELAY_SIGMA,
        value: 0.005,
        source: "group delay of the low-pass filter, 5 to 20 ms at 12 to 47 Hz, and the bus",
    },
    Assumption {
        path: "gyro.noise_tolerance",
        key: NOISE_TOLERANCE,
        value: 0.2,
        source: "noise density is a typical value, at one bandwidth",
    },
    Assumption {
        path: "wheel.spin_inertia_sigma",
        key: EACH_SPIN_INERTIA_SIGMA,
        value: 0.01,
        source: "rotor inertia from drawing or spin-down test: 1 to 3 %",
    },
    Assumption {
        path: "wheel.axis_sigma_deg",
        key: EACH_AXIS_SIGMA,
        value: 0.2,
        source: "mounting and bearing: 0.1° to 0.5°",
    },
    Assumption {
        path: "torque.scale_sigma",
        key: TORQUE_SCALE_SIGMA,
        value: 0.05,
        source: "thrust from a blow-down table, or dipole and field: ±10 %",
    },
    Assumption {
        path: "mode.frequency_sigma",
        key: FREQUENCY_SIGMA,
        value: 0.05,
        source: "model correlated with a modal survey: first modes to ±5 to 10 %",
    },
    Assumption {
        path: "mode.damping_sigma",
        key: DAMPING_SIGMA,
        value: 0.25,
        source: "damping depends on amplitude and temperature: ±50 %",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_of_each_key_in_words_is_its_value() {
        for Assumption { path, key, value, .. } in DATA_SHEET {
            assert_eq!(key.default, Some(format!("{value}, assumed").as_str()), "{path}");
            assert!((key.range.contains)(value), "{path}");
            assert!(path.ends_with(key.name), "{path}");
        }
    }
}
