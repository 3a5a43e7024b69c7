//! Profiles from a CSV file beside the scenario: column `t_s` in s, one torque column per axis in N m.

use std::path::Path;

use flight_input::InputError;
use flight_input::csv_problem::CsvProblem;
use flight_input::csv_source::CsvSource;

use super::torque::TorqueProfile;

const TIME: &str = "t_s";

/// One profile per torque column of the file, all over column `t_s`.
pub(super) fn table<const N: usize>(
    path: &Path,
    columns: [&str; N],
) -> Result<[TorqueProfile; N], InputError> {
    let source = CsvSource::read(path)?;
    let is_known = |name: &str| name == TIME || columns.contains(&name);
    let time_s = strictly_increasing_times(&source, is_known)?;
    let mut profiles = [TorqueProfile::ZERO; N];
    for (profile, name) in profiles.iter_mut().zip(columns) {
        let column = source.column(name, is_known)?;
        let value_n_m = (source.rows().iter())
            .map(|row| source.number(row, &column))
            .collect::<Result<_, _>>()?;
        *profile = TorqueProfile::Table { time_s: time_s.clone(), value_n_m };
    }
    Ok(profiles)
}

fn strictly_increasing_times(
    source: &CsvSource,
    is_known: impl Fn(&str) -> bool,
) -> Result<Vec<f64>, InputError> {
    let column = source.column(TIME, is_known)?;
    let mut times: Vec<f64> = Vec::with_capacity(source.rows().len());
    for row in source.rows() {
        let time = source.number(row, &column)?;
        if let Some(&previous) = times.last()
            && time <= previous
        {
            let (column, time_text) = (TIME.to_owned(), time.to_string());
            let problem = if time < previous {
                let previous = previous.to_string();
                CsvProblem::TimeBackwards { column, time: time_text, previous }
            } else {
                CsvProblem::DuplicateTime { column, time: time_text }
            };
            return Err(source.error(Some(row.line), problem));
        }
        times.push(time);
    }
    Ok(times)
}
