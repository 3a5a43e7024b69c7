//! Dependencies: those of the workspace and of a flight image, and their list in the CycloneDX format.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::program::{cargo, repository};

/// Target of the flight images.
pub const FLIGHT_TARGET: &str = "thumbv7em-none-eabihf";

/// Output of `cargo metadata`, as far as it is used.
#[derive(Debug, Deserialize)]
pub struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
    workspace_members: Vec<String>,
}

/// A package.
#[derive(Clone, Debug, Deserialize)]
pub struct Package {
    id: String,
    /// Name.
    pub name: String,
    /// Version.
    pub version: String,
    /// SPDX expression; none if the package states a file.
    pub license: Option<String>,
    /// Registry or repository; none for a path.
    pub source: Option<String>,
    /// Oldest compiler.
    pub rust_version: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

/// Kind of a dependency: none for a normal one, `build`, `dev`.
#[derive(Debug, Deserialize)]
struct Kind {
    kind: Option<String>,
}

impl Metadata {
    /// Of the workspace, for one target or for all.
    ///
    /// # Errors
    /// If `cargo metadata` fails.
    pub fn load(target: Option<&str>) -> Result<Self> {
        let mut command = cargo();
        command.args(["metadata", "--locked", "--format-version", "1"]);
        if let Some(target) = target {
            command.args(["--filter-platform", target]);
        }
        let output = command.output()?;
        serde_json::from_slice(&output.stdout)
            .with_context(|| String::from_utf8_lossy(&output.stderr).into_owned())
    }

    /// Packages of the whole workspace, tests and build scripts included.
    pub fn all(&self) -> Vec<&Package> {
        self.reached(self.workspace_members.clone(), |_| true)
    }

    /// Packages whose code is in an image of fsw-target, or generates such code.
    pub fn of_the_flight_image(&self) -> Vec<&Package> {
        let root = self.packages.iter().find(|package| package.name == "fsw-target");
        let is_normal = |kind: &Kind| kind.kind.is_none();
        self.reached(root.map(|root| root.id.clone()).into_iter().collect(), is_normal)
    }

    /// Packages reached from these by dependencies of a kind that `follows`.
    fn reached(&self, mut open: Vec<String>, follows: impl Fn(&Kind) -> bool) -> Vec<&Package> {
        let nodes: BTreeMap<&str, &Node> =
            self.resolve.nodes.iter().map(|node| (node.id.as_str(), node)).collect();
        let mut reached: BTreeSet<String> = BTreeSet::new();
        while let Some(id) = open.pop() {
            let dependencies = nodes.get(id.as_str()).map_or(&[][..], |node| &node.deps);
            let followed = dependencies.iter().filter(|of| of.dep_kinds.iter().any(&follows));
            if reached.insert(id.clone()) {
                open.extend(followed.map(|of| of.pkg.clone()));
            }
        }
        self.packages.iter().filter(|package| reached.contains(&package.id)).collect()
    }
}

/// Software bill of materials of a flight image with the default features, CycloneDX 1.5.
///
/// # Errors
/// If `cargo metadata` fails or `Cargo.lock` cannot be read.
pub fn bill_of_materials() -> Result<Value> {
    let metadata = Metadata::load(Some(FLIGHT_TARGET))?;
    let checksums = checksums()?;
    let mut packages = metadata.of_the_flight_image();
    packages.sort_by_key(|package| (&package.name, &package.version));
    let component = |package: &&Package| {
        let key = (package.name.clone(), package.version.clone());
        let url = format!("pkg:cargo/{}@{}", package.name, package.version);
        let mut component = json!({
            "type": "library", "name": package.name, "version": package.version,
            "bom-ref": url, "purl": url,
            "licenses": [{ "expression": package.license.as_deref().unwrap_or("NOASSERTION") }],
        });
        if let Some(checksum) = checksums.get(&key) {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
        }
        component
    };
    Ok(json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": { "component": { "type": "firmware", "name": "flight", "bom-ref": "flight" } },
        "components": packages.iter().map(component).collect::<Vec<_>>(),
    }))
}

/// SHA-256 of each package of `Cargo.lock` that has one, by name and version.
fn checksums() -> Result<BTreeMap<(String, String), String>> {
    #[derive(Deserialize)]
    struct Lock {
        package: Vec<Locked>,
    }
    #[derive(Deserialize)]
    struct Locked {
        name: String,
        version: String,
        checksum: Option<String>,
    }
    let lock: Lock = toml::from_str(&fs::read_to_string(repository().join("Cargo.lock"))?)?;
    let known = |locked: Locked| Some(((locked.name, locked.version), locked.checksum?));
    Ok(lock.package.into_iter().filter_map(known).collect())
}
