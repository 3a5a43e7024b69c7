//! Checks of the values of one table. Each rejection names the file, the line and the full key.
//!
//! A value outside its range is kept as a fault of the file and replaced by a stand-in, so that one
//! reading finds all of them: see [`TomlSource::read_all`].

use std::ops::Range as Span;

use nalgebra::Vector3;
use toml::Spanned;

use crate::error::{InputError, Problem};
use crate::inertia::{is_physical, principal_moments, tensor};
use crate::key::{FINITE, Key, Range};
use crate::toml_source::TomlSource;
use crate::words::numbers;

/// Stand-in for a value outside its range.
const STAND_IN: f64 = 0.25;

/// A list of numbers with its place in the file.
pub type List = Spanned<Vec<f64>>;

/// A table of a TOML file, with the path to it.
#[derive(Clone)]
pub struct Section<'a> {
    source: &'a TomlSource,
    /// Empty, or ends with a point.
    prefix: String,
}

impl<'a> Section<'a> {
    /// Checks that every value read until now is valid, before a computation that needs all of them.
    ///
    /// # Errors
    /// All faults of these values, in one error.
    pub fn checked(&self) -> Result<(), InputError> {
        self.source.checked()
    }

    /// The keys above the first table.
    pub fn root(source: &'a TomlSource) -> Self {
        Self { source, prefix: String::new() }
    }

    /// The table `name` of this one.
    pub fn table(&self, name: &str) -> Self {
        Self { source: self.source, prefix: format!("{}{name}.", self.prefix) }
    }

    /// Table `index` of the repeated table `name`. Index in error messages: from 1, as in the
    /// column names of a log.
    pub fn entry(&self, name: &str, index: usize) -> Self {
        self.table(&format!("{name}[{}]", index + 1))
    }

    /// The path of this table, as `wheel[2]`.
    pub fn path(&self) -> &str {
        self.prefix.trim_end_matches('.')
    }

    /// The full name of a key, as `wheel[2].axis`.
    pub fn full(&self, key: &Key) -> String {
        format!("{}{}", self.prefix, key.name)
    }

    /// An error at `value`.
    pub fn error<T>(&self, value: &Spanned<T>, problem: impl Into<Problem>) -> InputError {
        self.error_at(value.span(), problem)
    }

    /// An error at a span of the file.
    pub fn error_at(&self, span: Span<usize>, problem: impl Into<Problem>) -> InputError {
        self.source.error(span, problem.into())
    }

    /// The error for a key absent from `table`.
    pub fn missing<T>(&self, key: &Key, table: &Spanned<T>) -> InputError {
        self.error(table, Problem::MissingKey { key: self.full(key) })
    }

    /// The error for a value outside the key's range; `found` is the value in words.
    pub fn out_of_range<T>(&self, key: &Key, value: &Spanned<T>, found: String) -> InputError {
        let problem =
            Problem::BadValue { key: self.full(key), found, required: key.range.words.to_owned() };
        self.error(value, problem)
    }

    /// The error for a list outside the key's range.
    pub fn list_out_of_range(&self, key: &Key, value: &List) -> InputError {
        self.out_of_range(key, value, numbers(value.get_ref()))
    }

    /// A number within the key's range.
    ///
    /// # Errors
    /// The number is outside the range.
    pub fn number(&self, key: &Key, value: &Spanned<f64>) -> Result<f64, InputError> {
        self.number_if(key, value, |_| true)
    }

    /// A number within the key's range that also satisfies `condition`.
    ///
    /// # Errors
    /// The number is outside the range, or fails the condition.
    pub fn number_if(
        &self,
        key: &Key,
        value: &Spanned<f64>,
        condition: impl Fn(f64) -> bool,
    ) -> Result<f64, InputError> {
        let number = *value.get_ref();
        if (key.range.contains)(number) && condition(number) {
            return Ok(number);
        }
        self.source.keep(self.out_of_range(key, value, number.to_string()));
        Ok(STAND_IN)
    }

    /// A number within the key's range, if the key is present.
    ///
    /// # Errors
    /// The number is outside the range.
    pub fn optional_number(
        &self,
        key: &Key,
        value: &Option<Spanned<f64>>,
    ) -> Result<Option<f64>, InputError> {
        value.as_ref().map(|value| self.number(key, value)).transpose()
    }

    /// Exactly `N` numbers, each within the key's range.
    ///
    /// # Errors
    /// Another length, or a number outside the range.
    pub fn list<const N: usize>(&self, key: &Key, value: &List) -> Result<[f64; N], InputError> {
        let list = self.length(key, value)?;
        self.all_in(&self.full(key), &key.range, value)?;
        Ok(list)
    }

    /// Exactly `N` entries of any type. The parser itself ignores entries beyond a fixed length.
    ///
    /// # Errors
    /// Another length.
    pub fn length<E: Clone, const N: usize>(
        &self,
        key: &Key,
        value: &Spanned<Vec<E>>,
    ) -> Result<[E; N], InputError> {
        let entries = value.get_ref();
        if let Ok(list) = <[E; N]>::try_from(entries.clone()) {
            return Ok(list);
        }
        let found = entries.len();
        let error =
            self.error(value, Problem::WrongLength { key: self.full(key), found, required: N });
        // The entries over again stand in for the list.
        let filled: Vec<E> = entries.iter().cycle().take(N).cloned().collect();
        match <[E; N]>::try_from(filled) {
            Ok(list) => {
                self.source.keep(error);
                Ok(list)
            }
            Err(_) => Err(error),
        }
    }

    /// Requires each number of the list called `name` to be in the range.
    ///
    /// # Errors
    /// A number outside the range.
    pub fn all_in(&self, name: &str, range: &Range, value: &List) -> Result<(), InputError> {
        if value.get_ref().iter().all(|number| (range.contains)(*number)) {
            return Ok(());
        }
        let found = numbers(value.get_ref());
        let required = range.words.to_owned();
        let problem = Problem::BadValue { key: name.to_owned(), found, required };
        self.source.keep(self.error(value, problem));
        Ok(())
    }

    /// A vector in body axes.
    ///
    /// # Errors
    /// Other than three numbers, or one outside the range.
    pub fn vector(&self, key: &Key, value: &List) -> Result<Vector3<f64>, InputError> {
        self.list(key, value).map(Vector3::from)
    }

    /// A vector in body axes, zero if the key is absent.
    ///
    /// # Errors
    /// As of [`Self::vector`].
    pub fn vector_or_zero(
        &self,
        key: &Key,
        value: &Option<List>,
    ) -> Result<Vector3<f64>, InputError> {
        value.as_ref().map_or(Ok(Vector3::zeros()), |value| self.vector(key, value))
    }

    /// A direction, scaled to unit length.
    ///
    /// # Errors
    /// As of [`Self::vector`], or three zeros.
    pub fn axis(&self, key: &Key, value: &List) -> Result<Vector3<f64>, InputError> {
        let vector = self.vector(key, value)?;
        let largest = vector.amax();
        if largest == 0.0 || !largest.is_finite() {
            if largest == 0.0 {
                self.source.keep(self.list_out_of_range(key, value));
            }
            return Ok(Vector3::x());
        }
        // Scaled by the largest entry first: the square of a finite axis may overflow.
        Ok((vector / largest).normalize())
    }

    /// The six elements of a rigid body's inertia tensor, kg m².
    ///
    /// # Errors
    /// Other than six finite numbers, a principal moment of zero or less, or one above the sum of
    /// the other two.
    pub fn inertia(&self, key: &Key, value: &List) -> Result<[f64; 6], InputError> {
        let elements = self.length(key, value)?;
        self.all_in(&self.full(key), &FINITE, value)?;
        let moments = principal_moments(&tensor(&elements));
        if is_physical(&moments) {
            return Ok(elements);
        }
        if elements.iter().all(|element| element.is_finite()) {
            let key = self.full(key);
            let problem = Problem::NotPhysical { key, principal_moments_kg_m2: moments };
            self.source.keep(self.error(value, problem));
        }
        Ok([STAND_IN, STAND_IN, STAND_IN, 0.0, 0.0, 0.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::{DIRECTION, ELEMENTS, PHYSICAL, VECTOR};

    const AXIS: Key = Key::required("axis", VECTOR, "", DIRECTION, "direction");
    const INERTIA: Key = Key::required("inertia", ELEMENTS, "kg m²", PHYSICAL, "inertia");

    #[test]
    fn lamina_on_the_triangle_limit_is_physical() {
        let source = TomlSource::new("x", "");
        let lamina = Spanned::new(1..2, vec![0.4651, 0.037, 0.5021, 0.0, 0.0, 0.0]);
        assert!(Section::root(&source).inertia(&INERTIA, &lamina).is_ok());
    }

    #[test]
    fn axis_of_any_finite_length_is_normalised() {
        let source = TomlSource::new("x", "");
        for length in [1e-300, 1e-3, 1.0, 1e300] {
            let axis = Spanned::new(1..2, vec![length, 0.0, -length]);
            let unit = Section::root(&source).axis(&AXIS, &axis).unwrap();
            assert!((unit.norm() - 1.0).abs() < 1e-15, "{length}");
        }
    }
}
