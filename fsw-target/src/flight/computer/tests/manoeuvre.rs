//! Manoeuvre: upload, storage, start, restart. The wheels of the recording do not answer; `pil` has wheels that do.

extern crate std;
use super::world::*;
use crate::flight::computer::Reporting;
use crate::flight::manoeuvre::fixtures::table;
use crate::flight::manoeuvre::{FlightTable, checksum};
use crate::link::command::Command;
use crate::link::telemetry::{ManoeuvreReport, TableFault, Telemetry};
use crate::stand_in::recording::cubesat_pyramid::ROWS;
use fsw_core::manoeuvre::{Abort, State};
use std::vec::Vec;

fn ground(flash: Vec<u8>) -> Ground {
    Ground::new(&ROWS, flash, Reporting::Every(1_000))
}

fn flash_of(ground: &Ground) -> Vec<u8> {
    ground.world.0.flash.borrow().clone()
}

/// The last manoeuvre report of the next second; `None` before an upload.
fn report(ground: &mut Ground) -> Option<ManoeuvreReport> {
    let sent = ground.poll(10);
    let mut reports = sent.iter().filter_map(|telemetry| match telemetry {
        Telemetry::Manoeuvre(report) => Some(*report),
        _ => None,
    });
    reports.next_back()
}

fn upload(ground: &mut Ground, table: &FlightTable) -> Option<bool> {
    let mut done = None;
    for command in Command::upload(table) {
        done = ground.command(command).last_command_done;
    }
    done
}

#[test]
fn committed_table_survives_a_restart_and_a_broken_upload_does_not_replace_it() {
    let mut first = ground(erased());
    assert_eq!(report(&mut first), None);
    assert_eq!(first.command(Command::StartManoeuvre { at_us: 0 }).last_command_done, Some(false));
    let table = table();
    first.poll(5);
    assert_eq!(upload(&mut first, &table), Some(true));
    let crc = Some(checksum(&table));
    assert_eq!(
        report(&mut first).map(|report| (report.table_checksum, report.state)),
        Some((crc, State::Idle))
    );

    let second = flash_of(&first);
    let mut second = ground(second);
    assert_eq!(report(&mut second).and_then(|report| report.table_checksum), crc);
    let mut other = table;
    other.repeats = 2;
    let segments = Command::upload(&other).take(2);
    segments.for_each(|command| assert_eq!(second.command(command).last_command_done, Some(true)));
    let broken = second.command(Command::CommitManoeuvre { checksum: 1 });
    assert_eq!(broken.last_command_done, Some(false));
    let found = report(&mut second).unwrap();
    assert_eq!((found.table_error, found.table_checksum), (Some(TableFault::Checksum), None));
    assert_eq!(found.segments, 0b11);
    assert_eq!(second.command(Command::StartManoeuvre { at_us: 0 }).last_command_done, Some(false));

    let mut third = ground(flash_of(&second));
    assert_eq!(report(&mut third).and_then(|report| report.table_checksum), crc);
}

#[test]
fn restart_in_flight_returns_the_wheels_and_does_not_resume() {
    let mut first = ground(erased());
    first.poll(5);
    assert_eq!(upload(&mut first, &table()), Some(true));
    assert_eq!(first.command(Command::StartManoeuvre { at_us: 0 }).last_command_done, Some(true));
    first.poll(3);
    assert_ne!(first.world.0.motors_n_m.get(), [0.0; 4], "flying");
    assert_eq!(first.command(Command::SaveCheckpoint).last_command_done, Some(false));
    assert_eq!(first.command(Command::StartManoeuvre { at_us: 0 }).last_command_done, Some(false));
    let flash = flash_of(&first);
    assert_eq!(first.command(Command::AbortManoeuvre).last_command_done, Some(true));
    assert_eq!(report(&mut first).unwrap().abort, Some(Abort::Command));

    let mut second = ground(flash);
    assert_eq!(second.world.0.motors_n_m.get(), [0.0; 4], "no torque at the start");
    let found = report(&mut second).unwrap();
    assert_eq!(found.abort, Some(Abort::Restart));
    assert!(matches!(found.state, State::Resting | State::AtRest), "{found:?}");
}

#[test]
fn samples_that_stop_are_a_gap() {
    let mut ground = ground(erased());
    ground.poll(5);
    assert_eq!(upload(&mut ground, &table()), Some(true));
    assert_eq!(ground.command(Command::StartManoeuvre { at_us: 0 }).last_command_done, Some(true));
    ground.poll(2);
    ground.world.0.gyro_is_set_up.set(false);
    assert_eq!(report(&mut ground).unwrap().abort, Some(Abort::Glitch), "unreadable gyro");
}
