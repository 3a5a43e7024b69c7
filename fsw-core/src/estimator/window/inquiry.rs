//! Inquiry into a contradiction: the blocks before and after it, fitted apart.
//!
//! | after | before | consequence |
//! |---|---|---|
//! | explained | explained | window of its own; the blocks before join the earlier windows |
//! | explained | not explained | window of its own; the blocks before are discarded |
//! | not explained | | asked again with later blocks; in the end the model is wrong |
//!
//! The blocks after a contradiction contain the fault itself. Where their residuals show its end, they are fitted from
//! there; where they do not, the newest blocks are fitted, again as the time since the contradiction grows by a quarter:
//! a fault costs its own duration and a quarter of it. A fit that is explained, but does not determine the shape, is
//! repeated from the same block.
//!
//! # Doubt
//!
//! A transient fault and a change of the inertia look alike at first. The new window therefore starts without
//! earlier windows and without prior: they are *doubted*, kept but not used. Once the new window alone is so
//! certain that a change of [`DECISIVE`] would contradict what is doubted, chi-square decides:
//!
//! | tensors | verdict |
//! |---|---|
//! | contradict each other | the inertia has changed: what is doubted and the prior are discarded |
//! | agree, or nothing is doubted | the motion was interrupted: what is doubted joins the window |
//!
//! Until then the residuals are not called white: the window may lie within a fault that goes on, or be too short to
//! show an error of the model. Such an error has no outcome: the interruption is reported with the verdict, where all
//! residuals were white.
//!
//! A new window ends the doubt at once where it agrees with what is doubted. All other verdicts take a further fit, and
//! after contradictions that recur a time without one ([`Recurrence`]).

use super::work::Work;
use super::{Closing, Schedule, Window};
use crate::fit::belief::Past;
use crate::fit::descent::Descent;
use crate::fit::front::{Fit, Front};
use crate::math::scalar::Real;
use crate::math::square_root_information::SquareRootInformation;
use crate::monitor::residuals::Residuals;
use crate::outcome::Reset;
use crate::trajectory::unknowns::{scale_of, shape_of};

/// Fewest blocks that are fitted apart: before a contradiction, and after it. The latter begin a window, whose
/// residuals are to be as white as those of 24 clean blocks.
const FEWEST_BEFORE: usize = 12;
const FEWEST: usize = 24;
/// Inquiries into the same contradiction before the model is taken to be wrong, and later blocks of which one
/// of them begins again.
const MOST_INQUIRIES: u8 = 12;
const MOST_BEGINS: u8 = 6;
/// Fewest blocks of a window of its own whose residuals are not white: a shorter one may contain a rest of the fault. Ten
/// seconds of a fault at 10 Hz are 25 blocks.
const FEWEST_NOT_WHITE: u32 = 64;
/// Blocks at reduced weight in a row that are not outliers.
const LONG_RUN: u32 = 5;
/// Change that is to be excluded, 2 % of the mean moment, over the sigmas by which a tensor must differ to
/// contradict: `√33`.
const DECISIVE: f64 = 0.02 / 5.75;

/// Inquiry in progress.
#[derive(Clone, Copy, Debug)]
pub struct Inquiry {
    /// First block of the contradiction, and of the blocks after it that are fitted.
    rise: usize,
    pub from: usize,
    /// The last fit of the blocks after it was explained.
    is_explained: bool,
    /// True once the blocks before it have been fitted.
    has_before: bool,
    /// True while a fit for the inquiry is in progress.
    pub has_asked: bool,
    inquiries: u8,
    begins: u8,
}

crate::persist!([] Inquiry { rise, from, is_explained, has_before, has_asked, inquiries, begins });

impl Inquiry {
    /// Inquiry into a contradiction at these blocks, before its first fit.
    fn at(rise: usize, from: usize) -> Self {
        let (is_explained, has_before, has_asked) = (true, false, false);
        Self { rise, from, is_explained, has_before, has_asked, inquiries: 0, begins: 0 }
    }
}

/// Contradictions that recur: a fault that goes on, or one within another.
///
/// A window that contains the fault alone is explained by a wrong tensor, until the fault varies. Its verdict counts
/// once it has held for as long as the contradictions recurred before it. An estimate from before all of them, with
/// which a window agrees, needs no such time.
#[derive(Clone, Copy, Debug)]
pub struct Recurrence {
    /// Blocks of the windows since the first contradiction, before the present one.
    blocks: u8,
    /// Nothing from before the first one is left to compare with: discarded as before a change, or not explained.
    is_discarded: bool,
}

crate::persist!([] Recurrence { blocks, is_discarded });

impl Recurrence {
    pub const NONE: Self = Self { blocks: 0, is_discarded: false };

    /// A window of this number of blocks has been contradicted, in doubt or not. One of 255 blocks or more is no part of a
    /// fault. `is_known`: an estimate from before is doubted.
    fn separate(&mut self, is_doubtful: bool, is_known: bool, blocks: usize) {
        let blocks = u8::try_from(blocks).unwrap_or(u8::MAX);
        if !is_doubtful && (!self.is_discarded || blocks == u8::MAX) {
            *self = Self::NONE;
        }
        self.is_discarded |= !is_known;
        if is_doubtful || self.is_discarded {
            self.blocks = self.blocks.saturating_add(blocks);
        }
    }

    /// A window of this number of blocks has ended without contradiction.
    pub fn hold(&mut self, blocks: usize) {
        self.blocks = self.blocks.saturating_sub(u8::try_from(blocks).unwrap_or(u8::MAX));
    }

    /// True where a window of this number of blocks is too short for a verdict.
    fn is_waiting(&self, is_changed: bool, blocks: usize) -> bool {
        (is_changed || self.is_discarded) && blocks < usize::from(self.blocks)
    }
}

/// Contradiction that residuals show: the first block of it, and the first block after it.
///
/// Blocks at reduced weight that ended some blocks ago are a fault that is over: what comes after it is fitted.
/// Otherwise all blocks since the contradiction are.
fn contradiction<T: Real>(residuals: &Residuals<T>, next: usize) -> Option<(usize, usize)> {
    let run = residuals.longest;
    if run.count >= LONG_RUN {
        let is_over = run.after + FEWEST_BEFORE <= next;
        return Some((run.from, if is_over { run.after } else { run.from }));
    }
    let is_known = residuals.is_contradicted && residuals.rise < next;
    is_known.then_some((residuals.rise, residuals.rise))
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// Notes where further blocks contradict the front, before a fit over all blocks. Of two parts that disagree and are
    /// equally long, such a fit makes large residuals throughout, which show no instant.
    pub(super) fn note_contradiction(&mut self) {
        let Some(front) = self.front.as_ref().filter(|front| front.is_settled) else { return };
        if let (None, Some((rise, from))) =
            (&self.inquiry, contradiction(&front.pass.residuals, front.pass.next))
        {
            self.inquiry = Some(Inquiry::at(rise, from));
        }
    }

    /// Begins or continues an inquiry after a fit that is settled, but does not explain all blocks: the front.
    #[inline(never)]
    pub(super) fn inquire(&mut self) {
        let Some(front) = self.front.as_ref().filter(|front| front.is_settled) else { return };
        let shown = contradiction(&front.pass.residuals, front.pass.next);
        // Large residuals throughout show no instant; that of the last fit is still valid.
        let known = self.inquiry.as_ref().map(|inquiry| (inquiry.rise, inquiry.from));
        let Some((begin, from)) = shown.or(known) else { return };
        let newest = self.end().saturating_sub(FEWEST);
        let inquiry = self.inquiry.get_or_insert(Inquiry::at(begin, from));
        if inquiry.inquiries == 0 && !self.is_doubtful {
            self.doubted = None;
        }
        inquiry.rise = begin;
        let is_end_shown = from > begin;
        inquiry.from = if inquiry.is_explained {
            if is_end_shown { inquiry.from.min(from) } else { inquiry.from }
        } else if is_end_shown && from != inquiry.from {
            from
        } else {
            newest.max(begin)
        };
        inquiry.begins = 0;
        inquiry.inquiries = inquiry.inquiries.saturating_add(1);
        if inquiry.inquiries > MOST_INQUIRIES {
            return;
        }
        if !inquiry.has_before && begin >= FEWEST_BEFORE {
            inquiry.has_asked = true;
            return;
        }
        inquiry.has_before = true;
        self.ask_after();
    }

    /// Asks for a fit of the blocks after the contradiction, once there are enough of them.
    fn ask_after(&mut self) {
        let end = self.end();
        let Some(inquiry) = &mut self.inquiry else { return };
        let from = inquiry.from;
        inquiry.has_asked = end >= from + FEWEST;
        if !inquiry.has_asked {
            let missing = (from + FEWEST).saturating_sub(end) as u32;
            self.schedule.due_at = self.schedule.blocks.saturating_add(missing);
        }
    }

    /// Continues an inquiry without another fit of all blocks, which cannot explain them: the front has taken in the
    /// newer ones. False where all blocks are to be fitted.
    #[inline(never)]
    pub(super) fn continues_inquiry(&mut self) -> bool {
        if !self.inquiry.as_ref().is_some_and(|inquiry| inquiry.has_before) {
            return false;
        }
        self.inquire();
        let is_waiting = self.schedule.due_at < u32::MAX;
        is_waiting || self.has_asked()
    }

    /// True where an inquiry asks for a fit, or one for it is in progress.
    pub(super) fn has_asked(&self) -> bool {
        self.inquiry.as_ref().is_some_and(|inquiry| inquiry.has_asked)
    }

    /// Begins the fit that an inquiry asks for: of the blocks before the contradiction, then of those after it. False where it
    /// asks for none.
    pub(super) fn begins_asked(&mut self) -> bool {
        let Some(inquiry) = self.inquiry.as_ref().filter(|inquiry| inquiry.has_asked) else {
            return false;
        };
        let (from, end) =
            if inquiry.has_before { (inquiry.from, self.end()) } else { (0, inquiry.rise) };
        self.begin_start(from, end, None);
        true
    }

    /// Takes the result of a fit for the inquiry, which is the present task.
    #[inline(never)]
    pub(super) fn answer(&mut self, fit: &Fit) {
        let Some(inquiry) = &mut self.inquiry else { return };
        inquiry.has_asked = false;
        if !inquiry.has_before {
            inquiry.has_before = true;
            if !self.is_doubtful {
                self.doubted = None;
                if fit.is_good {
                    self.doubt();
                }
            }
            return self.ask_after();
        }
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let is_long = pass.residuals.blocks >= FEWEST_NOT_WHITE;
        let is_white = is_long || self.is_white(pass, fit.is_settled) != Some(false);
        if fit.is_good && fit.is_shape_observed && is_white {
            return self.separate(fit);
        }
        let Some(inquiry) = &mut self.inquiry else { return };
        let residuals = &pass.residuals;
        let later = contradiction(residuals, pass.next).map(|(_, rise)| rise);
        let run = residuals.longest;
        // Blocks at reduced weight at the begin of the fit are the rest of the fault.
        let is_rest = !is_white && run.count > 0 && run.from < fit.from + FEWEST_BEFORE;
        let later = if is_rest { Some(run.after) } else { later.filter(|_| run.count >= LONG_RUN) };
        if let Some(rise) = later.filter(|rise| *rise > fit.from)
            && inquiry.begins < MOST_BEGINS
        {
            inquiry.from = rise;
            inquiry.begins += 1;
            return self.ask_after();
        }
        inquiry.is_explained = fit.is_good;
        let since = pass.next.saturating_sub(inquiry.rise) as u32;
        self.schedule.due_at = self.schedule.blocks.saturating_add((since / 4).max(4));
    }

    /// The fit of the blocks before the contradiction is doubted, as an earlier window.
    #[inline(never)]
    fn doubt(&mut self) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let mut window = SquareRootInformation::default();
        self.information(pass, &mut window);
        let (scale, sigma) = (pass.point.scale(), self.sigma_of_sample(pass));
        Past::replace(&mut self.doubted, &mut window, &pass.point, pass.unit_per_kg_m2);
        if C > 0 {
            self.doubt_cross(scale, sigma);
        }
    }

    /// Ends an inquiry whose later blocks are explained: they become a window of their own, and all that came
    /// before is doubted.
    #[inline(never)]
    fn separate(&mut self, fit: &Fit) {
        self.inquiry = None;
        let was_doubtful = self.is_doubtful;
        self.put_in_doubt();
        self.recurrence.separate(was_doubtful, self.doubted.is_some(), fit.from);
        let start = self.stretch_from(fit.from);
        match &mut self.closing {
            Some(Closing { stretch, .. }) => *stretch = start,
            None => self.open = start,
        }
        let blocks = self.end().saturating_sub(fit.from) as u32;
        self.schedule = Schedule { blocks, fitted: blocks, ..Schedule::new() };
        self.schedule.wait_for_growth(4);
        self.take_front(fit);
        if let Some(front) = &mut self.front {
            front.pass.residuals.drop_before(fit.from);
        }
        self.blocks.drop_before(fit.from);
    }

    /// Earlier windows are doubted. Where something is doubted already, they are discarded: they came after it.
    pub(super) fn put_in_doubt(&mut self) {
        if !self.is_doubtful {
            self.doubt_past();
        }
        self.is_doubtful = true;
        self.past = None;
    }

    /// Earlier windows join what is doubted.
    #[inline(never)]
    fn doubt_past(&mut self) {
        if C > 0 {
            self.doubt_past_cross();
        }
        match (&mut self.doubted, &self.past) {
            (Some(doubted), Some(past)) => doubted.join(past, &self.groups),
            (Some(_), None) => {}
            (None, _) => self.doubted = self.past,
        }
    }

    /// Discards earlier windows and the prior: the inertia has changed.
    pub(super) fn forget_past(&mut self) {
        self.past = None;
        self.forget_doubted();
    }

    /// Discards what is doubted and the prior.
    fn forget_doubted(&mut self) {
        self.doubted = None;
        self.is_doubtful = false;
        self.prior = None;
        self.is_known_white = true;
        self.recurrence.is_discarded = true;
        self.event = Some(Reset::Changed);
    }

    /// True where the front is long and white enough for this verdict.
    #[inline(never)]
    fn may_decide(&self, is_changed: bool, is_new: bool) -> bool {
        let blocks = self.end();
        let is_agreement = !is_changed && self.doubted.is_some();
        if is_new && !is_agreement || self.recurrence.is_waiting(is_changed, blocks) {
            return false;
        }
        let is_long = is_changed && blocks >= FEWEST_NOT_WHITE as usize;
        let needs_white = is_new || is_changed && !is_long;
        (!is_changed || self.is_known_white || self.closing.is_some())
            && (!needs_white || self.is_front_white())
    }

    /// Decides on what is doubted, once the window alone is certain enough: the front. A window that is new may agree with
    /// what is doubted; for another verdict it has to be explained by a further fit, since it may lie within a fault.
    #[inline(never)]
    pub(super) fn reconsider(&mut self, is_new: bool) {
        match self.contradicts_doubted() {
            None => {}
            Some(is_changed) if !self.may_decide(is_changed, is_new) => {}
            Some(true) => self.forget_doubted(),
            Some(false) => {
                if self.doubted.is_some() {
                    self.doubt_past();
                    self.past = self.doubted;
                    self.considered.past = self.considered.doubted;
                    self.doubted = None;
                }
                self.is_doubtful = false;
                if self.is_known_white && self.is_front_white() {
                    self.event = Some(Reset::Interrupted);
                }
            }
        }
    }

    /// True where no test finds the residuals of the front other than white.
    pub(super) fn is_front_white(&self) -> bool {
        let white = |front: &Front<T, W, U, M>| self.is_white(&front.pass, front.is_settled);
        self.front.as_ref().and_then(white) != Some(false)
    }

    /// True where the front contradicts what is doubted; `None` without doubt, or where the front is not certain enough.
    #[inline(never)]
    fn contradicts_doubted(&self) -> Option<bool> {
        if !self.is_doubtful {
            return None;
        }
        let pass = &self.front.as_ref()?.pass;
        let mut window = SquareRootInformation::default();
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        let sigma = self.window_alone(pass, &mut window);
        beliefs.noise_rad_s = sigma;
        beliefs.add_known(&mut window, &pass.point);
        beliefs.add_hardware(&mut window, &pass.point);
        if !is_decisive(&window, pass.point.scale(), sigma) {
            return None;
        }
        let Some(doubted) = &self.doubted else { return Some(false) };
        (beliefs.prior, beliefs.past) = (None, Some(doubted));
        if C > 0 {
            let doubted = Some((doubted, &self.considered.doubted));
            self.widen(&mut window, (pass.unit_per_kg_m2, sigma), doubted);
        }
        Some(beliefs.contradiction(&mut window, &pass.point) > beliefs.contradicted())
    }
}

/// True where each coordinate of the shape and the scale have sigmas below [`DECISIVE`] of the mean moment, for
/// a sigma of a sample of `sigma_rad_s`.
fn is_decisive<T: Real, const U: usize>(
    window: &SquareRootInformation<T, U>,
    scale: T,
    sigma_rad_s: T,
) -> bool {
    let Some(variances) = window.variances() else { return false };
    let mean = T::lit(DECISIVE / 3.0);
    (shape_of(U)..U).zip(variances.iter().skip(shape_of(U))).all(|(k, variance)| {
        let most = if k < scale_of(U) { mean } else { T::lit(DECISIVE) * scale };
        *variance * (sigma_rad_s * sigma_rad_s) <= most * most
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::square_root_information::unit_row;

    /// Numbers of blocks from which a change and an agreement count.
    fn waits(recurrence: &Recurrence) -> [usize; 2] {
        [true, false].map(|is_changed| {
            (0..400).find(|blocks| !recurrence.is_waiting(is_changed, *blocks)).unwrap()
        })
    }

    /// A fault with an end: what came before it is still doubted, and agreement counts at once.
    #[test]
    fn agreement_with_what_came_before_a_fault_counts_at_once() {
        let mut recurrence = Recurrence::NONE;
        recurrence.separate(false, true, 250);
        assert_eq!(waits(&recurrence), [0, 0]);
        recurrence.separate(true, true, 26);
        assert_eq!(waits(&recurrence), [26, 0]);
        recurrence.separate(true, true, 40);
        assert_eq!(waits(&recurrence), [66, 0]);
        // A contradiction after the verdict that the motion was interrupted is another one.
        recurrence.separate(false, true, 30);
        assert_eq!(waits(&recurrence), [0, 0]);
    }

    /// Agreement with an estimate from within the fault, or with nothing, is no evidence.
    #[test]
    fn a_fault_that_goes_on_has_to_hold_for_as_long_as_it_recurred() {
        let mut recurrence = Recurrence::NONE;
        recurrence.separate(false, false, 103);
        assert_eq!(waits(&recurrence), [103, 103]);
        recurrence.separate(true, false, 26);
        recurrence.separate(false, true, 30);
        assert_eq!(waits(&recurrence), [159, 159]);
        recurrence.hold(59);
        assert_eq!(waits(&recurrence), [100, 100]);
        recurrence.separate(false, true, 200);
        assert_eq!(waits(&recurrence), [255, 255]);
        recurrence.separate(false, true, 300);
        assert_eq!(waits(&recurrence), [0, 0]);
    }

    /// A run of five blocks that ended twelve blocks ago is over; otherwise the contradiction lasts. A cumulative sum that
    /// begins to rise at the next block has no block yet.
    #[test]
    fn contradiction_has_an_instant_and_an_end() {
        let mut residuals = Residuals::<f32>::from_block(0);
        assert_eq!(contradiction(&residuals, 30), None);
        (residuals.is_contradicted, residuals.rise) = (true, 7);
        assert_eq!(contradiction(&residuals, 8), Some((7, 7)));
        assert_eq!(contradiction(&residuals, 7), None);
        (residuals.longest.from, residuals.longest.after) = (3, 9);
        residuals.longest.count = LONG_RUN - 1;
        assert_eq!(contradiction(&residuals, 30), Some((7, 7)));
        residuals.longest.count = LONG_RUN;
        assert_eq!(contradiction(&residuals, 20), Some((3, 3)));
        assert_eq!(contradiction(&residuals, 21), Some((3, 9)));
    }

    /// Each of the six sigmas alone, one percent below and above its limit, for bodies of two sizes.
    #[test]
    fn window_is_decisive_within_a_share_of_the_moments() {
        const SIGMA_RAD_S: f64 = 1e-3;
        for scale in [0.1, 10.0] {
            let is_decisive = |beyond: usize, by: f64| {
                let mut window = SquareRootInformation::<f64, 12>::default();
                for k in 0..12 {
                    let limit = if k < scale_of(12) { DECISIVE / 3.0 } else { DECISIVE * scale };
                    let sigma = limit * if k == beyond { by } else { 0.9 };
                    window.fold(&unit_row(k), 0.0, (SIGMA_RAD_S / sigma).powi(2));
                }
                is_decisive(&window, scale, SIGMA_RAD_S)
            };
            for k in shape_of(12)..12 {
                assert!(is_decisive(k, 0.99) && !is_decisive(k, 1.01), "{k} {scale}");
            }
            assert!(is_decisive(0, 100.0), "a coordinate of the motion");
        }
    }
}
