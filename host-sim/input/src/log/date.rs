//! Dates with a time of day, as logs of the ground write them.

use chrono::{DateTime, NaiveDateTime, NaiveTime};

use super::time::{PICOSECONDS_PER_SECOND, TimeStamp};

/// Forms of a date: ISO 8601, its day of the year, with slashes, of MATLAB, with points.
const DATES: [&str; 6] = ["%Y-%m-%d", "%Y-%j", "%Y/%m/%d", "%Y/%j", "%d-%b-%Y", "%d.%m.%Y"];
/// Form of a time of day.
const TIME: &str = "%H:%M:%S%.f";

/// Stamp of a date and time, UTC without an offset, or of a time of day alone; none for another text.
///
/// Resolution: 1 ns. A leap second is the second after it.
pub(super) fn parse(text: &str) -> Option<TimeStamp> {
    let text = text.trim();
    if !text.contains(':') {
        return None;
    }
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
        ] {
            assert_eq!(parse(text), expected, "{text}");
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
