//! Dates with a time of day, as logs of the ground write them.

use chrono::format::{Item, Parsed, StrftimeItems, parse as parse_items};
use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime};

use super::time::{PICOSECONDS_PER_SECOND, TimeStamp};

/// Forms of a date: ISO 8601, its day of the year, with slashes, of MATLAB, with points.
const DATES: [&str; 6] = ["%Y-%m-%d", "%Y-%j", "%Y/%m/%d", "%Y/%j", "%d-%b-%Y", "%d.%m.%Y"];
/// Form of a time of day.
const TIME: &str = "%H:%M:%S%.f";

/// Stamp of a date and time, UTC without an offset, or of a time of day alone; none for another text.
///
/// Resolution: 1 ns. A leap second is the second after it. The fraction may have a comma.
pub(super) fn parse(text: &str) -> Option<TimeStamp> {
    let text = text.trim();
    if !text.contains(':') {
        return None;
    }
    let text = &text.replace(',', ".");
    if let Ok(date) = DateTime::parse_from_rfc3339(text) {
        return Some(stamp(date.timestamp(), date.timestamp_subsec_nanos()));
    }
    let local = text.trim_end_matches(['Z', 'z']).trim_end_matches("UTC").trim_end();
    if let Ok(time) = NaiveTime::parse_from_str(local, TIME) {
        let of_day = time.signed_duration_since(NaiveTime::MIN);
        return Some(stamp(of_day.num_seconds(), of_day.subsec_nanos().unsigned_abs()));
    }
    if let Some(duration) = duration(local) {
        return Some(duration);
    }
    let parse = |form: &str| NaiveDateTime::parse_from_str(local, form).ok();
    let date = DATES
        .iter()
        .flat_map(|date| ["T", " "].map(|between| format!("{date}{between}{TIME}")))
        .find_map(|form| parse(&form))?
        .and_utc();
    Some(stamp(date.timestamp(), date.timestamp_subsec_nanos()))
}

/// Stamp of a date in a stated form, UTC without an offset; a form without a date gives a time of day. None for a text of
/// another form. The fraction may have a comma.
pub(super) fn parse_as(text: &str, form: &str) -> Option<TimeStamp> {
    let text = text.trim();
    let pointed = if form.contains(',') { text.into() } else { text.replace(',', ".") };
    let mut parsed = Parsed::new();
    parse_items(&mut parsed, &pointed, StrftimeItems::new(form)).ok()?;
    if parsed.offset().is_some() {
        let date = parsed.to_datetime().ok()?;
        return Some(stamp(date.timestamp(), date.timestamp_subsec_nanos()));
    }
    let date = parsed.to_naive_date().unwrap_or(NaiveDate::from_ymd_opt(1970, 1, 1)?);
    let date = date.and_time(parsed.to_naive_time().ok()?).and_utc();
    Some(stamp(date.timestamp(), date.timestamp_subsec_nanos()))
}

/// True for a date that is read: in a form of strftime, or in one of those that are recognised.
pub fn is_date(text: &str, form: Option<&str>) -> bool {
    form.map_or_else(|| parse(text), |form| parse_as(text, form)).is_some()
}

/// True for a form of strftime with a time of day.
pub fn is_date_form(form: &str) -> bool {
    let example = NaiveDate::from_ymd_opt(2024, 5, 1).and_then(|date| date.and_hms_opt(12, 34, 56));
    let is_known = StrftimeItems::new(form).all(|item| item != Item::Error);
    let written = example.filter(|_| is_known).map(|date| date.and_utc().format(form).to_string());
    let read = written.and_then(|text| parse_as(&text, form));
    let [hour_s, minute_s] = [12 * 3600, 34 * 60];
    read.is_some_and(|stamp| {
        let second = stamp.picoseconds / PICOSECONDS_PER_SECOND;
        second.rem_euclid(86_400) >= hour_s + minute_s
    })
}

/// A duration as `hh:mm:ss`, of any number of hours, as of MATLAB.
fn duration(text: &str) -> Option<TimeStamp> {
    let (hours, rest) = text.split_once(':')?;
    let is_count = hours.len() < 10 && hours.bytes().all(|byte| byte.is_ascii_digit());
    let within = NaiveTime::parse_from_str(&format!("00:{rest}"), TIME).ok()?;
    let hours: i64 = hours.parse().ok().filter(|_| is_count)?;
    let within = within.signed_duration_since(NaiveTime::MIN);
    Some(stamp(3600 * hours + within.num_seconds(), within.subsec_nanos().unsigned_abs()))
}

fn stamp(seconds: i64, nanoseconds: u32) -> TimeStamp {
    let picoseconds = i128::from(seconds) * PICOSECONDS_PER_SECOND + i128::from(nanoseconds) * 1000;
    TimeStamp { picoseconds }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_of_one_instant_are_equal() {
        let expected = parse("2024-05-01T12:00:00.25Z");
        assert_eq!(expected, Some(stamp(1_714_564_800, 250_000_000)));
        for text in [
            "2024-05-01T12:00:00.250",
            "2024-05-01 12:00:00.25",
            "2024-05-01T14:00:00.25+02:00",
            "2024-05-01 12:00:00.25 UTC",
            "2024-122T12:00:00.250Z",
            "2024/05/01 12:00:00.25",
            "01-May-2024 12:00:00.250",
            "01.05.2024 12:00:00.25",
            "01.05.2024 12:00:00,25",
        ] {
            assert_eq!(parse(text), expected, "{text}");
        }
    }

    #[test]
    fn stated_forms_are_read() {
        let expected = Some(stamp(1_714_564_800, 250_000_000));
        for (form, text) in [
            ("%m/%d/%Y %H:%M:%S%.f", "05/01/2024 12:00:00.25"),
            ("%m/%d/%Y %I:%M:%S%.f %p", "5/1/2024 12:00:00.250 PM"),
            ("%d/%m/%Y %H:%M:%S%.f", "01/05/2024 12:00:00.25"),
            ("%Y%m%dT%H%M%S%.f", "20240501T120000.25"),
            ("%d.%m.%y %H:%M:%S%.f %z", "01.05.24 14:00:00.25 +0200"),
        ] {
            assert!(is_date_form(form), "{form}");
            assert_eq!(parse_as(text, form), expected, "{form}");
            assert_eq!(parse_as("1", form), None, "{form}");
        }
        assert_eq!(parse_as("01:02:03.5", "%H:%M:%S%.f"), Some(stamp(3723, 500_000_000)));
        for form in ["", "%Q", "%Y-%m-%d", "%H", "time"] {
            assert!(!is_date_form(form), "{form}");
        }
    }

    #[test]
    fn time_of_day_is_read_and_other_texts_are_not() {
        assert_eq!(parse("00:01:00.5"), Some(stamp(60, 500_000_000)));
        assert_eq!(parse("30:00:01.25"), Some(stamp(108_001, 250_000_000)));
        for text in [
            "",
            "12",
            "30:61:00",
            "-1:00:00",
            "2024-05-01",
            "2024-13-01T00:00:00",
            "05/01/2024 12:00:00",
            "a:b",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
