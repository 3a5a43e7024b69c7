//! The image `replay` in QEMU: exit status, and the bits of the host on the recorded flight.

use anyhow::Result;
use fsw_core::Estimator;
use fsw_target::flight::flight_loop::Tick;
use fsw_target::flight::selected::{EstimatorId, SelectedEstimator};
use fsw_target::stand_in::replay;
use host_sim::estimation::{EstimatorName, Precision, Setup, estimate_log, set_up};
use host_sim::input::craft::StatedHardware;
use host_sim::input::{Craft, RecordedLog};
use std::path::Path;
use std::time::Duration;
use target_tools::{firmware, image, qemu};

use crate::LIMIT;

/// Beginnings of the lines in which `bin/replay` prints bits: state and covariance, and the digest of each estimator.
const BIT_LINES: [&str; 3] = ["state[", "covariance[", "digest "];

fn run(bin: &str, limit: Duration) -> Result<qemu::Run> {
    qemu::run(&firmware::build(bin)?, qemu::MACHINE, limit, |_| {})
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn target_and_host_compute_the_same_bits() -> Result<()> {
    let _alone = crate::alone();
    assert_bits_of_the_host(&run("replay", LIMIT)?)
}

/// Every line with bits is that of the host.
pub fn assert_bits_of_the_host(target: &qemu::Run) -> Result<()> {
    assert!(target.success, "the image reported a failure: {:#?}", target.lines);
    let is_bits = |line: &&String| BIT_LINES.iter().any(|start| line.starts_with(start));
    let target_bits: Vec<_> = target.lines.iter().filter(is_bits).cloned().collect();
    assert_eq!(target_bits, host_bits()?);
    Ok(())
}

/// Lines of the host for the same recording: state, each row of the covariance, digests.
fn host_bits() -> Result<Vec<String>> {
    let recording = replay::recording();
    let mut flight = replay::flight_loop(&recording)?;
    while flight.tick() != Tick::Idle {}

    let filter = &flight.estimator().0;
    let covariance = filter.covariance();
    let mut lines = vec![line("state", 0, filter.state())];
    for row in 0..9 {
        let elements = std::array::from_fn(|column| covariance[(row, column)]);
        lines.push(line("covariance", row, elements));
    }
    let mut estimator = SelectedEstimator::uninitialised();
    for &id in EstimatorId::BUILT_IN {
        let digest = replay::digest(&mut estimator, id);
        let digest = digest.map_err(|why| anyhow::anyhow!("{}: {why:?}", id.name()))?;
        lines.push(format!("digest {} {digest:#018x}", id.name()));
    }
    Ok(lines)
}

fn line(name: &str, row: usize, elements: [f32; 9]) -> String {
    let bits = elements.map(|element| format!("{:#010x}", element.to_bits()));
    format!("{name}[{row}] {}", bits.join(" "))
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn panic_is_logged_and_ends_with_failure() -> Result<()> {
    let _alone = crate::alone();
    let run = run("panics", LIMIT)?;
    assert!(!run.success);
    let last = run.lines.last().map(String::as_str).unwrap_or_default();
    assert!(last.starts_with("panicked at fsw-target/src/bin/panics.rs:"), "{:?}", run.lines);
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn image_that_does_not_end_is_stopped_at_the_time_limit() {
    let _alone = crate::alone();
    let error = run("replay", Duration::ZERO).unwrap_err();
    assert!(error.to_string().contains("did not end"), "{error}");
}

#[test]
#[ignore = "needs the Cortex-M target: tests/check.sh runs it"]
fn replay_image_has_no_code_that_panics_allocates_or_emulates_doubles() -> Result<()> {
    let _alone = crate::alone();
    let symbols = image::symbols(&firmware::build("replay")?)?;
    assert!(symbols.iter().any(|name| name == "main"), "the image has no symbol table");

    let unwanted: Vec<_> = symbols.iter().filter(|name| image::is_unwanted(name)).collect();
    assert!(unwanted.is_empty(), "{unwanted:#?}");
    Ok(())
}

/// `host-sim replay` reads log and craft from files, the flight loop from a table in the image.
#[test]
fn simulator_and_flight_loop_compute_the_same_bits_on_the_recorded_flight() -> Result<()> {
    let flights = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fsw-target/flights");
    let mut craft = Craft::load(&flights.join("cubesat_pyramid.craft.toml"))?;
    // The flight loop takes the hardware as known exactly.
    craft.hardware = StatedHardware::ideal(craft.wheels.len());
    let log = RecordedLog::load(&flights.join("cubesat_pyramid.csv"), craft.wheels.len())?;
    let estimator = set_up(&Setup {
        estimator: EstimatorName::JointEkf,
        precision: Precision::F32,
        craft: &craft,
        gyro_noise_rad_s: craft.gyro.noise_rad_s,
        sample_period_s: 0.1,
        refuse_spikes: true,
    })?;
    let replayed = estimate_log(&log.rows, estimator, |_, _, _| ()).estimate;

    let recording = replay::recording();
    let mut flight = replay::flight_loop(&recording)?;
    while flight.tick() != Tick::Idle {}
    let flown = flight.estimator().estimate();
    assert_eq!(replayed.inertia.elements_kg_m2(), flown.inertia.elements_kg_m2().map(f64::from));
    assert_eq!(replayed.covariance_kg2_m4, flown.covariance_kg2_m4.map(f64::from));
    Ok(())
}
