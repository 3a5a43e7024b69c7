//! The attitude controller of a scenario, as torques of the wheels' motors.
//!
//! It knows the true attitude and rate, without noise or delay, and acts continuously: so the
//! motion is the same for every seed of the gyro's noise.

use nalgebra::{DVector, Dyn, Matrix3xX, OMatrix, U3, UnitQuaternion, Vector3};

use crate::input::scenario::{Control, SimulatedWheel};

/// A control law and the wheels that carry it out.
pub struct Controller<'a> {
    control: &'a Control,
    /// Pseudo-inverse of the axes, wheels × 3: the motor torques of least norm for a torque.
    allocation: OMatrix<f64, Dyn, U3>,
}

impl<'a> Controller<'a> {
    /// The controller of these wheels, which have been checked to span three dimensions.
    pub fn new(control: &'a Control, wheels: &[SimulatedWheel]) -> Self {
        let columns: Vec<Vector3<f64>> = wheels.iter().map(|motor| motor.wheel.axis).collect();
        let axes = Matrix3xX::from_columns(&columns);
        // A⁺ = Aᵀ (A Aᵀ)⁻¹; a NaN here would be told by the integrator.
        let inverse = (&axes * axes.transpose()).try_inverse();
        let inverse = inverse.unwrap_or_else(|| nalgebra::Matrix3::repeat(f64::NAN));
        Self { control, allocation: axes.transpose() * inverse }
    }

    /// Torque on the body, body axes, N m: `u = −K_P q_e − K_D ω`, \[Kim2010\] Eq. (17).
    ///
    /// `q_e` is the vector part of the rotation from the target to the body, by the shorter way.
    pub fn torque_n_m(
        &self,
        attitude: &UnitQuaternion<f64>,
        rate_rad_s: &Vector3<f64>,
    ) -> Vector3<f64> {
        let error = self.control.target.inverse() * attitude;
        let shorter_way = if error.w < 0.0 { -1.0 } else { 1.0 };
        let vector_part = error.imag() * shorter_way;
        -(self.control.attitude_gain_n_m * vector_part + self.control.rate_gain_n_m_s * rate_rad_s)
    }

    /// Torque of each motor on its wheel, N m; the body feels the opposite.
    pub fn motor_torque_n_m(
        &self,
        attitude: &UnitQuaternion<f64>,
        rate_rad_s: &Vector3<f64>,
    ) -> DVector<f64> {
        -(&self.allocation * self.torque_n_m(attitude, rate_rad_s))
    }
}
