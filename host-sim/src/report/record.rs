//! Record of a campaign in the files of its runs: all that a merged report needs besides the rows.
//!
//! It is one JSON document in the Parquet metadata, under [`RECORD_KEY`].

use std::fmt;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::campaign::{Reference, Shard, Truths};
use crate::estimation::Method;
use crate::input::Scenario;
use crate::input::scenario::SourceFile;

/// Key of the record in the metadata of a Parquet file.
pub const RECORD_KEY: &str = "host-sim";
/// Version of the format of record and rows.
const FORMAT: u32 = 1;

/// Campaign and shard of a file of runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CampaignRecord {
    /// Version of the format of record and rows.
    pub format: u32,
    /// Version of the program that flew the runs.
    pub version: String,
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of its files and of its values as read, hexadecimal.
    pub scenario_sha256: String,
    /// Name of the estimator.
    pub estimator: String,
    /// Precision of the flight core: `f32` or `f64`.
    pub precision: String,
    /// Seed of the campaign's first run. Run `i` has `seed + i`.
    pub seed: u64,
    /// Runs of the whole campaign.
    pub runs: u64,
    /// Number of the shard, from 1.
    pub shard: u64,
    /// Number of shards.
    pub shards: u64,
    /// Mean of the true elements and RMS of the bounds. None if each run draws its own spacecraft.
    reference: Option<SharedReference>,
    /// Notes on the scenario, as on stderr.
    pub notes: Vec<String>,
    /// The scenario, and the tables that it names by a path below its folder.
    scenario_files: Vec<SourceFile>,
}

/// A [`Reference`], kg m².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct SharedReference {
    truth_kg_m2: [f64; 6],
    bound_kg_m2: [Option<f64>; 6],
    joint_bound_kg_m2: [Option<f64>; 6],
}

impl fmt::Display for SharedReference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{:?}, {:?}", self.truth_kg_m2, (self.bound_kg_m2, self.joint_bound_kg_m2))
    }
}

/// Scenario of a campaign, with what belongs to it.
pub struct CampaignScenario<'a> {
    /// Scenario.
    pub scenario: &'a Scenario,
    /// Its files.
    pub files: &'a [SourceFile],
    /// Its truths.
    pub truths: &'a Truths,
    /// Notes on it.
    pub notes: &'a [String],
}

impl CampaignRecord {
    /// Record of a shard of a campaign of `runs` from this seed.
    pub fn new(
        of: &CampaignScenario<'_>,
        method: Method,
        seed: u64,
        runs: u64,
        shard: Shard,
    ) -> Self {
        let shared = |reference: Reference| SharedReference {
            truth_kg_m2: reference.truth_kg_m2,
            bound_kg_m2: reference.bound_kg_m2,
            joint_bound_kg_m2: reference.joint_bound_kg_m2,
        };
        Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scenario: of.scenario.name.clone(),
            scenario_sha256: fingerprint(of.scenario, of.files),
            estimator: method.estimator.to_string(),
            precision: method.precision.to_string(),
            seed,
            runs,
            shard: shard.number(),
            shards: shard.count(),
            reference: of.truths.shared().map(shared),
            notes: of.notes.to_vec(),
            scenario_files: of.files.to_vec(),
        }
    }

    /// The shard; none if its numbers are not those of a shard.
    pub fn shard(&self) -> Option<Shard> {
        Shard::new(self.shard, self.shards).ok()
    }

    /// The record of the same campaign in one file.
    pub fn whole(&self) -> Self {
        Self { shard: 1, shards: 1, ..self.clone() }
    }

    /// Indices of the runs of the shard.
    pub fn indices(&self) -> std::ops::Range<u64> {
        self.shard().map_or(0..0, |shard| shard.runs_of(self.runs))
    }

    /// Seed of the first run of the shard.
    pub fn first_seed(&self) -> u64 {
        self.seed.wrapping_add(self.indices().start)
    }

    /// Mean of the true elements and RMS of the bounds; none if each run draws its own spacecraft.
    pub fn shared_reference(&self) -> Option<Reference> {
        self.reference.map(|shared| Reference {
            truth_kg_m2: shared.truth_kg_m2,
            bound_kg_m2: shared.bound_kg_m2,
            joint_bound_kg_m2: shared.joint_bound_kg_m2,
        })
    }

    /// Files of the scenario.
    pub fn scenario_files(&self) -> &[SourceFile] {
        &self.scenario_files
    }

    /// Command that flies the campaign in one process; the scenario is that of `scenario/`.
    pub fn command(&self) -> String {
        let Self { scenario, runs, seed, estimator, precision, .. } = self;
        format!(
            "cargo run --release -p host-sim -- mc {scenario} --runs {runs} --seed {seed} \
             --estimator {estimator} --precision {precision}"
        )
    }

    /// The first property in which another file is of another campaign: name, value here, value there.
    pub fn difference(&self, other: &Self) -> Option<[String; 3]> {
        let properties = |record: &Self| {
            [
                ("version", record.version.clone()),
                ("scenario", record.scenario.clone()),
                ("SHA-256 of the scenario", record.scenario_sha256.clone()),
                ("estimator", record.estimator.clone()),
                ("precision", record.precision.clone()),
                ("seed", record.seed.to_string()),
                ("number of runs", record.runs.to_string()),
                ("number of shards", record.shards.to_string()),
                // Of equal scenarios equal, except between mathematical libraries that round differently.
                ("truth and bound", record.reference.map_or(String::new(), |r| r.to_string())),
            ]
        };
        let pairs = properties(self).into_iter().zip(properties(other));
        let mut different = pairs.filter(|(here, there)| here != there);
        different.next().map(|((name, here), (_, there))| [name.to_owned(), here, there])
    }

    /// True for a format that this program reads.
    pub fn is_readable(&self) -> bool {
        self.format == FORMAT
    }
}

/// SHA-256 of the files of a scenario, and of its values as read: tables outside of its folder are among these.
fn fingerprint(scenario: &Scenario, files: &[SourceFile]) -> String {
    let mut hash = Sha256::new();
    for file in files {
        for text in [&file.name, &file.text] {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text.as_bytes());
        }
    }
    // Debug output has the shortest decimals that read back as the same numbers.
    hash.update(format!("{scenario:?}").as_bytes());
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
