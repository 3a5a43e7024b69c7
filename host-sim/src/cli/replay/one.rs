//! One log, and its estimates.

use std::path::Path;

use super::super::Failure;
use super::super::estimate::{Estimated, estimate};
use super::super::notes::Notes;
use crate::diagnosis::diagnose;
use crate::estimation::{EstimatorName, Method, Precision};
use crate::input::{Craft, RecordedLog, interpolated, log_file, plausible, units};
use crate::report::{ExplanationReport, ReportFolder, table};

/// A log and the craft that recorded it.
pub(super) struct Replay<'a> {
    pub craft: &'a Craft,
    pub log: &'a Path,
    pub precision: Precision,
}

/// The log as read, for every estimator.
pub(super) struct Read {
    /// Name in messages.
    pub file: String,
    /// The craft, with the error of interpolated wheel speeds.
    craft: Craft,
    log: RecordedLog,
    notes: Vec<String>,
}

impl Replay<'_> {
    pub(super) fn read(&self, notes: &mut Notes) -> Result<Read, Failure> {
        let file = self.log.display().to_string();
        let mut log = log_file::load(self.log, self.craft)?;
        log.correct(&self.craft.hardware);
        let mut craft = self.craft.clone();
        let mut all = log.notes.clone();
        if let Some(interpolation) = &log.interpolation {
            all.extend(interpolated::add_error(&mut craft, interpolation));
        }
        all.extend(plausible::craft(&craft));
        all.extend(plausible::log(&log.rows).iter().map(|note| format!("{file}: {note}")));
        all.extend(units::note(&craft, &log.rows).map(|note| format!("{file}: {note}")));
        all.iter().for_each(|note| notes.add(note));
        Ok(Read { file, craft, log, notes: all })
    }

    pub(super) fn estimate(
        &self,
        read: &Read,
        estimator: EstimatorName,
        keep_history: bool,
        notes: Notes,
    ) -> Result<Estimated, Failure> {
        let Read { file, craft, log, .. } = read;
        let method = Method { estimator, precision: self.precision };
        let mut estimated =
            estimate(method, keep_history, craft, &log.rows, file, (&[], 0), notes)?;
        let report = &mut estimated.report;
        report.notes.splice(0..0, read.notes.iter().cloned());
        let skipped = log.skipped_rows.iter().map(|(reason, rows)| ((*reason).to_owned(), *rows));
        report.skipped_rows = skipped.collect();
        if report.is_unexplained() {
            let diagnosis = diagnose(craft, &log.rows);
            let explanations = diagnosis.iter().flat_map(|found| &found.explanations);
            report.explanations = explanations.map(ExplanationReport::from).collect();
        }
        Ok(estimated)
    }
}

pub(super) fn write_folder(
    folder: &Path,
    title: &str,
    command: &str,
    estimated: &Estimated,
) -> Result<(), Failure> {
    let table = table::replay(&estimated.report);
    ReportFolder {
        title,
        command,
        table: &table,
        result: &estimated.report,
        history: &estimated.history,
        notes: &estimated.report.notes,
        simulated: None,
    }
    .write(folder)?;
    Ok(())
}
