//! Result of a fit: what it explains and observes, and how its information joins that of earlier windows.

use super::Work;
use crate::estimator::window::considered::Source;
use crate::estimator::window::steadiness::Steadiness;
use crate::estimator::window::{FIRST_FIT_BLOCKS, Schedule, Window};
use crate::fit::belief::Past;
use crate::fit::descent::Descent;
use crate::fit::front::{Fit, Front};
use crate::fit::pass::Pass;
use crate::math::scalar::Real;
use crate::math::square_root_information::SquareRootInformation;
use crate::monitor::whiteness::chi_square;
use crate::trajectory::unknowns::{Belief, GROUPS, Group, groups_of};

/// Residual over noise above which a model does not explain the blocks, and normal quantile of the square that chance leaves
/// in few of them: once in 30,000 fits. It is the larger of both up to 140 degrees of freedom.
const EXPLAINED: f64 = 1.3;
const BY_CHANCE_SIGMA: f64 = 4.0;
/// Share of the range of the shape below which it is observed.
const SHAPE_OBSERVED: f64 = 0.5;
/// Contradiction of an assumed absence of drag: chi-square of three degrees of freedom exceeds it once
/// in 10⁵.
const DRAG_SHOWN: f64 = 26.0;
/// One sigma of a gyro bias that is allowed for beside drag, rad/s: a steady rate against the air and a
/// steady error of the gyro look alike, and consumer gyros have 1 deg/s of it.
const BIAS_WITH_DRAG_RAD_S: f64 = 0.02;

/// Largest square of the residual over the noise that a model explains, for this number of degrees of freedom.
fn most_explained<T: Real>(degrees: u32) -> T {
    let degrees = degrees.max(1);
    let by_chance = chi_square::<T>(degrees, BY_CHANCE_SIGMA) / T::count(degrees);
    by_chance.max(T::lit(EXPLAINED * EXPLAINED))
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// True where the residuals of a pass agree with the noise, but for outliers: those at the point, or
    /// those at the solution of the blocks alone, from which earlier windows and the prior may differ.
    #[inline(never)]
    pub(in super::super) fn is_explained(&self, pass: &Pass<T, W, U, M>) -> bool {
        let at_point = pass.residuals.typical(pass.unit_rad_s);
        let unknowns = self.unknowns();
        let typical =
            at_point.min(crate::estimator::window::report::rms(&pass.residuals, unknowns));
        let most = most_explained::<T>(pass.residuals.degrees(unknowns));
        let reference = self.reference_rad_s();
        typical * typical <= most * (reference * reference) + self.explained(pass)
            && !pass.residuals.has_many_low()
            && pass.is_finite()
    }

    /// Judges what the fit that has ended observes.
    #[inline(never)]
    pub(super) fn judge_fit(&mut self) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let observed = self.observed_by(pass);
        if let Work::Descent(Descent { fit: Some(fit), .. }) = &mut self.work {
            fit.observed = Some(observed);
        }
    }

    /// The fit that has ended, with all judgements.
    fn judged_fit(&self) -> Option<Fit> {
        let Work::Descent(Descent { pass, fit: Some(fit), .. }) = &self.work else { return None };
        Some(Fit {
            is_good: self.is_good(pass, fit.is_settled),
            is_shape_observed: self.is_shape_observed(pass),
            ..*fit
        })
    }

    /// Result of all attempts: the new front, or an answer to the inquiry. Calls in sequence: each has a factor of its
    /// own on the stack.
    #[inline(never)]
    pub(super) fn end_fit(&mut self) {
        let Some(fit) = self.judged_fit() else { return };
        if self.has_asked() {
            self.answer(&fit);
            self.work = Work::Idle;
            if self.inquiry.is_none() {
                self.reconsider(true);
            }
            return;
        }
        self.schedule.wait_for_growth(FIRST_FIT_BLOCKS / 2);
        self.take_front(&fit);
        if fit.is_good {
            self.work = Work::Comparison;
            self.inquiry = None;
        } else {
            self.work = Work::Idle;
            self.inquire();
        }
    }

    /// Compares the front, an explained fit, with an assumed absence of drag, with earlier windows and the prior, and with
    /// what is doubted.
    pub(super) fn compare(&mut self) {
        self.work = Work::Idle;
        if self.lets_drag_loose() || self.drop_contradicted() {
            self.schedule.due_at = self.schedule.blocks;
        }
        self.reconsider(false);
    }

    /// The fit that has ended becomes the front.
    #[inline(never)]
    pub(in super::super) fn take_front(&mut self, fit: &Fit) {
        let Work::Descent(Descent { pass, .. }) = &self.work else { return };
        let rows = pass.residuals.rows;
        self.front = Some(Front::new(pass, fit));
        self.steadiness = Steadiness::none();
        if let Some(front) = &mut self.front {
            front.pass.residuals.curvature.end();
        }
        self.take_front_cross(rows);
    }

    /// True for a fit at a minimum whose residuals agree with the noise from the first block to the last.
    pub(in super::super) fn is_good(&self, pass: &Pass<T, W, U, M>, is_settled: bool) -> bool {
        is_settled && self.is_explained(pass) && !pass.residuals.is_contradicted
    }

    /// True where the sigma of every coordinate of the shape is well below its range.
    #[inline(never)]
    fn is_shape_observed(&self, pass: &Pass<T, W, U, M>) -> bool {
        let mut factor = pass.factor;
        let beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.add(&mut factor, &pass.point);
        let Some(variances) = factor.variances() else { return false };
        let most = T::lit(SHAPE_OBSERVED * crate::fit::belief::SHAPE_SIGMA) / beliefs.noise_rad_s;
        let shape = crate::trajectory::unknowns::shape_of(U);
        variances.iter().skip(shape).take(5).all(|v| *v < most * most)
    }

    /// Contradiction of each group that is assumed to be absent by the blocks of a fit: chi-square of three degrees
    /// of freedom. A stated noise that is too small does not exaggerate it.
    #[inline(never)]
    pub(in super::super) fn contradictions(&self, pass: &Pass<T, W, U, M>) -> [T; GROUPS] {
        if groups_of(U) == 0 {
            return [T::zero(); GROUPS];
        }
        let mut factor = pass.factor;
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.noise_rad_s = beliefs.noise_rad_s.max(self.sigma_of_sample(pass));
        beliefs.add(&mut factor, &pass.point)
    }

    /// Drag becomes an unknown where the blocks of the front contradict its absence.
    #[inline(never)]
    fn lets_drag_loose(&mut self) -> bool {
        if groups_of(U) == 0 {
            return false;
        }
        let Some(drag) = self.config.drag_per_s else { return false };
        let Some(Front { pass, .. }) = &self.front else { return false };
        let contradiction = self.contradictions(pass);
        let mut is_loose = false;
        for (place, of_place) in self.groups.place.iter_mut().enumerate() {
            let is_shown = contradiction[place] > T::lit(DRAG_SHOWN);
            if is_shown && matches!(of_place, Some((Group::Drag, Belief::Zero))) {
                *of_place = Some((Group::Drag, Belief::Within([drag; 3])));
                is_loose = true;
            }
        }
        if is_loose {
            let hardware = self.groups.hardware;
            for of_place in self.groups.place.iter_mut().take(hardware) {
                if of_place.is_none() {
                    let bias = Belief::Within([T::lit(BIAS_WITH_DRAG_RAD_S); 3]);
                    *of_place = Some((Group::Bias, bias));
                    break;
                }
            }
        }
        is_loose
    }

    /// Concludes the window that is being closed: its information goes to the past.
    #[inline(never)]
    pub(in super::super) fn conclude(&mut self) {
        let end = self.end();
        self.join_past();
        self.recurrence.hold(end);
        self.front = None;
        self.closing = self.waiting.take();
        self.work = Work::Idle;
        self.inquiry = None;
        self.blocks.drop_before(end);
        let further = self.blocks.len().saturating_sub(end) as u32;
        let is_final = self.closing.is_some();
        self.schedule = Schedule { blocks: further, is_final, ..Schedule::new() };
        self.schedule.reopen();
        self.config.set_groups::<U>(&mut self.groups);
    }

    /// Adds the information of the front to that of the windows before it, unless these contradict it.
    #[inline(never)]
    fn join_past(&mut self) {
        let Some(front) = &self.front else { return };
        let is_good = self.is_good(&front.pass, front.is_settled);
        self.ended = self.ended_with(front);
        if !is_good {
            return;
        }
        self.drop_contradicted();
        self.reconsider(false);
        self.is_known_white &= self.ended.is_white();
        if self.replace_past() {
            let rest_s = if self.is_quiet { self.open.duration_s } else { T::zero() };
            self.age_past(rest_s);
        }
    }

    /// Information of the front, joined with that of the windows before it, as that of earlier windows. False where it
    /// is not finite.
    #[inline(never)]
    fn replace_past(&mut self) -> bool {
        let Some(Front { pass, .. }) = &self.front else { return false };
        let mut window = SquareRootInformation::default();
        self.information(pass, &mut window);
        let unit = pass.unit_per_kg_m2;
        if let Some(past) = self.past_beside() {
            past.add_to(&mut window, &self.groups, &pass.point, unit);
        }
        let (scale, sigma) = (pass.point.scale(), self.sigma_of_sample(pass));
        if C > 0 {
            self.join_cross(Source::Front, (unit, scale), sigma);
        }
        let Some(Front { pass, .. }) = &self.front else { return false };
        let is_finite = Past::replace(&mut self.past, &mut window, &pass.point, unit);
        if let (true, Some(past)) = (is_finite, &self.past) {
            self.unit_per_kg_m2 = past.per_kg_m2;
        }
        is_finite
    }

    /// Writes the information of the blocks alone on hardware and inertia, of unit variance, to `window`.
    pub(in super::super) fn information(
        &self,
        pass: &Pass<T, W, U, M>,
        window: &mut SquareRootInformation<T, U>,
    ) {
        let sigma = self.window_alone(pass, window);
        window.rescale(T::one(), T::one() / (sigma * sigma));
        // The pins of what does not last stay as they are.
        window.eliminate(self.groups.first_kept::<U>());
    }

    /// Discards earlier windows and the prior where the blocks of the front contradict them. Earlier windows with an error of
    /// the model, which the present one is too short to show, are doubted instead. True if they are contradicted.
    fn drop_contradicted(&mut self) -> bool {
        let is_contradicted = self.is_contradicted();
        let has_error = !self.is_known_white && self.closing.is_none() && self.is_front_white();
        if is_contradicted && self.past.is_some() && has_error {
            self.put_in_doubt();
        } else if is_contradicted {
            self.forget_past();
        }
        is_contradicted
    }

    /// True where the blocks of the front contradict earlier windows and the prior.
    #[inline(never)]
    fn is_contradicted(&self) -> bool {
        let Some(Front { pass, .. }) = &self.front else { return false };
        let mut window = SquareRootInformation::default();
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        beliefs.noise_rad_s = self.window_alone(pass, &mut window);
        beliefs.add_hardware(&mut window, &pass.point);
        if C > 0 {
            let past = self.past_beside().map(|past| (past, &self.considered.past));
            self.widen(&mut window, (pass.unit_per_kg_m2, beliefs.noise_rad_s), past);
        }
        beliefs.contradiction(&mut window, &pass.point) > beliefs.contradicted()
    }

    /// Writes the information of the blocks alone on hardware and inertia to `window`, in units of a sample's variance.
    /// Returns the sigma of a sample.
    #[inline(never)]
    pub(in super::super) fn window_alone(
        &self,
        pass: &Pass<T, W, U, M>,
        window: &mut SquareRootInformation<T, U>,
    ) -> T {
        *window = pass.factor;
        let mut beliefs = self.beliefs(pass.unit_per_kg_m2);
        let sigma = self.sigma_of_sample(pass);
        beliefs.noise_rad_s = sigma;
        beliefs.add_of_window(window, &pass.point);
        window.eliminate(self.groups.first_kept::<U>());
        sigma
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::test_hardware::normal;

    /// Residuals of white noise in windows of 5 to 20 blocks and 9 unknowns: chance exceeds 1.3 times the noise in one of ten
    /// windows of five blocks, and four sigmas of chi-square in at most two of 8,000. Twice the noise over 20 blocks is
    /// not explained, and the limit of many blocks is 1.3.
    #[test]
    fn chance_alone_is_explained() {
        let mut normal = normal(1);
        let mut beyond = [0, 0];
        for blocks in [5, 8, 13, 20] {
            let degrees = 3 * blocks - 9;
            let most = most_explained::<f64>(degrees);
            for _ in 0..2000 {
                let square: f64 = (0..degrees).map(|_| normal().powi(2)).sum();
                let mean = square / f64::from(degrees);
                beyond[0] += u32::from(blocks == 5 && mean > EXPLAINED * EXPLAINED);
                beyond[1] += u32::from(mean > most);
            }
        }
        assert!((150..300).contains(&beyond[0]) && beyond[1] <= 2, "{beyond:?}");
        assert!(most_explained::<f64>(51) < 4.0);
        assert_eq!(most_explained::<f64>(171), EXPLAINED * EXPLAINED);
    }
}
