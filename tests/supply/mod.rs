//! Dependencies of the workspace and of what is built from it: their list in the CycloneDX format, and the texts of their
//! licences.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::program::{cargo, repository};

/// Target of the flight images.
pub const FLIGHT_TARGET: &str = "thumbv7em-none-eabihf";

/// Something that is delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Product {
    /// A flight image with the default features.
    Flight,
    /// The static library of the C interface.
    C,
}

impl Product {
    /// Package of the workspace that it is built from.
    fn package(self) -> &'static str {
        match self {
            Self::Flight => "fsw-target",
            Self::C => "fsw-core-c",
        }
    }
}

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
    manifest_path: String,
    /// Registries to which it may be published; none for any.
    publish: Option<Vec<String>>,
}

impl Package {
    /// True if it may be published.
    pub fn is_published(&self) -> bool {
        self.publish.is_none()
    }

    /// Folder of its manifest.
    pub fn folder(&self) -> &Path {
        let manifest = Path::new(&self.manifest_path);
        manifest.parent().unwrap_or(manifest)
    }
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

    /// Packages whose code is in a product, or generates such code, by name.
    pub fn of(&self, product: Product) -> Vec<&Package> {
        let root = self.packages.iter().find(|package| package.name == product.package());
        let is_normal = |kind: &Kind| kind.kind.is_none();
        let root = root.map(|root| root.id.clone()).into_iter().collect();
        let mut packages = self.reached(root, is_normal);
        packages.sort_by_key(|package| (&package.name, &package.version));
        packages
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

/// Licences of the packages from elsewhere in a product: name, version, SPDX expression, and the text of each file
/// of a licence beside the package's manifest.
///
/// # Errors
/// If `cargo metadata` fails or a file cannot be read.
pub fn notices(product: Product) -> Result<String> {
    let mut text = String::new();
    for package in Metadata::load(Some(FLIGHT_TARGET))?.of(product) {
        if package.source.is_none() {
            continue;
        }
        let licence = package.license.as_deref().unwrap_or("NOASSERTION");
        let rule = "=".repeat(72);
        text += &format!("{rule}\n{} {}: {licence}\n{rule}\n\n", package.name, package.version);
        for (name, content) in licence_files(package.folder())? {
            text += &format!("--- {name}\n\n{}\n\n", content.trim_end());
        }
    }
    Ok(text)
}

/// Name and content of the files of a folder whose names state a licence.
fn licence_files(folder: &Path) -> Result<BTreeMap<String, String>> {
    let is_licence = |name: &str| {
        let name = name.to_uppercase();
        ["LICENSE", "LICENCE", "COPYING", "NOTICE", "COPYRIGHT"]
            .iter()
            .any(|of| name.starts_with(of))
    };
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if is_licence(&name) && entry.file_type()?.is_file() {
            files.insert(name, fs::read_to_string(entry.path())?);
        }
    }
    Ok(files)
}

/// Software bill of materials of a product, CycloneDX 1.5.
///
/// # Errors
/// If `cargo metadata` fails or `Cargo.lock` cannot be read.
pub fn bill_of_materials(product: Product) -> Result<Value> {
    let metadata = Metadata::load(Some(FLIGHT_TARGET))?;
    let checksums = checksums()?;
    let packages = metadata.of(product);
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
    let (kind, name) = match product {
        Product::Flight => ("firmware", "flight"),
        Product::C => ("library", "libfsw_core_c"),
    };
    Ok(json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": { "component": { "type": kind, "name": name, "bom-ref": name } },
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
