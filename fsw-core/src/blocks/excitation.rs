//! Detector of motion: end of a manoeuvre and beginning of the next one.
//!
//! Blocks are averaged over stretches. A stretch is quiet if its mean rate, its drive, and the impulse of the
//! external torque differ from those of the reference, an earlier stretch, by less than the gyro's noise resolves.
//! A stretch that is not quiet becomes the reference. The motion ends after [`QUIET_STRETCHES`] quiet ones in a row. It
//! begins again with the first block that differs from the reference, or with a stretch whose drive does. A
//! change of rate without a drive is a disturbance, not a manoeuvre.

use super::block::{Block, REFUSED_WEIGHT};
use crate::math::{Mat, Vec3, scalar::Real};

/// Blocks in a stretch. Their mean has a quarter of a block's noise, so that slow motion exceeds it.
const STRETCH_BLOCKS: u32 = 16;
/// Quiet stretches in a row, at least, that end a motion.
const QUIET_STRETCHES: u32 = 4;
/// Squared difference over its variance from which on there is a change: chi-square of three degrees of freedom
/// exceeds it once in 10⁵.
const CHANGED: f64 = 26.0;

/// Detector of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excitation<T: Real> {
    reference: Option<Mean<T>>,
    /// External torque since the reference, N m s.
    impulse_n_m_s: Vec3<T>,
    sum: Mean<T>,
    quiet_stretches: u32,
    quiet_s: T,
    is_driven: bool,
}

crate::persist!([T: Real] Excitation<T> {
    reference, impulse_n_m_s, sum, quiet_stretches, quiet_s, is_driven
});

/// Means over a stretch; while it fills, sums.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mean<T: Real> {
    blocks: u32,
    weight: T,
    duration_s: T,
    rate_rad_s: Vec3<T>,
    drive_n_m_s: Vec3<T>,
    impulse_n_m_s: Vec3<T>,
}

crate::persist!([T: Real] Mean<T> {
    blocks, weight, duration_s, rate_rad_s, drive_n_m_s, impulse_n_m_s
});

impl<T: Real> Mean<T> {
    fn empty() -> Self {
        let (blocks, weight, o) = (0, T::zero(), Vec3::zeros());
        let duration_s = T::zero();
        Self { blocks, weight, duration_s, rate_rad_s: o, drive_n_m_s: o, impulse_n_m_s: o }
    }

    fn of<const W: usize>(block: &Block<T, W>, axes: &Mat<T, 3, W>) -> Self {
        Self {
            blocks: 1,
            weight: block.weight,
            duration_s: block.duration_s,
            rate_rad_s: block.rate_rad_s,
            drive_n_m_s: block.drive_n_m_s(axes),
            impulse_n_m_s: block.impulse_n_m_s,
        }
    }

    fn add<const W: usize>(&mut self, block: &Block<T, W>, axes: &Mat<T, 3, W>) {
        self.blocks += 1;
        self.weight += block.weight;
        self.duration_s += block.duration_s;
        self.rate_rad_s += block.rate_rad_s;
        self.drive_n_m_s += block.drive_n_m_s(axes);
        self.impulse_n_m_s += block.impulse_n_m_s;
    }

    fn of_sums(mut self) -> Self {
        let share = T::one() / T::count(self.blocks.max(1));
        self.rate_rad_s *= share;
        self.drive_n_m_s *= share;
        self
    }

    /// Changes since `before`, for a body of this inertia: of the rate, and of the drive.
    fn differs(&self, before: &Self, noise_rad_s: T, inertia_kg_m2: T) -> (bool, bool) {
        let share = |m: &Self| T::one() / m.weight.max(T::lit(REFUSED_WEIGHT));
        let variance = noise_rad_s * noise_rad_s * (share(self) + share(before));
        let per = T::one() / inertia_kg_m2;
        let moved = |x: Vec3<T>| x.dot(&x) > variance * T::lit(CHANGED);
        let is_driven =
            moved((self.drive_n_m_s - before.drive_n_m_s) * per) || moved(self.impulse_n_m_s * per);
        (moved(self.rate_rad_s - before.rate_rad_s), is_driven)
    }
}

impl<T: Real> Excitation<T> {
    /// Detector that assumes motion.
    pub fn new() -> Self {
        Self {
            reference: None,
            impulse_n_m_s: Vec3::zeros(),
            sum: Mean::empty(),
            quiet_stretches: 0,
            quiet_s: T::zero(),
            is_driven: false,
        }
    }

    /// Takes in a block, for a body of this inertia.
    pub fn add<const W: usize>(
        &mut self,
        block: &Block<T, W>,
        axes: &Mat<T, 3, W>,
        noise_rad_s: T,
        inertia_kg_m2: T,
    ) {
        if block.is_hole() {
            // Neither motion nor rest.
            self.impulse_n_m_s += block.impulse_n_m_s;
            return;
        }
        self.sum.add(block, axes);
        if self.sum.blocks < STRETCH_BLOCKS {
            return;
        }
        let mut stretch = core::mem::replace(&mut self.sum, Mean::empty()).of_sums();
        self.impulse_n_m_s += stretch.impulse_n_m_s;
        stretch.impulse_n_m_s = self.impulse_n_m_s;
        let moved = |reference: Mean<T>| stretch.differs(&reference, noise_rad_s, inertia_kg_m2);
        let (is_moved, is_driven) = self.reference.map_or((true, true), moved);
        self.is_driven = is_driven;
        if is_moved || is_driven {
            self.reference = Some(stretch);
            self.impulse_n_m_s = Vec3::zeros();
            self.quiet_stretches = 0;
            self.quiet_s = T::zero();
        } else {
            self.quiet_stretches = self.quiet_stretches.saturating_add(1);
            self.quiet_s += stretch.duration_s;
        }
    }

    /// True after a quiet time of `quiet_s`, s.
    pub fn is_over(&self, quiet_s: T) -> bool {
        self.quiet_stretches >= QUIET_STRETCHES && self.quiet_s >= quiet_s
    }

    /// True if the last stretch was driven.
    pub fn is_driven(&self) -> bool {
        self.is_driven
    }

    /// True if a block after quiet ones shows motion.
    pub fn begins<const W: usize>(
        &self,
        block: &Block<T, W>,
        axes: &Mat<T, 3, W>,
        noise_rad_s: T,
        inertia_kg_m2: T,
    ) -> bool {
        self.reference.is_none_or(|reference| {
            let (is_moved, is_driven) =
                Mean::of(block, axes).differs(&reference, noise_rad_s, inertia_kg_m2);
            is_moved || is_driven
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE_RAD_S: f64 = 1e-3;
    const QUIET_S: f64 = 30.0;

    fn block(rate: f64, drive: f64, impulse: f64) -> Block<f64, 3> {
        Block {
            weight: 4.0,
            duration_s: 0.4,
            rate_rad_s: Vec3::new(0.01, rate, 0.0),
            wheels_n_m_s: Vec3::new(drive, 0.0, 0.3),
            impulse_n_m_s: Vec3::new(0.0, 0.0, impulse),
            ..Block::empty()
        }
    }

    fn after(blocks: impl Iterator<Item = Block<f64, 3>>) -> Excitation<f64> {
        let mut excitation = Excitation::new();
        blocks.for_each(|b| excitation.add(&b, &Mat::identity(), NOISE_RAD_S, 2.0));
        excitation
    }

    #[test]
    fn a_body_that_turns_steadily_is_quiet_and_stirs_when_it_speeds_up() {
        let quiet = after((0..100).map(|_| block(0.05, 0.1, 0.0)));
        assert!(quiet.is_over(QUIET_S));
        assert!(!quiet.begins(&block(0.05, 0.1, 0.0), &Mat::identity(), NOISE_RAD_S, 2.0));
        assert!(quiet.begins(&block(0.053, 0.1, 0.0), &Mat::identity(), NOISE_RAD_S, 2.0));
        assert!(quiet.begins(&block(0.05, 0.11, 0.0), &Mat::identity(), NOISE_RAD_S, 2.0));
        assert!(quiet.begins(&block(0.05, 0.1, 0.01), &Mat::identity(), NOISE_RAD_S, 2.0));
    }

    /// A change of a tenth of a block's noise a block, and wheels or torque alone.
    #[test]
    fn slow_motion_isn_t_over() {
        assert!(!after((0..300).map(|k| block(5e-5 * f64::from(k), 0.1, 0.0))).is_over(QUIET_S));
        assert!(!after((0..300).map(|k| block(0.0, 1e-4 * f64::from(k), 0.0))).is_over(QUIET_S));
        assert!(!after((0..300).map(|_| block(0.0, 0.1, 2e-4))).is_over(QUIET_S));
    }
}
