//! First state and covariance of the filter: from the prior, or from an alignment.
//!
//! Decides when an [`Alignment`] is solved, whether its solution is good enough to linearise about,
//! and the covariance with which the filter starts. The least squares themselves are
//! [`alignment`](super::alignment)'s.

use super::alignment::Alignment;
use super::{Config, InitialRate, State};
use crate::math::{Vec3, scalar::Real, ud::Ud};
use crate::prior::Prior;
use crate::tensor::Inertia;

/// Factor on the formal covariance of an alignment, which leaves out the noise in the integrals:
/// over 10,000 runs of the STSAT-3 spin-up its error is 1.1 to 1.5 times the bound.
const ALIGNMENT_INFLATION: f64 = 1.5 * 1.5;

/// Largest sigma of each element, as a share of the mean moment, that ends the alignment. The
/// filter converges from errors of a half; this is a fifth of that.
const ALIGNED: f64 = 0.1;

/// Samples between two attempts: a solution costs twice as much as adding a sample, and one more
/// sample changes little.
const ALIGNMENT_PERIOD: u32 = 16;

/// True if the alignment is to be solved at this sample: every sixteenth, so that the mean cost of
/// a step in alignment stays near that of adding a sample.
pub(super) fn is_due<T: Real>(alignment: &Alignment<T>) -> bool {
    alignment.samples() > 0 && alignment.samples().is_multiple_of(ALIGNMENT_PERIOD)
}

/// State and covariance at the start of tracking.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<T: Real> {
    /// Rate and inertia.
    pub state: State<T>,
    /// Covariance of the nine states.
    pub covariance: Ud<T, 9>,
    /// Sigma of each element before the data, kg m²: the yardstick of observability.
    pub range_kg_m2: [T; 6],
}

/// Reason why an alignment gives no start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoStart {
    /// The motion does not yet stand out of the noise: no solution, after a tenth of its cost.
    NoSolution,
    /// The motion does not yet determine all six elements well enough.
    TooLittleMotion,
    /// The motion determines a tensor that no rigid body has, or leaves residuals above the noise:
    /// a fault of the gyro within it, wrong signs, axes or units, an unmodelled torque.
    Contradiction,
}

impl<T: Real> Start<T> {
    /// From the prior (that of an unknown body if none) and the first sample's rate, or from the
    /// configured rate and inertia in their place. All nine states are uncorrelated.
    pub fn from_prior(
        prior: Option<Prior<T>>,
        config: &Config<T>,
        first_rate_rad_s: &Vec3<T>,
    ) -> Self {
        let Prior { inertia_kg_m2, sigma_kg_m2 } = prior.unwrap_or(Prior::unknown());
        let rate = config.initial_rate.unwrap_or(InitialRate {
            rate_rad_s: *first_rate_rad_s,
            sigma_rad_s: config.gyro_noise_rad_s,
        });
        let mut variances = [rate.sigma_rad_s * rate.sigma_rad_s; 9];
        for (variance, sigma) in variances.iter_mut().skip(3).zip(sigma_kg_m2) {
            *variance = sigma * sigma;
        }
        let covariance = Ud::diagonal(variances);
        let inertia = Inertia::new(config.initial_inertia_kg_m2.unwrap_or(inertia_kg_m2));
        Self {
            state: State { rate_rad_s: rate.rate_rad_s, inertia },
            covariance,
            range_kg_m2: sigma_kg_m2,
        }
    }

    /// From the motion since the start, for gyro noise of `noise_rad_s` (one sigma per sample). The
    /// residuals may be those of the measured noise, `measured_rad_s`, instead.
    ///
    /// The range of each element is the prior's sigma, or that of a body of the estimated size.
    ///
    /// # Errors
    /// [`NoStart::NoSolution`] while the motion does not stand out of the noise;
    /// [`NoStart::TooLittleMotion`] while an element's sigma exceeds a tenth of the mean moment;
    /// [`NoStart::Contradiction`] where the tensor is then not physical or the residuals are not
    /// explained.
    pub fn from_motion(
        alignment: &Alignment<T>,
        prior: Option<&Prior<T>>,
        noise_rad_s: T,
        measured_rad_s: impl FnOnce() -> T,
    ) -> Result<Self, NoStart> {
        let solution = alignment.solve(noise_rad_s).ok_or(NoStart::NoSolution)?;
        let mut covariance = solution.covariance;
        covariance.scale(T::lit(ALIGNMENT_INFLATION));
        let mean_moment = solution.inertia.trace_kg_m2() * T::lit(1.0 / 3.0);
        let largest = mean_moment * T::lit(ALIGNED);
        if !(3..9).all(|i| covariance.variance(i) < largest * largest) {
            return Err(NoStart::TooLittleMotion);
        }
        let is_explained = |noise_rad_s| alignment.is_explained(&solution.inertia, noise_rad_s);
        let is_contradicted = !is_explained(noise_rad_s) && !is_explained(measured_rad_s());
        if is_contradicted || !solution.inertia.is_physical() {
            return Err(NoStart::Contradiction);
        }
        let range_kg_m2 = prior.unwrap_or(&Prior::of_size(mean_moment)).sigma_kg_m2;
        let state = State { rate_rad_s: solution.rate_rad_s, inertia: solution.inertia };
        Ok(Self { state, covariance, range_kg_m2 })
    }
}
