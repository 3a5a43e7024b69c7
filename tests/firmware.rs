//! The firmware image in QEMU: it ends as it should, and computes what the host computes.

use anyhow::Result;
use fsw_core::Estimator;
use fsw_target::flight::flight_loop::Tick;
use fsw_target::stand_in::replay;
use host_sim::estimation::{EstimatorName, Precision, Setup, estimate_log, set_up};
use host_sim::input::{Craft, RecordedLog};
use std::path::Path;
use std::time::Duration;
use target_tools::{firmware, image, qemu};

/// The replay takes less than a second in QEMU; a busy machine may take far longer.
const LIMIT: Duration = Duration::from_secs(120);

/// The lines in which `bin/replay` reports states and covariance elements, as bits of `f32`.
const BIT_LINES: [&str; 2] = ["state[", "covariance["];

fn run(bin: &str, limit: Duration) -> Result<qemu::Run> {
    qemu::run(&firmware::build(bin)?, qemu::MACHINE, limit, |_| {})
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn target_and_host_come_to_the_same_bits() -> Result<()> {
    let target = run("replay", LIMIT)?;
    assert!(target.success, "the image reported a failure: {:#?}", target.lines);

    let is_bits = |line: &&String| BIT_LINES.iter().any(|start| line.starts_with(start));
    let target_bits: Vec<_> = target.lines.iter().filter(is_bits).cloned().collect();
    assert_eq!(target_bits, host_bits()?);
    Ok(())
}

/// Flies the same recording on the host; one line for the state and one for each row of its
/// covariance.
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
    Ok(lines)
}

fn line(name: &str, row: usize, elements: [f32; 9]) -> String {
    let bits = elements.map(|element| format!("{:#010x}", element.to_bits()));
    format!("{name}[{row}] {}", bits.join(" "))
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn a_panic_is_logged_and_reported_as_a_failure() -> Result<()> {
    let run = run("panics", LIMIT)?;
    assert!(!run.success);
    let last = run.lines.last().map(String::as_str).unwrap_or_default();
    assert!(last.starts_with("panicked at fsw-target/src/bin/panics.rs:"), "{:?}", run.lines);
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn an_image_that_does_not_end_is_ended() {
    let error = run("replay", Duration::ZERO).unwrap_err();
    assert!(error.to_string().contains("still running"), "{error}");
}

#[test]
#[ignore = "needs the Cortex-M target: tests/check.sh runs it"]
fn the_flight_image_has_no_code_that_panics_allocates_or_emulates_doubles() -> Result<()> {
    let symbols = image::symbols(&firmware::build("replay")?)?;
    assert!(symbols.iter().any(|name| name == "main"), "the image has lost its symbol table");

    let unwanted: Vec<_> = symbols.iter().filter(|name| image::is_unwanted(name)).collect();
    assert!(unwanted.is_empty(), "{unwanted:#?}");
    Ok(())
}

/// The committed log is an ordinary one: `host-sim replay` reads the two files and comes to the
/// same bits as the flight loop, which got them as a table.
#[test]
fn the_simulator_replays_the_committed_flight_to_the_same_bits() -> Result<()> {
    let flights = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fsw-target/flights");
    let craft = Craft::load(&flights.join("cubesat_pyramid.craft.toml"))?;
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
