//! The table of estimators: name, source and requirements of each.

use std::fmt;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

/// An estimator of the flight core, in one configuration. [`EstimatorName::properties`] has its row
/// of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorName {
    /// `window`: the default, our own.
    Window,
    /// `joint-ekf`: the nine-state filter in UD form that flies.
    JointEkf,
    /// `joint-ekf-published`: the nine-state filter as printed.
    JointEkfPublished,
    /// `joint-ekf-unaligned`: the UD form with the start of the printed filter.
    JointEkfUnaligned,
    /// `ekf-sgf-rls`: rate filter, differentiator, recursive least squares.
    EkfSgfRls,
    /// `ekf-sgf-lls`: rate filter, differentiator, batch least squares.
    EkfSgfLls,
    /// `momentum-batch`: conservation of momentum, all six elements at once.
    MomentumBatch,
    /// `momentum-conventional`: conservation of momentum, one axis at a time.
    MomentumConventional,
    /// `momentum-pre-estimate`: products given earlier products.
    MomentumPreEstimate,
    /// `momentum-suggested`: products given the moments.
    MomentumSuggested,
}

/// One row of the table of estimators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Properties {
    /// The estimator.
    pub estimator: EstimatorName,
    /// Name on the command line and in reports. Stable.
    pub name: &'static str,
    /// Key of the source in the bibliography of `fsw_core`; none for our own estimator.
    pub paper: Option<&'static str>,
    /// The method in one line, for the help text.
    pub summary: &'static str,
    /// Requires the attitude in each sample.
    pub needs_attitude: bool,
    /// Estimates the gyro noise from its own residuals, so that it may be left unstated.
    pub measures_gyro_noise: bool,
    /// Estimates a constant disturbance torque and the gyro bias on request.
    pub solves_for_disturbances: bool,
    /// Widens its covariance by a disturbance torque and a gyro bias of stated sigma.
    pub considers_disturbances: bool,
}

/// The defaults of a row: a published filter that takes rates, torques and the gyro noise.
const PUBLISHED: Properties = Properties {
    estimator: EstimatorName::Window,
    name: "",
    paper: None,
    summary: "",
    needs_attitude: false,
    measures_gyro_noise: false,
    solves_for_disturbances: false,
    considers_disturbances: false,
};

/// The estimators, in the order of [`EstimatorName`].
const TABLE: [Properties; 10] = [
    Properties {
        estimator: EstimatorName::Window,
        name: "window",
        summary: "Gauss-Newton fit of each manoeuvre as a whole, at the Cramér-Rao bound",
        measures_gyro_noise: true,
        solves_for_disturbances: true,
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::JointEkf,
        name: "joint-ekf",
        paper: Some("Bellar2019"),
        summary: "Nine-state EKF in UD form, in the flight image",
        considers_disturbances: true,
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::JointEkfPublished,
        name: "joint-ekf-published",
        paper: Some("Bellar2019"),
        summary: "Nine-state EKF as printed",
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::JointEkfUnaligned,
        name: "joint-ekf-unaligned",
        paper: Some("Bellar2019"),
        summary: "Nine-state EKF in UD form, started at once on the prior as the printed one",
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::EkfSgfRls,
        name: "ekf-sgf-rls",
        paper: Some("Kim2013"),
        summary: "Rate EKF, causal Savitzky-Golay filter, recursive least squares of the moments",
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::EkfSgfLls,
        name: "ekf-sgf-lls",
        paper: Some("Kim2016"),
        summary: "Rate EKF, even-window Savitzky-Golay filter, batch least squares of all elements",
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::MomentumBatch,
        name: "momentum-batch",
        paper: Some("Kim2010"),
        summary: "Conservation of momentum, least squares of all elements at once",
        needs_attitude: true,
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::MomentumConventional,
        name: "momentum-conventional",
        paper: Some("Kim2010"),
        summary: "Conservation of momentum, one axis at a time",
        needs_attitude: true,
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::MomentumPreEstimate,
        name: "momentum-pre-estimate",
        paper: Some("Kim2010"),
        summary: "Conservation of momentum, each product given the earlier products",
        needs_attitude: true,
        ..PUBLISHED
    },
    Properties {
        estimator: EstimatorName::MomentumSuggested,
        name: "momentum-suggested",
        paper: Some("Kim2010"),
        summary: "Conservation of momentum, products given the moments: the paper's suggestion",
        needs_attitude: true,
        ..PUBLISHED
    },
];

/// The estimators of [`TABLE`], in its order.
const ALL: [EstimatorName; TABLE.len()] = {
    let mut all = [EstimatorName::Window; TABLE.len()];
    let mut row = 0;
    while row < TABLE.len() {
        all[row] = TABLE[row].estimator;
        row += 1;
    }
    all
};

impl EstimatorName {
    /// All estimators, the default first.
    pub fn all() -> impl Iterator<Item = Self> {
        ALL.into_iter()
    }

    /// The estimator's row of the table.
    pub fn properties(self) -> &'static Properties {
        &TABLE[self as usize]
    }

    /// The estimator of this name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        ALL.into_iter().find(|estimator| estimator.properties().name == name)
    }
}

impl fmt::Display for EstimatorName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.properties().name)
    }
}

impl ValueEnum for EstimatorName {
    fn value_variants<'a>() -> &'a [Self] {
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let Properties { name, paper, summary, .. } = *self.properties();
        let help = match paper {
            Some(key) => format!("{summary} [{key}]"),
            None => summary.to_owned(),
        };
        Some(PossibleValue::new(name).help(help))
    }
}

/// The arithmetic of the flight core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Precision {
    /// Single precision, as in flight
    F32,
    /// Double precision
    F64,
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        })
    }
}

/// An estimator and its arithmetic. The same options for every verb that estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Args)]
pub struct Method {
    /// Estimator
    #[arg(long, value_enum, default_value_t = EstimatorName::Window)]
    pub estimator: EstimatorName,
    /// Arithmetic of the estimator
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    pub precision: Precision,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_rows_follow_the_order_of_the_enumeration() {
        for (index, row) in TABLE.iter().enumerate() {
            assert_eq!(row.estimator as usize, index, "{}", row.name);
            assert_eq!(EstimatorName::from_name(row.name), Some(row.estimator));
        }
    }
}
