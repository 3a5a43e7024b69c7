//! Why an input was refused, in words the person who wrote it can act on.
//!
//! [`InputError`] prints as `file:line: what is wrong; what to do`, one or two lines in all.

use std::fmt;
use std::io;

use thiserror::Error;

use super::ELEMENT_NAMES;
pub use super::csv_problem::CsvProblem;

/// A refused input: where, and what is wrong there.
#[derive(Debug, Error)]
#[error("{place}: {problem}")]
pub struct InputError {
    /// The file, and the line in it if one is to blame.
    pub place: Place,
    /// What is wrong, and what to do.
    pub problem: Problem,
}

/// Where a problem is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file as the user named it, or the name of a built-in scenario.
    pub file: String,
    /// The line, from 1; none if the whole file is meant.
    pub line: Option<u64>,
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(out, "{}:{line}", self.file),
            None => write!(out, "{}", self.file),
        }
    }
}

/// What is wrong with a file as such, or with the keys and values of a TOML file.
#[derive(Debug, Error)]
pub enum Problem {
    /// The file is missing or may not be read.
    #[error("cannot be read: {0}; check the path and the permissions")]
    Unreadable(io::Error),

    /// The bytes are not text.
    #[error("not UTF-8 text; save the file as UTF-8")]
    NotUtf8,

    /// Neither a file nor a built-in scenario has this name.
    #[error(
        "neither a file nor a built-in scenario; give the path of a .toml file, or one of: {}",
        list(.built_in)
    )]
    UnknownScenario {
        /// The names that would have worked.
        built_in: Vec<String>,
    },

    /// The text breaks the grammar of TOML.
    #[error("not valid TOML: {message}\n    in the line `{source_line}`")]
    TomlSyntax {
        /// The parser's own words.
        message: String,
        /// The line of the file.
        source_line: String,
    },

    /// A key that this kind of file does not have.
    #[error(
        "unknown key `{key}`{}; known here: {}",
        suggestion(.nearest.as_deref()),
        list(.known)
    )]
    UnknownKey {
        /// The key as written.
        key: String,
        /// The known key most like it.
        nearest: Option<String>,
        /// Every key known in that place.
        known: Vec<String>,
    },

    /// A word where only certain words are allowed, as in `kind = "constant"`.
    #[error(
        "unknown word \"{word}\"{}; allowed here: {}",
        suggestion(.nearest.as_deref()),
        list(.allowed)
    )]
    UnknownWord {
        /// The word as written.
        word: String,
        /// The allowed word most like it.
        nearest: Option<String>,
        /// Every word allowed in that place.
        allowed: Vec<String>,
    },

    /// A key that must be there is not.
    #[error("missing key `{key}`; add it here")]
    MissingKey {
        /// The missing key.
        key: String,
    },

    /// A value of another type than the key's.
    #[error("wrong type of value: {message}\n    in the line `{source_line}`")]
    WrongType {
        /// The deserialiser's words: what is there, what was expected.
        message: String,
        /// The line of the file.
        source_line: String,
    },

    /// A list with more or fewer entries than its key takes.
    #[error("`{key}` has {found} entries, but takes {required}; give {required}")]
    WrongLength {
        /// The key, as `wheel[2].axis`; wheels are counted from 1 as in the log's columns.
        key: String,
        /// How many entries are there.
        found: usize,
        /// How many there must be.
        required: usize,
    },

    /// Lists that belong together, of different lengths.
    #[error("`{key}` has {found} entries, but `{other}` has {required}; make them equal")]
    UnequalLengths {
        /// The key of one list.
        key: String,
        /// How many entries it has.
        found: usize,
        /// The key of the list it belongs to.
        other: String,
        /// How many entries that one has.
        required: usize,
    },

    /// A value of the right type that cannot be true.
    #[error("`{key}` is {found}; it must be {required}")]
    BadValue {
        /// The key, as `wheel[2].axis`; wheels are counted from 1 as in the log's columns.
        key: String,
        /// The value as written.
        found: String,
        /// What it must be.
        required: &'static str,
    },

    /// An inertia tensor that no rigid body has.
    #[error(
        "`{key}` ({}) is not the inertia of a body: its principal moments are {}, but must be \
         positive with none above the sum of the other two; check the signs, the unit (kg m²) \
         and the order",
        ELEMENT_NAMES.join(" "),
        numbers(.principal_moments_kg_m2)
    )]
    NotPhysical {
        /// The key.
        key: String,
        /// Eigenvalues of the tensor, ascending, kg m².
        principal_moments_kg_m2: [f64; 3],
    },

    /// Wheels that have more spin inertia than the spacecraft that contains them.
    #[error(
        "`{key}` includes the wheels (locked), but leaves principal moments {} without their spin \
         inertia; they must be positive: check the wheels' `spin_inertia_kg_m2`",
        numbers(.principal_moments_kg_m2)
    )]
    WheelsOutweighBody {
        /// The key of the inertia.
        key: String,
        /// Eigenvalues of `J − Σ Iₛ a aᵀ`, ascending, kg m².
        principal_moments_kg_m2: [f64; 3],
    },

    /// A change of the inertia that leads to none of a real body.
    #[error(
        "`{key}` makes principal moments of {} kg m² by t = {time_s} s, which no body that carries \
         these wheels has; check the numbers and their order ({})",
        numbers(.principal_moments_kg_m2),
        ELEMENT_NAMES.join(" ")
    )]
    ChangesToNoBody {
        /// The key.
        key: String,
        /// When, s since the start.
        time_s: f64,
        /// Eigenvalues of the tensor then, ascending, kg m².
        principal_moments_kg_m2: [f64; 3],
    },

    /// None or several of keys that exclude each other.
    #[error("`{key}` takes one of {}; give just one", list(.keys))]
    NotOneOf {
        /// The table.
        key: String,
        /// The keys.
        keys: &'static [&'static str],
    },

    /// A controller whose wheels can't give every torque.
    #[error(
        "[control] turns the body with its wheels, but the axes of the {found} [[wheel]] tables \
         don't span three dimensions; give three wheels or more whose axes do"
    )]
    WheelsDoNotSpan {
        /// How many wheels there are.
        found: usize,
    },

    /// A controller with gains from a natural frequency, and with gains of their own.
    #[error(
        "`control` has gains of both kinds; give either natural_frequency_rad_s and \
         damping_ratio, or attitude_gain_n_m and rate_gain_n_m_s"
    )]
    TwoKindsOfGains,

    /// More wheels than the flight core is built for.
    #[error("{found} [[wheel]] tables, but at most {most} are supported; remove some")]
    TooManyWheels {
        /// How many are there.
        found: usize,
        /// How many may be.
        most: usize,
    },

    /// More samples than a simulation may have.
    #[error(
        "`duration_s` times `gyro.rate_hz` gives {samples:.3e} samples, but at most {limit:.0e} \
         are supported; shorten the run or lower the rate"
    )]
    TooManySamples {
        /// Samples asked for.
        samples: f64,
        /// Samples allowed.
        limit: f64,
    },

    /// A torque profile with a key of another kind of profile.
    #[error("`{key}` has no meaning for kind = \"{kind}\", which takes: {}; remove it", list(.takes))]
    KeyOfOtherKind {
        /// The key that is there in vain.
        key: String,
        /// The kind of the profile.
        kind: &'static str,
        /// The keys of this kind.
        takes: &'static [&'static str],
    },

    /// What is wrong with the columns or rows of a CSV file.
    #[error(transparent)]
    Csv(#[from] CsvProblem),
}

pub(super) fn list<S: AsRef<str>>(names: &[S]) -> String {
    names.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ")
}

/// `[1, 2, 3]`, each as short as it can be written.
pub(super) fn numbers(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| short(*value)).collect();
    format!("[{}]", texts.join(", "))
}

/// Four significant digits at most, an exponent only where it helps: eigenvalues come with rounding
/// errors nobody wants to read.
fn short(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-3..1e6).contains(&f64::abs(rounded)) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(numbers(&[0.1 + 0.2, -1.0, 1.234_56e-7]), "[0.3, -1, 1.235e-7]");
    }

    #[test]
    fn error_begins_with_file_and_line() {
        let place = Place { file: "a.toml".to_owned(), line: Some(3) };
        let error = InputError { place, problem: Problem::TooManyWheels { found: 9, most: 8 } };
        assert_eq!(
            error.to_string(),
            "a.toml:3: 9 [[wheel]] tables, but at most 8 are supported; remove some"
        );
    }
}
