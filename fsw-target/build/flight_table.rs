//! A recorded flight, from its log and craft file to Rust source.
//!
//! Decimal text is parsed as f64 and rounded to f32 once, here, and emitted as exact bits: the
//! table holds what `host-sim replay --precision f32` reads from the same two files.

use super::craft::{self, floats};
use std::{error::Error, fmt::Write as _, path::Path};

/// Seconds to the integer microseconds of a sample's time tag.
const MICROSECONDS_PER_SECOND: f64 = 1.0e6;

/// Columns of a log, by name, as `host-sim replay` reads them.
const GYRO_COLUMNS: [&str; 3] = ["gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"];
const TORQUE_COLUMNS: [&str; 3] = ["torque_x_n_m", "torque_y_n_m", "torque_z_n_m"];

/// One row of the log, in SI units and f64.
struct Row {
    time_us: u64,
    rate_rad_s: Vec<f64>,
    wheel_speed_rad_s: Vec<f64>,
    torque_n_m: Vec<f64>,
}

/// The Rust source of the flight recorded in `log`, of the spacecraft described by `craft`.
pub fn generate(log: &Path, craft: &Path) -> Result<String, Box<dyn Error>> {
    let craft = craft::Craft::load(craft)?;
    let wheels = craft.wheel.len();
    let rows = read_rows(log, wheels).map_err(|e| format!("{}: {e}", log.display()))?;

    let mut source = craft.to_source(wheels)?;
    writeln!(
        source,
        "/// How many wheels the spacecraft has.\npub const WHEELS: usize = {wheels};"
    )?;
    write_rows(&mut source, &rows)?;
    Ok(source)
}

fn read_rows(log: &Path, wheels: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut reader = csv::Reader::from_path(log)?;
    let header = reader.headers()?.clone();
    let column = |name: &str| header.iter().position(|cell| cell == name);
    let columns = |names: &[String]| -> Result<Vec<usize>, String> {
        names.iter().map(|n| column(n).ok_or(format!("no column {n}"))).collect()
    };

    let time = column("t_s").ok_or("no column t_s")?;
    let gyro = columns(&GYRO_COLUMNS.map(String::from))?;
    let wheel_names: Vec<_> = (1..=wheels).map(|n| format!("wheel_{n}_rad_s")).collect();
    let wheel = columns(&wheel_names)?;
    let torque = match column(TORQUE_COLUMNS[0]) {
        Some(_) => columns(&TORQUE_COLUMNS.map(String::from))?,
        None => Vec::new(), // no torque columns: torque-free
    };

    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let cells = |columns: &[usize]| -> Result<Vec<f64>, Box<dyn Error>> {
            columns.iter().map(|&c| finite(&record[c])).collect()
        };
        let torque_n_m = if torque.is_empty() { vec![0.0; 3] } else { cells(&torque)? };
        rows.push(Row {
            time_us: microseconds(&record[time])?,
            rate_rad_s: cells(&gyro)?,
            wheel_speed_rad_s: cells(&wheel)?,
            torque_n_m,
        });
    }
    Ok(rows)
}

fn finite(cell: &str) -> Result<f64, Box<dyn Error>> {
    let value: f64 = cell.trim().parse().map_err(|_| format!("{cell:?} is not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("{cell:?} is not finite").into()) }
}

fn microseconds(cell: &str) -> Result<u64, Box<dyn Error>> {
    let time_us = (finite(cell)? * MICROSECONDS_PER_SECOND).round();
    if time_us < 0.0 {
        return Err(format!("t_s {cell} is negative").into());
    }
    Ok(time_us as u64)
}

fn write_rows(source: &mut String, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let samples = rows.len();
    writeln!(source, "/// The log of this flight.\npub static ROWS: [Row<WHEELS>; {samples}] = [")?;
    for row in rows {
        writeln!(source, "    Row {{")?;
        writeln!(source, "        time_us: {},", row.time_us)?;
        writeln!(source, "        rate_rad_s: {},", floats(&row.rate_rad_s))?;
        writeln!(source, "        wheel_speed_rad_s: {},", floats(&row.wheel_speed_rad_s))?;
        writeln!(source, "        torque_n_m: {},", floats(&row.torque_n_m))?;
        writeln!(source, "    }},")?;
    }
    writeln!(source, "];")?;
    Ok(())
}
