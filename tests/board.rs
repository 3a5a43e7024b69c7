//! The board in QEMU, as far as QEMU has it: failures, interrupts, timers.

use anyhow::Result;
use std::io::{Read, Write};
use std::time::Duration;
use target_tools::machine::Machine;
use target_tools::{firmware, qemu};

/// No image here takes more than a second in QEMU; a busy machine may take far longer.
const LIMIT: Duration = Duration::from_secs(120);

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn every_failure_is_caught_and_told_of_after_the_restart() -> Result<()> {
    let run = qemu::run(&firmware::build("failures")?, qemu::MACHINE, LIMIT, |_| {})?;
    assert!(run.success, "{:#?}", run.lines);

    // In this order: an overflow of the stack comes first, and leaves the statics intact.
    let caught = ["stack overflow at", "hard fault at", "interrupt -1 has", "panicked at"];
    let told = ["StackOverflow", "HardFault", "UnservedInterrupt", "Panic"];
    let lives = caught.iter().zip(told).enumerate().flat_map(|(ended, (caught, told))| {
        [
            (*caught).to_string(),
            format!("life {}, ended last by Some(Failure {{ kind: {told}", ended + 1),
        ]
    });
    let mut lines = run.lines.iter().skip(1); // the first life was ended by nothing
    for expected in lives {
        let line = lines.next().map(String::as_str).unwrap_or_default();
        assert!(line.starts_with(&expected), "{line:?} is not {expected:?} in {:#?}", run.lines);
    }
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn what_is_on_the_chip_works_and_what_is_not_there_is_told_of() -> Result<()> {
    let run = qemu::run(&firmware::build("bringup")?, qemu::MACHINE, LIMIT, |_| {})?;
    assert!(run.success, "{:#?}", run.lines);

    // QEMU has no crystal, no gyro, and a flash that can't be written.
    for expected in [
        "BoardReport { reset_cause: Unknown, clock_source: Internal, clock_fault: Some(CrystalDead) }",
        "data ready: works",
        "loop in an interrupt: works",
        "gyro: not there, [0x00] answers for an identity",
        "flash: NotAsWritten { offset: 131072 }",
    ] {
        assert!(run.lines.iter().any(|line| line == expected), "{expected} in {:#?}", run.lines);
    }
    Ok(())
}

/// The second serial port sends back what it gets, all of it and in order: by interrupt into its
/// queue, and from there in the loop.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn no_received_byte_is_lost() -> Result<()> {
    let (_machine, [mut log, mut port]) = Machine::start(&firmware::build("bringup")?)?;
    // What comes before the ports are open is lost, as on a board: the log comes after.
    log.set_read_timeout(Some(LIMIT))?;
    log.read_exact(&mut [0])?;
    port.set_read_timeout(Some(LIMIT))?;
    for first in 0..20_u8 {
        // Fewer than the queue holds, so that it doesn't matter when the image comes to read them.
        let sent: Vec<u8> =
            (0..200).map(|index: u8| index.wrapping_mul(7).wrapping_add(first)).collect();
        port.write_all(&sent)?;
        let mut received = vec![0; sent.len()];
        port.read_exact(&mut received)?;
        assert_eq!(received, sent);
    }
    Ok(())
}
