//! `window`: a stretch of motion fitted as a whole, at the Cramér-Rao bound.
//!
//! ```text
//!  sample ─► block ─────► storage ────────► pass ──────────────► solution ─► estimate
//!            averages     N blocks; merged  integrate motion     with what
//!        └─► linear       two by two when   and sensitivities,   is held:
//!            start        full              residuals into a     past, zero
//!            a first                        triangular factor    torque
//!            estimate ──────────────────────┘       ▲                │
//!                                                   └─ a better point┘
//! ```
//!
//! No initial guess is needed: as soon as the motion stands out of the noise, linear least squares
//! gives a first point (`linear_start`). About it a pass of Gauss-Newton goes over the
//! blocks, catches up with the newest, and stays with it: that is the *front*, and it is valid at
//! any time. Meanwhile another pass, the *rework*, starts again at the first block from what the
//! front has found, overtakes it as soon as it has caught up, and so on. All that takes more than a
//! few hundred instructions is cut into slices, whose cost is known before they begin (`cost`), and a
//! step does no more of them than its budget has room for (`work`). Since passes run while
//! data arrives, their horizon grows as the estimate does: the phase of the predicted motion is
//! never lost, however far the body turns. A front that is far from its solution waits until the rework
//! has overtaken it: what it would say of more blocks is linearised at the wrong point.
//!
//! When storage is full, blocks are merged two by two. Where they already turn as far as the
//! integration allows, what the front knows of momentum and inertia, once it is close to its solution, is
//! carried to the end of the window as information, and the next window begins with it: nothing is lost.
//!
//! A window ends when nothing moves any more (`excitation`), after a gap, or by command. What
//! it says of the inertia is then fused with what was known before (`past`), which may walk at
//! random meanwhile, unless a chi-square test finds that the two contradict each other: then the
//! inertia has changed, and the stale past is dropped. So is a prior that the data contradict.
//!
//! A change in mid-manoeuvre shows in rows that aren't what a front near its solution expects; before there
//! is such a front, in a pass that doesn't explain the data where one did before (`start`). No inertia
//! explains what comes before and after: all that was known is dropped, and the window starts over with the
//! next sample. It does so once, for a torque that nobody models looks the same.
//!
//! Beside momentum and inertia, a constant disturbance torque and a gyro bias can be unknowns
//! (`unknowns`). Where the torque is among the U unknowns but isn't asked for, it is held at zero and
//! tested (`solution`). With 18 unknowns, a torque that is asked for is also tested for a part that
//! changes with the body's motion, such as the air's; where it shows, drag rates are unknowns as well.
//!
//! Limits, as yet: torque and bias are found anew in each window; the rate is the newest reading's.

pub mod config;

mod approach;
mod block;
mod cost;
mod excitation;
mod linear_start;
mod noise;
mod packed;
mod pass;
mod past;
mod report;
mod solution;
mod start;
mod storage;
#[cfg(test)]
mod tests;
mod trajectory;
mod unknowns;
mod work;

pub use config::Config;

use block::{Averager, Block, Limits, Reading};
use cost::Cost;
use excitation::Excitation;
use linear_start::{Holds, LinearStart};
use noise::NoiseMeter;
use past::Past;
use solution::{Held, Hold};
use storage::Storage;
use unknowns::{Known, is_a_set};
use work::{Passes, Work};

use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::estimate::Estimate;
use crate::estimator::Estimator;
use crate::gate::{Gate, Verdict};
use crate::math::{Vec3, scalar::Real};
use crate::monitor::innovation::Innovation;
use crate::outcome::{Coasting, Outcome, Reset};
use crate::sample::Sample;

/// With so many blocks and still no linear start, some directions are unseen: the passes then
/// start from a sphere, or from the prior.
const BLOCKS_TO_SEE: usize = 32;

/// One sigma that holds drag rates, 1/s. Ours: what is found in the air on thrown objects of a tenth of
/// a metre and a hundred grams, 0.1 to 0.2; in orbit there is none.
const DRAG_RANGE: f64 = 0.2;
/// One sigma of a gyro bias that is allowed for beside drag even where none is asked for, rad/s: a
/// steady rate against the air and a steady error of the gyro look alike, and consumer gyros have 1 deg/s
/// of it.
const BIAS_WITH_DRAG_RAD_S: f64 = 0.02;

/// W wheels; up to N blocks, at least 64; U unknowns: 9 for momentum and inertia, 12 with a
/// disturbance torque, 15 with a gyro bias as well, 18 with drag.
#[derive(Clone, Debug)]
pub struct Window<T: Real, const W: usize, const N: usize, const U: usize> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    meter: NoiseMeter<T>,
    /// What takes in the samples.
    averager: Option<Averager<T>>,
    excitation: Excitation<T>,
    /// Between manoeuvres: blocks aren't kept.
    is_quiet: bool,
    /// Samples in a block from now on.
    block_samples: u32,
    blocks: Storage<T, N>,
    /// Momentum and inertia are kept in units of this, so that single precision sees numbers
    /// near 1.
    typical_kg_m2: T,
    /// The inertia before this window, and how long ago that was when the window opened, or is
    /// while none is open, s.
    past: Option<Past<T>>,
    past_age_s: T,
    /// How long this window is open, s.
    window_s: T,
    beginning: Beginning<T, U>,
    passes: Passes<T, U>,
    work: Work<T, U>,
    /// Rows in the front until it is looked at again.
    rests_until: u32,
    /// Passes in a row that were begun from points that explain nothing.
    attempts: u32,
    /// Whether this window has given up its data once, and the later ones aren't explained yet.
    has_started_over: bool,
    /// Whether a front of this window has explained its data, from a point near its solution.
    has_explained: bool,
    /// Blocks with which a first point was looked for.
    tried_with: usize,
    /// Block at which the front was asked whether the motion is too unstable to go on.
    checked_at: usize,
    /// Whether the torque that is looked for has been found to change with the motion.
    has_drag: bool,
    watch: Watch<T>,
    /// A window that has been closed, whose front isn't settled yet.
    closing: Option<Closing<T>>,
    /// Of windows that ended.
    ended: report::Ended<T>,
    rate_rad_s: Vec3<T>,
}

crate::persist!([T: Real, const W: usize, const N: usize, const U: usize] Window<T, W, N, U> {
    config, gate, meter, averager, excitation, is_quiet, block_samples, blocks, typical_kg_m2, past,
    past_age_s, window_s, beginning, passes, work, rests_until, attempts, has_started_over, has_explained,
    tried_with, checked_at, has_drag, watch, closing, ended, rate_rad_s; unchanged wheels
} if |this| this.passes.are_within(N));

/// What a window begins with.
#[derive(Clone, Copy, Debug)]
enum Beginning<T: Real, const U: usize> {
    /// Nothing is known: linear least squares goes along with the samples.
    Linear(LinearStart<T, U>),
    /// What the window before it has found.
    Known(Known<T, U>),
    /// Nothing was known, and all has been found since.
    Found,
}

crate::persist!([T: Real, const U: usize] enum Beginning<T, U> {
    0 => Linear(linear: LinearStart<T, U>), 1 => Known(known: Known<T, U>), 2 => Found
});

/// A window that takes in no more: the block that was being filled, and how many passes may still be
/// finished before it is concluded.
#[derive(Clone, Copy, Debug)]
struct Closing<T: Real> {
    last: Option<Block<T>>,
    passes: u32,
}

/// After so many passes over all of its data a front is settled, or never will be.
const MOST_CLOSING_PASSES: u32 = 3;

crate::persist!([T: Real] Closing<T> { last, passes });

/// Watches the front's recursive residuals for spikes, and for a change in mid-manoeuvre.
#[derive(Clone, Copy, Debug)]
struct Watch<T: Real> {
    /// Whether the front has explained its data: before that, nothing is out of the ordinary.
    is_armed: bool,
    /// Blocks with which the front's point was found near its solution, and close to it; zero where it
    /// wasn't.
    near_at: usize,
    close_at: usize,
    /// Blocks refused in a row.
    refused: u32,
    /// Cumulative sum of squared residuals beyond what is usual.
    sum: T,
    /// What happened since the last step.
    event: Option<Reset>,
    has_refused: bool,
}

crate::persist!([T: Real] Watch<T> { is_armed, near_at, close_at, refused, sum, event, has_refused });

impl<T: Real> Watch<T> {
    fn new() -> Self {
        Self {
            is_armed: false,
            near_at: 0,
            close_at: 0,
            refused: 0,
            sum: T::zero(),
            event: None,
            has_refused: false,
        }
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// An estimator that waits for its first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range, or that asks for an unknown
    /// that isn't among the U.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        config.validate::<U>()?;
        Ok(Self::of_valid(config, wheels))
    }

    /// The same with the default configuration, for a gyro of which nothing is known: which needs no
    /// check, so that a large window can be built where it stays, and [`reset`](Self::reset) there.
    #[inline(always)]
    pub fn of_unknown_noise(wheels: WheelArray<T, W>) -> Self {
        Self::of_valid(Config::of_unknown_noise(), wheels)
    }

    /// As at the start, with this configuration.
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing has changed then.
    pub fn reset(&mut self, config: Config<T>) -> Result<(), ConfigError> {
        config.validate::<U>()?;
        // Field by field: a whole one would be made on the stack first.
        self.gate = Gate::new(config.gate);
        self.meter = NoiseMeter::new();
        self.averager = None;
        self.excitation = Excitation::new();
        self.is_quiet = false;
        self.block_samples = config.block_samples;
        self.blocks.clear();
        self.typical_kg_m2 = T::one();
        self.past = config.prior.as_ref().map(Past::from_prior);
        self.past_age_s = T::zero();
        self.window_s = T::zero();
        self.beginning = Beginning::Found;
        self.passes.drop_front();
        self.work = Work::Idle;
        self.rests_until = 0;
        self.attempts = 0;
        self.has_started_over = false;
        self.has_explained = false;
        self.tried_with = 0;
        self.checked_at = 0;
        self.has_drag = false;
        self.watch = Watch::new();
        self.closing = None;
        self.ended = report::Ended::nothing();
        self.rate_rad_s = Vec3::zeros();
        self.config = config;
        Ok(())
    }

    #[inline(always)]
    fn of_valid(config: Config<T>, wheels: WheelArray<T, W>) -> Self {
        const {
            assert!(N >= 64, "storage for fewer blocks than a start may need");
            assert!(is_a_set(U), "9, 12, 15 or 18 unknowns");
        };
        Self {
            gate: Gate::new(config.gate),
            meter: NoiseMeter::new(),
            averager: None,
            excitation: Excitation::new(),
            is_quiet: false,
            block_samples: config.block_samples,
            blocks: Storage::default(),
            typical_kg_m2: T::one(),
            past: config.prior.as_ref().map(Past::from_prior),
            past_age_s: T::zero(),
            window_s: T::zero(),
            beginning: Beginning::Found,
            passes: Passes::none(),
            work: Work::Idle,
            rests_until: 0,
            attempts: 0,
            has_started_over: false,
            has_explained: false,
            tried_with: 0,
            checked_at: 0,
            has_drag: false,
            watch: Watch::new(),
            closing: None,
            ended: report::Ended::nothing(),
            rate_rad_s: Vec3::zeros(),
            config,
            wheels,
        }
    }

    /// Ends the window: what it says of the inertia is kept, and a new one opens with the next motion.
    /// The steps that follow settle its passes and conclude it, and until they have the estimate is that
    /// of the window.
    pub fn close_window(&mut self) {
        match self.passes.front() {
            Some(front) if !self.is_quiet && !matches!(self.work, Work::Ending(_)) => {
                let last = self.filling_after(front);
                self.closing = Some(Closing { last, passes: MOST_CLOSING_PASSES });
            }
            Some(_) if self.closing.is_some() => {}
            _ => self.end_window(),
        }
        self.is_quiet = true;
    }

    /// Begins a window at the next sample, whether anything moves or not. One that is open ends.
    pub fn open_window(&mut self) {
        self.end_window();
        self.averager = None;
        self.is_quiet = false;
    }

    /// Whether a window is open.
    pub fn is_open(&self) -> bool {
        self.averager.is_some() && !self.is_quiet
    }

    /// Whether nothing moves, and all that was found before is concluded: samples that fail to come now cost
    /// nothing.
    pub fn is_at_rest(&self) -> bool {
        self.is_quiet && self.closing.is_none() && matches!(self.work, Work::Idle)
    }

    fn reading(&self, sample: &Sample<T, W>) -> Reading<T> {
        Reading {
            rate_rad_s: sample.rate_rad_s,
            wheel_momentum_n_m_s: self.wheels.momentum_n_m_s(&sample.wheel_speed_rad_s),
            torque_n_m: sample.torque_n_m,
        }
    }

    /// Gyro noise, as given or as measured, one sigma per sample, rad/s.
    fn noise_rad_s(&self) -> T {
        self.config.gyro_noise_rad_s.unwrap_or_else(|| self.meter.noise_rad_s())
    }

    /// What is held beside the data, for residuals of this size.
    fn held(&self, noise_rad_s: T) -> Held<'_, T> {
        let past = self.past.as_ref();
        held(&self.config, past, self.typical_kg_m2, self.has_drag, noise_rad_s)
    }

    fn holds(&self) -> Holds<T> {
        let within = |sigma: Option<T>| sigma.map_or(Hold::AtZero, Hold::Within);
        Holds {
            torque: within(self.config.disturbance_torque_n_m),
            bias: within(self.config.gyro_bias_rad_s),
        }
    }

    /// Starts afresh at a reading. What is known of the inertia stays.
    fn open_at(&mut self, reading: Reading<T>) {
        self.averager = Some(Averager::new(reading));
        self.excitation = Excitation::new();
        self.meter.interrupt();
        self.begin_window(reading);
        self.is_quiet = false;
    }

    /// Begins a window at a reading, or will have begun it once the one before has ended.
    fn begin_window(&mut self, reading: Reading<T>) {
        self.blocks.clear();
        self.block_samples = self.config.block_samples;
        self.window_s = T::zero();
        self.beginning = Beginning::Linear(LinearStart::new(reading));
        match &mut self.work {
            Work::Ending(ending) => ending.is_succeeded = true,
            _ => self.begin_afresh(),
        }
    }

    /// Clears what belongs to one window, and walks the past to its beginning.
    fn begin_afresh(&mut self) {
        self.passes.drop_front();
        self.work = Work::Idle;
        self.rests_until = 0;
        self.attempts = 0;
        self.has_explained = false;
        self.tried_with = 0;
        self.checked_at = 0;
        self.ended = report::Ended::nothing();
        self.has_drag = false;
        self.watch.is_armed = false;
        self.watch.near_at = 0;
        self.watch.close_at = 0;
        self.watch.refused = 0;
        self.watch.sum = T::zero();
        let walk_kg_m2 = self.walk_kg_m2();
        if let Some(past) = &mut self.past {
            past.walk(walk_kg_m2);
        }
        self.past_age_s = T::zero();
    }

    /// How far the inertia may have walked since the past, one sigma of each element, kg m².
    fn walk_kg_m2(&self) -> T {
        self.config.inertia_walk_kg_m2_sqrt_s * self.past_age_s.max(T::zero()).sqrt()
    }

    /// All that was found is wrong: nothing is believed any more, no prior either, and all begins at
    /// the next sample.
    fn forget(&mut self) {
        self.past = None;
        self.ended = report::Ended::nothing();
        self.lose();
    }

    /// Takes in a reading. Returns what the step costs so far.
    fn take_in(&mut self, reading: Reading<T>, elapsed_s: T) -> Cost {
        self.meter.add(&reading.rate_rad_s);
        let limits = Limits {
            samples: self.block_samples,
            turn_rad: self.config.block_turn_rad,
            is_torque_smooth: self.config.is_torque_smooth,
        };
        let Some(averager) = &mut self.averager else { return cost::step::<U>() };
        let block = averager.add(reading, elapsed_s, &limits);
        let mut spent = cost::step::<U>();
        if self.is_quiet {
            self.past_age_s += elapsed_s;
        } else {
            self.window_s += elapsed_s;
            if let Beginning::Linear(linear) = &mut self.beginning {
                spent += cost::step_of_linear::<U>();
                if block.is_some() && linear.is_due() {
                    linear.close_block();
                    spent += cost::block_of_linear::<U>();
                }
                linear.add(reading, elapsed_s);
            }
        }
        if let Some(block) = block {
            spent += cost::BLOCK;
            if self.take_in_block(&block, reading) {
                spent += cost::open::<U>();
            }
        }
        spent
    }

    /// Whether a window opens with it.
    #[inline(never)]
    fn take_in_block(&mut self, block: &Block<T>, reading: Reading<T>) -> bool {
        let noise = self.noise_rad_s();
        let opens = self.is_quiet;
        if self.is_quiet {
            let begins = self.excitation.begins(block, noise, self.typical_kg_m2);
            self.excitation.add(block, noise, self.typical_kg_m2);
            if !begins && !self.excitation.is_driven() {
                return false;
            }
            self.is_quiet = false;
            self.excitation = Excitation::new();
            self.end_window();
            self.begin_window(reading);
        }
        if !self.blocks.push(block, self.block_samples, noise) {
            // Samples failed to come in the midst of it.
            self.end_window();
            self.open_at(reading);
            return true;
        }
        self.excitation.add(block, noise, self.typical_kg_m2);
        if self.passes.front().is_some() && self.excitation.is_over(self.config.quiet_s) {
            self.close_window();
        }
        opens
    }
}

/// What is held beside the data, for residuals of this size.
fn held<'a, T: Real>(
    config: &Config<T>,
    past: Option<&'a Past<T>>,
    typical_kg_m2: T,
    has_drag: bool,
    noise_rad_s: T,
) -> Held<'a, T> {
    let within = |sigma: Option<T>, unit: T| match sigma {
        Some(sigma) => Hold::Within(sigma / unit),
        None => Hold::AtZero,
    };
    let bias = T::lit(BIAS_WITH_DRAG_RAD_S);
    Held {
        noise_rad_s,
        typical_kg_m2,
        torque: within(config.disturbance_torque_n_m, typical_kg_m2),
        bias: within(config.gyro_bias_rad_s.or(has_drag.then_some(bias)), T::one()),
        drag: within(has_drag.then_some(T::lit(DRAG_RANGE)), T::one()),
        past,
    }
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Estimator<T, W>
    for Window<T, W, N, U>
{
    fn step(&mut self, sample: &Sample<T, W>) -> Outcome {
        let reading = self.reading(sample);
        let verdict = self.gate.check(sample);
        if !matches!(verdict, Verdict::Rejected(_)) {
            self.rate_rad_s = sample.rate_rad_s;
        }
        match verdict {
            Verdict::Rejected(why) => return Outcome::Coasting(Coasting::Rejected(why)),
            Verdict::First => {
                self.open_at(reading);
                return Outcome::Reset(Reset::FirstSample);
            }
            Verdict::Gap => {
                self.end_window();
                self.open_at(reading);
                return Outcome::Reset(Reset::Gap);
            }
            Verdict::After { elapsed_us } if self.averager.is_some() => {
                let spent = self.take_in(reading, T::seconds(elapsed_us));
                self.work(spent);
            }
            Verdict::After { .. } => self.open_at(reading),
        }
        match self.watch.event.take() {
            Some(Reset::Lockout) => {
                self.has_started_over = true;
                self.forget();
                Outcome::Reset(Reset::Lockout)
            }
            Some(reset) => Outcome::Reset(reset),
            None if core::mem::take(&mut self.watch.has_refused) => {
                Outcome::Coasting(Coasting::Spike)
            }
            None if self.passes.front().is_some() || self.is_quiet => Outcome::Updated,
            None => Outcome::Coasting(Coasting::Aligning),
        }
    }

    fn estimate(&self) -> Estimate<T> {
        self.report()
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        self.rate_rad_s
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        None
    }
}

/// Square of what the data leave of the past, over the gyro's variance, above which the two
/// contradict each other: chance exceeds it once in 10⁵ (chi-square of six degrees of freedom), and a
/// window is looked at some ten to a hundred times.
const CONTRADICTED: f64 = 33.0;

fn contradicts<T: Real>(square: T, noise_rad_s: T) -> bool {
    square > noise_rad_s * noise_rad_s * T::lit(CONTRADICTED)
}
