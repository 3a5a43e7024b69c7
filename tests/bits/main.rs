//! Bits of every estimator on every built-in scenario, in both precisions, and of the firmware's
//! recorded flight: a refactoring leaves each of them unchanged.
//!
//! `tests/bits/expected.txt` has one line per flight: scenario, estimator, precision, and the
//! 64-bit FNV-1a digest of the final estimate, rate and innovation. Regenerate it with
//! `BITS_WRITE=1 cargo test -p tests --test bits`.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use clap::ValueEnum;
use fsw_core::Estimator;
use fsw_target::flight::flight_loop::Tick;
use fsw_target::stand_in::replay;
use host_sim::estimation::{EstimatorName, Precision, Setup, estimate_log, set_up};
use host_sim::input::scenario::{Scenario, built_in_names};
use host_sim::simulation::log_of;
use host_sim::truth::Flight;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// FNV-1a, 64 bits, over the little-endian bytes of words.
struct Digest(u64);

impl Digest {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn word(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn floats<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) {
        values.into_iter().for_each(|value| self.word(value.to_bits()));
    }
}

/// The line of one flight.
fn line_of(
    scenario: &Scenario,
    flight: &Flight,
    name: EstimatorName,
    precision: Precision,
) -> String {
    let craft = scenario.craft();
    let label = format!("{} {name} {precision}", scenario.name);
    let estimator = match set_up(&Setup {
        estimator: name,
        precision,
        craft: &craft,
        gyro_noise_rad_s: Some(scenario.gyro.noise_rad_s),
        sample_period_s: 1.0 / scenario.gyro.rate_hz,
        refuse_spikes: true,
    }) {
        Ok(estimator) => estimator,
        Err(_) => return format!("{label} refused"),
    };
    let log = log_of(scenario, flight, 0);
    let mut digest = Digest::new();
    let end = log.len() - 1;
    let mut step = 0;
    let flown = estimate_log(&log, estimator, |_, _, estimator| {
        // The state in mid-flight counts as well as at the end.
        if step % 997 == 0 || step == end {
            digest.floats(estimator.rate_rad_s().iter());
            if let Some(innovation) = estimator.innovation() {
                digest.floats(innovation.rate_rad_s.iter());
                digest.floats(innovation.variance_rad2_s2.iter());
            }
        }
        step += 1;
    });
    let estimate = &flown.estimate;
    digest.floats(estimate.inertia.elements_kg_m2().iter());
    digest.floats(estimate.covariance_kg2_m4.iter());
    digest.floats([&estimate.residual_rms_rad_s]);
    digest.floats(estimate.disturbance_torque_n_m.iter().flatten());
    digest.floats(estimate.gyro_bias_rad_s.iter().flatten());
    digest.word(u64::from(estimate.observed.directions));
    digest.word(u64::from(estimate.observed.scale));
    digest.word(estimate.status as u64);
    digest.word(estimate.residuals_white.map_or(2, u64::from));
    digest.word(u64::from(flown.counts.accepted));
    digest.word(u64::from(flown.changes()));
    format!("{label} {:016x}", digest.0)
}

/// The firmware's recorded flight, flown on the host by the firmware's own loop.
fn recorded_flight() -> String {
    let recording = replay::recording();
    let mut flight = replay::flight_loop(&recording).unwrap();
    while flight.tick() != Tick::Idle {}
    let filter = &flight.estimator().0;
    let mut digest = Digest::new();
    for element in filter.state() {
        digest.word(u64::from(element.to_bits()));
    }
    for element in filter.covariance().iter() {
        digest.word(u64::from(element.to_bits()));
    }
    for element in flight.estimator().estimate().covariance_kg2_m4.iter() {
        digest.word(u64::from(element.to_bits()));
    }
    format!("recorded-flight joint-ekf f32 {:016x}", digest.0)
}

fn all_lines() -> String {
    let names: Vec<_> = built_in_names().collect();
    let next = AtomicUsize::new(0);
    let done = Mutex::new(vec![String::new(); names.len()]);
    let work = || {
        while let Some(name) = names.get(next.fetch_add(1, Ordering::Relaxed)) {
            let scenario = Scenario::load(name).unwrap().of_seed(0);
            let flight = Flight::simulate(&scenario).unwrap();
            let mut lines = String::new();
            for estimator in EstimatorName::value_variants() {
                for precision in [Precision::F32, Precision::F64] {
                    writeln!(lines, "{}", line_of(&scenario, &flight, *estimator, precision))
                        .unwrap();
                }
            }
            let index = names.iter().position(|other| other == name).unwrap();
            done.lock().unwrap()[index] = lines;
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(work);
        }
    });
    let flights = done.into_inner().unwrap().concat();
    format!("{flights}{}\n", recorded_flight())
}

#[test]
fn every_estimator_computes_the_bits_it_did() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("bits/expected.txt");
    let lines = all_lines();
    if std::env::var_os("BITS_WRITE").is_some() {
        std::fs::write(&path, &lines).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    let differ: Vec<_> =
        lines.lines().zip(expected.lines()).filter(|(now, before)| now != before).collect();
    assert!(differ.is_empty(), "{} flights differ: {differ:#?}", differ.len());
    assert_eq!(lines.lines().count(), expected.lines().count());
}
