//! The board in QEMU, as far as QEMU has it: failures, interrupts, timers.

use anyhow::Result;
use std::io::{Read, Write};
use std::time::Duration;
use target_tools::machine::Machine;
use target_tools::{firmware, qemu};

/// No image here takes more than a second in QEMU; a busy machine may take far longer.
const LIMIT: Duration = Duration::from_secs(120);

/// How the lines begin that each life ends with. The stack's first two, by recursion and by one
/// large frame, run into memory that the protection unit has closed: a frame that couldn't be put
/// on the stack (MSTKERR), an access against its rules (DACCVIOL), its address known (MMARVALID).
const CAUGHT: [&[&str]; 5] = [
    &["fault status 0x00000092", "stack overflow at"],
    &["fault status 0x00000092", "stack overflow at"],
    &["fault status 0x00010000", "hard fault at"],
    &["interrupt -1 has no handler"],
    &["panicked at fsw-target/src/bin/failures.rs:"],
];

/// What each life is told of the one before it.
const TOLD: [&str; 6] = [
    "None",
    "Some(Failure { kind: StackOverflow",
    "Some(Failure { kind: StackOverflow",
    "Some(Failure { kind: HardFault",
    "Some(Failure { kind: UnservedInterrupt",
    "Some(Failure { kind: Panic",
];

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn every_failure_is_caught_and_told_of_after_the_restart() -> Result<()> {
    let run = qemu::run(&firmware::build("failures")?, qemu::MACHINE, LIMIT, |_| {})?;
    assert!(run.success, "{:#?}", run.lines);

    let lives: Vec<&[String]> = run.lines.split(|line| line.starts_with("start")).skip(1).collect();
    for (life, caught) in CAUGHT.iter().enumerate() {
        let lines: Vec<&str> = lives[life].iter().map(String::as_str).collect();
        let starts = |(line, start): (&&str, &&str)| line.starts_with(start);
        let is_caught = lines.len() == caught.len() && lines.iter().zip(*caught).all(starts);
        assert!(is_caught, "life {life}: {lines:#?} is not {caught:#?}");
    }

    let told = run.lines.iter().filter(|line| line.starts_with("start"));
    for (life, (line, kind)) in told.zip(TOLD).enumerate() {
        let expected = format!("start {life}, last failure {kind}");
        assert!(line.starts_with(&expected), "{line:?} is not {expected:?}");
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
        "gyro: identity 0x00, expected 0x0f",
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
