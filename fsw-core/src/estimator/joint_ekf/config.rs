//! Configuration of the nine-state filter: prior, noise levels, spike gate, sample gate.
//!
//! Every field has a default except the gyro noise; [`Config::bellar_2019`] has those of the paper.

use crate::error::{ConfigError, Invalid};
use crate::gate;
use crate::math::range::{finite, not_negative, positive};
use crate::math::{Vec3, scalar::Real};
use crate::monitor::spikes;
use crate::prior::Prior;

/// Configuration, fixed for the filter's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// Inertia before the data, kg m². Default none: the filter aligns on the motion first.
    pub prior: Option<Prior<T>>,
    /// Largest sigma of a prior, as a share of its mean moment, zero or above, from which the
    /// filter starts directly. A vaguer prior, or none, cannot be linearised about: the filter then
    /// aligns on the motion first, by linear least squares. Default 0.2: from a prior twice as
    /// vague one run in a hundred of the STSAT-3 spin-up diverged. `T::MAX` disables the alignment.
    pub align_above: T,
    /// Rate at the first sample, for a filter that starts from its prior. Default none: the first
    /// sample, with the gyro's noise.
    pub initial_rate: Option<InitialRate<T>>,
    /// Inertia at the start, kg m², if not the prior's: any finite numbers, also ones that no body
    /// has, as in the Monte Carlo campaign of \[Bellar2019\]. It takes the prior's sigma. From a
    /// prior vaguer than `align_above` the alignment replaces it. Default none.
    pub initial_inertia_kg_m2: Option<[T; 6]>,
    /// Gyro noise, one sigma, white, per sample, rad/s, above zero. Must be given.
    pub gyro_noise_rad_s: T,
    /// Random walk of the rate by unmodelled torques, (rad/s)/√s, zero or above. Its square is the
    /// spectral amplitude s of \[Bellar2019\] Eq. (11). Default 0.
    pub rate_walk_rad_s_sqrt_s: T,
    /// Random walk of each inertia element (fuel consumption), kg m²/√s, zero or above. Default 0.
    /// The published form ignores it.
    pub inertia_walk_kg_m2_sqrt_s: [T; 6],
    /// Spike gate. Default 6 sigma, which white noise alone exceeds once in 10⁸ samples, and a
    /// lock-out after 10 spikes in a row.
    pub spikes: spikes::Config<T>,
    /// Sample gate.
    pub gate: gate::Config<T>,
}

// A telecommand may set the prior, which is therefore state.
crate::persist!([T: Real] Config<T> {
    prior;
    unchanged align_above, initial_rate, initial_inertia_kg_m2, gyro_noise_rad_s,
    rate_walk_rad_s_sqrt_s, inertia_walk_kg_m2_sqrt_s, spikes, gate
});

/// Rate before any data, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialRate<T: Real> {
    /// Expected rate, rad/s, finite.
    pub rate_rad_s: Vec3<T>,
    /// One sigma on each axis, rad/s, above zero.
    pub sigma_rad_s: T,
}

crate::persist!([T: Real] InitialRate<T> { rate_rad_s, sigma_rad_s });

impl<T: Real> Config<T> {
    /// Defaults for a gyro of this noise (one sigma, white, per sample, rad/s): no prior, no
    /// process noise, alignment on the motion.
    ///
    /// ```
    /// use fsw_core::Prior;
    /// use fsw_core::estimator::joint_ekf::Config;
    ///
    /// let prior = Prior { inertia_kg_m2: [1.0, 1.2, 1.5, 0.0, 0.0, 0.0], sigma_kg_m2: [0.1; 6] };
    /// let config = Config { prior: Some(prior), ..Config::new(1e-4f32) };
    /// assert_eq!(config.validate(), Ok(()));
    /// ```
    pub fn new(gyro_noise_rad_s: T) -> Self {
        let o = T::zero();
        Self {
            prior: None,
            align_above: T::lit(0.2),
            initial_rate: None,
            initial_inertia_kg_m2: None,
            gyro_noise_rad_s,
            rate_walk_rad_s_sqrt_s: o,
            inertia_walk_kg_m2_sqrt_s: [o; 6],
            spikes: spikes::Config { limit_sigma: T::lit(6.0), lockout_after: 10 },
            gate: gate::Config::default(),
        }
    }

    /// The filter of \[Bellar2019\] Table 2: initial rate (0, −2.3, 1.15) deg/s, initial moments 25
    /// and products 2 kg m².
    ///
    /// Ours, since the paper leaves them open: the sigmas, chosen as the sizes of the initial
    /// errors (2.3 deg/s, 10 kg m² on the moments, 2 kg m² on the products), and no process noise.
    /// As in the paper the filter starts from this prior although it is vague, and has no spike
    /// gate.
    pub fn bellar_2019(gyro_noise_rad_s: T) -> Self {
        let defaults = Self::new(gyro_noise_rad_s);
        let degree = core::f64::consts::PI / 180.0;
        let rate_rad_s = Vec3::new(0.0, -2.3 * degree, 1.15 * degree).map(T::lit);
        Self {
            prior: Some(Prior {
                inertia_kg_m2: [25.0, 25.0, 25.0, 2.0, 2.0, 2.0].map(T::lit),
                sigma_kg_m2: [10.0, 10.0, 10.0, 2.0, 2.0, 2.0].map(T::lit),
            }),
            initial_rate: Some(InitialRate { rate_rad_s, sigma_rad_s: T::lit(2.3 * degree) }),
            align_above: T::MAX,
            spikes: spikes::Config { limit_sigma: T::MAX, ..defaults.spikes },
            ..defaults
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// Names the first field that is out of its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        positive("gyro_noise_rad_s", self.gyro_noise_rad_s)?;
        not_negative("rate_walk_rad_s_sqrt_s", self.rate_walk_rad_s_sqrt_s)?;
        for walk in self.inertia_walk_kg_m2_sqrt_s {
            not_negative("inertia_walk_kg_m2_sqrt_s", walk)?;
        }
        not_negative("align_above", self.align_above)?;
        self.spikes.validate()?;
        if let Some(prior) = &self.prior {
            prior.validate()?;
        }
        if let Some(initial) = &self.initial_rate {
            positive("initial_rate.sigma_rad_s", initial.sigma_rad_s)?;
            if !initial.rate_rad_s.iter().all(|x| x.is_finite()) {
                let reason = Invalid::NotFinite;
                return Err(ConfigError { field: "initial_rate.rate_rad_s", reason });
            }
        }
        for element in self.initial_inertia_kg_m2.into_iter().flatten() {
            finite("initial_inertia_kg_m2", element)?;
        }
        self.gate.validate()
    }

    /// R: variance of the gyro noise on each axis, rad²/s².
    pub(super) fn noise_variance(&self) -> T {
        self.gyro_noise_rad_s * self.gyro_noise_rad_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::NotPhysical;

    fn refused(change: impl FnOnce(&mut Config<f32>)) -> ConfigError {
        let mut config = Config::bellar_2019(1e-4);
        assert_eq!(config.validate(), Ok(()));
        change(&mut config);
        config.validate().unwrap_err()
    }

    #[test]
    fn names_the_field_that_is_out_of_range() {
        let prior = |c: &mut Config<f32>, f: fn(&mut Prior<f32>)| f(c.prior.as_mut().unwrap());
        let cases = [
            (refused(|c| c.gyro_noise_rad_s = -1e-4), "gyro_noise_rad_s", Invalid::NotPositive),
            (refused(|c| c.gyro_noise_rad_s = 0.0), "gyro_noise_rad_s", Invalid::NotPositive),
            (refused(|c| c.gyro_noise_rad_s = f32::NAN), "gyro_noise_rad_s", Invalid::NotFinite),
            (
                refused(|c| c.rate_walk_rad_s_sqrt_s = -1.0),
                "rate_walk_rad_s_sqrt_s",
                Invalid::Negative,
            ),
            (
                refused(|c| c.initial_inertia_kg_m2 = Some([f32::INFINITY; 6])),
                "initial_inertia_kg_m2",
                Invalid::NotFinite,
            ),
            (refused(|c| c.spikes.limit_sigma = 0.0), "spikes.limit_sigma", Invalid::NotPositive),
            (refused(|c| c.gate.range_rad_s = 0.0), "gate.range_rad_s", Invalid::NotPositive),
            (
                refused(|c| prior(c, |p| p.sigma_kg_m2[3] = 0.0)),
                "prior.sigma_kg_m2",
                Invalid::NotPositive,
            ),
            (
                refused(|c| prior(c, |p| p.inertia_kg_m2[0] = 60.0)),
                "prior.inertia_kg_m2",
                Invalid::NotPhysical(NotPhysical::TriangleInequality),
            ),
        ];
        for (error, field, reason) in cases {
            assert_eq!(error, ConfigError { field, reason });
        }
    }
}
