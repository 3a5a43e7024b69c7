//! `bench`: counts the instructions of every step of the estimators.
//!
//! | | |
//! |---|---|
//! | purpose | instruction budgets: most expensive and median step of whole flights |
//! | machine | only QEMU with `-icount shift=8`, see `fsw_target::arch::instructions`; `cargo bench-target` |
//! | log | defmt, on USART1: a line `count …` per estimator and flight, lines `outcome …` with details |
//! | end | success after the last count, failure if counts are not exact |
//!
//! The host program `cargo run -p fsw-bench` steps the same flights without counting, and logs the
//! outcomes of their samples.

#![cfg_attr(target_os = "none", no_std, no_main)]

mod counter;
mod covariance;
mod estimators;
mod flights;
mod manoeuvre;
mod noise;
mod slices;
mod tally;

use counter::Counter;
use estimators::Places;

/// Counts everything, in the order of the table.
fn count_all(counter: &mut Counter, places: &mut Places) -> Result<(), &'static str> {
    covariance::count_all(counter, &mut places.tally)?;
    if !cfg!(feature = "one-flight") {
        manoeuvre::count_all(counter, &mut places.tally)?;
    }
    estimators::fly_all(counter, places).map_err(|error| {
        fsw_target::log_line!("{:?}", error);
        "an estimator rejected its configuration"
    })
}

#[cfg(target_os = "none")]
fsw_target::ends_by!(fsw_target::arch::exit::end_after);

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use fsw_target::board::Board;
    use fsw_target::{arch::exit, runtime::log};

    let Some(board) = Board::take() else { exit::failure() };
    log::init(board.link.into_log_output());
    match count_on_target(board.syst) {
        Ok(()) => exit::success(),
        Err(reason) => {
            defmt::error!("{=str}", reason);
            exit::failure()
        }
    }
}

#[cfg(target_os = "none")]
fn count_on_target(timer: cortex_m::peripheral::SYST) -> Result<(), &'static str> {
    use core::cell::RefCell;
    use critical_section::Mutex;

    static PLACES: Mutex<RefCell<Places>> = Mutex::new(RefCell::new(Places::new()));

    let mut counter = Counter::start(timer)
        .map_err(|_| "counts are exact only in QEMU with -icount shift=8: cargo bench-target")?;
    critical_section::with(|cs| count_all(&mut counter, &mut PLACES.borrow_ref_mut(cs)))
}

#[cfg(not(target_os = "none"))]
fn main() -> Result<(), &'static str> {
    count_all(&mut Counter, &mut Places::new())
}
