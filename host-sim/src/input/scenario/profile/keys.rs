//! Keys of a torque profile, and the keys of each kind.
//!
//! The keys of all kinds are fields of one struct: serde loses the spans inside an enum tagged by
//! `kind`.

use std::ops::Range as Span;

use flight_input::InputError;
use flight_input::craft::hardware::TORQUE_SCALE_SIGMA;
use flight_input::key::{ANY, FINITE, Key, NUMBER, Range, TEXT, Table};
use flight_input::section::{List, Section};
use serde::Deserialize;
use toml::Spanned;

use super::super::problem::ScenarioProblem;

const KINDS: Range = Range::new("constant, multisine, table or points", |_| true);
const POINT_RATE: Range =
    Range::new("positive, and give at most 1e7 points over `duration_s`", |rate| rate > 0.0);
const ASCENDING: Range =
    Range::new("finite times, each later than the previous one", f64::is_finite);
const INTERVALS: Range =
    Range::new("one or more `[start, end]`, each after the previous one", f64::is_finite);

/// Type of the keys with one number per sine or point, in each of the two tables.
const LIST: &str = "list of numbers; external: 3 such lists";

const KIND: Key = Key::required("kind", TEXT, "", KINDS, "Kind of the profile");
pub(super) const VALUE: Key = Key::required(
    "value_n_m",
    "number; external: 3 numbers",
    "N m",
    FINITE,
    "`constant`: the torque",
)
.or("required by `constant`");
pub(super) const AMPLITUDE: Key =
    Key::required("amplitude_n_m", LIST, "N m", FINITE, "`multisine`: amplitude a of each sine")
        .or("required by `multisine`");
pub(super) const FREQUENCY: Key =
    Key::required("frequency_hz", LIST, "Hz", FINITE, "`multisine`: frequency f of each sine")
        .or("required by `multisine`");
pub(super) const PHASE: Key =
    Key::required("phase_rad", LIST, "rad", FINITE, "`multisine`: phase φ of each sine")
        .or("required by `multisine`");
pub(super) const SWEEP: Key = Key::required(
    "sweep_hz_s",
    LIST,
    "Hz/s",
    FINITE,
    "`multisine`: sweep s of each sine, a sin(2π (f + s t) t + φ)",
)
.or("0");
pub(super) const POINTS: Key = Key::required(
    "points_hz",
    NUMBER,
    "Hz",
    POINT_RATE,
    "`multisine`: commanded at this rate, linear in between",
)
.or("continuous");
const CSV: Key = Key::required(
    "csv",
    TEXT,
    "",
    ANY,
    "`table`: file with the columns t_s (s) and x (N m); external: x, y, z",
)
.or("required by `table`");
pub(super) const TIME: Key =
    Key::required("time_s", "list of numbers", "s", ASCENDING, "`points`: time of each point")
        .or("required by `points`");
pub(super) const POINT: Key = Key::required(
    "point_n_m",
    LIST,
    "N m",
    FINITE,
    "`points`: torque at each point, linear in between",
)
.or("required by `points`");
pub(super) const DURING: Key = Key::required(
    "during_s",
    "list of pairs of numbers",
    "s",
    INTERVALS,
    "Intervals in which the torque acts, its time counted from each start",
)
.or("the whole flight");

const KEYS: [Key; 12] = [
    KIND,
    VALUE,
    AMPLITUDE,
    FREQUENCY,
    PHASE,
    SWEEP,
    POINTS,
    CSV,
    TIME,
    POINT,
    DURING,
    TORQUE_SCALE_SIGMA.or("0"),
];

/// The keys of `torque` in a wheel.
pub(in super::super) const WHEEL_TABLE: Table = Table {
    header: "[wheel.torque]",
    about: "Torque of a wheel's motor on the wheel. Keys of another kind are rejected. Optional.",
    keys: &KEYS,
};
/// The keys of `[torque]`.
pub(in super::super) const EXTERNAL_TABLE: Table = Table {
    header: "[torque]",
    about: "Commanded external torque in body axes, known to the estimator: the keys of \
            `[wheel.torque]` with a value for each of x, y and z. Optional.",
    keys: &KEYS,
};

/// A wheel's profile.
pub(in super::super) type WheelProfileFile = Spanned<ProfileFile<f64, Vec<f64>>>;
/// The external torque's profile.
pub(in super::super) type ExternalProfileFile = Spanned<ProfileFile<Vec<f64>, Vec<List>>>;

/// A profile with a constant of type `Value`, and amplitudes, frequencies and phases of type `Lists`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct ProfileFile<Value, Lists> {
    kind: Kind,
    value_n_m: Option<Spanned<Value>>,
    amplitude_n_m: Option<Spanned<Lists>>,
    frequency_hz: Option<Spanned<Lists>>,
    phase_rad: Option<Spanned<Lists>>,
    sweep_hz_s: Option<Spanned<Lists>>,
    pub(super) points_hz: Option<Spanned<f64>>,
    csv: Option<Spanned<String>>,
    time_s: Option<List>,
    point_n_m: Option<Spanned<Lists>>,
    pub(super) during_s: Option<Spanned<Vec<Vec<f64>>>>,
    pub(in super::super) scale_sigma: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Constant,
    Multisine,
    Table,
    Points,
}

impl Kind {
    /// The word of the kind, and the keys that belong to it alone.
    fn takes(self) -> (&'static str, &'static [Key]) {
        match self {
            Self::Constant => ("constant", &[VALUE]),
            Self::Multisine => ("multisine", &[AMPLITUDE, FREQUENCY, PHASE, SWEEP, POINTS]),
            Self::Table => ("table", &[CSV]),
            Self::Points => ("points", &[TIME, POINT]),
        }
    }
}

/// A profile with the keys of its kind.
pub(super) enum Parts<'a, Value, Lists> {
    Constant(&'a Spanned<Value>),
    Multisine {
        amplitude: &'a Spanned<Lists>,
        frequency: &'a Spanned<Lists>,
        phase: &'a Spanned<Lists>,
        sweep: Option<&'a Spanned<Lists>>,
    },
    Table(&'a Spanned<String>),
    Points {
        time: &'a List,
        value: &'a Spanned<Lists>,
    },
}

impl<'a, Value, Lists> Parts<'a, Value, Lists> {
    /// Requires the keys of the profile's kind, and no key of another kind.
    pub(super) fn of(
        section: &Section<'_>,
        spanned: &'a Spanned<ProfileFile<Value, Lists>>,
    ) -> Result<Self, InputError> {
        let file = spanned.get_ref();
        let (kind, takes) = file.kind.takes();
        for (key, span) in file.present() {
            if !takes.iter().any(|taken| taken.name == key.name) {
                let takes = takes.iter().map(|key| key.name).collect();
                let problem =
                    ScenarioProblem::KeyOfOtherKind { key: section.full(&key), kind, takes };
                return Err(section.error_at(span, problem));
            }
        }
        let missing = |key: &Key| section.missing(key, spanned);
        Ok(match file.kind {
            Kind::Constant => {
                Self::Constant(file.value_n_m.as_ref().ok_or_else(|| missing(&VALUE))?)
            }
            Kind::Multisine => Self::Multisine {
                amplitude: file.amplitude_n_m.as_ref().ok_or_else(|| missing(&AMPLITUDE))?,
                frequency: file.frequency_hz.as_ref().ok_or_else(|| missing(&FREQUENCY))?,
                phase: file.phase_rad.as_ref().ok_or_else(|| missing(&PHASE))?,
                sweep: file.sweep_hz_s.as_ref(),
            },
            Kind::Table => Self::Table(file.csv.as_ref().ok_or_else(|| missing(&CSV))?),
            Kind::Points => Self::Points {
                time: file.time_s.as_ref().ok_or_else(|| missing(&TIME))?,
                value: file.point_n_m.as_ref().ok_or_else(|| missing(&POINT))?,
            },
        })
    }
}

impl<Value, Lists> ProfileFile<Value, Lists> {
    /// The keys that belong to one kind and are present, with their places.
    fn present(&self) -> impl Iterator<Item = (Key, Span<usize>)> {
        let spans = [
            (VALUE, self.value_n_m.as_ref().map(Spanned::span)),
            (AMPLITUDE, self.amplitude_n_m.as_ref().map(Spanned::span)),
            (FREQUENCY, self.frequency_hz.as_ref().map(Spanned::span)),
            (PHASE, self.phase_rad.as_ref().map(Spanned::span)),
            (SWEEP, self.sweep_hz_s.as_ref().map(Spanned::span)),
            (POINTS, self.points_hz.as_ref().map(Spanned::span)),
            (CSV, self.csv.as_ref().map(Spanned::span)),
            (TIME, self.time_s.as_ref().map(Spanned::span)),
            (POINT, self.point_n_m.as_ref().map(Spanned::span)),
        ];
        spans.into_iter().filter_map(|(key, span)| Some((key, span?)))
    }
}
