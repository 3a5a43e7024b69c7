//! Parameters of gyro, wheels and known torque: their errors, each with one sigma.
//!
//! ```text
//! reading        z(t) = (1 + M) ω(t − δ) + b + ν
//! wheel          h_i = Iₛᵢ (1 + sᵢ + s) Ωᵢ (aᵢ + θ₁ e₁ + θ₂ e₂)
//! known torque   τ = (1 + t) τ_known
//! ```
//!
//! | symbol | meaning | unit | [`Hardware`] |
//! |---|---|---|---|
//! | `M_xx M_yy M_zz` | scale factor errors of the gyro | share | `gyro_scale` |
//! | `M_ij` | reading of axis i of a rate about axis j: misalignment and non-orthogonality | rad | `gyro_axes_rad` |
//! | `δ` | time offset: age of the motion in a reading, against wheels and torque of the same time stamp | s | `delay_s`, `delay_sigma_s` |
//! | `sᵢ`, `s` | errors of the spin inertias: of each wheel, and common to all | share | `wheel_inertia`, `common_wheel_inertia` |
//! | `θ₁ θ₂` | tilts of a spin axis, about two directions normal to it ([`tilt_directions`]) | rad | `wheel_axis_rad` |
//! | `t` | error of the known external torque | share | `torque_scale` |
//! | `ε` | error of the clock that stamps the samples: common to parameters above ([`Parameter::by_clock`]) | share | `clock` |
//! | `μ` | turn of all sensors as one: the tensor in the wanted axes is `J + μ^× J − J μ^×` | rad | `mount_rad` |
//!
//! All are constant over the life of an estimator, of zero mean and independent of one another before the data.
//! Their sensitivities, and which of them a motion makes observable, are documented with the estimators
//! ([`window`](crate::estimator::window)).

use crate::error::ConfigError;
use crate::math::{
    Mat, Vec3, column, norm, of_columns,
    range::{not_negative, positive, up_to},
    scalar::Real,
    skew,
};
use crate::tensor::Inertia;

/// Largest stated sigma of a share, or of an angle in rad: ten times the quantity itself. Beyond it a square with
/// another quantity may leave the range of `f32`.
pub const LARGEST_SIGMA: u32 = 10;
/// Largest time offset and its largest sigma, s.
pub const LARGEST_DELAY_S: u32 = 100;

/// Stated errors of the hardware, one sigma each; zero for one that is known exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hardware<T: Real, const W: usize> {
    /// Scale factor of each gyro axis, share.
    pub gyro_scale: T,
    /// Each of the six errors of the gyro's axes, rad.
    pub gyro_axes_rad: T,
    /// Known time offset, s: a gyro reading shows the motion of `delay_s` before its time stamp.
    pub delay_s: T,
    /// Error of it, s.
    pub delay_sigma_s: T,
    /// Spin inertia of each wheel, share.
    pub wheel_inertia: [T; W],
    /// Each of the two tilts of a spin axis, rad.
    pub wheel_axis_rad: [T; W],
    /// Error common to all spin inertias, share.
    pub common_wheel_inertia: T,
    /// Known external torque, share.
    pub torque_scale: T,
    /// Rate of the clock that stamps the samples, share: positive where it is fast.
    pub clock: T,
    /// Turn of gyro and wheels as one against the axes of the tensor, about each axis, rad. No motion shows it: it
    /// turns the tensor and enters its covariance alone.
    pub mount_rad: [T; 3],
}

crate::persist!([T: Real, const W: usize] Hardware<T, W> {
    gyro_scale, gyro_axes_rad, delay_s, delay_sigma_s, wheel_inertia, wheel_axis_rad, common_wheel_inertia, torque_scale,
    clock, mount_rad
});

impl<T: Real, const W: usize> Hardware<T, W> {
    /// Hardware without errors.
    pub fn ideal() -> Self {
        let none = T::zero();
        Self {
            gyro_scale: none,
            gyro_axes_rad: none,
            delay_s: none,
            delay_sigma_s: none,
            wheel_inertia: [none; W],
            wheel_axis_rad: [none; W],
            common_wheel_inertia: none,
            torque_scale: none,
            clock: none,
            mount_rad: [none; 3],
        }
    }

    /// One sigma of a parameter that a clock's error is part of, of its own one and the clock's.
    pub(crate) fn with_clock(&self, parameter: Parameter, own: T) -> T {
        let of_clock = self.clock * T::lit(parameter.by_clock());
        if of_clock == T::zero() { own } else { (own * own + of_clock * of_clock).sqrt() }
    }

    /// Every parameter that acts on motion or reading, with one sigma in [`Parameter::unit`], that of the clock included,
    /// and zero included: gyro, wheels by number, time offset, torque, common spin inertia.
    pub fn parameters(&self) -> impl Iterator<Item = (Parameter, T)> {
        let with_clock = |parameter, sigma| (parameter, self.with_clock(parameter, sigma));
        let scale = [0, 1, 2].map(|axis| with_clock(Parameter::GyroScale(axis), self.gyro_scale));
        let axes = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
            .map(|(axis, about)| (Parameter::GyroAxes(axis, about), self.gyro_axes_rad));
        let (inertia, tilt) = (self.wheel_inertia, self.wheel_axis_rad);
        let wheels =
            (0u8..).zip(inertia.into_iter().zip(tilt)).flat_map(|(wheel, (inertia, tilt))| {
                let tilts = [0, 1].map(|direction| (Parameter::WheelAxis(wheel, direction), tilt));
                core::iter::once((Parameter::WheelInertia(wheel), inertia)).chain(tilts)
            });
        let common = [
            (Parameter::Delay, self.delay_sigma_s),
            with_clock(Parameter::TorqueScale, self.torque_scale),
            with_clock(Parameter::CommonWheelInertia, self.common_wheel_inertia),
        ];
        scale.into_iter().chain(axes).chain(wheels).chain(common)
    }

    /// Checks the ranges: shares and angles up to [`LARGEST_SIGMA`], times up to [`LARGEST_DELAY_S`].
    ///
    /// # Errors
    /// Names the first value that is negative, too large or not finite.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let sigma = |field, value| up_to(field, value, LARGEST_SIGMA);
        sigma("hardware.gyro_scale", self.gyro_scale)?;
        sigma("hardware.gyro_axes_rad", self.gyro_axes_rad)?;
        up_to("hardware.delay_s", self.delay_s.abs(), LARGEST_DELAY_S)?;
        up_to("hardware.delay_sigma_s", self.delay_sigma_s, LARGEST_DELAY_S)?;
        sigma("hardware.common_wheel_inertia", self.common_wheel_inertia)?;
        sigma("hardware.torque_scale", self.torque_scale)?;
        sigma("hardware.clock", self.clock)?;
        for value in self.mount_rad {
            sigma("hardware.mount_rad", value)?;
        }
        for i in 0..W {
            sigma("hardware.wheel_inertia", self.wheel_inertia[i])?;
            sigma("hardware.wheel_axis_rad", self.wheel_axis_rad[i])?;
        }
        Ok(())
    }
}

/// One parameter of the hardware. Axes are 0 to 2, wheels from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Parameter {
    /// Scale factor error of one gyro axis.
    GyroScale(u8),
    /// Reading of the first axis of a rate about the second one.
    GyroAxes(u8, u8),
    /// Spin inertia of a wheel.
    WheelInertia(u8),
    /// Tilt of a wheel's axis, first or second direction.
    WheelAxis(u8, u8),
    /// Time offset of the gyro.
    Delay,
    /// Scale of the known torque.
    TorqueScale,
    /// Common error of the spin inertias.
    CommonWheelInertia,
    /// Turn of all sensors as one, about an axis.
    Mount(u8),
    /// Constant bias of one gyro axis.
    GyroBias(u8),
    /// Constant disturbance torque about one axis.
    DisturbanceTorque(u8),
    /// Element of the modal inertia of a mode, in the order of a tensor's.
    ModalInertia(u8, u8),
    /// Undamped frequency of a mode: error of the stated one.
    ModeFrequency(u8),
    /// Damping ratio of a mode: error of the stated one.
    ModeDamping(u8),
}

crate::persist!([] enum Parameter {
    0 => GyroScale(axis: u8),
    1 => GyroAxes(axis: u8, about: u8),
    2 => WheelInertia(wheel: u8),
    3 => WheelAxis(wheel: u8, direction: u8),
    4 => Delay,
    5 => TorqueScale,
    6 => CommonWheelInertia,
    7 => Mount(axis: u8),
    8 => GyroBias(axis: u8),
    9 => DisturbanceTorque(axis: u8),
    10 => ModalInertia(mode: u8, element: u8),
    11 => ModeFrequency(mode: u8),
    12 => ModeDamping(mode: u8)
});

impl Parameter {
    /// Name of the kind, as reports have it.
    pub const fn kind(self) -> &'static str {
        match self {
            Self::GyroScale(_) => "gyro scale factor",
            Self::GyroAxes(..) => "gyro axes",
            Self::WheelInertia(_) => "wheel spin inertia",
            Self::WheelAxis(..) => "wheel axis",
            Self::Delay => "time offset",
            Self::TorqueScale => "torque scale",
            Self::CommonWheelInertia => "common wheel spin inertia",
            Self::Mount(_) => "mount",
            Self::GyroBias(_) => "gyro bias",
            Self::DisturbanceTorque(_) => "disturbance torque",
            Self::ModalInertia(..) => "modal inertia",
            Self::ModeFrequency(_) => "mode frequency",
            Self::ModeDamping(_) => "mode damping",
        }
    }

    /// Value that a clock's error of one gives the parameter.
    ///
    /// In the time of a clock that is fast by ε, `dω/dt = (1 + ε) ω'`, and the motion is
    /// `(1 + ε) (J ω' + h') + ω × (J ω + h) = τ`. That of a gyro's scale error s, of spin inertias by c and of a torque by t,
    /// for the rate `z = (1 + s) ω`, is `(1 + s) (J z' + (1 + s) (1 + c) h') + z × (J z + (1 + s) (1 + c) h) = (1 + s)² (1 + t) τ`: the same for
    /// s = ε, c = −ε and t = −2 ε, to first order.
    pub const fn by_clock(self) -> f64 {
        match self {
            Self::GyroScale(_) => 1.0,
            Self::CommonWheelInertia => -1.0,
            Self::TorqueScale => -2.0,
            _ => 0.0,
        }
    }

    /// Unit of its value; empty for a share.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::GyroAxes(..) | Self::WheelAxis(..) | Self::Mount(_) => "rad",
            Self::Delay => "s",
            Self::GyroBias(_) => "rad/s",
            Self::DisturbanceTorque(_) => "N m",
            Self::ModalInertia(..) => "kg m²",
            _ => "",
        }
    }
}

/// Stated flexible appendage or sloshing liquid: a linear oscillator on the body.
///
/// Its modal inertia, `D Dᵀ` with the coupling vector D of the modal coordinate, is unknown. Frequency and damping ratio
/// are those of the appendage with the body held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode<T: Real> {
    /// Undamped frequency, Hz, positive.
    pub frequency_hz: T,
    /// Damping ratio, zero to one.
    pub damping: T,
    /// One sigma of the frequency, share; zero for one that is known exactly.
    pub frequency_sigma: T,
    /// One sigma of the damping ratio, share.
    pub damping_sigma: T,
}

crate::persist!([T: Real] Mode<T> { frequency_hz, damping, frequency_sigma, damping_sigma });

impl<T: Real> Mode<T> {
    /// Checks the ranges.
    ///
    /// # Errors
    /// Names the first field that is out of its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("modes.frequency_hz", self.frequency_hz)?;
        up_to("modes.damping", self.damping, 1)?;
        up_to("modes.frequency_sigma", self.frequency_sigma, LARGEST_SIGMA)?;
        up_to("modes.damping_sigma", self.damping_sigma, LARGEST_SIGMA)
    }
}

/// Disturbances that are constant over a flight, one sigma on each axis; zero for none.
///
/// Beside [`Hardware`], since they are unknowns of an estimator that can solve for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance<T: Real> {
    /// External torque that is not known, N m.
    pub torque_n_m: T,
    /// Gyro bias, rad/s.
    pub gyro_bias_rad_s: T,
}

impl<T: Real> Disturbance<T> {
    /// No disturbance.
    pub fn none() -> Self {
        Self { torque_n_m: T::zero(), gyro_bias_rad_s: T::zero() }
    }

    /// Every parameter with one sigma, in [`Parameter::unit`], zero included.
    pub fn parameters(&self) -> impl Iterator<Item = (Parameter, T)> {
        let bias = [0, 1, 2].map(|axis| (Parameter::GyroBias(axis), self.gyro_bias_rad_s));
        let torque = [0, 1, 2].map(|axis| (Parameter::DisturbanceTorque(axis), self.torque_n_m));
        bias.into_iter().chain(torque)
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// Names the first sigma that is negative or not finite.
    pub fn validate(&self) -> Result<(), ConfigError> {
        not_negative("disturbance.torque_n_m", self.torque_n_m)?;
        not_negative("disturbance.gyro_bias_rad_s", self.gyro_bias_rad_s)
    }
}

/// Result on one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding<T: Real> {
    /// The parameter.
    pub parameter: Parameter,
    /// Estimate, in [`Parameter::unit`].
    pub value: T,
    /// One sigma after the data.
    pub sigma: T,
    /// One sigma as stated.
    pub stated: T,
    /// Shift of the six elements of the tensor by one sigma of what the data leave of it, kg m².
    pub effect_kg_m2: [T; 6],
}

/// Change of the six elements of a tensor by a turn of the body axes about one of them, per radian:
/// `e^× J − J e^×`.
pub fn turned_by<T: Real>(inertia: &Inertia<T>, axis: usize) -> [T; 6] {
    let mut turn = Vec3::zeros();
    turn[axis.min(2)] = T::one();
    let by = skew(&turn) * inertia.matrix_kg_m2();
    let sum = by + by.transpose();
    [sum[(0, 0)], sum[(1, 1)], sum[(2, 2)], sum[(0, 1)], sum[(0, 2)], sum[(1, 2)]]
}

/// The two directions of the tilts of a unit axis a: `e₁` normal to a and to the body axis that is farthest from
/// it, `e₂ = a × e₁`.
pub fn tilt_directions<T: Real>(axis: &Vec3<T>) -> [Vec3<T>; 2] {
    let [x, y, z] = [axis.x.abs(), axis.y.abs(), axis.z.abs()];
    let far = if x <= y && x <= z {
        Vec3::x()
    } else if y <= z {
        Vec3::y()
    } else {
        Vec3::z()
    };
    let first = axis.cross(&far);
    let first = first * (T::one() / norm(&first));
    [first, axis.cross(&first)]
}

/// Axes of W wheels with errors, by columns: `1 + s + sᵢ` times the unit vector along `aᵢ + θ₁ e₁ + θ₂ e₂`. `errors` returns `(sᵢ, θ₁, θ₂)` of a
/// wheel.
pub fn axes_with_errors<T: Real, const W: usize>(
    axes: &Mat<T, 3, W>,
    common: T,
    errors: impl Fn(usize) -> Vec3<T>,
) -> Mat<T, 3, W> {
    of_columns(core::array::from_fn(|i| {
        let error = errors(i);
        let axis = column(axes, i);
        let share = T::one() + common + error[0];
        if error[1] == T::zero() && error[2] == T::zero() {
            return axis * share;
        }
        let [first, second] = tilt_directions(&axis);
        let tilted = axis + first * error[1] + second * error[2];
        tilted * (share / norm(&tilted))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orthonormal right-handed triad for axes in all octants.
    #[test]
    fn tilts_are_normal_to_the_axis() {
        for axis in [Vec3::x(), Vec3::new(0.6, -0.8, 0.0), Vec3::new(1.0, 1.0, -1.0).normalize()] {
            let [e1, e2] = tilt_directions::<f64>(&axis);
            assert!(axis.dot(&e1).abs() < 1e-15 && axis.dot(&e2).abs() < 1e-15);
            assert!((e1.norm() - 1.0).abs() < 1e-15 && (axis.cross(&e1) - e2).norm() < 1e-15);
        }
    }

    /// Against the rotated tensor by finite differences.
    #[test]
    fn a_turn_is_the_derivative_of_a_rotation() {
        let inertia = Inertia::new([2.0, 3.0, 4.0, 0.3, -0.2, 0.1f64]);
        for axis in 0..3 {
            let mut turn = nalgebra::Vector3::zeros();
            turn[axis] = 1e-6;
            let rotation = nalgebra::Rotation3::new(turn).into_inner();
            let turned = rotation * inertia.matrix_kg_m2() * rotation.transpose();
            let apart = (turned - inertia.matrix_kg_m2()) / 1e-6;
            let by = Inertia::new(turned_by(&inertia, axis)).matrix_kg_m2();
            assert!((apart - by).norm() < 1e-5);
        }
    }

    #[test]
    fn an_error_names_the_field() {
        let refused = |hardware: Hardware<f32, 1>| hardware.validate().unwrap_err().field;
        let ideal = Hardware::<f32, 1>::ideal();
        assert_eq!(ideal.validate(), Ok(()));
        assert_eq!(refused(Hardware { gyro_scale: -1.0, ..ideal }), "hardware.gyro_scale");
        assert_eq!(
            refused(Hardware { wheel_axis_rad: [f32::NAN], ..ideal }),
            "hardware.wheel_axis_rad"
        );
    }
}
