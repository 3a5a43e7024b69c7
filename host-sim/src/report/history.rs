//! The estimate over time, and its CSV file.

use std::io;

use crate::input::ELEMENT_NAMES;

/// The estimate after one sample.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryRow {
    /// Time since the first sample, s.
    pub time_s: f64,
    /// Measured body rate, rad/s.
    pub measured_rate_rad_s: [f64; 3],
    /// Estimated body rate, rad/s.
    pub estimated_rate_rad_s: [f64; 3],
    /// One sigma of the estimated rate by the estimator's covariance, rad/s. None if the sample was not
    /// predicted.
    pub rate_sigma_rad_s: Option<[f64; 3]>,
    /// Angular acceleration, if the estimator computes one and this sample completed it.
    pub acceleration: Option<AccelerationRow>,
    /// Innovation: measured minus predicted rate, rad/s. None if the sample was not predicted. The estimator's own, or
    /// that of a filter with its last estimate: see [`innovations`](crate::diagnosis::innovations).
    pub innovation_rad_s: Option<[f64; 3]>,
    /// One sigma of the innovation by its predicted variance, rad/s.
    pub innovation_sigma_rad_s: Option<[f64; 3]>,
    /// Normalised innovation squared, three degrees of freedom.
    pub nis: Option<f64>,
    /// Elements of the inertia tensor, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of each, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// Outcome of the step, as `updated`.
    pub outcome: &'static str,
}

/// Angular acceleration at an instant before the row's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationRow {
    /// Body axes, rad/s².
    pub rad_s2: [f64; 3],
    /// Delay of the instant behind the row's time, s.
    pub delay_s: f64,
}

/// Writes the history as CSV. A missing value is an empty cell. Numbers have the fewest digits that
/// read back as the same `f64`.
///
/// # Errors
/// Those of `out`.
pub fn write_history<W: io::Write>(out: W, rows: &[HistoryRow]) -> io::Result<()> {
    let mut out = csv::Writer::from_writer(out);
    out.write_record(header())?;
    for row in rows {
        let numbers = (row.measured_rate_rad_s.map(Some).into_iter())
            .chain(row.estimated_rate_rad_s.map(Some))
            .chain(three(row.rate_sigma_rad_s))
            .chain(three(row.acceleration.map(|acceleration| acceleration.rad_s2)))
            .chain([row.acceleration.map(|acceleration| acceleration.delay_s)])
            .chain(three(row.innovation_rad_s))
            .chain(three(row.innovation_sigma_rad_s))
            .chain([row.nis])
            .chain(row.inertia_kg_m2.map(Some))
            .chain(row.sigma_kg_m2.map(Some));
        let mut cells = vec![row.time_s.to_string()];
        cells.extend(numbers.map(|number| number.map_or(String::new(), |x| format!("{x:?}"))));
        cells.push(row.outcome.to_owned());
        out.write_record(&cells)?;
    }
    out.flush()
}

/// Writes time and outcome of the samples that were rejected or reset part of the state, as CSV. The
/// ordinary outcomes of a running estimator are left out.
///
/// # Errors
/// Those of `out`.
pub fn write_events<W: io::Write>(out: W, rows: &[HistoryRow]) -> io::Result<()> {
    const ORDINARY: [&str; 3] = ["updated", "aligning", "refilling"];
    let mut out = csv::Writer::from_writer(out);
    out.write_record(["t_s", "outcome"])?;
    for row in rows.iter().filter(|row| !ORDINARY.contains(&row.outcome)) {
        out.write_record([&row.time_s.to_string(), row.outcome])?;
    }
    out.flush()
}

fn header() -> Vec<String> {
    let axes = |name: &str| ["x", "y", "z"].map(|axis| format!("{name}_{axis}_rad_s"));
    let mut names = vec!["t_s".to_owned()];
    names.extend(axes("gyro"));
    names.extend(axes("rate"));
    names.extend(axes("rate_sigma"));
    names.extend(["x", "y", "z"].map(|axis| format!("acceleration_{axis}_rad_s2")));
    names.push("acceleration_delay_s".to_owned());
    names.extend(axes("innovation"));
    names.extend(axes("innovation_sigma"));
    names.push("nis".to_owned());
    names.extend(ELEMENT_NAMES.map(|element| format!("{element}_kg_m2")));
    names.extend(ELEMENT_NAMES.map(|element| format!("sigma_{element}_kg_m2")));
    names.push("outcome".to_owned());
    names
}

/// The components, or three missing values.
fn three(vector: Option<[f64; 3]>) -> [Option<f64>; 3] {
    vector.map_or([None; 3], |vector| vector.map(Some))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_as_many_cells_as_the_header() {
        let predicted = HistoryRow {
            time_s: 0.1,
            measured_rate_rad_s: [1.0, 2.0, 3.0],
            estimated_rate_rad_s: [1.5, 2.5, 3.5],
            rate_sigma_rad_s: Some([2e-5; 3]),
            acceleration: Some(AccelerationRow { rad_s2: [7e-5; 3], delay_s: 0.25 }),
            innovation_rad_s: Some([1e-5, 0.0, -1e-5]),
            innovation_sigma_rad_s: Some([1e-4; 3]),
            nis: Some(2.5),
            inertia_kg_m2: [1.0, 2.0, 3.0, 0.1, 0.2, 0.3],
            sigma_kg_m2: [0.5; 6],
            outcome: "updated",
        };
        let first = HistoryRow {
            time_s: 0.0,
            rate_sigma_rad_s: None,
            acceleration: None,
            innovation_rad_s: None,
            innovation_sigma_rad_s: None,
            nis: None,
            outcome: "reset",
            ..predicted.clone()
        };
        let rows = [first, predicted];
        let mut bytes = Vec::new();
        write_events(&mut bytes, &rows).unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), "t_s,outcome\n0,reset\n");
        let mut bytes = Vec::new();
        write_history(&mut bytes, &rows).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("t_s,gyro_x_rad_s,"));
        assert!(lines[0].ends_with(",sigma_jyz_kg_m2,outcome"));
        assert!(
            lines[1].starts_with("0,1.0,2.0,3.0,1.5,2.5,3.5,,,,,,,,,,,,,,,1.0,"),
            "{}",
            lines[1]
        );
        assert!(lines[2].starts_with("0.1,1.0,2.0,3.0,1.5,2.5,3.5,2e-5,2e-5,2e-5,7e-5,"));
        assert!(lines[2].contains(",0.25,1e-5,0.0,-1e-5,0.0001,"), "{}", lines[2]);
        for line in &lines {
            assert_eq!(line.split(',').count(), 34, "{line}");
        }
    }
}
