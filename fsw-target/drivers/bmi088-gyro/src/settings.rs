//! Settings of the gyro in a BMI088: range, data rate, interrupt pin, mounting.

/// Tolerance of each entry of `Rᵀ R − 1` for a rotation `R`: above the rounding of six digits,
/// below a mistyped entry.
const ROTATION_TOLERANCE: f32 = 1.0e-4;

/// Full scale by GYRO_RANGE. A smaller range has a finer quantum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Range {
    /// ±2000 deg/s, 0.061 deg/s per count.
    DegS2000 = 0,
    /// ±1000 deg/s, 0.031 deg/s per count.
    DegS1000 = 1,
    /// ±500 deg/s, 0.015 deg/s per count.
    DegS500 = 2,
    /// ±250 deg/s, 7.6e-3 deg/s per count.
    DegS250 = 3,
    /// ±125 deg/s, 3.8e-3 deg/s per count.
    DegS125 = 4,
}

impl Range {
    /// All ranges, finest first.
    pub const ALL: [Self; 5] =
        [Self::DegS125, Self::DegS250, Self::DegS500, Self::DegS1000, Self::DegS2000];

    /// Range of a register value; `None` for a reserved value.
    pub fn from_register(value: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|range| *range as u8 == value)
    }

    /// Rate at 32768 counts, rad/s.
    pub fn full_scale_rad_s(self) -> f32 {
        let deg_s = match self {
            Self::DegS2000 => 2000.0,
            Self::DegS1000 => 1000.0,
            Self::DegS500 => 500.0,
            Self::DegS250 => 250.0,
            Self::DegS125 => 125.0,
        };
        deg_s * (core::f32::consts::PI / 180.0)
    }

    /// Rate per count, rad/s.
    pub fn quantum_rad_s(self) -> f32 {
        // Exact: the divisor is a power of two.
        self.full_scale_rad_s() / 32_768.0
    }
}

/// Output data rate and bandwidth of its low-pass filter, as GYRO_BANDWIDTH pairs them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Bandwidth {
    /// 2000 samples/s, filter 532 Hz.
    Odr2000Filter532 = 0,
    /// 2000 samples/s, filter 230 Hz.
    Odr2000Filter230 = 1,
    /// 1000 samples/s, filter 116 Hz.
    Odr1000Filter116 = 2,
    /// 400 samples/s, filter 47 Hz.
    Odr400Filter47 = 3,
    /// 200 samples/s, filter 23 Hz.
    Odr200Filter23 = 4,
    /// 100 samples/s, filter 12 Hz.
    Odr100Filter12 = 5,
    /// 200 samples/s, filter 64 Hz.
    Odr200Filter64 = 6,
    /// 100 samples/s, filter 32 Hz.
    Odr100Filter32 = 7,
}

impl Bandwidth {
    /// Bandwidth of the low-pass filter, Hz.
    pub const fn filter_hz(self) -> u32 {
        match self {
            Self::Odr2000Filter532 => 532,
            Self::Odr2000Filter230 => 230,
            Self::Odr1000Filter116 => 116,
            Self::Odr400Filter47 => 47,
            Self::Odr200Filter23 => 23,
            Self::Odr100Filter12 => 12,
            Self::Odr200Filter64 => 64,
            Self::Odr100Filter32 => 32,
        }
    }

    /// Delay of the filter at low frequency, µs: `1/(2π f)`, that of a first-order low-pass filter of the
    /// bandwidth `f`. 5 ms at 32 Hz, 13 ms at 12 Hz. The data sheet gives the bandwidth and no delay: a
    /// filter of higher order has more, and a measured value replaces this one in [`Settings::delay_us`].
    pub const fn delay_us(self) -> u32 {
        // 10⁶/(2π) = 159,155.
        159_155 / self.filter_hz()
    }
}

/// Interrupt pin for a new sample: push-pull, active high.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DataReadyPin {
    /// INT3.
    Int3,
    /// INT4.
    Int4,
}

impl DataReadyPin {
    /// INT3_INT4_IO_CONF with this pin push-pull. The reset value has both pins open-drain (bits 1
    /// and 3) and active high (bits 0 and 2).
    pub(super) fn io_conf(self) -> u8 {
        match self {
            Self::Int3 => 0b1101,
            Self::Int4 => 0b0111,
        }
    }

    /// INT3_INT4_IO_MAP with the data-ready interrupt on this pin.
    pub(super) fn io_map(self) -> u8 {
        match self {
            Self::Int3 => 0x01,
            Self::Int4 => 0x80,
        }
    }
}

/// Configuration and mounting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Range. Default ±125 deg/s, the finest: above the rate of a working spacecraft.
    pub range: Range,
    /// Data rate and filter. Default 100 samples/s, the lowest rate, with the wider of its two
    /// filters, 32 Hz.
    pub bandwidth: Bandwidth,
    /// Interrupt pin. Default INT3.
    pub data_ready: DataReadyPin,
    /// Rotation from sensor axes to body axes, by rows: row i has the components of body axis i in sensor
    /// axes. Default identity.
    pub body_from_sensor: [[f32; 3]; 3],
    /// Delay of a reading, µs. Default that of the filter, [`Bandwidth::delay_us`].
    pub delay_us: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            range: Range::DegS125,
            bandwidth: Bandwidth::Odr100Filter32,
            data_ready: DataReadyPin::Int3,
            body_from_sensor: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            delay_us: Bandwidth::Odr100Filter32.delay_us(),
        }
    }
}

impl Settings {
    /// True if `body_from_sensor` is a proper rotation.
    pub(super) fn is_valid(&self) -> bool {
        is_rotation(&self.body_from_sensor)
    }

    /// A vector of sensor axes, in body axes.
    pub(super) fn to_body(self, sensor: &[f32; 3]) -> [f32; 3] {
        self.body_from_sensor.map(|row| dot(&row, sensor))
    }
}

/// Proper rotation: orthonormal first and second row, and the third row their cross product.
fn is_rotation(rows: &[[f32; 3]; 3]) -> bool {
    let [x, y, z] = rows;
    let is_small = |value: f32| value.abs() < ROTATION_TOLERANCE;
    let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    is_small(dot(x, x) - 1.0)
        && is_small(dot(y, y) - 1.0)
        && is_small(dot(x, y))
        && cross.iter().zip(z).all(|(expected, value)| is_small(expected - value))
}

/// Scalar product.
pub(super) fn dot(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
