//! `[wheels.tachometer]` and `[wheel.tachometer]`: measuring principle of the tachometers.

use serde::Deserialize;
use toml::Spanned;

use crate::error::InputError;
use crate::key::{Key, NOT_NEGATIVE, NUMBER, POSITIVE, Range, TEXT, Table};
use crate::section::Section;
use crate::words::short;

/// Edges of one Hall sensor on a motor with six pole pairs.
const DEFAULT_EDGES_PER_TURN: f64 = 6.0;
/// Resolution of a timer at 1 MHz, s.
const DEFAULT_RESOLUTION_S: f64 = 1e-6;

const KINDS: Range = Range::new("speed, mean, count or period", |_| true);

const KIND: Key = Key::required(
    "kind",
    TEXT,
    "",
    KINDS,
    "Instantaneous speed, mean over the sample interval, edges in a window, or time between two edges",
)
.or("speed");
const EDGES: Key = Key::required("edges_per_turn", NUMBER, "", POSITIVE, "Edges per turn").or("6");
const WINDOW: Key =
    Key::required("window_s", NUMBER, "s", POSITIVE, "`count`: window that ends with the reading")
        .or("sample period");
const RESOLUTION: Key =
    Key::required("resolution_s", NUMBER, "s", POSITIVE, "`period`: resolution of the timer")
        .or("1e-6");
const QUANTUM: Key =
    Key::required("quantum_rad_s", NUMBER, "rad/s", NOT_NEGATIVE, "Least significant bit").or("0");
const HOLD: Key = Key::required(
    "hold_s",
    NUMBER,
    "s",
    NOT_NEGATIVE,
    "Interval at which the output is renewed; held in between",
)
.or("0");
const LATENCY: Key = Key::required(
    "latency_s",
    NUMBER,
    "s",
    NOT_NEGATIVE,
    "A reading stamped t shows the speed at t − latency",
)
.or("0");
const NOISE: Key = Key::required(
    "noise_rad_s",
    NUMBER,
    "rad/s",
    NOT_NEGATIVE,
    "White noise of a reading, one sigma",
)
.or("0");

/// The keys of a tachometer.
pub const TACHOMETER_KEYS: &[Key] =
    &[KIND, EDGES, WINDOW, RESOLUTION, QUANTUM, HOLD, LATENCY, NOISE];

/// The keys of `[wheels.tachometer]`.
pub const TACHOMETERS_TABLE: Table = Table {
    header: "[wheels.tachometer]",
    about: "Measuring principle of all tachometers: what delays a reading is corrected in logs, rounding is in the sigma. \
            The flight computer's own driver corrects its readings itself. Optional.",
    keys: TACHOMETER_KEYS,
};

/// The keys of `[wheel.tachometer]`.
pub const TACHOMETER_TABLE: Table = Table {
    header: "[wheel.tachometer]",
    about: "The tachometer of a wheel, in place of that of `[wheels]`. Optional.",
    keys: TACHOMETER_KEYS,
};

/// Measuring principle of a tachometer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TachometerKind {
    /// Instantaneous speed.
    #[default]
    Speed,
    /// Mean speed over the sample interval that ends with the reading.
    Mean,
    /// Number of edges in a window that ends with the reading, over its duration.
    Count {
        /// Duration of the window, s; none for the sample period.
        window_s: Option<f64>,
    },
    /// Inverse of the time between the last two edges.
    Period {
        /// Resolution of the timer, s.
        resolution_s: f64,
    },
}

/// A tachometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tachometer {
    /// Measuring principle.
    pub kind: TachometerKind,
    /// Edges per turn, of the principles that count edges.
    pub edges_per_turn: f64,
    /// Least significant bit, rad/s; zero for a continuous output.
    pub quantum_rad_s: f64,
    /// The output is renewed at this interval and held in between, s; zero for each sample.
    pub hold_s: f64,
    /// A reading stamped `t` shows the speed at `t − latency`, s.
    pub latency_s: f64,
    /// White noise of one reading, one sigma, rad/s.
    pub noise_rad_s: f64,
}

impl Default for Tachometer {
    fn default() -> Self {
        Self {
            kind: TachometerKind::Speed,
            edges_per_turn: DEFAULT_EDGES_PER_TURN,
            quantum_rad_s: 0.0,
            hold_s: 0.0,
            latency_s: 0.0,
            noise_rad_s: 0.0,
        }
    }
}

impl Tachometer {
    /// Angle between two edges, rad.
    pub fn edge_rad(&self) -> f64 {
        std::f64::consts::TAU / self.edges_per_turn
    }

    /// Error of a reading by quantum and noise, one sigma, rad/s. A rounded number is uniform within its quantum.
    pub fn resolution_sigma_rad_s(&self) -> f64 {
        (self.quantum_rad_s * self.quantum_rad_s / 12.0 + self.noise_rad_s.powi(2)).sqrt()
    }

    /// Its keys and values that differ from the defaults, in a line.
    pub fn in_words(&self) -> String {
        let number = |key: &Key, value: f64| {
            (value != 0.0).then(|| format!("{} = {}", key.name, short(value)))
        };
        let kind = match self.kind {
            TachometerKind::Speed => [None, None],
            TachometerKind::Mean => [Some("kind = mean".to_owned()), None],
            TachometerKind::Count { window_s } => {
                [Some("kind = count".to_owned()), window_s.and_then(|s| number(&WINDOW, s))]
            }
            TachometerKind::Period { resolution_s } => {
                [Some("kind = period".to_owned()), number(&RESOLUTION, resolution_s)]
            }
        };
        let counts_edges =
            matches!(self.kind, TachometerKind::Count { .. } | TachometerKind::Period { .. });
        let others = [
            number(&EDGES, self.edges_per_turn).filter(|_| counts_edges),
            number(&QUANTUM, self.quantum_rad_s),
            number(&HOLD, self.hold_s),
            number(&LATENCY, self.latency_s),
            number(&NOISE, self.noise_rad_s),
        ];
        kind.into_iter().chain(others).flatten().collect::<Vec<_>>().join(" ")
    }

    /// Lines of `[wheel.tachometer]`; nothing for an ideal one.
    pub(super) fn write(&self, text: &mut String) {
        if *self == Self::default() {
            return;
        }
        let (kind, own) = match self.kind {
            TachometerKind::Speed => ("speed", None),
            TachometerKind::Mean => ("mean", None),
            TachometerKind::Count { window_s } => ("count", window_s.map(|s| (WINDOW, s))),
            TachometerKind::Period { resolution_s } => ("period", Some((RESOLUTION, resolution_s))),
        };
        *text += &format!("{}\n{} = {kind:?}\n", TACHOMETER_TABLE.header, KIND.name);
        let numbers = [
            (EDGES, self.edges_per_turn),
            (QUANTUM, self.quantum_rad_s),
            (HOLD, self.hold_s),
            (LATENCY, self.latency_s),
            (NOISE, self.noise_rad_s),
        ];
        for (key, value) in own.into_iter().chain(numbers) {
            *text += &format!("{} = {value:?}\n", key.name);
        }
    }
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    #[default]
    Speed,
    Mean,
    Count,
    Period,
}

/// A tachometer as written.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TachometerFile {
    #[serde(default)]
    kind: Kind,
    edges_per_turn: Option<Spanned<f64>>,
    window_s: Option<Spanned<f64>>,
    resolution_s: Option<Spanned<f64>>,
    quantum_rad_s: Option<Spanned<f64>>,
    hold_s: Option<Spanned<f64>>,
    latency_s: Option<Spanned<f64>>,
    noise_rad_s: Option<Spanned<f64>>,
}

impl TachometerFile {
    /// The checked tachometer.
    ///
    /// # Errors
    /// A value outside the range of its key.
    pub fn read(&self, section: &Section<'_>) -> Result<Tachometer, InputError> {
        let or = |key: &Key, value: &Option<Spanned<f64>>, default: f64| {
            Ok(section.optional_number(key, value)?.unwrap_or(default))
        };
        let window_s = section.optional_number(&WINDOW, &self.window_s)?;
        let resolution_s = or(&RESOLUTION, &self.resolution_s, DEFAULT_RESOLUTION_S)?;
        Ok(Tachometer {
            kind: match self.kind {
                Kind::Speed => TachometerKind::Speed,
                Kind::Mean => TachometerKind::Mean,
                Kind::Count => TachometerKind::Count { window_s },
                Kind::Period => TachometerKind::Period { resolution_s },
            },
            edges_per_turn: or(&EDGES, &self.edges_per_turn, DEFAULT_EDGES_PER_TURN)?,
            quantum_rad_s: or(&QUANTUM, &self.quantum_rad_s, 0.0)?,
            hold_s: or(&HOLD, &self.hold_s, 0.0)?,
            latency_s: or(&LATENCY, &self.latency_s, 0.0)?,
            noise_rad_s: or(&NOISE, &self.noise_rad_s, 0.0)?,
        })
    }
}
