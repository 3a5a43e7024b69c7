//! Attitude controller of a scenario: motor torques of the wheels from attitude and rate.
//!
//! Assumptions: true attitude and rate, without noise or delay; continuous action. The motion is
//! therefore the same for every seed of the gyro noise.

use nalgebra::{DVector, Dyn, Matrix3xX, OMatrix, U3, UnitQuaternion, Vector3};

use crate::input::scenario::{Control, SimulatedWheel};

/// Control law, and its allocation to the wheels.
pub struct Controller<'a> {
    control: &'a Control,
    /// Pseudo-inverse of the wheel axes, wheels × 3: motor torques of least norm for a torque.
    allocation: OMatrix<f64, Dyn, U3>,
}

impl<'a> Controller<'a> {
    /// Controller of these wheels, whose axes span three dimensions (checked on loading).
    pub fn new(control: &'a Control, wheels: &[SimulatedWheel]) -> Self {
        let columns: Vec<Vector3<f64>> = wheels.iter().map(|motor| motor.wheel.axis).collect();
        let axes = Matrix3xX::from_columns(&columns);
        // A⁺ = Aᵀ (A Aᵀ)⁻¹. The integrator reports the NaN of a singular matrix.
        let inverse = (&axes * axes.transpose()).try_inverse();
        let inverse = inverse.unwrap_or_else(|| nalgebra::Matrix3::repeat(f64::NAN));
        Self { control, allocation: axes.transpose() * inverse }
    }

    /// Torque on the body, body axes, N m: `u = −K_P q_e − K_D ω`, \[Kim2010\] Eq. (17).
    ///
    /// `q_e` is the vector part of the rotation from the target to the body, the shorter of the two;
    /// `ω` is the body rate, rad/s; `K_P`, N m, and `K_D`, N m s, are the gains.
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

    /// Torque of each motor on its wheel, N m. The reaction acts on the body.
    pub fn motor_torque_n_m(
        &self,
        attitude: &UnitQuaternion<f64>,
        rate_rad_s: &Vector3<f64>,
    ) -> DVector<f64> {
        -(&self.allocation * self.torque_n_m(attitude, rate_rad_s))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::input::scenario::Scenario;

    const PYRAMID: &str = r#"
        name = "pyramid"
        duration_s = 10.0
        spacecraft = { inertia_kg_m2 = [3, 4, 5, 0.1, -0.2, 0.3] }
        gyro = { rate_hz = 1.0, noise_rad_s = 1e-4 }
        wheel = [
            { axis = [1, 1, 1], spin_inertia_kg_m2 = 1e-3 },
            { axis = [-1, 1, 1], spin_inertia_kg_m2 = 2e-3 },
            { axis = [-1, -1, 1], spin_inertia_kg_m2 = 1e-3 },
            { axis = [1, -1, 1], spin_inertia_kg_m2 = 1e-3 },
        ]
        [control]
        target_attitude_deg = [10, 20, 30]
        attitude_gain_n_m = [1, 2, 3]
        rate_gain_n_m_s = [4, 5, 6]
        "#;

    fn with_controller(test: impl Fn(&Controller<'_>, &[SimulatedWheel])) {
        let scenario = Scenario::from_toml("s.toml", PYRAMID, Path::new("")).unwrap();
        let control = scenario.control.as_ref().unwrap();
        test(&Controller::new(control, &scenario.wheels), &scenario.wheels);
    }

    #[test]
    fn four_wheels_produce_the_torque_of_the_law() {
        with_controller(|controller, wheels| {
            let attitude = UnitQuaternion::from_euler_angles(0.4, -0.2, 0.9);
            let rate = Vector3::new(0.01, -0.02, 0.03);
            let motors = controller.motor_torque_n_m(&attitude, &rate);
            let on_body: Vector3<f64> =
                wheels.iter().zip(motors.iter()).map(|(w, m)| -w.wheel.axis * *m).sum();
            assert!((on_body - controller.torque_n_m(&attitude, &rate)).norm() < 1e-14);
        });
    }

    #[test]
    fn torque_turns_the_body_to_its_target_by_the_shorter_rotation() {
        with_controller(|controller, _| {
            let target = controller.control.target;
            assert!(controller.torque_n_m(&target, &Vector3::zeros()).norm() < 1e-15);
            for angle in [0.1f64, 3.0, -0.1, 3.5] {
                let turned = target * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
                let push = controller.torque_n_m(&turned, &Vector3::zeros()).z;
                assert_eq!(push < 0.0, angle.sin() > 0.0, "{angle}: {push}");
            }
            let braked = controller.torque_n_m(&target, &Vector3::new(1.0, 1.0, 1.0));
            assert!((braked - Vector3::new(-4.0, -5.0, -6.0)).norm() < 1e-14);
        });
    }
}
