//! `window`: a stretch of motion fitted as a whole, at the Cramér-Rao bound.
//!
//! ```text
//!  step     sample ─► gate ─► averager ─► block ─► storage
//!                                                    │
//!  work     storage ─► front: one more block, predicted and taken in
//!                 ├──► linear start ─► descent: pass ─► step ─► pass … ─► new front
//!                 └──► compaction: rest collapsed, blocks merged two by two
//!
//!  estimate           front with beliefs ─► tensor, covariance, observed directions, status
//! ```
//!
//! [`step`](Window::step) does what must be done at once: checks, averages. All else is cut into slices of
//! bounded cost, a block each, and [`work`](Window::work) does as many of them as the caller has time for. A
//! caller that never calls it gets [`Config::slices_per_step`] of them with each step. [`finish`](Window::finish)
//! completes everything that is due.
//!
//! # Life of a window
//!
//! A window opens with the first sample, and with the first motion after a rest. Its blocks are fitted
//! anew each time their number has grown by half (module `fit`): the result is the *front*, which takes in further
//! blocks as they come. A window ends at rest, after a gap, by command, or where storage is full of
//! blocks that turn far. Its information on the inertia joins that of the windows before it, unless a
//! chi-square test finds that the two contradict each other: then the inertia has changed.
//!
//! # Changes
//!
//! A change in mid-manoeuvre moves the estimate by more than its covariance allows (module `steadiness`): the residuals
//! are not called white. A cumulative sum of recursive residuals shows its instant. The blocks before and after it
//! are then fitted apart (module `inquiry`). Where those after it are explained, they become a window of their
//! own, and all earlier information is doubted: it is not used until the new window alone is certain enough
//! to decide between a change and an interruption. Where they are not explained, the model is wrong: the
//! status is diverged, and nothing is discarded.

pub mod config;

mod considered;
mod inquiry;
mod report;
mod solution;
mod steadiness;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_considered;
#[cfg(test)]
mod tests_of_drift;
#[cfg(test)]
mod tests_of_swing;
mod work;

pub use crate::trajectory::unknowns;
pub use config::Config;
pub use work::{Remaining, Slice};

use crate::blocks::block::{Averager, Block, Limits, REFUSED_WEIGHT, Reading};
use crate::blocks::excitation::Excitation;
use crate::blocks::storage::Storage;
use crate::blocks::stretch::Stretch;
use crate::fit::belief::{Beliefs, Past};
use crate::fit::drift::walked_rad_s;
use crate::fit::front::Front;
use crate::trajectory::unknowns::{Groups, is_a_set};
use considered::Considered;
use inquiry::{Inquiry, Recurrence};
use report::Ended;
use steadiness::Steadiness;
use work::Work;

use crate::dynamics::wheels::{Momenta, WheelArray};
use crate::error::ConfigError;
use crate::estimate::Estimate;
use crate::estimator::Estimator;
use crate::gate::{Gate, Verdict};
use crate::hardware::Finding;
use crate::math::{Vec3, largest_component, scalar::Real};
use crate::monitor::innovation::Innovation;
use crate::monitor::outliers::{Judged, OutlierGate};
use crate::outcome::{Coasting, Outcome, Reset};
use crate::prior::Prior;
use crate::sample::Sample;

/// W wheels; up to N blocks, at least 64; U unknowns: 9 for momentum, shape and scale, and three for each
/// further group; up to C groups of three parameters of the hardware that are considered (module `considered`).
///
/// Fields in the order written: built in its place, a part with content takes a copy on the stack together with an
/// absent one beside it.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Window<
    T: Real,
    const W: usize,
    const N: usize,
    const U: usize,
    const C: usize = 0,
    const M: usize = 0,
> {
    config: Config<T, W>,
    wheels: WheelArray<T, W>,
    groups: Groups<T>,
    gate: Gate<T>,
    /// Outlier gate on raw readings, which delays them by two; it measures the noise.
    outliers: OutlierGate<T, Drive<T, W>>,
    averager: Option<Averager<T, W>>,
    excitation: Excitation<T>,
    /// True between manoeuvres: nothing is fitted.
    is_quiet: bool,
    /// Mean interval between samples, s, and the number of intervals in it.
    period_s: T,
    intervals: u32,
    /// Largest rate so far, rad/s. The noise is at least the rounding error of this rate.
    largest_rad_s: T,
    /// Effects of the hardware that is considered.
    considered: Considered<T, C>,
    blocks: Storage<T, W, N>,
    /// Stretch of the blocks that are being taken in.
    open: Stretch<T, W>,
    /// Stretch before it whose fit is not complete.
    closing: Option<Closing<T, W>>,
    /// Stretch between both, which has ended too.
    waiting: Option<Closing<T, W>>,
    /// Unit of the inverse trace, 1/(kg m²).
    unit_per_kg_m2: T,
    front: Option<Front<T, W, U, M>>,
    work: Work<T, W, U, M>,
    schedule: Schedule,
    inquiry: Option<Inquiry>,
    steadiness: Steadiness<T>,
    /// Information of earlier windows, with the random walk of the inertia up to the start of the present motion.
    past: Option<Past<T, U>>,
    /// Information from before a contradiction that may be a change: kept, but not used. It is doubtful once
    /// the blocks after the contradiction are a window of their own.
    doubted: Option<Past<T, U>>,
    is_doubtful: bool,
    /// False once the residuals of earlier windows, or of what is doubted, were not white.
    is_known_white: bool,
    /// Contradictions that recur.
    recurrence: Recurrence,
    /// Prior of the configuration after its random walk; none once data have contradicted it.
    prior: Option<Prior<T>>,
    ended: Ended<T>,
    /// Reset that the next step reports, and whether a reading was refused since the last one.
    event: Option<Reset>,
    has_refused: bool,
    rate_rad_s: Vec3<T>,
}

crate::persist!([T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize] Window<T, W, N, U, C, M> {
    config, groups, gate, outliers, averager, excitation, is_quiet, period_s, intervals, largest_rad_s, considered, blocks,
    open, closing, waiting, unit_per_kg_m2, front, work, schedule, inquiry, steadiness, past, doubted, is_doubtful, is_known_white, recurrence, prior, ended, event, has_refused,
    rate_rad_s; unchanged wheels
} if |this| this.is_within());

/// Momentum of each wheel, N m s, and external torque, N m, at the instant of a sample.
type Drive<T, const W: usize> = (Momenta<T, W>, Vec3<T>);

/// Stretch of blocks that takes in no more, and the index after its last one.
#[derive(Clone, Copy, Debug)]
struct Closing<T: Real, const W: usize> {
    stretch: Stretch<T, W>,
    end: usize,
}

crate::persist!([T: Real, const W: usize] Closing<T, W> { stretch, end });

/// Numbers of blocks that decide when to fit again. Blocks are counted as they come, not as they are
/// stored, and short ones at the start of a record by their share of a usual one.
#[derive(Clone, Copy, Debug)]
struct Schedule {
    /// Number of blocks: of the present window, at the last fit, and before the motion.
    blocks: u32,
    fitted: u32,
    quiet: u32,
    /// Samples of short blocks that are not counted yet.
    uncounted: u32,
    /// Number at which the next fit is due.
    due_at: u32,
    /// True where a fit over all blocks is due: at the end of a window or of a log.
    is_final: bool,
}

crate::persist!([] Schedule { blocks, fitted, quiet, uncounted, due_at, is_final });

/// Noise over the stated one that is still taken for noise: data sheets are wrong by less, and what
/// exceeds it is a fault.
const MOST_UNDERSTATED: f64 = 2.5;
/// Shift of the predicted rate by rounding that ends a window, in σ of a sample, and the angle that a window
/// may turn in any case, rad.
const PHASE_SHARE: f64 = 0.3;
const LEAST_TURN_RAD: f64 = 30.0;
/// Samples that a step takes in at most: after a hole up to nine leave the outlier gate, which are spread over the steps that
/// follow. The most expensive step has 5,671 instructions (`cargo bench-target`); with blocks of one sample it has 6,717.
const MOST_SAMPLES: u32 = 2;
/// Usual block over those of a record that ends before the first fit in flight: in so few blocks, means over the usual
/// number of samples would lose a part of its information.
const SHORTEST_BLOCK: u32 = 2;
/// Blocks at which a window is fitted for the first time, without being asked to.
const FIRST_FIT_BLOCKS: u32 = 8;

impl Schedule {
    fn new() -> Self {
        let [blocks, fitted, quiet, uncounted] = [0; 4];
        Self { blocks, fitted, quiet, uncounted, due_at: FIRST_FIT_BLOCKS, is_final: false }
    }

    /// Counts a block of up to these samples of those of a usual one.
    fn count(&mut self, samples: u32, usual: u32) {
        self.uncounted = self.uncounted.saturating_add(samples);
        if self.uncounted >= usual {
            self.uncounted = 0;
            self.blocks = self.blocks.saturating_add(1);
        }
    }

    /// Counts what is left at the end of a record.
    fn count_rest(&mut self) {
        let is_left = core::mem::replace(&mut self.uncounted, 0) > 0;
        self.blocks = self.blocks.saturating_add(u32::from(is_left));
    }

    /// Begin of the motion: the blocks before it belong to the rest.
    fn reopen(&mut self) {
        self.quiet = self.blocks;
        self.due_at = self.blocks.saturating_add(FIRST_FIT_BLOCKS);
    }

    /// Number of blocks at which those since the motion began have grown by half since the last fit, or by `least`.
    fn grown_at(&self, least: u32) -> u32 {
        let grown = self.fitted.saturating_sub(self.quiet) / 2;
        self.fitted.saturating_add(grown.max(least))
    }

    /// Next fit at this growth.
    fn wait_for_growth(&mut self, least: u32) {
        self.due_at = self.grown_at(least);
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Window<T, W, N, U, C, M>
{
    /// U.
    pub const UNKNOWNS: usize = U;
    /// C.
    pub const CONSIDERED: usize = C;

    /// Estimator that waits for its first sample.
    ///
    /// # Errors
    /// Names the first field of the configuration that is out of its range, or for whose unknowns U has no
    /// place.
    pub fn new(config: Config<T, W>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        let mut this = Self::in_place(wheels);
        this.reset(config)?;
        Ok(this)
    }

    /// Initialises all state, with this configuration.
    ///
    /// # Errors
    /// As [`new`](Self::new); the state is unchanged then.
    pub fn reset(&mut self, config: Config<T, W>) -> Result<(), ConfigError> {
        config.validate::<U, C, M>()?;
        // Field by field: a whole one would be made on the stack first.
        config.set_groups::<U>(&mut self.groups);
        self.gate = Gate::new(config.gate);
        self.outliers.reset();
        self.averager = None;
        self.excitation = Excitation::new();
        self.is_quiet = false;
        self.period_s = T::zero();
        self.intervals = 0;
        self.largest_rad_s = T::zero();
        self.blocks.clear(T::count(config.block_samples));
        self.open = Stretch::new(Momenta::zeros());
        self.closing = None;
        self.waiting = None;
        self.unit_per_kg_m2 = T::one();
        self.front = None;
        self.work = Work::Idle;
        self.schedule = Schedule::new();
        self.inquiry = None;
        self.steadiness = Steadiness::none();
        self.past = None;
        self.doubted = None;
        self.is_doubtful = false;
        self.is_known_white = true;
        self.recurrence = Recurrence::NONE;
        self.considered = Considered::NOTHING;
        self.prior = config.prior;
        self.ended = Ended::nothing();
        self.event = None;
        self.has_refused = false;
        self.rate_rad_s = Vec3::zeros();
        self.config = config;
        Ok(())
    }

    /// Estimator without a configuration, to be completed by [`reset`](Self::reset). Inlined, so that a large window
    /// is built in its place and not on the stack.
    #[inline(always)]
    pub fn in_place(wheels: WheelArray<T, W>) -> Self {
        const {
            assert!(N >= 64, "storage for fewer blocks than a fit needs");
            assert!(is_a_set(U), "9 unknowns, and three for each further group");
        };
        let config = Config::of_unknown_noise();
        Self {
            groups: Groups::none(),
            gate: Gate::new(config.gate),
            outliers: OutlierGate::new(),
            averager: None,
            excitation: Excitation::new(),
            is_quiet: false,
            period_s: T::zero(),
            intervals: 0,
            largest_rad_s: T::zero(),
            considered: Considered::NOTHING,
            blocks: Storage::new(),
            open: Stretch::new(Momenta::zeros()),
            closing: None,
            waiting: None,
            unit_per_kg_m2: T::one(),
            front: None,
            work: Work::Idle,
            schedule: Schedule::new(),
            inquiry: None,
            steadiness: Steadiness::none(),
            past: None,
            doubted: None,
            is_doubtful: false,
            is_known_white: true,
            recurrence: Recurrence::NONE,
            prior: None,
            ended: Ended::nothing(),
            event: None,
            has_refused: false,
            rate_rad_s: Vec3::zeros(),
            config,
            wheels,
        }
    }

    /// Ends the window. Its fit is completed by the work that follows, or by [`finish`](Self::finish), and
    /// the estimate is that of the window until then. A new one opens with the next motion.
    pub fn close_window(&mut self) {
        self.drain();
        self.end_stretch();
        self.is_quiet = true;
    }

    /// Opens a window at the next sample, whether anything moves or not. A window that is open ends.
    pub fn open_window(&mut self) {
        self.drain();
        self.end_stretch();
        self.is_quiet = false;
    }

    /// As [`step`](Estimator::step), without any slice of work: for a caller that calls
    /// [`work`](Self::work) itself, and compiles it apart from the step.
    pub fn step_alone(&mut self, sample: &Sample<T, W>) -> Outcome {
        match self.take_sample(sample) {
            Some(outcome) => outcome,
            None => self.outcome(),
        }
    }

    /// Checks and takes in a sample. Returns the outcome where it is known already.
    fn take_sample(&mut self, sample: &Sample<T, W>) -> Option<Outcome> {
        let verdict = self.gate.check(sample);
        if !matches!(verdict, Verdict::Rejected(_)) {
            self.rate_rad_s = sample.rate_rad_s;
        }
        match verdict {
            Verdict::Rejected(why) => {
                if let Some(elapsed_us) = self.gate.bridge(sample) {
                    self.push_drive(sample, T::seconds(elapsed_us));
                }
                Some(Outcome::Coasting(Coasting::Rejected(why)))
            }
            Verdict::First => {
                self.begin_stretch(sample);
                Some(Outcome::Reset(Reset::FirstSample))
            }
            Verdict::Gap => {
                self.drain();
                self.end_stretch();
                self.begin_stretch(sample);
                Some(Outcome::Reset(self.gate.cause_of_gap().into()))
            }
            Verdict::After { elapsed_us } => {
                self.push(sample, T::seconds(elapsed_us));
                None
            }
        }
    }

    /// Outcome of a sample that was taken in.
    fn outcome(&mut self) -> Outcome {
        match self.event.take() {
            Some(reset) => Outcome::Reset(reset),
            None if core::mem::take(&mut self.has_refused) => Outcome::Coasting(Coasting::Spike),
            None if self.front.is_some() || self.is_quiet => Outcome::Updated,
            None => Outcome::Coasting(Coasting::Aligning),
        }
    }

    /// True while a window is open.
    pub fn is_open(&self) -> bool {
        self.averager.is_some() && !self.is_quiet
    }

    /// True where nothing moves and no work is due: missing samples cost nothing now.
    pub fn is_at_rest(&self) -> bool {
        self.is_quiet && self.closing.is_none() && matches!(self.work, Work::Idle)
    }

    /// One sigma of a gyro sample, rad/s: stated or measured, and at least the rounding of the largest rate.
    #[inline(never)]
    fn noise_rad_s(&self) -> T {
        let floor = self.largest_rad_s * (T::EPSILON + T::EPSILON);
        let noise = self.config.gyro_noise_rad_s.unwrap_or_else(|| self.outliers.noise_rad_s());
        noise.max(floor).max(T::lit(1e-15))
    }

    /// Noise against which residuals are judged, rad/s: the larger of stated and measured, up to
    /// [`MOST_UNDERSTATED`] times the stated one.
    #[inline(never)]
    fn reference_rad_s(&self) -> T {
        let noise = self.noise_rad_s();
        let measured = self.outliers.noise_rad_s();
        match self.config.gyro_noise_rad_s {
            Some(_) => noise.max(measured.min(noise * T::lit(MOST_UNDERSTATED))),
            None => noise,
        }
    }

    /// Prior, unless data have contradicted it or may have.
    fn known_prior(&self) -> Option<&Prior<T>> {
        self.prior.as_ref().filter(|_| !self.is_doubtful)
    }

    /// All knowledge beside the blocks.
    fn beliefs(&self, unit_per_kg_m2: T) -> Beliefs<'_, T, U> {
        Beliefs {
            groups: &self.groups,
            prior: self.known_prior(),
            past: self.past_beside(),
            unit_per_kg_m2,
            noise_rad_s: self.noise_rad_s(),
            holds_hardware: false,
            holds_modes: false,
            bias_walked_rad_s: self.bias_walked_rad_s(),
            has_varying_torque: self.config.varying_torque_n_m > T::zero(),
            has_varying_inertia: self.config.is_walking(),
        }
    }

    /// Earlier windows as knowledge beside the blocks; none where the inertia walks: passes begin with them then.
    fn past_beside(&self) -> Option<&Past<T, U>> {
        self.past.as_ref().filter(|_| !self.config.is_walking())
    }

    /// One sigma of the gyro bias' walk over the present window, rad/s.
    fn bias_walked_rad_s(&self) -> T {
        let (walk, instability) =
            (self.config.bias_walk_rad_s_sqrt_s, self.config.bias_instability_rad_s);
        walked_rad_s(walk, instability, self.stretch().duration_s)
    }

    /// Passes a sample to the outlier gate, and takes in what is ready.
    fn push(&mut self, sample: &Sample<T, W>, elapsed_s: T) {
        let drive = self.drive_of(sample);
        let floor = self.config.gyro_noise_rad_s.unwrap_or(T::zero());
        self.outliers.add(elapsed_s, sample.rate_rad_s, drive, floor);
        self.advance_outliers();
    }

    /// As [`push`](Self::push), for a sample whose rate was rejected: its drive is known.
    #[inline(never)]
    fn push_drive(&mut self, sample: &Sample<T, W>, elapsed_s: T) {
        let drive = self.drive_of(sample);
        self.outliers.add_absent(elapsed_s, drive);
        self.advance_outliers();
    }

    fn drive_of(&self, sample: &Sample<T, W>) -> Drive<T, W> {
        (self.wheels.momenta_n_m_s(&sample.wheel_speed_rad_s), sample.torque_n_m)
    }

    /// Takes in the samples that the outlier gate has judged.
    #[inline(never)]
    fn advance_outliers(&mut self) {
        let mut judged = self.outliers.advance();
        for further in (0..MOST_SAMPLES).rev() {
            let Some(sample) = judged else { break };
            self.take_in(&sample);
            judged = if further > 0 { self.outliers.ready() } else { None };
        }
    }

    /// Takes in what the gate still holds: at the end of a stretch.
    fn drain(&mut self) {
        for _ in 0..9 {
            let Some(sample) = self.outliers.drain() else { break };
            self.take_in(&sample);
        }
    }

    /// Begins a stretch of samples.
    fn begin_stretch(&mut self, sample: &Sample<T, W>) {
        self.outliers.restart();
        self.averager = None;
        self.excitation = Excitation::new();
        self.is_quiet = false;
        self.push(sample, T::zero());
    }

    /// Takes in a sample that the gate has judged.
    #[inline(never)]
    fn take_in(&mut self, sample: &Judged<T, Drive<T, W>>) {
        let (wheel_momentum_n_m_s, torque_n_m) = sample.payload;
        let reading = Reading {
            weight: match (sample.is_accepted, sample.is_known) {
                (true, _) => T::one(),
                (false, true) => T::lit(REFUSED_WEIGHT),
                (false, false) => T::zero(),
            },
            is_known: sample.is_known,
            rate_rad_s: sample.rate_rad_s,
            wheel_momentum_n_m_s,
            torque_n_m,
        };
        self.has_refused |= !sample.is_accepted && !sample.is_absent;
        let samples = self.samples_of_block();
        let Some(averager) = &mut self.averager else {
            self.averager = Some(Averager::new(reading));
            self.open = Stretch::new(wheel_momentum_n_m_s);
            return;
        };
        let elapsed_s = sample.elapsed_s;
        self.largest_rad_s = self.largest_rad_s.max(largest_component(&reading.rate_rad_s));
        self.intervals = self.intervals.saturating_add(1);
        self.period_s += (elapsed_s - self.period_s) / T::count(self.intervals.min(1000));
        let limits = Limits {
            samples,
            turn_rad: self.config.block_turn_rad,
            is_torque_smooth: self.config.is_torque_smooth,
        };
        if let Some(block) = averager.add(reading, elapsed_s, &limits) {
            self.take_in_block(&block);
        }
    }

    /// Samples of the next block: those of a usual one, fewer before the first fit in flight.
    fn samples_of_block(&self) -> u32 {
        let usual = self.blocks.usual().to_f32() as u32;
        if self.is_short_record() { (usual / SHORTEST_BLOCK).max(1) } else { usual }
    }

    /// True before the first record has as many samples as the usual blocks of the first fit in flight.
    fn is_short_record(&self) -> bool {
        let usual = self.blocks.usual();
        let first_fit = usual * T::count(FIRST_FIT_BLOCKS) - T::lit(0.5);
        self.is_first_fit()
            && usual <= T::count(self.config.block_samples)
            && self.open.duration_s <= first_fit * self.period_s
    }

    /// True until a fit has begun, with no block of an earlier record in storage and nothing known from one.
    fn is_first_fit(&self) -> bool {
        let is_known = self.past.is_some() || self.doubted.is_some();
        self.schedule.fitted == 0 && self.front.is_none() && self.closing.is_none() && !is_known
    }

    /// Takes in a block. At rest it is stored too: the motion begins before it is noticed.
    #[inline(never)]
    fn take_in_block(&mut self, block: &Block<T, W>) {
        let noise = self.reference_rad_s();
        let typical_kg_m2 = T::lit(1.0 / 3.0) / self.unit_per_kg_m2;
        let begins = self.is_quiet
            && self.excitation.begins(block, self.wheels.axes(), noise, typical_kg_m2);
        self.add_block(block);
        self.excitation.add(block, self.wheels.axes(), noise, typical_kg_m2);
        if begins || self.is_quiet && self.excitation.is_driven() {
            self.is_quiet = false;
            self.excitation = Excitation::new();
            self.schedule.reopen();
            self.blocks.set_usual(T::count(self.config.block_samples));
        }
        if self.front.is_some() && !self.is_quiet && self.excitation.is_over(self.config.quiet_s) {
            self.end_stretch();
            self.is_quiet = true;
        } else if self.closing.is_none() && self.has_turned_too_far() {
            self.end_stretch();
        }
    }

    #[inline(never)]
    fn add_block(&mut self, block: &Block<T, W>) {
        if self.open.duration_s == T::zero() {
            let start = self.averager.as_ref().map(Averager::wheels_at_start_n_m_s);
            self.open.wheels_n_m_s = start.unwrap_or(self.open.wheels_n_m_s);
        }
        let usual = self.blocks.usual().to_f32() as u32;
        self.schedule.count(self.samples_of_block(), usual);
        self.open.note(block);
        self.blocks.push(block);
        if self.config.is_walking() {
            self.age(block.duration_s);
        }
    }

    /// The prior forgets by the random walk of the inertia over a block, and earlier windows between two motions: those of a
    /// motion walk in its passes.
    #[inline(never)]
    fn age(&mut self, duration_s: T) {
        let walk = self.config.inertia_walk_kg_m2_sqrt_s;
        for sigma in self.prior.iter_mut().flat_map(|prior| &mut prior.sigma_kg_m2) {
            let aged = (*sigma * *sigma + walk * walk * duration_s).sqrt();
            *sigma = if aged < T::MAX { aged } else { *sigma };
        }
        if self.is_quiet && self.closing.is_none() {
            self.age_past(duration_s);
        }
    }

    /// Earlier windows forget by the random walk of the inertia over this time, s.
    fn age_past(&mut self, duration_s: T) {
        let walk = self.config.inertia_walk_kg_m2_sqrt_s;
        if self.config.is_walking() {
            for past in [&mut self.past, &mut self.doubted].into_iter().flatten() {
                past.walk(walk * duration_s.max(T::zero()).sqrt());
            }
        }
    }

    /// True where the turn in this window exceeds the limit that rounding of the tensor sets.
    ///
    /// A tensor rounded by ε shifts the phase by up to ε times the angle, and the rate by that share of
    /// itself: the angle at which this is [`PHASE_SHARE`] σ, and [`LEAST_TURN_RAD`] at least, ends a window.
    /// In double precision it is out of reach.
    fn has_turned_too_far(&self) -> bool {
        let share = T::lit(PHASE_SHARE) * self.noise_rad_s();
        let most = share / (self.largest_rad_s * T::EPSILON);
        self.open.turn_rad > most.max(T::lit(LEAST_TURN_RAD))
    }

    /// Ends the stretch of blocks that is being taken in: at rest, after a gap, by command, and in mid-motion
    /// where storage is full, or rounding or a random walk limits it. What follows begins another one.
    #[inline(never)]
    fn end_stretch(&mut self) {
        if let Some(block) = self.averager.as_mut().and_then(Averager::finish) {
            self.add_block(&block);
            self.schedule.count_rest();
        }
        let wheels =
            self.averager.as_ref().map_or(Momenta::zeros(), Averager::wheels_at_start_n_m_s);
        let ended = core::mem::replace(&mut self.open, Stretch::new(wheels));
        let end = self.blocks.len();
        let begin = self.waiting.or(self.closing).map_or(0, |before| before.end);
        if end == begin {
            return;
        }
        if self.waiting.is_some() && !self.blocks.is_compacting() {
            // Places for two: the first of three is concluded with the fit that it has.
            self.conclude();
        }
        if self.waiting.is_some() {
            self.blocks.truncate(begin);
            return;
        }
        let end = self.blocks.len();
        if self.closing.is_some() {
            self.waiting = Some(Closing { stretch: ended, end });
            return;
        }
        self.closing = Some(Closing { stretch: ended, end });
        self.schedule.is_final = self.schedule.fitted != self.schedule.blocks;
    }

    /// True where every index lies within storage, as no correct state violates.
    fn is_within(&self) -> bool {
        let len = self.blocks.len();
        self.front.as_ref().is_none_or(|front| front.pass.next <= len)
            && [&self.closing, &self.waiting].iter().all(|at| at.is_none_or(|at| at.end <= len))
            && self.unit_per_kg_m2 > T::zero()
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize, const C: usize, const M: usize>
    Estimator<T, W> for Window<T, W, N, U, C, M>
{
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        if let Some(outcome) = self.take_sample(sample) {
            return outcome;
        }
        self.work(self.config.slices_per_step);
        self.outcome()
    }

    fn estimate(&self) -> Estimate<T> {
        let mut estimate = Estimate::of_nothing();
        self.report(&mut estimate);
        estimate
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        self.rate_rad_s
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        None
    }

    fn each_of_hardware(&self, visit: &mut dyn FnMut(Finding<T>)) {
        self.findings(visit);
    }

    fn finish(&mut self) {
        self.complete();
    }
}
