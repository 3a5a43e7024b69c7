//! Numbers: plausible, at the edges of a range, and not finite.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::{once_in, one_of};

/// Special values.
const SPECIAL: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::MIN_POSITIVE,
    1e-45,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    f32::EPSILON,
    1e19,
    -1e19,
    1e-19,
    16_777_216.0,
];

/// Draws numbers; the share of extreme ones is drawn for each case, so that some cases have none.
pub struct Numbers {
    /// One in this many numbers is extreme; 0: none.
    extreme: u32,
}

impl Numbers {
    /// Numbers without extreme ones.
    pub fn of_usual() -> Self {
        Self { extreme: 0 }
    }

    /// Numbers of a case.
    pub fn new(random: &mut Pcg64) -> Self {
        Self { extreme: one_of(random, &[0, 0, 0, 1_000, 100, 10, 2]) }
    }

    /// True where no number is extreme.
    pub fn are_usual(&self) -> bool {
        self.extreme == 0
    }

    /// True where the next number is to be extreme.
    pub fn is_extreme(&self, random: &mut Pcg64) -> bool {
        self.extreme > 0 && once_in(random, self.extreme)
    }

    /// A number of this magnitude, or an extreme one.
    pub fn of(&self, random: &mut Pcg64, magnitude: f32) -> f32 {
        if self.is_extreme(random) {
            return extreme(random);
        }
        magnitude * (2.0 * random.random::<f32>() - 1.0)
    }

    /// A positive number between these, uniform in its logarithm, or an extreme one.
    pub fn between(&self, random: &mut Pcg64, least: f32, most: f32) -> f32 {
        if self.is_extreme(random) {
            return extreme(random);
        }
        (least.ln() + (most / least).ln() * random.random::<f32>()).exp()
    }
}

/// A special value, a power of ten, or any bits.
pub fn extreme(random: &mut Pcg64) -> f32 {
    match random.random_range(0..3) {
        0 => one_of(random, &SPECIAL),
        1 => {
            let sign = one_of(random, &[-1.0, 1.0]);
            sign * 10f32.powi(random.random_range(-38..=38))
        }
        _ => f32::from_bits(random.random()),
    }
}
