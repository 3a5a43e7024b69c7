//! Checks of single parts: for the report of `bringup`, and one by one as `board-tests`.

use embedded_hal::delay::DelayNs;
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use fsw_target::board::{
    CaptureInputs, Delay, GyroBus, GyroDataReady, SectorPair, Watchdog, now_us,
};
use fsw_target::drivers::gyro::RateGyro;
use fsw_target::drivers::gyro::bus::Spi;
use fsw_target::drivers::gyro::fitted::{Chip, Settings};
use fsw_target::drivers::wheel_tach::CaptureTimer;
use fsw_target::flight::sensors::DataReady;
use fsw_target::flight::supervisor::{Supervisor, Task};

/// The clock is monotonic, and a delay takes at least its duration.
pub fn clock_advances() -> bool {
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
pub fn data_ready_stamps(data_ready: &mut GyroDataReady) -> bool {
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
pub fn watchdog_is_fed_by_permit(watchdog: &mut Watchdog) -> bool {
    let mut supervisor = Supervisor::new();
    Task::ALL.into_iter().for_each(|task| supervisor.report(task));
    let permit = supervisor.permit();
    let is_granted = permit.is_some();
    permit.into_iter().for_each(|permit| watchdog.feed(permit));
    is_granted && supervisor.permit().is_none()
}

/// The fitted gyro answers with its identity. Logs what is found.
pub fn gyro_answers(bus: GyroBus) -> bool {
    let expected = <Chip<Spi<GyroBus>> as RateGyro>::IDENTITY;
    match Chip::new(Spi::new(bus), Settings::default()).identity() {
        Ok(found) if found == expected => {
            defmt::info!("gyro: works");
            return true;
        }
        Ok(found) => {
            defmt::warn!("gyro: identity {=u8:#04x}, expected {=u8:#04x}", found, expected);
        }
        Err(error) => defmt::warn!("gyro: {}", error),
    }
    false
}

/// The last sector keeps what is written after an erase. Logs the result.
pub fn flash_keeps(flash: &mut SectorPair) -> bool {
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
            defmt::info!("flash: works, erased and written in {=u64} us", now_us() - start_us);
        }
        Err(error) => defmt::warn!("flash: {}", error),
    }
    result.is_ok() && read == PATTERN
}

/// Shortest interval between edges, s: half of that at 6000 rpm and 24 edges per turn.
const SHORTEST_EDGE_S: f32 = 0.5 / (100.0 * 24.0);

/// Every wheel has edges within one second: turn the wheels by hand. Logs their number.
pub fn every_wheel_has_edges(inputs: CaptureInputs) -> bool {
    let mut captures = inputs.start(SHORTEST_EDGE_S);
    Delay.delay_ms(1_000);
    match captures.captured() {
        Ok(captured) => {
            defmt::info!("wheel edges in one second: {}", captured.map(|c| c.edges));
            captured.iter().all(|captured| captured.edges > 0)
        }
        Err(error) => {
            defmt::warn!("wheels: {}", error);
            false
        }
    }
}
