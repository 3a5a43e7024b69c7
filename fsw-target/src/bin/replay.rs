//! `replay`: steps the committed recording by every estimator and logs the results, bit by bit.
//!
//! | | |
//! |---|---|
//! | purpose | comparison of target and host, bit by bit; the second image to flash on a new board,
//! after `bringup` |
//! | rate | as fast as the core allows; time stamps from the recording (10 Hz) |
//! | estimator | nine-state joint filter in UD form, `f32`, four wheels; then each estimator of the image |
//! | log | defmt, on RTT and on the serial port of the link (115200 baud): progress, then state and covariance as bits, and one digest for each estimator |
//! | end | success if every sample was accepted and the estimate converged, failure otherwise |
//!
//! `cargo qemu replay` runs it in QEMU, `cargo board replay` on a board. The host program prints the
//! same lines: `cargo run -p fsw-target --bin replay`.

#![cfg_attr(target_os = "none", no_std, no_main)]

use fsw_core::{Estimator, Status};
use fsw_target::flight::flight_loop::Tick;
use fsw_target::flight::selected::{EstimatorId, SelectedEstimator};
use fsw_target::log_line;
use fsw_target::stand_in::replay::{self, ReplayLoop};

/// Samples per progress line: ten seconds at 10 Hz.
const SAMPLES_PER_LINE: u32 = 100;

/// Logs the digest of the recording by each estimator of the image. Not inlined: the stack of [`fly`] is free again.
///
/// # Errors
/// The reason, for the log.
#[inline(never)]
fn fly_all(estimator: &mut SelectedEstimator) -> Result<(), &'static str> {
    for &id in EstimatorId::BUILT_IN {
        let digest = replay::digest(estimator, id).map_err(|_| "an estimator does not start")?;
        log_line!("digest {} {:#018x}", id.name(), digest);
    }
    Ok(())
}

/// Steps the recording to its end.
///
/// # Errors
/// The reason, for the log.
#[inline(never)]
fn fly() -> Result<(), &'static str> {
    let recording = replay::recording();
    let mut flight = replay::flight_loop(&recording).map_err(|error| {
        log_line!("{:?}", error);
        "the estimator rejects the craft file"
    })?;

    let mut samples: u32 = 0;
    loop {
        match flight.tick() {
            Tick::Idle => break,
            Tick::Stepped { .. } => samples += 1,
            Tick::GyroFailed(_) | Tick::WheelsFailed(_) => return Err("a sensor reading failed"),
            Tick::Overtaken => return Err("a sample was lost to a newer one"),
        }
        if samples.is_multiple_of(SAMPLES_PER_LINE) {
            log_progress(samples, &flight);
        }
    }

    log_result(&flight);
    verdict(samples, &flight)
}

fn log_progress(samples: u32, flight: &ReplayLoop) {
    let estimate = flight.estimator().estimate();
    let [jxx, jyy, jzz, ..] = estimate.inertia.elements_kg_m2();
    log_line!(
        "{} samples, {:?}, moments {:?} {:?} {:?} kg m2",
        samples,
        estimate.status,
        jxx,
        jyy,
        jzz
    );
}

/// Logs every element of state and covariance as the bits of its `f32`, one matrix row per line, for
/// the comparison of host and target.
fn log_result(flight: &ReplayLoop) {
    log_bits("state", 0, flight.estimator().0.state());
    let rows: [[f32; 9]; 9] = flight.estimator().0.covariance().transpose().into();
    for (index, row) in rows.into_iter().enumerate() {
        log_bits("covariance", index, row);
    }
}

fn log_bits(name: &'static str, row: usize, values: [f32; 9]) {
    let [a, b, c, d, e, f, g, h, i] = values.map(f32::to_bits);
    log_line!(
        "{}[{}] {:#010x} {:#010x} {:#010x} {:#010x} {:#010x} {:#010x} {:#010x} {:#010x} {:#010x}",
        name,
        row,
        a,
        b,
        c,
        d,
        e,
        f,
        g,
        h,
        i
    );
}

fn verdict(samples: u32, flight: &ReplayLoop) -> Result<(), &'static str> {
    if flight.counters().outcomes.accepted != samples {
        return Err("samples were rejected");
    }
    match flight.estimator().estimate().status {
        Status::Converged => Ok(()),
        _ => Err("the estimate did not converge"),
    }
}

#[cfg(target_os = "none")]
fsw_target::ends_by!(fsw_target::arch::exit::end_after);

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use fsw_target::arch::exit;
    use fsw_target::board::{Board, now_us};
    use fsw_target::runtime::log;
    use static_cell::ConstStaticCell;

    // In static memory: it exceeds the stack.
    static ESTIMATOR: ConstStaticCell<SelectedEstimator> =
        ConstStaticCell::new(SelectedEstimator::uninitialised());

    if let Some(board) = Board::take() {
        log::init(board.link.into_log_output());
    }
    let start_us = now_us();
    let all = fly().and_then(|()| match ESTIMATOR.try_take() {
        Some(estimator) => fly_all(estimator),
        None => Err("the estimator exists already"),
    });
    defmt::info!("{=u64} us of on-board time", now_us().saturating_sub(start_us));
    match all {
        Ok(()) => exit::success(),
        Err(reason) => {
            defmt::error!("{=str}", reason);
            exit::failure()
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() -> Result<(), &'static str> {
    fly()?;
    fly_all(&mut SelectedEstimator::uninitialised())
}
