//! Estimators of the flight image, as values of an option.

use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use fsw_target::flight::selected::EstimatorId;

use crate::estimation::EstimatorName;

/// An estimator of the flight image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FlightEstimator {
    /// Number in telecommands and telemetry.
    pub id: EstimatorId,
    /// The same estimator on the host.
    pub name: EstimatorName,
}

static ALL: LazyLock<Vec<FlightEstimator>> = LazyLock::new(|| {
    let with_name = |id: EstimatorId| {
        EstimatorName::from_name(id.name()).map(|name| FlightEstimator { id, name })
    };
    EstimatorId::ALL.into_iter().filter_map(with_name).collect()
});

impl ValueEnum for FlightEstimator {
    fn value_variants<'a>() -> &'a [Self] {
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        self.name.to_possible_value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flight_estimator_is_in_the_table_of_estimators() {
        assert_eq!(ALL.len(), EstimatorId::ALL.len());
    }
}
