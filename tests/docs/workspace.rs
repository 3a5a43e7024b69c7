//! Names that a command of a page may use: packages, targets, features, aliases, verbs and flags.

use std::collections::HashMap;
use std::fs;

use serde_json::Value;
use tests::program::{cargo, repository};

use super::command::host_sim_arguments;

/// Programs from outside the workspace that pages may name.
const EXTERNAL: [&str; 8] = [
    "qemu-system-arm",
    "rustup",
    "stty",
    "apt-get",
    "openssl",
    "STM32_Programmer_CLI",
    "gcc",
    "arm-none-eabi-gcc",
];

/// Cargo's own verbs that pages use.
const CARGO_VERBS: [&str; 8] =
    ["build", "run", "rustc", "test", "doc", "clippy", "package", "publish"];

/// Aliases that take an image, and `--board` with a feature of fsw-target.
const IMAGE_ALIASES: [&str; 2] = ["board", "qemu"];
/// Packages with images.
const IMAGE_PACKAGES: [&str; 2] = ["fsw-target", "fsw-bringup"];

/// Packages of the workspace with the names of their targets and features.
pub struct Workspace {
    packages: HashMap<String, Vec<String>>,
    aliases: Vec<String>,
    profiles: Vec<String>,
}

impl Workspace {
    pub fn load() -> Self {
        let metadata =
            cargo().args(["metadata", "--no-deps", "--format-version", "1"]).output().unwrap();
        let metadata: Value = serde_json::from_slice(&metadata.stdout).unwrap();
        let packages = metadata["packages"].as_array().unwrap().iter().map(names).collect();
        let read = |name: &str| fs::read_to_string(repository().join(name)).unwrap();
        let config = read(".cargo/config.toml");
        let aliases = config.split_once("[alias]").unwrap().1.lines();
        let aliases = aliases.filter_map(|line| line.split_once(" = "));
        let manifest = read("Cargo.toml");
        let profile = |line: &str| Some(line.strip_prefix("[profile.")?.strip_suffix(']')?.into());
        Self {
            packages,
            aliases: aliases.map(|(name, _)| name.to_owned()).collect(),
            profiles: manifest.lines().filter_map(profile).chain(["release".into()]).collect(),
        }
    }

    /// Checks one program with its arguments. Variables of its environment before it are not checked.
    pub fn check(&self, words: &[String]) -> Result<(), String> {
        let variables = words.iter().take_while(|word| is_variable(word)).count();
        let words = &words[variables..];
        if let Some(arguments) = host_sim_arguments(words) {
            return check_host_sim(arguments);
        }
        match words.first().ok_or("variables without a program")?.as_str() {
            "cargo" => self.check_cargo(&words[1..]),
            program if EXTERNAL.contains(&program) => Ok(()),
            script if repository().join(script).exists() => Ok(()),
            _ => Err("an unknown program".into()),
        }
    }

    fn check_cargo(&self, words: &[String]) -> Result<(), String> {
        let verb = words.first().ok_or("cargo without a verb")?;
        if self.aliases.contains(verb) {
            if IMAGE_ALIASES.contains(&verb.as_str()) {
                let mut names = words[1..].iter().filter(|word| *word != "--board");
                return names.try_for_each(|name| self.check_image(name));
            }
            return if words.len() > 1 { self.check_cargo(&words[1..]) } else { Ok(()) };
        }
        if !CARGO_VERBS.contains(&verb.as_str()) {
            return Err(format!("cargo has no verb or alias `{verb}`"));
        }
        let mut package = None;
        let mut words = words[1..].iter().take_while(|word| *word != "--");
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "-p" | "--package" => package = Some(self.package(value()?)?),
                "--bin" | "--test" | "--example" | "--features" => {
                    let package = package.ok_or("names no package")?;
                    let mut names = value()?.split(',');
                    names.try_for_each(|name| self.check_name(package, name))?;
                }
                "--profile" => {
                    let profile = value()?;
                    let is_known = self.profiles.contains(profile);
                    is_known.then_some(()).ok_or(format!("no profile `{profile}`"))?;
                }
                "--crate-type" => {
                    value()?;
                }
                "--release"
                | "--no-default-features"
                | "--workspace"
                | "--no-deps"
                | "--open"
                | "--lib"
                | "--doc" => {}
                "--dry-run" if verb == "publish" => {}
                // Part of the names of tests.
                filter if verb == "test" && !filter.starts_with('-') => {}
                other => return Err(format!("an unknown flag `{other}`")),
            }
        }
        Ok(())
    }

    fn package<'a>(&self, name: &'a str) -> Result<&'a str, String> {
        self.packages.contains_key(name).then_some(name).ok_or(format!("no package `{name}`"))
    }

    /// An image, or a feature of the flight software.
    fn check_image(&self, name: &str) -> Result<(), String> {
        let is_known = IMAGE_PACKAGES.iter().any(|package| self.check_name(package, name).is_ok());
        is_known.then_some(()).ok_or(format!("no image or feature `{name}`"))
    }

    /// A target or a feature of a package.
    fn check_name(&self, package: &str, name: &str) -> Result<(), String> {
        let is_known = self.packages[package].iter().any(|known| known == name);
        is_known.then_some(()).ok_or(format!("{package} has no target or feature `{name}`"))
    }
}

/// A package with the names of its targets and features.
fn names(package: &Value) -> (String, Vec<String>) {
    let targets = package["targets"].as_array().unwrap().iter().map(|target| &target["name"]);
    let targets = targets.map(|name| name.as_str().unwrap().to_owned());
    let features = package["features"].as_object().unwrap().keys().cloned();
    (package["name"].as_str().unwrap().to_owned(), targets.chain(features).collect())
}

/// Verbs and flags of `host-sim`, by its help.
fn check_host_sim(arguments: &[String]) -> Result<(), String> {
    let is_word = |word: &&String| word.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    let verbs = if arguments[0] == "command" { 2 } else { 1 };
    let verbs: Vec<&str> =
        arguments.iter().take(verbs).filter(is_word).map(String::as_str).collect();
    let help =
        super::host_sim().output(&[&verbs[..], &["--help"]].concat()).map_err(|e| e.to_string())?;
    let flags = arguments.iter().filter(|word| word.starts_with("--") && *word != "--help");
    let mut unknown = flags.filter(|flag| !help.contains(flag.as_str()));
    unknown.next().map_or(Ok(()), |flag| Err(format!("{verbs:?} has no flag `{flag}`")))
}

/// True for `NAME=value`.
fn is_variable(word: &str) -> bool {
    let name = word.split_once('=').map_or("", |(name, _)| name);
    !name.is_empty() && name.chars().all(|c| c.is_ascii_uppercase() || c == '_')
}
