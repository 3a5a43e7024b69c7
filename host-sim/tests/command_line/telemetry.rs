//! `telemetry`: packets of the flight computer's serial line.

use std::convert::Infallible;
use std::fs;
use std::process::Output;

use assert_cmd::Command;
use embedded_hal_nb::{nb, serial};
use fsw_core::Status;
use fsw_core::monitor::health::Health;
use fsw_core::outcome::OutcomeCounts;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::Downlink;
use fsw_target::link::authentication::{Authentication, Key};
use fsw_target::link::telemetry::{
    BrownOutLevel, CheckpointPart, CheckpointState, ClockSource, EstimateReport, GyroState,
    LINK_VERSION, ResetCause, StatusReport,
};
use fsw_target::link::uplink::UplinkCounters;
use fsw_target::runtime::failure::Kind as FailureKind;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{host_sim, rejected};

/// A serial port that stores the bytes written.
struct Line(Vec<u8>);

impl serial::ErrorType for Line {
    type Error = Infallible;
}

impl serial::Write for Line {
    fn write(&mut self, byte: u8) -> nb::Result<(), Infallible> {
        self.0.push(byte);
        Ok(())
    }

    fn flush(&mut self) -> nb::Result<(), Infallible> {
        Ok(())
    }
}

fn estimate(jxx_kg_m2: f32) -> EstimateReport {
    EstimateReport {
        sample_time_us: 12_300_000,
        estimator: EstimatorId::Window,
        status: Status::Converged,
        outcome: None,
        health: Health::Nominal,
        health_driver: None,
        wheel_follows: [true; 4],
        physical: true,
        projected: false,
        residuals_white: None,
        observed_directions: 6,
        element_observed: [true; 6],
        scale_observed: true,
        inertia_kg_m2: [jxx_kg_m2, 17.3, 20.3, 0.0867, 0.1357, f32::NAN],
        sigma_kg_m2: [1e-3; 6],
        rate_rad_s: [0.1, 0.2, 0.3],
        residual_rms_rad_s: 1.9e-4,
        nis: Some(2.5),
        disturbance_torque_n_m: Some([1e-6, 2e-6, -3e-6]),
        gyro_bias_rad_s: None,
        sigma_systematic_kg_m2: None,
        largest_systematic: None,
        largest_systematic_number: 0,
        time_offset_s: None,
    }
}

const STATUS: StatusReport = StatusReport {
    link_version: LINK_VERSION,
    uptime_s: 12,
    reset_cause: ResetCause::Watchdog,
    failures: 1,
    last_failure: Some(FailureKind::StackOverflow),
    last_failure_at: 0x0800_1234,
    last_failure_from: 0,
    clock: ClockSource::Internal,
    watchdog: true,
    brown_out: BrownOutLevel::Level3,
    option_bytes_as_set: true,
    supply_low: false,
    configuration_intact: true,
    upsets: 0,
    short_lives: 0,
    stack_high_water_bytes: 2100,
    gyro: GyroState::WrongIdentity,
    gyro_identity: Some(0),
    gyro_self_tests_failed: 0,
    gyro_failures: 0,
    wheel_failures: 0,
    wheel_valid: [true; 4],
    data_ready_overruns: 3,
    outcomes: OutcomeCounts {
        accepted: 6001,
        not_finite: 0,
        out_of_range: 0,
        out_of_order: 0,
        stuck: 0,
        spike: 2,
        no_attitude: 0,
        waiting_for_rest: 0,
        gap_resets: 1,
        clock_resets: 0,
        lockout_resets: 0,
        interruption_resets: 0,
        change_resets: 0,
        divergence_resets: 0,
    },
    uplink: UplinkCounters::NONE,
    downlink_dropped: 0,
    serial_errors: 0,
    last_command: None,
    last_sequence_count: 0,
    last_command_done: None,
    authentication: Authentication::Required,
    key_counters: [0, 7, 0],
    key_generations: [0; 3],
    telemetry_slot: None,
    telemetry_period_ms: 1000,
    torque_n_m: [0.0; 3],
    checkpoint: CheckpointState::None,
    checkpoints_saved: 0,
    checkpoints_failed: 0,
};

/// Bytes of an estimate, a status, a part of a checkpoint, another estimate.
fn line() -> Vec<u8> {
    let (mut downlink, mut line) = (Downlink::<2000>::new(), Line(Vec::new()));
    downlink.send(12_345_678, &estimate(14.2), None);
    downlink.send(12_345_679, &STATUS, None);
    downlink.send(12_345_680, &CheckpointPart::new(0, 9, &[0xca, 0xfe, 0]).unwrap(), None);
    downlink.send(12_345_681, &estimate(14.200_001), None);
    downlink.drain(&mut line);
    line.0
}

fn telemetry(bytes: &[u8], arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(["telemetry", "-"])
        .args(arguments)
        .write_stdin(bytes)
        .output()
        .unwrap()
}

#[test]
fn text_has_one_line_per_packet() {
    let output = telemetry(&line(), &[]);
    assert!(output.status.success() && output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4, "{text}");
    for (line, start, within) in [
        (0, "    12.345678 s  estimate 0", "  inertia_kg_m2 14.2000 17.3000 20.3000 0.0867000 "),
        (
            1,
            "    12.345679 s  status 0",
            "  outcomes.accepted 6001  outcomes.spike 2  outcomes.gap_resets 1  ",
        ),
        (2, "    12.345680 s  checkpoint 0", "  index 0  parts 9  bytes 3"),
        (
            3,
            "    12.345681 s  estimate 1",
            "  status converged  health nominal  wheel_follows yes yes ",
        ),
    ] {
        assert!(lines[line].starts_with(start) && lines[line].contains(within), "{text}");
    }
    assert!(!text.contains("gyro_bias"), "a missing value is left out: {text}");
}

#[test]
fn json_has_every_field_to_the_last_bit() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("line.bin");
    fs::write(&file, line()).unwrap();
    let output = host_sim(&["telemetry", file.to_str().unwrap(), "--json"]);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let packets: Vec<Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let kinds: Vec<_> = packets.iter().map(|packet| packet["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["estimate", "status", "checkpoint", "estimate"]);

    let estimate = &packets[3];
    assert_eq!(
        (&estimate["time_us"], &estimate["sequence_count"]),
        (&12_345_681.into(), &1.into())
    );
    let jxx = estimate["inertia_kg_m2"][0].to_string().parse::<f32>().unwrap();
    assert_eq!(jxx.to_bits(), 14.200_001_f32.to_bits());
    assert!(estimate["inertia_kg_m2"][5].is_null() && estimate["gyro_bias_rad_s"].is_null());
    assert!(estimate["outcome"].is_null());
    assert_eq!(estimate["estimator"], "window");

    let status = &packets[1];
    assert_eq!(status["outcomes"]["spike"], 2);
    assert_eq!(status["outcomes"]["gap_resets"], 1);
    assert_eq!(status["uplink"]["replayed"], 0);
    assert_eq!(status["reset_cause"], "watchdog");
    assert_eq!(
        (&status["authentication"], &status["key_counters"][1]),
        (&"required".into(), &7.into())
    );
    assert!(status["tag_slot"].is_null());
    assert_eq!(packets[2]["bytes"], "cafe00");
}

#[test]
fn with_a_key_only_packets_with_its_tag_are_printed() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("slot1.key");
    fs::write(&file, "01".repeat(16)).unwrap();
    let (mut downlink, mut line) = (Downlink::<2000>::new(), Line(Vec::new()));
    for key in [None, Some((1, Key::new([1; 16]))), Some((1, Key::new([2; 16])))] {
        downlink.send(0, &estimate(1.0), key.as_ref());
    }
    downlink.drain(&mut line);
    let output = telemetry(&line.0, &["--json", "--key", file.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    let packets: Vec<Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(packets.len(), 1, "{text}");
    assert_eq!((&packets[0]["sequence_count"], &packets[0]["tag_slot"]), (&1.into(), &1.into()));
    let notes = String::from_utf8_lossy(&output.stderr);
    assert_eq!(notes.matches("without a tag of this key").count(), 2, "{notes}");
}

#[test]
fn damaged_packets_are_noted_and_the_others_printed() {
    let mut damaged = line();
    damaged[48] ^= 1; // first byte of jxx
    // Within the disturbance torque: at the zeros behind it every byte ends a group.
    let output = telemetry(&damaged[..damaged.len() - 60], &[]);
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 2);
    let notes = String::from_utf8_lossy(&output.stderr);
    let notes: Vec<&str> = notes.lines().collect();
    assert!(notes.len() == 2 && notes[0].contains("checksum"), "{notes:?}");
    assert!(notes[1].contains("truncated frame"), "{notes:?}");
}

#[test]
fn gap_in_the_sequence_count_is_noted() {
    let (mut downlink, mut line) = (Downlink::<200>::new(), Line(Vec::new()));
    for _ in 0..3 {
        downlink.send(0, &estimate(1.0), None);
    }
    downlink.drain(&mut line);
    downlink.send(0, &estimate(1.0), None);
    downlink.drain(&mut line);
    let output = telemetry(&line.0, &[]);
    assert_eq!(String::from_utf8_lossy(&output.stderr), "note: missing before estimate 3: 2\n");
}

#[test]
fn bytes_without_telemetry_are_rejected() {
    rejected(&telemetry(b"", &[]), &["-", "no telemetry packet in 0 bytes"]);
    rejected(&telemetry(b"Hello, world\n", &["--json"]), &["no telemetry packet in 13 bytes"]);
    rejected(&host_sim(&["telemetry", "no/such/port"]), &["no/such/port", "cannot be read"]);
    rejected(&host_sim(&["telemetry"]), &["FILE"]);
}
