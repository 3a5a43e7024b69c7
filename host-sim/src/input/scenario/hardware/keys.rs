//! Keys of `[hardware]`.

use flight_input::craft::hardware::TACHOMETER_KEYS;
use flight_input::key::{
    ANY, DIRECTION, FINITE, FLAG, Key, NOT_NEGATIVE, NUMBER, POSITIVE, Range, TABLE as A_TABLE,
    TABLES as REPEATED, Table, VECTOR,
};

const SHARE: Range = Range::new("above -0.5 and below 0.5", |x| x.abs() < 0.5);
const ANGLE: Range = Range::new("-10 to 10", |x| x.abs() <= 10.0);
const PROBABILITY: Range = Range::new("0 to 1", |x| (0.0..=1.0).contains(&x));
const CORRELATION: Range = Range::new("zero or positive, below 1", |x| (0.0..1.0).contains(&x));
const HALF: Range = Range::new("zero or positive, below 0.5", |x| (0.0..0.5).contains(&x));
const PARTS_PER_MILLION: Range = Range::new("-100000 to 100000", |x| x.abs() <= 1e5);
/// Modal inertia. The readers check the sum over the modes.
pub(super) const MODAL_SHARE: Range = Range::new(
    "positive, and small enough for the least moment of the body to stay positive",
    |x| x > 0.0 && x < 1.0,
);

const ZEROS: &str = "zeros";

pub(super) const SCALE: Key =
    Key::required("scale", VECTOR, "", SHARE, "Scale error of each axis, share").or(ZEROS);
pub(super) const AXES: Key = Key::required(
    "axes_deg",
    "6 numbers",
    "deg",
    ANGLE,
    "Misalignment in the order `xy xz yx yz zx zy`: reading of x from rate about y, …",
)
.or(ZEROS);
pub(super) const DELAY: Key = Key::required(
    "delay_s",
    NUMBER,
    "s",
    FINITE,
    "Delay of the gyro beyond the stated one: positive if the gyro is late",
)
.or("0");
pub(super) const LAG: Key = Key::required(
    "lag_s",
    NUMBER,
    "s",
    NOT_NEGATIVE,
    "Time constant of a first-order low-pass filter",
)
.or("0");
pub(super) const AVERAGED: Key = Key::required(
    "averaged",
    FLAG,
    "",
    ANY,
    "A reading is the mean over the sample interval that ends with it, unknown to the estimator",
)
.or("false");
pub(super) const NOISE_FACTOR: Key =
    Key::required("noise_factor", NUMBER, "", POSITIVE, "True noise over the stated one").or("1");
pub(super) const NOISE_CORRELATION: Key = Key::required(
    "noise_correlation",
    NUMBER,
    "",
    CORRELATION,
    "Correlation of the noise of two successive samples (first-order autoregressive)",
)
.or("0");
pub(super) const FLICKER: Key = Key::required(
    "flicker_rad_s",
    NUMBER,
    "rad/s",
    NOT_NEGATIVE,
    "Bias instability: floor of the Allan deviation, from 0.3 s to 300 s",
)
.or("0");
pub(super) const OUTLIER_SHARE: Key = Key::required(
    "outlier_share",
    NUMBER,
    "",
    PROBABILITY,
    "Probability of an outlier, per sample and axis",
)
.or("0");
pub(super) const OUTLIER_SIGMA: Key = Key::required(
    "outlier_sigma",
    "2 numbers",
    "",
    NOT_NEGATIVE,
    "Least and largest size of an outlier, sigmas of the stated noise; of either sign",
)
.or("`[10, 50]`");

const GYRO_TABLE: Table = Table {
    header: "[hardware.gyro]",
    about: "True errors of the gyro. Optional.",
    keys: &[
        SCALE,
        AXES,
        DELAY,
        LAG,
        AVERAGED,
        NOISE_FACTOR,
        NOISE_CORRELATION,
        FLICKER,
        OUTLIER_SHARE,
        OUTLIER_SIGMA,
    ],
};

pub(super) const DRIFT: Key = Key::required(
    "drift_ppm",
    NUMBER,
    "1e-6",
    PARTS_PER_MILLION,
    "True time elapsed over that of the stamps, less 1",
)
.or("0");
pub(super) const JITTER: Key = Key::required(
    "jitter",
    NUMBER,
    "",
    HALF,
    "Half-width of the uniform error of a sample's time, share of the period; not in the stamp",
)
.or("0");

const CLOCK_TABLE: Table = Table {
    header: "[hardware.clock]",
    about: "Errors of the time stamps. Optional.",
    keys: &[DRIFT, JITTER],
};

pub(super) const SPIN_INERTIA: Key =
    Key::required("spin_inertia", NUMBER, "", SHARE, "Error of the spin inertia, share").or("0");
pub(super) const AXIS_TILT: Key = Key::required(
    "axis_deg",
    "2 numbers",
    "deg",
    ANGLE,
    "Tilt of the axis a along e₁ = a × ê, ê the coordinate axis of its least component, and e₂ = a × e₁",
)
.or(ZEROS);
pub(super) const STATIC_IMBALANCE: Key = Key::required(
    "static_imbalance_kg_m",
    NUMBER,
    "kg m",
    NOT_NEGATIVE,
    "Mass of the rotor times its offset from the axis",
)
.or("0");
pub(super) const POSITION: Key = Key::required(
    "position_m",
    VECTOR,
    "m",
    FINITE,
    "Centre of the rotor from the centre of mass: lever of the static imbalance",
)
.or(ZEROS);
pub(super) const DYNAMIC_IMBALANCE: Key = Key::required(
    "dynamic_imbalance_kg_m2",
    NUMBER,
    "kg m²",
    NOT_NEGATIVE,
    "Product of inertia of the rotor about its axis",
)
.or("0");

const WHEEL_TABLE: Table = Table {
    header: "[[hardware.wheel]]",
    about: "True errors of a wheel, in the order of the `[[wheel]]` tables and at most as many. \
            Optional.",
    keys: &[SPIN_INERTIA, AXIS_TILT, STATIC_IMBALANCE, POSITION, DYNAMIC_IMBALANCE],
};

pub(super) const COMMON_SPIN_INERTIA: Key = Key::required(
    "common_spin_inertia",
    NUMBER,
    "",
    SHARE,
    "Error that all spin inertias have in common, share",
)
.or("0");

const WHEELS_TABLE: Table = Table {
    header: "[hardware.wheels]",
    about: "True error of all wheels. Optional.",
    keys: &[COMMON_SPIN_INERTIA],
};

const TACHOMETER_TABLE: Table = Table {
    header: "[hardware.tachometer]",
    about: "True tachometers of all wheels, in place of the stated ones. `pil` has encoders instead. Optional.",
    keys: TACHOMETER_KEYS,
};

pub(super) const TORQUE_SCALE: Key =
    Key::required("scale", NUMBER, "", SHARE, "True external torque over the commanded, less 1")
        .or("0");

const TORQUE_TABLE: Table = Table {
    header: "[hardware.torque]",
    about: "True error of the commanded external torque. Optional.",
    keys: &[TORQUE_SCALE],
};

pub(super) const ALTITUDE: Key = Key::required(
    "altitude_km",
    NUMBER,
    "km",
    POSITIVE,
    "Height of the circular orbit above the equatorial radius",
);
pub(super) const INCLINATION: Key =
    Key::required("inclination_deg", NUMBER, "deg", FINITE, "Inclination to the inertial xy plane")
        .or("0");
pub(super) const PHASE: Key =
    Key::required("phase_deg", NUMBER, "deg", FINITE, "Angle from inertial x at the start").or("0");
pub(super) const GRAVITY_GRADIENT: Key =
    Key::required("gravity_gradient", FLAG, "", ANY, "Gravity-gradient torque acts").or("true");
pub(super) const DIPOLE: Key = Key::required(
    "dipole_a_m2",
    VECTOR,
    "A m²",
    FINITE,
    "Residual magnetic dipole of the body, in the field of a dipole along inertial z",
)
.or(ZEROS);
pub(super) const AIR_DENSITY: Key =
    Key::required("air_density_kg_m3", NUMBER, "kg/m³", NOT_NEGATIVE, "Density of the air").or("0");
pub(super) const DRAG_AREA: Key = Key::required(
    "drag_area_m2",
    NUMBER,
    "m²",
    NOT_NEGATIVE,
    "Area against the flow; drag coefficient 2.2",
)
.or("0");
pub(super) const PRESSURE_CENTRE: Key = Key::required(
    "pressure_centre_m",
    VECTOR,
    "m",
    FINITE,
    "Centre of pressure from the centre of mass",
)
.or(ZEROS);

const ORBIT_TABLE: Table = Table {
    header: "[hardware.orbit]",
    about: "A circular orbit, whose environment exerts torques on the body. Optional.",
    keys: &[
        ALTITUDE,
        INCLINATION,
        PHASE,
        GRAVITY_GRADIENT,
        DIPOLE,
        AIR_DENSITY,
        DRAG_AREA,
        PRESSURE_CENTRE,
    ],
};

pub(super) const PULSE_TIME: Key =
    Key::required("time_s", NUMBER, "s", NOT_NEGATIVE, "Start since the start of the flight");
pub(super) const PULSE_DURATION: Key =
    Key::required("duration_s", NUMBER, "s", POSITIVE, "Duration");
pub(super) const PULSE_TORQUE: Key =
    Key::required("torque_n_m", VECTOR, "N m", FINITE, "Torque on the body");

const PULSE_TABLE: Table = Table {
    header: "[[hardware.pulse]]",
    about: "A thruster pulse that is not in the log. Optional.",
    keys: &[PULSE_TIME, PULSE_DURATION, PULSE_TORQUE],
};

pub(super) const FREQUENCY: Key =
    Key::required("frequency_hz", NUMBER, "Hz", POSITIVE, "Undamped frequency with the body held");
pub(super) const DAMPING: Key = Key::required("damping", NUMBER, "", CORRELATION, "Damping ratio");
pub(super) const INERTIA_SHARE: Key = Key::required(
    "inertia_share",
    NUMBER,
    "",
    MODAL_SHARE,
    "Modal inertia over the body's moment about the axis",
);
pub(super) const MODE_AXIS: Key =
    Key::required("axis", VECTOR, "", DIRECTION, "Axis of the rotation that excites it")
        .or("drawn by the seed");

const MODE_TABLE: Table = Table {
    header: "[[hardware.mode]]",
    about: "A flexible appendage or a sloshing liquid of the true body. The inertia of the body \
            includes it at rest. Optional.",
    keys: &[FREQUENCY, DAMPING, INERTIA_SHARE, MODE_AXIS],
};

const ROOT: Table = Table {
    header: "[hardware]",
    about: "True errors of the hardware, unknown to the estimator. Optional.",
    keys: &[
        Key::required("gyro", A_TABLE, "", ANY, "Gyro").or("ideal"),
        Key::required("clock", A_TABLE, "", ANY, "Clock of the samples").or("ideal"),
        Key::required("wheel", REPEATED, "", ANY, "Each wheel").or("ideal"),
        Key::required("wheels", A_TABLE, "", ANY, "All wheels").or("ideal"),
        Key::required("tachometer", A_TABLE, "", ANY, "Tachometers").or("the stated ones"),
        Key::required("torque", A_TABLE, "", ANY, "Commanded external torque").or("ideal"),
        Key::required("orbit", A_TABLE, "", ANY, "Orbit").or("none"),
        Key::required("pulse", REPEATED, "", ANY, "Thruster pulses").or("none"),
        Key::required("mode", REPEATED, "", ANY, "Flexible modes and slosh").or("rigid body"),
    ],
};

/// The tables of `[hardware]`.
pub(in super::super) const TABLES: [Table; 10] = [
    ROOT,
    GYRO_TABLE,
    CLOCK_TABLE,
    WHEEL_TABLE,
    WHEELS_TABLE,
    TACHOMETER_TABLE,
    TORQUE_TABLE,
    ORBIT_TABLE,
    PULSE_TABLE,
    MODE_TABLE,
];
