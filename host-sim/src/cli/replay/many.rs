//! Several logs, several estimators: one row each.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::super::notes::Notes;
use super::super::progress::Progress;
use super::super::{Failure, command_line, print};
use super::one::{Read, Replay, write_folder};
use super::{Arguments, stop_at, title};
use crate::estimation::EstimatorName;
use crate::input::Craft;
use crate::report::campaign_dir::write_logs;
use crate::report::{LogReport, table};

/// Most notes on stderr; the documents have all of them.
const MOST_NOTES: usize = 20;

pub(super) fn run(
    arguments: &Arguments,
    craft: &Craft,
    logs: &[PathBuf],
    estimators: &[EstimatorName],
) -> Result<(), Failure> {
    let folders = folders(arguments.out.as_deref(), logs);
    let command = command_line();
    let bar = Progress::new(logs.len() as u64, "logs");
    let one = |(log, folder): &(&PathBuf, Option<PathBuf>)| {
        let replay = Replay { craft, log, precision: arguments.precision };
        let results = match replay.read(&mut Notes::quiet()) {
            Ok(read) => (estimators.iter())
                .map(|estimator| {
                    let folder = folder.as_ref().map(|folder| match estimators.len() {
                        1 => folder.clone(),
                        _ => folder.join(estimator.properties().name),
                    });
                    let craft = (&replay, arguments.craft.as_path());
                    let (report, failure) =
                        result(craft, &read, *estimator, folder.as_deref(), &command);
                    (report, failure, folder.filter(|folder| folder.join("report.html").exists()))
                })
                .collect(),
            Err(failure) => {
                let report = LogReport::failed(log, "", &failure.to_string());
                vec![(report, Some(failure), None)]
            }
        };
        bar.inc(1);
        results
    };
    let jobs: Vec<_> = logs.iter().zip(folders).collect();
    let results: Vec<Vec<_>> = jobs.par_iter().map(one).collect();
    bar.finish();

    let (mut reports, mut failures, mut links) = (Vec::new(), Vec::new(), Vec::new());
    for (report, failure, folder) in results.into_iter().flatten() {
        reports.push(report);
        failures.extend(failure);
        links.push(folder.and_then(|folder| link(arguments.out.as_deref()?, &folder)));
    }
    show_notes(&reports);
    if let Some(out) = &arguments.out {
        write_logs(out, &reports, &links, &command)?;
    }
    print(arguments.json, &reports, &table::logs(&reports))?;
    // A report that cannot be written is a fault of the run, a log that cannot be read one of the input.
    let worst = failures.iter().map(Failure::exit_code).min();
    if let Some(exit_code) = worst {
        return Err(Failure::SomeLogs { failed: failures.len(), of: reports.len(), exit_code });
    }
    stop_at(&arguments.fail_on, reports.iter().filter_map(|report| report.result.as_ref()))
}

/// Estimate of one log by one estimator.
fn result(
    (replay, craft): (&Replay<'_>, &Path),
    read: &Read,
    estimator: EstimatorName,
    folder: Option<&Path>,
    command: &str,
) -> (LogReport, Option<Failure>) {
    let name = estimator.properties().name;
    let estimated = replay.estimate(read, estimator, folder.is_some(), Notes::quiet());
    let written = estimated.and_then(|estimated| {
        if let Some(folder) = folder {
            let (title, inputs) = (title(&read.file, estimator), [replay.log, craft]);
            write_folder(folder, &title, command, &inputs, &estimated)?;
        }
        Ok(estimated)
    });
    match written {
        Ok(estimated) => (LogReport::of(replay.log, estimated.report), None),
        Err(failure) => (LogReport::failed(replay.log, name, &failure.to_string()), Some(failure)),
    }
}

/// Link from a page in `out` to a folder within it.
fn link(out: &Path, folder: &Path) -> Option<String> {
    let within = folder.strip_prefix(out).ok()?;
    let parts: Vec<_> = within.iter().map(|part| part.to_string_lossy()).collect();
    // These end the path of a link.
    let path = parts.join("/");
    Some(path.replace('%', "%25").replace('#', "%23").replace('?', "%3F"))
}

/// Folder of each log: its name without the ending; with the names of its folders where two are equal.
fn folders(out: Option<&Path>, logs: &[PathBuf]) -> Vec<Option<PathBuf>> {
    let Some(out) = out else { return vec![None; logs.len()] };
    let mut taken = HashSet::new();
    let folder = |log: &PathBuf| {
        let name = log.file_name().unwrap_or(log.as_os_str()).to_string_lossy().into_owned();
        let stem = match name.split_once('.') {
            Some((stem, _)) if !stem.is_empty() => stem.to_owned(),
            _ => name,
        };
        let mut folder = stem.clone();
        let mut parents = log.ancestors().skip(1).filter_map(Path::file_name);
        while !taken.insert(folder.clone()) {
            folder = match parents.next() {
                Some(parent) => format!("{}-{folder}", parent.to_string_lossy()),
                None => format!("{folder}-{}", taken.len()),
            };
        }
        Some(out.join(folder))
    };
    logs.iter().map(folder).collect()
}

/// Notes of all logs on stderr: equal ones once, with the number of logs.
fn show_notes(reports: &[LogReport]) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let notes = reports.iter().filter_map(|report| report.result.as_ref()).flat_map(|r| &r.notes);
    notes.for_each(|note| *counts.entry(note).or_default() += 1);
    for (note, count) in counts.iter().take(MOST_NOTES) {
        match count {
            1 => eprintln!("note: {note}"),
            count => eprintln!("note: {count} logs: {note}"),
        }
    }
    if let Some(more) = counts.len().checked_sub(MOST_NOTES).filter(|more| *more > 0) {
        eprintln!("note: {more} further notes are in the documents of --json and --out");
    }
    for report in reports {
        if let Some(error) = &report.error {
            eprintln!("error: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_log_has_a_folder_of_its_own() {
        let logs = ["a/x.csv", "b/x.csv.gz", "x.csv", "-"].map(PathBuf::from);
        let folders = folders(Some(Path::new("out")), &logs);
        let names: Vec<_> =
            folders.iter().map(|f| f.as_ref().unwrap().display().to_string()).collect();
        assert_eq!(names, ["out/x", "out/b-x", "out/x-2", "out/-"]);
    }
}
