//! Columns of the information: unknowns and errors of the hardware, in their order.
//!
//! Columns with a differential equation come first. Inertia and torque are in units of the mean moment
//! of the prior, so that all columns have the size of a rate.

use crate::input::Scenario;
use crate::truth::bound::hardware::{Error, errors};

/// Prior sigma of an unknown without one, in the scaled units: no information, and finite sums.
const NO_PRIOR_SIGMA: f64 = 1e3;

/// One column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Rate at the start about an axis.
    Rate(usize),
    /// Element of the inertia.
    Inertia(usize),
    /// Constant torque about an axis.
    Torque(usize),
    /// Error of a wheel or of all wheels, or of the gyro.
    Hardware(Error),
    /// Gyro bias about an axis.
    Bias(usize),
}

/// A column, its prior, and its use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub kind: Kind,
    /// One sigma before the data, in the unit of the column.
    pub prior_sigma: f64,
    /// The estimate leaves the error at zero and adds its effect to the covariance.
    pub is_considered: bool,
}

/// All columns.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub all: Vec<Column>,
    /// Number of those with a differential equation.
    pub dynamic: usize,
}

/// Treatment of stated errors of the hardware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Treatment {
    /// Left out of the unknowns, their effect in the covariance (Schmidt).
    #[default]
    Considered,
    /// Unknowns with their sigma as prior.
    Solved,
}

impl Columns {
    /// Columns of a scenario. Without `prior_sigma_kg_m2` the inertia has no prior.
    pub(super) fn new(
        scenario: &Scenario,
        treatment: Treatment,
        prior_sigma_kg_m2: Option<&[f64; 6]>,
        unit_kg_m2: f64,
    ) -> Self {
        let free = |kind| Column { kind, prior_sigma: NO_PRIOR_SIGMA, is_considered: false };
        let stated = &scenario.hardware;
        let mut all: Vec<Column> = (0..3).map(|axis| free(Kind::Rate(axis))).collect();
        all.extend((0..6).map(|element| Column {
            prior_sigma:
                prior_sigma_kg_m2.map_or(NO_PRIOR_SIGMA, |sigma| {
                    (sigma[element] / unit_kg_m2).min(NO_PRIOR_SIGMA)
                }),
            ..free(Kind::Inertia(element))
        }));
        if scenario.solve_for.torque {
            let sigma = stated.torque_sigma_n_m.map_or(NO_PRIOR_SIGMA, |sigma| sigma / unit_kg_m2);
            all.extend(
                (0..3).map(|axis| Column { prior_sigma: sigma, ..free(Kind::Torque(axis)) }),
            );
        }
        let is_considered = treatment == Treatment::Considered;
        let hardware = errors(scenario).into_iter().map(|(error, prior_sigma)| Column {
            kind: Kind::Hardware(error),
            prior_sigma,
            is_considered,
        });
        // The errors of wheels and torque precede those of the gyro; without thrusters no external torque is
        // commanded. An error of the clock is left out: of 100 ppm it is a hundredth of the others.
        let has_thrusters = !scenario.torque.thrusters.is_empty();
        let (moving, direct): (Vec<Column>, Vec<Column>) = hardware
            .filter(|column| match column.kind {
                Kind::Hardware(Error::TorqueScale) => has_thrusters,
                kind => kind != Kind::Hardware(Error::Clock),
            })
            .partition(|column| column.is_dynamic());
        all.extend(moving);
        let dynamic = all.len();
        if scenario.solve_for.gyro_bias {
            let sigma = stated.bias_sigma_rad_s.unwrap_or(NO_PRIOR_SIGMA);
            all.extend((0..3).map(|axis| Column { prior_sigma: sigma, ..free(Kind::Bias(axis)) }));
        }
        all.extend(direct);
        Self { all, dynamic }
    }

    /// No column: motion alone.
    pub(super) fn none() -> Self {
        Self { all: Vec::new(), dynamic: 0 }
    }
}

impl Column {
    fn is_dynamic(&self) -> bool {
        matches!(self.kind, Kind::Hardware(error) if error.is_dynamic())
    }
}
