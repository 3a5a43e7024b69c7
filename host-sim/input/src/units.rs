//! Units of the columns of a log, and their conversion to SI.

use std::f64::consts::{PI, TAU};

/// A unit other than that of time, and its conversion to SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Name in a craft file.
    pub name: &'static str,
    /// Other spellings, without case and spaces.
    pub spellings: &'static [&'static str],
    /// Value of the unit in SI.
    pub factor: f64,
}

const fn unit(name: &'static str, spellings: &'static [&'static str], factor: f64) -> Unit {
    Unit { name, spellings, factor }
}

/// Units of rates and wheel speeds; the first is that of SI.
pub const RATES: [Unit; 10] = [
    unit("rad/s", &["rad_s", "rad.s-1", "rads", "rps_rad", "radps", "rad/sec", "rad*s^-1"], 1.0),
    unit("mrad/s", &["mrad_s", "mrad/sec"], 1e-3),
    unit("urad/s", &["µrad/s", "μrad/s", "urad_s", "urad/sec"], 1e-6),
    unit(
        "deg/s",
        &["deg_s", "dps", "°/s", "deg/sec", "degps", "degs", "degrees/s", "d/s"],
        PI / 180.0,
    ),
    unit("mdeg/s", &["mdps", "mdeg_s", "mdeg/sec"], PI / 180e3),
    unit("deg/h", &["deg_h", "deg/hr", "dph", "°/h", "deg/hour"], PI / (180.0 * 3600.0)),
    unit("arcsec/s", &["arcsec_s", "as/s", "arcsec/sec"], PI / (180.0 * 3600.0)),
    unit("rpm", &["r/min", "rev/min", "1/min", "min-1", "u/min", "tr/min"], TAU / 60.0),
    unit("krpm", &["kr/min"], TAU * 1e3 / 60.0),
    unit("Hz", &["rev/s", "r/s", "1/s", "rps"], TAU),
];
/// Units of the momentum of a wheel about its axis.
pub const MOMENTA: [Unit; 3] = [
    unit("N m s", &["n_m_s", "n*m*s", "n·m·s", "n.m.s"], 1.0),
    unit("mN m s", &["mn_m_s", "mn*m*s", "mn·m·s", "mn.m.s"], 1e-3),
    unit("uN m s", &["µnms", "μnms", "un_m_s"], 1e-6),
];
/// Units of torques.
pub const TORQUES: [Unit; 3] = [
    unit("N m", &["n_m", "n*m", "n·m", "n.m"], 1.0),
    unit("mN m", &["mn_m", "mn*m", "mn·m", "mn.m"], 1e-3),
    unit("uN m", &["µnm", "μnm", "un_m"], 1e-6),
];
/// Unit of a quaternion.
pub const NONE: [Unit; 1] = [unit("1", &["", "-"], 1.0)];

/// The unit of this spelling; brackets around it, case and spaces are ignored.
pub fn find<'a>(spelling: &str, units: &'a [Unit]) -> Option<&'a Unit> {
    let spelling = plain(spelling);
    units
        .iter()
        .find(|unit| plain(unit.name) == spelling || unit.spellings.contains(&spelling.as_str()))
}

/// The unit that the name of a column ends with, as `deg/s` of `wx_dps` or `w [deg/s]`: the longest spelling after a
/// character that is neither letter nor digit.
pub fn in_name<'a>(name: &str, units: &'a [Unit]) -> Option<&'a Unit> {
    let name = name.trim().trim_end_matches([')', ']', '}', '>']).to_lowercase();
    let length_of = |spelling: &str| {
        let before = name.strip_suffix(&plain(spelling))?;
        let is_apart = before.ends_with(|c: char| !c.is_alphanumeric());
        (is_apart && !spelling.is_empty()).then_some(spelling.len())
    };
    let longest = |unit: &Unit| {
        let spellings = unit.spellings.iter().copied().chain([unit.name]);
        spellings.filter_map(length_of).max()
    };
    units.iter().filter(|unit| longest(unit).is_some()).max_by_key(|unit| longest(unit))
}

/// Names of the units.
pub fn names(units: &[Unit]) -> Vec<String> {
    units.iter().map(|unit| unit.name.to_owned()).collect()
}

/// A spelling without brackets, case and spaces.
pub fn plain(spelling: &str) -> String {
    let inner = spelling.trim().trim_matches(['(', ')', '[', ']', '{', '}', '<', '>', '"']);
    inner.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_lowercase()
}

/// Unit of a column of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// s.
    Second,
    /// ms.
    Millisecond,
    /// µs.
    Microsecond,
    /// ns.
    Nanosecond,
    /// 60 s.
    Minute,
    /// 3,600 s.
    Hour,
    /// 86,400 s, as of a Julian date.
    Day,
    /// 604,800 s, as of GPS.
    Week,
    /// A date with the time of day as text, UTC without an offset.
    Date,
}

impl TimeUnit {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Second,
        Self::Millisecond,
        Self::Microsecond,
        Self::Nanosecond,
        Self::Minute,
        Self::Hour,
        Self::Day,
        Self::Week,
        Self::Date,
    ];

    /// The unit of this spelling.
    pub fn find(spelling: &str) -> Option<Self> {
        Some(match plain(spelling).as_str() {
            "s" | "sec" | "secs" | "second" | "seconds" => Self::Second,
            "ms" | "msec" | "millis" | "milliseconds" => Self::Millisecond,
            "us" | "µs" | "μs" | "usec" | "micros" | "microseconds" => Self::Microsecond,
            "ns" | "nsec" | "nanos" | "nanoseconds" => Self::Nanosecond,
            "min" | "minute" | "minutes" => Self::Minute,
            "h" | "hour" | "hours" => Self::Hour,
            "d" | "day" | "days" => Self::Day,
            "week" | "weeks" => Self::Week,
            "utc" | "iso8601" | "iso" | "date" | "datetime" => Self::Date,
            _ => return None,
        })
    }

    /// Name in a craft file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
            Self::Nanosecond => "ns",
            Self::Minute => "min",
            Self::Hour => "h",
            Self::Day => "d",
            Self::Week => "week",
            Self::Date => "utc",
        }
    }

    /// The unit in seconds; of a date one.
    pub fn seconds(self) -> f64 {
        10f64.powi(self.power()) * self.multiple() as f64
    }

    /// Power of ten of the unit in seconds, 0 from the second on.
    pub(crate) fn power(self) -> i32 {
        match self {
            Self::Millisecond => -3,
            Self::Microsecond => -6,
            Self::Nanosecond => -9,
            _ => 0,
        }
    }

    /// Seconds in the unit, 1 up to the second.
    pub(crate) fn multiple(self) -> i128 {
        match self {
            Self::Minute => 60,
            Self::Hour => 3_600,
            Self::Day => 86_400,
            Self::Week => 604_800,
            _ => 1,
        }
    }

    /// Name in notes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Second => "seconds",
            Self::Millisecond => "milliseconds",
            Self::Microsecond => "microseconds",
            Self::Nanosecond => "nanoseconds",
            Self::Minute => "minutes",
            Self::Hour => "hours",
            Self::Day => "days",
            Self::Week => "weeks",
            Self::Date => "dates, UTC without an offset,",
        }
    }
}

/// True for the spelling of any unit, as in a row of units below the header.
pub fn is_unit(spelling: &str) -> bool {
    TimeUnit::find(spelling).is_some()
        || [RATES.as_slice(), TORQUES.as_slice(), MOMENTA.as_slice()]
            .iter()
            .any(|units| find(spelling, units).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_data_sheets_and_headers_are_found() {
        for (spelling, name) in [
            ("(deg/s)", "deg/s"),
            ("[RPM]", "rpm"),
            ("dps", "deg/s"),
            ("°/s", "deg/s"),
            ("[kRPM]", "krpm"),
        ] {
            assert_eq!(find(spelling, &RATES).unwrap().name, name, "{spelling}");
        }
        assert_eq!(find("mN·m", &TORQUES).unwrap().factor, 1e-3);
        assert_eq!(find("furlong", &RATES), None);
        assert_eq!(TimeUnit::find("[µs]"), Some(TimeUnit::Microsecond));
    }

    #[test]
    fn spellings_are_plain_and_unique() {
        for units in [RATES.as_slice(), &TORQUES, &MOMENTA, &NONE] {
            let all: Vec<String> = (units.iter())
                .flat_map(|unit| [&[unit.name], unit.spellings].concat())
                .map(plain)
                .collect();
            for (index, spelling) in all.iter().enumerate() {
                assert!(!all[..index].contains(spelling), "{spelling}");
            }
            assert!(units.iter().all(|u| u.spellings.iter().all(|s| plain(s) == *s)));
        }
    }

    #[test]
    fn a_unit_is_found_at_the_end_of_a_name() {
        for (name, expected) in [
            ("wx_dps", Some("deg/s")),
            ("gyro_x_deg_s", Some("deg/s")),
            ("Rate X [rad/s]", Some("rad/s")),
            ("rate_x_rad_s", Some("rad/s")),
            ("gyro_x_mdps", Some("mdeg/s")),
            ("RW1_SPEED_RPM", Some("rpm")),
            ("wheels", None),
            ("gyro_x", None),
            ("dps", None),
        ] {
            assert_eq!(in_name(name, &RATES).map(|unit| unit.name), expected, "{name}");
        }
    }
}
