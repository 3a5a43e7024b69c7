//! `window`: a stretch of motion fitted as a whole, at the Cramér-Rao bound.
//!
//! ```text
//!  sample ─► block ─────► storage ────────► pass ─────────────────────► estimate
//!            averages     N blocks; merged  integrate motion and
//!        └─► linear       two by two when   sensitivities, residuals
//!            start        full              into a triangular factor
//!            a first                        ▲         │ solve
//!            estimate ──────────────────────┴─────────┘ a better point
//! ```
//!
//! No initial guess is needed: as soon as the motion stands out of the noise, linear least squares
//! gives a first point (`linear_start`). About it a pass of Gauss-Newton goes over the
//! blocks, catches up with the newest, and stays with it: that is the *front*, and it is valid at
//! any time. Meanwhile another pass, the *rework*, starts again at the first block from what the
//! front has found, overtakes it as soon as it has caught up, and so on. Each step does a fixed
//! number of slices of this work, so that none costs more than another. Since passes run while
//! data arrives, their horizon grows as the estimate does: the phase of the predicted motion is
//! never lost, however far the body turns.
//!
//! When storage is full, blocks are merged two by two. Where they already turn as far as the
//! integration allows, what the front knows of momentum and inertia is carried to the end of the
//! window as information, and the next window begins with it: nothing is lost. After a gap, the
//! inertia alone is carried on.
//!
//! Limits, as yet: gyro noise must be known; disturbance torque and gyro bias aren't among the
//! unknowns; spikes aren't recognised; the rate is the newest reading's.

mod block;
pub mod config;
mod known;
mod linear_start;
mod pass;
mod storage;
mod trajectory;

pub use config::Config;

use block::{Averager, Reading};
use known::{Known, Point, UNKNOWNS};
use linear_start::LinearStart;
use pass::Pass;
use storage::Storage;

use super::{Coasting, Estimate, Estimator, Innovation, Outcome, Prior, Reset, Status};
use crate::dynamics::wheels::WheelArray;
use crate::error::ConfigError;
use crate::gate::{Gate, Verdict};
use crate::math::{Mat, Vec3, scalar::Real};
use crate::sample::Sample;
use crate::tensor::Inertia;

/// No pass before so many blocks: fewer equations than a few per unknown say little.
const BLOCKS_TO_START: usize = 16;
/// With so many blocks and still no linear start, some directions are unseen: the passes then
/// start from a sphere, or from the prior.
const BLOCKS_TO_SEE: usize = 64;
/// A front whose squared residuals exceed what the noise makes of them by this factor hasn't
/// found the solution yet: it is tried again, from its own point and from the linear start in turn.
const UNEXPLAINED: f64 = 1.5;
/// A solution within so many sigmas of its pass's own point isn't worth another.
const SETTLED_SIGMA: f64 = 0.01;
/// An element of more typical inertias than this is a pass that went astray.
const ASTRAY: f64 = 10.0;
/// A window ends where a change of the momentum at its start has grown by this factor: motion about
/// an unstable axis. Ours: single precision then still resolves 1e-5 of a rate.
const MOST_GROWTH: f64 = 30.0;
/// One sigma of every element, in units of the mean moment, below which linearising anew changes
/// nothing any more.
const KNOWN: f64 = 0.01;
/// Where noise alone exceeds a sum of squares once in eˣ windows, the model is rejected. Of chi-square
/// with k degrees of freedom that is at most `k + 2 √(k x) + 2 x` (Laurent and Massart, Ann. Stat. 28,
/// 2000, Lemma 1): 20 makes it once in 5·10⁸.
const REJECTED: f64 = 20.0;

/// W wheels; up to N blocks, at least 64.
#[derive(Clone, Debug)]
pub struct Window<T: Real, const W: usize, const N: usize> {
    config: Config<T>,
    wheels: WheelArray<T, W>,
    gate: Gate<T>,
    open: Option<Open<T>>,
    /// Samples in a block from now on.
    block_samples: u32,
    blocks: Storage<T, N>,
    /// Momentum and inertia are kept in units of this, so that single precision sees numbers
    /// near 1.
    typical_kg_m2: T,
    /// Before the first block of this window.
    known: Option<Known<T>>,
    /// Whether that comes from windows before this one.
    is_carried: bool,
    front: Option<Pass<T>>,
    rework: Option<Pass<T>>,
    /// Whether the next attempt is from the linear start.
    try_linear: bool,
    /// Sum of squares that no solution explained in the windows before, rad²/s², and their
    /// degrees of freedom.
    past: (T, u32),
    rate_rad_s: Vec3<T>,
}

/// What takes in the samples of an open window.
#[derive(Clone, Copy, Debug)]
struct Open<T: Real> {
    averager: Averager<T>,
    linear: LinearStart<T>,
}

impl<T: Real, const W: usize, const N: usize> Window<T, W, N> {
    /// An estimator that waits for its first sample.
    ///
    /// # Errors
    /// Names the configuration's first field that is out of its range.
    pub fn new(config: Config<T>, wheels: WheelArray<T, W>) -> Result<Self, ConfigError> {
        const { assert!(N >= BLOCKS_TO_SEE, "storage for fewer blocks than a start may need") };
        config.validate()?;
        Ok(Self {
            gate: Gate::new(config.gate),
            open: None,
            block_samples: config.block_samples,
            blocks: Storage::default(),
            typical_kg_m2: T::one(),
            known: None,
            is_carried: false,
            front: None,
            rework: None,
            try_linear: false,
            past: (T::zero(), 0),
            rate_rad_s: Vec3::zeros(),
            config,
            wheels,
        })
    }

    fn reading(&self, sample: &Sample<T, W>) -> Reading<T> {
        Reading {
            rate_rad_s: sample.rate_rad_s,
            wheel_momentum_n_m_s: self.wheels.momentum_n_m_s(&sample.wheel_speed_rad_s),
            torque_n_m: sample.torque_n_m,
        }
    }

    /// Opens a window at a reading. What is known of the inertia stays.
    fn open_at(&mut self, reading: Reading<T>) {
        let per = T::one() / self.typical_kg_m2;
        let wheel_momentum = reading.wheel_momentum_n_m_s * per;
        self.carry(self.up_to_now(), |known| known.after_gap(&reading.rate_rad_s, &wheel_momentum));
        self.open =
            Some(Open { averager: Averager::new(reading), linear: LinearStart::new(reading) });
        self.blocks.clear();
        self.block_samples = self.config.block_samples;
    }

    /// Whether this window's data rejects what was carried into it: the inertia has changed, or an
    /// earlier window was wrong about it.
    fn past_is_contradicted(&self) -> bool {
        self.is_carried
            && self.front.as_ref().is_some_and(|front| !self.explains(front.unexplained()))
    }

    fn forget(&mut self) {
        self.front = None;
        self.rework = None;
        self.known = None;
        self.is_carried = false;
        self.past = (T::zero(), 0);
    }

    /// Makes what a front knows, or a part of it, what is known before the next window, whose
    /// front starts from it. All is forgotten where there is nothing to carry.
    fn carry(&mut self, front: Option<Pass<T>>, part: impl FnOnce(Known<T>) -> Known<T>) {
        self.rework = None;
        let Some(known) = front.as_ref().and_then(Pass::known_at_next).map(part) else {
            return self.forget();
        };
        if let Some(front) = front {
            self.past = self.residuals(&front);
        }
        self.known = Some(known);
        self.is_carried = true;
        self.front = Pass::new(known.point, Some(&known));
    }

    fn take_in(&mut self, reading: Reading<T>, elapsed_s: T) {
        let Some(open) = &mut self.open else { return };
        let (samples, turn) = (self.block_samples, self.config.block_turn_rad);
        if let Some(block) = open.averager.add(reading, elapsed_s, samples, turn) {
            open.linear.close_block();
            self.blocks.push(block, self.config.gyro_noise_rad_s);
        }
        open.linear.add(reading, elapsed_s);
    }

    /// The work of one step, which came with this reading.
    fn work(&mut self, reading: Reading<T>) {
        if self.blocks.is_merging() {
            if self.blocks.merge_some(self.config.gyro_noise_rad_s) {
                for pass in [&mut self.front, &mut self.rework].into_iter().flatten() {
                    pass.halve();
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
        }
    }

    /// Begins to merge blocks, or a new window where they turn too far for that. False while a
    /// pass stands where it can't.
    fn make_room(&mut self, reading: Reading<T>) -> bool {
        if !self.blocks.can_merge(self.config.block_turn_rad) {
            let is_ready =
                |front: &Pass<T>| !front.is_busy() && front.next() + 1 >= self.blocks.len();
            if !self.front.as_ref().is_none_or(is_ready) {
                return false;
            }
            self.move_on(reading);
            return true;
        }
        let can_halve = |pass: &Pass<T>| pass.next().is_multiple_of(2);
        if ![&self.front, &self.rework].into_iter().flatten().all(can_halve) {
            return false;
        }
        self.blocks.begin_merging();
        self.block_samples = self.block_samples.saturating_mul(2);
        true
    }

    /// The next window begins where the front has come to, with all that it knows.
    fn move_on(&mut self, reading: Reading<T>) {
        if self.front.is_none() {
            // Nothing found in as much motion as there is storage for.
            return self.open_at(reading);
        }
        self.carry(self.up_to_date(), |known| known);
        self.blocks.keep_newest();
    }

    /// Whether the motion since the window opened magnifies a change of its start so far that
    /// rounding would be magnified to the size of the noise; the front is up to date; and it knows
    /// the inertia so well that its blocks needn't be gone over again.
    fn is_unstable(&self) -> bool {
        let Some(front) = &self.front else { return false };
        let noise = self.config.gyro_noise_rad_s;
        let is_known = |covariance: Mat<T, 6, 6>| {
            (0..6).all(|i| covariance[(i, i)] * noise * noise < T::lit(KNOWN * KNOWN))
        };
        front.growth_square() > T::lit(MOST_GROWTH * MOST_GROWTH)
            && !front.is_busy()
            && front.next() + 1 >= self.blocks.len()
            && front.inertia_covariance().is_some_and(is_known)
    }

    /// One slice of work: a row, or a block, of the front if it isn't up to date, else of the
    /// rework. Each block waits for its successor, which tells of its inside.
    fn slice(&mut self) {
        let per = T::one() / self.typical_kg_m2;
        for pass in [&mut self.front, &mut self.rework].into_iter().flatten() {
            if pass.is_busy() {
                return pass.take_row();
            }
            if pass.next() + 1 < self.blocks.len()
                && let Some(span) = self.blocks.span(pass.next(), per)
            {
                return pass.advance(&span);
            }
        }
        self.begin_pass();
    }

    fn begin_pass(&mut self) {
        if let Some(done) = self.rework.take()
            && self.is_better(&done)
        {
            self.front = Some(done);
        }
        let noise = self.config.gyro_noise_rad_s;
        let settled = T::lit(SETTLED_SIGMA) * noise;
        let found = self.front.as_ref().and_then(Pass::solve).filter(is_plausible);
        let explains = self.front.as_ref().is_some_and(|front| {
            mean_square(front.unexplained()) < T::lit(UNEXPLAINED) * noise * noise
        });
        let is_settled =
            self.front.as_ref().is_some_and(|front| front.step_square() < settled * settled);
        self.try_linear = !self.try_linear;
        let point = match found {
            Some(_) if explains && is_settled => None,
            Some(point) if explains || self.is_carried || !self.try_linear => Some(point),
            _ => self.first_point().or(found),
        };
        self.rework = point.and_then(|point| Pass::new(point, self.known.as_ref()));
    }

    /// Whether a finished rework should become the front.
    fn is_better(&self, rework: &Pass<T>) -> bool {
        if !rework.solve().is_some_and(|point| is_plausible(&point)) {
            return false;
        }
        let ours = mean_square(rework.unexplained());
        let theirs = self.front.as_ref().map(|front| mean_square(front.unexplained()));
        let noise = self.config.gyro_noise_rad_s;
        let good = noise * noise * T::lit(UNEXPLAINED);
        ours < good || theirs.is_none_or(|x| ours <= x || (ours.is_finite() && !x.is_finite()))
    }

    /// Where a first pass starts, once there is enough motion.
    fn first_point(&mut self) -> Option<Point<T>> {
        if self.blocks.len() < BLOCKS_TO_START {
            return None;
        }
        let linear = self.open?.linear;
        if let Some(start) = linear.solve(self.config.gyro_noise_rad_s)
            && start.inertia.is_positive_definite()
        {
            if self.front.is_none() {
                self.use_units_of(start.inertia.trace_kg_m2() * T::lit(1.0 / 3.0));
            }
            let per = T::one() / self.typical_kg_m2;
            return Some(Point {
                momentum: start.momentum_n_m_s * per,
                inertia: start.inertia.elements_kg_m2().map(|x| x * per),
            });
        }
        if self.front.is_some() || self.blocks.len() < BLOCKS_TO_SEE {
            return None;
        }
        let noise = self.config.gyro_noise_rad_s;
        let size = linear.size_kg_m2(noise);
        let prior = self.config.prior.unwrap_or(Prior::of_size(size.unwrap_or(T::one())));
        self.use_units_of(Inertia::new(prior.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0));
        let per = T::one() / self.typical_kg_m2;
        self.known = Some(Known::from_prior(&prior, noise, per));
        // In units of its own mean moment any inertia is a homogeneous one.
        if size.is_none()
            && let Some(start) = linear.solve_homogeneous()
            && start.inertia.is_positive_definite()
        {
            let inertia = start.inertia.elements_kg_m2();
            return Some(Point { momentum: start.momentum_n_m_s, inertia });
        }
        let inertia = prior.inertia_kg_m2.map(|x| x * per);
        Some(Point { momentum: self.first_momentum(&inertia)?, inertia })
    }

    /// Sets the unit of inertia, and what is known from the prior in it.
    fn use_units_of(&mut self, typical_kg_m2: T) {
        self.typical_kg_m2 = typical_kg_m2;
        let per = T::one() / typical_kg_m2;
        let noise = self.config.gyro_noise_rad_s;
        self.known = self.config.prior.map(|prior| Known::from_prior(&prior, noise, per));
    }

    /// Momentum about the first block for an inertia, both in units of the typical inertia.
    fn first_momentum(&self, inertia: &[T; 6]) -> Option<Vec3<T>> {
        let first = self.blocks.span(0, T::one() / self.typical_kg_m2)?.block;
        Some(Inertia::new(*inertia).matrix_kg_m2() * first.rate_rad_s + first.drive_n_m_s)
    }

    /// The front with all rows that wait taken in.
    fn up_to_date(&self) -> Option<Pass<T>> {
        let mut front = self.front?;
        for _ in 0..UNKNOWNS {
            front.take_row();
        }
        Some(front)
    }

    /// The front, carried on over what hasn't come to it yet: the newest block, and the one that is
    /// still being filled.
    fn up_to_now(&self) -> Option<Pass<T>> {
        let mut front = self.up_to_date()?;
        let Some([before, newest]) = self.blocks.newest() else { return Some(front) };
        if front.next() + 1 != self.blocks.len() {
            return Some(front);
        }
        let mut tail = Storage::<T, 3>::default();
        let noise = self.config.gyro_noise_rad_s;
        tail.push(before, noise);
        tail.push(newest, noise);
        if let Some(block) = self.open.and_then(|open| open.averager.block()) {
            tail.push(block, noise);
        }
        for index in 1..tail.len() {
            let Some(span) = tail.span(index, T::one() / self.typical_kg_m2) else { break };
            front.advance(&span);
            for _ in 0..3 {
                front.take_row();
            }
        }
        Some(front)
    }

    /// Whether gyro noise explains a sum of squares, rad²/s², of so many degrees of freedom.
    fn explains(&self, (sum, degrees): (T, u32)) -> bool {
        let variance = self.config.gyro_noise_rad_s * self.config.gyro_noise_rad_s;
        let (k, x) = (T::count(degrees), T::lit(REJECTED));
        let two = T::lit(2.0);
        sum <= variance * (k + two * (k * x).sqrt() + two * x)
    }

    /// Of all windows: see [`Pass::unexplained`].
    fn residuals(&self, front: &Pass<T>) -> (T, u32) {
        let (sum, degrees) = front.unexplained();
        (self.past.0 + sum, self.past.1.saturating_add(degrees))
    }

    /// Covariance of the elements, kg² m⁴. Neither an element nor a variance can be told more
    /// finely than it is rounded.
    fn covariance(&self, front: &Pass<T>, inertia: &Inertia<T>) -> Option<Mat<T, 6, 6>> {
        let unit = self.config.gyro_noise_rad_s * self.typical_kg_m2;
        let mut covariance = front.inertia_covariance()? * (unit * unit);
        for i in 0..6 {
            let rounded = inertia.elements_kg_m2()[i] * T::EPSILON;
            covariance[(i, i)] *= T::one() + T::EPSILON * T::lit(16.0);
            covariance[(i, i)] += rounded * rounded;
        }
        Some(covariance)
    }

    /// What is held while nothing has been found.
    fn nothing_yet(&self) -> Estimate<T> {
        let prior = self.config.prior.unwrap_or(Prior::unknown());
        let covariance = Mat::from_diagonal(&prior.sigma_kg_m2.map(|s| s * s).into());
        let inertia = Inertia::new(prior.inertia_kg_m2);
        Estimate::of_inertia(inertia, covariance, &prior.sigma_kg_m2, T::zero())
    }
}

impl<T: Real, const W: usize, const N: usize> Estimator<T, W> for Window<T, W, N> {
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
                self.open_at(reading);
                return Outcome::Reset(Reset::Gap);
            }
            Verdict::After { elapsed_us } => self.take_in(reading, T::seconds(elapsed_us)),
        }
        if self.past_is_contradicted() {
            self.forget();
            self.open_at(reading);
            return Outcome::Reset(Reset::Lockout);
        }
        self.work(reading);
        if self.front.is_some() { Outcome::Updated } else { Outcome::Coasting(Coasting::Aligning) }
    }

    fn estimate(&self) -> Estimate<T> {
        let Some(front) = self.up_to_now() else { return self.nothing_yet() };
        let Some(point) = front.solve() else { return self.nothing_yet() };
        let inertia = Inertia::new(point.inertia.map(|x| x * self.typical_kg_m2));
        let Some(covariance) = self.covariance(&front, &inertia) else { return self.nothing_yet() };
        let mean_moment = inertia.trace_kg_m2().abs() * T::lit(1.0 / 3.0);
        let range = self.config.prior.unwrap_or(Prior::of_size(mean_moment)).sigma_kg_m2;
        let residual = mean_square(self.residuals(&front)).sqrt();
        let estimate = Estimate::of_inertia(inertia, covariance, &range, residual);
        if self.explains(self.residuals(&front)) {
            estimate
        } else {
            Estimate { status: Status::Diverged, ..estimate }
        }
    }

    fn rate_rad_s(&self) -> Vec3<T> {
        self.rate_rad_s
    }

    fn innovation(&self) -> Option<Innovation<T>> {
        None
    }
}

/// Whether a pass from there has a chance: positive definite, and no larger than the unit allows.
fn is_plausible<T: Real>(point: &Point<T>) -> bool {
    Inertia::new(point.inertia).is_positive_definite()
        && point.inertia.iter().all(|x| x.abs() < T::lit(ASTRAY))
}

/// A sum of squares per degree of freedom; zero for none.
fn mean_square<T: Real>((sum, degrees): (T, u32)) -> T {
    if degrees == 0 { T::zero() } else { sum / T::count(degrees) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::test_flight::{TestFlight, tumbling_torque_n_m};
    use proptest::prelude::*;
    use std::vec::Vec;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    /// Of the test flight, which has none: rounding to single precision is far below it.
    const NOISE_RAD_S: f32 = 1e-5;

    fn flight(samples: u64) -> TestFlight<0> {
        TestFlight {
            inertia_kg_m2: INERTIA,
            initial_rate_rad_s: Vec3::new(0.01, -0.02, 0.03),
            wheels: WheelArray::new([], []).unwrap(),
            period_us: 100_000,
            samples,
        }
    }

    fn tumble(samples: u64) -> Vec<Sample<f32, 0>> {
        flight(samples).fly(|_| [], tumbling_torque_n_m)
    }

    fn window<const N: usize>(config: Config<f32>) -> Window<f32, 0, N> {
        Window::new(config, WheelArray::new([], []).unwrap()).unwrap()
    }

    fn fly<const N: usize>(config: Config<f32>, samples: &[Sample<f32, 0>]) -> Estimate<f32> {
        let mut window = window::<N>(config);
        for sample in samples {
            window.step(sample);
        }
        window.estimate()
    }

    fn worst_error(estimate: &Estimate<f32>) -> f64 {
        let found = estimate.inertia.elements_kg_m2().map(f64::from);
        (0..6).map(|i| (found[i] - INERTIA[i]).abs()).fold(0.0, f64::max)
    }

    /// Torque that is told only at its samples, 70 a period, and rounding.
    const EXACT: f64 = 1e-4;

    #[test]
    fn finds_the_inertia_without_a_guess() {
        let estimate = fly::<512>(Config::new(NOISE_RAD_S), &tumble(600));
        assert!(worst_error(&estimate) < EXACT, "{estimate:?}");
        assert_eq!((estimate.status, estimate.observed.directions), (Status::Converged, 6));
    }

    /// Storage for 64 blocks is merged, and then carried on, and says the same.
    #[test]
    fn little_storage_loses_next_to_nothing() {
        let estimate = fly::<64>(Config::new(1e-3), &tumble(2400));
        let all = fly::<512>(Config::new(1e-3), &tumble(2400));
        assert!(worst_error(&estimate) < 1e-3, "{estimate:?}");
        assert_eq!(estimate.status, Status::Converged);
        for i in 0..6 {
            let ratio = estimate.sigma_kg_m2()[i] / all.sigma_kg_m2()[i];
            assert!((0.95..1.1).contains(&ratio), "element {i}: {ratio}");
        }
    }

    /// Blocks too short to be merged, so that each window is carried into the next: five of them.
    #[test]
    fn windows_in_a_row_know_what_one_would() {
        let short = Config { block_turn_rad: 0.02, ..Config::new(NOISE_RAD_S) };
        let chained = fly::<128>(short, &tumble(900));
        let whole = fly::<512>(Config::new(NOISE_RAD_S), &tumble(900));
        assert!(worst_error(&chained) < EXACT, "{chained:?}");
        assert_eq!(chained.status, Status::Converged);
        for i in 0..6 {
            let ratio = chained.sigma_kg_m2()[i] / whole.sigma_kg_m2()[i];
            assert!((0.95..1.05).contains(&ratio), "element {i}: {ratio}");
        }
    }

    #[test]
    fn the_inertia_survives_a_gap() {
        let samples = tumble(900);
        let mut window = window::<512>(Config::new(NOISE_RAD_S));
        for sample in &samples[..450] {
            window.step(sample);
        }
        let before = window.estimate();
        assert_eq!(window.step(&samples[600]), Outcome::Reset(Reset::Gap));
        for sample in &samples[601..610] {
            window.step(sample);
        }
        let after_gap = window.estimate();
        for sample in &samples[610..] {
            window.step(sample);
        }
        let after = window.estimate();
        for i in 0..6 {
            assert!(
                after_gap.sigma_kg_m2()[i] < 1.01 * before.sigma_kg_m2()[i],
                "{:?} {:?}",
                after_gap.sigma_kg_m2(),
                before.sigma_kg_m2()
            );
            assert!(after.sigma_kg_m2()[i] < 0.95 * before.sigma_kg_m2()[i]);
        }
        assert!(worst_error(&after) < EXACT);
        assert_eq!(after.status, Status::Converged);
    }

    #[test]
    fn a_change_of_the_inertia_makes_all_start_anew() {
        let mut window = window::<512>(Config::new(NOISE_RAD_S));
        for sample in tumble(600) {
            window.step(&sample);
        }
        let heavier = TestFlight { inertia_kg_m2: [1.7, 1.2, 1.8, 0.1, -0.2, 0.05], ..flight(600) };
        let later = heavier.fly(|_| [], tumbling_torque_n_m);
        let outcomes: Vec<Outcome> = later
            .iter()
            .map(|s| window.step(&Sample { time_us: s.time_us + 600_000_000, ..*s }))
            .collect();
        assert_eq!(outcomes[0], Outcome::Reset(Reset::Gap));
        assert!(outcomes.contains(&Outcome::Reset(Reset::Lockout)));
        let found = window.estimate();
        assert!((found.inertia.elements_kg_m2()[0] - 1.7).abs() < EXACT as f32, "{found:?}");
        assert_eq!(found.status, Status::Converged);
    }

    #[test]
    fn a_turn_about_one_axis_shows_three_elements_and_no_confident_number_else() {
        let about_z = |t: f64| Vec3::new(0.0, 0.0, 0.02 * (0.4 * t).cos());
        let body = TestFlight {
            inertia_kg_m2: [1.5, 1.2, 1.8, 0.0, 0.0, 0.0],
            initial_rate_rad_s: Vec3::zeros(),
            ..flight(900)
        };
        let estimate = fly::<512>(Config::new(NOISE_RAD_S), &body.fly(|_| [], about_z));
        assert_eq!(estimate.observed.element, [false, false, true, false, true, true]);
        assert_eq!((estimate.status, estimate.observed.directions), (Status::Partial, 3));
        assert!((estimate.inertia.elements_kg_m2()[2] - 1.8).abs() < 1e-3);
        for i in [0, 1, 3] {
            assert!(estimate.sigma_kg_m2()[i] > 0.5, "{estimate:?}");
        }
    }

    #[test]
    fn without_torque_and_wheels_the_ratios_are_seen_and_the_scale_is_not() {
        let spinning = TestFlight { initial_rate_rad_s: Vec3::new(0.2, 0.3, -0.2), ..flight(900) };
        let estimate =
            fly::<512>(Config::new(NOISE_RAD_S), &spinning.fly(|_| [], |_| Vec3::zeros()));
        assert!(!estimate.observed.scale, "{estimate:?}");
        assert_eq!((estimate.status, estimate.observed.directions), (Status::Partial, 5));
        let (ratio, sigma) = estimate.over_trace();
        for i in 0..6 {
            let truth = INERTIA[i] / 4.5;
            assert!((f64::from(ratio[i]) - truth).abs() < 1e-3, "{ratio:?}");
            assert!(sigma[i] < 1e-2, "{sigma:?}");
        }
    }

    #[test]
    fn a_prior_fills_in_what_the_motion_does_not_show() {
        let about_z = |t: f64| Vec3::new(0.0, 0.0, 0.02 * (0.4 * t).cos());
        let body = TestFlight {
            inertia_kg_m2: [1.5, 1.2, 1.8, 0.0, 0.0, 0.0],
            initial_rate_rad_s: Vec3::zeros(),
            ..flight(900)
        };
        let prior = Prior { inertia_kg_m2: [1.4, 1.3, 1.6, 0.0, 0.0, 0.0], sigma_kg_m2: [0.2; 6] };
        let config = Config { prior: Some(prior), ..Config::new(NOISE_RAD_S) };
        let estimate = fly::<512>(config, &body.fly(|_| [], about_z));
        assert!((estimate.inertia.elements_kg_m2()[2] - 1.8).abs() < 1e-3, "{estimate:?}");
        for i in [0, 1] {
            let error = estimate.inertia.elements_kg_m2()[i] - prior.inertia_kg_m2[i];
            assert!(error.abs() < 1e-2, "{estimate:?}");
            assert!((estimate.sigma_kg_m2()[i] - 0.2).abs() < 1e-2, "{estimate:?}");
        }
    }

    #[test]
    fn a_torque_that_nobody_told_is_called_diverged() {
        let samples: Vec<_> = tumble(600)
            .into_iter()
            .map(|s| Sample { torque_n_m: s.torque_n_m + Vec3::new(2e-3, 0.0, 0.0), ..s })
            .collect();
        assert_eq!(fly::<512>(Config::new(NOISE_RAD_S), &samples).status, Status::Diverged);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_bits_leave_finite_numbers(
            bits in prop::collection::vec(prop::array::uniform6(any::<u32>()), 400),
            mild in any::<bool>(),
        ) {
            let mut window = window::<64>(Config::new(1e-3));
            for (k, b) in bits.iter().enumerate() {
                let f = b.map(|b| if mild { b as f32 * 1e-10 } else { f32::from_bits(b) });
                window.step(&Sample {
                    time_us: 100_000 * k as u64,
                    rate_rad_s: Vec3::new(f[0], f[1], f[2]),
                    wheel_speed_rad_s: [],
                    torque_n_m: Vec3::new(f[3], f[4], f[5]),
                    attitude: None,
                });
                if k % 50 == 0 {
                    let estimate = window.estimate();
                    prop_assert!(estimate.inertia.elements_kg_m2().iter().all(|x| x.is_finite()));
                    prop_assert!(estimate.covariance_kg2_m4.iter().all(|x| x.is_finite()));
                }
            }
        }
    }
}
