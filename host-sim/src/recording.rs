//! A flight, written down sample by sample as the estimator saw it.

use fsw_core::Outcome;

use crate::estimation::AnyEstimator;
use crate::input::log::LogRow;
use crate::report::{AccelerationRow, HistoryRow};

/// What the estimator knows after this sample.
pub fn history_row(row: &LogRow, outcome: &Outcome, on_board: &dyn AnyEstimator) -> HistoryRow {
    let innovation = on_board.innovation();
    let estimate = on_board.estimate();
    HistoryRow {
        time_s: row.time_us as f64 * 1e-6,
        measured_rate_rad_s: row.rate_rad_s.into(),
        estimated_rate_rad_s: on_board.rate_rad_s().into(),
        rate_sigma_rad_s: on_board.rate_sigma_rad_s().map(Into::into),
        acceleration: on_board
            .acceleration()
            .map(|a| AccelerationRow { rad_s2: a.rad_s2.into(), delay_s: a.delay_s }),
        innovation_rad_s: innovation.map(|i| i.rate_rad_s.into()),
        innovation_sigma_rad_s: innovation.map(|i| i.variance_rad2_s2.map(f64::sqrt).into()),
        nis: innovation.map(|i| i.nis()),
        inertia_kg_m2: estimate.inertia.elements_kg_m2(),
        sigma_kg_m2: estimate.sigma_kg_m2(),
        outcome: outcome.name(),
    }
}
