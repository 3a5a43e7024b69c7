//! What the window estimator says of itself: the estimate at any time.

use super::Window;
use super::pass::{Pass, Residuals};
use super::solution::{Solution, Solving, finish, solve_past};
use super::unknowns::{has_bias, has_torque};
use super::work::Work;
use crate::estimate::{Estimate, Status};
use crate::math::{Vec3, scalar::Real};
use crate::monitor::nearest_physical::nearest_physical;
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Where noise alone exceeds a sum of squares once in eˣ windows, the model is rejected. Of chi-square
/// with k degrees of freedom that is at most `k + 2 √(k x) + 2 x` (Laurent and Massart, Ann. Stat. 28,
/// 2000, Lemma 1): 20 makes it once in 5·10⁸.
const REJECTED: f64 = 20.0;
/// Torque that noise alone imitates once in 150 windows: chi-square of three degrees of freedom.
const TORQUE_SHOWN: f64 = 12.2;
/// Residuals whose correlation from block to block is so many sigmas aren't white: once in 10⁴
/// windows. With the torque's that makes at most one false alarm in a hundred windows.
const CORRELATED_SIGMA: f64 = 4.0;
/// Residuals that hang together more than this are taken as if by this much.
const MOST_CORRELATED: f64 = 0.95;
/// A solution so many sigmas squared from where its pass was linearised isn't to be relied on as it says:
/// its variance is as much larger as the step is. Data that came during a pass make for a tenth of it.
const UNSETTLED: f64 = 100.0;
/// At most so many times where sigma is measured from residuals that aren't noise alone: their model is
/// never settled.
const MOST_UNSETTLED: f64 = 16.0;
/// With fewer residuals nothing is said of them.
const ENOUGH_RESIDUALS: u32 = 30;
/// A torque or bias counts as seen once its sigma is below this share of the range that it is held in.
const SEEN: f64 = 0.5;

/// A front that waits for the rework lies behind the newest block. A report carries it on over so many at
/// most, each of some 6,000 instructions.
const MOST_CARRIED: usize = 64;
/// Slices of a block at most, a look at the first one among them: looked at and gone on to, crossed in three
/// steps of two slices, three rows.
const SLICES_OF_A_BLOCK: usize = 11;

/// What windows that ended left.
#[derive(Clone, Copy, Debug)]
pub struct Ended<T> {
    /// Sum of squared residuals that no solution explained, rad²/s², and their degrees of freedom.
    squares: T,
    degrees: u32,
    residuals_white: Option<bool>,
}

crate::persist!(
    [T: Real] Ended<T> { squares, degrees, residuals_white } if |this| this.squares >= T::zero()
);

impl<T: Real> Ended<T> {
    /// None has.
    pub fn nothing() -> Self {
        Self { squares: T::zero(), degrees: 0, residuals_white: None }
    }

    /// Degrees of freedom.
    pub fn degrees(&self) -> u32 {
        self.degrees
    }

    /// One more has, and its successor goes on from where it stopped.
    pub fn add(&mut self, residuals: &Residuals<T>) {
        self.squares += residuals.squares;
        self.degrees = self.degrees.saturating_add(residuals.degrees());
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// The estimate.
    ///
    /// Found stage by stage: each has a frame of its own, which is gone when the next one begins, so that
    /// between them the stack holds the estimate alone.
    pub(super) fn report(&self) -> Estimate<T> {
        let mut estimate = Estimate::of_nothing();
        self.report_into(&mut estimate);
        estimate
    }

    #[inline(never)]
    fn report_into(&self, estimate: &mut Estimate<T>) {
        if !self.report_front(estimate) && !self.report_past(estimate) {
            self.report_nothing(estimate);
        }
    }

    /// What the front says; false where there is none.
    fn report_front(&self, estimate: &mut Estimate<T>) -> bool {
        let Some(is_explained) = self.solve_front(estimate) else { return false };
        if !self.judge_worth(estimate) {
            return false;
        }
        // An inertia that isn't seen is free to imitate a torque.
        if estimate.observed.directions < 6 {
            estimate.disturbance_torque_n_m = None;
        }
        if !is_explained {
            estimate.status = Status::Diverged;
        }
        true
    }

    /// Between windows; false where nothing was found before.
    fn report_past(&self, estimate: &mut Estimate<T>) -> bool {
        self.solve_past(estimate).is_some() && self.judge_worth(estimate)
    }

    /// What is held while nothing has been found.
    fn report_nothing(&self, estimate: &mut Estimate<T>) {
        let prior = self.config.prior.unwrap_or(Prior::unknown());
        *estimate = Estimate::of_nothing();
        estimate.inertia = Inertia::new(prior.inertia_kg_m2);
        for i in 0..6 {
            estimate.covariance_kg2_m4[(i, i)] = prior.sigma_kg_m2[i] * prior.sigma_kg_m2[i];
        }
        estimate.judge(&prior.sigma_kg_m2);
    }

    /// Solves the front: inertia, covariance and residuals as the data by itself have them, torque and
    /// bias where they are known. Says whether the model explains the data.
    #[inline(never)]
    fn solve_front(&self, estimate: &mut Estimate<T>) -> Option<bool> {
        let mut front = *self.passes.front()?;
        self.carry_on(&mut front);
        self.solve_carried(&mut front, estimate)
    }

    /// The same of a copy that has come to the newest sample; its factor is the room in which it is solved.
    #[inline(never)]
    fn solve_carried(&self, front: &mut Pass<T, U>, estimate: &mut Estimate<T>) -> Option<bool> {
        let (point, residuals) = (*front.point(), *front.residuals());
        let room = front.room();
        let noise = self.scale_rad_s(&residuals);
        let held = self.held(noise);
        let mut solving = Solving::new();
        solving.take_all_but_the_sphere(room, &point, &held);
        let solution = finish(room, &point, &held, &mut estimate.covariance_kg2_m4)?;
        let unit = noise * self.typical_kg_m2;
        let unsettled = self.unsettled(solution.inertia_step_square / (noise * noise));
        let inflation = self.inflation(&residuals);
        for element in estimate.covariance_kg2_m4.iter_mut() {
            *element = *element * (unit * unit) * inflation * unsettled;
        }
        estimate.inertia = Inertia::new(solution.point.inertia.map(|x| x * self.typical_kg_m2));
        let (squares, degrees) = self.squares(&residuals);
        estimate.residual_rms_rad_s = (squares / T::count(degrees.max(1))).sqrt();
        estimate.residuals_white = self.is_white(&residuals, &solving);
        estimate.disturbance_torque_n_m = self.torque_of(&solution, noise);
        estimate.gyro_bias_rad_s = self.bias_of(&solution, noise);
        // A torque that is held at zero against the data counts as unexplained.
        let unexplained = (squares + solving.torque_square(), degrees.saturating_add(3));
        Some(self.config.gyro_noise_rad_s.is_none_or(|n| explains(unexplained, n)))
    }

    /// Carries a copy of the front on over what it hasn't come to yet: those that it waits with, the
    /// newest blocks, and the one that is still being filled.
    #[inline(never)]
    fn carry_on(&self, front: &mut Pass<T, U>) {
        let (per, most) = (T::one() / self.typical_kg_m2, self.most_rad_s());
        let enough = front.next().saturating_add(MOST_CARRIED);
        // One block more than that: the front may stand inside one.
        for _ in 0..(MOST_CARRIED + 1) * SLICES_OF_A_BLOCK {
            let is_due = front.is_busy() || front.next() < enough;
            if self.blocks.is_rebuilt() || !is_due || front.stage(&self.blocks).is_none() {
                break;
            }
            front.work(&self.blocks, per, most);
        }
        let has_looked_at_all = front.has_looked_at_all(&self.blocks);
        let (mut last, is_next_to_it) = match (&self.work, &self.closing) {
            (Work::Ending(ending), _) => (ending.last, true),
            (_, Some(closing)) => (closing.last.filter(|_| has_looked_at_all), has_looked_at_all),
            _ => (self.filling_after(front), has_looked_at_all),
        };
        while (is_next_to_it || front.is_busy())
            && front.work_to_the_end(&mut last, per, most).is_some()
        {}
    }

    /// Solves the past by itself.
    #[inline(never)]
    fn solve_past(&self, estimate: &mut Estimate<T>) -> Option<()> {
        let mut past = self.past?;
        past.walk(self.walk_kg_m2());
        // Before any window it has no other size than its own.
        let typical = Inertia::new(past.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0);
        *estimate = Estimate::of_nothing();
        let inertia = solve_past(&past, typical, &mut estimate.covariance_kg2_m4)?;
        estimate.covariance_kg2_m4 *= typical * typical;
        estimate.inertia = Inertia::new(inertia.map(|x| x * typical));
        estimate.residual_rms_rad_s =
            (self.ended.squares / T::count(self.ended.degrees.max(1))).sqrt();
        estimate.residuals_white = self.ended.residuals_white;
        Some(())
    }

    /// What an inertia is worth, brought to the nearest physical one; false where it isn't finite.
    fn judge_worth(&self, estimate: &mut Estimate<T>) -> bool {
        let (inertia, covariance) = (estimate.inertia, &mut estimate.covariance_kg2_m4);
        // Neither an element nor a variance can be told more finely than it is rounded.
        for i in 0..6 {
            let rounded = inertia.elements_kg_m2()[i] * T::EPSILON;
            covariance[(i, i)] *= T::one() + T::EPSILON * T::lit(16.0);
            covariance[(i, i)] += rounded * rounded;
        }
        let is_finite = inertia.elements_kg_m2().iter().all(|x| x.is_finite())
            && covariance.iter().all(|x| x.is_finite());
        if !is_finite {
            return false;
        }
        if let Some(nearest) = nearest_physical(&inertia, covariance) {
            estimate.inertia = nearest;
            estimate.projected = true;
        }
        let mean_moment = estimate.inertia.trace_kg_m2().abs() * T::lit(1.0 / 3.0);
        let range = self.config.prior.unwrap_or(Prior::of_size(mean_moment)).sigma_kg_m2;
        estimate.judge(&range);
        true
    }

    fn torque_of(&self, solution: &Solution<T>, noise_rad_s: T) -> Option<Vec3<T>> {
        let range = self.config.disturbance_torque_n_m.filter(|_| has_torque(U))?;
        let most = range / self.typical_kg_m2 / noise_rad_s * T::lit(SEEN);
        is_seen(&solution.torque_variances, most)
            .then(|| solution.point.torque * self.typical_kg_m2)
    }

    fn bias_of(&self, solution: &Solution<T>, noise_rad_s: T) -> Option<Vec3<T>> {
        let range = self.config.gyro_bias_rad_s.filter(|_| has_bias(U))?;
        let most = range / noise_rad_s * T::lit(SEEN);
        is_seen(&solution.bias_variances, most).then_some(solution.point.bias)
    }

    /// Residuals of a front with those of the windows that it goes on from.
    fn squares(&self, front: &Residuals<T>) -> (T, u32) {
        let mut all = self.ended;
        all.add(front);
        (all.squares, all.degrees)
    }

    /// One sigma of a gyro sample by which a front's covariance is scaled, rad/s: as given, or as the
    /// residuals have it.
    pub(super) fn scale_rad_s(&self, front: &Residuals<T>) -> T {
        match (self.config.gyro_noise_rad_s, self.squares(front)) {
            (Some(noise), _) => noise,
            (None, (_, 0)) => self.noise_rad_s(),
            (None, (squares, degrees)) => (squares / T::count(degrees)).sqrt(),
        }
    }

    /// What correlation from block to block makes of a variance that is taken from residuals:
    /// `(1 + ρ) / (1 − ρ)`, for one that fades by ρ a block. Of a gyro whose noise is given nothing is
    /// taken from the residuals: 1.
    pub(super) fn inflation(&self, residuals: &Residuals<T>) -> T {
        if self.config.gyro_noise_rad_s.is_some() || residuals.squares <= T::zero() {
            return T::one();
        }
        let correlation =
            (residuals.products / residuals.squares).max(T::zero()).min(T::lit(MOST_CORRELATED));
        (T::one() + correlation) / (T::one() - correlation)
    }

    /// How much larger than it says the variance of a solution is that is so many sigmas squared from
    /// where it was linearised.
    fn unsettled(&self, step_square: T) -> T {
        let times = (step_square / T::lit(UNSETTLED)).max(T::one());
        match self.config.gyro_noise_rad_s {
            Some(_) => times,
            None => times.min(T::lit(MOST_UNSETTLED)),
        }
    }

    /// Whether gyro noise explains what a front leaves.
    pub(super) fn explains(&self, front: &Residuals<T>) -> bool {
        let squares = self.squares(front);
        match self.config.gyro_noise_rad_s {
            Some(noise) => explains(squares, noise),
            None => squares.0.is_finite(),
        }
    }

    /// Whether a front's residuals are white, as far as a constant torque and their correlation from
    /// block to block tell.
    fn is_white(&self, residuals: &Residuals<T>, solving: &Solving<T>) -> Option<bool> {
        if residuals.degrees() < ENOUGH_RESIDUALS {
            return None;
        }
        let noise = self.scale_rad_s(residuals);
        let shows_torque = solving.torque_square() > noise * noise * T::lit(TORQUE_SHOWN);
        // Of n products of white residuals the sum has √n times their mean square.
        let sigma = residuals.mean_square() * T::count(residuals.rows).sqrt();
        let is_correlated = residuals.products.abs() > sigma * T::lit(CORRELATED_SIGMA);
        Some(!shows_torque && !is_correlated)
    }

    /// What is left of a window that ends with this front.
    pub(super) fn ended_with(&self, front: &Residuals<T>, solving: &Solving<T>) -> Ended<T> {
        let (squares, degrees) = self.squares(front);
        Ended { squares, degrees, residuals_white: self.is_white(front, solving) }
    }
}

/// Whether each of three variances, for unit noise, is below the square of `most`.
fn is_seen<T: Real>(variances: &[T; 3], most: T) -> bool {
    variances.iter().all(|v| *v < most * most)
}

/// Whether gyro noise explains a sum of squares, rad²/s², of so many degrees of freedom.
fn explains<T: Real>((sum, degrees): (T, u32), noise_rad_s: T) -> bool {
    let variance = noise_rad_s * noise_rad_s;
    let (k, x) = (T::count(degrees), T::lit(REJECTED));
    let two = T::lit(2.0);
    sum <= variance * (k + two * (k * x).sqrt() + two * x)
}
