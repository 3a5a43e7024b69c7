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
mod on_target {
    use crate::in_interrupt;
    use core::hint::black_box;
    use cortex_m::peripheral::SYST;
    use embedded_hal::delay::DelayNs;
    use embedded_hal_nb::serial::{Read, Write};
    use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
    use fsw_target::arch::exit;
    use fsw_target::arch::instructions::InstructionCounter;
    use fsw_target::board::{
        Board, Delay, GyroBus, GyroDataReady, OptionBytes, SectorPair, Tunnel, WheelCaptures,
        now_us,
    };
    use fsw_target::drivers::gyro::RateGyro;
    use fsw_target::drivers::gyro::bus::Spi;
    use fsw_target::drivers::gyro::fitted::{Chip, Settings};
    use fsw_target::drivers::wheel_tach::CaptureTimer;
    use fsw_target::flight::selected::SelectedEstimator;
    use fsw_target::flight::sensors::DataReady;
    use fsw_target::flight::supervisor::{Supervisor, Task};
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
        all_work &= report_check("clock", clock_advances());
        all_work &= report_check("data ready", data_ready_stamps(&mut board.data_ready));
        all_work &= report_check(
            "loop in an interrupt",
            in_interrupt::loop_steps_every_sample(board.data_ready),
        );
        all_work &= report_check("watchdog", watchdog_is_fed_by_permit(&mut board.watchdog));
        report_wheels(&mut board.captures.start(SHORTEST_EDGE_S));
        report_gyro(board.gyro_bus);
        report_flash(&mut board.flash);
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

    /// The clock is monotonic, and a delay takes at least its duration.
    fn clock_advances() -> bool {
        const DELAY_US: u32 = 2_000;
        let mut last_us = now_us();
        let start_us = last_us;
        for _ in 0..1_000 {
            let time_us = now_us();
            if time_us < last_us {
                return false;
            }
            last_us = time_us;
        }
        Delay.delay_us(DELAY_US);
        let passed_us = now_us() - last_us;
        defmt::info!("a delay of {=u32} us took {=u64}", DELAY_US, passed_us);
        last_us > start_us && passed_us >= u64::from(DELAY_US)
    }

    /// One interrupt gives one stamp at its time; of three, the newest stamp remains.
    fn data_ready_stamps(data_ready: &mut GyroDataReady) -> bool {
        let before_us = now_us();
        GyroDataReady::trigger();
        let stamp_us = data_ready.take_us();
        let is_in_time = stamp_us.is_some_and(|us| (before_us..=now_us()).contains(&us));

        let overruns = data_ready.overruns();
        GyroDataReady::trigger();
        GyroDataReady::trigger();
        let between_us = now_us();
        GyroDataReady::trigger();
        let has_newer = data_ready.has_newer();
        let is_newest = data_ready.take_us().is_some_and(|us| us >= between_us);
        let is_over = !data_ready.has_newer() && data_ready.take_us().is_none();
        is_in_time && has_newer && is_newest && is_over && data_ready.overruns() == overruns + 2
    }

    /// A complete set of task reports gives one permit to feed the watchdog. The watchdog itself stays
    /// off: it could not be stopped at the end of the image.
    fn watchdog_is_fed_by_permit(watchdog: &mut fsw_target::board::Watchdog) -> bool {
        let mut supervisor = Supervisor::new();
        Task::ALL.into_iter().for_each(|task| supervisor.report(task));
        let permit = supervisor.permit();
        let is_granted = permit.is_some();
        permit.into_iter().for_each(|permit| watchdog.feed(permit));
        is_granted && supervisor.permit().is_none()
    }

    /// Shortest interval between edges, s: half of that at 6000 rpm and 24 edges per turn.
    const SHORTEST_EDGE_S: f32 = 0.5 / (100.0 * 24.0);

    /// Logs the positions of the wheels after one second, in edges. Turn the wheels by hand.
    fn report_wheels(captures: &mut WheelCaptures) {
        Delay.delay_ms(1_000);
        match captures.captured() {
            Ok(captured) => {
                defmt::info!("wheel edges in one second: {}", captured.map(|c| c.edges))
            }
            Err(error) => defmt::warn!("wheels: {}", error),
        }
    }

    /// Logs whether the fitted gyro answers with its identity.
    fn report_gyro(bus: GyroBus) {
        let expected = <Chip<Spi<GyroBus>> as RateGyro>::IDENTITY;
        match Chip::new(Spi::new(bus), Settings::default()).identity() {
            Ok(found) if found == expected => defmt::info!("gyro: works"),
            Ok(found) => {
                defmt::warn!("gyro: identity {=u8:#04x}, expected {=u8:#04x}", found, expected)
            }
            Err(error) => defmt::warn!("gyro: {}", error),
        }
    }

    /// Erases the last sector, writes to it, reads it back, and logs the result.
    fn report_flash(flash: &mut SectorPair) {
        const PATTERN: [u8; 8] = *b"bringup\n";
        let end = flash.capacity() as u32;
        let start = end - SectorPair::ERASE_SIZE as u32;
        let start_us = now_us();
        let mut read = [0; 8];
        let result = flash
            .erase(start, end)
            .and_then(|()| flash.write(start, &PATTERN))
            .and_then(|()| flash.read(start, &mut read));
        match result {
            Ok(()) => {
                defmt::info!("flash: works, erased and written in {=u64} us", now_us() - start_us)
            }
            Err(error) => defmt::warn!("flash: {}", error),
        }
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
