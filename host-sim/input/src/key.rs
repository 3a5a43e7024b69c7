//! Keys of files: name, type, unit, range, default and meaning of each, one row a key.
//!
//! The readers check values against the range of the row; the reference page prints the rows.

/// Type of a key whose value is a string.
pub const TEXT: &str = "text";
/// Type of a key whose value is a boolean.
pub const FLAG: &str = "true or false";
/// Type of a key whose value is one number.
pub const NUMBER: &str = "number";
/// Type of a key whose value is a vector in body axes.
pub const VECTOR: &str = "3 numbers";
/// Type of a key whose value has one number for each inertia element.
pub const ELEMENTS: &str = "6 numbers";
/// Type of a key whose value is a table of further keys.
pub const TABLE: &str = "table";
/// Type of a key whose table may be repeated.
pub const TABLES: &str = "tables";

/// Any value of the type.
pub const ANY: Range = Range::new("any", |_| true);
/// Neither NaN nor infinite.
pub const FINITE: Range = Range::new("finite", f64::is_finite);
/// Above zero.
pub const POSITIVE: Range = Range::new("positive and finite", |x| x.is_finite() && x > 0.0);
/// Zero or above.
pub const NOT_NEGATIVE: Range =
    Range::new("zero or positive, and finite", |x| x.is_finite() && x >= 0.0);
/// A vector with a direction.
pub const DIRECTION: Range =
    Range::new("finite, with at least one entry other than zero", f64::is_finite);
/// The elements of a rigid body's tensor.
pub const PHYSICAL: Range = Range::new("the inertia of a rigid body", f64::is_finite);

/// The valid values of a key.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The range, as it follows "it must be".
    pub words: &'static str,
    /// Test of one number; each number of a list has to pass.
    pub contains: fn(f64) -> bool,
}

impl Range {
    /// A range from its words and its test.
    pub const fn new(words: &'static str, contains: fn(f64) -> bool) -> Self {
        Self { words, contains }
    }
}

/// A key of a table, or a column of a log.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// The name as written in the file.
    pub name: &'static str,
    /// Type of the value.
    pub value: &'static str,
    /// SI unit; empty for a pure number and for text.
    pub unit: &'static str,
    /// Valid values.
    pub range: Range,
    /// Value of an absent key; none if the key is required.
    pub default: Option<&'static str>,
    /// Meaning, a noun phrase.
    pub meaning: &'static str,
}

impl Key {
    /// A key that every file has.
    pub const fn required(
        name: &'static str,
        value: &'static str,
        unit: &'static str,
        range: Range,
        meaning: &'static str,
    ) -> Self {
        Self { name, value, unit, range, default: None, meaning }
    }

    /// The same key, optional, with this value where it is absent.
    pub const fn or(self, default: &'static str) -> Self {
        Self { default: Some(default), ..self }
    }
}

/// A table of a file.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// The TOML header; empty for the keys above the first header.
    pub header: &'static str,
    /// Meaning, and a condition that spans several keys.
    pub about: &'static str,
    /// The keys, in the order of the reader.
    pub keys: &'static [Key],
}

impl Table {
    /// The names of the keys.
    pub fn names(&self) -> Vec<&'static str> {
        self.keys.iter().map(|key| key.name).collect()
    }
}
