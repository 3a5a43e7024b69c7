//! `examples/replay.c` on the host and on a Cortex-M4F in QEMU: the bits of `fsw-core` called from Rust, after each
//! sample. `examples/cfs`, `examples/fprime` and
//! `examples/freertos` against stubs of their frameworks.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

mod build;
mod flights;

use build::{Library, compile_on_host, compile_on_target, run, run_in_qemu};
use flights::{Row, spin_up, wheel_slew};
use fsw_core::estimator::joint_ekf::{self, JointEkfUd};
use fsw_core::estimator::window::{self, Window};
use fsw_core::hardware::{Disturbance, Hardware};
use fsw_core::{Estimate, Estimator, Outcome, Sample, Status, Vec3, WheelArray};
use std::fmt::Write;

/// Stack that a task needs which calls every function, without its own frames and those of interrupts: `fsw-core/docs/c.md`.
const STACK: u32 = 7_168;

/// Words of 32-bit FNV-1a, as in `replay.c`.
fn mix(hash: u32, word: u32) -> u32 {
    (hash ^ word).wrapping_mul(0x0100_0193)
}

/// Hash of what a step and an estimate return, as in `replay.c`.
fn hash_of(code: u32, estimator: &impl Estimator<f32, 4>, estimate: &Estimate<f32>) -> u32 {
    let mut hash = mix(0x811c_9dc5, code);
    let (rate, innovation) = (estimator.rate_rad_s(), estimator.innovation());
    for i in 0..3 {
        hash = mix(hash, rate[i].to_bits());
        hash = mix(hash, innovation.map_or(0.0, |innovation| innovation.rate_rad_s[i]).to_bits());
    }
    hash = mix(mix(hash, status(estimate)), estimate.observed.directions.into());
    for (i, element) in estimate.inertia.elements_kg_m2().iter().enumerate() {
        hash = mix(hash, element.to_bits());
        for k in 0..6 {
            hash = mix(hash, estimate.covariance_kg2_m4[(i, k)].to_bits());
        }
    }
    mix(hash, estimate.residual_rms_rad_s.to_bits())
}

fn status(estimate: &Estimate<f32>) -> u32 {
    match estimate.status {
        Status::Converged => 0,
        Status::Partial => 1,
        Status::Unobservable => 2,
        Status::Diverged => 3,
    }
}

/// Number of an outcome in the header.
fn code(outcome: &Outcome) -> u32 {
    match outcome.name() {
        "updated" => 0,
        "spike" => 5,
        "aligning" => 6,
        "reset_first_sample" => 16,
        "reset_aligned" => 17,
        other => panic!("{other}: not expected in these flights"),
    }
}

fn wheels() -> WheelArray<f32, 4> {
    let flights::fsw_wheels { axis, spin_inertia_kg_m2 } = flights::pyramid();
    WheelArray::new(axis.map(Vec3::from), spin_inertia_kg_m2).unwrap()
}

/// Lines of one flight and one estimator; `work` is called after each step.
fn lines<E: Estimator<f32, 4>>(
    title: &str,
    rows: &[Row],
    mut estimator: E,
    work: fn(&mut E),
) -> String {
    let mut text = String::new();
    for (k, row) in rows.iter().enumerate() {
        let outcome = estimator.step(&Sample {
            time_us: row.time_us,
            rate_rad_s: row.rate_rad_s.into(),
            wheel_speed_rad_s: row.wheel_speed_rad_s,
            torque_n_m: row.torque_n_m.into(),
            attitude: None,
        });
        work(&mut estimator);
        let hash = hash_of(code(&outcome), &estimator, &estimator.estimate());
        writeln!(text, "{title} {k:08x} {:08x} {hash:08x}", code(&outcome)).unwrap();
    }
    estimator.finish();
    let estimate = estimator.estimate();
    write!(text, "{title} end {:08x}", status(&estimate)).unwrap();
    let sigma = estimate.sigma_kg_m2();
    for (element, sigma) in estimate.inertia.elements_kg_m2().iter().zip(sigma) {
        write!(text, " {:08x} {:08x}", element.to_bits(), sigma.to_bits()).unwrap();
    }
    text + "\n"
}

/// Output of `replay.c`, by `fsw-core` without the C interface.
fn expected() -> String {
    let mut text = String::new();
    for (flight, rows, noise) in
        [("spin-up", spin_up(), 1.8151e-4), ("wheel-slew", wheel_slew(), 1e-4)]
    {
        let config = window::Config { slices_per_step: 0, ..window::Config::new(noise) };
        let estimator = Window::<f32, 4, 512, 18, 7>::new(config, wheels()).unwrap();
        text += &lines(&format!("{flight} window"), &rows, estimator, |window| {
            window.work(4);
        });
        let filter = JointEkfUd::<f32, 4, 30>::considering(
            joint_ekf::Config::new(noise),
            wheels(),
            &Hardware::ideal(),
            &Disturbance::none(),
        );
        text += &lines(&format!("{flight} joint-ekf"), &rows, filter.unwrap(), |_| {});
    }
    text + "done\n"
}

/// Compares line by line: the first that differs is printed.
fn assert_same(printed: &str) {
    let expected = expected();
    let has_bits = |line: &&str| !line.starts_with('#');
    for (c, rust) in printed.lines().filter(has_bits).zip(expected.lines()) {
        assert_eq!(c, rust);
    }
    assert_eq!(printed.lines().filter(has_bits).count(), expected.lines().count());
}

/// The recording of the examples is that of the firmware, in single precision.
#[test]
fn wheel_slew_is_the_recorded_flight() {
    let csv = include_str!("../../../fsw-target/flights/cubesat_pyramid.csv");
    let rows = wheel_slew();
    assert_eq!(rows.len(), csv.lines().count() - 1);
    for (line, row) in csv.lines().skip(1).zip(&rows) {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        assert_eq!(row.time_us, (numbers[0] * 1e6).round() as u64);
        let of_row = [&row.rate_rad_s[..], &row.wheel_speed_rad_s, &row.torque_n_m].concat();
        assert_eq!(of_row, numbers[1..].iter().map(|x| *x as f32).collect::<Vec<_>>());
    }
}

#[test]
fn c_on_the_host_has_the_bits_of_rust() {
    let library = Library::of_host();
    let program =
        compile_on_host(&library, &["-Iinclude", "examples/replay.c", "examples/port_host.c"]);
    assert_same(&run(&program));
}

#[test]
#[ignore = "builds for the Cortex-M: needs its Rust target, arm-none-eabi-gcc and QEMU"]
fn c_on_the_target_has_the_bits_of_rust() {
    let library = Library::of_target();
    let program =
        compile_on_target(&library, &["-Iinclude", "examples/replay.c", "examples/target/port.c"]);
    let printed = run_in_qemu(&program);
    assert_same(&printed);
    let mut deepest = 0;
    for line in printed.lines().filter(|line| line.contains("instructions")) {
        println!("{line}");
        let stack: u32 = line.rsplit(' ').next().unwrap().parse().unwrap();
        deepest = deepest.max(stack);
    }
    assert!(deepest > 0 && deepest <= STACK, "{deepest} bytes of stack, of {STACK}");
    build::assert_no_panic(&program);
}

/// Two starts of the application: samples, telemetry, critical data store; the second start continues from it.
#[test]
fn cfs_application_runs_against_stubs() {
    let library = Library::of_host();
    let sources = [
        "examples/cfs/fsw_inertia_app.c",
        "examples/cfs/stubs/cfe_stubs.c",
        "-Iexamples/cfs",
        "-Iexamples/cfs/stubs",
        "-Iinclude",
    ];
    let printed = run(&compile_on_host(&library, &sources));
    assert!(printed.contains("CDS is new"), "{printed}");
    assert!(printed.contains("state restored"), "{printed}");
    assert!(printed.trim_end().ends_with("status 0, 6 directions"), "{printed}");
}

/// Three tasks and a mutex: sample, work, telemetry.
#[test]
fn freertos_tasks_run_against_stubs() {
    let library = Library::of_host();
    let sources = [
        "examples/freertos/inertia_tasks.c",
        "examples/freertos/stubs/main.c",
        "-Iexamples/freertos",
        "-Iexamples/freertos/stubs",
        "-Iinclude",
    ];
    let printed = run(&compile_on_host(&library, &sources));
    assert!(printed.trim_end().ends_with("status 0, 6 directions"), "{printed}");
}

#[test]
fn f_prime_component_runs_against_stubs() {
    let library = Library::of_host();
    let sources = [
        "examples/fprime/InertiaEstimator.cpp",
        "examples/fprime/stubs/main.cpp",
        "-Iexamples/fprime",
        "-Iexamples/fprime/stubs",
        "-Iinclude",
    ];
    let printed = run(&build::compile_cpp_on_host(&library, &sources));
    assert!(printed.trim_end().ends_with("status 0, 6 directions"), "{printed}");
}
