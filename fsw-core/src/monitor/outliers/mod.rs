//! Outlier gate: single bad readings of the gyro, judged by their neighbours alone.
//!
//! Input: time, rate and a payload of each sample. Output: the same samples two later, each
//! accepted, or refused with a rate bridged from accepted neighbours. No model of the body: the
//! gate protects a start that has no estimate yet.
//!
//! # Test
//!
//! The cubic through two neighbours on each side predicts the reading, left and right line the two
//! sides alone. With e the prediction minus the reading on one axis, c its gain (variance of e by
//! white noise over that of a reading), and s the running scale of `e_cubic / √c`, an axis disowns
//! the reading where
//!
//! `|e_cubic| > 6 s √c`, `e_left e_cubic > ½ e_cubic²` and `e_right e_cubic > ½ e_cubic²`.
//!
//! The last two: both sides are closer to the cubic's value than to the reading. They fail at a
//! step and at a kink of the motion, and beside a bad reading, since there one side agrees with the
//! reading.
//!
//! | neighbours | predictors | limits, scales |
//! |---|---|---|
//! | two on each side | cubic, left and right line | as above |
//! | on one side only | its lines: the nearest, a further one | 6, 4; all must disown |
//! | fewer | none | accepted |
//!
//! A sample without a reading is no neighbour, and waits in its place. A reading is judged once two readings follow it, or
//! where all places are in use; neighbours on the left before a long hole are discarded.
//!
//! * **Left** neighbours are accepted readings, **right** ones the readings that follow, without
//!   frames of three equal values far from the last accepted reading: 0, −1 count and full scale
//!   are what a bus without an answer returns. Such frames are refused themselves.
//! * **Scale**: running median of `e²`, module `scale`; never below the known
//!   noise, nor below the rounding of the reading. Curvature of the motion is part of it.
//! * **Run limit**: after 16 refused readings the motion has changed, not the gyro. The next one is
//!   accepted, and the scales start over.
//!
//! # Rates
//!
//! White noise passes with a probability of false alarm far below 1e-6 a sample: `2e-9` for six
//! sigmas, more by the scatter of the scale. A reading that is off by 20 sigmas is 14 gains off the
//! cubic and four deviations beyond the test of a side.
//!
//! # Start
//!
//! The first eight samples are held back; their second differences give the first scale, those that
//! one bad reading enters left out. The backlog is then judged at two samples a call.
//!
//! # Cost
//!
//! On a Cortex-M4F about 1,400 instructions a sample, up to 4,500 where five samples leave after a burst,
//! which the caller spreads by calls of [`ready`](OutlierGate::ready). 624 bytes in `f32` with a payload
//! of six numbers.

mod noise;
mod predictor;
mod queue;
mod scale;
#[cfg(test)]
mod tests;

use crate::math::{Vec3, scalar::Real};
use crate::persist::{Blank, Persist};
use noise::Noise;
use predictor::{History, Offset, Reading};
use queue::{PLACES, Queue};
use scale::Scale;

/// Limit of the cubic and of a single line, in scales. Three axes of white noise exceed it in 6e-9
/// of the samples.
const LIMIT: f64 = 6.0;

/// Limit of a further line that confirms, in scales.
const CONFIRMATION: f64 = 4.0;

/// Refused readings in a row after which the next one is accepted: three times the longest burst of
/// lost packets that is expected.
const RUN_LIMIT: u8 = 16;

/// Samples that are held back for the first scales: all places but one.
const START: usize = PLACES - 1;

/// Readings after the one that is judged.
const DELAY: usize = 2;

/// Verdicts in one call: two, so that a backlog shrinks by one sample a call.
const VERDICTS: usize = 2;

/// A sample with its verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged<T: Real, P> {
    /// Time since the sample before, s, as given.
    pub elapsed_s: T,
    /// Reading, rad/s; where it was refused, a cubic through two accepted neighbours on each side,
    /// a line through one on each side, or the nearest one.
    pub rate_rad_s: Vec3<T>,
    /// Payload, as given.
    pub payload: P,
    /// False for an outlier, and for a sample without a reading.
    pub is_accepted: bool,
    /// True for an accepted reading, and for one that is bridged from two neighbours on each side about as precisely: a hole
    /// of up to two readings.
    pub is_known: bool,
    /// True for a sample that came without a reading.
    pub is_absent: bool,
}

/// Gate for samples with a payload P, for instance torque and wheel momentum of the same instant.
///
/// ```
/// use fsw_core::Vec3;
/// use fsw_core::monitor::outliers::OutlierGate;
///
/// let mut gate = OutlierGate::<f32, u32>::new();
/// let mut judged = Vec::new();
/// for k in 0..50u32 {
///     let noise = 1e-3 * ((k * 7) % 5) as f32;
///     let spike = if k == 30 { 0.1 } else { 0.0 };
///     judged.extend(gate.push(0.1, Vec3::new(0.2 + noise + spike, noise, 0.0), k, 0.0));
///     judged.extend(std::iter::from_fn(|| gate.ready()));
/// }
/// judged.extend(std::iter::from_fn(|| gate.drain()));
/// let refused: Vec<u32> = judged.iter().filter(|j| !j.is_accepted).map(|j| j.payload).collect();
/// assert_eq!((judged.len(), refused), (50, vec![30]));
/// assert!((judged[30].rate_rad_s.x - 0.2).abs() < 5e-3); // bridged
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlierGate<T: Real, P> {
    queue: Queue<T, P>,
    /// Accepted readings before the first one without a verdict.
    history: History<T>,
    /// Errors of the cubic, normalised to the noise of a reading.
    across: Scale<T>,
    /// The same of a line.
    line: Scale<T>,
    /// Samples since the start of the scales, up to the end of the start.
    samples: u8,
    /// False until the first scales are known.
    is_scaled: bool,
    /// Known noise, rad/s.
    floor_rad_s: T,
    /// Refused readings in a row.
    run: u8,
    /// Refused readings. Saturates.
    refused: u32,
    noise: Noise<T>,
}

crate::persist!([T: Real, P: Persist + Blank] OutlierGate<T, P> {
    queue, history, across, line, samples, is_scaled, floor_rad_s, run, refused, noise
} if |this| this.run <= RUN_LIMIT);

/// Predictions of one reading.
struct Prediction<T: Real> {
    /// Squared error of the cubic, normalised, on each axis, rad²/s².
    across: Option<Vec3<T>>,
    /// The same of the nearest line, on the left where there are both.
    line: Option<Vec3<T>>,
    /// The same of the line on the right where there are both.
    right: Option<Vec3<T>>,
    /// Axes of which the sides, or a further line, confirm an outlier.
    is_confirmed: [bool; 3],
}

/// No prediction, and nothing that contradicts an outlier.
impl<T: Real> Default for Prediction<T> {
    fn default() -> Self {
        Self { across: None, line: None, right: None, is_confirmed: [true; 3] }
    }
}

impl<T: Real> Prediction<T> {
    /// True where an axis is beyond the squared limits of cubic and line, rad²/s², and confirmed.
    #[inline]
    fn is_disowned(&self, across: &Vec3<T>, line: &Vec3<T>) -> bool {
        let is_beyond = |error: &Option<Vec3<T>>, limit: &Vec3<T>, axis: usize| {
            error.as_ref().is_some_and(|error| error[axis] > limit[axis])
        };
        let (error, limit) =
            if self.across.is_some() { (&self.across, across) } else { (&self.line, line) };
        (0..3).any(|axis| {
            let by_sides = is_beyond(&self.right, line, axis) && is_beyond(&self.line, line, axis);
            by_sides || is_beyond(error, limit, axis) && self.is_confirmed[axis]
        })
    }
}

impl<T: Real, P: Copy + Blank> Default for OutlierGate<T, P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, P: Copy + Blank> OutlierGate<T, P> {
    /// Gate before the first sample.
    #[inline(always)] // built in its place
    pub fn new() -> Self {
        Self {
            queue: Queue::empty(),
            history: History::empty(),
            across: Scale::of_variance(T::zero()),
            line: Scale::of_variance(T::zero()),
            samples: 0,
            is_scaled: false,
            floor_rad_s: T::zero(),
            run: 0,
            refused: 0,
            noise: Noise::unknown(),
        }
    }

    /// Returns to the state before the first sample, in place: without a copy of the queue.
    pub fn reset(&mut self) {
        self.restart();
        self.across = Scale::of_variance(T::zero());
        self.line = self.across;
        self.samples = 0;
        self.is_scaled = false;
        self.floor_rad_s = T::zero();
        self.refused = 0;
        self.noise = Noise::unknown();
    }

    /// Takes in a sample and returns one that is ready: normally that of two calls before. None
    /// during the first eight samples, and while a refused sample waits for accepted neighbours;
    /// [`ready`](Self::ready) returns the others afterwards.
    ///
    /// `elapsed_s`: time since the sample before. `floor_rad_s`: known noise of the gyro, one sigma,
    /// 0 where unknown.
    pub fn push(
        &mut self,
        elapsed_s: T,
        rate_rad_s: Vec3<T>,
        payload: P,
        floor_rad_s: T,
    ) -> Option<Judged<T, P>> {
        self.add(elapsed_s, rate_rad_s, payload, floor_rad_s);
        self.advance()
    }

    /// First half of [`push`](Self::push): takes in a sample. [`advance`](Self::advance) must follow before
    /// all nine places are in use.
    #[inline]
    pub fn add(&mut self, elapsed_s: T, rate_rad_s: Vec3<T>, payload: P, floor_rad_s: T) {
        self.floor_rad_s = floor_rad_s;
        self.queue.add(elapsed_s, Some(rate_rad_s), payload);
    }

    /// As [`add`](Self::add), for a sample without a usable reading: its payload keeps its place.
    pub fn add_absent(&mut self, elapsed_s: T, payload: P) {
        self.queue.add(elapsed_s, None, payload);
    }

    /// Second half of [`push`](Self::push): up to two verdicts. Returns a sample that is ready.
    pub fn advance(&mut self) -> Option<Judged<T, P>> {
        if !self.is_scaled && self.queue.len() == START {
            self.start_scales();
        }
        for _ in 0..VERDICTS {
            if self.is_scaled && self.queue.is_followed(DELAY) {
                self.judge_next();
            }
        }
        self.queue.take(self.queue.len() == PLACES)
    }

    /// True while samples wait for a verdict beyond the usual delay and the newest one: the next
    /// [`advance`](Self::advance) makes two.
    pub fn is_behind(&self) -> bool {
        self.queue.unjudged() > DELAY + 1
    }

    /// Next sample that is ready beside the one that [`push`](Self::push) returned. To be called
    /// until None; a caller that does not has the delay of the longest run of refused samples, up to
    /// eight, from then on.
    pub fn ready(&mut self) -> Option<Judged<T, P>> {
        self.queue.take(false)
    }

    /// Next of the samples that are left, in order: at the end of a log and at a gap. To be called
    /// until None, at most nine times.
    pub fn drain(&mut self) -> Option<Judged<T, P>> {
        if !self.is_scaled && self.queue.unjudged() > 0 {
            self.start_scales();
        }
        for _ in 0..PLACES {
            if self.queue.unjudged() > 0 {
                self.judge_next();
            }
        }
        self.queue.take(true)
    }

    /// Discards samples and neighbours: after a gap, before its first sample. Scales, counter and
    /// measured noise stay.
    pub fn restart(&mut self) {
        self.queue.clear();
        self.history = History::empty();
        self.run = 0;
        self.noise.interrupt();
    }

    /// Time since the sample before (s) and payload of each sample that has not been returned.
    pub fn pending(&self) -> impl Iterator<Item = (T, P)> {
        self.queue.pending()
    }

    /// Number of refused samples. Saturates.
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Noise of the gyro by differences of accepted readings: one sigma of a reading, mean over the
    /// axes, rad/s. Zero before the first ten samples, and for readings that only repeat.
    ///
    /// Relative standard deviation on white noise: 3.8 % after 300 samples, 2 % later; bias below
    /// 2 %. Memory of 512 samples.
    pub fn noise_rad_s(&self) -> T {
        self.noise.sigma_rad_s()
    }

    /// First scales, by the readings in the queue.
    #[cfg_attr(target_os = "none", inline(never))]
    fn start_scales(&mut self) {
        let number = self.queue.len();
        let (mut readings, mut count) = self.queue.readings(true);
        if count <= 2 {
            (readings, count) = self.queue.readings(false);
        }
        let variance = scale::first_variance(readings.get(..count).unwrap_or(&[]));
        self.across = Scale::of_variance(variance);
        self.line = self.across;
        self.samples = 0;
        self.is_scaled = number >= START;
    }

    /// Verdict on the next sample.
    #[cfg_attr(target_os = "none", inline(never))]
    fn judge_next(&mut self) {
        let Some((elapsed_s, reading)) = self.queue.next() else {
            return;
        };
        self.history.advance(elapsed_s);
        let Some(rate_rad_s) = reading else {
            self.noise.interrupt();
            self.history.forget_old();
            return self.queue.judge(false);
        };
        let is_blank = self.is_blank(&rate_rad_s);
        let (after, count) = self.queue.following(|rate| !self.is_blank(rate));
        let prediction = self.predict(&rate_rad_s, &after, count);
        let across = self.limits(&self.across, &rate_rad_s);
        let line = self.limits(&self.line, &rate_rad_s);
        let is_outlier = is_blank || prediction.is_disowned(&across, &line);
        if !is_blank {
            self.follow(&prediction);
        }
        if is_outlier && self.run < RUN_LIMIT {
            self.run += 1;
            self.refused = self.refused.saturating_add(1);
            self.noise.interrupt();
            return self.queue.judge(false);
        }
        if is_outlier {
            self.history = History::empty();
            self.start_scales();
        }
        self.run = 0;
        self.history.add(&rate_rad_s);
        self.noise.add(&rate_rad_s, prediction.across, &(across * T::lit(1.0 / (LIMIT * LIMIT))));
        self.queue.judge(true);
    }

    /// Errors of the predictors that the neighbours permit.
    fn predict(
        &self,
        rate_rad_s: &Vec3<T>,
        after: &[Reading<T>; 3],
        count: usize,
    ) -> Prediction<T> {
        let [first, second, third] = after;
        let latest = self.history.latest();
        let inner = latest.filter(|_| count >= 1).map(|left| [left, first]);
        match self.history.pair() {
            Some([left, far_left]) if count >= 2 => {
                across([far_left, left, first, second], rate_rad_s)
            }
            Some([left, far_left]) => {
                on_one_side([left, far_left], [inner, None], &self.line, rate_rad_s)
            }
            None if count >= 2 => {
                let far = (count == 3).then_some([second, third]);
                let further = inner.or(far.map(|_| [first, third]));
                on_one_side([first, second], [further, far], &self.line, rate_rad_s)
            }
            None => Prediction::default(),
        }
    }

    /// Squared limit of six scales on each axis, rad²/s²; not below that of the known noise and of
    /// the reading's rounding. An unknown scale has none.
    #[cfg_attr(target_os = "none", inline(never))]
    fn limits(&self, scale: &Scale<T>, rate_rad_s: &Vec3<T>) -> Vec3<T> {
        let known = self.floor_rad_s * self.floor_rad_s;
        Vec3::from_fn(|axis, _| {
            let variance = larger(scale.variance(axis), known);
            if variance > T::zero() {
                let rounding = T::EPSILON * rate_rad_s[axis];
                larger(variance, rounding * rounding) * T::lit(LIMIT * LIMIT)
            } else {
                T::MAX
            }
        })
    }

    /// Moves the scales by the errors of a reading.
    fn follow(&mut self, prediction: &Prediction<T>) {
        if let Some(error) = &prediction.across {
            self.across.follow(error, self.samples);
        }
        if let Some(error) = &prediction.line {
            self.line.follow(error, self.samples);
        }
        self.samples = scale::count_of_start(self.samples);
    }

    /// True for a frame of three equal values beyond the limit from the last accepted reading, or
    /// from the first other frame where there is none. Two readings: twice the variance.
    #[inline]
    fn is_blank(&self, rate_rad_s: &Vec3<T>) -> bool {
        is_uniform(rate_rad_s) && self.is_far(rate_rad_s)
    }

    /// True for a reading beyond the limit from the reference of [`is_blank`](Self::is_blank).
    #[cfg_attr(target_os = "none", inline(never))]
    fn is_far(&self, rate_rad_s: &Vec3<T>) -> bool {
        let latest = self.history.latest().map(|latest| latest.rate_rad_s);
        let reference = latest.or_else(|| self.queue.first_rate(|rate| !is_uniform(rate)));
        reference.is_some_and(|reference| {
            let change = rate_rad_s - reference;
            let limit = self.limits(&self.line, &reference) * T::lit(2.0);
            (0..3).any(|axis| change[axis] * change[axis] > limit[axis])
        })
    }
}

/// Larger of two numbers. In contrast to [`Real::max`] an instruction and not a library call on the
/// Cortex-M4F; the first one where the second is NaN.
fn larger<T: Real>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// True for three equal values.
fn is_uniform<T: Real>(rate_rad_s: &Vec3<T>) -> bool {
    rate_rad_s.x == rate_rad_s.y && rate_rad_s.y == rate_rad_s.z
}

/// Prediction by two neighbours on each side, in the order of time.
fn across<T: Real>(four: [&Reading<T>; 4], rate_rad_s: &Vec3<T>) -> Prediction<T> {
    let [far_left, left, right, far_right] = four;
    let sides = [[left, far_left], [right, far_right]];
    let mut prediction =
        Prediction { across: None, line: None, right: None, is_confirmed: [true; 3] };
    let Some(cubic) = Offset::of_cubic(four, rate_rad_s) else {
        return prediction;
    };
    let error = cubic.rate_rad_s;
    prediction.across = Some(cubic.normalised());
    let half = error * T::lit(0.5);
    let [of_left, of_right] = sides.map(|side| {
        let line = Offset::of_line(side, rate_rad_s)?;
        for axis in 0..3 {
            let of_side = line.rate_rad_s[axis] * error[axis];
            prediction.is_confirmed[axis] &= of_side > half[axis] * error[axis];
        }
        Some(line.normalised())
    });
    prediction.line = of_left;
    prediction.right = of_right;
    prediction
}

/// Prediction by the nearest line, and up to two further ones that confirm.
fn on_one_side<T: Real>(
    nearest: [&Reading<T>; 2],
    further: [Option<[&Reading<T>; 2]>; 2],
    scale: &Scale<T>,
    rate_rad_s: &Vec3<T>,
) -> Prediction<T> {
    let error =
        |two: [&Reading<T>; 2]| Offset::of_line(two, rate_rad_s).map(|line| line.normalised());
    let mut prediction = Prediction { line: error(nearest), ..Prediction::default() };
    for squared in further.into_iter().flatten().filter_map(error) {
        for axis in 0..3 {
            let limit = scale.variance(axis) * T::lit(CONFIRMATION * CONFIRMATION);
            prediction.is_confirmed[axis] &= squared[axis] > limit;
        }
    }
    prediction
}
