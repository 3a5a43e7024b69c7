//! `[log]`: columns, units and clock of the logs of a craft.

use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, IntoDeserializer, SeqAccess, Visitor};
use toml::Spanned;

use crate::csv_dialect::{CsvOptions, Separator};
use crate::error::{InputError, Problem};
use crate::key::{ANY, Key, NUMBER, Range, TABLE as SUBTABLE, TEXT, Table};
use crate::log::is_date_form;
use crate::nearest::nearest;
use crate::section::Section;
use crate::units::{self, MOMENTA, NONE, RATES, TORQUES, TimeUnit, Unit};

const TEXTS: &str = "text, or list of texts";
const NUMBERS: &str = "number, or list of numbers";
const NOT_ZERO: Range = Range::new("finite and other than zero", |x| x.is_finite() && x != 0.0);
const SEPARATORS: Range = Range::new("comma, semicolon, tab, bar or spaces", |_| true);
const DECIMALS: Range = Range::new("point or comma", |_| true);
const TIME_UNITS: Range = Range::new("s, ms, us, ns, min, h, d, week or utc", |_| true);
const RATE_UNITS: Range =
    Range::new("rad/s, mrad/s, urad/s, deg/s, mdeg/s, deg/h, arcsec/s, rpm, krpm or Hz", |_| true);
const WHEEL_UNITS: Range = Range::new(
    "a unit of `[log.gyro]`, or of the momentum about the axis: N m s, mN m s or uN m s",
    |_| true,
);
const DATE_FORMS: Range = Range::new("a form of strftime, as %m/%d/%Y %H:%M:%S%.f", |_| true);
const TORQUE_UNITS: Range = Range::new("N m, mN m or uN m", |_| true);
/// Time of a log without `[log]`.
const DEFAULT_TIME: &str = "t_s";

const FILE: Key = Key::required(
    "file",
    TEXT,
    "",
    ANY,
    "Names of the logs of a folder, as `*_gyro.csv`, with one `*` for any text",
)
.or("every log");
const SEPARATOR: Key =
    Key::required("separator", TEXT, "", SEPARATORS, "Separator of the cells").or("found");
const DECIMAL: Key =
    Key::required("decimal", TEXT, "", DECIMALS, "Decimal sign of the numbers").or("found");
const TIME: Key = Key::required(
    "time",
    TEXTS,
    "",
    ANY,
    "Column of time; several are added, as seconds and nanoseconds",
)
.or("`t_s`");
const TIME_UNIT: Key = Key::required(
    "time_unit",
    TEXTS,
    "",
    TIME_UNITS,
    "Unit of each column of time; `utc`: ISO 8601, or another date with the month first or by name",
)
.or("found: s, a time since 1970, or utc");
const TIME_FORMAT: Key = Key::required(
    "time_format",
    TEXT,
    "",
    DATE_FORMS,
    "Form of the dates in all columns of the unit `utc`, as of strftime; `%.f` is the fraction with its point, `%p` AM or PM",
)
.or("found: the forms of the page on logs");
const TIME_SCALE: Key = Key::required(
    "time_scale",
    NUMBER,
    "",
    NOT_ZERO,
    "Units per count, for time in counts of a clock",
)
.or("1");
const OWN_FILE: Key = Key::required(
    "file",
    TEXT,
    "",
    ANY,
    "File of its own beside the log; `*` stands for the text that `*` of `[log] file` stands for, or for \
     the name of the log without its ending",
)
.or("the log itself");
const OWN_TIME: Key =
    Key::required("time", TEXTS, "", ANY, "Column of time of that file").or("that of `[log]`");
const OWN_TIME_UNIT: Key =
    Key::required("time_unit", TEXTS, "", TIME_UNITS, "Unit of it").or("that of `[log]`");
const SCALE: Key = Key::required(
    "scale",
    NUMBERS,
    "",
    NOT_ZERO,
    "Units per count, for all columns or for each; negative: the other direction",
)
.or("1");

const fn columns(meaning: &'static str) -> Key {
    Key::required("columns", "list of texts", "", ANY, meaning)
}

const fn unit(range: Range, si: &'static str) -> Key {
    Key::required("unit", TEXT, "", range, "Unit of the columns").or(si)
}

const GYRO_COLUMNS: Key = columns("Body rates about x, y and z");
const WHEEL_COLUMNS: Key = columns("Speed of each wheel, in the order of `[[wheel]]`");
const TORQUE_COLUMNS: Key = columns("External torque about x, y and z");
const ATTITUDE_COLUMNS: Key =
    columns("Quaternion, inertial to body axes: vector part x, y, z, scalar part");

const ROOT: Table = Table {
    header: "[log]",
    about: "Columns, units and clock of the logs, where these are not as in LOG.csv below. The text of a \
            column is its name in the header. Optional.",
    keys: &[
        FILE,
        SEPARATOR,
        DECIMAL,
        TIME,
        TIME_UNIT,
        TIME_FORMAT,
        TIME_SCALE,
        Key::required("gyro", SUBTABLE, "", ANY, "Columns of the gyro").or("`gyro_x_rad_s`, …"),
        Key::required("wheels", SUBTABLE, "", ANY, "Columns of the wheels")
            .or("`wheel_1_rad_s`, …"),
        Key::required("torque", SUBTABLE, "", ANY, "Columns of the external torque")
            .or("`torque_x_n_m`, …, if there"),
        Key::required("attitude", SUBTABLE, "", ANY, "Columns of the attitude")
            .or("`attitude_q1`, …, if there"),
    ],
};
const WHEELS: Table = Table {
    header: "[log.wheels]",
    about: "Wheel speeds relative to the body. Slower than the gyro, or in a file of their own, they are \
            interpolated. Optional.",
    keys: &[WHEEL_COLUMNS, unit(WHEEL_UNITS, "rad/s"), SCALE, OWN_FILE, OWN_TIME, OWN_TIME_UNIT],
};
const TORQUE: Table = Table {
    header: "[log.torque]",
    about: "External torque, body axes. Optional.",
    keys: &[TORQUE_COLUMNS, unit(TORQUE_UNITS, "N m"), SCALE, OWN_FILE, OWN_TIME, OWN_TIME_UNIT],
};
const ATTITUDE: Table = Table {
    header: "[log.attitude]",
    about: "Attitude. Optional.",
    keys: &[ATTITUDE_COLUMNS, SCALE, OWN_FILE, OWN_TIME, OWN_TIME_UNIT],
};
const GYRO: Table = Table {
    header: "[log.gyro]",
    about: "Body rates. Optional.",
    keys: &[GYRO_COLUMNS, unit(RATE_UNITS, "rad/s"), SCALE],
};

/// The keys of `[log]` and of its tables.
pub const TABLES: [Table; 5] = [ROOT, GYRO, WHEELS, TORQUE, ATTITUDE];

/// Form of the logs of a craft.
#[derive(Clone, Debug, PartialEq)]
pub struct LogFormat {
    /// Separator and decimal sign, where stated.
    pub csv: CsvOptions,
    /// Names of the logs in a folder.
    pub file: Option<String>,
    /// Columns of time.
    pub time: TimeFormat,
    /// Columns of the gyro: three; none: those of the standard names.
    pub gyro: Option<SensorFormat>,
    /// Columns of the wheels: one for each.
    pub wheels: Option<SensorFormat>,
    /// Columns of the torque: three.
    pub torque: Option<SensorFormat>,
    /// Columns of the attitude: four.
    pub attitude: Option<SensorFormat>,
}

/// Columns of time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeFormat {
    /// Names, at least one; their times are added.
    pub columns: Vec<String>,
    /// Unit of each; empty: found from the values.
    pub units: Vec<TimeUnit>,
    /// Form of dates, as of strftime; none: the forms that are recognised.
    pub form: Option<String>,
    /// Units per count.
    pub scale: f64,
}

/// Columns of one kind of sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorFormat {
    /// Names.
    pub columns: Vec<String>,
    /// SI value of one count of each.
    pub factors: Vec<f64>,
    /// File of its own, beside the log.
    pub file: Option<String>,
    /// Columns of time in that file, if other than those of the log.
    pub time: Option<TimeFormat>,
}

impl Default for LogFormat {
    fn default() -> Self {
        let time = TimeFormat::of(vec![DEFAULT_TIME.to_owned()], Vec::new());
        let csv = CsvOptions::default();
        Self { csv, file: None, time, gyro: None, wheels: None, torque: None, attitude: None }
    }
}

impl LogFormat {
    /// Text of the tables; reads back as this format.
    pub(super) fn write(&self, text: &mut String) {
        if *self == Self::default() {
            return;
        }
        *text += "[log]\n";
        if let Some(file) = &self.file {
            *text += &format!("file = {file:?}\n");
        }
        if let Some(separator) = self.csv.separator {
            *text += &format!("separator = {:?}\n", separator.name());
        }
        if let Some(comma) = self.csv.decimal_comma {
            *text += &format!("decimal = {:?}\n", if comma { "comma" } else { "point" });
        }
        self.time.write(text);
        for (name, sensor) in [
            ("gyro", &self.gyro),
            ("wheels", &self.wheels),
            ("torque", &self.torque),
            ("attitude", &self.attitude),
        ] {
            let Some(sensor) = sensor else { continue };
            *text += &format!("[log.{name}]\ncolumns = {:?}\n", sensor.columns);
            *text += &format!("scale = {:?}\n", sensor.factors);
            if let Some(file) = &sensor.file {
                *text += &format!("file = {file:?}\n");
            }
            if let Some(time) = &sensor.time {
                time.write(text);
            }
        }
    }
}

impl TimeFormat {
    fn of(columns: Vec<String>, units: Vec<TimeUnit>) -> Self {
        Self { columns, units, form: None, scale: 1.0 }
    }

    fn write(&self, text: &mut String) {
        *text += &format!("time = {:?}\n", self.columns);
        if !self.units.is_empty() {
            let units: Vec<&str> = self.units.iter().map(|unit| unit.key()).collect();
            *text += &format!("time_unit = {units:?}\n");
        }
        if let Some(form) = &self.form {
            *text += &format!("time_format = {form:?}\n");
        }
        if self.scale != 1.0 {
            *text += &format!("time_scale = {:?}\n", self.scale);
        }
    }
}

/// One value, or a list of them.
#[derive(Clone, Debug)]
struct Listed<T>(Vec<T>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Listed<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMore<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrMore<T> {
            type Value = Listed<T>;

            fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                out.write_str("one value or a list")
            }

            fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<Self::Value, E> {
                T::deserialize(value.into_deserializer()).map(|value| Listed(vec![value]))
            }

            fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Self::Value, E> {
                T::deserialize(value.into_deserializer()).map(|value| Listed(vec![value]))
            }

            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Self::Value, E> {
                T::deserialize(value.into_deserializer()).map(|value| Listed(vec![value]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(Listed)
            }
        }
        deserializer.deserialize_any(OneOrMore(std::marker::PhantomData))
    }
}

type Texts = Spanned<Listed<String>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LogFile {
    file: Option<Spanned<String>>,
    separator: Option<Spanned<String>>,
    decimal: Option<Spanned<String>>,
    time: Option<Texts>,
    time_unit: Option<Texts>,
    time_format: Option<Spanned<String>>,
    time_scale: Option<Spanned<f64>>,
    gyro: Option<Spanned<GyroColumnsFile>>,
    wheels: Option<Spanned<SensorFile>>,
    torque: Option<Spanned<SensorFile>>,
    attitude: Option<Spanned<AttitudeFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GyroColumnsFile {
    columns: Spanned<Vec<String>>,
    unit: Option<Spanned<String>>,
    scale: Option<Spanned<Listed<f64>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorFile {
    columns: Spanned<Vec<String>>,
    unit: Option<Spanned<String>>,
    scale: Option<Spanned<Listed<f64>>>,
    file: Option<Spanned<String>>,
    time: Option<Texts>,
    time_unit: Option<Texts>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AttitudeFile {
    columns: Spanned<Vec<String>>,
    scale: Option<Spanned<Listed<f64>>>,
    file: Option<Spanned<String>>,
    time: Option<Texts>,
    time_unit: Option<Texts>,
}

impl From<GyroColumnsFile> for SensorFile {
    fn from(file: GyroColumnsFile) -> Self {
        let GyroColumnsFile { columns, unit, scale } = file;
        Self { columns, unit, scale, file: None, time: None, time_unit: None }
    }
}

impl From<AttitudeFile> for SensorFile {
    fn from(file: AttitudeFile) -> Self {
        let AttitudeFile { columns, scale, file, time, time_unit } = file;
        Self { columns, unit: None, scale, file, time, time_unit }
    }
}

impl LogFile {
    /// The checked format for a craft with wheels of these spin inertias, kg m².
    pub(super) fn read(
        self,
        root: &Section<'_>,
        spin_inertias: &[f64],
    ) -> Result<LogFormat, InputError> {
        let section = root.table("log");
        let separator =
            self.separator.as_ref().map(|text| word(&section, text, &Separator::ALL, |s| s.name()));
        let decimal = [("point", false), ("comma", true)];
        let decimal = self.decimal.as_ref().map(|text| word(&section, text, &decimal, |d| d.0));
        let csv = CsvOptions {
            separator: separator.transpose()?,
            decimal_comma: decimal.transpose()?.map(|(_, comma)| comma),
        };
        let default = LogFormat::default();
        let mut time = time_format(&section, &self.time, &self.time_unit)?
            .unwrap_or_else(|| default.time.clone());
        time.scale = section.optional_number(&TIME_SCALE, &self.time_scale)?.unwrap_or(1.0);
        time.form = self.time_format.as_ref().map(|text| date_form(&section, text)).transpose()?;
        let gyro = self.gyro.map(|gyro| SensorFile::from(gyro.into_inner()));
        let attitude = self.attitude.map(|attitude| SensorFile::from(attitude.into_inner()));
        let form = time.form.clone();
        let of = |name, sensor: Option<SensorFile>, units, count| {
            let read = |sensor: SensorFile| sensor.read(&section.table(name), units, count);
            let mut sensor: Option<SensorFormat> = sensor.map(read).transpose()?;
            if let Some(own) = sensor.as_mut().and_then(|sensor| sensor.time.as_mut()) {
                own.form.clone_from(&form);
            }
            Ok(sensor)
        };
        let file = self.file.as_ref().map(|text| pattern(&section, &FILE, text)).transpose()?;
        let wheels = self.wheels.map(Spanned::into_inner);
        let is_momentum = wheels.as_ref().is_some_and(SensorFile::is_momentum);
        let wheel_units = if is_momentum { MOMENTA.as_slice() } else { &RATES };
        let mut wheels = of("wheels", wheels, wheel_units, spin_inertias.len())?;
        if let Some(wheels) = wheels.as_mut().filter(|_| is_momentum) {
            for (factor, spin_inertia) in wheels.factors.iter_mut().zip(spin_inertias) {
                *factor /= spin_inertia;
            }
        }
        Ok(LogFormat {
            csv,
            file,
            time,
            gyro: of("gyro", gyro, &RATES, 3)?,
            wheels,
            torque: of("torque", self.torque.map(Spanned::into_inner), &TORQUES, 3)?,
            attitude: of("attitude", attitude, &NONE, 4)?,
        })
    }
}

impl SensorFile {
    /// True if the unit is that of a momentum.
    fn is_momentum(&self) -> bool {
        self.unit.as_ref().is_some_and(|unit| units::find(unit.get_ref(), &MOMENTA).is_some())
    }

    fn read(
        &self,
        section: &Section<'_>,
        units: &[Unit],
        count: usize,
    ) -> Result<SensorFormat, InputError> {
        let names = self.columns.get_ref();
        if names.len() != count {
            let (key, found) = (section.full(&SENSOR_COLUMNS), names.len());
            let problem = Problem::WrongLength { key, found, required: count };
            return Err(section.error(&self.columns, problem));
        }
        let factor = match &self.unit {
            Some(text) => unit_of(section, text, units)?.factor,
            None => 1.0,
        };
        let scale = match &self.scale {
            Some(scale) => scales(section, scale, count)?,
            None => vec![1.0; count],
        };
        let file = self.file.as_ref().map(|text| pattern(section, &OWN_FILE, text)).transpose()?;
        Ok(SensorFormat {
            columns: names.clone(),
            factors: scale.iter().map(|scale| scale * factor).collect(),
            file,
            time: time_format(section, &self.time, &self.time_unit)?,
        })
    }
}

/// Key of the columns in errors: the same name in every table.
const SENSOR_COLUMNS: Key = GYRO_COLUMNS;

/// The unit of a column.
fn unit_of<'a>(
    section: &Section<'_>,
    text: &Spanned<String>,
    units: &'a [Unit],
) -> Result<&'a Unit, InputError> {
    units::find(text.get_ref(), units)
        .ok_or_else(|| unknown_word(section, text, text.get_ref(), &units::names(units)))
}

/// One scale for all columns, or one for each.
fn scales(
    section: &Section<'_>,
    scale: &Spanned<Listed<f64>>,
    count: usize,
) -> Result<Vec<f64>, InputError> {
    let values = &scale.get_ref().0;
    let list = match values.as_slice() {
        [one] => vec![*one; count],
        all => all.to_vec(),
    };
    if list.len() != count {
        let (key, found) = (section.full(&SCALE), list.len());
        return Err(section.error(scale, Problem::WrongLength { key, found, required: count }));
    }
    let values = Spanned::new(scale.span(), values.clone());
    section.all_in(&section.full(&SCALE), &SCALE.range, &values)?;
    Ok(list)
}

/// Columns of time, if stated, with their units.
fn time_format(
    section: &Section<'_>,
    time: &Option<Texts>,
    units: &Option<Texts>,
) -> Result<Option<TimeFormat>, InputError> {
    let columns = match time {
        Some(time) if time.get_ref().0.is_empty() => {
            let key = section.full(&TIME);
            let problem = Problem::WrongLength { key, found: 0, required: 1 };
            return Err(section.error(time, problem));
        }
        Some(time) => time.get_ref().0.clone(),
        None if units.is_none() => return Ok(None),
        None => LogFormat::default().time.columns,
    };
    let Some(stated) = units else {
        return Ok(Some(TimeFormat::of(columns, Vec::new())));
    };
    let names: Vec<String> = TimeUnit::ALL.iter().map(|unit| unit.key().to_owned()).collect();
    let unit = |text: &String| {
        TimeUnit::find(text).ok_or_else(|| unknown_word(section, stated, text, &names))
    };
    let units = stated.get_ref().0.iter().map(unit).collect::<Result<Vec<_>, _>>()?;
    if units.len() != columns.len() {
        let (key, required) = (section.full(&TIME_UNIT), columns.len());
        let problem = Problem::WrongLength { key, found: units.len(), required };
        return Err(section.error(stated, problem));
    }
    Ok(Some(TimeFormat::of(columns, units)))
}

/// A form of dates with a time of day.
fn date_form(section: &Section<'_>, text: &Spanned<String>) -> Result<String, InputError> {
    let form = text.get_ref();
    if is_date_form(form) {
        return Ok(form.clone());
    }
    let (key, found) = (section.full(&TIME_FORMAT), format!("{form:?}"));
    let required = DATE_FORMS.words.to_owned();
    Err(section.error(text, Problem::BadValue { key, found, required }))
}

/// A name of files with at most one `*`.
fn pattern(section: &Section<'_>, key: &Key, text: &Spanned<String>) -> Result<String, InputError> {
    let name = text.get_ref();
    if !name.is_empty() && name.matches('*').count() <= 1 {
        return Ok(name.clone());
    }
    Err(section.error(
        text,
        Problem::BadValue {
            key: section.full(key),
            found: format!("{name:?}"),
            required: "a name with at most one `*`".to_owned(),
        },
    ))
}

/// One of a few words.
fn word<T: Copy>(
    section: &Section<'_>,
    text: &Spanned<String>,
    all: &[T],
    name: impl Fn(&T) -> &'static str,
) -> Result<T, InputError> {
    let names: Vec<String> = all.iter().map(|one| name(one).to_owned()).collect();
    let found = all.iter().find(|one| name(one) == text.get_ref());
    found.copied().ok_or_else(|| unknown_word(section, text, text.get_ref(), &names))
}

fn unknown_word<T>(
    section: &Section<'_>,
    at: &Spanned<T>,
    word: &str,
    allowed: &[String],
) -> InputError {
    let nearest = nearest(word, allowed).map(str::to_owned);
    let problem =
        Problem::UnknownWord { word: word.to_owned(), nearest, allowed: allowed.to_vec() };
    section.error(at, problem)
}

#[cfg(test)]
mod tests {
    use super::super::Craft;
    use super::*;

    fn read(text: &str) -> Result<LogFormat, InputError> {
        Craft::from_toml("craft.toml", text).map(|craft| craft.log)
    }

    const WHEEL: &str = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n";

    #[test]
    fn documented_format_is_read() {
        let text = format!(
            "{WHEEL}[log]\nfile = \"*_gyro.csv\"\nseparator = \"semicolon\"\ndecimal = \"comma\"\n\
             time = [\"secs\", \"nsecs\"]\ntime_unit = [\"s\", \"ns\"]\n\
             [log.gyro]\ncolumns = [\"wx\", \"wy\", \"wz\"]\nunit = \"deg/s\"\nscale = [1, -1, 1]\n\
             [log.wheels]\ncolumns = [\"rw\"]\nunit = \"rpm\"\nfile = \"*_wheels.csv\"\ntime = \"t\"\n\
             time_unit = \"utc\"\n\
             [log.torque]\ncolumns = [\"a\", \"b\", \"c\"]\nunit = \"mN m\"\nscale = 2\n"
        );
        let format = read(&text).unwrap();
        assert_eq!(format.csv.separator, Some(Separator::Semicolon));
        assert_eq!(format.time.units, [TimeUnit::Second, TimeUnit::Nanosecond]);
        let deg = 1f64.to_radians();
        assert_eq!(format.gyro.as_ref().unwrap().factors, [deg, -deg, deg]);
        let wheels = format.wheels.as_ref().unwrap();
        assert_eq!(wheels.factors, [std::f64::consts::TAU / 60.0]);
        assert_eq!(wheels.time.as_ref().unwrap().units, [TimeUnit::Date]);
        assert_eq!(format.torque.as_ref().unwrap().factors, [0.002; 3]);

        let craft = Craft::from_toml("craft.toml", &text).unwrap();
        assert_eq!(Craft::from_toml("again", &craft.to_toml()).unwrap().log, format);
        assert_eq!(read("").unwrap(), LogFormat::default());
    }

    #[test]
    fn each_bad_value_is_reported() {
        for (text, expected) in [
            ("[log]\nseparator = \"colon\"", "unknown word \"colon\""),
            ("[log]\ntime_unit = \"sec.\"", "unknown word \"sec.\""),
            ("[log]\ntime = []", "`log.time` has 0 entries, but takes 1"),
            ("[log]\ntime = 1", "wrong type of value: "),
            (
                "[log]\ntime = [\"a\", \"b\"]\ntime_unit = \"s\"",
                "`log.time_unit` has 1 entries, but takes 2",
            ),
            ("[log]\nfile = \"*a*\"", "`log.file` is \"*a*\"; it must be a name with at most one"),
            ("[log]\ntime_scale = 0", "`log.time_scale` is 0; it must be finite and other"),
            (
                "[log.gyro]\ncolumns = [\"a\", \"b\"]",
                "craft.toml:2: `log.gyro.columns` has 2 entries, but takes 3",
            ),
            (
                "[log.gyro]\ncolumns = [\"a\", \"b\", \"c\"]\nunit = \"rads/s\"",
                "unknown word \"rads/s\" (did you mean `rad/s`?)",
            ),
            (
                "[log.gyro]\ncolumns = [\"a\", \"b\", \"c\"]\nscale = [1, 2]",
                "`log.gyro.scale` has 2 entries, but takes 3",
            ),
            ("[log.wheels]\ncolumns = [\"a\"]", "`log.wheels.columns` has 1 entries, but takes 0"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}\n  expected: {expected}");
        }
    }
}
