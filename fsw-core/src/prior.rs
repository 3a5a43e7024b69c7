//! Inertia before any data: expected elements and their sigma.

use crate::error::{ConfigError, Invalid};
use crate::math::range::{finite, positive};
use crate::math::scalar::Real;
use crate::tensor::Inertia;

/// Inertia before any data, elements `jxx jyy jzz jxy jxz jyz`, taken as uncorrelated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior<T: Real> {
    /// Expected elements, kg m². Must be physical.
    pub inertia_kg_m2: [T; 6],
    /// One sigma of each, kg m², above zero. Observability is judged against it.
    pub sigma_kg_m2: [T; 6],
}

crate::persist!(
    [T: Real] Prior<T> { inertia_kg_m2, sigma_kg_m2 } if |prior| prior.validate().is_ok()
);

/// Range of a product over that of a moment, where it has to be made up: no physical product
/// exceeds half a moment.
const PRODUCT_RANGE: f64 = 0.5;

/// What is held as possible while nothing is known, kg m²: no spacecraft of this project's kind
/// is larger.
const UNKNOWN_RANGE_KG_M2: f64 = 1.0e4;

impl<T: Real> Prior<T> {
    /// Of a body of which only the size is known: moments of this much and no products, each
    /// with a sigma as large as it can be.
    pub fn of_size(moment_kg_m2: T) -> Self {
        let (m, product) = (moment_kg_m2, moment_kg_m2 * T::lit(PRODUCT_RANGE));
        let inertia_kg_m2 = Inertia::spherical(m).elements_kg_m2();
        Self { inertia_kg_m2, sigma_kg_m2: [m, m, m, product, product, product] }
    }

    /// Of a body of which nothing is known.
    pub fn unknown() -> Self {
        let inertia_kg_m2 = Inertia::spherical(T::one()).elements_kg_m2();
        Self { inertia_kg_m2, ..Self::of_size(T::lit(UNKNOWN_RANGE_KG_M2)) }
    }

    /// Whether an element's sigma is above this share of the mean moment.
    pub fn is_vague(&self, share: T) -> bool {
        let moment = Inertia::new(self.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0);
        self.sigma_kg_m2.iter().any(|sigma| *sigma > share * moment)
    }

    /// Refuses a tensor that no body has and a sigma that isn't positive.
    pub fn validate(&self) -> Result<(), ConfigError> {
        Inertia::new(self.inertia_kg_m2).check().map_err(|why| ConfigError {
            field: "prior.inertia_kg_m2",
            reason: Invalid::NotPhysical(why),
        })?;
        for sigma in self.sigma_kg_m2 {
            positive("prior.sigma_kg_m2", sigma)?;
            // Variance and information of it are numbers, too: else this is none.
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
