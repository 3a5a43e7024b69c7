//! A recorded flight, from its log and craft file to Rust source.
//!
//! Decimal text is parsed as f64 and rounded to f32 once, here, and emitted as exact bits: the
//! table holds what `host-sim replay --precision f32` reads from the same two files.

use serde::Deserialize;
use std::{error::Error, fmt::Write as _, fs, path::Path};

/// Seconds to the integer microseconds of a sample's time tag.
const MICROSECONDS_PER_SECOND: f64 = 1.0e6;

/// Columns of a log, by name, as `host-sim replay` reads them.
const GYRO_COLUMNS: [&str; 3] = ["gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"];
const TORQUE_COLUMNS: [&str; 3] = ["torque_x_n_m", "torque_y_n_m", "torque_z_n_m"];

/// What the craft file says, in the format of `host-sim replay --craft`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Craft {
    #[serde(default)]
    wheel: Vec<Wheel>,
    gyro: Gyro,
    prior: Option<Prior>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wheel {
    axis: [f64; 3],
    spin_inertia_kg_m2: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Gyro {
    noise_rad_s: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Prior {
    inertia_kg_m2: [f64; 6],
    sigma_kg_m2: [f64; 6],
}

/// One row of the log, in SI units and f64.
struct Row {
    time_us: u64,
    rate_rad_s: Vec<f64>,
    wheel_speed_rad_s: Vec<f64>,
    torque_n_m: Vec<f64>,
}

/// The Rust source of the flight recorded in `log`, of the spacecraft described by `craft`.
pub fn generate(log: &Path, craft: &Path) -> Result<String, Box<dyn Error>> {
    let text = fs::read_to_string(craft).map_err(|e| format!("{}: {e}", craft.display()))?;
    let craft: Craft = toml::from_str(&text).map_err(|e| format!("{}: {e}", craft.display()))?;
    let rows = read_rows(log, craft.wheel.len()).map_err(|e| format!("{}: {e}", log.display()))?;

    let mut source = String::new();
    write_craft(&mut source, &craft)?;
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

fn write_craft(source: &mut String, craft: &Craft) -> Result<(), Box<dyn Error>> {
    let wheels = craft.wheel.len();
    let axes: Vec<_> = craft.wheel.iter().map(|wheel| floats(&wheel.axis)).collect();
    let spin_inertias: Vec<_> = craft.wheel.iter().map(|wheel| wheel.spin_inertia_kg_m2).collect();

    writeln!(
        source,
        "/// How many wheels the spacecraft has.\npub const WHEELS: usize = {wheels};"
    )?;
    writeln!(
        source,
        "/// The spacecraft of this flight.\npub static CRAFT: Craft<WHEELS> = Craft {{"
    )?;
    writeln!(source, "    wheel_axes: [{}],", axes.join(", "))?;
    writeln!(source, "    spin_inertia_kg_m2: {},", floats(&spin_inertias))?;
    writeln!(source, "    gyro_noise_rad_s: {},", float(craft.gyro.noise_rad_s))?;
    match &craft.prior {
        None => writeln!(source, "    prior: None,")?,
        Some(prior) => {
            let inertia = floats(&prior.inertia_kg_m2);
            let sigma = floats(&prior.sigma_kg_m2);
            writeln!(source, "    prior: Some(Prior {{")?;
            writeln!(source, "        inertia_kg_m2: {inertia},")?;
            writeln!(source, "        sigma_kg_m2: {sigma},")?;
            writeln!(source, "    }}),")?;
        }
    }
    writeln!(source, "}};")?;
    Ok(())
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

fn floats(values: &[f64]) -> String {
    let elements: Vec<_> = values.iter().map(|&value| float(value)).collect();
    format!("[{}]", elements.join(", "))
}

fn float(value: f64) -> String {
    format!("f32::from_bits({:#010x})", (value as f32).to_bits())
}
