//! `bringup`: looks at each part of the board in turn. The first image to flash on a new board.
//!
//! | | |
//! |---|---|
//! | purpose | says which parts of the board work, in QEMU as far as QEMU has them |
//! | log | defmt, on RTT and on USART1: one line for each part |
//! | serial | USART2 sends back what it receives |
//! | end | success if what is on the chip works; what is wired to it, and the flash, is only told of |
//!
//! Overwrites the checkpoint in the flash's last sector.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod in_interrupt;

#[cfg(target_os = "none")]
mod on_target {
    use crate::in_interrupt;
    use embedded_hal::delay::DelayNs;
    use embedded_hal_nb::serial::{Read, Write};
    use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
    use fsw_target::arch::exit;
    use fsw_target::board::{
        Board, CheckpointFlash, Delay, GyroBus, GyroDataReady, Tunnel, WheelCaptures, now_us,
    };
    use fsw_target::drivers::gyro::bmi088::{CHIP_ID, register};
    use fsw_target::drivers::gyro::bus::{RegisterBus, Spi};
    use fsw_target::drivers::wheel_tach::CaptureTimer;
    use fsw_target::flight::sensors::DataReady;
    use fsw_target::flight::supervisor::{Supervisor, Task};
    use fsw_target::runtime::{log, stack};

    fsw_target::ends_by!(exit::end_after);

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(mut board) = Board::take() else { exit::failure() };
        let report = board.report();
        log::init(board.link.into_log_output());
        defmt::info!("{}", report);

        let mut all_well = true;
        all_well &= passed("clock", time_goes_on());
        all_well &= passed("data ready", data_ready_stamps(&mut board.data_ready));
        all_well &= passed("loop in an interrupt", in_interrupt::loop_flies(board.data_ready));
        all_well &= passed("watchdog", watchdog_takes_food(&mut board.watchdog));
        look_at_wheels(&mut board.captures.start(SHORTEST_EDGE_S));
        look_for_gyro(board.gyro_bus);
        look_at_flash(&mut board.flash);
        let echoed = echo(&mut board.tunnel);
        defmt::info!("USART2: {=u32} bytes sent back, {}", echoed, board.tunnel.counters());
        defmt::info!(
            "stack: {=u32} of {=u32} bytes",
            stack::high_water_bytes(),
            stack::size_bytes()
        );
        if all_well { exit::success() } else { exit::failure() }
    }

    /// Says so.
    fn passed(part: &'static str, passes: bool) -> bool {
        defmt::info!("{=str}: {=str}", part, if passes { "works" } else { "FAILS" });
        passes
    }

    /// Time goes on and never back, and a delay takes at least its time.
    fn time_goes_on() -> bool {
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

    /// One interrupt, one stamp of its time; three, and the newest stamp is the one.
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

    /// The watchdog is not started: it can't be stopped any more when the image ends.
    fn watchdog_takes_food(watchdog: &mut fsw_target::board::Watchdog) -> bool {
        let mut supervisor = Supervisor::new();
        Task::ALL.into_iter().for_each(|task| supervisor.report(task));
        let permit = supervisor.permit();
        let is_granted = permit.is_some();
        permit.into_iter().for_each(|permit| watchdog.feed(permit));
        is_granted && supervisor.permit().is_none()
    }

    /// Half of the time between the edges of the fastest wheel: 6000 rpm, 24 edges a turn.
    const SHORTEST_EDGE_S: f32 = 0.5 / (100.0 * 24.0);

    /// Where the wheels are after a second; turn them by hand to see something.
    fn look_at_wheels(captures: &mut WheelCaptures) {
        Delay.delay_ms(1_000);
        match captures.captured() {
            Ok(captured) => defmt::info!("wheel edges in a second: {}", captured.map(|c| c.edges)),
            Err(error) => defmt::warn!("wheels: {}", error),
        }
    }

    /// Asks the gyro who it is.
    fn look_for_gyro(bus: GyroBus) {
        let mut id = [0];
        match Spi::new(bus).read(register::CHIP_ID, &mut id) {
            Ok(()) if id == [CHIP_ID] => defmt::info!("gyro: there"),
            Ok(()) => defmt::warn!("gyro: not there, {=[u8; 1]:#04x} answers for an identity", id),
            Err(error) => defmt::warn!("gyro: the bus failed, {}", error),
        }
    }

    /// Erases the last sector, writes to it and reads it back.
    fn look_at_flash(flash: &mut CheckpointFlash) {
        const PATTERN: [u8; 8] = *b"bringup\n";
        let end = flash.capacity() as u32;
        let start = end - CheckpointFlash::ERASE_SIZE as u32;
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

    /// How often the tunnel is asked in vain before it is left alone: a few seconds.
    const IDLE_POLLS: u32 = 6_000_000;

    /// Sends back what comes until nothing comes any more. Returns the number of bytes.
    fn echo(tunnel: &mut Tunnel) -> u32 {
        let mut echoed: u32 = 0;
        let mut idle = 0;
        while idle < IDLE_POLLS {
            match tunnel.read() {
                Ok(byte) => {
                    // As long as a byte takes on the line, and then it is given up.
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
    println!("looks at a board: cargo qemu bringup");
}
