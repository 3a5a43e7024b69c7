//! Sensors, telecommands, checkpoints and telemetry of the flight computer.

extern crate std;
use super::super::checkpoints::MAX_BYTES;
use super::super::*;
use super::world::*;
use crate::flight::selected::EstimatorId;
use crate::link::frame::Frame;
use crate::link::packet::SequenceCount;
use crate::link::telemetry::{CheckpointState, Telemetry};
use crate::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};
use fsw_core::estimator::window::Remaining;
use fsw_core::monitor::health::HealthMonitor;
use fsw_core::{Estimator, Status, Vec3};
use std::vec;
use std::vec::Vec;

#[test]
fn telemetry_equals_the_estimator_bit_for_bit() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let mut reference = SelectedEstimator::new(CRAFT).unwrap();
    let mut health = HealthMonitor::default();
    for row in &ROWS {
        let outcome = reference.step(&fsw_core::Sample {
            time_us: row.time_us,
            rate_rad_s: Vec3::from(row.rate_rad_s),
            wheel_speed_rad_s: row.wheel_speed_rad_s,
            torque_n_m: Vec3::from(row.torque_n_m),
            attitude: None,
        });
        health.step(&outcome);
        reference.work(SLICES_PER_SAMPLE);
        let (time_us, outcome) = (row.time_us, Some(outcome));
        let id = EstimatorId::Window;
        let wheels = [true; WHEELS];
        let expected = EstimateReport::of(id, &reference, time_us, outcome, &mut health, wheels);
        assert_eq!(estimates(&ground.poll(1)), [expected]);
    }
    assert_eq!(reference.estimate().status, Status::Converged);
}

#[test]
fn the_telemetry_period_is_commandable() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::Every(1_000));
    let sent = ground.poll(100);
    assert_eq!((statuses(&sent).len(), estimates(&sent).len()), (10, 10));
    ground.command(Command::SetTelemetryPeriod { ms: 200 });
    let sent = ground.poll(100);
    assert_eq!((statuses(&sent).len(), estimates(&sent).len()), (50, 50));
}

#[test]
fn every_telecommand_has_a_status_report_with_its_result() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    assert_eq!(ground.command(Command::Ping).last_command_done, Some(true));
    let no_nominal = ground.command(Command::Select(EstimatorId::EkfSgfRls));
    assert_eq!(no_nominal.last_command_done, Some(false));
    assert_eq!(ground.command(Command::SetPrior(PRIOR)).last_command_done, Some(true));
    let selected = ground.command(Command::Select(EstimatorId::EkfSgfRls));
    assert_eq!(selected.last_command_done, Some(true));
    assert_eq!(ground.command(Command::OpenWindow).last_command_done, Some(false), "no windows");
    assert_eq!(ground.command(Command::SetTorque([0.1, 0.0, 0.0])).torque_n_m, [0.1, 0.0, 0.0]);
    assert_eq!(estimates(&ground.poll(1))[0].estimator, EstimatorId::EkfSgfRls);
}

#[test]
fn a_restarted_computer_continues_from_its_checkpoint() {
    for id in EstimatorId::ALL {
        let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
        ground.command(Command::SetPrior(PRIOR));
        ground.command(Command::Select(id));
        ground.poll(300);
        // Telecommands are executed before the next sample.
        let before = ground.computer.estimator().estimate();
        let saved = ground.command(Command::SaveCheckpoint);
        // The first one was saved ten seconds after the telecommands.
        assert_eq!((saved.last_command_done, saved.checkpoints_saved), (Some(true), 2));
        let flash = ground.world.0.flash.borrow().clone();

        let mut again = Ground::new(&ROWS[303..], flash, Reporting::EachSample);
        let after = again.computer.estimator();
        assert_eq!((after.selected(), after.estimate()), (id, before));
        assert!(again.world.0.now_us.get() > ground.world.0.now_us.get());
        let status = again.command(Command::Ping);
        assert!(
            status.uptime_s < 2,
            "{} s since the start, not since the first one",
            status.uptime_s
        );
    }
}

#[test]
fn a_dump_contains_the_whole_checkpoint() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.command(Command::Select(EstimatorId::JointEkf));
    assert_eq!(
        ground.command(Command::DumpCheckpoint).last_command_done,
        Some(false),
        "no checkpoint"
    );
    ground.command(Command::SaveCheckpoint);
    ground.command(Command::DumpCheckpoint);
    let mut bytes = Vec::new();
    let (mut next, mut parts) = (0, 0);
    // Starts again: the first parts were sent with the status report.
    ground.command(Command::DumpCheckpoint);
    for telemetry in ground.poll(200) {
        if let Telemetry::Checkpoint(part) = telemetry {
            next = part.index + 1;
            parts = part.parts;
            bytes.extend_from_slice(part.bytes());
        }
    }
    assert!(parts > 3 && next == parts, "{next} of {parts}");
    assert!(ground.world.0.flash.borrow().windows(bytes.len()).any(|stored| stored == bytes));
}

#[test]
fn an_absent_gyro_is_reported_and_started_once_it_answers() {
    let mut ground = Ground::with_gyro(&ROWS, erased(), Reporting::Every(1_000), false);
    let sent = ground.poll(45);
    let status = statuses(&sent).last().copied().unwrap();
    assert_eq!((status.gyro, status.gyro_identity), (GyroState::WrongIdentity, Some(0xff)));
    assert!(status.gyro_failures > 30 && status.outcomes.accepted == 0);
    assert_eq!(ground.world.0.gyro_starts.get(), 5, "at the start, then once a second");
    assert_eq!(
        ground.world.0.feeds.get(),
        5 + 45,
        "every stage of the start and every round completes"
    );

    ground.world.0.gyro_is_absent.set(false);
    let sent = ground.poll(30);
    let status = statuses(&sent).last().copied().unwrap();
    assert_eq!((status.gyro, status.gyro_identity), (GyroState::Ready, Some(0x42)));
    assert_eq!(status.gyro_self_tests_failed, 0);
    assert!(status.outcomes.accepted > 10);
}

#[test]
fn a_gyro_that_fails_its_self_test_is_reported_and_used() {
    let mut ground = Ground::with_gyro(&ROWS, erased(), Reporting::Every(1_000), false);
    ground.world.0.gyro_is_absent.set(false);
    ground.world.0.gyro_fails_its_test.set(true);
    let sent = ground.poll(45);
    let status = statuses(&sent).last().copied().unwrap();
    assert_eq!((status.gyro, status.gyro_identity), (GyroState::SelfTestFailed, Some(0x42)));
    assert_eq!(status.gyro_self_tests_failed, 1);
    assert!(status.outcomes.accepted > 20);
}

#[test]
fn wheel_errors_do_not_restart_the_gyro() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::Every(1_000));
    let starts = ground.world.0.gyro_starts.get();
    ground.world.0.wheels_fail.set(true);
    let sent = ground.poll(100);
    let status = statuses(&sent).last().copied().unwrap();
    assert!(status.wheel_failures > 80 && status.outcomes.accepted == 0);
    assert_eq!(ground.world.0.gyro_starts.get(), starts);
}

#[test]
fn queued_telecommands_have_one_status_report_each() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let rejected = Command::Select(EstimatorId::EkfSgfRls); // without a prior
    for (count, command) in [(1, rejected), (2, Command::Ping), (3, Command::Ping)] {
        let packet = command.packet(SequenceCount::new(count)).unwrap();
        let frame = Frame::of(packet.bytes()).unwrap();
        ground.world.0.to_computer.borrow_mut().extend(frame.bytes());
    }
    let sent = ground.poll(3);
    let results: Vec<_> = statuses(&sent)
        .iter()
        .map(|status| (status.last_sequence_count, status.last_command_done))
        .collect();
    assert_eq!(results, [(1, Some(false)), (2, Some(true)), (3, Some(true))]);
}

#[test]
fn a_checkpoint_follows_a_change_by_telecommand() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.poll(10);
    ground.command(Command::SetPrior(PRIOR));
    ground.command(Command::Select(EstimatorId::EkfSgfRls));
    ground.poll(101);
    assert_eq!(ground.command(Command::Ping).checkpoints_saved, 1, "one for both telecommands");
    let flash = ground.world.0.flash.borrow().clone();
    let again = Ground::new(&ROWS[303..], flash, Reporting::EachSample);
    let estimator = again.computer.estimator();
    assert_eq!((estimator.selected(), estimator.prior()), (EstimatorId::EkfSgfRls, Some(PRIOR)));
}

/// The fit over the window's blocks takes more slices than one sample has.
#[test]
fn a_window_closed_by_telecommand_is_completed_with_the_samples_that_follow() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    ground.poll(400);
    ground.command(Command::CloseWindow);
    let mut complete = ground.computer.estimator().clone();
    complete.work(100_000);
    let mut samples = 0;
    let is_complete =
        |ground: &Ground| ground.computer.estimator().clone().work(1) == Remaining::Nothing;
    while samples < 300 && !is_complete(&ground) {
        ground.poll(1);
        samples += 1;
    }
    assert!(samples > 1 && samples < 300, "{samples}");
    // The last block has a neighbour now, and a time offset is read from both: the result differs by rounding.
    let found = ground.computer.estimator().estimate().inertia.elements_kg_m2();
    let expected = complete.estimate().inertia.elements_kg_m2();
    let largest = expected.iter().fold(0.0f32, |most, x| most.max(*x));
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 4.0 * f32::EPSILON * largest, "{found} {expected}");
    }
    assert_eq!(complete.estimate().status, Status::Converged);
}

/// Flash whose halves hold one checkpoint of the largest estimator.
fn small_flash() -> Vec<u8> {
    let checkpoint = MAX_BYTES.next_multiple_of(1024);
    vec![0xff; 2 * (checkpoint + 1024)]
}

/// Longest erasure of a sector of an STM32F405, µs: twice `GYRO_SILENCE_US`.
const ERASURE_US: u64 = 2_000_000;

#[test]
fn an_erasure_does_not_restart_the_gyro() {
    let mut ground = Ground::new(&ROWS, small_flash(), Reporting::EachSample);
    ground.world.0.erasure_us.set(ERASURE_US);
    let (starts, erasures) = (ground.world.0.gyro_starts.get(), ground.world.0.erasures.get());
    for _ in 0..20 {
        ground.command(Command::SaveCheckpoint);
        ground.poll(5);
    }
    assert!(ground.world.0.erasures.get() > erasures);
    assert_eq!(ground.world.0.gyro_starts.get(), starts);
}

/// Three manoeuvres with a save in each, every one followed by two minutes of steady rotation, in which
/// the window closes.
#[test]
fn space_for_a_save_is_erased_at_rest() {
    const MANOEUVRE: usize = 200;
    const QUIET: usize = 1_200;
    let mut rows = Vec::new();
    for _ in 0..3 {
        rows.extend_from_slice(&ROWS[..MANOEUVRE]);
        for k in 0..QUIET {
            let mut row = ROWS[MANOEUVRE];
            // Small gyro noise: constant readings would count as stuck.
            row.rate_rad_s[k % 3] += 1e-5 * (k % 7) as f32;
            rows.push(row);
        }
    }
    for (k, row) in (0..).zip(&mut rows) {
        row.time_us = 100_000 * k;
    }
    let mut ground = Ground::new(Vec::leak(rows), small_flash(), Reporting::EachSample);
    let erasures = |ground: &Ground| ground.world.0.erasures.get();
    assert_eq!(erasures(&ground), 1, "new flash");
    for manoeuvre in 1..=3 {
        ground.poll(MANOEUVRE as u32 - 50);
        assert!(!ground.computer.estimator().is_at_rest());
        assert_eq!(ground.command(Command::SaveCheckpoint).last_command_done, Some(true));
        assert_eq!(erasures(&ground), manoeuvre, "no erasure in the manoeuvre");
        ground.poll(QUIET as u32 + 49);
        assert!(ground.computer.estimator().is_at_rest());
        assert_eq!(erasures(&ground), manoeuvre + 1, "no space for another checkpoint");
    }
}

#[test]
fn noise_on_the_link_is_counted_and_ignored() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let mut state = 1_u32;
    let noise = core::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    ground.world.0.to_computer.borrow_mut().extend(noise.take(3_000));
    assert_eq!(estimates(&ground.poll(60)).len(), 60);
    let status = ground.command(Command::Ping);
    let uplink = status.uplink;
    assert_eq!(uplink.accepted, 1);
    assert!(uplink.truncated + uplink.malformed + uplink.wrong_checksum > 0, "{uplink:?}");
}

#[test]
fn the_computer_runs_without_flash() {
    let mut ground = Ground::new(&ROWS, Vec::new(), Reporting::EachSample);
    assert_eq!(estimates(&ground.poll(10)).len(), 10);
    let status = ground.command(Command::SaveCheckpoint);
    assert_eq!((status.last_command_done, status.checkpoints_failed), (Some(false), 1));
    assert_eq!(status.checkpoint, CheckpointState::Failed);
}

/// Against the division of 64 bits, at the limits of each digit and of the result.
#[test]
fn seconds_are_whole_and_saturate() {
    for time_us in
        [0, 999_999, 1_000_000, 4_294_967_296, 90_061_000_001, u64::from(u32::MAX) * 1_000_000]
    {
        assert_eq!(u64::from(seconds(time_us)), time_us / 1_000_000);
    }
    assert_eq!(seconds(u64::MAX), u32::MAX);
}
