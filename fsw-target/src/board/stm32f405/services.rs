//! Services of the board for the flight computer: clock, watchdog and health.

use super::BoardReport;
use super::option_bytes::OptionBytes;
use super::rates::ClockSource;
use super::reset::ResetCause;
use super::time::Delay;
use super::watchdog::Watchdog;
use super::{clocks, supply, time, usart};
use crate::flight::computer::{Health, Housekeeping};
use crate::flight::sensors::NoMotors;
use crate::flight::supervisor::FeedPermit;
use crate::link::telemetry;
use crate::runtime::failure::LastRun;
use crate::runtime::{restart, stack};
use cortex_m::peripheral::SCB;

/// Services of the board, with the watchdog running.
pub struct Services {
    watchdog: Watchdog,
    delay: Delay,
    motors: NoMotors,
    reset_cause: ResetCause,
    options: OptionBytes,
    last_run: LastRun,
}

impl Services {
    /// Starts the watchdog, which must be fed from now on.
    pub fn start(mut watchdog: Watchdog, report: &BoardReport, last_run: LastRun) -> Self {
        watchdog.start();
        let BoardReport { reset_cause, options, .. } = *report;
        Self { watchdog, delay: Delay, motors: NoMotors, reset_cause, options, last_run }
    }
}

impl Housekeeping for Services {
    type Delay = Delay;
    type Motors = NoMotors;

    fn now_us(&mut self) -> u64 {
        time::now_us()
    }

    fn resume_at(&mut self, time_us: u64) {
        time::resume_at(time_us);
    }

    fn delay(&mut self) -> &mut Delay {
        &mut self.delay
    }

    /// The wheels are commanded by another unit.
    fn motors(&mut self) -> &mut NoMotors {
        &mut self.motors
    }

    fn feed(&mut self, permit: FeedPermit) {
        self.watchdog.feed(permit);
    }

    fn health(&mut self) -> Health {
        let lost = usart::link_counters();
        Health {
            reset_cause: self.reset_cause.into(),
            last_run: self.last_run,
            clock: match clocks::in_force().source {
                ClockSource::Crystal => telemetry::ClockSource::Crystal,
                ClockSource::Internal => telemetry::ClockSource::Internal,
            },
            watchdog: self.watchdog.is_running(),
            brown_out: self.options.brown_out(),
            option_bytes_as_set: self.options.are_as_set(),
            supply_low: supply::is_low(),
            stack_high_water_bytes: stack::high_water_bytes(),
            serial_errors: lost.overruns.saturating_add(lost.line_errors),
        }
    }

    fn note_long_life(&mut self) {
        restart::note_long_life();
    }

    fn reboot(&mut self) {
        SCB::sys_reset();
    }
}

impl From<ResetCause> for telemetry::ResetCause {
    fn from(cause: ResetCause) -> Self {
        match cause {
            ResetCause::PowerOn => Self::PowerOn,
            ResetCause::BrownOut => Self::BrownOut,
            ResetCause::Pin => Self::Pin,
            ResetCause::Software => Self::Software,
            ResetCause::IndependentWatchdog | ResetCause::WindowWatchdog => Self::Watchdog,
            ResetCause::LowPower => Self::LowPower,
            ResetCause::Unknown => Self::Unknown,
        }
    }
}
