//! The gyro's noise where nobody tells it: from third differences of its readings, which white noise
//! fills and smooth motion doesn't.

use crate::math::{Vec3, scalar::Real};
use crate::persist::{Archive, Persist, mix, name};

/// Variance of a third difference over that of a reading: 1 + 9 + 9 + 1.
const THIRD_DIFFERENCE: f64 = 20.0;

/// Measures noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseMeter<T: Real> {
    last: [Vec3<T>; 3],
    readings: u32,
    squares: T,
}

/// Readings that aren't numbers are kept as none.
impl<T: Real> Persist for NoiseMeter<T> {
    fn layout() -> u32 {
        mix(const { name("NoiseMeter") }, <([Option<Vec3<T>>; 3], (u32, T))>::layout())
    }

    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Self { last, readings, squares } = self;
        for reading in last {
            let mut known = reading.iter().all(|x| x.is_finite()).then_some(*reading);
            known.persist(archive);
            *reading = known.unwrap_or(no_reading());
        }
        readings.persist(archive);
        squares.persist(archive);
        if *squares < T::zero() {
            archive.refuse("NoiseMeter");
        }
    }
}

fn no_reading<T: Real>() -> Vec3<T> {
    Vec3::repeat(T::lit(f64::NAN))
}

impl<T: Real> NoiseMeter<T> {
    /// Before any reading.
    pub fn new() -> Self {
        Self { last: [Vec3::zeros(); 3], readings: 0, squares: T::zero() }
    }

    /// After a gap: readings don't follow one another.
    pub fn interrupt(&mut self) {
        self.last = [no_reading(); 3];
    }

    /// Takes in a reading, rad/s.
    #[inline(never)]
    pub fn add(&mut self, rate_rad_s: &Vec3<T>) {
        let [a, b, c] = self.last;
        self.last = [b, c, *rate_rad_s];
        if self.readings < 3 {
            self.readings += 1;
            return;
        }
        let third = rate_rad_s - c * T::lit(3.0) + b * T::lit(3.0) - a;
        let square = third.dot(&third);
        if square.is_finite() {
            // A running mean, so that nothing grows without bound.
            self.readings = self.readings.saturating_add(1);
            self.squares += (square - self.squares) / T::count(self.readings - 3);
        }
    }

    /// One sigma of a reading on one axis, rad/s, never zero.
    pub fn noise_rad_s(&self) -> T {
        (self.squares / T::lit(3.0 * THIRD_DIFFERENCE)).sqrt().max(T::lit(1e-12))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_told_from_motion() {
        // Numbers that jump about: a linear congruence, uniform in ±1, of variance 1/3.
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 23) as f64 - 1.0
        };
        let mut meter = NoiseMeter::new();
        for k in 0..4000 {
            let t = f64::from(k) * 0.1;
            let motion = Vec3::new((0.3 * t).sin(), 0.5, 0.2 * (0.1 * t).cos());
            meter.add(&(motion + Vec3::from_fn(|_, _| 1e-3 * noise())));
        }
        let sigma = 1e-3 / 3f64.sqrt();
        assert!((meter.noise_rad_s() / sigma - 1.0).abs() < 0.05, "{}", meter.noise_rad_s());
    }
}
