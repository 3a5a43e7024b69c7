//! Authentication of telecommands and telemetry by the whole flight computer, over restarts.

extern crate std;
use super::super::*;
use super::world::*;
use crate::link::Receiver;
use crate::link::authentication::{Authentication, Key};
use crate::link::frame::Frame;
use crate::stand_in::recording::cubesat_pyramid::ROWS;
use std::vec::Vec;

const MASTER: Key = Key::new(*b"master key, test");

fn ground(world: World) -> Ground {
    Ground::start(&ROWS, world, Reporting::EachSample, Some(MASTER))
}

/// The world after a reset of the computer: both flash memories as they are.
fn after_reset(ground: &Ground) -> World {
    let world = World::with(ground.world.0.flash.borrow().clone());
    *world.counters.borrow_mut() = ground.world.0.counters.borrow().clone();
    world
}

fn status(ground: &mut Ground) -> StatusReport {
    ground.computer.status_due = true;
    statuses(&ground.poll(1)).last().copied().expect("a status report")
}

#[test]
fn image_without_a_key_says_so() {
    let mut open = Ground::new(&ROWS, erased(), Reporting::EachSample);
    let status = open.command(Command::Ping);
    assert_eq!((status.authentication, status.link_version), (Authentication::Off, LINK_VERSION));
    assert_eq!(open.command(Command::ChangeKey { slot: 1 }).last_command_done, Some(false));
    assert_eq!(open.command(Command::TagTelemetry(true)).last_command_done, Some(false));
    assert_eq!(open.world.0.counters.borrow()[..], [0xff; COUNTERS], "no counter is stored");
}

#[test]
fn recorded_session_is_refused_after_a_restart() {
    let mut first = ground(World::with(erased()));
    let mut session = Vec::new();
    for _ in 0..25 {
        let frame = first.next_frame(Command::SetTorque([0.1, 0.0, 0.0]));
        first.send(frame.bytes());
        session.extend_from_slice(frame.bytes());
        first.poll(1);
    }
    let report = status(&mut first);
    assert_eq!((report.uplink.accepted, report.key_counters), (25, [0, 25, 0]));
    assert_eq!(report.authentication, Authentication::Required);
    let erasures = first.world.0.erasures.get();
    assert!(erasures > 3, "the counters have wrapped through their flash: {erasures}");

    let mut again = ground(after_reset(&first));
    assert_eq!(status(&mut again).key_counters, [0, 25, 0], "the ground reads its counter");
    again.send(&session);
    again.poll(60);
    let report = status(&mut again);
    assert_eq!((report.uplink.accepted, report.uplink.replayed), (0, 25));
    assert_eq!(report.torque_n_m, [0.0; 3]);
    again.key = Some((MASTER, 1, 25));
    assert_eq!(again.command(Command::Ping).last_command_done, Some(true));
}

/// The counter is in flash before the command acts: a power cut at any byte of its record leaves a computer
/// that has not executed the command, or one that does not accept it again.
#[test]
fn telecommand_is_executed_at_most_once_over_a_power_cut() {
    let mut before = ground(World::with(erased()));
    before.command(Command::Ping);
    let clean = before.world.0.counters.borrow().clone();
    let frame = before.next_frame(Command::Reset);
    before.send(frame.bytes());
    before.poll(1);
    let done = before.world.0.counters.borrow().clone();
    let changed = (0..COUNTERS).filter(|at| clean[*at] != done[*at]).count();
    assert!(changed > 30, "{changed}");
    for cut in 0..=COUNTERS {
        let world = World::with(erased());
        let torn = [&done[..cut], &clean[cut..]].concat();
        let is_whole = torn == done;
        *world.counters.borrow_mut() = torn;
        let mut again = ground(world);
        again.send(frame.bytes());
        again.poll(1);
        let accepted = again.computer.uplink.counters().accepted;
        assert_eq!(accepted, u32::from(!is_whole), "cut at byte {cut}");
    }
}

#[test]
fn counter_that_cannot_be_stored_is_reported_and_locks_nobody_out() {
    let mut ground = ground(World::with(erased()));
    ground.world.0.counters_fail.set(true);
    let report = ground.command(Command::Ping);
    assert_eq!(report.authentication, Authentication::NotStored);
    assert_eq!(ground.command(Command::Ping).last_command_done, Some(true));
    ground.world.0.counters_fail.set(false);
    assert_eq!(ground.command(Command::Ping).authentication, Authentication::Required);
}

#[test]
fn unreadable_counters_are_reported() {
    let world = World::with(erased());
    world.counters.borrow_mut().clear();
    let mut ground = ground(world);
    assert_eq!(ground.command(Command::Ping).authentication, Authentication::NotStored);
}

#[test]
fn changed_key_survives_a_restart() {
    let mut first = ground(World::with(erased()));
    let old = first.next_frame(Command::Reset);
    first.key = Some((MASTER, 0, 41));
    assert_eq!(first.command(Command::ChangeKey { slot: 1 }).key_generations, [0, 42, 0]);
    let mut again = ground(after_reset(&first));
    again.send(old.bytes());
    again.poll(1);
    let report = status(&mut again);
    assert_eq!((report.uplink.wrong_tag, report.key_generations), (1, [0, 42, 0]));
    let new = Command::Reset.tagged_packet(&MASTER.of_slot(1, 42), 1, 1).unwrap();
    again.send(Frame::of(new.bytes()).unwrap().bytes());
    again.poll(1);
    assert_eq!(status(&mut again).uplink.accepted, 1);
}

#[test]
fn telemetry_is_tagged_on_request() {
    let mut ground = ground(World::with(erased()));
    ground.receiver = Receiver::with_key(MASTER.of_slot(1, 0));
    let frame = ground.next_frame(Command::TagTelemetry(true));
    ground.send(frame.bytes());
    // With `unwrap` on every packet: all have the tag.
    let sent = ground.poll(20);
    assert_eq!(estimates(&sent).len(), 20);
    assert_eq!(status(&mut ground).telemetry_slot, Some(1));
    let mut again = Ground::start(&ROWS, after_reset(&ground), Reporting::EachSample, Some(MASTER));
    again.receiver = Receiver::with_key(MASTER.of_slot(1, 0));
    assert_eq!(estimates(&again.poll(5)).len(), 5, "after a restart too");
    again.receiver = Receiver::default();
    again.key = Some((MASTER, 1, 1));
    assert_eq!(again.command(Command::TagTelemetry(false)).telemetry_slot, None);
}

#[test]
fn forged_telemetry_is_refused_by_a_receiver_with_a_key() {
    let mut ground = ground(World::with(erased()));
    ground.poll(1);
    let bytes: Vec<u8> = {
        ground.computer.status_due = true;
        ground.world.0.now_us.set(ground.world.0.now_us.get() + 100_000);
        ground.computer.poll();
        ground.world.0.from_computer.borrow_mut().drain(..).collect()
    };
    let packets = |mut receiver: Receiver| -> Vec<_> {
        bytes.iter().filter_map(|byte| receiver.push(*byte)).collect()
    };
    assert!(packets(Receiver::default()).iter().all(Result::is_ok));
    let refused = packets(Receiver::with_key(MASTER.of_slot(1, 0)));
    assert!(refused.len() == 2 && refused.iter().all(Result::is_err));
}
