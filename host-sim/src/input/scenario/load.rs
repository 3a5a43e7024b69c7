//! Scenarios by path or by name.

use std::fs;
use std::path::{Component, Path};

use flight_input::InputError;
use flight_input::error::Place;
use flight_input::toml_source::TomlSource;
use serde::{Deserialize, Serialize};

use super::definition::Scenario;
use super::problem::ScenarioProblem;
use super::{built_in, file};

impl Scenario {
    /// The scenario in the file at this path if the file exists or the name ends in `.toml`, else the
    /// built-in scenario of this name.
    ///
    /// # Errors
    /// Neither exists, or the file has an unknown key or a value outside the range of its key.
    pub fn load(name_or_path: &str) -> Result<Self, InputError> {
        let path = Path::new(name_or_path);
        if path.is_file() || path.extension().is_some_and(|extension| extension == "toml") {
            let folder = path.parent().unwrap_or(Path::new(""));
            return file::read(&TomlSource::read(path)?, folder);
        }
        match built_in::text(name_or_path) {
            Some(text) => Self::from_toml(name_or_path, text, Path::new("")),
            None => {
                let built_in = built_in::built_in_names().map(str::to_owned).collect();
                Err(InputError {
                    place: Place { file: name_or_path.to_owned(), line: None },
                    problem: ScenarioProblem::UnknownScenario { built_in }.into(),
                })
            }
        }
    }

    /// The scenario in the text of a `SCENARIO.toml`; `file` is the name in errors, `folder` that of
    /// the CSV tables it names.
    ///
    /// # Errors
    /// An unknown key, or a value outside the range of its key.
    pub fn from_toml(file: &str, text: &str, folder: &Path) -> Result<Self, InputError> {
        file::read(&TomlSource::new(file, text), folder)
    }
}

/// A file of a scenario.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFile {
    /// Path relative to the scenario; `scenario.toml` for the scenario itself.
    pub name: String,
    /// Content.
    pub text: String,
}

/// The scenario of this path or name as text, and the CSV tables that it names by a path below its own folder.
///
/// # Errors
/// Those of [`Scenario::load`] for a file that cannot be read.
pub fn sources(name_or_path: &str) -> Result<Vec<SourceFile>, InputError> {
    let own = |text: &str| SourceFile { name: "scenario.toml".to_owned(), text: text.to_owned() };
    let path = Path::new(name_or_path);
    let built_in = built_in::text(name_or_path).filter(|_| !path.is_file());
    if let Some(text) = built_in {
        return Ok(vec![own(text)]);
    }
    let source = TomlSource::read(path)?;
    let text = source.text();
    let mut files = vec![own(text)];
    let document: toml::Table = text.parse().unwrap_or_default();
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut names = Vec::new();
    tables_of(&toml::Value::Table(document), &mut names);
    names.sort_unstable();
    names.dedup();
    for name in names {
        let is_below = Path::new(&name).components().all(|c| matches!(c, Component::Normal(_)));
        if let (true, Ok(text)) = (is_below, fs::read_to_string(folder.join(&name))) {
            files.push(SourceFile { name, text });
        }
    }
    Ok(files)
}

/// Values of all keys `csv`.
fn tables_of(value: &toml::Value, names: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                match value {
                    toml::Value::String(name) if key == "csv" => names.push(name.clone()),
                    value => tables_of(value, names),
                }
            }
        }
        toml::Value::Array(values) => values.iter().for_each(|value| tables_of(value, names)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_name_is_reported_with_the_built_in_scenarios() {
        let message = Scenario::load("stsat").unwrap_err().to_string();
        assert!(message.starts_with("stsat: neither a file nor a built-in scenario"), "{message}");
        assert!(message.contains("stsat3-spin-up, stsat3-spin-up-wrong-prior"), "{message}");
        let message = Scenario::load("gone.toml").unwrap_err().to_string();
        assert!(message.starts_with("gone.toml: cannot be read: "), "{message}");
    }

    #[test]
    fn sources_of_a_file_have_its_tables() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        let text = "[[wheel]]\ntorque = { kind = 'table', csv = 'tables/a.csv' }\n[torque]\ncsv = '../b.csv'\n";
        fs::write(&path, text).unwrap();
        fs::create_dir(folder.path().join("tables")).unwrap();
        fs::write(folder.path().join("tables/a.csv"), "t_s,x\n").unwrap();
        let files = sources(path.to_str().unwrap()).unwrap();
        let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(names, ["scenario.toml", "tables/a.csv"]);
        assert_eq!((files[0].text.as_str(), files[1].text.as_str()), (text, "t_s,x\n"));
        assert_eq!(sources("stsat3-spin-up").unwrap().len(), 1);
    }
}
