//! Unknowns of the bound: their names, their order, and the limit of observability.
//!
//! Order: initial rate (3), inertia (6), disturbance torque (3, if estimated), gyro bias (3, if
//! estimated). Inertia and torque are in units of the mean moment of inertia (per s²), so that all
//! sensitivities have the size of a rate.

use crate::input::craft::SolveFor;
use crate::input::scenario::Scenario;

/// Column of the first element of the inertia.
pub(super) const INERTIA: usize = 3;
/// Column of the torque about x.
pub(super) const TORQUE: usize = 9;

/// Sigma in mean moments of inertia from which a direction or element is unobserved: its
/// uncertainty is as large as the inertia itself.
pub(super) const UNOBSERVED_SIGMA: f64 = 1.0;
/// Largest sigma of a direction without information, so that sums stay finite.
pub(super) const NO_INFORMATION_SIGMA: f64 = 1e6;

/// Unknowns of an estimator: rate, inertia, and the disturbances to solve for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknowns(SolveFor);

impl Unknowns {
    /// Unknowns that the scenario asks for.
    pub fn of(scenario: &Scenario) -> Self {
        Self(scenario.solve_for)
    }

    /// A constant disturbance torque is unknown.
    pub fn has_torque(&self) -> bool {
        self.0.torque
    }

    /// Names, in order.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names = vec!["rate_x", "rate_y", "rate_z"];
        names.extend(["jxx", "jyy", "jzz", "jxy", "jxz", "jyz"]);
        if self.0.torque {
            names.extend(["torque_x", "torque_y", "torque_z"]);
        }
        if self.0.gyro_bias {
            names.extend(["gyro_bias_x", "gyro_bias_y", "gyro_bias_z"]);
        }
        names
    }

    /// Number of unknowns whose sensitivity follows a differential equation: all but the gyro bias.
    pub(super) fn dynamic(&self) -> usize {
        if self.0.torque { 12 } else { 9 }
    }

    /// Number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.dynamic() + if self.0.gyro_bias { 3 } else { 0 }
    }
}
