//! Linear start: shape and scale of the inertia from the blocks, without any guess.
//!
//! Angular momentum is constant in inertial axes but for the impulse of external torque. With C the
//! rotation from the window's start, which the measured rates give block by block,
//!
//! `C G(ω) n + κ (C h_w − ∫ C τ dt) − m₀ − ∫ C dt d = 0`
//!
//! is linear in the shape n, the inverse trace κ, the momentum m₀ and a disturbance torque d, all over the
//! trace. Givens rotations fold the rows into a triangle; its last six rows are the information on n with
//! the others eliminated.
//!
//! 1. *Shape.* `R n = 0` for tensors of unit trace. Noise of the rates inflates R: its expected share is
//!    removed from the singular values, so that it biases no direction.
//! 2. *Scale.* With n known, noisy momentum is regressed on the exact drive: noise does not bias κ either,
//!    and its sigma follows.

use super::belief::SHAPE_SIGMA;
use crate::blocks::block::Block;
use crate::blocks::stretch::{Rest, Stretch};
use crate::math::square_root_information::SquareRootInformation;
use crate::math::{
    Entries, Mat, Vec3, eigen::singular_values, norm, rotated, scalar::Real, skew, times,
};
use crate::tensor::{Inertia, regressor, regressor_noise_share};
use crate::trajectory::unknowns::{by_shape, over_trace};

/// Columns: momentum 3, torque 3, inverse trace 1, elements 6.
const COLUMNS: usize = 13;
const TORQUE: usize = 3;
const SCALE: usize = 6;
const ELEMENTS: usize = 7;
/// Sigmas by which the inverse trace must exceed zero.
const SCALE_OBSERVED: f64 = 5.0;
/// Principal moments over the trace of a physical tensor, with a margin: 0.002 to 0.498.
const MARGIN: f64 = 0.002;
/// Steps towards the sphere, of a tenth each: 0.9²⁰ = 0.12.
const SHRINKS: usize = 20;

/// Linear least squares over the blocks of a stretch.
#[derive(Clone, Copy, Debug)]
pub struct LinearStart<T: Real> {
    /// Next block.
    pub next: usize,
    /// True with a disturbance torque among the unknowns.
    pub has_torque: bool,
    factor: SquareRootInformation<T, COLUMNS>,
    /// Inertial axes of the start from body axes at the end of the last block.
    rotation: Mat<T, 3, 3>,
    /// `∫ C τ dt`, N m s, and `∫ C dt`, s.
    impulse: Vec3<T>,
    by_torque: Mat<T, 3, 3>,
    sizes: Sizes<T>,
    /// Sum over the rows of their weight over the number of samples.
    noise: T,
}

crate::persist!([T: Real] LinearStart<T> {
    next, has_torque, factor, rotation, impulse, by_torque, sizes, noise
});

/// Units in which all columns are near one.
#[derive(Clone, Copy, Debug)]
struct Sizes<T: Real> {
    rate_rad_s: T,
    drive_n_m_s: T,
    duration_s: T,
    /// Samples of a block of full weight: a long rest has no more influence than motion.
    samples: T,
}

crate::persist!([T: Real] Sizes<T> { rate_rad_s, drive_n_m_s, duration_s, samples });

/// Result.
#[derive(Clone, Copy, Debug)]
pub struct FirstPoint<T: Real> {
    /// Shape, disturbance torque over the trace (rad/s²), and unit scale.
    pub shape: [T; 5],
    pub torque: Vec3<T>,
    /// κ, 1/(kg m²), where it is observed.
    pub per_kg_m2: Option<T>,
}

impl<T: Real> LinearStart<T> {
    /// Start over these blocks; `has_torque` for a disturbance torque among the unknowns.
    #[inline(never)]
    pub fn new<'a, const W: usize>(
        blocks: impl Iterator<Item = &'a Block<T, W>>,
        axes: &Mat<T, 3, W>,
        start: &Stretch<T, W>,
        from: usize,
        usual_samples: T,
        has_torque: bool,
    ) -> Self {
        let square = |v: &Vec3<T>| v.dot(v);
        // Largest squares: over hundreds of blocks a root of each would take half of the time.
        let (mut rate, mut drive) = (square(&start.rest.rate_rad_s), T::zero());
        let (mut impulse, mut duration_s) = (T::zero(), T::zero());
        for block in blocks {
            let of_block = [square(&block.rate_rad_s), square(&(axes * block.wheels_n_m_s))];
            for (largest, of_block) in [&mut rate, &mut drive].into_iter().zip(of_block) {
                if of_block > *largest {
                    *largest = of_block;
                }
            }
            impulse += norm(&block.impulse_n_m_s);
            duration_s += block.duration_s;
        }
        let sizes = Sizes {
            rate_rad_s: rate.sqrt().max(T::lit(1e-12)),
            drive_n_m_s: drive.sqrt() + impulse,
            duration_s,
            samples: usual_samples + usual_samples,
        };
        Self {
            next: from,
            has_torque,
            factor: SquareRootInformation::default(),
            rotation: Mat::identity(),
            impulse: Vec3::zeros(),
            by_torque: Mat::zeros(),
            sizes,
            noise: T::zero(),
        }
    }

    /// Rows of the rest before the first block: to be added first.
    pub fn add_rest<const W: usize>(&mut self, rest: &Rest<T, W>, axes: &Mat<T, 3, W>) {
        if rest.weight > T::zero() {
            let one = Mat::identity();
            let wheels = axes * rest.wheels_n_m_s;
            self.add_rows(&one, &rest.rate_rad_s, &wheels, &Mat::zeros(), rest.weight);
        }
    }

    /// Takes in the next block.
    #[inline(never)]
    pub fn take<const W: usize>(&mut self, block: &Block<T, W>, axes: &Mat<T, 3, W>) {
        let half = T::lit(0.5);
        let turn = block.rate_rad_s * (block.duration_s * half);
        let half_way = rotation(&turn);
        let middle = times(&self.rotation, &half_way);
        let quarter = times(&self.rotation, &rotation(&(turn * half)));
        let impulse = self.impulse + rotated(&quarter, &block.impulse_n_m_s) * half;
        let by_torque = self.by_torque + middle * (block.duration_s * half);
        let drive = block.drive_n_m_s(axes) - rotated(&middle.transpose(), &impulse);
        if !block.is_hole() {
            self.add_rows(&middle, &block.rate_rad_s, &drive, &by_torque, block.weight);
        }
        self.impulse += rotated(&middle, &block.impulse_n_m_s);
        self.by_torque += middle * block.duration_s;
        self.rotation = times(&middle, &half_way);
        self.next += 1;
    }

    fn add_rows(
        &mut self,
        middle: &Mat<T, 3, 3>,
        rate: &Vec3<T>,
        drive: &Vec3<T>,
        by_torque: &Mat<T, 3, 3>,
        samples: T,
    ) {
        let Sizes { rate_rad_s, drive_n_m_s, duration_s, samples: most } = self.sizes;
        let weight = samples.min(most) / most;
        self.noise += weight / samples;
        let momentum = middle * regressor(&(rate * (T::one() / rate_rad_s)));
        let drive = if drive_n_m_s > T::zero() {
            rotated(middle, drive) * (T::one() / drive_n_m_s)
        } else {
            Vec3::zeros()
        };
        for i in 0..3 {
            let mut row = [T::zero(); COLUMNS];
            row[i] = -T::one();
            if self.has_torque {
                for k in 0..3 {
                    row[TORQUE + k] = -by_torque.at(i, k) / duration_s;
                }
            }
            row[SCALE] = drive.at(i, 0);
            for k in 0..6 {
                row[ELEMENTS + k] = momentum.at(i, k);
            }
            self.factor.fold(&row, T::zero(), weight);
        }
    }

    /// Shape, torque and scale, for gyro noise of one sigma per sample, rad/s.
    #[inline(never)]
    pub fn conclude(&self, noise_rad_s: T) -> FirstPoint<T> {
        let noise = noise_rad_s / self.sizes.rate_rad_s;
        let shape = self.shape(noise);
        let n = over_trace(&shape);
        let (x, sigma) = self.scale(&n, noise);
        let is_observed = x > sigma * T::lit(SCALE_OBSERVED);
        let x = if is_observed { x } else { T::zero() };
        let torque = self.torque(x, &n) * (self.sizes.rate_rad_s / self.sizes.duration_s);
        let per_kg_m2 = x * self.sizes.rate_rad_s / self.sizes.drive_n_m_s;
        let is_finite = torque.iter().all(|x| x.is_finite());
        FirstPoint {
            shape,
            torque: if is_finite { torque } else { Vec3::zeros() },
            per_kg_m2: (is_observed && per_kg_m2.is_finite()).then_some(per_kg_m2),
        }
    }

    /// Shape that minimises `|R n|²` after removal of the noise share, with a weak belief in the sphere.
    fn shape(&self, noise: T) -> [T; 5] {
        // Noise of unit variance in each column.
        let root = |element: usize| regressor_noise_share::<T>(element).sqrt();
        let lower = Mat::<T, 6, 6>::from_fn(|i, k| {
            let row = &self.factor.factor[ELEMENTS + i];
            let u = if i == k { T::one() } else { row[ELEMENTS + k] };
            row[ELEMENTS + i].sqrt() * u / root(k)
        });
        let (values, v) = singular_values(&lower);
        let least = values.iter().fold(T::MAX, |least, x| least.min(*x));
        let share = (noise * noise * self.noise).min(least * least);
        let mut system = SquareRootInformation::<T, 5>::default();
        for i in 0..6 {
            let value = (values[i] * values[i] - share).max(T::zero()).sqrt();
            let of_elements: [T; 6] = core::array::from_fn(|k| v.at(k, i) * root(k) * value);
            let trace = of_elements[0] + of_elements[1] + of_elements[2];
            system.fold(&by_shape(&of_elements), -trace * T::lit(1.0 / 3.0), T::one());
        }
        // A row's noise is σ |n|, about σ / 3.
        let row_noise = (noise / self.sizes.samples.sqrt()).max(T::lit(1e-6)) * T::lit(1.0 / 3.0);
        let belief = row_noise * T::lit(1.0 / SHAPE_SIGMA);
        for k in 0..5 {
            let mut row = [T::zero(); 5];
            row[k] = belief;
            system.fold(&row, T::zero(), T::one());
        }
        nearer_the_sphere(system.solve().unwrap_or([T::zero(); 5]))
    }

    /// Inverse trace in units of the columns for a known shape, and one sigma of it.
    fn scale(&self, n: &[T; 6], noise: T) -> (T, T) {
        let row = &self.factor.factor[SCALE];
        let root = row[SCALE].sqrt();
        if root < T::lit(1e-6) {
            return (T::zero(), T::one());
        }
        let mut x = T::zero();
        for k in 0..6 {
            x -= row[ELEMENTS + k] * n[k];
        }
        let n = Inertia::new(*n).matrix_kg_m2();
        let size = n.iter().fold(T::zero(), |sum, x| sum + *x * *x).sqrt();
        (x, noise / self.sizes.samples.sqrt() * size / root)
    }

    /// Disturbance torque in units of its columns for known scale and shape.
    fn torque(&self, x: T, n: &[T; 6]) -> Vec3<T> {
        let mut torque = Vec3::zeros();
        if !self.has_torque {
            return torque;
        }
        for i in (0..3).rev() {
            let row = &self.factor.factor[TORQUE + i];
            let mut value = -row[SCALE] * x;
            for k in 0..6 {
                value -= row[ELEMENTS + k] * n[k];
            }
            for k in i + 1..3 {
                value -= row[TORQUE + k] * torque.at(k, 0);
            }
            *torque.at_mut(i, 0) = if row[TORQUE + i] > T::lit(1e-12) { value } else { T::zero() };
        }
        torque
    }
}

/// Shrinks a shape towards the sphere until its tensor is physical with a margin.
fn nearer_the_sphere<T: Real>(mut shape: [T; 5]) -> [T; 5] {
    for _ in 0..SHRINKS {
        if is_inside(&over_trace(&shape)) {
            return shape;
        }
        shape = shape.map(|q| q * T::lit(0.9));
    }
    [T::zero(); 5]
}

/// True where all principal moments over the trace lie between the margins.
fn is_inside<T: Real>(n: &[T; 6]) -> bool {
    let margin = T::lit(MARGIN);
    let most = T::lit(0.5) - margin;
    let [xx, yy, zz, xy, xz, yz] = *n;
    Inertia::new([xx - margin, yy - margin, zz - margin, xy, xz, yz]).is_positive_definite()
        && Inertia::new([most - xx, most - yy, most - zz, -xy, -xz, -yz]).is_positive_definite()
}

/// Rotation by a vector of up to one radian: `1 + a v^× + b v^× v^×`, with the series of `sin φ / φ` and
/// `(1 − cos φ) / φ²` to φ¹⁰, an error of 3e-9 at one radian.
fn rotation<T: Real>(v: &Vec3<T>) -> Mat<T, 3, 3> {
    let s = v.dot(v);
    // In single precision each coefficient is a literal: a conversion would be a library call.
    let series = |c: [T; 5]| c.iter().rev().fold(T::zero(), |sum, c| *c - s * sum);
    let inverse = |n: f64| T::lit(1.0 / n);
    let a = series([T::one(), inverse(6.0), inverse(120.0), inverse(5040.0), inverse(362_880.0)]);
    let b = [T::lit(0.5), inverse(24.0), inverse(720.0), inverse(40320.0), inverse(3_628_800.0)];
    let b = series(b);
    let cross = skew(v);
    Mat::identity() + cross * a + times(&cross, &cross) * b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotation about z against sine and cosine.
    #[test]
    fn a_rotation_agrees_with_its_angle() {
        for angle in [1e-3f64, 0.3, 1.0] {
            let r = rotation(&Vec3::new(0.0, 0.0, angle));
            assert!(
                (r[(0, 0)] - angle.cos()).abs() < 4e-9 && (r[(1, 0)] - angle.sin()).abs() < 4e-8
            );
        }
    }

    #[test]
    fn a_shape_outside_is_drawn_to_the_sphere() {
        let shape = nearer_the_sphere([0.5f64, 0.0, 0.0, 0.0, 0.0]);
        let n = over_trace(&shape);
        assert!(is_inside(&n) && shape[0] > 0.1);
    }
}
