//! Peripherals of the board that QEMU models: failures, interrupts, timers, serial ports.

use anyhow::Result;
use std::io::{Read, Write};
use target_tools::image::{self, BoardTest};
use target_tools::machine::Machine;
use target_tools::{budgets, firmware, qemu};

use crate::LIMIT;

/// Beginnings of the last lines of each run between two restarts.
///
/// The first two are stack overflows, by recursion and by one large frame. The memory protection unit
/// reports them: stacking error (MSTKERR), access violation (DACCVIOL), valid address (MMARVALID).
const LAST_LINES: [&[&str]; 5] = [
    &["fault status 0x00000092", "stack overflow at"],
    &["fault status 0x00000092", "stack overflow at"],
    &["fault status 0x00010000", "hard fault at"],
    &["interrupt -1 has no handler"],
    &["panicked at fsw-target/src/bin/failures.rs:"],
];

/// Failure reported after each restart.
const LAST_FAILURE: [&str; 6] = [
    "None",
    "Some(Failure { kind: StackOverflow",
    "Some(Failure { kind: StackOverflow",
    "Some(Failure { kind: HardFault",
    "Some(Failure { kind: UnservedInterrupt",
    "Some(Failure { kind: Panic",
];

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn every_failure_is_caught_and_reported_after_the_restart() -> Result<()> {
    let _alone = crate::alone();
    let run = qemu::run(&firmware::build("failures")?, qemu::MACHINE, LIMIT, |_| {})?;
    assert!(run.success, "{:#?}", run.lines);

    let is_start = |line: &String| line.starts_with("start");
    let runs: Vec<&[String]> = run.lines.split(is_start).skip(1).collect();
    for (index, expected) in LAST_LINES.iter().enumerate() {
        let lines: Vec<&str> = runs[index].iter().map(String::as_str).collect();
        let begins = |(line, beginning): (&&str, &&str)| line.starts_with(beginning);
        let is_caught = lines.len() == expected.len() && lines.iter().zip(*expected).all(begins);
        assert!(is_caught, "run {index}: {lines:#?} is not {expected:#?}");
    }

    let starts = run.lines.iter().filter(|line| is_start(line));
    for (index, (line, failure)) in starts.zip(LAST_FAILURE).enumerate() {
        let expected = format!("start {index}, last failure {failure}");
        assert!(line.starts_with(&expected), "{line:?} is not {expected:?}");
    }
    Ok(())
}

#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn peripherals_of_the_chip_work_and_missing_ones_are_reported() -> Result<()> {
    let _alone = crate::alone();
    let run = qemu::run(&firmware::build("bringup")?, qemu::MACHINE, LIMIT, |_| {})?;
    assert!(run.success, "{:#?}", run.lines);

    // QEMU has no crystal, no gyro, and a flash that cannot be programmed.
    for expected in [
        "BoardReport { reset_cause: Unknown, clock_source: Internal, clock_fault: Some(CrystalDead), \
         options: OptionBytes { register: 0 } }",
        "option bytes: not those of a flight board, see docs/board.md",
        "data ready: works",
        "loop in an interrupt: works",
        "gyro: identity 0x00, expected 0x0f",
        "flash: NotAsWritten { offset: 131072 }",
    ] {
        assert!(run.lines.iter().any(|line| line == expected), "{expected} in {:#?}", run.lines);
    }
    Ok(())
}

/// Tests of the board, each on a machine of its own. QEMU has no crystal, no gyro, and a flash that cannot be programmed:
/// those tests fail there, and no other.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn each_test_of_a_board_fails_where_the_part_is_missing() -> Result<()> {
    const MISSING: [&str; 4] = [
        "crystal_is_the_source_of_the_clock",
        "flash_keeps_what_is_written",
        "gyro_answers",
        "gyro_passes_its_self_test",
    ];
    let _alone = crate::alone();
    let elf = firmware::build("board-tests")?;
    let tests = image::board_tests(&elf)?;
    let run = |test: &BoardTest| qemu::run_test(&elf, qemu::MACHINE, LIMIT, test);
    let (mut passed, mut failed) = (0, Vec::new());
    for test in tests.iter().filter(|test| !test.is_ignored) {
        match run(test)?.success {
            true => passed += 1,
            false => failed.push(test.name.as_str()),
        }
    }
    assert_eq!(failed, MISSING);
    assert_eq!((tests.len(), passed), (10, 4));
    Ok(())
}

/// Instructions of the tag of the longest telecommand and of a check of the estimator's memory, counted.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn tag_and_check_of_memory_are_within_their_budgets() -> Result<()> {
    let _alone = crate::alone();
    let image = firmware::build("bringup")?;
    let (mut tag, mut check) = (None, None);
    // The image goes on with parts that wait for seconds of virtual time: the lines are enough.
    let run = qemu::run_counting(&image, qemu::MACHINE, LIMIT, |line| {
        let Some(numbers) = line.strip_prefix("instructions: ") else { return };
        println!("{line}");
        let numbers = numbers.split(|letter: char| !letter.is_ascii_digit());
        let numbers: Vec<u32> = numbers.filter_map(|number| number.parse().ok()).collect();
        match line.contains("key of a slot") {
            true => tag = Some((numbers[0], numbers[2])),
            false => check = Some(numbers[1]),
        }
    });
    let (Some((key, tag)), Some(check)) = (tag, check) else {
        anyhow::bail!("no count in {run:?}")
    };
    assert!(key + tag <= budgets::TELECOMMAND_TAG, "{key} and {tag} instructions");
    assert!(check <= budgets::MEMORY_CHECK, "{check} instructions");
    Ok(())
}

/// The image echoes the second serial port: an interrupt queues the bytes, the loop sends them.
#[test]
#[ignore = "needs the Cortex-M target and QEMU: tests/check.sh runs it"]
fn no_received_byte_is_lost() -> Result<()> {
    let _alone = crate::alone();
    let (_machine, [mut log, mut port]) = Machine::start(&firmware::build("bringup")?)?;
    // Bytes sent before the ports are open are lost, as on a board. The log begins afterwards.
    log.set_read_timeout(Some(LIMIT))?;
    log.read_exact(&mut [0])?;
    port.set_read_timeout(Some(LIMIT))?;
    for first in 0..20_u8 {
        // Fewer bytes than the queue holds: the result does not depend on the time of reading.
        let sent: Vec<u8> =
            (0..200).map(|index: u8| index.wrapping_mul(7).wrapping_add(first)).collect();
        port.write_all(&sent)?;
        let mut received = vec![0; sent.len()];
        port.read_exact(&mut received)?;
        assert_eq!(received, sent);
    }
    Ok(())
}
