//! A first estimate from nothing: linear least squares on the conservation of momentum.
//!
//! The gyro itself, integrated, tells how the body has turned since the window opened: C takes
//! body axes to the axes of that instant, `Ċ = C ω^×`. Total momentum changes there only by
//! external torque, which makes an equation linear in the inertia `j` and the initial momentum H₀:
//!
//! `G(ω) j − Cᵀ H₀ − Cᵀ ∫ C dt τ_d − β = Cᵀ ∫ C τ dt − h_w`
//!
//! with a disturbance torque τ_d and, for a gyro bias b, `β = J b`, where they are among the unknowns
//! (what b does to C is left to Gauss-Newton). Nothing is differentiated, no initial guess exists, and since the measured turn is used, none
//! is lost however far the body turns. Gyro noise v enters the regressor and biases `j` by many
//! sigmas unless its expectation is taken out: `E[G(v)ᵀ G(v)] = σ² diag(1 1 1 2 2 2)` per row of
//! unit weight. (The noise in C, an angle random walk, is left in: it is what Gauss-Newton
//! then removes.)

use super::block::Reading;
use super::solution::{Hold, hard};
use super::unknowns::{BIAS, DRAG, MOMENTUM, TORQUE, has_bias, has_torque, inertia_of};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{Mat, Vec3, scalar::Real};
use crate::tensor::{Inertia, regressor_noise_share};

/// Passes over the noise correction. Each shrinks its error by [`LARGEST_CORRECTION`] or more:
/// eight leave 3e-6 of the correction.
const CORRECTION_PASSES: usize = 8;

/// The noise's share of the information in any element, at most. From a half on the correction
/// wouldn't converge; already from a third on, what is left of the motion is as uncertain as the noise
/// that a hundred blocks happen to have.
const LARGEST_CORRECTION: f64 = 0.2;

/// So many of them in a slice, which makes it about a row's work.
const CORRECTIONS_PER_SLICE: usize = 4;

/// Motion that is so many times the noise stands out clearly.
const CLEAR: f64 = 30.0;

/// Samples of a block's rows at least, and how many blocks there are before it is twice as many: rows cost
/// as much as half a block of a pass, and where the body turns fast blocks end every sample or two.
const FEW_SAMPLES: u32 = 4;
const MANY_ROWS: u32 = 32;

/// An element whose sigma is above this share of the mean moment is too vague to start from.
const VAGUE: f64 = 0.2;

/// Accumulates the equation, three rows a block, into a square-root information factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearStart<T: Real, const U: usize> {
    information: SquareRootInformation<T, U>,
    rows: u32,
    /// C at the newest reading.
    attitude: Mat<T, 3, 3>,
    /// `∫ C τ dt` and `∫ C dt` up to the newest reading.
    impulse_n_m_s: Vec3<T>,
    push_s: Mat<T, 3, 3>,
    newest: Reading<T>,
    /// Sums over the block so far: of ω, of Cᵀ, of Cᵀ ∫ C dt, and of the right-hand side.
    samples: u32,
    sum_rate: Vec3<T>,
    sum_attitude: Mat<T, 3, 3>,
    sum_push_s: Mat<T, 3, 3>,
    sum_momentum: Vec3<T>,
}

crate::persist!([T: Real, const U: usize] LinearStart<T, U> {
    information, rows, attitude, impulse_n_m_s, push_s, newest, samples, sum_rate, sum_attitude,
    sum_push_s, sum_momentum
});

/// What the equation says of the unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T: Real> {
    /// H₀, N m s, in the body axes of that instant.
    pub momentum_n_m_s: Vec3<T>,
    /// τ_d, N m.
    pub torque_n_m: Vec3<T>,
    /// b, rad/s.
    pub bias_rad_s: Vec3<T>,
    /// Inertia, noise bias removed.
    pub inertia: Inertia<T>,
}

impl<T: Real> Solution<T> {
    fn of<const U: usize>(x: &[T; U]) -> Self {
        let three = |at: usize| Vec3::new(x[at], x[at + 1], x[at + 2]);
        let none = Vec3::zeros();
        let inertia = Inertia::new(core::array::from_fn(|i| x[inertia_of(U) + i]));
        let beta = if has_bias(U) { three(BIAS) } else { none };
        Self {
            momentum_n_m_s: three(MOMENTUM),
            torque_n_m: if has_torque(U) { three(TORQUE) } else { none },
            bias_rad_s: inertia.inverse().map_or(none, |inverse| inverse * beta),
            inertia,
        }
    }
}

/// How torque and bias are held beside the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Holds<T> {
    /// N m.
    pub torque: Hold<T>,
    /// rad/s.
    pub bias: Hold<T>,
}

impl<T: Real, const U: usize> LinearStart<T, U> {
    /// Starts at the first reading.
    pub fn new(first: Reading<T>) -> Self {
        let mut this = Self {
            information: SquareRootInformation::default(),
            rows: 0,
            attitude: Mat::identity(),
            impulse_n_m_s: Vec3::zeros(),
            push_s: Mat::zeros(),
            newest: first,
            samples: 0,
            sum_rate: Vec3::zeros(),
            sum_attitude: Mat::zeros(),
            sum_push_s: Mat::zeros(),
            sum_momentum: Vec3::zeros(),
        };
        this.sum();
        this
    }

    /// Takes in the next reading, `elapsed_s` after the last.
    #[inline(never)]
    pub fn add(&mut self, reading: Reading<T>, elapsed_s: T) {
        let (half, last) = (T::lit(0.5), self.newest);
        let (w0, w1) = (last.rate_rad_s, reading.rate_rad_s);
        // The turn of a rate that changes linearly, to third order: the cross product is what a
        // turn of its axis adds (coning).
        let turn = (w0 + w1) * (elapsed_s * half)
            + w0.cross(&w1) * (elapsed_s * elapsed_s * T::lit(1.0 / 12.0));
        let before = self.attitude * last.torque_n_m;
        let attitude_before = self.attitude;
        self.attitude *= rotation(&turn);
        if has_torque(U) {
            self.push_s += (attitude_before + self.attitude) * (elapsed_s * half);
        }
        let after = self.attitude * reading.torque_n_m;
        self.impulse_n_m_s += (before + after) * (elapsed_s * half);
        self.newest = reading;
        self.sum();
    }

    fn sum(&mut self) {
        let back = self.attitude.transpose();
        self.samples += 1;
        self.sum_rate += self.newest.rate_rad_s;
        self.sum_attitude += back;
        if has_torque(U) {
            self.sum_push_s += back * self.push_s;
        }
        self.sum_momentum += back * self.impulse_n_m_s - self.newest.wheel_momentum_n_m_s;
    }

    /// Whether its rows are due: they go with a block, but of a few samples at least, and of more once
    /// there are many of them. What was averaged is exact however far the body turned meanwhile.
    pub fn is_due(&self) -> bool {
        self.samples >= if self.rows < MANY_ROWS { FEW_SAMPLES } else { 2 * FEW_SAMPLES }
    }

    /// Makes three rows of the readings since the last block, as many as `samples` tells.
    #[inline(never)]
    pub fn close_block(&mut self) {
        // Means would have the weight n, sums have one of its inverse.
        let weight = T::one() / T::count(self.samples);
        let w = &self.sum_rate;
        let o = T::zero();
        let g = [[w.x, o, o, w.y, w.z, o], [o, w.y, o, w.x, o, w.z], [o, o, w.z, o, w.x, w.y]];
        for r in 0..3 {
            let mut row = [T::zero(); U];
            for c in 0..3 {
                row[MOMENTUM + c] = -self.sum_attitude[(r, c)];
                if has_torque(U) {
                    row[TORQUE + c] = -self.sum_push_s[(r, c)];
                }
            }
            if has_bias(U) {
                row[BIAS + r] = -T::count(self.samples);
            }
            row[inertia_of(U)..].copy_from_slice(&g[r]);
            self.information.add_weighted(&row, self.sum_momentum[r], weight);
        }
        self.rows += 1;
        self.samples = 0;
        self.sum_rate = Vec3::zeros();
        self.sum_attitude = Mat::zeros();
        self.sum_push_s = Mat::zeros();
        self.sum_momentum = Vec3::zeros();
        // One Newton step keeps C orthogonal against rounding.
        let error =
            Mat::<T, 3, 3>::identity() * T::lit(3.0) - self.attitude.transpose() * self.attitude;
        self.attitude *= error * T::lit(0.5);
    }

    /// Size of the inertia along the motion, kg m²: the sphere that explains it best, noise bias
    /// removed. `None` where nothing drives the body, or the motion doesn't stand out of the noise.
    pub fn size_kg_m2(&self, noise_rad_s: T) -> Option<T> {
        // A sphere adds up the columns of the three moments. Equations after those of the momentum don't
        // depend on it.
        let (mut information, mut y) = (T::zero(), T::zero());
        for i in MOMENTUM + 3..U {
            let (row, right, weight) = self.information.equation(i);
            let first = inertia_of(U);
            let sum = row[first] + row[first + 1] + row[first + 2];
            information += weight * sum * sum;
            y += weight * sum * right;
        }
        let noise = noise_rad_s * noise_rad_s * T::count(self.rows) * T::lit(3.0) / information;
        let size = y / information / (T::one() - noise);
        (noise < T::lit(LARGEST_CORRECTION) && size > T::zero() && size.is_finite()).then_some(size)
    }

    /// Whether the motion stands so clearly out of the noise that its bias needn't be removed.
    pub fn is_clear(&self, noise_rad_s: T) -> bool {
        // The columns of the moments hold the squares of the rates, and of their noise.
        let squares = (0..3)
            .fold(T::zero(), |sum, i| sum + self.information.column_square(inertia_of(U) + i));
        let noise_square = noise_rad_s * noise_rad_s * T::count(self.rows);
        squares >= noise_square * T::lit(CLEAR * CLEAR)
    }
}

/// What a solution is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Of motion that shows all of the inertia above the noise, whose bias is removed.
    Driven,
    /// Of motion that nothing drives, which shows the inertia only up to its scale: momentum and
    /// inertia of mean moment 1 kg m².
    Homogeneous,
}

crate::persist!([] enum Kind { 0 => Driven, 1 => Homogeneous });

/// A solution in the making, in slices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solving<T: Real> {
    kind: Kind,
    stage: Stage,
    /// Size of the inertia, kg m².
    size_kg_m2: T,
    /// The six elements by the data alone, and with the noise's bias removed so far.
    biased: [T; 6],
    corrected: [T; 6],
    variances: [T; 6],
}

crate::persist!([T: Real] Solving<T> { kind, stage, size_kg_m2, biased, corrected, variances });

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Unknown of this index is to be held.
    Hold(usize),
    /// The six elements are to be looked at.
    Weigh,
    /// So many corrections are done.
    Correct(usize),
    /// All unknowns are to be solved for.
    Finish,
}

crate::persist!([] enum Stage {
    0 => Hold(index: usize), 1 => Weigh, 2 => Correct(done: usize), 3 => Finish
} if |this| !matches!(this, Self::Correct(done) if *done > CORRECTION_PASSES));

/// What became of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found<T: Real> {
    /// More slices are needed.
    NotYet,
    /// The motion doesn't determine all of the inertia above the noise.
    Nothing,
    /// This.
    Start(Solution<T>),
}

impl<T: Real> Solving<T> {
    /// Begins, in room for a factor, for white gyro noise of `noise_rad_s` per sample.
    pub fn begin<const U: usize>(
        kind: Kind,
        linear: &LinearStart<T, U>,
        noise_rad_s: T,
        room: &mut SquareRootInformation<T, U>,
    ) -> Self {
        *room = linear.information;
        let none = [T::zero(); 6];
        Self {
            kind,
            stage: Stage::Hold(TORQUE),
            size_kg_m2: linear.size_kg_m2(noise_rad_s).unwrap_or(T::zero()),
            biased: none,
            corrected: none,
            variances: none,
        }
    }

    /// One slice of work, in the same room.
    pub fn work<const U: usize>(
        &mut self,
        linear: &LinearStart<T, U>,
        noise_rad_s: T,
        holds: &Holds<T>,
        room: &mut SquareRootInformation<T, U>,
    ) -> Found<T> {
        let noise_information = noise_rad_s * noise_rad_s * T::count(linear.rows);
        let share = |i: usize| noise_information * regressor_noise_share(i);
        match (self.stage, self.kind) {
            (Stage::Hold(index), _) if index < inertia_of(U) => {
                self.hold(index, noise_rad_s, holds, room);
                self.stage = Stage::Hold(index + 1);
            }
            (Stage::Hold(_), Kind::Driven) => self.stage = Stage::Weigh,
            (Stage::Hold(_), Kind::Homogeneous) => {
                let first = inertia_of(U);
                let mut trace = [T::zero(); U];
                trace[first..first + 3].fill(T::one());
                room.add_weighted(&trace, T::lit(3.0), room.column_square(first));
                self.stage = Stage::Finish;
            }
            (Stage::Weigh, _) => {
                let six = room.last::<6>();
                let (Some(variances), Some(biased)) = (six.variances(), six.solve()) else {
                    return Found::Nothing;
                };
                let is_small = |i: usize| share(i) * variances[i] < T::lit(LARGEST_CORRECTION);
                if !(0..6).all(is_small) {
                    return Found::Nothing;
                }
                (self.variances, self.biased, self.corrected) = (variances, biased, biased);
                self.stage = Stage::Correct(0);
            }
            (Stage::Correct(done), _) if done < CORRECTION_PASSES => {
                let six = room.last::<6>();
                for _ in 0..CORRECTIONS_PER_SLICE {
                    let b = core::array::from_fn(|i| share(i) * self.corrected[i]);
                    let Some(correction) = six.solve_normal(&b) else { return Found::Nothing };
                    self.corrected = core::array::from_fn(|i| self.biased[i] + correction[i]);
                }
                self.stage = Stage::Correct(done + CORRECTIONS_PER_SLICE);
            }
            (Stage::Correct(_), _) => self.stage = Stage::Finish,
            (Stage::Finish, Kind::Driven) => {
                return self.driven(noise_rad_s, room).map_or(Found::Nothing, Found::Start);
            }
            (Stage::Finish, Kind::Homogeneous) => {
                return homogeneous(room).map_or(Found::Nothing, Found::Start);
            }
        }
        Found::NotYet
    }

    fn hold<const U: usize>(
        &self,
        index: usize,
        noise_rad_s: T,
        holds: &Holds<T>,
        room: &mut SquareRootInformation<T, U>,
    ) {
        // The equation is in N m s, where the noise is that of the rate times the inertia. Drag isn't
        // looked for here.
        let (hold, unit) = match index {
            ..BIAS => (&holds.torque, self.size_kg_m2),
            BIAS..DRAG => (&holds.bias, T::one()),
            _ => (&Hold::AtZero, T::one()),
        };
        let weight = match (hold, self.kind) {
            (Hold::Within(sigma), Kind::Driven) => {
                let weight = noise_rad_s * unit / *sigma;
                weight * weight
            }
            _ => hard(room.column_square(index)),
        };
        let mut row = [T::zero(); U];
        row[index] = T::one();
        room.add_weighted(&row, T::zero(), weight);
    }

    /// All unknowns for elements that the noise's bias is removed from.
    fn driven<const U: usize>(
        &self,
        noise_rad_s: T,
        room: &mut SquareRootInformation<T, U>,
    ) -> Option<Solution<T>> {
        let x = room.solve_with_last(&self.corrected)?;
        let solution = Solution::of(&x);
        let trace = solution.inertia.trace_kg_m2();
        let row_sigma = noise_rad_s * trace * T::lit(1.0 / 3.0);
        let largest = trace * T::lit(VAGUE / 3.0);
        let is_sharp = |i: usize| self.variances[i] * row_sigma * row_sigma < largest * largest;
        (0..6).all(is_sharp).then_some(solution)
    }
}

fn homogeneous<T: Real, const U: usize>(room: &SquareRootInformation<T, U>) -> Option<Solution<T>> {
    let x = room.solve()?;
    let first = inertia_of(U);
    let scale = T::lit(3.0) / (x[first] + x[first + 1] + x[first + 2]);
    let is_positive = scale > T::zero() && scale < T::one() / T::EPSILON;
    is_positive.then(|| Solution::of(&x.map(|x| x * scale)))
}

/// The rotation by a vector of less than a radian: `1 + (1 − φ²/6 + φ⁴/120) φ^× + (½ − φ²/24 +
/// φ⁴/720) φ^× φ^×`, whose error is below `φ⁷ / 5040`.
fn rotation<T: Real>(turn_rad: &Vec3<T>) -> Mat<T, 3, 3> {
    let square = turn_rad.dot(turn_rad);
    let a = T::one() - square * (T::lit(1.0 / 6.0) - square * T::lit(1.0 / 120.0));
    let b = T::lit(0.5) - square * (T::lit(1.0 / 24.0) - square * T::lit(1.0 / 720.0));
    // φ^× φ^× = φ φᵀ − φ² 1.
    let (x, y, z) = (turn_rad.x, turn_rad.y, turn_rad.z);
    let c = T::one() - square * b;
    let (ax, ay, az) = (a * x, a * y, a * z);
    let (bx, by, bz) = (b * x, b * y, b * z);
    let (xy, xz, yz) = (bx * y, bx * z, by * z);
    Mat::<T, 3, 3>::new(
        c + bx * x,
        xy - az,
        xz + ay, //
        xy + az,
        c + by * y,
        yz - ax, //
        xz - ay,
        yz + ax,
        c + bz * z,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::skew;

    const INERTIA: [f64; 6] = [1.5, 1.2, 1.8, 0.1, -0.2, 0.05];
    const PERIOD_S: f64 = 0.01;

    fn solve<T: Real>(start: &LinearStart<T, 9>, noise_rad_s: f64) -> Option<Solution<T>> {
        let noise_rad_s = T::lit(noise_rad_s);
        let mut room = SquareRootInformation::default();
        let mut solving = Solving::begin(Kind::Driven, start, noise_rad_s, &mut room);
        let holds = Holds { torque: Hold::AtZero, bias: Hold::AtZero };
        loop {
            match solving.work(start, noise_rad_s, &holds, &mut room) {
                Found::NotYet => {}
                Found::Nothing => return None,
                Found::Start(found) => return Some(found),
            }
        }
    }

    /// A body that turns by several radians, driven by a torque that makes it do so: its
    /// momentum is integrated with steps a tenth of a sample.
    fn fly<T: Real>(seconds: f64) -> LinearStart<T, 9> {
        let body = Inertia::new(INERTIA);
        let (j, inverse) = (body.matrix_kg_m2(), body.inverse().unwrap());
        let wheels = |t: f64| Vec3::new(0.0, 0.4 * (1.3 * t).sin(), 0.1);
        let torque = |t: f64| Vec3::new(0.3 * (0.9 * t).sin(), 0.0, 0.2 * (0.5 * t).cos());
        let cast = |v: Vec3<f64>| Vec3::from_fn(|i, _| T::lit(v[i]));
        let mut h = j * Vec3::new(0.3, -0.5, 0.2) + wheels(0.0);
        let reading = |t: f64, h: Vec3<f64>| Reading {
            rate_rad_s: cast(inverse * (h - wheels(t))),
            wheel_momentum_n_m_s: cast(wheels(t)),
            torque_n_m: cast(torque(t)),
        };
        let mut start = LinearStart::new(reading(0.0, h));
        let fine = PERIOD_S / 10.0;
        for k in 0..(seconds / PERIOD_S) as u32 {
            for i in 0..10 {
                let t = f64::from(k) * PERIOD_S + f64::from(i) * fine;
                let slope =
                    |t: f64, h: Vec3<f64>| torque(t) - (inverse * (h - wheels(t))).cross(&h);
                let half_way = h + slope(t, h) * (fine / 2.0);
                h += slope(t + fine / 2.0, half_way) * fine;
            }
            if k % 5 == 4 {
                start.close_block();
            }
            start.add(reading(f64::from(k + 1) * PERIOD_S, h), T::lit(PERIOD_S));
        }
        start
    }

    /// Trapezoids at this step: (0.01 s)² / 12 times second derivatives near 1.
    const TRAPEZOID: f64 = 1e-4;

    #[test]
    fn finds_the_inertia_without_a_guess_in_both_precisions() {
        let double = solve(&fly::<f64>(20.0), 1e-6).unwrap().inertia.elements_kg_m2();
        let single = solve(&fly::<f32>(20.0), 1e-6).unwrap().inertia.elements_kg_m2();
        for i in 0..6 {
            assert!((double[i] - INERTIA[i]).abs() < TRAPEZOID, "{double:?}");
            assert!((f64::from(single[i]) - INERTIA[i]).abs() < TRAPEZOID, "{single:?}");
        }
    }

    #[test]
    fn says_nothing_before_the_motion_stands_out_of_the_noise() {
        assert!(solve(&fly::<f64>(0.1), 1e-2).is_none());
        assert!(solve(&fly::<f64>(20.0), 10.0).is_none());
    }

    #[test]
    fn the_size_along_the_motion_is_that_of_the_body() {
        let size = fly::<f64>(20.0).size_kg_m2(1e-6).unwrap();
        assert!(size > 1.0 && size < 2.0, "{size}");
    }

    #[test]
    fn rotation_is_the_exponential_of_the_cross_product() {
        let turn = Vec3::new(0.3, -0.4, 0.5);
        let (mut power, mut sum) = (Mat::<f64, 3, 3>::identity(), Mat::<f64, 3, 3>::identity());
        for n in 1..20 {
            power = power * skew(&turn) / f64::from(n);
            sum += power;
        }
        // φ⁷ / 5040.
        assert!((rotation(&turn) - sum).abs().max() < 2e-5);
    }
}
