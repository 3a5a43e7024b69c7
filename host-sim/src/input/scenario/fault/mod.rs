//! `[[fault]]`: faults of gyro, clock, tachometers, torque report and computer, between the sensors and
//! the estimator.
//!
//! ```toml
//! [[fault]]
//! kind = "tachometer_freeze"
//! start_s = 30.0
//! latest_start_s = 60.0     # drawn uniformly from start_s to this, by the seed
//! duration_s = 10.0
//! wheel = 2                 # from 1; absent: all wheels
//! ```
//!
//! The true motion is that of the scenario without faults: a torque that is commanded and does not act
//! is a reported torque that the body does not feel.

mod kinds;

use flight_input::InputError;
use flight_input::error::Problem;
use flight_input::key::{Key, NOT_NEGATIVE, NUMBER, Range, TEXT, Table};
use flight_input::nearest::nearest;
use flight_input::section::Section;
use flight_input::words::list;
use serde::Deserialize;
use toml::Spanned;

use super::problem::ScenarioProblem;
pub use kinds::{FaultKind, KINDS, KindProperties};

const KIND_NAMES: Range = Range::new("a kind of the table below", |_| true);
const OF_KIND: Range = Range::new("that of the kind", |_| true);
const SHARES: Range = Range::new("above 0, at most 1", |x| x > 0.0 && x <= 1.0);
const AXES: Range = Range::new("x, y or z", |_| true);
const WHEELS: Range = Range::new("1 to the number of wheels", |x| x >= 1.0 && x.fract() == 0.0);
const LATER: Range = Range::new("start_s or later", |x| x.is_finite());

const KIND: Key = Key::required("kind", TEXT, "", KIND_NAMES, "Kind of the fault");
const START: Key =
    Key::required("start_s", NUMBER, "s", NOT_NEGATIVE, "Time of the start since the first sample");
const LATEST_START: Key = Key::required(
    "latest_start_s",
    NUMBER,
    "s",
    LATER,
    "Latest start: the start is drawn uniformly from `start_s` to this",
)
.or("`start_s`");
pub(super) const DURATION: Key = Key::required(
    "duration_s",
    NUMBER,
    "s",
    NOT_NEGATIVE,
    "Duration; 0 is one sample, or a restart without loss of samples",
)
.or("0");
pub(super) const MAGNITUDE: Key =
    Key::required("magnitude", NUMBER, "of the kind", OF_KIND, "Magnitude")
        .or("required if the kind has one");
pub(super) const SHARE: Key =
    Key::required("share", NUMBER, "", SHARES, "Probability of the fault, per sample").or("1");
pub(super) const AXIS: Key = Key::required("axis", TEXT, "", AXES, "Axis").or("all axes");
pub(super) const WHEEL: Key =
    Key::required("wheel", NUMBER, "", WHEELS, "Number of the wheel").or("all wheels");

/// The keys of `[[fault]]`.
pub(super) const TABLE: Table = Table {
    header: "[[fault]]",
    about: "A fault between sensors and estimator, which the estimator does not know of. Optional.",
    keys: &[KIND, START, LATEST_START, DURATION, MAGNITUDE, SHARE, AXIS, WHEEL],
};

/// A fault of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Kind.
    pub kind: FaultKind,
    /// Earliest start, s since the first sample.
    pub start_s: f64,
    /// Latest start, s.
    pub latest_start_s: f64,
    /// Duration, s; zero for a single sample.
    pub duration_s: f64,
    /// Magnitude in the unit of the kind; zero if it has none.
    pub magnitude: f64,
    /// Probability per sample.
    pub share: f64,
    /// Axis; none for all.
    pub axis: Option<usize>,
    /// Wheel, from 0; none for all.
    pub wheel: Option<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultFile {
    kind: Spanned<String>,
    start_s: Spanned<f64>,
    latest_start_s: Option<Spanned<f64>>,
    duration_s: Option<Spanned<f64>>,
    magnitude: Option<Spanned<f64>>,
    share: Option<Spanned<f64>>,
    axis: Option<Spanned<String>>,
    wheel: Option<Spanned<f64>>,
}

/// The checked fault of a craft with this number of wheels.
pub(super) fn read(
    section: &Section<'_>,
    file: &Spanned<FaultFile>,
    wheels: usize,
) -> Result<Fault, InputError> {
    let table = file.get_ref();
    let kind = table.kind(section)?;
    let properties = kind.properties();
    table.check_surplus(section, properties)?;
    let start_s = section.number(&START, &table.start_s)?;
    let latest = table.latest_start_s.as_ref();
    let latest_start_s = latest
        .map(|latest| section.number_if(&LATEST_START, latest, |latest_s| latest_s >= start_s))
        .transpose()?;
    let range = Key { range: properties.range, ..MAGNITUDE };
    let magnitude = match &table.magnitude {
        Some(magnitude) => section.number(&range, magnitude)?,
        None if properties.takes(&MAGNITUDE) => return Err(section.missing(&MAGNITUDE, file)),
        None => 0.0,
    };
    let wheel = (table.wheel.as_ref())
        .map(|wheel| section.number_if(&WHEEL, wheel, |number| number <= wheels as f64))
        .transpose()?;
    Ok(Fault {
        kind,
        start_s,
        latest_start_s: latest_start_s.unwrap_or(start_s),
        duration_s: section.optional_number(&DURATION, &table.duration_s)?.unwrap_or(0.0),
        magnitude,
        share: section.optional_number(&SHARE, &table.share)?.unwrap_or(1.0),
        axis: table.axis(section)?,
        wheel: wheel.map(|number| (number as usize).saturating_sub(1)),
    })
}

impl FaultFile {
    fn kind(&self, section: &Section<'_>) -> Result<FaultKind, InputError> {
        let name = self.kind.get_ref();
        FaultKind::from_name(name).ok_or_else(|| {
            let known = KINDS.map(|row| row.name);
            let nearest = nearest(name, &known).unwrap_or_default();
            let required = format!("one of {} (did you mean `{nearest}`?)", list(&known));
            let found = format!("\"{name}\"");
            let problem = Problem::BadValue { key: section.full(&KIND), found, required };
            section.error(&self.kind, problem)
        })
    }

    fn axis(&self, section: &Section<'_>) -> Result<Option<usize>, InputError> {
        let Some(axis) = &self.axis else { return Ok(None) };
        match axis.get_ref().as_str() {
            "x" => Ok(Some(0)),
            "y" => Ok(Some(1)),
            "z" => Ok(Some(2)),
            other => Err(section.out_of_range(&AXIS, axis, format!("\"{other}\""))),
        }
    }

    /// Rejects a key that the kind does not take.
    fn check_surplus(
        &self,
        section: &Section<'_>,
        kind: &KindProperties,
    ) -> Result<(), InputError> {
        let present = [
            (&DURATION, self.duration_s.as_ref().map(Spanned::span)),
            (&MAGNITUDE, self.magnitude.as_ref().map(Spanned::span)),
            (&SHARE, self.share.as_ref().map(Spanned::span)),
            (&AXIS, self.axis.as_ref().map(Spanned::span)),
            (&WHEEL, self.wheel.as_ref().map(Spanned::span)),
        ];
        for (key, span) in present {
            if let Some(span) = span.filter(|_| !kind.takes(key)) {
                let takes = kind.takes.iter().map(|key| key.name);
                let problem = ScenarioProblem::KeyOfOtherKind {
                    key: section.full(key),
                    kind: kind.name,
                    takes: [START.name, LATEST_START.name].into_iter().chain(takes).collect(),
                };
                return Err(section.error_at(span, problem));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Scenario;
    use super::*;

    const FLIGHT: &str = "name = 'test'\nduration_s = 60\n[spacecraft]\n\
        inertia_kg_m2 = [3, 4, 5, 0, 0, 0]\n[[wheel]]\naxis = [0, 0, 1]\n\
        spin_inertia_kg_m2 = 1e-3\n[gyro]\nrate_hz = 10\nnoise_rad_s = 1e-4\n[[fault]]\n";

    fn read(fault: &str) -> Result<Fault, String> {
        let scenario = Scenario::from_toml("s.toml", &format!("{FLIGHT}{fault}"), Path::new(""));
        scenario.map(|scenario| scenario.faults[0]).map_err(|error| error.to_string())
    }

    #[test]
    fn keys_are_read_and_absent_ones_have_their_defaults() {
        let fault = read("kind = 'gyro_bias'\nstart_s = 5\nmagnitude = 0.1\naxis = 'y'").unwrap();
        assert_eq!((fault.kind, fault.axis, fault.wheel), (FaultKind::GyroBias, Some(1), None));
        assert_eq!((fault.latest_start_s, fault.duration_s, fault.share), (5.0, 0.0, 1.0));
        let fault = read("kind = 'tachometer_freeze'\nstart_s = 5\nlatest_start_s = 9\nwheel = 1");
        assert_eq!(fault.map(|fault| (fault.latest_start_s, fault.wheel)), Ok((9.0, Some(0))));
    }

    #[test]
    fn wrong_faults_are_rejected_with_line_key_and_remedy() {
        for (fault, named) in [
            ("kind = 'gyro_spikes'\nstart_s = 1", "did you mean `gyro_spike`?"),
            ("kind = 'gyro_bias'\nstart_s = 1", "missing key `fault[1].magnitude`"),
            ("kind = 'gyro_nan'\nstart_s = -1", "`fault[1].start_s`"),
            ("kind = 'gyro_nan'\nstart_s = 3\nlatest_start_s = 2", "start_s or later"),
            ("kind = 'gyro_nan'\nstart_s = 3\nwheel = 1", "`fault[1].wheel` does not belong to"),
            ("kind = 'gyro_nan'\nstart_s = 3\naxis = 'q'", "x, y or z"),
            ("kind = 'tachometer_sign'\nstart_s = 3\nwheel = 2", "1 to the number of wheels"),
            ("kind = 'tachometer_edges'\nstart_s = 3\nmagnitude = 2", "0 to 1"),
        ] {
            let message = read(fault).unwrap_err();
            assert!(message.contains(named) && message.starts_with("s.toml:"), "{message}");
        }
    }
}
