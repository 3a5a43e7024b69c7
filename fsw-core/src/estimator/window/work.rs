//! The window's work, slice by slice: the front keeps up with the data, the rework overtakes it, storage
//! is rebuilt or handed on when it is full, and a window that ends is concluded.
//!
//! A step does slices as long as their cost is left of its budget. What a slice costs is known before
//! it begins, so that no step costs more than another by more than what is left over.

use super::block::Block;
use super::cost::{self, Cost};
use super::linear_start::{self, Found, Kind, LinearStart};
use super::pass::{Pass, Taken};
use super::solution::{Solving, inertia_variances, known};
use super::storage::Rebuilt;
use super::unknowns::{Known, Point};
use super::{Beginning, Window};
use crate::Reset;
use crate::math::scalar::Real;

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
/// A window ends where a change of the momentum at its start has grown by this factor: motion about
/// an unstable axis. Ours: single precision then still resolves 1e-5 of a rate.
const MOST_GROWTH: f64 = 30.0;
/// One sigma of every element, in units of the mean moment, below which linearising anew changes
/// nothing any more.
const KNOWN: f64 = 0.01;

/// The two passes: the front, which is valid at any time once there is one, and another, which is under
/// way or lends its factor as room for a solution.
#[derive(Clone, Debug)]
pub struct Passes<T: Real, const U: usize> {
    slots: [Pass<T, U>; 2],
    has_front: bool,
    front_is_second: bool,
}

crate::persist!([T: Real, const U: usize] Passes<T, U> { slots, has_front, front_is_second });

impl<T: Real, const U: usize> Passes<T, U> {
    /// No front, and no pass under way.
    pub fn none() -> Self {
        Self { slots: [Pass::none(); 2], has_front: false, front_is_second: false }
    }

    /// The front.
    pub fn front(&self) -> Option<&Pass<T, U>> {
        let [first, second] = &self.slots;
        self.has_front.then_some(if self.front_is_second { second } else { first })
    }

    /// The other one.
    pub fn other(&self) -> &Pass<T, U> {
        let [first, second] = &self.slots;
        if self.front_is_second { first } else { second }
    }

    /// Both.
    pub fn both(&mut self) -> (Option<&mut Pass<T, U>>, &mut Pass<T, U>) {
        let [first, second] = &mut self.slots;
        let (front, other) = if self.front_is_second { (second, first) } else { (first, second) };
        (self.has_front.then_some(front), other)
    }

    /// The other one takes the front's place.
    pub fn swap(&mut self) {
        self.front_is_second = !self.front_is_second;
        self.has_front = true;
    }

    /// Whether neither is beyond so many blocks.
    pub fn are_within(&self, blocks: usize) -> bool {
        self.slots.iter().all(|pass| pass.next() <= blocks)
    }

    /// There is no front any more.
    pub fn drop_front(&mut self) {
        self.has_front = false;
    }
}

/// What is being done beside the front.
#[derive(Clone, Copy, Debug)]
pub enum Work<T: Real, const U: usize> {
    /// Nothing.
    Idle,
    /// The front is being solved, to linearise anew or to move on.
    Solving(Solving<T>, Purpose),
    /// It is solved: what follows from that is to be found.
    Solved(Solving<T>),
    /// Another pass is to start from the solution.
    Choosing,
    /// The linear start is being solved.
    Starting(Starting<T>),
    /// A pass is to begin here.
    Beginning(Point<T>),
    /// It is under way.
    Passing,
    /// The next window is to begin where the front has come to, a step from its point: so many of the
    /// equations that change are done.
    Carrying([T; U], usize),
    /// The window has ended.
    Ending(Ending<T>),
}

crate::persist!([T: Real, const U: usize] enum Work<T, U> {
    0 => Idle,
    1 => Solving(solving: Solving<T>, purpose: Purpose),
    2 => Solved(solving: Solving<T>),
    3 => Choosing,
    4 => Starting(starting: Starting<T>),
    5 => Beginning(point: Point<T>),
    6 => Passing,
    7 => Carrying(step: [T; U], done: usize),
    8 => Ending(ending: Ending<T>),
} if |this| !matches!(this, Self::Carrying(_, done) if *done > U));

/// What a front is solved for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To linearise anew.
    Rework,
    /// To begin the next window where it has come to.
    MoveOn,
}

crate::persist!([] enum Purpose { 0 => Rework, 1 => MoveOn });

/// A linear start that is being solved, and the point to start from if it finds none.
#[derive(Clone, Copy, Debug)]
pub struct Starting<T: Real> {
    pub kind: Kind,
    pub solving: linear_start::Solving<T>,
    pub otherwise: Option<Point<T>>,
}

crate::persist!([T: Real] Starting<T> { kind, solving, otherwise });

/// A window that has ended.
#[derive(Clone, Copy, Debug)]
pub struct Ending<T: Real> {
    /// The block that was being filled.
    pub last: Option<Block<T>>,
    /// Once the front has come to its end.
    solving: Option<Solving<T>>,
    /// Whether the past takes part.
    with_past: bool,
    /// How old the past is that it leaves, s.
    age_s: T,
    /// Whether another window has begun.
    pub is_succeeded: bool,
}

crate::persist!([T: Real] Ending<T> { last, solving, with_past, age_s, is_succeeded });

/// A kind of slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slice {
    Rebuild,
    End,
    Front,
    CheckStability,
    Close,
    Lose,
    MoveOn,
    Merge,
    Work,
}

/// Whether blocks can be merged two by two without parting what a pass has crossed from what it hasn't.
fn stands_between_pairs<T: Real, const U: usize>(pass: &Pass<T, U>) -> bool {
    !pass.is_busy() && pass.next().is_multiple_of(2)
}

/// Whether a change of the momentum at the window's start has grown too far.
fn is_growing<T: Real, const U: usize>(front: &Pass<T, U>) -> bool {
    front.growth_square() > T::lit(MOST_GROWTH * MOST_GROWTH)
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// The work of one step, which has cost so much already.
    pub(super) fn work(&mut self, spent: Cost) {
        let budget = self.config.instructions_per_step.unwrap_or(cost::usual::<U>());
        let mut left = budget.saturating_sub(spent);
        // However little is allowed, it must go on: what fits into no step is done in any.
        let most = budget.saturating_sub(cost::step::<U>() + cost::BLOCK);
        let mut is_first = true;
        let mut next = self.next_slice();
        while let Some((slice, cost)) = next {
            if cost > left && !(is_first && cost > most) {
                return;
            }
            is_first = false;
            left = left.saturating_sub(cost);
            self.do_slice(slice);
            if self.watch.event.is_some() {
                return;
            }
            next = self.rest_of_the_block(slice).or_else(|| self.next_slice());
        }
    }

    /// Inside a block a pass goes on with it: nothing else can have become due within the same step.
    fn rest_of_the_block(&self, slice: Slice) -> Option<(Slice, Cost)> {
        let (pass, is_armed) = match (slice, &self.work) {
            (Slice::Front, _) => (self.passes.front()?, self.watch.is_armed),
            (Slice::Work, Work::Passing) => (self.passes.other(), false),
            _ => return None,
        };
        let cost = cost::of_pass::<U>(pass.current(), is_armed) + cost::NEXT;
        pass.is_busy().then_some((slice, cost))
    }

    /// The slice that comes next, and what it costs at most, with finding it.
    fn next_slice(&self) -> Option<(Slice, Cost)> {
        let (slice, cost) = self.due_slice()?;
        Some((slice, cost + cost::next::<U>()))
    }

    /// The slice that is due, and what it costs at most. A front that is to be carried on, or
    /// whose window has ended, takes in no more blocks; else it comes first.
    #[inline(never)]
    fn due_slice(&self) -> Option<(Slice, Cost)> {
        if self.blocks.is_rebuilt() {
            return Some((Slice::Rebuild, cost::REBUILD));
        }
        match &self.work {
            Work::Ending(ending) => return Some((Slice::End, self.cost_of_end(ending))),
            _ if self.averager.is_none() || (self.is_quiet && self.closing.is_none()) => {
                return None;
            }
            Work::Solving(_, Purpose::MoveOn) | Work::Carrying(..) => {
                return Some((Slice::Work, self.cost_of_work()?));
            }
            _ => {}
        }
        let has_room = !self.blocks.is_nearly_full();
        let can_merge = !has_room && self.blocks.can_merge(self.config.block_turn_rad);
        let has_no_room = !can_merge && self.blocks.is_full();
        // Linearised far from the solution, what is carried on would be wrong for good.
        let may_move_on = self.is_close() || has_no_room;
        if let Some(front) = self.passes.front().filter(|front| may_move_on && !front.is_busy())
            && self.closing.is_none()
        {
            if !has_room && !can_merge {
                return Some((Slice::MoveOn, cost::copy::<U>()));
            }
            if is_growing(front) && self.checked_at != front.next() {
                return Some((Slice::CheckStability, cost::stability::<U>()));
            }
        }
        if let Some(front) = self.passes.front().filter(|_| !self.front_waits()) {
            if let Some(stage) = front.stage(&self.blocks) {
                return Some((Slice::Front, cost::of_pass::<U>(stage, self.watch.is_armed)));
            }
            if let Some(closing) = &self.closing {
                let is_idle = matches!(self.work, Work::Idle);
                let is_settled = front.residuals().rows < self.rests_until;
                if is_idle && (is_settled || closing.passes == 0) {
                    return Some((Slice::Close, cost::LITTLE));
                }
                return Some((Slice::Work, self.cost_of_work()?));
            }
        }
        if can_merge && self.can_halve() {
            return Some((Slice::Merge, cost::LITTLE));
        }
        if has_no_room && self.passes.front().is_none() {
            return Some((Slice::Lose, cost::LITTLE));
        }
        Some((Slice::Work, self.cost_of_work()?))
    }

    /// Whether the front takes in no more for now: until its solution is near its point, what it would say
    /// of more blocks is wrong, and the sooner the rework has overtaken it the better. It waits between two
    /// pairs of blocks, so that they can be merged.
    fn front_waits(&self) -> bool {
        let is_idle = matches!(self.work, Work::Idle);
        let may_wait = !is_idle && self.closing.is_none() && !self.blocks.is_full();
        may_wait
            && self.passes.front().is_some_and(stands_between_pairs)
            && !self.is_close()
            && (!self.is_near() || self.is_to_move_on())
    }

    /// Whether the front's point is near its solution: with less than half as many blocks again as when
    /// that was found.
    fn is_near(&self) -> bool {
        let near_at = self.watch.near_at;
        self.passes
            .front()
            .is_some_and(|front| front.next() < near_at.saturating_add(near_at.div_ceil(2)))
    }

    /// Whether it is so close that what is carried on from it is right for good: with hardly more blocks.
    fn is_close(&self) -> bool {
        let close_at = self.watch.close_at;
        self.passes
            .front()
            .is_some_and(|front| front.next() < close_at.saturating_add(close_at.div_ceil(16)))
    }

    /// Whether the window is to be carried on as soon as its front is close enough.
    fn is_to_move_on(&self) -> bool {
        let is_full =
            self.blocks.is_nearly_full() && !self.blocks.can_merge(self.config.block_turn_rad);
        is_full || self.passes.front().is_some_and(is_growing)
    }

    /// Whether the rework stands beyond a front that waits for it.
    fn has_overtaken(&self) -> bool {
        let (rework, front) = (self.passes.other(), self.passes.front());
        !rework.is_busy()
            && front.is_some_and(|front| rework.next() > front.next())
            && self.front_waits()
    }

    /// Whether each pass stands between two pairs of blocks.
    fn can_halve(&self) -> bool {
        self.passes.front().is_none_or(stands_between_pairs)
            && (!matches!(self.work, Work::Passing) || stands_between_pairs(self.passes.other()))
    }

    /// What the next slice beside the front costs at most; `None` if there is nothing to do.
    fn cost_of_work(&self) -> Option<Cost> {
        Some(match &self.work {
            Work::Idle => match self.passes.front() {
                Some(front) if front.residuals().rows < self.rests_until => return None,
                Some(_) => cost::copy::<U>(),
                None if self.blocks.len() <= self.tried_with => return None,
                None => cost::first_point::<U>(),
            },
            Work::Solving(..) => cost::hold::<U>(),
            Work::Solved(_) => cost::JUDGE,
            Work::Choosing => cost::choose::<U>(),
            Work::Starting(_) => cost::start::<U>(),
            Work::Beginning(_) => cost::begin::<U>(),
            Work::Passing if self.has_overtaken() => cost::compare_and_begin::<U>(),
            Work::Passing => match self.passes.other().stage(&self.blocks) {
                Some(stage) => cost::of_pass::<U>(stage, false),
                None => cost::compare::<U>(),
            },
            Work::Carrying(_, done) => cost::carry::<U>(*done),
            Work::Ending(ending) => self.cost_of_end(ending),
        })
    }

    fn cost_of_end(&self, ending: &Ending<T>) -> Cost {
        match (&ending.solving, self.passes.front()) {
            (None, Some(front)) => cost::of_the_end::<U>(front.current(), self.watch.is_armed),
            (Some(_), _) => cost::hold_at_the_end::<U>(),
            (None, None) => cost::LITTLE,
        }
    }

    fn do_slice(&mut self, slice: Slice) {
        match slice {
            Slice::Rebuild => self.rebuild(),
            Slice::End => self.work_on_the_end(),
            Slice::Front => self.work_on_the_front(),
            Slice::CheckStability => {
                if self.knows_enough() {
                    self.begin_moving_on();
                }
            }
            Slice::Close => self.end_window(),
            Slice::Lose => self.lose(),
            Slice::MoveOn => self.begin_moving_on(),
            Slice::Merge => {
                self.blocks.begin_merging();
                self.block_samples = self.block_samples.saturating_mul(2);
            }
            Slice::Work => self.work_beside_the_front(),
        }
    }

    fn rebuild(&mut self) {
        let noise = self.noise_rad_s();
        if self.blocks.rebuild_one(noise) != Rebuilt::Merged {
            return;
        }
        let (front, other) = self.passes.both();
        if let Some(front) = front {
            front.halve();
        }
        other.halve();
        self.watch.near_at /= 2;
        self.watch.close_at /= 2;
    }

    fn per_kg_m2(&self) -> T {
        T::one() / self.typical_kg_m2
    }

    fn work_on_the_front(&mut self) {
        let (per, most) = (self.per_kg_m2(), self.most_rad_s());
        let (Some(front), _) = self.passes.both() else { return };
        let taken = front.work(&self.blocks, per, most);
        let (is_whole, block) = (!front.is_busy(), front.next().saturating_sub(1));
        let is_near = self.is_near();
        match taken {
            Taken::Silent => {}
            Taken::Refused => {
                self.blocks.distrust(block);
                self.watch.has_refused = true;
                self.watch.refused += 1;
                if self.watch.refused >= MOST_SPIKES {
                    // What a front expects that is linearised far off isn't what the body would do.
                    self.watch.is_armed = is_near;
                    if is_near {
                        self.watch.event = Some(Reset::Lockout);
                    }
                }
            }
            Taken::In(square) => {
                if is_whole {
                    self.watch.refused = 0;
                }
                if self.watch.is_armed && is_near && self.config.gyro_noise_rad_s.is_some() {
                    self.watch_for_change(square);
                }
            }
        }
    }

    fn watch_for_change(&mut self, square: T) {
        let usual = self.usual_rad_s();
        let beyond = square / (usual * usual) - T::lit(USUAL_SQUARE);
        self.watch.sum = (self.watch.sum + beyond).max(T::zero());
        if self.watch.sum > T::lit(CHANGED_SUM) {
            self.watch.event = Some(Reset::Lockout);
        }
    }

    /// One sigma of a gyro sample by which the front is scaled, rad/s.
    pub(super) fn front_scale_rad_s(&self) -> T {
        self.passes.front().map_or(self.noise_rad_s(), |f| self.scale_rad_s(f.residuals()))
    }

    /// One sigma of what a row of the front usually leaves, rad/s.
    fn usual_rad_s(&self) -> T {
        self.front_scale_rad_s().max(self.noise_rad_s())
    }

    /// What a row of the front may leave at most, rad/s: more is a spike.
    pub(super) fn most_rad_s(&self) -> T {
        if !self.watch.is_armed {
            return T::MAX;
        }
        let is_sure = self.config.gyro_noise_rad_s.is_some();
        let sigmas = if is_sure { SPIKE_SIGMA } else { SPIKE_SIGMA_UNSURE };
        self.usual_rad_s() * T::lit(sigmas)
    }

    fn work_beside_the_front(&mut self) {
        match self.work {
            Work::Idle => self.begin(),
            Work::Solving(mut solving, purpose) => {
                if !self.take_held_row(&mut solving, true) {
                    self.work = Work::Solving(solving, purpose);
                    return;
                }
                self.work = match purpose {
                    Purpose::Rework => Work::Solved(solving),
                    Purpose::MoveOn => match self.passes.both().1.room().solve() {
                        Some(step) => Work::Carrying(step, 0),
                        None => return self.lose(),
                    },
                };
            }
            Work::Solved(solving) => self.judge(&solving),
            Work::Choosing => self.choose(),
            Work::Starting(starting) => self.work_on_the_start(starting),
            Work::Beginning(point) => self.begin_pass(&point),
            Work::Passing if self.has_overtaken() => self.compare(),
            Work::Passing => {
                let per = self.per_kg_m2();
                let (_, rework) = self.passes.both();
                if rework.stage(&self.blocks).is_some() {
                    rework.work(&self.blocks, per, T::MAX);
                } else {
                    self.compare();
                }
            }
            Work::Carrying(step, done) => self.carry(step, done),
            Work::Ending(_) => {}
        }
    }

    /// Adds a row of what is held to the front's factor, in the room of the other pass.
    fn take_held_row(&mut self, solving: &mut Solving<T>, with_past: bool) -> bool {
        let held = super::held(
            &self.config,
            if with_past { self.past.as_ref() } else { None },
            self.typical_kg_m2,
            self.has_drag,
            self.front_scale_rad_s(),
        );
        let (Some(front), other) = self.passes.both() else { return true };
        let point = *front.point();
        solving.take_row(other.room(), &point, &held)
    }

    /// Begins to solve the front, or looks for a first point.
    fn begin(&mut self) {
        if self.passes.front().is_some() {
            self.copy_front_to_room();
            self.work = Work::Solving(Solving::new(), Purpose::Rework);
        } else {
            self.tried_with = self.blocks.len();
            self.look_for_a_start();
        }
    }

    fn copy_front_to_room(&mut self) {
        if let (Some(front), other) = self.passes.both() {
            *other.room() = *front.information();
        }
    }

    fn begin_pass(&mut self, point: &Point<T>) {
        let known = match &self.beginning {
            Beginning::Known(known) => Some(known),
            Beginning::Linear(_) | Beginning::Found => None,
        };
        let has_begun = self.passes.both().1.begin(point, known);
        self.work = if has_begun { Work::Passing } else { Work::Idle };
    }

    /// The rework has caught up: it takes the front's place where it fits better.
    ///
    /// Where the window is to be carried on, one that has overtaken a front which waited is solved at once,
    /// before more blocks come: its step is then what linearising left out, and no more.
    fn compare(&mut self) {
        let had_to_wait = self.has_overtaken();
        self.work = Work::Idle;
        if let Some(closing) = &mut self.closing {
            closing.passes = closing.passes.saturating_sub(1);
        }
        let rework = self.passes.other();
        let ours = rework.residuals().mean_square();
        let is_better = self.has_found(rework.residuals())
            || self.passes.front().is_none_or(|front| {
                let theirs = front.residuals().mean_square();
                ours <= theirs || (ours.is_finite() && !theirs.is_finite())
            });
        if is_better {
            self.passes.swap();
            self.rests_until = 0;
            if had_to_wait && self.is_to_move_on() {
                self.begin();
            }
        }
    }

    /// Whether the front knows the inertia so well that its blocks needn't be gone over again: then a window
    /// of unstable motion is carried on before rounding is magnified to the size of the noise.
    fn knows_enough(&mut self) -> bool {
        let noise = self.noise_rad_s();
        let Some(front) = self.passes.front() else { return false };
        self.checked_at = front.next();
        let are_small = |v: [T; 6]| v.iter().all(|v| *v * noise * noise < T::lit(KNOWN * KNOWN));
        inertia_variances(front.information()).is_some_and(are_small)
    }

    /// The next window is to begin where the front has come to, with all that it knows.
    fn begin_moving_on(&mut self) {
        if !self.passes.front().is_some_and(|front| self.explains(front.residuals())) {
            return self.lose();
        }
        self.copy_front_to_room();
        self.work = Work::Solving(Solving::new(), Purpose::MoveOn);
    }

    /// Carries on one of the three equations that depend on the momentum; after them the next window begins.
    fn carry(&mut self, step: [T; U], done: usize) {
        let (Some(front), other) = self.passes.both() else { return };
        let (point, rest) = front.carried(&step);
        let room = other.room();
        if done == 0 {
            room.take_over(front.information(), 3);
            room.shift(&core::array::from_fn(|i| step[i] - rest[i]));
        }
        if done < 3 {
            let Some((row, y, weight)) = front.carried_equation(done, &step, &rest) else {
                return self.lose();
            };
            room.add_weighted(&row, y, weight);
            self.work = Work::Carrying(step, done + 1);
            return;
        }
        let known = Known { point, information: *room };
        self.ended.add(front.residuals());
        let first = front.next();
        let has_begun = front.begin(&point, Some(&known));
        self.beginning = Beginning::Known(known);
        if !has_begun {
            return self.lose();
        }
        self.blocks.begin_dropping(first);
        (self.watch.near_at, self.watch.close_at) = (0, 0);
        self.work = Work::Idle;
        self.rests_until = 0;
    }

    /// Nothing was found in as much motion as there is storage for: all begins at the next sample.
    pub(super) fn lose(&mut self) {
        self.work = Work::Idle;
        self.closing = None;
        self.passes.drop_front();
        self.blocks.clear();
        self.averager = None;
    }

    /// Ends the window. What it says of the inertia is fused with the past in the steps that follow.
    pub(super) fn end_window(&mut self) {
        self.has_started_over = false;
        if matches!(self.work, Work::Ending(_)) {
            // The one that is open since has no front yet.
            return self.blocks.clear();
        }
        let closing = self.closing.take();
        self.work = match self.passes.front() {
            Some(front) => Work::Ending(Ending {
                last: closing.map_or_else(|| self.filling_after(front), |closing| closing.last),
                solving: None,
                with_past: true,
                // As old as the middle of the window that it is from.
                age_s: self.window_s * T::lit(0.5),
                is_succeeded: false,
            }),
            None => Work::Idle,
        };
        self.blocks.clear();
    }

    /// The block that is being filled, if nothing lies between it and what a pass has looked at.
    pub(super) fn filling_after(&self, pass: &Pass<T, U>) -> Option<Block<T>> {
        let has_all = !self.blocks.is_rebuilt() && pass.has_looked_at_all(&self.blocks);
        self.averager.as_ref().filter(|_| has_all)?.block()
    }

    /// The front first comes to its end; then it is solved, without the past if that contradicts it.
    fn work_on_the_end(&mut self) {
        let Work::Ending(mut ending) = self.work else { return };
        let (per, most) = (self.per_kg_m2(), self.most_rad_s());
        match &mut ending.solving {
            None => {
                let (Some(front), _) = self.passes.both() else { return self.has_ended(&ending) };
                if front.work_to_the_end(&mut ending.last, per, most).is_none() {
                    let residuals = *front.residuals();
                    if !self.explains(&residuals) {
                        return self.has_ended(&ending);
                    }
                    self.copy_front_to_room();
                    ending.solving = Some(Solving::new());
                }
            }
            Some(solving) => {
                let noise = self.front_scale_rad_s();
                let has_past = ending.with_past && self.past.is_some();
                if !solving.has_all_but_the_sphere::<U>(has_past) {
                    self.take_held_row(solving, ending.with_past);
                } else if has_past && super::contradicts(solving.past_square(), noise) {
                    self.watch.event = Some(Reset::Changed);
                    ending.with_past = false;
                    ending.solving = Some(Solving::new());
                    self.copy_front_to_room();
                } else {
                    let solving = *solving;
                    return self.keep(&ending, &solving);
                }
            }
        }
        self.work = Work::Ending(ending);
    }

    /// What the window says of the inertia takes the past's place.
    fn keep(&mut self, ending: &Ending<T>, solving: &Solving<T>) {
        if let Some(front) = self.passes.front() {
            let held = self.held(self.front_scale_rad_s());
            let past = known(self.passes.other().information(), front.point(), &held);
            let ended = self.ended_with(front.residuals(), solving);
            self.past = Some(past);
            self.ended = ended;
            self.past_age_s = ending.age_s;
        }
        self.has_ended(ending);
    }

    fn has_ended(&mut self, ending: &Ending<T>) {
        self.work = Work::Idle;
        self.passes.drop_front();
        if ending.is_succeeded {
            self.begin_afresh();
        }
    }

    /// See [`LinearStart`].
    pub(super) fn linear(&self) -> Option<&LinearStart<T, U>> {
        match &self.beginning {
            Beginning::Linear(linear) => Some(linear),
            Beginning::Known(_) | Beginning::Found => None,
        }
    }

    /// One slice of the linear start.
    fn work_on_the_start(&mut self, mut starting: Starting<T>) {
        let (noise, holds) = (self.noise_rad_s(), self.holds());
        let Beginning::Linear(linear) = &self.beginning else {
            self.work = Work::Idle;
            return;
        };
        let room = self.passes.both().1.room();
        match starting.solving.work(linear, noise, &holds, room) {
            Found::NotYet => self.work = Work::Starting(starting),
            Found::Start(start) => self.start_from(&starting, &start),
            Found::Nothing => self.start_otherwise(&starting),
        }
    }
}
