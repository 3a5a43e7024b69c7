//! Supply chain: licences, duplicates and sources as `deny.toml` states them, oldest compiler, bill of materials.
//!
//! `cargo deny check` covers the same file and the advisories, for which it needs the network.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use serde::Deserialize;
use spdx::{Expression, Licensee, ParseMode};
use tests::program::{cargo, repository};
use tests::supply::{FLIGHT_TARGET, Metadata, Product, bill_of_materials, notices};

/// `deny.toml`, as far as it is checked here.
#[derive(Deserialize)]
struct Policy {
    licenses: Licenses,
    bans: Bans,
    sources: Sources,
}

#[derive(Deserialize)]
struct Licenses {
    allow: Vec<String>,
}

#[derive(Deserialize)]
struct Bans {
    skip: Vec<Skipped>,
}

#[derive(Deserialize)]
struct Skipped {
    #[serde(rename = "crate")]
    package: String,
    reason: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Sources {
    allow_registry: Vec<String>,
}

fn policy() -> Policy {
    toml::from_str(&fs::read_to_string(repository().join("deny.toml")).unwrap()).unwrap()
}

#[test]
fn every_licence_is_allowed() {
    let allowed: Vec<Licensee> =
        policy().licenses.allow.iter().map(|name| Licensee::parse(name).unwrap()).collect();
    let mut used = BTreeSet::new();
    for package in Metadata::load(None).unwrap().all() {
        let text = package.license.as_deref().unwrap_or("NOASSERTION");
        // Old packages have `MIT/Apache-2.0`.
        let licence = Expression::parse_mode(text, ParseMode::LAX).unwrap();
        let is_allowed = licence.evaluate(|required| {
            let found = allowed.iter().position(|licensee| licensee.satisfies(required));
            used.extend(found);
            found.is_some()
        });
        assert!(is_allowed, "{} {}: {text}", package.name, package.version);
    }
    assert_eq!(used.len(), allowed.len(), "an allowed licence that no package has");
}

#[test]
fn every_duplicate_is_stated() {
    let metadata = Metadata::load(None).unwrap();
    let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for package in metadata.all() {
        versions.entry(&package.name).or_default().insert(&package.version);
    }
    let skipped = policy().bans.skip;
    assert!(skipped.iter().all(|skipped| !skipped.reason.is_empty()));
    let is_skipped = |name: &str, version: &str| {
        skipped.iter().any(|skipped| skipped.package == format!("{name}@{version}"))
    };
    let mut stated = 0;
    for (name, versions) in versions {
        let others: Vec<_> = versions.iter().filter(|version| !is_skipped(name, version)).collect();
        assert_eq!(others.len(), 1, "{name}: {versions:?}; state one in deny.toml");
        stated += versions.len() - 1;
    }
    assert_eq!(stated, skipped.len(), "deny.toml states a duplicate that is none");
}

#[test]
fn every_package_is_from_the_registry_or_this_workspace() {
    let allowed = policy().sources.allow_registry;
    for package in Metadata::load(None).unwrap().all() {
        let Some(source) = &package.source else { continue };
        let is_allowed = allowed.iter().any(|url| *source == format!("registry+{url}"));
        assert!(is_allowed, "{}: {source}", package.name);
    }
}

/// Numbers of a version.
fn numbers(version: &str) -> Vec<u32> {
    version.split('.').map(|number| number.parse().unwrap()).collect()
}

#[test]
fn no_package_needs_a_newer_compiler_than_stated() {
    let metadata = Metadata::load(None).unwrap();
    let own = metadata.all().into_iter().find(|package| package.name == "fsw-core").unwrap();
    let stated = numbers(own.rust_version.as_deref().unwrap());
    for package in metadata.all() {
        let needed = package.rust_version.as_deref().map(numbers);
        assert!(
            needed.is_none_or(|needed| needed <= [&stated[..], &[u32::MAX]].concat()),
            "{package:?}"
        );
    }
}

#[test]
fn bill_of_materials_has_every_package_with_licence_and_checksum() {
    let metadata = Metadata::load(Some(FLIGHT_TARGET)).unwrap();
    for (product, with) in [(Product::Flight, "cmac"), (Product::C, "libm")] {
        let bill = bill_of_materials(product).unwrap();
        let format = (&bill["bomFormat"], &bill["specVersion"]);
        assert_eq!(format, (&"CycloneDX".into(), &"1.5".into()));
        let packages = metadata.of(product);
        let own = packages.iter().filter(|package| package.source.is_none());
        let own: BTreeSet<&str> = own.map(|package| package.name.as_str()).collect();
        let components = bill["components"].as_array().unwrap();
        println!("{product:?}: {} components", components.len());
        let names: BTreeSet<&str> =
            components.iter().map(|c| c["name"].as_str().unwrap()).collect();
        assert!(["nalgebra", "fsw-core", with].iter().all(|name| names.contains(name)));
        assert!(!names.contains("proptest") && !names.contains("clap"), "not of the product");
        for component in components {
            let name = component["name"].as_str().unwrap();
            let is_own = own.contains(name);
            assert_ne!(component["licenses"][0]["expression"], "NOASSERTION", "{component}");
            assert!(is_own || component["hashes"][0]["content"].is_string(), "{component}");
        }
    }
}

#[test]
fn notices_have_the_licence_of_every_package_from_elsewhere() {
    let metadata = Metadata::load(Some(FLIGHT_TARGET)).unwrap();
    for product in [Product::Flight, Product::C] {
        let text = notices(product).unwrap();
        let foreign = metadata.of(product).into_iter().filter(|package| package.source.is_some());
        for package in foreign {
            let heading = format!("\n{} {}: ", package.name, package.version);
            assert_eq!(text.matches(&heading).count(), 1, "{heading}");
        }
        assert!(text.contains("Apache License") && text.contains("Permission is hereby granted"));
    }
}

/// Crates that stand alone, as for a release, without one: `cargo publish --dry-run`, which compiles each from its
/// package, with the versions that the registry has.
#[test]
#[ignore = "asks the registry: tests/check.sh runs it"]
fn crates_that_stand_alone_can_be_published() {
    let metadata = Metadata::load(None).unwrap();
    let published: Vec<_> =
        metadata.all().into_iter().filter(|package| package.is_published()).collect();
    let own: Vec<_> = published.into_iter().filter(|package| package.source.is_none()).collect();
    let names: BTreeSet<&str> = own.iter().map(|package| package.name.as_str()).collect();
    assert_eq!(names, BTreeSet::from(["bmi088-gyro", "fsw-core", "wheel-tach"]));
    for package in own {
        for file in ["README.md", "CHANGELOG.md"] {
            assert!(package.folder().join(file).is_file(), "{}: no {file}", package.name);
        }
        let check = cargo()
            .args(["publish", "--dry-run", "--allow-dirty", "--package", &package.name])
            .output()
            .unwrap();
        let log = String::from_utf8_lossy(&check.stderr);
        assert!(check.status.success(), "{}: {log}", package.name);
        assert!(log.contains("Verifying"), "{log}");
    }
}
