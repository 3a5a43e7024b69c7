//! Small version of the catalogue of imperfections: 12 flights a cell, in the precision of flight.
//!
//! The whole catalogue is `cargo run --release -p tests --bin hardware`.

use anyhow::Result;
use host_sim::estimation::{EstimatorName, Precision};
use host_sim::input::Scenario;
use tests::hardware::catalogue::{DATA_SHEET, SCENARIOS, all};
use tests::hardware::cell::{Cell, Flown};

/// Rows flown here: one of each kind of parameter, stated modes, and a torque of a field.
const ROWS: [&str; 9] = [
    "none",
    "gyro scale factor",
    "gyro axes",
    "gyro late",
    "wheel spin inertia, each",
    "wheel axes",
    "flexible mode 0.5 Hz, stated",
    "slosh 0.05 Hz, stated",
    "residual dipole",
];
const FLOWN: Flown =
    Flown { estimator: EstimatorName::Window, precision: Precision::F32, seed: 1000, runs: 12 };

#[test]
fn stated_hardware_is_covered_by_the_sigma() -> Result<()> {
    let mut missed = Vec::new();
    for name in SCENARIOS {
        let ideal = Scenario::load(name)?;
        for case in all().iter().filter(|case| ROWS.contains(&case.name)) {
            let Some(cell) = Cell::of_case(case, &ideal, &FLOWN)? else { continue };
            if !cell.missed().is_empty() {
                missed.push(format!("{name}, {} {}: {cell:?}", case.name, case.level));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
    Ok(())
}

#[test]
fn everything_at_data_sheet_level_at_once_is_covered() -> Result<()> {
    for name in DATA_SHEET {
        let cell = Cell::fly(&Scenario::load(name)?, &FLOWN)?;
        assert!(cell.missed().is_empty() && cell.flagged <= 1, "{name}: {cell:?}");
    }
    Ok(())
}
