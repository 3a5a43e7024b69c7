//! Column of time of a log, and its unit.

use flight_input::csv_source::CsvSource;
use flight_input::log::is_date;
use flight_input::units::TimeUnit;

use super::name::Name;

/// Words of time, the better ones first.
const TIME: [&str; 27] = [
    "gentime",
    "timestamp",
    "time",
    "stamp",
    "utc",
    "epoch",
    "t",
    "date",
    "packet",
    "zeit",
    "datum",
    "temps",
    "tiempo",
    "tempo",
    "met",
    "obt",
    "sclk",
    "mjd",
    "jd",
    "datenum",
    "tow",
    "sow",
    "itow",
    "clock",
    "seconds",
    "secs",
    "sec",
];
/// Words of a count of days.
const DAYS: [&str; 5] = ["mjd", "jd", "datenum", "days", "julian"];
/// Words of the second of a GPS week.
const OF_WEEK: [&str; 4] = ["tow", "sow", "itow", "seconds"];
/// Words of other times.
const NOT_TIME: [&str; 8] =
    ["delta", "dt", "relative", "received", "reception", "rx", "integral", "of"];
/// Pairs of words of seconds and of the rest of them.
const PAIRS: [([&str; 4], TimeUnit); 1] =
    [(["nsec", "nsecs", "nanosec", "nanoseconds"], TimeUnit::Nanosecond)];
const SECONDS: [&str; 5] = ["sec", "secs", "seconds", "s", "tv"];
/// Shortest and longest time between samples of a log, s.
const ORDINARY_STEP_S: std::ops::RangeInclusive<f64> = 1e-3..=10.0;
/// Forms of dates beside those that are read without a form: with slashes, of STK and SPICE, without separators.
const FORMS: [&str; 14] = [
    "%m/%d/%y %H:%M:%S%.f",
    "%d/%m/%y %H:%M:%S%.f",
    "%m/%d/%Y %H:%M:%S%.f",
    "%m/%d/%Y %I:%M:%S%.f %p",
    "%d/%m/%Y %H:%M:%S%.f",
    "%d/%m/%Y %I:%M:%S%.f %p",
    "%d-%m-%Y %H:%M:%S%.f",
    "%m-%d-%Y %H:%M:%S%.f",
    "%d %b %Y %H:%M:%S%.f",
    "%Y %b %d %H:%M:%S%.f",
    "%a %b %d %H:%M:%S%.f %Y",
    "%Y%m%dT%H%M%S%.f",
    "%Y%m%d-%H%M%S%.f",
    "%Y%m%d %H:%M:%S%.f",
];
/// Rows from which the form of dates is found.
const SAMPLED_ROWS: usize = 1_000;
/// Times since 1970 in seconds, 2000 to 2100.
const CENTURY_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;

/// Columns of time, and their units.
#[derive(Debug)]
pub(super) struct FoundClock {
    /// One, or seconds and nanoseconds.
    pub columns: Vec<String>,
    /// Unit of each.
    pub units: Vec<TimeUnit>,
    /// Form of dates, and evidence of it; none for numbers and for forms that are recognised.
    pub form: Option<(&'static str, &'static str)>,
    /// Evidence of the unit, in words.
    pub reason: String,
    /// Typical time between rows, s; none for dates.
    pub step_s: Option<f64>,
}

/// The columns of time of a log; none without a candidate.
pub(super) fn find(source: &CsvSource, names: &[Name]) -> Option<FoundClock> {
    pair(source, names).or_else(|| of_week(source, names)).or_else(|| {
        let rank = |name: &&Name| TIME.iter().position(|word| name.has(&[word]));
        let mut candidates: Vec<(usize, &Name)> =
            names.iter().filter_map(|name| Some((rank(&name)?, name))).collect();
        candidates.sort_by_key(|(rank, name)| rank + if name.has(&NOT_TIME) { 20 } else { 0 });
        let first = candidates.first().map(|(_, name)| *name);
        let named = candidates.into_iter().find_map(|(_, name)| single(source, name));
        // The log names the fault of its stamps when it is read.
        let at_fault = first.map(|first| FoundClock {
            columns: vec![first.full.clone()],
            units: vec![TimeUnit::Second],
            form: None,
            reason: "CONFIRM: the column does not increase".to_owned(),
            step_s: None,
        });
        named.or(at_fault).or_else(|| first_increasing(source, names))
    })
}

/// The first column that increases, whatever its name.
fn first_increasing(source: &CsvSource, names: &[Name]) -> Option<FoundClock> {
    let found = names.iter().find_map(|name| single(source, name))?;
    let reason = found.reason.trim_start_matches("CONFIRM: ");
    let reason = format!("CONFIRM: the first column that increases, {reason}");
    Some(FoundClock { reason, ..found })
}

/// Week and second of the week, as of GPS.
fn of_week(source: &CsvSource, names: &[Name]) -> Option<FoundClock> {
    let has = |name: &Name, wanted: &[&str]| {
        name.has(wanted) || name.unit.as_deref().is_some_and(|unit| wanted.contains(&unit))
    };
    let week = names.iter().find(|name| has(name, &["week", "weeks", "wn", "wno"]))?;
    let second = names.iter().find(|name| has(name, &OF_WEEK))?;
    let step = median_step(&super::numbers(source, &second.full))?;
    let unit =
        if ORDINARY_STEP_S.contains(&step) { TimeUnit::Second } else { TimeUnit::Millisecond };
    Some(FoundClock {
        columns: vec![week.full.clone(), second.full.clone()],
        units: vec![TimeUnit::Week, unit],
        form: None,
        reason: "CONFIRM: week and time of week, by their names".to_owned(),
        step_s: Some(step * unit.seconds()),
    })
}

/// Seconds and nanoseconds in two columns.
fn pair(source: &CsvSource, names: &[Name]) -> Option<FoundClock> {
    let last = |name: &Name| {
        let words = Name::of(&name.full, None);
        words.unit.or_else(|| words.words.last().cloned()).unwrap_or_default()
    };
    for (rest, unit) in PAIRS {
        let Some(small) = names.iter().find(|name| rest.contains(&last(name).as_str())) else {
            continue;
        };
        let stem = |name: &Name| {
            let end = name.full.rfind(|c: char| !c.is_alphanumeric()).unwrap_or(0);
            name.full[..end].to_owned()
        };
        let whole = names
            .iter()
            .find(|name| SECONDS.contains(&last(name).as_str()) && stem(name) == stem(small))?;
        return Some(FoundClock {
            columns: vec![whole.full.clone(), small.full.clone()],
            units: vec![TimeUnit::Second, unit],
            form: None,
            reason: "by their names".to_owned(),
            step_s: None,
        })
        .filter(|_| !super::numbers(source, &whole.full).is_empty());
    }
    None
}

fn single(source: &CsvSource, name: &Name) -> Option<FoundClock> {
    let found = |unit, reason: &str, step_s| FoundClock {
        columns: vec![name.full.clone()],
        units: vec![unit],
        form: None,
        reason: reason.to_owned(),
        step_s,
    };
    if let Some(form) = form_of_dates(source, &name.full) {
        return Some(FoundClock { form, ..found(TimeUnit::Date, "dates", None) });
    }
    if let Some(unit) = unit_of_cells(source, &name.full) {
        return Some(found(unit, "as in the cells", None));
    }
    let values = super::numbers(source, &name.full);
    let step = median_step(&values)?;
    let of = |unit: TimeUnit| step * unit.seconds();
    let days = name.has(&DAYS).then_some(TimeUnit::Day);
    let named = name.unit.as_deref().and_then(TimeUnit::find).or(days);
    if let Some(unit) = named.filter(|unit| ORDINARY_STEP_S.contains(&of(*unit))) {
        return Some(found(unit, "by its name", Some(of(unit))));
    }
    let numeric =
        [TimeUnit::Second, TimeUnit::Millisecond, TimeUnit::Microsecond, TimeUnit::Nanosecond];
    let first = values.first().copied().unwrap_or(0.0);
    let since_1970 =
        numeric.into_iter().find(|unit| CENTURY_S.contains(&(first * of(*unit) / step)));
    if let Some(unit) = since_1970 {
        return Some(found(unit, "as a time since 1970", Some(of(unit))));
    }
    let mut numeric = numeric.into_iter().chain([TimeUnit::Day]);
    let unit = numeric.find(|unit| ORDINARY_STEP_S.contains(&of(*unit)))?;
    Some(found(unit, "CONFIRM: by its increments", Some(of(unit))))
}

/// Form of the dates or times of day of a column; none where its cells are no dates. Where a day may be a month in every
/// cell, the first of the possible forms.
#[allow(clippy::option_option, reason = "dates of a recognised form have none to state")]
fn form_of_dates(source: &CsvSource, name: &str) -> Option<Option<(&'static str, &'static str)>> {
    let column = source.column(name, |_| true).ok()?;
    let cells = source.rows().iter().take(SAMPLED_ROWS).map(|row| source.text(row, &column));
    let cells: Vec<&str> = cells.filter(|cell| !cell.is_empty()).collect();
    let are_read = |form: Option<&str>| {
        let read = cells.iter().filter(|cell| is_date(cell, form)).count();
        read > 0 && 10 * read >= 9 * cells.len()
    };
    if are_read(None) {
        return Some(None);
    }
    let mut forms = FORMS.into_iter().filter(|form| are_read(Some(form)));
    let first = forms.next()?;
    let is_ambiguous = forms.any(|form| form[..2] != first[..2]);
    let reason =
        if is_ambiguous { "CONFIRM: day and month may be exchanged" } else { "as in the cells" };
    Some(Some((first, reason)))
}

/// Unit in the cells themselves, as of `0.1 sec`.
fn unit_of_cells(source: &CsvSource, name: &str) -> Option<TimeUnit> {
    let text = first_cell(source, name)?;
    let (number, unit) = text.rsplit_once(' ')?;
    number.trim().parse::<f64>().ok().and_then(|_| TimeUnit::find(unit))
}

/// The first cell of a column that is not empty.
fn first_cell(source: &CsvSource, name: &str) -> Option<String> {
    let column = source.column(name, |_| true).ok()?;
    let mut cells = source.rows().iter().map(|row| source.text(row, &column));
    cells.find(|cell| !cell.is_empty()).map(str::to_owned)
}

/// Typical increment; none for a column that does not increase.
fn median_step(values: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> =
        values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step != 0.0).collect();
    let rising = steps.iter().filter(|step| **step > 0.0).count();
    if steps.is_empty() || 10 * rising < 9 * steps.len() {
        return None;
    }
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}
