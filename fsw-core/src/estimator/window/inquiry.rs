//! Inquiry into a contradiction: the blocks before and after it, fitted apart.
//!
//! | before | after | tensors | verdict |
//! |---|---|---|---|
//! | explained | explained | contradict each other | the inertia has changed: the past is discarded |
//! | explained | explained | agree | the motion was interrupted: both are kept, as two windows |
//! | not explained | explained | | the blocks before are discarded |
//! | | not explained | | asked again with more blocks; in the end the model is wrong |

use super::belief::{CONTRADICTED, Past};
use super::front::Front;
use super::pass::Pass;
use super::work::Work;
use super::{Closing, Schedule, Window};
use crate::math::scalar::Real;
use crate::outcome::Reset;

/// Fewest blocks that are fitted apart.
const FEWEST: usize = 12;
/// Attempts with the blocks after a contradiction before the model is taken to be wrong.
const MOST_ATTEMPTS: u8 = 12;
/// Blocks at reduced weight in a row that are not outliers.
const LONG_RUN: u32 = 5;
/// Clean blocks after an interruption until the residuals are called white again.
const CLEAN_BLOCKS: u32 = 24;

/// Inquiry in progress.
#[derive(Clone, Copy, Debug)]
pub struct Inquiry<T: Real> {
    /// First block after the contradiction.
    pub rise: usize,
    /// Information of the blocks before it, where these are explained.
    before: Option<Past<T>>,
    /// True once the blocks before it have been fitted.
    has_before: bool,
    /// True while a fit for the inquiry is in progress.
    pub has_asked: bool,
    attempts: u8,
}

crate::persist!([T: Real] Inquiry<T> { rise, before, has_before, has_asked, attempts });

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// Begins or continues an inquiry after a fit that is settled, but does not explain all blocks.
    ///
    /// Blocks at reduced weight that ended some blocks ago are a fault that is over: what comes after it is
    /// fitted. Otherwise all blocks since the contradiction are.
    pub(super) fn inquire(&mut self, fit: &Front<T, U>) {
        let residuals = &fit.pass.residuals;
        let run = residuals.longest;
        let is_long = run.count >= LONG_RUN;
        if !fit.is_settled || !residuals.is_contradicted && !is_long {
            return;
        }
        let begin = if is_long { run.from } else { residuals.rise };
        let is_over = is_long && run.after + FEWEST <= fit.pass.next;
        let rise = if is_over { run.after } else { begin };
        let inquiry = self.inquiry.get_or_insert(Inquiry {
            rise,
            before: None,
            has_before: false,
            has_asked: false,
            attempts: 0,
        });
        inquiry.rise = rise;
        if !inquiry.has_before && begin >= FEWEST {
            inquiry.has_asked = true;
            return self.begin_start(0, begin, None);
        }
        inquiry.has_before = true;
        self.ask_after();
    }

    /// Asks for a fit of the blocks after the contradiction, once there are enough of them.
    fn ask_after(&mut self) {
        let end = self.end();
        let Some(inquiry) = &mut self.inquiry else { return };
        let enough = inquiry.rise + FEWEST;
        inquiry.has_asked = false;
        if inquiry.attempts >= MOST_ATTEMPTS {
            return;
        }
        if end < enough {
            let missing = (enough - end) as u32;
            self.schedule.due_at = self.schedule.blocks.saturating_add(missing);
            return;
        }
        inquiry.attempts += 1;
        inquiry.has_asked = true;
    }

    /// Begins the fit that [`ask_after`](Self::ask_after) asks for. After it and not within: each has a copy
    /// of a task on the stack.
    pub(super) fn begin_asked(&mut self) {
        let rise = self.inquiry.as_ref().filter(|inquiry| inquiry.has_asked).map(|i| i.rise);
        if let (Some(rise), Work::Idle) = (rise, &self.work) {
            self.begin_start(rise, self.end(), None);
        }
    }

    /// Takes the result of a fit for the inquiry, over the blocks from `from` on.
    pub(super) fn answer(&mut self, from: usize, fit: &Front<T, U>) {
        let is_good = self.is_good(fit);
        let before = self.information_of(fit);
        let Some(inquiry) = &mut self.inquiry else { return };
        inquiry.has_asked = false;
        if !inquiry.has_before {
            inquiry.has_before = true;
            inquiry.before = before.filter(|_| is_good);
            return self.ask_after();
        }
        if is_good && fit.is_shape_observed {
            return self.separate(from, fit);
        }
        let since = fit.pass.next.saturating_sub(from) as u32;
        self.schedule.due_at = self.schedule.blocks.saturating_add((since / 4).max(4));
    }

    /// Information of a fit as that of an earlier window, where it is finite.
    fn information_of(&self, fit: &Front<T, U>) -> Option<Past<T>> {
        let pass = &fit.pass;
        let past = Past::joined(self.information(pass), &pass.point, pass.unit_per_kg_m2, None);
        past.information.factor.iter().flatten().all(|x| x.is_finite()).then_some(past)
    }

    /// Ends an inquiry whose later blocks are explained: they become a window of their own.
    #[inline(never)]
    fn separate(&mut self, from: usize, fit: &Front<T, U>) {
        let before = self.inquiry.take().and_then(|inquiry| inquiry.before);
        match before {
            Some(before) if self.contradicts(&before, &fit.pass) => self.forget_past(),
            Some(before) => {
                self.join_earlier(&before);
                self.event = Some(Reset::Lockout);
            }
            None => self.event = Some(Reset::Lockout),
        }
        let start = self.stretch_from(from);
        match &mut self.closing {
            Some(Closing { stretch, .. }) => *stretch = start,
            None => self.open = start,
        }
        let blocks = self.end().saturating_sub(from) as u32;
        self.schedule = Schedule { blocks, fitted: blocks, ..Schedule::new() };
        self.schedule.wait_for_growth(4);
        self.suspect_until = blocks.saturating_add(CLEAN_BLOCKS);
        self.front = Some(*fit);
        self.blocks.drop_before(from);
    }

    /// Discards earlier windows and the prior: the inertia has changed.
    pub(super) fn forget_past(&mut self) {
        self.past = None;
        self.has_prior = false;
        self.event = Some(Reset::Changed);
    }

    /// Adds the blocks before an interruption to the earlier windows.
    fn join_earlier(&mut self, before: &Past<T>) {
        let mut point = super::unknowns::Point::sphere(crate::math::Vec3::zeros());
        point.shape = before.shape;
        let unit = before.per_kg_m2;
        let past = Past::joined(before.information, &point, unit, self.past.as_ref());
        self.past = Some(past);
        self.past_age_s = T::zero();
    }

    /// True where the tensors before and after contradict each other.
    fn contradicts(&self, before: &Past<T>, pass: &Pass<T, U>) -> bool {
        let (window, sigma) = self.window_alone(pass);
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.prior = None;
        beliefs.past = Some(before);
        beliefs.noise_rad_s = sigma;
        beliefs.contradiction(&window, &pass.point) > T::lit(CONTRADICTED)
    }
}
