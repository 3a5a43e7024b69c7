//! Craft files, scenarios and logs from Python objects.

use std::path::Path;

use host_sim::cli::verbs::{self, VerbFailed};
use host_sim::estimation::{EstimatorName, Method, Precision};
use host_sim::input::{Craft, RecordedLog, Scenario};
use numpy::{PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::Value;

/// A file of keys: the path of it, or the name of a built-in scenario, or its content as JSON.
pub struct Source {
    text: String,
    is_content: bool,
}

impl<'a, 'py> FromPyObject<'a, 'py> for Source {
    type Error = PyErr;

    /// A pair: text, and true for content.
    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let (text, is_content) = object.extract()?;
        Ok(Self { text, is_content })
    }
}

impl Source {
    /// The craft.
    pub fn craft(&self) -> PyResult<Craft> {
        let craft = match self.is_content {
            true => Craft::from_toml("craft", &self.toml("craft")?),
            false => Craft::load(Path::new(&self.text)),
        };
        craft.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The scenario. Tables named in a dictionary are below the current folder.
    pub fn scenario(&self) -> PyResult<Scenario> {
        let scenario = match self.is_content {
            true => Scenario::from_toml("scenario", &self.toml("scenario")?, Path::new("")),
            false => Scenario::load(&self.text),
        };
        scenario.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The content as TOML, the language of the files: one reader checks both.
    fn toml(&self, what: &str) -> PyResult<String> {
        let failed = |error: String| PyValueError::new_err(format!("{what}: {error}"));
        let value: Value =
            serde_json::from_str(&self.text).map_err(|error| failed(error.to_string()))?;
        let value = toml_of(what, &value).map_err(failed)?;
        toml::to_string(&value).map_err(|error| failed(error.to_string()))
    }
}

/// The value in TOML; `key` is the path of it in errors.
fn toml_of(key: &str, value: &Value) -> Result<toml::Value, String> {
    Ok(match value {
        Value::Null => return Err(format!("`{key}` is None; leave the key out")),
        Value::Bool(flag) => toml::Value::Boolean(*flag),
        Value::Number(number) => match (number.as_i64(), number.as_f64()) {
            (Some(integer), _) => toml::Value::Integer(integer),
            (None, Some(float)) => toml::Value::Float(float),
            (None, None) => return Err(format!("`{key}` is {number}; it exceeds the range")),
        },
        Value::String(text) => toml::Value::String(text.clone()),
        Value::Array(values) => {
            let values = values.iter().map(|value| toml_of(key, value));
            toml::Value::Array(values.collect::<Result<_, _>>()?)
        }
        Value::Object(table) => {
            let entries = table.iter().map(|(key, value)| Ok((key.clone(), toml_of(key, value)?)));
            toml::Value::Table(entries.collect::<Result<_, String>>()?)
        }
    })
}

/// A log: a file, or columns.
pub enum Log {
    /// Path.
    File(String),
    /// Names, and the cells of each column as texts. All columns have the same length.
    Columns(Vec<String>, Vec<Vec<String>>),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Log {
    type Error = PyErr;

    /// A path, or a list of pairs of name and column.
    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(path) = object.extract() {
            return Ok(Self::File(path));
        }
        let columns: Vec<(String, Bound<'py, PyAny>)> = object.extract()?;
        let mut cells = Vec::new();
        let mut names = Vec::new();
        for (name, column) in columns {
            cells.push(texts(&column)?);
            names.push(name);
        }
        let lengths = cells.iter().map(Vec::len);
        if let (Some(least), Some(most)) = (lengths.clone().min(), lengths.max())
            && least != most
        {
            let message = format!("log: columns of {least} and of {most} rows; make them equal");
            return Err(PyValueError::new_err(message));
        }
        Ok(Self::Columns(names, cells))
    }
}

/// Cells of a column: the shortest decimals that read back as the same numbers, nothing for a NaN.
fn texts(column: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let Ok(numbers) = column.extract::<PyReadonlyArray1<'_, f64>>() else {
        return column.extract();
    };
    let text = |x: &f64| if x.is_nan() { String::new() } else { format!("{x:?}") };
    let mut cells = Vec::with_capacity(numbers.len());
    cells.extend(numbers.as_array().iter().map(text));
    Ok(cells)
}

impl Log {
    /// The log as recorded, without corrections.
    pub fn read(self, craft: &Craft) -> Result<RecordedLog, VerbFailed> {
        match self {
            Self::File(path) => verbs::log_of_file(Path::new(&path), craft),
            Self::Columns(names, columns) => verbs::log_of_columns(names, &columns, craft),
        }
    }

    /// The craft file that it suggests.
    pub fn draft(self) -> Result<String, VerbFailed> {
        match self {
            Self::File(path) => verbs::draft_of_file(Path::new(&path)),
            Self::Columns(names, columns) => verbs::draft_of_columns(names, &columns),
        }
    }
}

/// Estimator and precision of these names.
pub fn method(estimator: &str, precision: &str) -> PyResult<Method> {
    let unknown = || {
        let names: Vec<String> = EstimatorName::all().map(|name| name.to_string()).collect();
        let names = names.join(", ");
        PyValueError::new_err(format!("estimator {estimator:?} is unknown; give one of: {names}"))
    };
    let precision = match precision {
        "f32" => Precision::F32,
        "f64" => Precision::F64,
        other => {
            let message = format!("precision {other:?} is unknown; give \"f32\" or \"f64\"");
            return Err(PyValueError::new_err(message));
        }
    };
    Ok(Method { estimator: EstimatorName::from_name(estimator).ok_or_else(unknown)?, precision })
}
