//! Other boards and cores: a Cortex-M7 and a Cortex-M33 in QEMU.

use anyhow::{Context, Result};
use target_tools::board::{Board, MPS2_AN500, MPS2_AN505};
use target_tools::{firmware, qemu};

use crate::{LIMIT, replay};

fn run(board: &Board, image: &str) -> Result<qemu::Run> {
    qemu::run(&firmware::build_for(board, image)?, board.machine, LIMIT, |_| {})
}

/// The recording by every estimator that flies. The test of the STM32F405 compares the Cortex-M4F with the same lines.
#[test]
#[ignore = "needs the Cortex-M targets and QEMU: tests/check.sh runs it"]
fn cortex_m7_and_m33_compute_the_bits_of_the_host() -> Result<()> {
    let _alone = crate::alone();
    for board in [MPS2_AN500, MPS2_AN505] {
        let flown = run(&board, "replay")?;
        replay::assert_bits_of_the_host(&flown)?;
        let time = flown.lines.iter().find_map(|line| line.strip_suffix(" us of on-board time"));
        let time_us: u64 = time.context("no on-board time in the log")?.parse()?;
        println!("{}, {}: {time_us} us of on-board time", board.feature, board.core);
        assert!(time_us > 0, "the timer runs");
    }
    Ok(())
}
