//! First state and covariance of the filter: from the prior, or from an alignment.
//!
//! Decides when an [`Alignment`] is solved, whether its solution is good enough to linearise about,
//! and the covariance with which the filter starts. The least squares themselves are
//! [`alignment`](super::alignment)'s.

use super::alignment::{Alignment, Solution};
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

/// Error of an aligned element, as a share of the mean moment, over the relative error of the readings: see
/// [`considered`](super::considered).
const AMPLIFICATION: f64 = 10.0;

/// Sigma of a scale that is taken as independent of the columns, over that of the parameters that cause it. The filter
/// takes the start for further information: of the sigma of the columns, a part of `1 / √(1 + 1 / 3²)` = 0.95 is left.
const INDEPENDENT: f64 = 3.0;

/// Samples between two attempts: a solution costs twice as much as adding a sample, and one more
/// sample changes little.
const ALIGNMENT_PERIOD: u32 = 16;

/// True if the alignment is to be solved at this sample: every sixteenth, so that the mean cost of
/// a step in alignment stays near that of adding a sample.
pub(super) fn is_due<T: Real>(alignment: &Alignment<T>) -> bool {
    alignment.samples() > 0 && alignment.samples().is_multiple_of(ALIGNMENT_PERIOD)
}

/// Inertia of an alignment that may end it, for gyro noise of `noise_rad_s` (one sigma per sample). The
/// residuals may be those of the measured noise instead, or of the noise with errors of the hardware:
/// `allowed_rad_s`, for a body of a mean moment, kg m².
///
/// # Errors
/// [`NoStart::NoSolution`] while the motion does not stand out of the noise;
/// [`NoStart::TooLittleMotion`] while an element's sigma exceeds a tenth of the mean moment;
/// [`NoStart::Contradiction`] where the tensor is then not physical or the residuals are not
/// explained.
pub(super) fn inertia_of<T: Real>(
    alignment: &Alignment<T>,
    noise_rad_s: T,
    allowed_rad_s: impl FnOnce(T) -> T,
) -> Result<Inertia<T>, NoStart> {
    let (inertia, largest_variance) =
        alignment.solve_inertia(noise_rad_s).ok_or(NoStart::NoSolution)?;
    let mean_moment = inertia.trace_kg_m2() * T::lit(1.0 / 3.0);
    let largest = mean_moment * T::lit(ALIGNED);
    let is_determined = largest_variance * T::lit(ALIGNMENT_INFLATION) < largest * largest;
    if !is_determined {
        return Err(NoStart::TooLittleMotion);
    }
    let is_explained = |noise_rad_s| alignment.is_explained(&inertia, noise_rad_s);
    let is_contradicted = !is_explained(noise_rad_s) && !is_explained(allowed_rad_s(mean_moment));
    if is_contradicted || !inertia.is_physical() {
        return Err(NoStart::Contradiction);
    }
    Ok(inertia)
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

    /// At the last sample of an alignment, for the inertia of [`inertia_of`] and gyro noise of `noise_rad_s` (one sigma
    /// per sample). `None` where the inertia has no inverse.
    ///
    /// The range of each element is the prior's sigma, or that of a body of the estimated size.
    pub fn from_motion(
        alignment: &Alignment<T>,
        inertia: &Inertia<T>,
        prior: Option<&Prior<T>>,
        noise_rad_s: T,
    ) -> Option<Self> {
        let Solution { rate_rad_s, inertia, mut covariance } =
            alignment.at_last_sample(inertia, noise_rad_s)?;
        covariance.scale(T::lit(ALIGNMENT_INFLATION));
        let mean_moment = inertia.trace_kg_m2() * T::lit(1.0 / 3.0);
        let range_kg_m2 = prior.unwrap_or(&Prior::of_size(mean_moment)).sigma_kg_m2;
        Some(Self { state: State { rate_rad_s, inertia }, covariance, range_kg_m2 })
    }

    /// Adds what errors of the hardware add to the covariance, uncorrelated with the later ones: the error of
    /// a reading on the rate; of each element `AMPLIFICATION` times its share of the rate, up to the sigma that ends an
    /// alignment; of the scale of all elements `INDEPENDENT` times the sigma of it.
    pub fn widen(&mut self, error: &AlignmentError<T>) {
        for axis in 0..3 {
            self.covariance.inflate(axis, error.rate_rad_s * error.rate_rad_s);
        }
        let share =
            (error.rate_rad_s / error.of_rate_rad_s * T::lit(AMPLIFICATION)).min(T::lit(ALIGNED));
        let sigma_kg_m2 = self.state.inertia.trace_kg_m2() * T::lit(1.0 / 3.0) * share;
        for element in 3..9 {
            self.covariance.inflate(element, sigma_kg_m2 * sigma_kg_m2);
        }
        let scale = error.scale * T::lit(INDEPENDENT);
        let [a, b, c, d, e, f] = self.state.inertia.elements_kg_m2();
        let o = T::zero();
        self.covariance.add_product([o, o, o, a, b, c, d, e, f], scale * scale);
    }
}

/// Errors of an alignment by the hardware, one sigma.
#[derive(Clone, Copy, Debug)]
pub(super) struct AlignmentError<T> {
    /// Error of a reading, rad/s, at a rate of this magnitude, rad/s.
    pub rate_rad_s: T,
    pub of_rate_rad_s: T,
    /// Common error of all elements, share.
    pub scale: T,
}
