//! The window's work, slice by slice: the front keeps up with the data, the rework overtakes it, and
//! storage is merged or handed on when it is full.

use super::pass::{Pass, Taken};
use super::solution::{Solving, inertia_covariance, size_square};
use super::unknowns::Point;
use super::{BLOCKS_TO_SEE, Rework, Window, contradicts, storage};
use crate::Reset;
use crate::estimator::Prior;
use crate::estimator::window::block::Reading;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::tensor::Inertia;

/// No pass before so many blocks: fewer equations than a few per unknown say little.
const BLOCKS_TO_START: usize = 16;
/// Motion that nothing drives shows no size, and need not be waited for longer than this.
const BLOCKS_TO_TUMBLE: usize = 24;
/// With a past to start from, so many will do.
const BLOCKS_TO_RESUME: usize = 2;
/// A front whose squared residuals exceed what the noise makes of them by this factor hasn't
/// found the solution yet: it is tried again, from its own point, and ever more
/// rarely from the linear start.
const UNEXPLAINED: f64 = 1.5;
/// A solution within so many sigmas of its pass's own point isn't worth another.
const SETTLED_SIGMA: f64 = 0.01;
/// Within so many, what linearising left out doesn't show in a chi-square test.
const NEAR_SIGMA: f64 = 1.0;
/// Drag that noise alone imitates once in 10⁵ windows: chi-square of three degrees of freedom.
const DRAG_SHOWN: f64 = 26.0;
/// A pass that has yet to step so many sigmas squared may err by as many times that in a sum of squares.
const UNSURE: f64 = 4.0;
/// Slices until a settled front is looked at again: two hundred rows more.
const REST: u32 = 256;
/// An element of more typical inertias than this is a pass that went astray.
const ASTRAY: f64 = 10.0;
/// And so is a body this much thinner than its size: four times its determinant over the cube of its
/// trace is about the share of the smallest moment in the trace, and a rod of one to a hundred has
/// 2e-4.
const THIN: f64 = 1.0e-4;
/// A point may break the triangle inequality by this share of the trace.
const UNPHYSICAL: f64 = 0.05;
/// A linear start larger or smaller than the typical inertia by this factor is another body.
const OTHER_SIZE: f64 = 3.0;
/// A step that leads astray is halved so often before it is given up.
const HALVINGS: u32 = 5;
/// A window ends where a change of the momentum at its start has grown by this factor: motion about
/// an unstable axis. Ours: single precision then still resolves 1e-5 of a rate.
const MOST_GROWTH: f64 = 30.0;
/// One sigma of every element, in units of the mean moment, below which linearising anew changes
/// nothing any more.
const KNOWN: f64 = 0.01;
/// Rows beyond the unknowns that a front has seen before it tells spikes: three times as many as the
/// most unknowns.
const ARMED_DEGREES: u32 = 45;
/// A row that would leave so many sigmas isn't the gyro's noise, once in 5·10⁸ rows.
const SPIKE_SIGMA: f64 = 6.0;
/// Where sigma is measured from residuals, which vibration and other things that come and go make
/// uneven, it takes more.
const SPIKE_SIGMA_UNSURE: f64 = 20.0;
/// So many blocks in a row aren't spikes: the body has changed.
const MOST_SPIKES: u32 = 8;
/// A change too small for that: squares beyond twice the usual sigma add up to this. Noise alone gets
/// there about once in 10⁹ blocks (Wald's bound, e to the power of minus 0.46 times the limit).
const USUAL_SQUARE: f64 = 4.0;
const CHANGED_SUM: f64 = 50.0;

/// What a solution says of its front.
enum Finding {
    /// The data contradict what was known before.
    PastContradicted,
    /// The torque changes with the motion.
    Drag,
    /// Another pass would change nothing. Whether spikes can be told by now.
    Settled { can_tell_spikes: bool },
    /// Another pass is needed.
    Unsettled { can_tell_spikes: bool },
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// The work of one step, which came with this reading.
    pub(super) fn work(&mut self, reading: Reading<T>) {
        if self.is_quiet {
            return;
        }
        if self.blocks.is_merging() {
            if self.blocks.merge_some(self.noise_rad_s()) {
                if let Some(front) = &mut self.front {
                    front.halve();
                }
                if let Rework::Pass(rework) = &mut self.rework {
                    rework.halve();
                }
            }
            return;
        }
        for _ in 0..self.config.slices_per_step {
            if self.is_unstable() {
                self.move_on(reading);
            }
            if self.blocks.is_nearly_full() && self.make_room(reading) {
                return;
            }
            self.slice();
            if self.watch.event.is_some() {
                return;
            }
        }
    }

    /// Begins to merge blocks, or a new window where they turn too far for that. False while a
    /// pass stands where it can't.
    fn make_room(&mut self, reading: Reading<T>) -> bool {
        if !self.blocks.can_merge(self.config.block_turn_rad) {
            let is_ready =
                |front: &Pass<T, U>| !front.is_busy() && front.next() + 1 >= self.blocks.len();
            if !self.front.as_ref().is_none_or(is_ready) {
                return false;
            }
            self.move_on(reading);
            return true;
        }
        let can_halve = |pass: &Pass<T, U>| pass.next().is_multiple_of(2);
        let rework = match &self.rework {
            Rework::Pass(rework) => Some(rework),
            _ => None,
        };
        if ![self.front.as_ref(), rework].into_iter().flatten().all(can_halve) {
            return false;
        }
        self.blocks.begin_merging();
        self.block_samples = self.block_samples.saturating_mul(2);
        true
    }

    /// The next window begins where the front has come to, with all that it knows.
    fn move_on(&mut self, reading: Reading<T>) {
        let carried = self.up_to_date().and_then(|front| {
            let noise = self.scale_rad_s(&front);
            let solution = Solving::new(&front).finish(&self.held(noise))?;
            let carried = front.carry(&solution.step)?;
            Some((carried, Pass::new(carried.point, Some(&carried))?, front))
        });
        let Some((carried, front, before)) = carried.filter(|(.., front)| self.explains(front))
        else {
            // Nothing found in as much motion as there is storage for.
            return self.open_at(reading);
        };
        self.ended.add(before.residuals());
        self.carried = Some(carried);
        self.front = Some(front);
        self.rework = Rework::Idle;
        self.resting = 0;
        self.blocks.keep_newest(self.block_samples);
    }

    /// Whether the motion since the window opened magnifies a change of its start so far that
    /// rounding would be magnified to the size of the noise; the front is up to date; and it knows
    /// the inertia so well that its blocks needn't be gone over again.
    fn is_unstable(&self) -> bool {
        let Some(front) = &self.front else { return false };
        let noise = self.noise_rad_s();
        let is_known = |covariance: Mat<T, 6, 6>| {
            (0..6).all(|i| covariance[(i, i)] * noise * noise < T::lit(KNOWN * KNOWN))
        };
        front.growth_square() > T::lit(MOST_GROWTH * MOST_GROWTH)
            && !front.is_busy()
            && front.next() + 1 >= self.blocks.len()
            && inertia_covariance(front.information()).is_some_and(is_known)
    }

    /// One slice of work: a row, or a block, of the front if it isn't up to date, else of the
    /// rework. Each block waits for its successor, which tells of its inside.
    fn slice(&mut self) {
        let per = T::one() / self.typical_kg_m2;
        if self.front.as_ref().is_some_and(Pass::is_busy) {
            return self.take_front_row();
        }
        if let Some(front) = &mut self.front
            && front.next() + 1 < self.blocks.len()
            && let Some(span) = self.blocks.span(front.next(), per)
        {
            return front.advance(&span);
        }
        match &mut self.rework {
            Rework::Idle if self.resting > 0 => self.resting -= 1,
            Rework::Idle => self.begin(),
            Rework::Solving(solving) => {
                let mut next = *solving;
                let is_done = next.take_row(&self.held_for_front());
                self.rework = Rework::Solving(next);
                if is_done {
                    self.conclude(&next);
                }
            }
            Rework::Pass(rework) if rework.is_busy() => {
                rework.take_row(self.carried.as_ref(), T::MAX);
            }
            Rework::Pass(rework) => match self.blocks.span(rework.next(), per) {
                Some(span) if rework.next() + 1 < self.blocks.len() => rework.advance(&span),
                _ => self.compare(),
            },
        }
    }

    fn held_for_front(&self) -> super::Held<T> {
        let noise = self.front.as_ref().map_or(self.noise_rad_s(), |f| self.scale_rad_s(f));
        self.held(noise)
    }

    /// Takes in a row of the front, unless it is a spike.
    fn take_front_row(&mut self) {
        let Some(front) = &self.front else { return };
        let usual = self.usual_rad_s(front);
        let most = self.most_rad_s(front);
        let is_sure = self.config.gyro_noise_rad_s.is_some();
        let Some(front) = &mut self.front else { return };
        let taken = front.take_row(self.carried.as_ref(), most);
        if matches!(taken, Taken::In(_)) && !front.is_busy() {
            self.watch.refused = 0;
        }
        match taken {
            Taken::Silent => {}
            Taken::Refused => {
                let block = front.next().saturating_sub(1);
                self.blocks.distrust(block);
                self.watch.has_refused = true;
                self.watch.refused += 1;
                if self.watch.refused >= MOST_SPIKES {
                    self.watch.event = Some(Reset::Lockout);
                }
            }
            Taken::In(left) if self.watch.is_armed && is_sure => {
                let square = left * left / (usual * usual);
                self.watch.sum = (self.watch.sum + square - T::lit(USUAL_SQUARE)).max(T::zero());
                if self.watch.sum > T::lit(CHANGED_SUM) {
                    self.watch.event = Some(Reset::Lockout);
                }
            }
            Taken::In(_) => {}
        }
    }

    /// One sigma of what a row of the front usually leaves, rad/s.
    fn usual_rad_s(&self, front: &Pass<T, U>) -> T {
        self.scale_rad_s(front).max(self.noise_rad_s())
    }

    /// What a row of the front may leave at most, rad/s: more is a spike.
    fn most_rad_s(&self, front: &Pass<T, U>) -> T {
        if !self.watch.is_armed {
            return T::MAX;
        }
        let is_sure = self.config.gyro_noise_rad_s.is_some();
        let sigmas = if is_sure { SPIKE_SIGMA } else { SPIKE_SIGMA_UNSURE };
        self.usual_rad_s(front) * T::lit(sigmas)
    }

    /// Begins to solve the front, or looks for a first point.
    fn begin(&mut self) {
        self.rework = match &self.front {
            Some(front) => Rework::Solving(Solving::new(front)),
            None => match self.first_point() {
                Some(point) => self.pass_from(point),
                None => Rework::Idle,
            },
        };
    }

    fn pass_from(&self, point: Point<T>) -> Rework<T, U> {
        Pass::new(point, self.carried.as_ref()).map_or(Rework::Idle, Rework::Pass)
    }

    /// The front is solved: what follows from that.
    fn conclude(&mut self, solving: &Solving<T, U>) {
        self.rework = Rework::Idle;
        let Some(front) = &self.front else { return };
        match self.judge(front, solving) {
            Finding::PastContradicted => {
                self.past = None;
                self.watch.event = Some(Reset::Changed);
            }
            Finding::Drag => self.has_drag = true,
            Finding::Settled { can_tell_spikes } => {
                self.watch.is_armed |= can_tell_spikes;
                self.resting = REST;
            }
            Finding::Unsettled { can_tell_spikes } => {
                self.watch.is_armed |= can_tell_spikes;
                self.begin_next(solving);
            }
        }
    }

    /// What a solution says of its front. A sum of squares is known as surely as the step is small.
    fn judge(&self, front: &Pass<T, U>, solving: &Solving<T, U>) -> Finding {
        let noise = self.scale_rad_s(front);
        let within = |square: T, sigma: f64| square < noise * noise * T::lit(sigma * sigma);
        let step = solving.step_square().min(size_square(front.information()));
        let surely = |square: T| square - step * T::lit(UNSURE);
        if !self.has_found(front) {
            return Finding::Unsettled { can_tell_spikes: false };
        }
        if self.past.is_some() && contradicts(surely(solving.past_square()), noise) {
            return Finding::PastContradicted;
        }
        if self.shows_drag(front, solving.drag_square(), surely(solving.drag_square())) {
            return Finding::Drag;
        }
        let degrees = front.residuals().degrees();
        let can_tell_spikes = within(step, NEAR_SIGMA) && degrees >= ARMED_DEGREES;
        if within(solving.step_square(), SETTLED_SIGMA) {
            Finding::Settled { can_tell_spikes }
        } else {
            Finding::Unsettled { can_tell_spikes }
        }
    }

    /// Whether a torque that is looked for changes with the motion, by the sum of squares that drag of
    /// zero leaves, and what of that is sure. Where the noise is measured from residuals there is more
    /// than noise in them: a pass never settles, and their correlation counts instead.
    fn shows_drag(&self, front: &Pass<T, U>, square: T, surely: T) -> bool {
        let noise = self.scale_rad_s(front);
        let shown = noise * noise * self.inflation(front) * T::lit(DRAG_SHOWN);
        let is_given = self.config.gyro_noise_rad_s.is_some();
        let is_asked_for = self.config.disturbance_torque_n_m.is_some();
        is_asked_for && !self.has_drag && (if is_given { surely } else { square }) > shown
    }

    /// Begins the next pass: from the front's solution, or where it hasn't explained the data for long
    /// from the linear start.
    fn begin_next(&mut self, solving: &Solving<T, U>) {
        let Some(front) = &self.front else { return };
        let found = plausible_point(front, solving);
        let is_found = self.is_at_noise(front);
        // What goes astray once it was at the noise is tried afresh soon.
        self.attempts = if is_found { 0 } else { self.attempts.wrapping_add(1) };
        let is_guided = is_found || self.carried.is_some() || !self.attempts.is_power_of_two();
        let point = match found {
            Some(point) if is_guided => Some(point),
            found => self.linear_point().or(found),
        };
        if let Some(point) = point {
            self.rework = self.pass_from(point);
        }
    }

    /// The rework has caught up: it takes the front's place where it fits better.
    fn compare(&mut self) {
        let Rework::Pass(rework) = core::mem::replace(&mut self.rework, Rework::Idle) else {
            return;
        };
        let ours = rework.residuals().mean_square();
        let is_better = match &self.front {
            _ if self.has_found(&rework) => true,
            None => true,
            Some(front) => {
                let theirs = front.residuals().mean_square();
                ours <= theirs || (ours.is_finite() && !theirs.is_finite())
            }
        };
        if is_better {
            self.front = Some(rework);
        }
    }

    /// Whether a pass leaves no more than the noise does, as given or as measured.
    fn is_at_noise(&self, pass: &Pass<T, U>) -> bool {
        let noise = self.noise_rad_s();
        pass.residuals().mean_square() < noise * noise * T::lit(UNEXPLAINED)
    }

    /// Whether a pass is at the noise; or where that isn't given, and so may be more than third
    /// differences show, leaves no more than the front.
    fn has_found(&self, pass: &Pass<T, U>) -> bool {
        let ours = pass.residuals().mean_square();
        let front = self.front.as_ref().map_or(T::zero(), |f| f.residuals().mean_square());
        let is_given = self.config.gyro_noise_rad_s.is_some();
        self.is_at_noise(pass) || (!is_given && ours.is_finite() && ours <= front)
    }

    /// Where a first pass starts: from the past, from linear least squares once there is enough
    /// motion, and where that doesn't come, from a sphere.
    fn first_point(&mut self) -> Option<Point<T>> {
        if self.blocks.len() >= BLOCKS_TO_RESUME
            && let Some(past) = &self.past
            && let Some((inertia, covariance)) = past.solve()
        {
            let mean_moment = (inertia[0] + inertia[1] + inertia[2]) * T::lit(1.0 / 3.0);
            let sharp = mean_moment * T::lit(super::solution::VAGUE);
            let is_sharp = (0..6).all(|i| covariance[(i, i)] < sharp * sharp);
            if is_sharp && Inertia::new(inertia).is_positive_definite() {
                self.typical_kg_m2 = mean_moment;
                return self.at_rest_from(inertia.map(|x| x / mean_moment));
            }
        }
        if self.blocks.len() < BLOCKS_TO_START {
            return None;
        }
        if let Some(point) = self.linear_point() {
            return Some(point);
        }
        if self.blocks.len() < BLOCKS_TO_TUMBLE {
            return None;
        }
        let noise = self.noise_rad_s();
        let linear = self.open?.linear;
        let size = linear.size_kg_m2(noise);
        let prior = self.config.prior.filter(|_| self.past.is_some());
        let unit =
            |prior: &Prior<T>| Inertia::new(prior.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0);
        // In units of its own mean moment any inertia is a homogeneous one.
        if size.is_none()
            && let Some(start) = linear.solve_homogeneous(noise)
            && start.inertia.is_positive_definite()
        {
            self.typical_kg_m2 = prior.as_ref().map_or(T::one(), unit);
            return Some(Point::new(start.momentum_n_m_s, start.inertia.elements_kg_m2()));
        }
        if self.blocks.len() < BLOCKS_TO_SEE {
            return None;
        }
        let prior = prior.or(size.map(Prior::of_size))?;
        self.typical_kg_m2 = unit(&prior);
        self.at_rest_from(prior.inertia_kg_m2.map(|x| x / self.typical_kg_m2))
    }

    /// The point of linear least squares; its size is the unit where nothing has one yet.
    fn linear_point(&mut self) -> Option<Point<T>> {
        let start = self.open?.linear.solve(self.noise_rad_s(), &self.holds())?;
        if self.carried.is_some() || !start.inertia.is_positive_definite() {
            return None;
        }
        let size = start.inertia.trace_kg_m2() * T::lit(1.0 / 3.0);
        let is_near = size < self.typical_kg_m2 * T::lit(OTHER_SIZE)
            && size * T::lit(OTHER_SIZE) > self.typical_kg_m2;
        if self.front.is_none() || !is_near {
            // A front in other units can't be compared; and it explains nothing.
            self.front = None;
            self.typical_kg_m2 = size;
        }
        let per = T::one() / self.typical_kg_m2;
        Some(Point {
            momentum: start.momentum_n_m_s * per,
            torque: start.torque_n_m * per,
            bias: start.bias_rad_s,
            drag: Vec3::zeros(),
            inertia: start.inertia.elements_kg_m2().map(|x| x * per),
        })
    }

    /// A point of this inertia, in typical ones, with the momentum that the first block shows.
    fn at_rest_from(&self, inertia: [T; 6]) -> Option<Point<T>> {
        let first = self.blocks.span(0, T::one() / self.typical_kg_m2)?.block;
        let momentum = Inertia::new(inertia).matrix_kg_m2() * first.rate_rad_s + first.drive_n_m_s;
        Some(Point::new(momentum, inertia))
    }

    /// The front with all rows that wait taken in, but for spikes.
    fn up_to_date(&self) -> Option<Pass<T, U>> {
        let mut front = self.front?;
        let most = self.most_rad_s(&front);
        front.take_all_rows(self.carried.as_ref(), most);
        Some(front)
    }

    /// The front, carried on over what hasn't come to it yet: the newest block, and the one that is
    /// still being filled.
    pub(super) fn up_to_now(&self) -> Option<Pass<T, U>> {
        let mut front = self.up_to_date()?;
        let most = self.most_rad_s(&front);
        let Some([before, newest]) = self.blocks.newest() else { return Some(front) };
        if self.blocks.is_merging() || front.next() + 1 != self.blocks.len() {
            return Some(front);
        }
        let filling = self.open.and_then(|open| open.averager.block());
        let per = T::one() / self.typical_kg_m2;
        front.advance(&storage::span([None, Some(before)], &newest, [filling, None], per));
        front.take_all_rows(self.carried.as_ref(), most);
        if let Some(filling) = filling {
            front.advance(&storage::span(
                [Some(before), Some(newest)],
                &filling,
                [None, None],
                per,
            ));
            front.take_all_rows(self.carried.as_ref(), most);
        }
        Some(front)
    }
}

/// The solution's point, or as far on the way to it as a body could be.
fn plausible_point<T: Real, const U: usize>(
    front: &Pass<T, U>,
    solving: &Solving<T, U>,
) -> Option<Point<T>> {
    let mut step = solving.step()?;
    for _ in 0..HALVINGS {
        let point = front.point().plus(&step);
        if is_plausible(&point) {
            return Some(point);
        }
        step = step.map(|x| x * T::lit(0.5));
    }
    None
}

/// Whether a pass from there has a chance: of a body or nearly so, not far too thin, and no larger than
/// the unit allows.
fn is_plausible<T: Real>(point: &Point<T>) -> bool {
    let inertia = Inertia::new(point.inertia);
    let trace = inertia.trace_kg_m2();
    let [_, _, determinant] = inertia.leading_minors();
    // ½ tr(J) 1 − J is that of a body; a little more than half leaves room for noise.
    let [xx, yy, zz, xy, xz, yz] = point.inertia;
    let most = trace * T::lit(0.5 + UNPHYSICAL);
    let shape = Inertia::new([most - xx, most - yy, most - zz, -xy, -xz, -yz]);
    inertia.is_positive_definite()
        && shape.is_positive_definite()
        && determinant > T::lit(THIN) * trace * trace * trace
        && point.inertia.iter().all(|x| x.abs() < T::lit(ASTRAY))
}
