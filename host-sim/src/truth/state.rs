//! State vector of the motion: body rate, attitude, wheel momenta.
//!
//! | index | content | unit |
//! |---|---|---|
//! | 0 to 2 | body rate `ω`, body axes | rad/s |
//! | 3 to 6 | attitude `q` from body to inertial axes, scalar first | 1 |
//! | 7 … | axial momentum of each wheel over the mean moment of inertia | rad/s |
//! | … | deflection `q` of each oscillator, then its rate (see [`flexible`](super::flexible)) | rad, rad/s |
//! | … | angle of each wheel relative to the body, if a wheel has an imbalance | rad |

use nalgebra::{Quaternion, Vector3};

/// Index of the body rate.
pub(super) const RATE: usize = 0;
/// Index of the attitude.
pub(super) const ATTITUDE: usize = 3;
/// Index of the first wheel.
pub(super) const WHEELS: usize = 7;

/// Body rate, rad/s.
pub(super) fn rate(state: &[f64]) -> Vector3<f64> {
    Vector3::new(state[RATE], state[RATE + 1], state[RATE + 2])
}

/// Attitude, not normalised.
pub(super) fn attitude(state: &[f64]) -> Quaternion<f64> {
    Quaternion::new(state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3])
}
