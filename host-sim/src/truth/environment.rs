//! Torques of the environment on a circular orbit about the Earth.
//!
//! With the position `r = r r̂` from the centre of the Earth and the velocity `v = v v̂`:
//!
//! ```text
//! gravity gradient   τ = 3 μ/r³ r̂ × J r̂
//! residual dipole    τ = m × B,  B = B₀ (R/r)³ (3 (m̂ · r̂) r̂ − m̂)
//! drag               τ = −c_p × ½ ρ v² C_D A v̂
//! ```
//!
//! Source: J. R. Wertz (ed.), *Spacecraft Attitude Determination and Control*, Reidel, 1978, section 17.2
//! and appendix H.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `μ`, `R` | gravitational parameter and equatorial radius of the Earth | m³/s², m |
//! | `J` | inertia of the body | kg m² |
//! | `m`, `B` | residual dipole, magnetic field | A m², T |
//! | `m̂` | direction of the Earth's dipole: −z, towards the southern pole | 1 |
//! | `c_p`, `A`, `ρ` | centre of pressure, area, density of the air | m, m², kg/m³ |
//!
//! Assumptions: circular orbit, dipole field fixed in inertial axes, air at rest in them, area
//! independent of the attitude.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::input::scenario::hardware::Orbit;

/// Gravitational parameter of the Earth (EGM96), m³/s².
const MU_M3_S2: f64 = 3.986_004_418e14;
/// Equatorial radius of the Earth (WGS 84), m.
const EARTH_RADIUS_M: f64 = 6.378_137e6;
/// Field of the Earth's dipole at the magnetic equator, T: 2.98e-5 (IGRF-13, 2020).
const EQUATOR_FIELD_T: f64 = 2.98e-5;
/// Drag coefficient of a satellite in free molecular flow.
const DRAG_COEFFICIENT: f64 = 2.2;

/// Torque in body axes, N m, at this time, attitude (body to inertial) and inertia.
pub fn torque_n_m(
    orbit: &Orbit,
    time_s: f64,
    attitude: &UnitQuaternion<f64>,
    inertia_kg_m2: &Matrix3<f64>,
) -> Vector3<f64> {
    let r = EARTH_RADIUS_M + 1e3 * orbit.altitude_km;
    let mean_motion = (MU_M3_S2 / (r * r * r)).sqrt();
    let (sin, cos) = (orbit.phase_rad + mean_motion * time_s).sin_cos();
    let (sin_i, cos_i) = orbit.inclination_rad.sin_cos();
    let position = Vector3::new(cos, cos_i * sin, sin_i * sin);
    let velocity = Vector3::new(-sin, cos_i * cos, sin_i * cos);
    let to_body = attitude.inverse();
    let mut torque = Vector3::zeros();
    if orbit.gravity_gradient {
        let r_hat = to_body * position;
        torque += r_hat.cross(&(inertia_kg_m2 * r_hat)) * (3.0 * mean_motion * mean_motion);
    }
    let south = -Vector3::z();
    let ratio = EARTH_RADIUS_M / r;
    let strength_t = EQUATOR_FIELD_T * ratio * ratio * ratio;
    let field = (position * (3.0 * south.dot(&position)) - south) * strength_t;
    torque += orbit.dipole_a_m2.cross(&(to_body * field));
    let speed_squared = MU_M3_S2 / r;
    let pressure = 0.5 * orbit.air_density_kg_m3 * speed_squared * DRAG_COEFFICIENT;
    let force = to_body * velocity * (-pressure * orbit.drag_area_m2);
    torque + orbit.pressure_centre_m.cross(&force)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orbit() -> Orbit {
        Orbit {
            altitude_km: 500.0,
            inclination_rad: 0.0,
            phase_rad: 0.0,
            gravity_gradient: false,
            dipole_a_m2: Vector3::zeros(),
            air_density_kg_m3: 0.0,
            drag_area_m2: 0.0,
            pressure_centre_m: Vector3::zeros(),
        }
    }

    /// Attitude for which the direction to the zenith in body axes is `up`.
    fn zenith(up: Vector3<f64>) -> UnitQuaternion<f64> {
        UnitQuaternion::rotation_between(&up, &Vector3::x()).unwrap()
    }

    #[test]
    fn gravity_gradient_is_that_of_two_point_masses() {
        // A dumbbell: masses m at ± l d from the centre of mass, with the force of each computed.
        let (mass_kg, arm_m) = (3.0, 0.7);
        let direction = Vector3::new(1.0, 2.0, -0.5).normalize();
        let up = Vector3::new(0.3, -0.4, 0.8).normalize();
        let r = EARTH_RADIUS_M + 500e3;
        let arm = direction * arm_m;
        // Forces less that at the centre, to first order in the arm, keep their digits:
        // F = −μ m (x/r³ − 3 (r̂·x) r̂/r³).
        let force =
            |x: Vector3<f64>| -(x - up * (3.0 * up.dot(&x))) * (MU_M3_S2 * mass_kg / (r * r * r));
        let expected = arm.cross(&force(arm)) + (-arm).cross(&force(-arm));
        let inertia =
            (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * (2.0 * mass_kg);
        let orbit = Orbit { gravity_gradient: true, ..orbit() };
        let torque = torque_n_m(&orbit, 0.0, &zenith(up), &inertia);
        assert!((torque - expected).norm() < 1e-12 * expected.norm(), "{torque} {expected}");
        let none = torque_n_m(&orbit, 0.0, &zenith(direction), &inertia);
        assert!(none.norm() < 1e-15 * expected.norm().max(1.0), "{none}");
    }

    #[test]
    fn dipole_turns_towards_the_field() {
        // Above the equator the field points north and has its equatorial strength over r³.
        let up = Vector3::x();
        let orbit = Orbit { dipole_a_m2: Vector3::y(), ..orbit() };
        let torque = torque_n_m(&orbit, 0.0, &zenith(up), &Matrix3::identity());
        let strength = EQUATOR_FIELD_T * (6378.137f64 / 6878.137).powi(3);
        assert!((torque - Vector3::x() * strength).norm() < 1e-12 * strength, "{torque}");
    }

    #[test]
    fn drag_acts_against_the_velocity_at_the_centre_of_pressure() {
        let orbit = Orbit {
            air_density_kg_m3: 1e-12,
            drag_area_m2: 2.0,
            pressure_centre_m: Vector3::new(0.1, 0.0, 0.0),
            ..orbit()
        };
        let torque = torque_n_m(&orbit, 0.0, &UnitQuaternion::identity(), &Matrix3::identity());
        // 7.61 km/s along y at 500 km: force 1e-12/2 · 7613² · 2.2 · 2 = 1.2750e-4 N.
        let speed_squared = 3.986_004_418e14 / 6.878_137e6;
        let expected = -0.1 * 0.5e-12 * speed_squared * 2.2 * 2.0;
        assert!((torque - Vector3::z() * expected).norm() < 1e-12 * expected.abs(), "{torque}");
    }

    #[test]
    fn mean_motion_is_that_of_the_period() {
        // 94.6 min at 500 km: after half of it the zenith is opposite and the torque of drag turns.
        let orbit = Orbit {
            air_density_kg_m3: 1e-12,
            drag_area_m2: 1.0,
            pressure_centre_m: Vector3::x(),
            ..orbit()
        };
        let period_s = std::f64::consts::TAU * (6.878_137e6f64.powi(3) / MU_M3_S2).sqrt();
        assert!((period_s / 60.0 - 94.6).abs() < 0.1, "{period_s}");
        let at = |t| torque_n_m(&orbit, t, &UnitQuaternion::identity(), &Matrix3::identity()).z;
        assert!((at(0.0) + at(period_s / 2.0)).abs() < 1e-9 * at(0.0).abs());
    }
}
