//! Scenarios by path or by name.

use std::path::Path;

use flight_input::InputError;
use flight_input::error::Place;
use flight_input::toml_source::TomlSource;

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
}
