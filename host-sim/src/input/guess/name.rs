//! The name of a column: its words, its index or axis, its unit.

use flight_input::units::{MOMENTA, RATES, TORQUES, TimeUnit, Unit, find};

/// A name of a column, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Name {
    /// As in the header.
    pub full: String,
    /// Words in lower case, without index and unit.
    pub words: Vec<String>,
    /// Last word that counts columns: `x y z`, `w`, or a number. `p q r` and `roll pitch yaw` are `x y z`, with a word of
    /// their own.
    pub index: Option<String>,
    /// Spelling of the unit, if there is one.
    pub unit: Option<String>,
    /// Text in the place of a unit, if it is none that is known.
    pub unknown_unit: Option<String>,
}

/// Words before the letter of a wheel.
const WHEELS: [&str; 5] = ["wheel", "rw", "rwa", "rws", "mw"];
/// Words of axes other than x, y and z: the axis, and the word that stands for the three.
const AXES: [(&str, &str, &str); 6] = [
    ("p", "x", "pqr"),
    ("q", "y", "pqr"),
    ("r", "z", "pqr"),
    ("roll", "x", "rpy"),
    ("pitch", "y", "rpy"),
    ("yaw", "z", "rpy"),
];

impl Name {
    /// The parts of a name; `unit` is that of a row of units.
    pub(super) fn of(full: &str, unit: Option<&str>) -> Self {
        let row_of_units = unit.filter(|unit| !unit.trim().is_empty());
        let (bare, bracketed) = without_unit(full);
        let mut words = words(bare);
        let stated = unit.filter(|unit| is_unit(unit)).or(bracketed).map(str::to_owned);
        let unit = stated.or_else(|| trailing_unit(&mut words));
        let index = take_index(&mut words);
        // A unit may stand before the index, as in gyro_rad[0].
        let unit = unit.or_else(|| trailing_unit(&mut words));
        let unknown_unit = unit
            .is_none()
            .then(|| row_of_units.or_else(|| bracketed_text(full)))
            .flatten()
            .map(str::to_owned);
        Self { full: full.to_owned(), words, index, unit, unknown_unit }
    }

    /// True if any word is, or begins or ends with, one of these.
    pub(super) fn has(&self, wanted: &[&str]) -> bool {
        self.words.iter().any(|word| wanted.iter().any(|wanted| matches(word, wanted)))
    }

    /// Unit of a momentum.
    pub(super) fn momentum_unit(&self) -> Option<&'static Unit> {
        find(self.unit.as_deref()?, &MOMENTA)
    }

    /// Unit of a rate.
    pub(super) fn rate_unit(&self) -> Option<&'static Unit> {
        find(self.unit.as_deref()?, &RATES)
    }
}

/// Short words match whole words only.
fn matches(word: &str, wanted: &str) -> bool {
    word == wanted || (wanted.len() > 3 && word.contains(wanted))
}

fn is_unit(text: &str) -> bool {
    !text.is_empty()
        && (TimeUnit::find(text).is_some()
            || find(text, &RATES).is_some()
            || find(text, &TORQUES).is_some()
            || find(text, &MOMENTA).is_some()
            || text.contains('/'))
}

/// A name without brackets at its end, and the unit in them.
fn without_unit(full: &str) -> (&str, Option<&str>) {
    let full = full.trim();
    for (open, close) in [('(', ')'), ('[', ']'), ('<', '>')] {
        let parts = full.strip_suffix(close).and_then(|rest| rest.rsplit_once(open));
        if let Some((bare, unit)) = parts
            && is_unit(unit)
        {
            return (bare, Some(unit));
        }
    }
    (full, None)
}

/// Text in brackets at the end of a name, unless it is an index.
fn bracketed_text(full: &str) -> Option<&str> {
    let full = full.trim();
    let inner = [('(', ')'), ('[', ']')].into_iter().find_map(|(open, close)| {
        full.strip_suffix(close)?.rsplit_once(open).map(|(_, inner)| inner.trim())
    })?;
    let is_index = inner.parse::<u32>().is_ok() || inner.len() == 1;
    (!inner.is_empty() && !is_index).then_some(inner)
}

/// Words of a name in lower case: runs of letters, runs of digits, split at changes to upper case.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut previous: Option<char> = None;
    for c in name.chars() {
        // The newton of mN and uN is no word of its own.
        let is_newton =
            c == 'N' && words.last().is_some_and(|word| matches!(word.as_str(), "m" | "u"));
        let continues = previous.is_some_and(|p| {
            p.is_alphanumeric()
                && p.is_ascii_digit() == c.is_ascii_digit()
                && (is_newton || !(p.is_lowercase() && c.is_uppercase()))
        });
        if c.is_alphanumeric() {
            match words.last_mut() {
                Some(word) if continues => word.extend(c.to_lowercase()),
                _ => words.push(c.to_lowercase().collect()),
            }
        }
        previous = Some(c);
    }
    words
}

/// Removes a unit at the end, as of `_deg_s`, `_rpm` or `_us`.
fn trailing_unit(words: &mut Vec<String>) -> Option<String> {
    for length in [3, 2, 1] {
        let Some(start) = words.len().checked_sub(length).filter(|start| *start > 0) else {
            continue;
        };
        let spelling = words[start..].join("_");
        let is_known = TimeUnit::find(&spelling).is_some()
            || find(&spelling, &RATES).is_some()
            || find(&spelling, &TORQUES).is_some()
            || find(&spelling, &MOMENTA).is_some();
        if is_known {
            words.truncate(start);
            return Some(spelling);
        }
        // PX4: gyro_rad is a rate in rad/s.
        if spelling == "rad" {
            words.truncate(start);
            return Some("rad/s".to_owned());
        }
    }
    None
}

/// Removes the last word that counts columns, or the last letter of the last word, as in `omegax`.
fn take_index(words: &mut Vec<String>) -> Option<String> {
    let other = |word: &str| AXES.iter().find(|(name, ..)| *name == word);
    if let Some(place) = words.iter().rposition(|word| other(word).is_some())
        && let Some((_, axis, all)) = other(&words.remove(place))
    {
        words.push((*all).to_owned());
        return Some((*axis).to_owned());
    }
    if let [one] = words.as_slice()
        && matches!(one.as_str(), "x" | "y" | "z")
    {
        return words.pop();
    }
    // Wheels are lettered as well.
    let lettered = words.windows(2).position(|pair| {
        WHEELS.contains(&pair[0].as_str()) && matches!(pair[1].as_str(), "a" | "b" | "c" | "d")
    });
    if let Some(place) = lettered {
        let letter = words.remove(place + 1);
        return letter.bytes().next().map(|letter| (letter - b'a' + 1).to_string());
    }
    let is_axis = |word: &str| matches!(word, "x" | "y" | "z" | "w");
    let is_number = |word: &str| word.parse::<u32>().is_ok();
    if words.len() > 1
        && let Some(last) = words.pop_if(|last| is_axis(last) || is_number(last))
    {
        return Some(last);
    }
    // The index of a wheel may stand inside, as in rw1_speed.
    if let Some(place) = words.iter().position(|word| is_number(word)).filter(|place| *place > 0) {
        return Some(words.remove(place));
    }
    let inner = words.iter().position(|word| is_axis(word));
    if let Some(place) = inner.filter(|place| *place > 0) {
        return Some(words.remove(place));
    }
    let last = words.last_mut().filter(|last| last.len() > 1)?;
    let axis = last.chars().next_back().filter(|c| matches!(c, 'x' | 'y' | 'z'))?;
    last.pop();
    Some(axis.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_exports_are_taken_apart() {
        for (full, words, index, unit) in [
            ("/imu/angular_velocity/x", "imu angular velocity", Some("x"), None),
            ("Gyroscope x (rad/s)", "gyroscope", Some("x"), Some("rad/s")),
            ("gyro_rad[0]", "gyro", Some("0"), Some("rad/s")),
            ("gyroADC[2] (deg/s)", "gyro adc", Some("2"), Some("deg/s")),
            ("gyro_x_dps", "gyro", Some("x"), Some("dps")),
            ("RW1_SPEED_RPM", "rw speed", Some("1"), Some("rpm")),
            ("wheel_2_rad_s", "wheel", Some("2"), Some("rad_s")),
            ("omegaX", "omega", Some("x"), None),
            ("wx", "w", Some("x"), None),
            ("timestamp", "timestamp", None, None),
            ("time_us", "time", None, Some("us")),
            ("Time (s)", "time", None, Some("s")),
            ("time_usec", "time", None, Some("usec")),
            ("p_dps", "pqr", Some("x"), Some("dps")),
            ("RollRate", "rate rpy", Some("x"), None),
            ("Drehrate Z [°/s]", "drehrate", Some("z"), Some("°/s")),
            ("gx", "g", Some("x"), None),
            ("Wheel B Speed (RPM)", "wheel speed", Some("2"), Some("RPM")),
            ("rw_h_1_mN_m_s", "rw h", Some("1"), Some("mn_m_s")),
            ("y", "", Some("y"), None),
        ] {
            let name = Name::of(full, None);
            assert_eq!(name.words.join(" "), words, "{full}");
            assert_eq!((name.index.as_deref(), name.unit.as_deref()), (index, unit), "{full}");
        }
        assert_eq!(Name::of("GYRO_X", Some("[deg/s]")).unit.as_deref(), Some("[deg/s]"));
        assert_eq!(Name::of("wheel 1 [furlong]", None).unknown_unit.as_deref(), Some("furlong"));
        assert_eq!(Name::of("wheel[1]", None).unknown_unit, None);
    }
}
