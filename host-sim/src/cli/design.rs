//! `design`: a manoeuvre for the estimation of the inertia, within limits of wheels and pointing.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use clap::Args;
use nalgebra::Vector3;

use super::notes::Notes;
use super::progress::{Progress, stop_on_signal};
use super::{Failure, command_line, print};
use crate::input::Scenario;
use crate::manoeuvre::{
    Criterion, Design, DesignError, Effort, KeepOut, Limits, Progress as Step, Request, Trade,
    Treatment, accuracy, design, flight_table, flown, series, subject, trade,
};
use crate::report::{DesignFolder, DesignReport, TradeReport, table, write_trade};

#[derive(Debug, Args)]
pub struct Arguments {
    /// SCENARIO.toml, CRAFT.toml, or name of a built-in scenario
    subject: String,
    /// Duration of the manoeuvre, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = positive)]
    duration: f64,
    /// Largest rotation from the attitude at the start, deg, below 180
    #[arg(long, value_name = "DEG", default_value_t = 5.0, value_parser = positive)]
    excursion: f64,
    /// Largest body rate, deg/s
    #[arg(long, value_name = "DEG_S", value_parser = positive)]
    rate: Option<f64>,
    /// Share of each wheel's largest torque that may be used
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    torque: f64,
    /// Share of each wheel's largest speed that may be used
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    momentum: f64,
    /// Largest rotation left at the end, deg
    #[arg(long = "return", value_name = "DEG", default_value_t = 0.1, value_parser = positive)]
    return_deg: f64,
    /// Cone that an instrument stays out of: its boresight in body axes, the direction of the cone in
    /// inertial axes, its half angle in deg, as 0,0,1:1,0,0.2:30; may be repeated
    #[arg(long, value_name = "B:D:DEG", value_parser = keep_out)]
    keep_out: Vec<KeepOut>,
    /// Measure of the covariance: a, sum of variances; d, volume; e, worst direction
    #[arg(long, value_enum, value_name = "CRITERION", default_value_t = Criterion::A)]
    optimality: Criterion,
    /// Stated errors of the hardware: considered in the covariance, or solved for
    #[arg(long, value_enum, value_name = "TREATMENT", default_value_t = Treatment::Considered)]
    hardware: Treatment,
    /// Samples per second of the gyro of a craft file, Hz
    #[arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = positive)]
    rate_hz: f64,
    /// Manoeuvres from which the search starts
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = count)]
    starts: usize,
    /// Seed of starts and of samples of the prior
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Design over a range of one quantity: excursion in deg, duration in s, noise in rad/s
    #[arg(long, value_enum, value_name = "QUANTITY")]
    trade: Option<Trade>,
    /// Range of the trade, as 0.05..20; a tenth to ten times the value asked for if left out
    #[arg(long, value_name = "FROM..TO", value_parser = range, requires = "trade")]
    range: Option<[f64; 2]>,
    /// Designs of the trade
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = count, requires = "trade")]
    points: usize,
    /// Write a report for the browser, the torque table, a scenario that flies it and the telecommands into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let number: f64 =
        text.trim_end_matches("deg").parse().map_err(|_| "not a number".to_owned())?;
    (number.is_finite() && number > 0.0).then_some(number).ok_or("it must be positive".to_owned())
}

fn share(text: &str) -> Result<f64, String> {
    let share = positive(text)?;
    (share <= 1.0).then_some(share).ok_or_else(|| match share <= 100.0 {
        true => format!("it is a share, 1 at most: {} for {share} %", share / 100.0),
        false => "it is a share, 1 at most".to_owned(),
    })
}

fn count(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|count| *count > 0)
        .ok_or("it must be a whole number above 0".to_owned())
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let (from, to) = text.split_once("..").ok_or("give FROM..TO, as 0.05..20")?;
    let range = [positive(from)?, positive(to)?];
    (range[0] < range[1]).then_some(range).ok_or("the first number must be the smaller".to_owned())
}

fn keep_out(text: &str) -> Result<KeepOut, String> {
    let shape = || "give BORESIGHT:DIRECTION:DEG, as 0,0,1:1,0,0.2:30".to_owned();
    let parts: Vec<&str> = text.split(':').collect();
    let [boresight, direction, angle] = parts[..] else { return Err(shape()) };
    let unit = |text: &str| {
        let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
        let vector = numbers.filter(|list| list.len() == 3).map(Vector3::from_vec);
        vector.and_then(|vector| vector.try_normalize(0.0)).ok_or_else(shape)
    };
    let half_angle_deg = positive(angle)?;
    if half_angle_deg >= 180.0 {
        return Err("the half angle of a cone is below 180 deg".to_owned());
    }
    let half_angle_rad = half_angle_deg.to_radians();
    Ok(KeepOut { boresight: unit(boresight)?, direction: unit(direction)?, half_angle_rad })
}

impl Arguments {
    fn request(&self) -> Request {
        Request {
            duration_s: self.duration,
            limits: Limits {
                excursion_rad: self.excursion.to_radians(),
                rate_rad_s: self.rate.map(f64::to_radians),
                torque_share: self.torque,
                momentum_share: self.momentum,
                return_rad: self.return_deg.to_radians(),
                keep_out: self.keep_out.clone(),
            },
            criterion: self.optimality,
            treatment: self.hardware,
            uses_prior: true,
            seed: self.seed,
            effort: Effort { starts: self.starts, ..Effort::default() },
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = subject(&arguments.subject, arguments.rate_hz)?;
    let failed = |error: DesignError| Failure::Design { scenario: scenario.name.clone(), error };
    let mut notes = Notes::default();
    note_assumptions(&scenario, &mut notes);
    let request = arguments.request();
    if let Some(quantity) = arguments.trade {
        return run_trade(arguments, &scenario, &request, quantity);
    }
    let stop = stop_on_signal();
    let bar = Progress::new(1, "rounds");
    let show = |progress: Step| {
        let gain = format!(", gain {:.2}", progress.gain);
        bar.set(progress.done as u64, progress.of as u64, gain);
    };
    let designed = designed(&scenario, &request, &stop, &show, &mut notes);
    bar.finish();
    let (found, report) = designed?;
    let on_board = match flight_table(&scenario, &request, &found) {
        Ok(table) => Some(table),
        Err(why) => {
            notes.add(format!("no telecommands: {why}"));
            None
        }
    };
    let text = table::design(&report);
    if let Some(folder) = &arguments.out {
        let of = |manoeuvre| series(&scenario, &request, manoeuvre);
        let standard = found.fixed.first().map(of).transpose().map_err(failed)?;
        DesignFolder {
            command: &command_line(),
            notes: &notes.into_list(),
            result: &report,
            scenario: &flown(&scenario, &found.best.table),
            table_on_board: on_board.as_ref(),
            series: &of(&found.best).map_err(failed)?,
            standard: &standard.unwrap_or_default(),
        }
        .write(folder)?;
    }
    print(arguments.json, &report, &text)
}

/// The best manoeuvre found until `stop` is set, and its report.
fn designed(
    scenario: &Scenario,
    request: &Request,
    stop: &AtomicBool,
    show: &(dyn Fn(Step) + Sync),
    notes: &mut Notes,
) -> Result<(Design, DesignReport), Failure> {
    let failed = |error: DesignError| Failure::Design { scenario: scenario.name.clone(), error };
    let found = design(scenario, request, stop, show).map_err(failed)?;
    let [completed, starts] = found.starts;
    if completed < starts {
        notes.add(format!(
            "stopped with {completed} of {starts} starts complete; the result is the best so far"
        ));
    }
    let accuracy = accuracy(scenario, request, &found.best).map_err(failed)?;
    let report = DesignReport::new(scenario, request, &found, &accuracy);
    Ok((found, report))
}

/// Report of the manoeuvre that the arguments ask for, without printing or writing.
pub(super) fn report(arguments: &Arguments, stop: &AtomicBool) -> Result<DesignReport, Failure> {
    let scenario = subject(&arguments.subject, arguments.rate_hz)?;
    let mut notes = Notes::quiet();
    designed(&scenario, &arguments.request(), stop, &|_| (), &mut notes).map(|(_, report)| report)
}

fn note_assumptions(scenario: &Scenario, notes: &mut Notes) {
    if scenario.prior.is_none() {
        notes.add("no [prior]: the design is for the inertia of the scenario, as if it were known");
    }
    if !scenario.hardware.modes.is_empty() {
        notes.add("[[mode]] is left out of the design: a rigid body is assumed");
    }
}

fn run_trade(
    arguments: &Arguments,
    scenario: &Scenario,
    request: &Request,
    quantity: Trade,
) -> Result<(), Failure> {
    let about = quantity.of(scenario, request);
    let range = arguments.range.unwrap_or([0.1 * about, 10.0 * about]);
    let stop = stop_on_signal();
    let bar = Progress::new(arguments.points as u64, "designs");
    let rows = trade(scenario, request, (quantity, range, arguments.points), &stop, &|| bar.inc(1));
    bar.finish();
    let rows = rows.map_err(|error| Failure::Design { scenario: scenario.name.clone(), error })?;
    if rows.is_empty() {
        return Err(Failure::Interrupted);
    }
    let report = TradeReport { scenario: scenario.name.clone(), quantity: quantity.name(), rows };
    if let Some(folder) = &arguments.out {
        write_trade(folder, quantity, &report, &command_line())?;
    }
    let text = table::trade(quantity, &report.rows);
    print(arguments.json, &report, &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_above_one_is_refused_and_a_percentage_converted() {
        assert_eq!(share("0.9"), Ok(0.9));
        assert_eq!(share("1"), Ok(1.0));
        assert_eq!(share("90").unwrap_err(), "it is a share, 1 at most: 0.9 for 90 %");
        assert_eq!(share("200").unwrap_err(), "it is a share, 1 at most");
        assert!(share("0").is_err() && share("NaN").is_err() && share("-0.5").is_err());
    }
}
