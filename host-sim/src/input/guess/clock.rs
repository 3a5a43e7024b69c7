//! Column of time of a log, and its unit.

use flight_input::csv_source::CsvSource;
use flight_input::units::TimeUnit;

use super::name::Name;

/// Words of time, the better ones first.
const TIME: [&str; 9] =
    ["gentime", "timestamp", "time", "stamp", "utc", "epoch", "t", "date", "packet"];
/// Words of other times.
const NOT_TIME: [&str; 8] =
    ["delta", "dt", "relative", "received", "reception", "rx", "integral", "of"];
/// Pairs of words of seconds and of the rest of them.
const PAIRS: [([&str; 4], TimeUnit); 1] =
    [(["nsec", "nsecs", "nanosec", "nanoseconds"], TimeUnit::Nanosecond)];
const SECONDS: [&str; 5] = ["sec", "secs", "seconds", "s", "tv"];
/// Shortest and longest time between samples of a log, s.
const ORDINARY_STEP_S: std::ops::RangeInclusive<f64> = 1e-3..=10.0;
/// Times since 1970 in seconds, 2000 to 2100.
const CENTURY_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;

/// Columns of time, and their units.
#[derive(Debug)]
pub(super) struct FoundClock {
    /// One, or seconds and nanoseconds.
    pub columns: Vec<String>,
    /// Unit of each.
    pub units: Vec<TimeUnit>,
    /// Evidence of the unit, in words.
    pub reason: String,
    /// Typical time between rows, s; none for dates.
    pub step_s: Option<f64>,
}

/// The columns of time of a log; none without a candidate.
pub(super) fn find(source: &CsvSource, names: &[Name]) -> Option<FoundClock> {
    pair(source, names).or_else(|| {
        let rank = |name: &&Name| TIME.iter().position(|word| name.has(&[word]));
        let mut candidates: Vec<(usize, &Name)> =
            names.iter().filter_map(|name| Some((rank(&name)?, name))).collect();
        candidates.sort_by_key(|(rank, name)| rank + if name.has(&NOT_TIME) { 20 } else { 0 });
        let (_, first) = *candidates.first()?;
        candidates.into_iter().find_map(|(_, name)| single(source, name)).or_else(|| {
            // The log names the fault of its stamps when it is read.
            Some(FoundClock {
                columns: vec![first.full.clone()],
                units: vec![TimeUnit::Second],
                reason: "CONFIRM: the column does not increase".to_owned(),
                step_s: None,
            })
        })
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
        reason: reason.to_owned(),
        step_s,
    };
    if is_date(source, &name.full) {
        return Some(found(TimeUnit::Date, "dates", None));
    }
    if let Some(unit) = unit_of_cells(source, &name.full) {
        return Some(found(unit, "as in the cells", None));
    }
    let values = super::numbers(source, &name.full);
    let step = median_step(&values)?;
    let of = |unit: TimeUnit| match unit {
        TimeUnit::Second | TimeUnit::Date => step,
        TimeUnit::Millisecond => step / 1e3,
        TimeUnit::Microsecond => step / 1e6,
        TimeUnit::Nanosecond => step / 1e9,
    };
    let named = name.unit.as_deref().and_then(TimeUnit::find);
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
    let unit = numeric.into_iter().find(|unit| ORDINARY_STEP_S.contains(&of(*unit)))?;
    Some(found(unit, "CONFIRM: by its increments", Some(of(unit))))
}

/// True for a column of dates or times of day.
fn is_date(source: &CsvSource, name: &str) -> bool {
    first_cell(source, name).is_some_and(|text| text.matches(':').count() >= 2)
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
