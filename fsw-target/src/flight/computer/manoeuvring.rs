//! Manoeuvre of the flight computer: its telecommands, its steps, its report.
//!
//! A step follows each sample, and each [`LONGEST_GAP_US`](fsw_core::manoeuvre::LONGEST_GAP_US) without one. At take-off
//! a window of the estimator is opened and a checkpoint saved, so that a restart finds the speeds to return to; at the
//! end the window is closed, its fit is completed with the samples that follow, and the next checkpoint has no manoeuvre.
//! In between no checkpoint is saved: an erasure would be a gap.

use super::parts::{Housekeeping, Parts};
use super::{Computer, Reporting, Sampled};
use crate::flight::craft::WHEELS;
use crate::flight::manoeuvre::{Event, SEGMENT};
use crate::flight::sensors::WheelMotors;
use crate::link::telemetry::ManoeuvreReport;
use fsw_core::manoeuvre::{Abort, Reading};
use fsw_core::{Coasting, Outcome};

impl<P: Parts> Computer<'_, P> {
    /// At the start of the computer: no torque, and the return of wheels that a manoeuvre had moved.
    #[inline(never)]
    pub(super) fn restore_manoeuvre(&mut self) {
        let _ = self.board.motors().set_torque_n_m(&[0.0; WHEELS]);
        self.manoeuvre.restore();
    }

    pub(super) fn load_manoeuvre(&mut self, segment: u8, words: &[u32; SEGMENT]) -> bool {
        self.manoeuvre.load(segment, words)
    }

    /// Ends an upload, and keeps the table in flash.
    #[inline(never)]
    pub(super) fn commit_manoeuvre(&mut self, checksum: u32) -> bool {
        !self.manoeuvre.is_active()
            && self.manoeuvre.commit(checksum).is_ok()
            && self.save_checkpoint()
    }

    /// Starts a manoeuvre. Space for the checkpoint at take-off is erased first.
    #[inline(never)]
    pub(super) fn start_manoeuvre(&mut self, at_us: u64) -> bool {
        if self.manoeuvre.is_active() {
            return false;
        }
        if self.flash.may_need_erasure() {
            self.flash.erase_ahead();
            self.gyro.silent_since_us = self.board.now_us();
        }
        self.manoeuvre.start(at_us)
    }

    /// Steps the manoeuvre after a look for a sample.
    #[inline(never)]
    pub(super) fn step_manoeuvre(&mut self, sampled: Sampled) {
        if !self.manoeuvre.is_active() {
            return;
        }
        let now_us = self.board.now_us();
        if sampled == Sampled::Nothing && !self.manoeuvre.is_overdue(now_us) {
            return;
        }
        let reading = self.reading(sampled);
        let (torque_n_m, event) = self.manoeuvre.step(now_us, &reading);
        if !self.board.motors().set_torque_n_m(&torque_n_m) {
            self.manoeuvre.abort(Abort::Motors);
        }
        // An estimator without windows estimates all the same.
        match event {
            Some(Event::TakenOff) => {
                let _ = self.checked().open_window();
                self.save_checkpoint();
            }
            Some(Event::Ended) => {
                let _ = self.checked().close_window();
                self.save_checkpoint();
            }
            None => {}
        }
        if self.reporting == Reporting::EachSample {
            self.report_manoeuvre();
        }
    }

    /// Rate and speeds of the last sample that can be used.
    fn reading(&self, sampled: Sampled) -> Reading<f32, WHEELS> {
        if sampled == Sampled::Nothing {
            return Reading::NONE;
        }
        let outcome = self.last_step.map(|(_, outcome)| outcome);
        let is_rejected =
            matches!(outcome, Some(Outcome::Coasting(Coasting::Rejected(_) | Coasting::Spike)));
        let (readings, follow) = (self.flight.readings(), self.flight.wheels_follow());
        let is_used = sampled != Sampled::Stepped || !is_rejected;
        let mut wheel_speed_rad_s = [None; WHEELS];
        for ((speed, read), follows) in wheel_speed_rad_s
            .iter_mut()
            .zip(readings.wheel_speed_rad_s.iter().flatten())
            .zip(follow)
        {
            *speed = follows.then_some(*read);
        }
        Reading { rate_rad_s: readings.rate_rad_s.filter(|_| is_used), wheel_speed_rad_s }
    }

    /// Queues the report, once an upload has begun.
    #[inline(never)]
    pub(super) fn report_manoeuvre(&mut self) {
        if self.manoeuvre.is_known() {
            let report = ManoeuvreReport::of(self.manoeuvre);
            self.send(&report);
        }
    }
}
