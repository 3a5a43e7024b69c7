//! Prior: inertia before any data, as expected elements and their sigma.
//!
//! The elements are taken as uncorrelated, with a normal distribution: covariance `diag(σ²)`, kg²
//! m⁴. The range before the data, against which observability is judged, is the sigma.
//!
//! | knowledge | prior | sigma of a moment |
//! |---|---|---|
//! | mass properties of the design | [`Prior`] with its elements | uncertainty of the design |
//! | size alone | [`Prior::of_size`] | the moment itself |
//! | none | no prior, or [`Prior::unknown`] | 1e4 kg m² |
//!
//! A prior that is too narrow biases the estimate and hides that a direction is unobserved. A vague
//! prior ([`Prior::is_vague`]) cannot serve as a point of linearisation: the filter then aligns
//! itself on the motion first.

use crate::error::{ConfigError, Invalid};
use crate::math::range::{finite, positive};
use crate::math::scalar::Real;
use crate::tensor::Inertia;

/// Expected elements and their sigma, in the order `jxx jyy jzz jxy jxz jyz`.
///
/// ```
/// use fsw_core::{ConfigError, Prior};
///
/// let prior = Prior {
///     inertia_kg_m2: [25.0, 25.0, 25.0, 2.0, 2.0, 2.0f32],
///     sigma_kg_m2: [30.0, 30.0, 30.0, 10.0, 10.0, 10.0],
/// };
/// assert_eq!(prior.validate(), Ok(()));
/// assert!(prior.is_vague(0.3)); // sigma of Jxx is 120 % of the mean moment
/// let error = Prior { sigma_kg_m2: [0.0; 6], ..prior }.validate().unwrap_err();
/// assert_eq!(error.field, "prior.sigma_kg_m2");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior<T: Real> {
    /// Expected elements, kg m². Must be physical.
    pub inertia_kg_m2: [T; 6],
    /// One sigma of each element, kg m². Must be positive.
    pub sigma_kg_m2: [T; 6],
}

crate::persist!(
    [T: Real] Prior<T> { inertia_kg_m2, sigma_kg_m2 } if |prior| prior.validate().is_ok()
);

/// Range of a product of inertia relative to a moment.
///
/// Derivation: `2 |∫ x y dm| ≤ ∫ (x² + y²) dm = Jzz`, so that no product exceeds half of the third
/// moment.
const PRODUCT_RANGE: f64 = 0.5;

/// Range of a moment without any knowledge, kg m²: above that of the spacecraft considered here.
const UNKNOWN_RANGE_KG_M2: f64 = 1.0e4;

impl<T: Real> Prior<T> {
    /// Prior of a body of known size alone: equal moments, no products, each with the largest
    /// possible sigma.
    ///
    /// ```
    /// use fsw_core::Prior;
    ///
    /// let prior = Prior::of_size(2.0f32); // kg m²
    /// assert_eq!(prior.inertia_kg_m2, [2.0, 2.0, 2.0, 0.0, 0.0, 0.0]);
    /// assert_eq!(prior.sigma_kg_m2, [2.0, 2.0, 2.0, 1.0, 1.0, 1.0]);
    /// ```
    pub fn of_size(moment_kg_m2: T) -> Self {
        let (m, product) = (moment_kg_m2, moment_kg_m2 * T::lit(PRODUCT_RANGE));
        let inertia_kg_m2 = Inertia::spherical(m).elements_kg_m2();
        Self { inertia_kg_m2, sigma_kg_m2: [m, m, m, product, product, product] }
    }

    /// Prior of a body of unknown size: sigma 1e4 kg m² for moments, half of that for products.
    pub fn unknown() -> Self {
        let inertia_kg_m2 = Inertia::spherical(T::one()).elements_kg_m2();
        Self { inertia_kg_m2, ..Self::of_size(T::lit(UNKNOWN_RANGE_KG_M2)) }
    }

    /// True where the sigma of an element exceeds `share` of the mean moment,
    /// `σᵢ > share · tr(J) / 3`.
    pub fn is_vague(&self, share: T) -> bool {
        let moment = Inertia::new(self.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0);
        self.sigma_kg_m2.iter().any(|sigma| *sigma > share * moment)
    }

    /// Range check of elements and sigma.
    ///
    /// # Errors
    /// `prior.inertia_kg_m2` not physical; `prior.sigma_kg_m2` not positive, or its square or the
    /// inverse of that not finite in this precision.
    pub fn validate(&self) -> Result<(), ConfigError> {
        Inertia::new(self.inertia_kg_m2).check().map_err(|why| ConfigError {
            field: "prior.inertia_kg_m2",
            reason: Invalid::NotPhysical(why),
        })?;
        for sigma in self.sigma_kg_m2 {
            positive("prior.sigma_kg_m2", sigma)?;
            // Variance and information must be finite in this precision.
            let variance = sigma * sigma;
            finite("prior.sigma_kg_m2", variance * (T::one() / variance))?;
        }
        Ok(())
    }
}

#[cfg(feature = "defmt")]
impl<T: Real + defmt::Format> defmt::Format for Prior<T> {
    fn format(&self, f: defmt::Formatter) {
        defmt::write!(f, "{} +- {} kg m2", self.inertia_kg_m2, self.sigma_kg_m2);
    }
}
