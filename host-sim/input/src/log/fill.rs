//! Sensors at instants of their own, beside the gyro: empty cells between their readings, readings held
//! for several rows, or tables of their own. Their values are interpolated at the instants of the gyro.

use nalgebra::Vector3;

use super::columns::{Columns, Sensor};
use super::held::fresh_wheel_rows;
use super::read::LogTables;
use super::record::{Interpolation, LogRow, RecordedLog};
use super::samples::{Between, Samples};
use super::time_columns::TimeColumns;
use crate::craft::{LogFormat, SensorFormat};
use crate::csv_problem::CsvProblem;
use crate::csv_source::CsvSource;
use crate::error::InputError;
use crate::words::short;

/// Share of rows without a reading from which a sensor counts as slower than the rows. Below, a row
/// without a reading is at fault.
const SLOWER_SHARE: f64 = 0.25;

/// Sensors of the log's own table that have readings in some of its rows only.
pub(super) struct Apart {
    pub gyro: bool,
    pub wheels: bool,
    pub torque: bool,
    pub attitude: bool,
}

impl Apart {
    pub(super) fn find(source: &CsvSource, columns: &Columns) -> Self {
        let rows = source.rows();
        let gyro_rows: Vec<_> =
            rows.iter().filter(|row| !columns.gyro.is_absent(source, row)).collect();
        let missing = |sensor: &Option<Sensor>| {
            sensor.as_ref().is_some_and(|sensor| {
                let absent = gyro_rows.iter().filter(|row| sensor.is_absent(source, row)).count();
                absent as f64 > SLOWER_SHARE * gyro_rows.len() as f64
            })
        };
        Self {
            gyro: (rows.len() - gyro_rows.len()) as f64 > SLOWER_SHARE * rows.len() as f64,
            wheels: missing(&columns.wheels),
            torque: missing(&columns.torque),
            attitude: missing(&columns.attitude),
        }
    }
}

/// Time scale of the rows.
pub(super) struct Clock {
    /// Time stamp at time zero of the rows, µs.
    pub start_us: i64,
    /// The clock was set back: stamps are ambiguous.
    pub is_set_back: bool,
}

impl RecordedLog {
    /// Fills in the sensors apart. Rows without wheel speed or torque are left out.
    pub(super) fn fill(
        &mut self,
        tables: &LogTables,
        format: &LogFormat,
        columns: &Columns,
        apart: &Apart,
        clock: &Clock,
    ) -> Result<(), InputError> {
        let of = |table: &Option<CsvSource>,
                  stated: &Option<SensorFormat>,
                  own: &Option<Sensor>,
                  is_apart: bool,
                  name: &'static str| {
            match (table, stated, own) {
                (Some(table), Some(stated), _) => of_table(table, stated, format, clock, name),
                (_, _, Some(own)) if is_apart => {
                    samples(&tables.log, &columns.time, own, clock, name)
                }
                _ => Ok(None),
            }
        };
        let wheels =
            of(&tables.wheels, &format.wheels, &columns.wheels, apart.wheels, "the wheels")?;
        let torque =
            of(&tables.torque, &format.torque, &columns.torque, apart.torque, "the torque")?;
        let attitude = of(
            &tables.attitude,
            &format.attitude,
            &columns.attitude,
            apart.attitude,
            "the attitude",
        )?;
        if let Some(readings) = wheels {
            let interpolator = readings.samples.interpolator(Between::Cubic);
            self.keep_rows(&readings, |row| {
                let speeds = interpolator.at(row.time_us as i64)?;
                row.wheel_speed_rad_s = speeds;
                Some(())
            })?;
            self.note_interpolation(&readings.file, &readings.samples);
        }
        if let Some(readings) = torque {
            let interpolator = readings.samples.interpolator(Between::Linear);
            self.keep_rows(&readings, |row| {
                let torque = interpolator.at(row.time_us as i64)?;
                row.torque_n_m = Vector3::from_column_slice(&torque);
                Some(())
            })?;
            self.notes
                .push(format!("{}: torque is interpolated at the gyro's times", readings.file));
        }
        if let Some(readings) = attitude {
            let interpolator = readings.samples.interpolator(Between::Linear);
            for row in &mut self.rows {
                let values = interpolator.at(row.time_us as i64);
                row.attitude = values.and_then(|values| values.try_into().ok());
            }
            self.notes
                .push(format!("{}: attitude is interpolated at the gyro's times", readings.file));
        }
        Ok(())
    }

    /// Applies `set` to each row, and leaves out the rows for which it has no value.
    fn keep_rows(
        &mut self,
        readings: &Readings,
        set: impl Fn(&mut LogRow) -> Option<()>,
    ) -> Result<(), InputError> {
        let before = self.rows.len();
        self.rows.retain_mut(|row| set(row).is_some());
        let left_out = before - self.rows.len();
        if self.rows.is_empty() {
            return Err(readings.no_overlap());
        }
        if left_out > 0 {
            let problem = CsvProblem::NoReading { sensor: readings.sensor };
            let reason = problem.skip_reason().unwrap_or("other");
            *self.skipped_rows.entry(reason).or_default() += left_out as u64;
            self.notes.push(format!("{}: {left_out} rows skipped: {problem}", readings.file));
        }
        Ok(())
    }

    /// Interpolates wheel speeds that the log holds for several rows.
    pub(super) fn interpolate_held_wheels(&mut self, source: &CsvSource) {
        let Some(fresh) = fresh_wheel_rows(&self.rows) else { return };
        let mut samples = Samples::default();
        for row in fresh.iter().filter_map(|row| self.rows.get(*row)) {
            samples.push(row.time_us as i64, row.wheel_speed_rad_s.clone());
        }
        // A row outside the readings keeps the one that it holds.
        let interpolator = samples.interpolator(Between::Cubic);
        for row in &mut self.rows {
            if let Some(speeds) = interpolator.at(row.time_us as i64) {
                row.wheel_speed_rad_s = speeds;
            }
        }
        self.note_interpolation(source.file(), &samples);
    }

    fn note_interpolation(&mut self, file: &str, samples: &Samples) {
        let period_s = samples.period_us().unwrap_or(0) as f64 / 1e6;
        let sigma_rad_s = samples.error();
        let largest = sigma_rad_s.iter().copied().fold(0.0, f64::max);
        self.notes.push(format!(
            "{file}: the wheels have a reading every {} s; their speeds are interpolated at the gyro's \
             times, to {} rad/s (one sigma)",
            short(period_s),
            short(largest)
        ));
        self.interpolation = Some(Interpolation {
            left_out: vec![0; sigma_rad_s.len()],
            sigma_rad_s,
            period_s,
            assumed: Vec::new(),
        });
    }
}

/// Readings of a sensor, and where they are from.
struct Readings {
    samples: Samples,
    file: String,
    sensor: &'static str,
}

impl Readings {
    fn no_overlap(&self) -> InputError {
        let place = crate::error::Place { file: self.file.clone(), line: None };
        InputError { place, problem: CsvProblem::NoOverlap { sensor: self.sensor }.into() }
    }
}

/// Readings of a sensor with a table of its own.
fn of_table(
    table: &CsvSource,
    stated: &SensorFormat,
    format: &LogFormat,
    clock: &Clock,
    name: &'static str,
) -> Result<Option<Readings>, InputError> {
    let is_known = |column: &str| stated.columns.iter().any(|known| known == column);
    let time = TimeColumns::find(table, stated.time.as_ref().unwrap_or(&format.time), is_known)?;
    let sensor = Sensor::find(table, stated, is_known)?;
    samples(table, &time, &sensor, clock, name)
}

/// Readings of a sensor in the rows of a table that have one.
fn samples(
    table: &CsvSource,
    time: &TimeColumns,
    sensor: &Sensor,
    clock: &Clock,
    name: &'static str,
) -> Result<Option<Readings>, InputError> {
    if clock.is_set_back {
        return Err(table.error(None, CsvProblem::SplitAtSetBack { sensor: name }));
    }
    let mut first_fault = None;
    let mut readings = Vec::new();
    for row in table.rows().iter().filter(|row| !sensor.is_absent(table, row)) {
        let reading = (table.check_log_row(row))
            .and_then(|()| Ok((time.stamp(table, row)?, sensor.values(table, row)?)));
        match reading {
            Ok(reading) => readings.push(reading),
            Err(fault) => _ = first_fault.get_or_insert((row.line, fault)),
        }
    }
    let Some((last, _)) = readings.last() else {
        let (line, fault) = first_fault.unzip();
        let problem = fault.unwrap_or(CsvProblem::NoOverlap { sensor: name });
        return Err(table.error(line, problem));
    };
    let unit = time.unit(Some(*last));
    let mut samples = Samples::default();
    for (stamp, values) in readings {
        if let Some(stamp_us) = stamp.microseconds(unit) {
            samples.push(stamp_us.saturating_sub(clock.start_us), values);
        }
    }
    Ok(Some(Readings { samples, file: table.file().to_owned(), sensor: name }))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::craft::Craft;
    use crate::csv_dialect::CsvOptions;

    const CRAFT: &str = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n[log]\ntime = \"t\"\n\
                         [log.gyro]\ncolumns = [\"x\", \"y\", \"z\"]\n";

    fn table(file: &str, text: &str) -> CsvSource {
        CsvSource::decode_unchecked(file, text.as_bytes(), &CsvOptions::default()).unwrap()
    }

    /// The log of one wheel; `wheels` are further keys of `[log.wheels]`.
    fn read(log: &str, wheels: Option<&str>, keys: &str) -> Result<RecordedLog, InputError> {
        let craft = format!("{CRAFT}[log.wheels]\ncolumns = [\"rw\"]\n{keys}");
        let craft = Craft::from_toml("craft.toml", &craft).unwrap();
        let mut tables = LogTables::from(table("log.csv", log));
        tables.wheels = wheels.map(|text| table("wheels.csv", text));
        RecordedLog::from_tables(&tables, &craft.log, 1)
    }

    /// Speed of the wheel, which the interpolation reproduces.
    fn speed(time_s: f64) -> f64 {
        100.0 + 3.0 * time_s + 0.25 * time_s * time_s
    }

    /// Rows at 10 Hz; `cell` is that of the wheel.
    fn log(rows: u32, cell: impl Fn(u32) -> String) -> String {
        let row = |row: u32| {
            format!("{},{},0.1,0.2,{}\n", f64::from(row) / 10.0, f64::from(row).sin(), cell(row))
        };
        "t,x,y,z,rw\n".to_owned() + &(0..rows).map(row).collect::<String>()
    }

    fn assert_interpolated(log: &RecordedLog, rows: usize) {
        assert_eq!(log.rows.len(), rows);
        for row in &log.rows {
            let expected = speed(row.time_us as f64 / 1e6 + log.start_s);
            assert!((row.wheel_speed_rad_s[0] - expected).abs() < 1e-9, "{row:?}");
        }
        let interpolation = log.interpolation.as_ref().unwrap();
        assert_eq!(interpolation.period_s, 1.0);
        assert!(interpolation.sigma_rad_s[0] < 1e-9);
    }

    #[test]
    fn empty_cells_between_readings_are_interpolated() {
        let cell = |row: u32| match row % 10 {
            5 => speed(f64::from(row) / 10.0).to_string(),
            _ => String::new(),
        };
        let log = read(&log(200, cell), None, "").unwrap();
        assert_interpolated(&log, 191);
        assert_eq!((log.start_s, log.skipped_rows["no_reading"]), (0.5, 9));
        assert!(log.notes[0].contains("9 rows skipped: no reading of the wheels near this"));
        assert!(
            log.notes[1]
                .starts_with("log.csv: the wheels have a reading every 1 s; their speeds are"),
            "{:?}",
            log.notes
        );
    }

    #[test]
    fn rows_of_the_wheels_beside_rows_of_the_gyro_are_readings() {
        let mut text = "t,x,y,z,rw\n".to_owned();
        for row in 0..100 {
            let time = f64::from(row) / 10.0;
            text += &format!("{time},{},0.1,0.2,\n", time.sin());
            if row % 10 == 0 {
                text += &format!("{time},,,,{}\n", speed(time));
                text += &format!("{},,,,\n,,,,\n", time + 0.02).repeat(4);
            }
        }
        let log = read(&text, None, "").unwrap();
        assert_interpolated(&log, 91);
        assert_eq!(log.skipped_rows["no_gyro"], 90);
    }

    #[test]
    fn held_readings_are_interpolated() {
        let text = log(300, |row| speed(f64::from(row / 10)).to_string());
        let mut log = read(&text, None, "").unwrap();
        assert_eq!(log.rows.len(), 300);
        log.rows.truncate(291);
        assert_interpolated(&log, 291);
    }

    #[test]
    fn second_table_is_joined_by_time() {
        let gyro: String = (0..100)
            .map(|row| format!("{},{row},0,0\n", 1_700_000_000_000_000i64 + row * 100_000))
            .collect();
        let wheels: String = (-2..12)
            .map(|second| {
                let rpm = speed(f64::from(second)) * 60.0 / TAU;
                let of_day = 22 * 60 + 13;
                format!("2023-11-14T22:{:02}:{:02}Z,{rpm}\n", of_day % 60, 20 + second)
            })
            .collect();
        let keys = "unit = \"rpm\"\ntime = \"utc\"\nfile = \"wheels.csv\"";
        let (gyro, wheels) = (format!("t,x,y,z\n{gyro}"), format!("utc,rw\n{wheels}"));
        let mut log = read(&gyro, Some(&wheels), keys).unwrap();
        assert_eq!(log.start_s, 1_700_000_000.0);
        log.start_s = 0.0;
        assert_interpolated(&log, 100);

        let other = wheels.replace("2023", "2024");
        let message = read(&gyro, Some(&other), keys).unwrap_err().to_string();
        assert!(
            message.starts_with("wheels.csv: no reading of the wheels at the times of"),
            "{message}"
        );
        let message = read(&gyro, Some("utc,rw\nx,1\n"), keys).unwrap_err().to_string();
        assert!(
            message.starts_with("wheels.csv:2: column `utc`: \"x\" is not a number"),
            "{message}"
        );
    }

    #[test]
    fn few_empty_cells_are_faults() {
        let text = log(100, |row| if row % 10 == 3 { String::new() } else { row.to_string() });
        let log = read(&text, None, "").unwrap();
        assert_eq!((log.rows.len(), log.skipped_rows["empty_cell"]), (90, 10));
        assert!(log.interpolation.is_none());
    }
}
