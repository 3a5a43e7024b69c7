//! Configuration of the two systems: nominal inertia, rate filter, differentiator, regression.
//!
//! [`Config::kim_2013`] and [`Config::kim_2016`] are the published ones. The papers leave several
//! values open; the choices made here are marked "Ours".

use crate::error::{ConfigError, Invalid};
use crate::estimator::ekf_sgf::rate_ekf;
use crate::estimator::ekf_sgf::regression::Elements;
use crate::gate;
use crate::math::range::{not_negative, positive, within};
use crate::math::savgol::{Fit, Growth};
use crate::math::scalar::Real;
use crate::monitor::spikes;
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Configuration, fixed for the estimator's life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config<T: Real> {
    /// Nominal inertia of the rate filter, kg m²; with its sigma the prior of the regression, which
    /// unobserved directions keep. Must be given.
    pub nominal: Prior<T>,
    /// Rate filter.
    pub rate_ekf: rate_ekf::Config<T>,
    /// Window, polynomial order and evaluation point of the differentiator.
    pub fit: Fit<T>,
    /// Use of the window while it fills.
    pub growth: Growth,
    /// Largest deviation of a sample interval from the window's mean, as a share; beyond, the
    /// window restarts. Ours: 0.1, which moves a derivative over six samples by up to 1.4 %.
    pub period_tolerance: T,
    /// Unknowns of the regression: three moments or six elements.
    pub elements: Elements,
    /// Instants at which the sums become an estimate.
    pub readout: Readout<T>,
    /// Spike gate, on innovations without the lag. In place of a spike the window takes the
    /// predicted rate. Ours: 15 sigma, since a nominal inertia half wrong alone makes 5, and a
    /// lock-out after 10 spikes in a row.
    pub spikes: spikes::Config<T>,
    /// Sample gate.
    pub gate: gate::Config<T>,
}

// A telecommand may set the nominal inertia, which is therefore state.
crate::persist!([T: Real] Config<T> {
    nominal;
    unchanged rate_ekf, fit, growth, period_tolerance, elements, readout, spikes, gate
});

/// Instants at which the sums become an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Readout<T: Real> {
    /// Every sample: recursive least squares, \[Kim2013\].
    EverySample {
        /// Weight λ of the past at each sample, `0 < λ ≤ 1`. Default 1: all samples alike.
        forgetting: T,
    },
    /// The end of each interval: batch least squares, \[Kim2016\].
    EveryInterval {
        /// Length of an interval, µs, above zero. Default 40 s.
        interval_us: u64,
        /// Data of a batch. Default all data since the start. The paper is ambiguous; on its
        /// manoeuvre this one converges at about the 440 s that it reports, and intervals of 40 s
        /// alone do not converge.
        batch: Batch,
    },
}

crate::persist!([T: Real] enum Readout<T> {
    0 => EverySample { forgetting: T }, 1 => EveryInterval { interval_us: u64, batch: Batch }
});

/// Data of one batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Batch {
    /// The interval that has just ended.
    LastInterval,
    /// All data since the start.
    SinceStart,
}

crate::persist!([] enum Batch { 0 => LastInterval, 1 => SinceStart });

impl<T: Real> Config<T> {
    /// `ekf-sgf-rls`, \[Kim2013\]: a parabola over a window that grows 3, 3, 5, 5, 7 (a backward
    /// difference before that), three moments, recursive least squares without forgetting.
    ///
    /// `gyro_noise_rad_s`: one sigma, white, per sample. The paper's nominal inertia is
    /// [`half_of`](Self::half_of) the true moments. Its process noise is open: see
    /// [`rate_ekf::Config`].
    pub fn kim_2013(gyro_noise_rad_s: T, nominal: Prior<T>) -> Self {
        Self {
            fit: Fit::centred(7, 2, 1),
            growth: Growth::Odd,
            elements: Elements::Moments,
            readout: Readout::EverySample { forgetting: T::one() },
            ..Self::kim_2016(gyro_noise_rad_s, nominal)
        }
    }

    /// `ekf-sgf-lls`, \[Kim2016\]: a parabola over a window of six samples, six elements, a batch
    /// every 40 s.
    ///
    /// ```
    /// use fsw_core::Prior;
    /// use fsw_core::estimator::ekf_sgf::{Batch, Config, Readout};
    ///
    /// let nominal =
    ///     Prior { inertia_kg_m2: [14.0, 17.0, 20.0, 0.0, 0.0, 0.0], sigma_kg_m2: [5.0; 6] };
    /// let readout = Readout::EveryInterval { interval_us: 60_000_000, batch: Batch::SinceStart };
    /// let config = Config { readout, ..Config::kim_2016(1e-4f32, nominal) };
    /// assert_eq!(config.validate(8), Ok(()));
    /// ```
    ///
    /// The paper calls its polynomial quartic and prints, in Eq. (10) and Table 2, the weights of a
    /// parabola, `(2i − 5)/35`; the printed ones are used here. Its Table 5 (errors of the
    /// acceleration 28 to 29 % smaller than by the backward difference, Eq. 11) is that of a true
    /// quartic, `Fit::centred(6, 4, 1)`: the printed weights make it 54 %.
    pub fn kim_2016(gyro_noise_rad_s: T, nominal: Prior<T>) -> Self {
        Self {
            nominal,
            rate_ekf: rate_ekf::Config::new(gyro_noise_rad_s),
            fit: Fit::centred(6, 2, 1),
            growth: Growth::WaitUntilFull,
            period_tolerance: T::lit(0.1),
            elements: Elements::All,
            readout: Readout::EveryInterval { interval_us: 40_000_000, batch: Batch::SinceStart },
            spikes: spikes::Config { limit_sigma: T::lit(15.0), lockout_after: 10 },
            gate: gate::Config::default(),
        }
    }

    /// Nominal inertia of \[Kim2013\], `0.5 J`: half of the given moments (kg m²), no products.
    ///
    /// Ours, since the paper leaves it open: a sigma of 100 % on each moment, and of half the mean
    /// moment on each product.
    pub fn half_of(moments_kg_m2: [T; 3]) -> Prior<T> {
        let (o, half) = (T::zero(), T::lit(0.5));
        let [x, y, z] = moments_kg_m2.map(|m| m * half);
        let product = Inertia::new([x, y, z, o, o, o]).trace_kg_m2() * T::lit(1.0 / 6.0);
        Prior {
            inertia_kg_m2: [x, y, z, o, o, o],
            sigma_kg_m2: [x, y, z, product, product, product],
        }
    }

    /// Checks every range; that of the window against `capacity`, the differentiator's samples.
    ///
    /// # Errors
    /// Names the first field that is out of its range.
    pub fn validate(&self, capacity: usize) -> Result<(), ConfigError> {
        self.nominal.validate().map_err(|e| match e.field {
            "prior.sigma_kg_m2" => ConfigError { field: "nominal.sigma_kg_m2", ..e },
            _ => ConfigError { field: "nominal.inertia_kg_m2", ..e },
        })?;
        self.rate_ekf.validate()?;
        self.fit.validate(capacity)?;
        within("order", self.fit.order, 1, self.fit.window - 1)?;
        not_negative("period_tolerance", self.period_tolerance)?;
        match self.readout {
            Readout::EverySample { forgetting } => {
                positive("forgetting", forgetting)?;
                if forgetting > T::one() {
                    return Err(ConfigError { field: "forgetting", reason: Invalid::AboveOne });
                }
            }
            Readout::EveryInterval { interval_us: 0, .. } => {
                return Err(ConfigError { field: "interval_us", reason: Invalid::NotPositive });
            }
            Readout::EveryInterval { .. } => {}
        }
        self.spikes.validate()?;
        self.gate.validate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut Config<f32>)) -> (&'static str, Invalid) {
        let mut config = Config::kim_2013(1e-4, Config::half_of([14.2, 17.3, 20.3]));
        assert_eq!(config.validate(8), Ok(()));
        change(&mut config);
        let error = config.validate(8).unwrap_err();
        (error.field, error.reason)
    }

    #[test]
    fn names_the_field_that_is_out_of_range() {
        let out = |least, most| Invalid::OutOfRange { least, most };
        let readout = |r| refused(|c| c.readout = r);
        let every = |interval_us| Readout::EveryInterval { interval_us, batch: Batch::SinceStart };
        let cases = [
            (refused(|c| c.fit.window = 9), ("window", out(2, 8))),
            (refused(|c| c.fit.order = 7), ("order", out(0, 6))),
            (refused(|c| c.fit.order = 0), ("order", out(1, 6))),
            (
                refused(|c| c.nominal.sigma_kg_m2[0] = 0.0),
                ("nominal.sigma_kg_m2", Invalid::NotPositive),
            ),
            (
                refused(|c| c.rate_ekf.gyro_noise_rad_s = 0.0),
                ("gyro_noise_rad_s", Invalid::NotPositive),
            ),
            (
                readout(Readout::EverySample { forgetting: 0.0 }),
                ("forgetting", Invalid::NotPositive),
            ),
            (readout(Readout::EverySample { forgetting: 1.1 }), ("forgetting", Invalid::AboveOne)),
            (readout(every(0)), ("interval_us", Invalid::NotPositive)),
            (
                refused(|c| c.spikes.limit_sigma = f32::NAN),
                ("spikes.limit_sigma", Invalid::NotFinite),
            ),
        ];
        for (found, expected) in cases {
            assert_eq!(found, expected);
        }
        assert_eq!(refused(|c| c.nominal.inertia_kg_m2[0] = -1.0).0, "nominal.inertia_kg_m2");
    }

    #[test]
    fn half_of_halves_the_moments_and_drops_the_products() {
        let nominal = Config::<f64>::half_of([14.2, 17.3, 20.3]);
        assert_eq!(nominal.inertia_kg_m2, [7.1, 8.65, 10.15, 0.0, 0.0, 0.0]);
    }
}
