//! Prediction of a reading from its neighbours: the interpolating polynomial at one instant.
//!
//! Times are relative to that instant, s. Neighbours on both sides interpolate, on one side they
//! extrapolate. Line and cubic are functions of their own, which all callers share.

use crate::math::{Vec3, scalar::Real};

/// Reading of the gyro and its time relative to the sample in question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading<T: Real> {
    /// Time, s: negative before the sample.
    pub(super) time_s: T,
    /// Rate, rad/s.
    pub(super) rate_rad_s: Vec3<T>,
}

crate::persist!([T: Real] Reading<T> { time_s, rate_rad_s });

impl<T: Real> Reading<T> {
    /// Zero rate at the instant of the sample.
    pub(super) fn zero() -> Self {
        Self { time_s: T::zero(), rate_rad_s: Vec3::zeros() }
    }
}

/// Prediction at time zero, minus another rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset<T: Real> {
    /// Difference, rad/s.
    pub(super) rate_rad_s: Vec3<T>,
    /// Variance of reading minus prediction, relative to that of a reading.
    pub(super) squared_gain: T,
}

impl<T: Real> Offset<T> {
    /// Line through two readings, minus `about`, rad/s. `None` where the times are equal.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn of_line(two: [&Reading<T>; 2], about: &Vec3<T>) -> Option<Self> {
        Self::through(two, about)
    }

    /// Cubic through four readings, minus `about`, rad/s. `None` where two times are equal.
    #[cfg_attr(target_os = "none", inline(never))]
    pub(super) fn of_cubic(four: [&Reading<T>; 4], about: &Vec3<T>) -> Option<Self> {
        Self::through(four, about)
    }

    /// Lagrange's weights `cᵢ = Πₖ tₖ / (tₖ − tᵢ)` over `k ≠ i`, gain `1 + Σ cᵢ²`, difference
    /// `Σ cᵢ (ωᵢ − about)`. Differences keep it exactly zero for readings that repeat.
    #[inline(always)] // the loops unroll: half of the instructions
    fn through<const N: usize>(readings: [&Reading<T>; N], about: &Vec3<T>) -> Option<Self> {
        let mut weight = [T::one(); N];
        let mut squared_gain = T::one();
        for i in 0..N {
            let (mut numerator, mut denominator) = (T::one(), T::one());
            for k in 0..N {
                if k != i {
                    numerator *= readings[k].time_s;
                    denominator *= readings[k].time_s - readings[i].time_s;
                }
            }
            weight[i] = numerator / denominator;
            squared_gain += weight[i] * weight[i];
        }
        if !squared_gain.is_finite() {
            return None;
        }
        let mut rate_rad_s = Vec3::zeros();
        for i in 0..N {
            rate_rad_s += (readings[i].rate_rad_s - about) * weight[i];
        }
        Some(Self { rate_rad_s, squared_gain })
    }

    /// Squared difference on each axis over the squared gain, rad²/s².
    #[inline]
    pub(super) fn normalised(&self) -> Vec3<T> {
        self.rate_rad_s.component_mul(&self.rate_rad_s) * (T::one() / self.squared_gain)
    }
}

/// Age of the latest reading, in intervals to the one before it, beyond which neither predicts.
const OLD: f64 = 6.0;

/// The last two accepted readings, latest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct History<T: Real> {
    /// Number of readings, 0 to 2.
    count: u32,
    readings: [Reading<T>; 2],
}

crate::persist!([T: Real] History<T> { count, readings } if |this| this.count <= 2);

impl<T: Real> History<T> {
    /// No reading.
    pub(super) fn empty() -> Self {
        Self { count: 0, readings: [Reading::zero(); 2] }
    }

    /// Moves the origin of the times by one interval, s.
    pub(super) fn advance(&mut self, elapsed_s: T) {
        for reading in &mut self.readings {
            reading.time_s -= elapsed_s;
        }
    }

    /// Discards readings that are too old for a prediction: the line through two readings a time apart multiplies their
    /// noise by nine after [`OLD`] times that, and the curvature of the motion by more.
    pub(super) fn forget_old(&mut self) {
        let [latest, far] = &self.readings;
        let is_old = -latest.time_s > (latest.time_s - far.time_s) * T::lit(OLD);
        if self.count < 2 || is_old {
            *self = Self::empty();
        }
    }

    /// Adds an accepted reading at the present instant.
    pub(super) fn add(&mut self, rate_rad_s: &Vec3<T>) {
        let [latest, _] = self.readings;
        self.readings = [Reading { time_s: T::zero(), rate_rad_s: *rate_rad_s }, latest];
        self.count = self.count.saturating_add(1).min(2);
    }

    /// Both readings, latest first.
    pub(super) fn pair(&self) -> Option<&[Reading<T>; 2]> {
        (self.count >= 2).then_some(&self.readings)
    }

    /// The latest reading.
    pub(super) fn latest(&self) -> Option<&Reading<T>> {
        (self.count >= 1).then_some(&self.readings[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64, x: f64) -> Reading<f64> {
        Reading { time_s, rate_rad_s: Vec3::new(x, 0.0, 0.0) }
    }

    /// `x = 1 + 2 t + 3 t² − t³` at uneven times.
    #[test]
    fn four_readings_predict_a_cubic() {
        let x = |t: f64| 1.0 + t * (2.0 + t * (3.0 - t));
        let readings = [-0.3, -0.1, 0.15, 0.2].map(|t| at(t, x(t)));
        let cubic = Offset::of_cubic(readings.each_ref(), &Vec3::zeros()).unwrap();
        assert!((cubic.rate_rad_s.x - 1.0).abs() < 1e-12);
    }

    /// Even steps: the fourth difference over 6, gain 70/36; a line on one side has a gain of 6.
    #[test]
    fn gains_are_those_of_even_steps() {
        let readings = [-2.0, -1.0, 1.0, 2.0].map(|t| at(t, 0.0));
        let about = Vec3::zeros();
        let across = Offset::of_cubic(readings.each_ref(), &about).unwrap();
        assert!((across.squared_gain - 70.0 / 36.0).abs() < 1e-12);
        let side = Offset::of_line([&readings[1], &readings[0]], &about).unwrap();
        assert!((side.squared_gain - 6.0).abs() < 1e-12);
        assert!(Offset::of_line([&readings[1], &readings[1]], &about).is_none());
    }

    /// Two readings an eighth of a second apart predict up to an age of six eighths; one alone predicts nothing.
    #[test]
    fn old_readings_are_forgotten() {
        let mut history = History::<f64>::empty();
        history.add(&Vec3::x());
        history.advance(0.125);
        let mut alone = history;
        alone.forget_old();
        assert!(alone.latest().is_none());
        history.add(&Vec3::y());
        history.advance(0.75);
        history.forget_old();
        assert!(history.pair().is_some());
        history.advance(0.125);
        history.forget_old();
        assert!(history.latest().is_none());
    }
}
