//! The board in QEMU, as far as QEMU has it: failures, interrupts, timers.

use anyhow::Result;
use std::time::Duration;
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
