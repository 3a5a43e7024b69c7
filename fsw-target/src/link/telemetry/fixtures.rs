//! Test reports.

use super::{
    BrownOutLevel, CheckpointPart, CheckpointState, ClockSource, EstimateReport, GyroState,
    HardwareError, LINK_VERSION, ManoeuvreReport, ResetCause, StatusReport, TableFault, Telemetry,
};
use crate::link::authentication::Authentication;
use crate::link::command::Function;
use crate::link::uplink::UplinkCounters;
use crate::link::wire::{Coded, Reader, Wire};
use crate::runtime::failure::Kind;
use fsw_core::manoeuvre::{Abort, State};
use fsw_core::monitor::health::{Driver, Health};
use fsw_core::outcome::OutcomeCounts;
use fsw_core::{Outcome, Status};
use fsw_roster::EstimatorId;
use proptest::prelude::*;

/// A report with a value in every field.
pub fn estimate() -> EstimateReport {
    EstimateReport {
        sample_time_us: 123_400_000,
        estimator: EstimatorId::JointEkf,
        status: Status::Converged,
        outcome: Some(Outcome::Updated),
        health: Health::Degraded,
        health_driver: Some(Driver::Residuals),
        wheel_follows: [true, true, false, true],
        physical: true,
        projected: false,
        residuals_white: Some(true),
        observed_directions: 6,
        element_observed: [true, true, true, false, true, false],
        scale_observed: true,
        inertia_kg_m2: [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016],
        sigma_kg_m2: [1e-3, 2e-3, 3e-3, 4e-4, 5e-4, 6e-4],
        rate_rad_s: [0.1, -0.2, 0.3],
        residual_rms_rad_s: 1.9e-4,
        nis: Some(2.5),
        disturbance_torque_n_m: Some([1e-6, 2e-6, -3e-6]),
        gyro_bias_rad_s: Some([1e-5, 2e-5, -3e-5]),
        sigma_systematic_kg_m2: Some([8e-4, 1e-3, 2e-3, 3e-4, 4e-4, 5e-4]),
        largest_systematic: Some(HardwareError::WheelInertia),
        largest_systematic_number: 2,
        time_offset_s: Some([1.2e-2, 3e-4]),
    }
}

/// A report with a value in every field.
pub fn status() -> StatusReport {
    let outcomes = OutcomeCounts { accepted: 6001, spike: 2, ..OutcomeCounts::default() };
    StatusReport {
        link_version: LINK_VERSION,
        uptime_s: 600,
        reset_cause: ResetCause::Watchdog,
        failures: 10,
        last_failure: Some(Kind::Panic),
        last_failure_at: 71,
        last_failure_from: 0x0800_1234,
        clock: ClockSource::Crystal,
        watchdog: true,
        brown_out: BrownOutLevel::Level3,
        option_bytes_as_set: true,
        supply_low: false,
        configuration_intact: true,
        upsets: 2,
        short_lives: 1,
        stack_high_water_bytes: 2100,
        gyro: GyroState::Ready,
        gyro_identity: Some(0x0f),
        gyro_self_tests_failed: 11,
        gyro_failures: 1,
        wheel_failures: 2,
        wheel_valid: [true, false, true, true],
        data_ready_overruns: 3,
        outcomes,
        uplink: UplinkCounters { accepted: 4, replayed: 5, ..UplinkCounters::NONE },
        downlink_dropped: 6,
        serial_errors: 7,
        last_command: Some(Function::SetTorque),
        last_sequence_count: 16_383,
        last_command_done: Some(true),
        authentication: Authentication::Required,
        key_counters: [12, 345, 0],
        key_generations: [0, 11, 0],
        telemetry_slot: Some(1),
        telemetry_period_ms: 1000,
        torque_n_m: [1e-3, -2e-3, 5e-4],
        checkpoint: CheckpointState::RestoredOlder,
        checkpoints_saved: 8,
        checkpoints_failed: 9,
    }
}

/// A report with a value in every field.
pub fn manoeuvre() -> ManoeuvreReport {
    ManoeuvreReport {
        state: State::Resting,
        abort: Some(Abort::Excursion),
        table_checksum: Some(0xcbf4_3926),
        table_error: Some(TableFault::Torque),
        table_error_wheel: 2,
        segments: 0x000f_ffff,
        flown_us: 12_300_000,
        repeat: 1,
        knot: 44,
        peak_rate_rad_s: 0.02,
        peak_excursion_rad: 0.035,
        start_speed_rad_s: [100.0, -100.0, 50.0, 0.0],
        torque_n_m: [1e-3, -5e-4, 0.0, 2e-4],
    }
}

/// One packet of each kind.
pub fn one_of_each() -> [Telemetry; 4] {
    let part = CheckpointPart::new(3, 7, &[1, 2, 3, 0xff]).unwrap();
    [
        Telemetry::Estimate(estimate()),
        Telemetry::Status(status()),
        Telemetry::Checkpoint(part),
        Telemetry::Manoeuvre(manoeuvre()),
    ]
}

fn any_of<C: Coded + core::fmt::Debug>() -> impl Strategy<Value = C> {
    (0..C::CODES.len()).prop_map(|i| C::of_code(C::CODES[i].0).unwrap())
}

fn any_bits<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    any::<[u32; N]>().prop_map(|bits| bits.map(f32::from_bits))
}

/// Any report, with any bits in every number.
pub fn any_estimate() -> impl Strategy<Value = EstimateReport> {
    let health = (any_of(), proptest::option::of(any_of()), any::<[bool; 4]>());
    let words = (any_of(), any_of(), proptest::option::of(any_of::<Outcome>()), health);
    let flags = (any::<[bool; 3]>(), any::<Option<bool>>(), any::<[bool; 6]>());
    let numbers = (any_bits(), any_bits(), any_bits(), any_bits::<2>());
    let optional =
        (any::<bool>(), proptest::option::of(any_bits()), proptest::option::of(any_bits()));
    let hardware = (
        proptest::option::of(any_bits()),
        proptest::option::of(any_of()),
        any::<u8>(),
        proptest::option::of(any_bits()),
    );
    (any::<u64>(), any::<u8>(), words, flags, numbers, optional, hardware).prop_map(
        |(sample_time_us, observed_directions, words, flags, numbers, optional, hardware)| {
            EstimateReport {
                sample_time_us,
                estimator: words.0,
                status: words.1,
                outcome: words.2,
                health: words.3.0,
                health_driver: words.3.1,
                wheel_follows: words.3.2,
                physical: flags.0[0],
                projected: flags.0[1],
                residuals_white: flags.1,
                observed_directions,
                element_observed: flags.2,
                scale_observed: flags.0[2],
                inertia_kg_m2: numbers.0,
                sigma_kg_m2: numbers.1,
                rate_rad_s: numbers.2,
                residual_rms_rad_s: numbers.3[0],
                nis: optional.0.then_some(numbers.3[1]),
                disturbance_torque_n_m: optional.1,
                gyro_bias_rad_s: optional.2,
                sigma_systematic_kg_m2: hardware.0,
                largest_systematic: hardware.1,
                largest_systematic_number: hardware.2,
                time_offset_s: hardware.3,
            }
        },
    )
}

/// Any report, with finite numbers.
pub fn any_status() -> impl Strategy<Value = StatusReport> {
    let words = (any_of(), any_of(), any_of(), any_of(), any_of(), any_of());
    let events = (proptest::option::of(any_of()), proptest::option::of(any_of()));
    let optional = (any::<Option<u8>>(), any::<Option<bool>>(), any::<bool>(), any::<u16>());
    let keys = (any::<[[u32; 3]; 2]>(), any::<Option<u8>>(), any::<[u8; 3]>(), any::<[bool; 7]>());
    let torque = proptest::array::uniform3(-100.0_f32..100.0);
    // Outcomes and uplink counters.
    let counters = proptest::collection::vec(any::<u8>(), 4 * (14 + 11));
    (words, events, optional, keys, torque, any::<[u32; 14]>(), counters).prop_map(
        |(words, events, optional, keys, torque_n_m, n, counters)| {
            let mut reader = Reader::new(&counters);
            let (slots, telemetry_slot, [link_version, short_lives, upsets], flags) = keys;
            StatusReport {
                link_version,
                uptime_s: n[0],
                reset_cause: words.0,
                failures: n[10],
                last_failure: events.0,
                last_failure_at: n[11],
                last_failure_from: n[12],
                clock: words.1,
                watchdog: optional.2,
                brown_out: words.4,
                option_bytes_as_set: flags[4],
                supply_low: flags[5],
                configuration_intact: flags[6],
                upsets,
                short_lives,
                stack_high_water_bytes: n[1],
                gyro: words.2,
                gyro_identity: optional.0,
                gyro_self_tests_failed: n[13],
                gyro_failures: n[2],
                wheel_failures: n[3],
                wheel_valid: [flags[0], flags[1], flags[2], flags[3]],
                data_ready_overruns: n[4],
                outcomes: Wire::take(&mut reader).unwrap(),
                uplink: Wire::take(&mut reader).unwrap(),
                downlink_dropped: n[5],
                serial_errors: n[6],
                last_command: events.1,
                last_sequence_count: optional.3,
                last_command_done: optional.1,
                authentication: words.5,
                key_counters: slots[0],
                key_generations: slots[1],
                telemetry_slot,
                telemetry_period_ms: n[7],
                torque_n_m,
                checkpoint: words.3,
                checkpoints_saved: n[8],
                checkpoints_failed: n[9],
            }
        },
    )
}
