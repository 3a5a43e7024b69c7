//! Start of the flight computer: watchdog, restart loops, checkpoints of other images, reboot.

extern crate std;
use super::super::*;
use super::world::*;
use crate::link::authentication::Key;
use crate::link::telemetry::CheckpointState;
use crate::stand_in::recording::cubesat_pyramid::ROWS;

/// Shortest period of the watchdog, µs: see `board/stm32f405/watchdog.rs`.
const WATCHDOG_US: u64 = 2_998_500;

/// On the internal oscillator: 0.2 s to read half of 256 KiB, the longest erasure twice, a gyro that takes
/// as long as it may.
#[test]
fn slowest_start_feeds_the_watchdog_in_time() {
    let used = Ground::new(&ROWS, erased(), Reporting::EachSample);
    // Without the mark of an erasure both halves are erased again.
    used.world.0.flash.borrow_mut().fill(0);
    let world = World::with(used.world.0.flash.borrow().clone());
    world.counters.borrow_mut().fill(0);
    world.erasure_us.set(2_000_000);
    world.chunk_us.set(200_000 * 32 / (FLASH as u64 / 2));
    world.gyro_start_us.set(75_000);
    let mut ground = Ground::start(&ROWS, world, Reporting::EachSample, Some(Key::new([3; 16])));
    let world = ground.world.0.clone();
    assert!(world.now_us.get() > WATCHDOG_US, "{} µs", world.now_us.get());
    ground.poll(1);
    let longest_us = world.longest_us.get();
    assert!(longest_us < WATCHDOG_US, "{longest_us} µs without feeding");
}

#[test]
fn checkpoint_is_skipped_after_three_short_lives() {
    let mut first = Ground::new(&ROWS, erased(), Reporting::EachSample);
    first.command(Command::SetPrior(PRIOR));
    first.poll(300);
    first.command(Command::SaveCheckpoint);
    let saved = first.world.0.flash.borrow().clone();
    for (lives, found) in [
        (0, CheckpointState::Restored),
        (2, CheckpointState::Restored),
        (3, CheckpointState::Skipped),
        (9, CheckpointState::Skipped),
    ] {
        let world = World::with(saved.clone());
        world.short_lives.set(lives);
        let mut again = Ground::start(&ROWS[303..], world, Reporting::EachSample, None);
        let status = again.command(Command::Ping);
        assert_eq!((status.checkpoint, u32::from(status.short_lives)), (found, lives));
        let prior = again.computer.estimator().prior();
        assert_eq!(prior.is_some(), found == CheckpointState::Restored);
    }
    // A start without any checkpoint skips none.
    let world = World::with(erased());
    world.short_lives.set(3);
    let mut again = Ground::start(&ROWS, world, Reporting::EachSample, None);
    assert_eq!(again.command(Command::Ping).checkpoint, CheckpointState::None);
}

/// A minute without the skipped checkpoint shows that it was the cause: a new one replaces it.
#[test]
fn long_life_ends_the_row_and_replaces_the_skipped_checkpoint() {
    let mut first = Ground::new(&ROWS, erased(), Reporting::EachSample);
    first.poll(50);
    first.command(Command::SaveCheckpoint);
    let world = World::with(first.world.0.flash.borrow().clone());
    world.short_lives.set(3);
    let mut again = Ground::start(&ROWS, world, Reporting::EachSample, None);
    again.poll(590);
    assert_eq!((again.world.0.long_lives.get(), again.computer.flash.saved), (0, 0));
    again.poll(20);
    assert_eq!(again.world.0.long_lives.get(), 1);
    again.poll(110);
    assert_eq!((again.world.0.long_lives.get(), again.computer.flash.saved), (1, 1));
    assert_eq!(again.command(Command::Ping).short_lives, 0);
}

/// The fingerprint in the head of each record is that of another precision or size.
#[test]
fn checkpoint_of_another_image_is_named() {
    use crate::store::Store;
    let other = Ground::new(&ROWS, erased(), Reporting::EachSample);
    Store::open(other.world.clone()).unwrap().save(&mut [1.0_f64; 9]).unwrap();
    let flash = other.world.0.flash.borrow().clone();
    let mut ground = Ground::new(&ROWS, flash, Reporting::EachSample);
    assert_eq!(ground.command(Command::Ping).checkpoint, CheckpointState::OtherImage);
}

#[test]
fn reboot_is_answered_first() {
    let mut ground = Ground::new(&ROWS, erased(), Reporting::EachSample);
    assert_eq!(ground.command(Command::Reboot).last_command_done, Some(true));
    assert_eq!(ground.world.0.reboots.get(), 0);
    ground.poll(6);
    assert_eq!(ground.world.0.reboots.get(), 1);
}
