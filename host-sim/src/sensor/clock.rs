//! Clock of the samples: the true time of each stamp.
//!
//! `t = (1 + δ) t_stamp + T u` with the drift `δ`, the sample period `T`, and `u` uniform within ± the
//! jitter.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::input::scenario::hardware::ClockErrors;

/// Offset into the random sequence of a seed, beyond the parts that gyro, initial estimate and hardware
/// use.
const JITTER_OFFSET: u128 = 5 << 64;

/// Clock with its own random generator.
pub struct Clock {
    errors: ClockErrors,
    period_s: f64,
    random: Pcg64,
}

impl Clock {
    /// Clock of samples with this period, s.
    pub fn new(errors: ClockErrors, period_s: f64, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        random.advance(JITTER_OFFSET);
        Self { errors, period_s, random }
    }

    /// True time of the next sample, s. Called once for each stamp, in order.
    pub fn true_time_s(&mut self, stamp_us: u64) -> f64 {
        let uniform = 2.0 * self.random.random::<f64>() - 1.0;
        let nominal_s = stamp_us as f64 * 1e-6;
        nominal_s * (1.0 + self.errors.drift) + uniform * self.errors.jitter * self.period_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drift_grows_with_time_and_jitter_is_uniform() {
        let errors = ClockErrors { drift: 3e-4, jitter: 0.1 };
        let mut clock = Clock::new(errors, 0.1, 7);
        let deviations: Vec<f64> = (0..20_000u64)
            .map(|k| clock.true_time_s(k * 100_000) - k as f64 * 0.1 * (1.0 + 3e-4))
            .collect();
        assert!(deviations.iter().all(|x| x.abs() <= 0.01 + 1e-9));
        let square = deviations.iter().map(|x| x * x).sum::<f64>() / 20_000.0;
        // Variance 0.01²/3, within five sigma of 20,000 draws.
        assert!((square / (1e-4 / 3.0) - 1.0).abs() < 5.0 * (0.8f64 / 20_000.0).sqrt());
    }
}
