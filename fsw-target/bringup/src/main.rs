//! `bringup`: checks each part of the board in turn. The first image to flash on a new board.
//!
//! | | |
//! |---|---|
//! | purpose | check of the board's parts; in QEMU, of the parts that QEMU emulates |
//! | log | defmt, on RTT and on USART1: one line per part |
//! | serial | USART2 echoes |
//! | end | success if the peripherals of the chip work; wired parts and flash are reported only |
//!
//! Overwrites checkpoints in the last sector of the flash.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod in_interrupt;
#[cfg(target_os = "none")]
mod parts;

#[cfg(target_os = "none")]
mod on_target {
    use crate::{in_interrupt, parts};
    use core::hint::black_box;
    use cortex_m::peripheral::SYST;
    use embedded_hal_nb::serial::{Read, Write};
    use fsw_target::arch::exit;
    use fsw_target::arch::instructions::InstructionCounter;
    use fsw_target::board::{Board, OptionBytes, Tunnel};
    use fsw_target::flight::selected::SelectedEstimator;
    use fsw_target::link::authentication::{KEY_BYTES, Key};
    use fsw_target::runtime::sealed::Sealed;
    use fsw_target::runtime::{log, stack};
    use static_cell::ConstStaticCell;

    fsw_target::ends_by!(exit::end_after);

    /// Estimator as in the flight image, for its size.
    static ESTIMATOR: ConstStaticCell<SelectedEstimator> =
        ConstStaticCell::new(SelectedEstimator::uninitialised());

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(mut board) = Board::take() else { exit::failure() };
        let report = board.report();
        log::init(board.link.into_log_output());
        defmt::info!("{}", report);
        report_options(report.options);
        report_costs(board.syst);

        let mut all_work = true;
        all_work &= report_check("clock", parts::clock_advances());
        all_work &= report_check("data ready", parts::data_ready_stamps(&mut board.data_ready));
        all_work &= report_check(
            "loop in an interrupt",
            in_interrupt::loop_steps_every_sample(board.data_ready),
        );
        all_work &= report_check("watchdog", parts::watchdog_is_fed_by_permit(&mut board.watchdog));
        parts::every_wheel_has_edges(board.captures);
        parts::gyro_answers(board.gyro_bus);
        parts::flash_keeps(&mut board.flash);
        let echoed = echo(&mut board.tunnel);
        defmt::info!("USART2: {=u32} bytes echoed, {}", echoed, board.tunnel.counters());
        defmt::info!(
            "stack: {=u32} of {=u32} bytes",
            stack::high_water_bytes(),
            stack::size_bytes()
        );
        if all_work { exit::success() } else { exit::failure() }
    }

    /// Logs whether the option bytes are those of a flight board.
    fn report_options(options: OptionBytes) {
        match options.are_as_set() {
            true => defmt::info!("option bytes: as for flight"),
            false => defmt::warn!("option bytes: not those of a flight board, see docs/board.md"),
        }
    }

    /// Logs the instructions of work beside the steps, where SysTick counts them: in QEMU with `-icount shift=8`.
    fn report_costs(syst: SYST) {
        let Ok(mut counter) = InstructionCounter::start(syst) else { return };
        report_seal_cost(&mut counter);
        report_tag_cost(&mut counter);
    }

    /// Logs the instructions of one check of the estimator's memory. A round has two: check and renewal.
    fn report_seal_cost(counter: &mut InstructionCounter) {
        let Some(estimator) = ESTIMATOR.try_take() else { return };
        let mut sealed = Sealed::new(estimator);
        sealed.seal();
        let mut is_intact = false;
        let check = counter.count(|| is_intact = black_box(&mut sealed).open());
        let bytes = size_of::<SelectedEstimator>();
        defmt::info!(
            "instructions: check of {=usize} bytes {=u32}, {=bool}",
            bytes,
            check,
            is_intact
        );
    }

    /// Logs the instructions of the tag of the longest telecommand, `set_prior`.
    fn report_tag_cost(counter: &mut InstructionCounter) {
        const TAGGED_BYTES: usize = 60;
        let (master, packet) = black_box((Key::new([7; KEY_BYTES]), [0x55; TAGGED_BYTES]));
        let key = counter.count(|| {
            black_box(master.of_slot(1, 0));
        });
        let tag = counter.count(|| {
            black_box(master.tag(&packet));
        });
        defmt::info!("instructions: key of a slot {=u32}, tag of 60 bytes {=u32}", key, tag);
    }

    /// Logs the result of a check and returns it.
    fn report_check(part: &'static str, passes: bool) -> bool {
        defmt::info!("{=str}: {=str}", part, if passes { "works" } else { "FAILS" });
        passes
    }

    /// Idle polls of the tunnel before the echo ends: a few seconds.
    const IDLE_POLLS: u32 = 6_000_000;

    /// Echoes bytes until the line is idle. Returns their number.
    fn echo(tunnel: &mut Tunnel) -> u32 {
        let mut echoed: u32 = 0;
        let mut idle = 0;
        while idle < IDLE_POLLS {
            match tunnel.read() {
                Ok(byte) => {
                    // A byte that the port does not take is dropped.
                    let _ = (0..IDLE_POLLS).try_for_each(|_| match tunnel.write(byte) {
                        Ok(()) => Err(()),
                        Err(_) => Ok(()),
                    });
                    echoed = echoed.wrapping_add(1);
                    idle = 0;
                }
                Err(_) => idle += 1,
            }
        }
        echoed
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("bringup runs on the target only: cargo qemu bringup");
}
