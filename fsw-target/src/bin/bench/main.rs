//! `bench`: counts the instructions of every step of the estimators.
//!
//! | | |
//! |---|---|
//! | purpose | the instruction budgets: the most expensive step of a whole flight, and the median |
//! | where | QEMU with `-icount shift=8` only, see `fsw_target::instructions`; `cargo bench-target` |
//! | log | defmt, on USART1: one line `count …` for each estimator and flight |
//! | end | success once all is counted, failure where counting isn't exact |

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod estimators;
#[cfg(target_os = "none")]
mod tally;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use fsw_target::{board::Board, exit, log};

    if let Some(board) = Board::take() {
        log::init(board.log_port);
    }
    match count() {
        Ok(()) => exit::success(),
        Err(reason) => {
            defmt::error!("{=str}", reason);
            exit::failure()
        }
    }
}

#[cfg(target_os = "none")]
fn count() -> Result<(), &'static str> {
    use fsw_target::instructions::InstructionCounter;

    let core = cortex_m::Peripherals::take().ok_or("the core's peripherals are taken")?;
    let counter = InstructionCounter::start(core.SYST)
        .map_err(|_| "counts are exact only in QEMU with -icount shift=8: cargo bench-target")?;
    estimators::fly_all(&counter).map_err(|error| {
        defmt::error!("{}", error);
        "an estimator refused its configuration"
    })
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("instructions are counted on the target: cargo bench-target");
}
