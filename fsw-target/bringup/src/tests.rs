//! `board-tests`: one test for each part of a board, each after a reset of its own (embedded-test).
//!
//! | | |
//! |---|---|
//! | purpose | acceptance of a board, in the form of a test run: `cargo board board-tests` |
//! | log | defmt, on RTT and on USART1 |
//! | end | one result for each test; those that need hands or flight settings run with `-- --include-ignored` |
//!
//! Overwrites checkpoints in the last sector of the flash.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod in_interrupt;
#[cfg(target_os = "none")]
mod parts;

#[cfg(target_os = "none")]
fsw_target::ends_by!(fsw_target::arch::exit::end_after);

#[cfg(target_os = "none")]
#[embedded_test::tests]
mod tests {
    use crate::{in_interrupt, parts};
    use fsw_target::arch::exit;
    use fsw_target::board::{Board, Delay};
    use fsw_target::drivers::gyro::RateGyro;
    use fsw_target::drivers::gyro::bus::Spi;
    use fsw_target::drivers::gyro::fitted::{Chip, Settings};
    use fsw_target::runtime::log;

    #[init]
    fn init() -> Board {
        match Board::take() {
            Some(board) => board,
            None => exit::failure(),
        }
    }

    #[test]
    fn crystal_is_the_source_of_the_clock(board: Board) {
        let report = board.report();
        log::init(board.link.into_log_output());
        defmt::info!("{}", report);
        assert!(report.clock_fault.is_none());
    }

    #[test]
    fn clock_advances_by_the_delay(board: Board) {
        log::init(board.link.into_log_output());
        assert!(parts::clock_advances());
    }

    #[test]
    fn interrupt_of_the_gyro_has_its_stamp(mut board: Board) {
        log::init(board.link.into_log_output());
        assert!(parts::data_ready_stamps(&mut board.data_ready));
    }

    #[test]
    fn flight_loop_in_an_interrupt_steps_every_sample(board: Board) {
        log::init(board.link.into_log_output());
        assert!(in_interrupt::loop_steps_every_sample(board.data_ready));
    }

    #[test]
    fn watchdog_is_fed_by_permit_alone(mut board: Board) {
        log::init(board.link.into_log_output());
        assert!(parts::watchdog_is_fed_by_permit(&mut board.watchdog));
    }

    #[test]
    fn gyro_answers(board: Board) {
        log::init(board.link.into_log_output());
        assert!(parts::gyro_answers(board.gyro_bus));
    }

    #[test]
    fn gyro_passes_its_self_test(board: Board) {
        log::init(board.link.into_log_output());
        let mut gyro = Chip::new(Spi::new(board.gyro_bus), Settings::default());
        let result = RateGyro::restart(&mut gyro, &mut Delay).is_ok()
            && RateGyro::self_test(&mut gyro, &mut Delay).is_ok();
        assert!(result);
    }

    #[test]
    fn flash_keeps_what_is_written(mut board: Board) {
        log::init(board.link.into_log_output());
        assert!(parts::flash_keeps(&mut board.flash));
    }

    /// Turn each wheel by hand within the first second.
    #[test]
    #[ignore]
    fn each_wheel_has_edges(board: Board) {
        log::init(board.link.into_log_output());
        assert!(parts::every_wheel_has_edges(board.captures));
    }

    /// Holds once the option bytes are set, as the last step before flight.
    #[test]
    #[ignore]
    fn option_bytes_are_those_of_flight(board: Board) {
        let options = board.report().options;
        log::init(board.link.into_log_output());
        assert!(options.are_as_set());
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("board-tests run on the target only: cargo board board-tests");
}
