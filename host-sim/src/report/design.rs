//! Output folder of a design, and of a trade.
//!
//! | file | content |
//! |---|---|
//! | `report.html` | accuracy, limits, the manoeuvre over time; of a trade: accuracy and gain over its range |
//! | `result.json` | the document of `--json` |
//! | `torque.csv` | torque of all wheels at the samples of the gyro |
//! | `spline.csv` | coefficients of the spline |
//! | `thrusters.csv` | with thrusters: their pulses in the order of time |
//! | `telecommands.csv` | the upload for the flight computer: function and user data of each telecommand, in order |
//! | `scenario.toml`, `torque-1.csv`, … | a scenario that flies the manoeuvre, for `run` and `mc` |
//! | `series.csv`, `series-standard.csv` | torque, speed, rate, excursion and sigma over time: design, best standard manoeuvre |
//! | `data/….csv` | the points of each plot |
//! | `trade.csv` | a row for each design of a trade |

use std::io::{self, Write};
use std::path::Path;

use fsw_target::flight::manoeuvre::FlightTable;
use fsw_target::link::command::Command;
use fsw_target::link::packet::SequenceCount;
use fsw_target::link::wire::Coded;

use super::files::{Folder, OutputError};
use super::json::{DesignReport, TradeReport};
use super::packet::hex;
use super::page;
use super::plots::Figure;
use crate::input::ELEMENT_NAMES;
use crate::manoeuvre::{SeriesRow, Trade, TradeRow, stamp_s};

/// Primary header and checksum around the user data of a telecommand without a tag, bytes.
const HEADER: usize = 6;
const CHECKSUM: usize = 2;

/// Content of the folder.
pub struct DesignFolder<'a> {
    /// Command line that reproduces the design.
    pub command: &'a str,
    /// Notes on the design, one sentence each.
    pub notes: &'a [String],
    /// Result.
    pub result: &'a DesignReport,
    /// Files of the scenario that flies it: name and text.
    pub scenario: &'a [(String, String)],
    /// The table of the flight computer, if it can fly the design.
    pub table_on_board: Option<&'a FlightTable>,
    /// The design over time.
    pub series: &'a [SeriesRow],
    /// The best standard manoeuvre over time.
    pub standard: &'a [SeriesRow],
}

impl DesignFolder<'_> {
    /// Writes all files into `folder`, which is created if it does not exist; files of an earlier report are removed.
    ///
    /// # Errors
    /// A path that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let mut folder = Folder::open(folder, &[])?;
        folder.json("result.json", self.result)?;
        for (name, text) in self.scenario {
            folder.text(name, text)?;
        }
        folder.stream("torque.csv", |out| self.torques(out))?;
        folder.stream("spline.csv", |out| self.spline(out))?;
        if let Some(table) = self.table_on_board {
            folder.stream("telecommands.csv", |out| telecommands(out, table))?;
        }
        for (name, rows) in [("series.csv", self.series), ("series-standard.csv", self.standard)] {
            folder.stream(name, |out| series(out, rows))?;
        }
        const FILES: [(&str, &str); 7] = [
            ("result.json", "the result as numbers"),
            ("torque.csv", "torque of the wheels at the samples of the gyro"),
            ("spline.csv", "the same as coefficients of cubic B-splines"),
            ("scenario.toml", "the scenario that flies it, for run and mc"),
            ("series.csv", "the design over time"),
            ("series-standard.csv", "the best standard manoeuvre over time"),
            ("telecommands.csv", "the upload for the flight computer"),
        ];
        let mut files =
            if self.table_on_board.is_some() { FILES.to_vec() } else { FILES[..6].to_vec() };
        if !self.result.thruster_on_s.is_empty() {
            folder.stream("thrusters.csv", |out| self.pulses(out))?;
            files.push(("thrusters.csv", "times at which each thruster is switched on and off"));
        }
        let over_time = (self.series, self.standard);
        let (page, figures) =
            page::design(self.result, over_time, self.command, self.notes, &files);
        write_page(&mut folder, &page, &figures)
    }

    fn torques(&self, mut out: impl Write) -> io::Result<()> {
        writeln!(out, "t_s{}", numbered(self.result.coefficients_n_m.len(), "wheel", "_n_m"))?;
        for (row, torques) in self.result.torque_n_m.iter().enumerate() {
            writeln!(out, "{}{}", stamp_s(row, self.result.step_s), values(torques))?;
        }
        Ok(())
    }

    fn pulses(&self, mut out: impl Write) -> io::Result<()> {
        let thrusters = (1..).zip(&self.result.thruster_on_s);
        let mut all: Vec<(f64, f64, usize)> = thrusters
            .flat_map(|(number, pulses)| pulses.iter().map(move |[on, off]| (*on, *off, number)))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        writeln!(out, "thruster,on_s,off_s")?;
        all.iter().try_for_each(|(on, off, number)| writeln!(out, "{number},{on:?},{off:?}"))
    }

    fn spline(&self, mut out: impl Write) -> io::Result<()> {
        let wheels = &self.result.coefficients_n_m;
        writeln!(out, "from_s{}", numbered(wheels.len(), "wheel", "_n_m"))?;
        for index in 0..wheels.first().map_or(0, Vec::len) {
            let row: Vec<f64> = wheels.iter().map(|wheel| wheel[index]).collect();
            writeln!(out, "{}{}", stamp_s(index, self.result.knot_s), values(&row))?;
        }
        Ok(())
    }
}

/// Writes the telecommands of an upload: the bytes of their user data, without header, tag and checksum.
fn telecommands(mut out: impl Write, table: &FlightTable) -> io::Result<()> {
    writeln!(out, "function,user_data_hex")?;
    for command in Command::upload(table) {
        let packet =
            command.packet(SequenceCount::new(0)).ok_or_else(|| io::Error::other("too long"))?;
        let data = packet.bytes().get(HEADER..packet.bytes().len() - CHECKSUM).unwrap_or_default();
        writeln!(out, "{},{}", command.function().code().1, hex(data))?;
    }
    Ok(())
}

/// Writes a series as CSV.
fn series(mut out: impl Write, rows: &[SeriesRow]) -> io::Result<()> {
    let wheels = rows.first().map_or(0, |row| row.torque_n_m.len());
    let sigma: String = ELEMENT_NAMES.iter().map(|name| format!(",sigma_{name}_kg_m2")).collect();
    writeln!(
        out,
        "t_s{}{},rate_x_rad_s,rate_y_rad_s,rate_z_rad_s,excursion_deg{sigma},observed_directions",
        numbered(wheels, "torque", "_n_m"),
        numbered(wheels, "wheel", "_rad_s"),
    )?;
    for row in rows {
        let sigma = row.sigma_kg_m2.map_or_else(|| ",".repeat(6), |sigma| values(&sigma));
        writeln!(
            out,
            "{}{}{}{},{}{sigma},{}",
            row.time_s,
            values(&row.torque_n_m),
            values(&row.wheel_speed_rad_s),
            values(&row.rate_rad_s),
            row.excursion_rad.to_degrees(),
            row.observed_directions,
        )?;
    }
    Ok(())
}

/// Writes a trade into a folder, which is created if it does not exist; files of an earlier report are removed.
///
/// # Errors
/// A path that cannot be written.
pub fn write_trade(
    folder: &Path,
    quantity: Trade,
    report: &TradeReport,
    command: &str,
) -> Result<(), OutputError> {
    const FILES: [(&str, &str); 2] =
        [("result.json", "the result as numbers"), ("trade.csv", "a row for each design")];
    let mut folder = Folder::open(folder, &[])?;
    folder.json("result.json", report)?;
    folder.stream("trade.csv", |out| trade_rows(out, quantity, &report.rows))?;
    let (page, figures) = page::trade(&report.scenario, quantity, &report.rows, command, &FILES);
    write_page(&mut folder, &page, &figures)
}

/// Writes a page and the points of its plots.
fn write_page(folder: &mut Folder, page: &str, figures: &[Figure]) -> Result<(), OutputError> {
    folder.text("report.html", page)?;
    figures.iter().try_for_each(|figure| {
        folder.stream(&format!("{}.csv", figure.name), |out| figure.write_csv(out))
    })
}

/// Writes the designs of a trade as CSV.
fn trade_rows(mut out: impl Write, quantity: Trade, rows: &[TradeRow]) -> io::Result<()> {
    let unit = match quantity {
        Trade::Excursion => "excursion_deg",
        Trade::Duration => "duration_s",
        Trade::Noise => "noise_rad_s",
    };
    let sigma: String = ELEMENT_NAMES.iter().map(|name| format!(",sigma_{name}_kg_m2")).collect();
    writeln!(out, "{unit},sigma_percent,gain,best_standard,limited_by{sigma}")?;
    for row in rows {
        let fixed = row.best_fixed.as_deref().unwrap_or_default();
        let sigma = values(&row.sigma_kg_m2);
        let TradeRow { value, sigma_percent, gain, limited_by, .. } = row;
        writeln!(out, "{value},{sigma_percent},{gain},{fixed},{limited_by}{sigma}")?;
    }
    Ok(())
}

/// Names of columns, each after a comma: `,wheel_1_n_m,wheel_2_n_m`.
fn numbered(count: usize, name: &str, unit: &str) -> String {
    (1..=count).map(|number| format!(",{name}_{number}{unit}")).collect()
}

/// Numbers, each after a comma.
fn values(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!(",{number:?}")).collect()
}
