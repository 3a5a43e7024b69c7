//! Checks of single values, each of which names the key it refuses.

use std::ops::Range;

use nalgebra::{Matrix3, SMatrix, Vector3};
use toml::Spanned;

use super::error::{InputError, Problem, numbers};
use super::toml_source::TomlSource;

/// How far the largest principal moment may exceed the sum of the others, relative to it.
///
/// A flat body lies on that limit exactly, and its file has been rounded to some digits.
const TRIANGLE_TOLERANCE: f64 = 1e-6;

/// A file whose values are being checked.
pub(super) struct Check<'a> {
    source: &'a TomlSource,
}

impl<'a> Check<'a> {
    pub(super) fn new(source: &'a TomlSource) -> Self {
        Self { source }
    }

    /// An error about `value`, which stands at `key`.
    pub(super) fn error<T>(&self, value: &Spanned<T>, problem: Problem) -> InputError {
        self.error_at(value.span(), problem)
    }

    /// An error about a piece of the file.
    pub(super) fn error_at(&self, span: Range<usize>, problem: Problem) -> InputError {
        self.source.error(span, problem)
    }

    pub(super) fn finite(&self, key: &str, value: &Spanned<f64>) -> Result<f64, InputError> {
        self.number(key, value, "a finite number", f64::is_finite)
    }

    pub(super) fn positive(&self, key: &str, value: &Spanned<f64>) -> Result<f64, InputError> {
        self.number(key, value, "positive and finite", |x| x.is_finite() && x > 0.0)
    }

    pub(super) fn not_negative(&self, key: &str, value: &Spanned<f64>) -> Result<f64, InputError> {
        self.number(key, value, "zero or positive, and finite", |x| x.is_finite() && x >= 0.0)
    }

    pub(super) fn number(
        &self,
        key: &str,
        value: &Spanned<f64>,
        required: &'static str,
        is_good: impl Fn(f64) -> bool,
    ) -> Result<f64, InputError> {
        let number = *value.get_ref();
        if is_good(number) {
            return Ok(number);
        }
        let found = number.to_string();
        Err(self.error(value, Problem::BadValue { key: key.to_owned(), found, required }))
    }

    /// A list of `N` finite numbers.
    pub(super) fn list<const N: usize>(
        &self,
        key: &str,
        value: &Spanned<Vec<f64>>,
    ) -> Result<[f64; N], InputError> {
        let list = self.length(key, value)?;
        if list.iter().all(|number| number.is_finite()) {
            return Ok(list);
        }
        Err(self.bad_list(key, value, "finite numbers"))
    }

    /// `N` entries of any kind. The parser itself ignores entries beyond a fixed length.
    pub(super) fn length<E: Clone, const N: usize>(
        &self,
        key: &str,
        value: &Spanned<Vec<E>>,
    ) -> Result<[E; N], InputError> {
        let found = value.get_ref().len();
        <[E; N]>::try_from(value.get_ref().clone()).map_err(|_| {
            self.error(value, Problem::WrongLength { key: key.to_owned(), found, required: N })
        })
    }

    pub(super) fn vector(
        &self,
        key: &str,
        value: &Spanned<Vec<f64>>,
    ) -> Result<Vector3<f64>, InputError> {
        self.list(key, value).map(Vector3::from)
    }

    /// A direction, scaled to length 1.
    pub(super) fn axis(
        &self,
        key: &str,
        value: &Spanned<Vec<f64>>,
    ) -> Result<Vector3<f64>, InputError> {
        let vector = self.vector(key, value)?;
        let largest = vector.amax();
        if largest == 0.0 {
            let required = "a direction, with at least one entry other than zero";
            return Err(self.bad_list(key, value, required));
        }
        // Scaled by the largest entry first, so that no finite axis overflows when squared.
        Ok((vector / largest).normalize())
    }

    /// Six elements of an inertia tensor of a real body.
    pub(super) fn inertia(
        &self,
        key: &str,
        value: &Spanned<Vec<f64>>,
    ) -> Result<[f64; 6], InputError> {
        let elements = self.list(key, value)?;
        let moments = principal_moments(&tensor(&elements));
        if is_physical(&moments) {
            return Ok(elements);
        }
        let problem =
            Problem::NotPhysical { key: key.to_owned(), principal_moments_kg_m2: moments };
        Err(self.error(value, problem))
    }

    /// Six standard deviations.
    pub(super) fn sigmas(
        &self,
        key: &str,
        value: &Spanned<Vec<f64>>,
    ) -> Result<[f64; 6], InputError> {
        let sigmas: [f64; 6] = self.list(key, value)?;
        if sigmas.iter().all(|sigma| *sigma > 0.0) {
            return Ok(sigmas);
        }
        Err(self.bad_list(key, value, "six positive standard deviations"))
    }

    pub(super) fn bad_list(
        &self,
        key: &str,
        value: &Spanned<Vec<f64>>,
        required: &'static str,
    ) -> InputError {
        let found = numbers(value.get_ref());
        self.error(value, Problem::BadValue { key: key.to_owned(), found, required })
    }
}

/// Whether a body can have these principal moments, ascending.
pub(super) fn is_physical(moments: &[f64; 3]) -> bool {
    let [smallest, middle, largest] = moments;
    *smallest > 0.0 && *largest <= (smallest + middle) * (1.0 + TRIANGLE_TOLERANCE)
}

/// The tensor of the six elements `jxx jyy jzz jxy jxz jyz`.
pub(super) fn tensor(elements_kg_m2: &[f64; 6]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = *elements_kg_m2;
    SMatrix::from_row_slice(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
}

/// Eigenvalues of a symmetric tensor, ascending.
pub(super) fn principal_moments(tensor: &Matrix3<f64>) -> [f64; 3] {
    let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    moments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamina_lies_on_the_limit_and_is_physical() {
        let source = TomlSource::new("x", "");
        let lamina = Spanned::new(1..2, vec![0.4651, 0.037, 0.5021, 0.0, 0.0, 0.0]);
        assert!(Check::new(&source).inertia("j", &lamina).is_ok());
    }

    #[test]
    fn axis_of_any_length_becomes_a_unit_vector() {
        let source = TomlSource::new("x", "");
        for length in [1e-300, 1e-3, 1.0, 1e300] {
            let axis = Spanned::new(1..2, vec![length, 0.0, -length]);
            let unit = Check::new(&source).axis("axis", &axis).unwrap();
            assert!((unit.norm() - 1.0).abs() < 1e-15, "{length}");
        }
    }
}
