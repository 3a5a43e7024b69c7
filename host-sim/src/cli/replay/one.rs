//! One log, and its estimates.

use std::path::Path;

use super::super::Failure;
use super::super::estimate::{Estimated, estimate};
use super::super::notes::Notes;
use crate::diagnosis::diagnose;
use crate::estimation::{EstimatorName, Method, Precision, with_wheel_error};
use crate::input::{Craft, RecordedLog, log_file, plausible, units};
use crate::report::{ExplanationReport, FlightResult, ReportFolder};

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
    log: RecordedLog,
    notes: Vec<String>,
}

impl Replay<'_> {
    pub(super) fn read(&self, notes: &mut Notes) -> Result<Read, Failure> {
        let log = log_file::load(self.log, self.craft)?;
        Ok(self.corrected(log, notes))
    }

    /// A log as recorded, corrected by the known errors of the hardware.
    fn corrected(&self, mut log: RecordedLog, notes: &mut Notes) -> Read {
        let file = self.log.display().to_string();
        log.correct(&self.craft.hardware);
        let craft = self.craft;
        let mut all = log.notes.clone();
        all.extend(plausible::craft(craft));
        all.extend(plausible::log(&log.rows).iter().map(|note| format!("{file}: {note}")));
        all.extend(units::note(craft, &log.rows).map(|note| format!("{file}: {note}")));
        all.iter().for_each(|note| notes.add(note));
        Read { file, log, notes: all }
    }

    pub(super) fn estimate(
        &self,
        read: &Read,
        estimator: EstimatorName,
        keep_history: bool,
        mut notes: Notes,
    ) -> Result<Estimated, Failure> {
        let Read { file, log, .. } = read;
        let method = Method { estimator, precision: self.precision };
        let craft = &self.with_interpolation(method, read, &mut notes)?;
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

impl Replay<'_> {
    /// The craft, with the error of interpolated wheel speeds in the noise of its gyro.
    fn with_interpolation(
        &self,
        method: Method,
        read: &Read,
        notes: &mut Notes,
    ) -> Result<Craft, Failure> {
        let Some(error) = &read.log.interpolation else { return Ok(self.craft.clone()) };
        let failure = |error| Failure::SetUp { source_name: read.file.clone(), error };
        let (craft, on_wheels) =
            with_wheel_error(method, self.craft, &read.log.rows, error).map_err(failure)?;
        on_wheels.into_iter().for_each(|note| notes.add(note));
        Ok(craft)
    }
}

/// The estimate from a log as recorded, without printing; `file` is its name in errors.
pub(in super::super) fn replayed(
    file: &str,
    craft: &Craft,
    log: RecordedLog,
    method: Method,
) -> Result<Estimated, Failure> {
    let replay = Replay { craft, log: Path::new(file), precision: method.precision };
    let read = replay.corrected(log, &mut Notes::quiet());
    replay.estimate(&read, method.estimator, true, Notes::quiet())
}

/// Writes the report of a log; `inputs` are the files that were read.
pub(super) fn write_folder(
    folder: &Path,
    title: &str,
    command: &str,
    inputs: &[&Path],
    estimated: &Estimated,
) -> Result<(), Failure> {
    ReportFolder {
        title,
        command,
        result: FlightResult::Replay(&estimated.report),
        history: &estimated.history,
        inputs,
        simulated: None,
    }
    .write(folder)?;
    Ok(())
}
