//! Processor in the loop: the flight computer in QEMU and on the host compute the same bits.

use std::sync::atomic::AtomicBool;

use anyhow::{Result, bail};
use fsw_core::Prior;
use fsw_core::hardware::Parameter;
use fsw_core::{Estimator, Status};
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::command::Command;
use fsw_target::link::telemetry::Received;
use host_sim::input::Scenario;
use host_sim::input::craft::WheelLimits;
use host_sim::manoeuvre::{Criterion, Effort, Limits, Request, Treatment, design, flight_table};
use host_sim::pil::compare::After;
use host_sim::pil::firmware::Image;
use host_sim::pil::manoeuvre::{Case, Reached};
use host_sim::pil::software::Software;
use host_sim::pil::{BrokenBit, Mission, PilFailed, PilFlight, fly};
use host_sim::truth::Flight;
use target_tools::board::{Board, MPS2_AN500, MPS2_AN505, STM32F405};
use target_tools::budgets;

/// Seed of the gyro noise and of the true errors of the hardware.
const SEED: u64 = 0;

/// A flight of a scenario.
struct Plan {
    board: Board,
    scenario: &'static str,
    /// Duration, s. None for the whole scenario.
    duration_s: Option<f64>,
    estimator: EstimatorId,
    restart_at: Option<usize>,
    commands: &'static [(usize, Command)],
    broken: Option<BrokenBit>,
}

/// The whole spin-up of STSAT-3 by `window`.
const SPIN_UP: Plan = Plan {
    board: STM32F405,
    scenario: "stsat3-spin-up",
    duration_s: None,
    estimator: EstimatorId::Window,
    restart_at: None,
    commands: &[],
    broken: None,
};

/// Flies firmware and host, and checks the use of the firmware's stack.
fn fly_plan(plan: &Plan) -> Result<Result<PilFlight, PilFailed>> {
    let mut scenario = Scenario::load(plan.scenario)?.of_seed(SEED);
    scenario.duration_s = plan.duration_s.unwrap_or(scenario.duration_s);
    // The flight image takes both as zero.
    scenario.gyro.bias_rad_s.fill(0.0);
    scenario.disturbance_torque_n_m.fill(0.0);
    let flight = Flight::simulate(&scenario)?;
    let mission = Mission {
        scenario: &scenario,
        flight: &flight,
        seed: SEED,
        estimator: plan.estimator,
        restart_at: plan.restart_at,
        commands: plan.commands,
        answering: None,
    };
    let image = Image::find(&plan.board, None)?;
    let flown = fly(&mission, || image.start(), plan.broken, |_, _| ());
    if let Ok(flown) = &flown {
        let stack = flown.stack_high_water_bytes;
        println!("{}, {}: {stack} bytes of stack", plan.scenario, plan.estimator.name());
        let most = budgets::FLIGHT_STACK.held - budgets::INTERRUPTS_STACK;
        assert!(stack > 0 && u64::from(stack) <= most, "{stack} bytes of stack, of {most}");
    }
    Ok(flown)
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn spin_up_has_the_same_bits_on_firmware_and_host() -> Result<()> {
    let flown = fly_plan(&SPIN_UP)??;
    assert_eq!((flown.compared, flown.outcomes.accepted), (6001, 6001));
    assert_eq!(flown.estimator.estimate().status, Status::Converged);
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn wheel_slew_has_the_same_bits_on_firmware_and_host() -> Result<()> {
    let flown = fly_plan(&Plan { scenario: "microsat-slew", ..SPIN_UP })??;
    // The tachometers need three readings before the first speed.
    assert_eq!((flown.compared, flown.outcomes.accepted, flown.wheel_failures), (1501, 1498, 3));
    assert_eq!(flown.wheel_doubts, 0, "healthy tachometers follow their commands");
    assert_eq!(flown.estimator.estimate().status, Status::Converged);
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn other_estimators_have_the_same_bits_on_firmware_and_host() -> Result<()> {
    for estimator in [EstimatorId::JointEkf, EstimatorId::EkfSgfRls] {
        let flown = fly_plan(&Plan { duration_s: Some(60.0), estimator, ..SPIN_UP })??;
        assert_eq!((flown.compared, flown.estimator.selected()), (601, estimator));
    }
    Ok(())
}

/// A Cortex-M7 and a Cortex-M33.
#[test]
#[ignore = "needs the Cortex-M targets and QEMU: tests/check.sh runs it"]
fn other_boards_have_the_same_bits_as_the_host() -> Result<()> {
    for board in [MPS2_AN500, MPS2_AN505] {
        let flown = fly_plan(&Plan { board, duration_s: Some(10.0), ..SPIN_UP })??;
        assert_eq!((flown.compared, flown.outcomes.accepted), (101, 101), "{}", board.feature);
    }
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn flight_with_a_power_cut_has_the_bits_of_a_flight_without() -> Result<()> {
    let whole = Plan { duration_s: Some(60.0), ..SPIN_UP };
    let cut = Plan { restart_at: Some(251), ..whole };
    let [whole, cut] = [fly_plan(&whole)??, fly_plan(&cut)??];
    let (resumed, expected) = (cut.estimator.estimate(), whole.estimator.estimate());
    assert_eq!(resumed.inertia, expected.inertia);
    assert_eq!(resumed.covariance_kg2_m4, expected.covariance_kg2_m4);
    assert_eq!(cut.outcomes, whole.outcomes);
    Ok(())
}

/// Gyro and wheels with errors at data-sheet level, drawn by the seed: scale, axes, delay, filter, spin inertia and
/// axes of the wheels. The flight computer is given one sigma of each.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn imperfect_gyro_and_wheels_have_the_same_bits_on_firmware_and_host() -> Result<()> {
    const SCENARIO: &str = "cubesat-pyramid-data-sheet";
    let scenario = Scenario::load(SCENARIO)?.of_seed(SEED);
    let gyro = &scenario.true_hardware.gyro;
    assert!(gyro.scale.norm() > 0.0 && gyro.delay_s != 0.0, "the errors are drawn");

    for estimator in [EstimatorId::Window, EstimatorId::JointEkf] {
        let flown = fly_plan(&Plan { scenario: SCENARIO, estimator, ..SPIN_UP })??;
        assert_eq!((flown.compared, flown.estimator.selected()), (601, estimator));
        assert_eq!(flown.wheel_doubts, 0, "spin inertia off by its sigma");
        let estimate = flown.estimator.estimate();
        assert_eq!(estimate.status, Status::Converged, "{}", estimator.name());
        assert!(estimate.sigma_random_kg_m2.is_some(), "{}", estimator.name());
    }
    Ok(())
}

/// `window` solves for the time offset of the scenario. The driver removes that of the chip's filter.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn time_offset_is_found_by_the_firmware() -> Result<()> {
    const SCENARIO: &str = "cubesat-pyramid-data-sheet";
    let gyro = Scenario::load(SCENARIO)?.of_seed(SEED).true_hardware.gyro;
    let expected_s = gyro.delay_s + gyro.lag_s;
    let flown = fly_plan(&Plan { scenario: SCENARIO, ..SPIN_UP })??;
    let mut found = None;
    flown.estimator.each_of_hardware(&mut |finding| {
        if finding.parameter == Parameter::Delay {
            found = Some((f64::from(finding.value), f64::from(finding.sigma)));
        }
    });
    let Some((value_s, sigma_s)) = found else { bail!("no time offset among the unknowns") };
    println!("time offset {value_s} s, sigma {sigma_s} s, true {expected_s} s");
    assert!((value_s - expected_s).abs() < 4.0 * sigma_s, "{value_s} +- {sigma_s}: {expected_s}");
    // Stated: 5 ms. Scale, axes and wheels limit the offset, not noise.
    assert!(sigma_s < 4e-3, "the motion shows the offset: {sigma_s}");
    Ok(())
}

/// Each telecommand at least once, most of them during the fastest rotation of the slew.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn telecommands_have_the_same_effect_on_firmware_and_host() -> Result<()> {
    const PRIOR: Prior<f32> = Prior {
        inertia_kg_m2: [2.0, 2.0, 2.0, 0.0, 0.0, 0.0],
        sigma_kg_m2: [1.0, 1.0, 1.0, 0.5, 0.5, 0.5],
    };
    const COMMANDS: [(usize, Command); 13] = [
        (400, Command::SaveCheckpoint),
        (410, Command::DumpCheckpoint),
        (500, Command::CloseWindow),
        (501, Command::OpenWindow),
        (650, Command::SaveCheckpoint),
        (700, Command::SetPrior(PRIOR)),
        (720, Command::SetTorque([1e-3, 0.0, 0.0])),
        (750, Command::Select(EstimatorId::JointEkf)),
        (800, Command::SaveCheckpoint),
        (850, Command::Select(EstimatorId::EkfSgfRls)),
        (900, Command::SaveCheckpoint),
        (950, Command::Select(EstimatorId::Window)),
        (951, Command::Ping),
    ];
    let plan = Plan { scenario: "microsat-slew", commands: &COMMANDS, ..SPIN_UP };
    let flown = fly_plan(&plan)??;
    assert_eq!((flown.compared, flown.estimator.selected()), (1501, EstimatorId::Window));
    Ok(())
}

/// Uploaded, flown to its end, and aborted by each of: limits of rate, excursion and speed, gap, glitch, telecommand,
/// power cut. The wheels answer the torques, and return to their speeds at the start each time.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn manoeuvre_ends_with_the_wheels_at_their_speeds_of_the_start() -> Result<()> {
    let mut scenario = Scenario::load("cubesat-pyramid")?;
    scenario.duration_s = 9.0;
    fly_cases(&scenario, &Case::all())
}

/// From the optimiser to the wheels: a design is uploaded with its limits and flown to its end, without an abort.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn designed_manoeuvre_is_flown_within_the_limits_of_its_upload() -> Result<()> {
    let mut scenario = Scenario::load("cubesat-pyramid")?;
    for wheel in &mut scenario.wheels {
        wheel.wheel.limits =
            WheelLimits { max_torque_n_m: Some(1e-3), max_speed_rad_s: Some(700.0) };
    }
    let request = Request {
        duration_s: 10.0,
        limits: Limits {
            excursion_rad: 5f64.to_radians(),
            rate_rad_s: None,
            torque_share: 1.0,
            momentum_share: 0.9,
            return_rad: 0.1f64.to_radians(),
            keep_out: Vec::new(),
        },
        criterion: Criterion::A,
        treatment: Treatment::Considered,
        uses_prior: true,
        seed: SEED,
        effort: Effort { starts: 1, ..Effort::default() },
    };
    let found = design(&scenario, &request, &AtomicBool::new(false), &|_| ())?;
    let table = flight_table(&scenario, &request, &found)?;
    println!("limits of the upload: {:?}", table.limits);
    scenario.duration_s = request.duration_s + 5.0;
    fly_cases(&scenario, &[Case::whole("design", table)])
}

/// Flies manoeuvres in QEMU and on the host, with wheels that answer.
fn fly_cases(scenario: &Scenario, cases: &[Case]) -> Result<()> {
    let flight = Flight::simulate(scenario)?;
    let image = Image::find(&STM32F405, None)?;
    for case in cases {
        let commands = case.commands();
        let mission = Mission {
            scenario,
            flight: &flight,
            seed: SEED,
            estimator: EstimatorId::Window,
            restart_at: case.restart_at,
            commands: &commands,
            answering: Some(case.answering),
        };
        let mut reached = Reached::default();
        let add = |software: &Software<'_, '_>, telemetry: &[Received]| {
            reached.add(software, telemetry);
        };
        let flown = fly(&mission, || image.start(), None, add)?;
        println!("{}: {} bytes of stack, {reached:?}", case.name, flown.stack_high_water_bytes);
        reached.check(case).map_err(anyhow::Error::msg)?;
    }
    Ok(())
}

/// The bit error is in one gyro reading of the target.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn bit_error_on_the_target_is_detected_and_named() -> Result<()> {
    let broken = Some(BrokenBit { sample: 200, byte: 4, bit: 0 });
    let plan = Plan { duration_s: Some(60.0), broken, ..SPIN_UP };
    match fly_plan(&plan)? {
        Err(PilFailed::Differs(difference)) => {
            assert_eq!(difference.when, After::Sample(200));
            assert!(difference.element.starts_with("estimate "), "{difference}");
            Ok(())
        }
        other => bail!("the bit error was not detected: {other:?}"),
    }
}
