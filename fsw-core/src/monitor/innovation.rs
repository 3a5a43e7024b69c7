//! Innovation statistics: consistency of a filter's covariance with the gyro's readings.
//!
//! Input: innovation ν (measured minus predicted rate) and its variance S on each axis. Output:
//! running mean of the NIS per degree of freedom, and the RMS of the residuals.
//!
//! `NIS = Σᵢ νᵢ² / Sᵢ`, chi-square of three degrees of freedom for a consistent filter.
//!
//! | mean NIS per degree of freedom | meaning |
//! |---|---|
//! | 0.8 to 1.2 | consistent |
//! | below 0.8 | covariance or stated gyro noise too large |
//! | 1.2 to 2 | gyro noise up to 1.4 times the stated one |
//! | above 2 | the model does not explain the data |
//!
//! The mean has a memory of 256 innovations, `m ← m + (NIS / 3 − m) / n`, `n ≤ 256`. A single NIS
//! is clipped at 75, five sigma on each axis, so that an isolated spike has little effect.
//!
//! Assumption: off-diagonal elements of S are small against the variance of the gyro noise, and
//! neglected.

use crate::math::{Vec3, scalar::Real};

/// Samples in the memory of the running mean.
///
/// The NIS of three degrees of freedom has the variance 6; that of NIS / 3 is 2/3. An exponential
/// mean of memory n has the variance of a mean over 2 n samples: √(2 / (3 · 2 · 256)) = 0.04 about
/// 1 for a consistent filter.
const MEMORY: u16 = 256;

/// Innovations before the mean is tested.
const WARM_UP: u16 = 64;

/// Mean NIS per degree of freedom above which the model does not explain the data. A consistent
/// filter stays below 1.2 (five sigma of the scatter above); the rest is margin for gyro noise
/// stated up to 1.4 times too small.
const DIVERGED: f64 = 2.0;

/// Largest NIS that enters the mean, which limits the effect of one spike on the mean.
const CLIP: f64 = 75.0;

/// Difference between a gyro sample and its prediction.
///
/// ```
/// use fsw_core::{Innovation, Vec3};
///
/// let innovation = Innovation {
///     rate_rad_s: Vec3::new(2e-4f64, 0.0, -1e-4),
///     variance_rad2_s2: Vec3::repeat(1e-8),
/// };
/// assert!((innovation.nis() - 5.0).abs() < 1e-12); // 2² + 0 + 1²
/// assert!((innovation.squared_test_ratio() - 4.0).abs() < 1e-12); // 2²
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation<T: Real> {
    /// Innovation ν, measured minus predicted rate, rad/s.
    pub rate_rad_s: Vec3<T>,
    /// Variance S of ν on each axis by the filter's covariance, gyro noise included, rad²/s².
    pub variance_rad2_s2: Vec3<T>,
}

crate::persist!([T: Real] Innovation<T> { rate_rad_s, variance_rad2_s2 });

impl<T: Real> Innovation<T> {
    /// Normalised innovation squared, `Σᵢ νᵢ² / Sᵢ`: three degrees of freedom.
    pub fn nis(&self) -> T {
        let [x, y, z] = self.squared_ratios();
        x + y + z
    }

    /// Squared test ratio, `maxᵢ νᵢ² / Sᵢ`: squared number of sigmas on the worst axis.
    pub fn squared_test_ratio(&self) -> T {
        let [x, y, z] = self.squared_ratios();
        x.max(y).max(z)
    }

    /// Ratios `νᵢ² / Sᵢ`.
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

/// Running means of the NIS and of the squared residuals.
///
/// ```
/// use fsw_core::monitor::innovation::InnovationMonitor;
/// use fsw_core::{Innovation, Vec3};
///
/// let mut monitor = InnovationMonitor::default();
/// let three_sigma = Innovation {
///     rate_rad_s: Vec3::repeat(3e-4f64),
///     variance_rad2_s2: Vec3::repeat(1e-8),
/// };
/// for _ in 0..200 {
///     monitor.accept(&three_sigma);
/// }
/// assert!(!monitor.is_consistent());
/// assert!((monitor.residual_rms_rad_s() - 3e-4).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InnovationMonitor<T: Real> {
    /// Innovations in the mean NIS, up to the memory.
    count: u16,
    /// Mean NIS per degree of freedom.
    mean_nis: T,
    /// Residuals in the mean square.
    residuals: u32,
    /// Mean square of the residuals, per axis, rad²/s².
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
    /// Adds an innovation that updated the filter.
    pub fn accept(&mut self, innovation: &Innovation<T>) {
        self.judge(innovation);
        let r = &innovation.rate_rad_s;
        let square = r.dot(r) * T::lit(1.0 / 3.0);
        if !square.is_finite() {
            return; // The filter is about to be reset; an infinite mean would be permanent.
        }
        // From 2²⁰ residuals on the memory is finite: a smaller weight would stall in single precision.
        self.residuals = (self.residuals + 1).min(1 << 20);
        let weight = T::one() / T::count(self.residuals);
        self.mean_square_rad2_s2 += (square - self.mean_square_rad2_s2) * weight;
    }

    /// Adds an innovation rejected as a spike: it counts for consistency, but is not a residual.
    pub fn refuse(&mut self, innovation: &Innovation<T>) {
        self.judge(innovation);
    }

    /// Running mean of the clipped NIS: `m ← m + (NIS / 3 − m) / n`.
    fn judge(&mut self, innovation: &Innovation<T>) {
        self.count = (self.count + 1).min(MEMORY);
        let weight = T::one() / T::count(u32::from(self.count));
        let nis = innovation.nis().min(T::lit(CLIP)) * T::lit(1.0 / 3.0);
        self.mean_nis += (nis - self.mean_nis) * weight;
    }

    /// Discards the mean NIS after a reset of the filter; the residuals stay.
    pub fn restart(&mut self) {
        self.count = 0;
        self.mean_nis = T::zero();
    }

    /// Mean NIS per degree of freedom: 1 for a consistent filter.
    pub fn mean_nis(&self) -> T {
        self.mean_nis
    }

    /// True where the innovations agree with the covariance, and before 64 of them.
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

    /// A NIS of 3 in every sample gives a mean of 1 and the RMS of the innovation.
    #[test]
    fn innovations_of_one_sigma_are_consistent() {
        let mut m = InnovationMonitor::default();
        for _ in 0..1000 {
            m.accept(&innovation(1.0));
        }
        assert!((m.mean_nis() - 1.0).abs() < 1e-12);
        assert!((m.residual_rms_rad_s() - 2.0).abs() < 1e-12);
        assert!(m.is_consistent());
    }

    /// A mean NIS per degree of freedom of 9.
    #[test]
    fn innovations_of_three_sigma_are_inconsistent() {
        let mut m = InnovationMonitor::default();
        for _ in 0..200 {
            m.accept(&innovation(3.0));
        }
        assert!(!m.is_consistent());
    }

    /// A rejected spike of 10⁶ sigma changes neither consistency nor the residual RMS.
    #[test]
    fn a_single_spike_keeps_consistency() {
        let mut m = InnovationMonitor::default();
        for _ in 0..100 {
            m.accept(&innovation(1.0));
        }
        m.refuse(&innovation(1e6));
        assert!(m.is_consistent());
        assert!((m.residual_rms_rad_s() - 2.0).abs() < 1e-12);
    }
}
