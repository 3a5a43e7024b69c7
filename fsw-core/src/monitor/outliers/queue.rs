//! Samples on their way through the gate: not yet judged, or judged and waiting for neighbours.

use super::predictor::{History, Offset, Reading};
use super::{Judged, is_uniform};
use crate::math::{Vec3, scalar::Real};
use crate::persist::Blank;

/// Places. A burst of five bad samples is bridged from both sides once two samples after it are
/// accepted, and these wait for two successors each: 5 + 2 + 2.
pub(super) const PLACES: usize = 9;

/// One sample, and its verdict once it is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place<T: Real, P> {
    /// Time since the sample before, s.
    elapsed_s: T,
    rate_rad_s: Vec3<T>,
    payload: P,
    /// [`ACCEPTED`], [`ABSENT`], otherwise 0. A word: without padding an empty queue is all zeros.
    mark: u32,
}

/// Mark of an accepted sample.
const ACCEPTED: u32 = 1;
/// Mark of a sample without a reading.
const ABSENT: u32 = 2;

crate::persist!([T: Real, P: crate::persist::Persist + Blank] Place<T, P> {
    elapsed_s, rate_rad_s, payload, mark
});

impl<T: Real, P> Place<T, P> {
    fn is_accepted(&self) -> bool {
        self.mark == ACCEPTED
    }

    fn is_absent(&self) -> bool {
        self.mark == ABSENT
    }
}

/// First in, first out, in a circle of places; the first `judged` of `len` samples have a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Queue<T: Real, P> {
    places: [Place<T, P>; PLACES],
    /// Place of the first sample.
    first: u32,
    len: u32,
    judged: u32,
    /// Accepted readings before the first sample of the queue.
    before: History<T>,
}

crate::persist!([T: Real, P: crate::persist::Persist + Blank] Queue<T, P> {
    places, first, len, judged, before
} if |this| {
    (this.first as usize) < PLACES && this.len as usize <= PLACES && this.judged <= this.len
});

impl<T: Real, P: Copy + Blank> Queue<T, P> {
    /// No sample.
    #[inline(always)] // built in its place
    pub(super) fn empty() -> Self {
        let place =
            Place { elapsed_s: T::zero(), rate_rad_s: Vec3::zeros(), payload: P::blank(), mark: 0 };
        Self { places: [place; PLACES], first: 0, len: 0, judged: 0, before: History::empty() }
    }

    /// Discards all samples. Their places keep their contents, which are not read.
    pub(super) fn clear(&mut self) {
        (self.first, self.len, self.judged) = (0, 0, 0);
        self.before = History::empty();
    }

    /// Number of samples.
    pub(super) fn len(&self) -> usize {
        (self.len as usize).min(PLACES)
    }

    /// The samples from one on, in order.
    fn from(&self, sample: usize) -> impl Iterator<Item = &Place<T, P>> {
        let index = self.index(sample);
        let after = self.places.get(index..).unwrap_or(&[]);
        let before = self.places.get(..index).unwrap_or(&[]);
        after.iter().chain(before).take(self.len().saturating_sub(sample))
    }

    /// Place of a sample.
    fn index(&self, sample: usize) -> usize {
        let index = (self.first as usize).min(PLACES) + sample;
        if index < PLACES { index } else { index - PLACES }
    }

    /// One sample.
    fn sample(&self, sample: usize) -> Option<&Place<T, P>> {
        self.places.get(self.index(sample)).filter(|_| sample < self.len())
    }

    /// Number of samples with a verdict.
    fn judged(&self) -> usize {
        (self.judged as usize).min(self.len())
    }

    /// Number of samples without a verdict.
    pub(super) fn unjudged(&self) -> usize {
        self.len() - self.judged()
    }

    /// True where a sample without a verdict is followed by this number of readings, has none itself, or is to make room.
    pub(super) fn is_followed(&self, by: usize) -> bool {
        let judged = self.judged();
        let Some(next) = self.sample(judged) else { return false };
        let is_full = judged == 0 && self.len() == PLACES;
        let followers = || self.from(judged + 1).filter(|place| !place.is_absent()).count();
        next.is_absent() || is_full || followers() >= by
    }

    /// Adds a sample, which may have no reading. The caller takes one out first where all places are in use.
    pub(super) fn add(&mut self, elapsed_s: T, rate_rad_s: Option<Vec3<T>>, payload: P) {
        let (len, index) = (self.len(), self.index(self.len()));
        if let Some(place) = self.places.get_mut(index).filter(|_| len < PLACES) {
            let mark = if rate_rad_s.is_some() { 0 } else { ABSENT };
            let rate_rad_s = rate_rad_s.unwrap_or(Vec3::zeros());
            *place = Place { elapsed_s, rate_rad_s, payload, mark };
            self.len = (len + 1) as u32;
        }
    }

    /// Time since the sample before (s) and payload of each sample.
    pub(super) fn pending(&self) -> impl Iterator<Item = (T, P)> {
        self.from(0).map(|place| (place.elapsed_s, place.payload))
    }

    /// The first sample without a verdict: time since the sample before (s) and rate, if it has one.
    pub(super) fn next(&self) -> Option<(T, Option<Vec3<T>>)> {
        let place = self.sample(self.judged())?;
        Some((place.elapsed_s, (!place.is_absent()).then_some(place.rate_rad_s)))
    }

    /// Gives the first sample without a verdict its verdict.
    pub(super) fn judge(&mut self, is_accepted: bool) {
        let (judged, index) = (self.judged(), self.index(self.judged()));
        if let Some(place) = self.places.get_mut(index).filter(|_| judged < (self.len as usize)) {
            if is_accepted {
                place.mark = ACCEPTED;
            }
            self.judged = (judged + 1) as u32;
        }
    }

    /// Up to three readings after the first sample without a verdict, as far as `is_usable`. Times
    /// relative to that sample.
    #[inline]
    pub(super) fn following(
        &self,
        is_usable: impl Fn(&Vec3<T>) -> bool,
    ) -> ([Reading<T>; 3], usize) {
        let following = self.from(self.judged() + 1);
        let marked = following.map(|p| (p, !p.is_absent() && is_usable(&p.rate_rad_s)));
        collect(&self.places[0], marked)
    }

    /// All readings, or those without three equal values. Times relative to the sample before the first.
    pub(super) fn readings(&self, is_varied: bool) -> ([Reading<T>; PLACES], usize) {
        let is_usable =
            |p: &Place<T, P>| !(p.is_absent() || is_varied && is_uniform(&p.rate_rad_s));
        let marked = self.from(0).map(|p| (p, is_usable(p)));
        collect(&self.places[0], marked)
    }

    /// First rate that is `is_usable`.
    pub(super) fn first_rate(&self, is_usable: impl Fn(&Vec3<T>) -> bool) -> Option<Vec3<T>> {
        self.from(0).filter(|p| !p.is_absent()).map(|p| p.rate_rad_s).find(is_usable)
    }

    /// Takes the first sample, if it is judged and, where it was refused, two samples after it are
    /// accepted. `must` takes it in any case.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn take(&mut self, must: bool) -> Option<Judged<T, P>> {
        let judged = self.judged();
        if judged == 0 && !must {
            return None;
        }
        let first = self.sample(0)?;
        let is_accepted = first.is_accepted() && judged > 0;
        let is_absent = first.is_absent();
        let (mut rate_rad_s, mut is_known) = (first.rate_rad_s, is_accepted);
        let mut before = self.before;
        before.advance(first.elapsed_s);
        if is_accepted {
            before.add(&rate_rad_s);
        } else {
            let after = self.from(1).take(judged.saturating_sub(1));
            let (after, count) = collect(&self.places[0], after.map(|p| (p, p.is_accepted())));
            if !must && count < 2 {
                return None;
            }
            let unjudged = self.sample(judged).filter(|place| !place.is_absent());
            let unjudged = unjudged.map(|place| (place.rate_rad_s, false));
            let bridged = bridged(&before, &after, count).or(unjudged);
            (rate_rad_s, is_known) = bridged.unwrap_or((rate_rad_s, false));
        }
        let (elapsed_s, payload) = (first.elapsed_s, first.payload);
        self.before = before;
        self.first = self.index(1) as u32;
        self.judged = judged.saturating_sub(1) as u32;
        self.len = self.len().saturating_sub(1) as u32;
        Some(Judged { elapsed_s, rate_rad_s, payload, is_accepted, is_known, is_absent })
    }
}

/// Readings of those samples that are marked, up to N; those beyond have the rate of another sample.
#[inline]
fn collect<'a, T: Real, P: 'a, const N: usize>(
    other: &Place<T, P>,
    samples: impl Iterator<Item = (&'a Place<T, P>, bool)>,
) -> ([Reading<T>; N], usize) {
    let (mut count, mut time_s) = (0, T::zero());
    let mut readings = [Reading { time_s, rate_rad_s: other.rate_rad_s }; N];
    for (place, is_marked) in samples {
        time_s += place.elapsed_s;
        if let (true, Some(reading)) = (is_marked, readings.get_mut(count)) {
            *reading = Reading { time_s, rate_rad_s: place.rate_rad_s };
            count += 1;
        }
    }
    (readings, count)
}

/// Rate at time zero by accepted neighbours, rad/s: a cubic through two on each side, a line
/// through one on each side, the nearest one where a side has none. True where its error is about that of a reading.
#[cfg_attr(target_os = "none", inline(never))]
fn bridged<T: Real>(
    before: &History<T>,
    after: &[Reading<T>; 2],
    count: usize,
) -> Option<(Vec3<T>, bool)> {
    let last = before.latest();
    let next = after.get(..count).and_then(|after| after.first());
    let (Some(last), Some(next)) = (last, next) else {
        return last.or(next).map(|nearest| (nearest.rate_rad_s, false));
    };
    let about = &last.rate_rad_s;
    if let ([second, first], Some([left, far_left])) = (after, before.pair().filter(|_| count >= 2))
    {
        let cubic = Offset::of_cubic([far_left, left, second, first], about);
        if let Some(cubic) = cubic.filter(|p| p.squared_gain < T::lit(CUBIC_GAIN)) {
            let is_known = cubic.squared_gain < T::lit(KNOWN_GAIN);
            return Some((about + cubic.rate_rad_s, is_known));
        }
    }
    Offset::of_line([last, next], about).map(|line| (about + line.rate_rad_s, false))
}

/// Largest gain of a bridging cubic: that of a gap of five samples between even neighbours is 4.4.
const CUBIC_GAIN: f64 = 8.0;

/// Gain up to which a bridged reading stands for one, of 1.5 times its variance: 1.9 for one missing reading, 2.4 for two in
/// a row, 2.8 for three.
const KNOWN_GAIN: f64 = 2.5;
