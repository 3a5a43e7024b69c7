//! Innovation statistics: whether the filter's own covariance explains what the gyro says.

use crate::math::{Vec3, scalar::Real};

/// Samples that the running mean remembers. The mean NIS per degree of freedom then scatters by
/// √(2 / (3 · 2 · 256)) = 0.04 about 1 while all is well.
const MEMORY: u16 = 256;

/// Before so many innovations, the mean says nothing.
const WARM_UP: u16 = 64;

/// Mean NIS per degree of freedom above which the model doesn't explain the data. An honest
/// filter stays below 1.2 (five sigma of the scatter above); the rest is margin for gyro noise
/// that was stated up to 1.4 times too small.
const DIVERGED: f64 = 2.0;

/// One innovation counts no more than this NIS, so that a single spike can't condemn a filter.
const CLIP: f64 = 75.0;

/// The difference between a gyro sample and its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation<T: Real> {
    /// Measured minus predicted rate, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Its variance on each axis by the filter's own covariance, gyro noise included, rad²/s².
    pub variance_rad2_s2: Vec3<T>,
}

crate::persist!([T: Real] Innovation<T> { rate_rad_s, variance_rad2_s2 });

impl<T: Real> Innovation<T> {
    /// Normalised innovation squared, axis by axis: three degrees of freedom. Leaves out the
    /// correlation between axes, which is small beside the gyro's noise.
    pub fn nis(&self) -> T {
        let [x, y, z] = self.squared_ratios();
        x + y + z
    }

    /// Square of the largest ratio of an axis to its sigma.
    pub fn squared_test_ratio(&self) -> T {
        let [x, y, z] = self.squared_ratios();
        x.max(y).max(z)
    }

    fn squared_ratios(&self) -> [T; 3] {
        let (r, v) = (&self.rate_rad_s, &self.variance_rad2_s2);
        [r.x * r.x / v.x, r.y * r.y / v.y, r.z * r.z / v.z]
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format> defmt::Format for Innovation<T> {
    fn format(&self, f: defmt::Formatter) {
        let (rate, variance) = (self.rate_rad_s.as_slice(), self.variance_rad2_s2.as_slice());
        defmt::write!(f, "{} rad/s, variance {} rad2/s2", rate, variance);
    }
}

/// Running means of the innovations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnovationMonitor<T: Real> {
    count: u16,
    mean_nis: T,
    residuals: u32,
    mean_square_rad2_s2: T,
}

crate::persist!(
    [T: Real] InnovationMonitor<T> { count, mean_nis, residuals, mean_square_rad2_s2 }
    if |this| this.mean_nis >= T::zero() && this.mean_square_rad2_s2 >= T::zero()
);

impl<T: Real> Default for InnovationMonitor<T> {
    fn default() -> Self {
        let o = T::zero();
        Self { count: 0, mean_nis: o, residuals: 0, mean_square_rad2_s2: o }
    }
}

impl<T: Real> InnovationMonitor<T> {
    /// Takes in an innovation that updated the filter.
    pub fn accept(&mut self, innovation: &Innovation<T>) {
        self.judge(innovation);
        let r = &innovation.rate_rad_s;
        let square = r.dot(r) * T::lit(1.0 / 3.0);
        if !square.is_finite() {
            return; // The filter is about to start anew; its mean must not be lost for good.
        }
        // Beyond 2^20 residuals the mean forgets slowly instead of stalling in single precision.
        self.residuals = (self.residuals + 1).min(1 << 20);
        let weight = T::one() / T::count(self.residuals);
        self.mean_square_rad2_s2 += (square - self.mean_square_rad2_s2) * weight;
    }

    /// Takes in an innovation that was refused as a spike: it speaks against the filter, but
    /// isn't a residual of it.
    pub fn refuse(&mut self, innovation: &Innovation<T>) {
        self.judge(innovation);
    }

    fn judge(&mut self, innovation: &Innovation<T>) {
        self.count = (self.count + 1).min(MEMORY);
        let weight = T::one() / T::count(u32::from(self.count));
        let nis = innovation.nis().min(T::lit(CLIP)) * T::lit(1.0 / 3.0);
        self.mean_nis += (nis - self.mean_nis) * weight;
    }

    /// Forgets the consistency record (all has started anew), not the residuals.
    pub fn restart(&mut self) {
        self.count = 0;
        self.mean_nis = T::zero();
    }

    /// Mean NIS per degree of freedom: 1 for an honest filter.
    pub fn mean_nis(&self) -> T {
        self.mean_nis
    }

    /// Whether the innovations fit the filter's covariance.
    pub fn is_consistent(&self) -> bool {
        self.count < WARM_UP || self.mean_nis <= T::lit(DIVERGED)
    }

    /// RMS of the innovations that updated the filter, per axis, rad/s.
    pub fn residual_rms_rad_s(&self) -> T {
        self.mean_square_rad2_s2.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn innovation(sigmas: f64) -> Innovation<f64> {
        Innovation { rate_rad_s: Vec3::repeat(2.0 * sigmas), variance_rad2_s2: Vec3::repeat(4.0) }
    }

    #[test]
    fn innovations_of_their_own_sigma_are_consistent() {
        let mut m = InnovationMonitor::default();
        for _ in 0..1000 {
            m.accept(&innovation(1.0));
        }
        assert!((m.mean_nis() - 1.0).abs() < 1e-12);
        assert!((m.residual_rms_rad_s() - 2.0).abs() < 1e-12);
        assert!(m.is_consistent());
    }

    #[test]
    fn innovations_three_times_too_large_are_not() {
        let mut m = InnovationMonitor::default();
        for _ in 0..200 {
            m.accept(&innovation(3.0));
        }
        assert!(!m.is_consistent());
    }

    #[test]
    fn one_spike_condemns_nothing() {
        let mut m = InnovationMonitor::default();
        for _ in 0..100 {
            m.accept(&innovation(1.0));
        }
        m.refuse(&innovation(1e6));
        assert!(m.is_consistent());
        assert!((m.residual_rms_rad_s() - 2.0).abs() < 1e-12);
    }
}
