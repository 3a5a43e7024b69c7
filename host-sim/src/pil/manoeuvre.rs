//! Manoeuvres for tests of the processor in the loop: a table, its telecommands, and what a flight reached.

use fsw_core::manoeuvre::{Abort, Limits, State};
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::manoeuvre::FlightTable;
use fsw_target::link::command::Command;
use fsw_target::link::telemetry::{ManoeuvreReport, Received, Telemetry};

use super::answering::Answering;
use super::software::Software;

/// Distance from the speed at the start that counts as rest, rad/s: that of the player, 1 rad/s or 0.2 % of the limit of
/// 700 rad/s, and the slowest speed of the tachometer, 0.52 rad/s.
pub const REST_RAD_S: f32 = 0.002 * 700.0 + 0.52;

/// Samples before the upload.
pub const UPLOAD_AT: usize = 8;
/// Samples before the start.
pub const START_AT: usize = 10;

/// A manoeuvre of 2.2 s for wheels of 0.5 mN m and more: each wheel speeds up, slows down, and returns.
pub fn table() -> FlightTable {
    let mut table = FlightTable {
        knot_us: 200_000,
        repeats: 1,
        splines: 8,
        limits: Limits {
            torque_n_m: [1e-3; WHEELS],
            speed_rad_s: [700.0; WHEELS],
            rate_rad_s: 0.5,
            excursion_rad: 0.5,
        },
        ..FlightTable::EMPTY
    };
    let pattern = [1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0];
    let sizes = [5e-4, -3e-4, 2e-4, -4e-4];
    for (coefficients, size) in table.coefficients_n_m.iter_mut().zip(sizes) {
        coefficients.iter_mut().zip(pattern).for_each(|(place, factor)| *place = size * factor);
    }
    table
}

/// A flight with a manoeuvre, and its expected end.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name.
    pub name: &'static str,
    /// The table.
    pub table: FlightTable,
    /// Telecommand after its start.
    pub command: Option<(usize, Command)>,
    /// Faults.
    pub answering: Answering,
    /// Samples before a power cut.
    pub restart_at: Option<usize>,
    /// Reason for the abort.
    pub abort: Option<Abort>,
}

impl Case {
    /// A table that is flown to its end.
    pub fn whole(name: &'static str, table: FlightTable) -> Self {
        let answering = Answering::default();
        Self { name, table, command: None, answering, restart_at: None, abort: None }
    }

    /// A manoeuvre that is flown to its end, and one for each way to abort it in mid-flight.
    pub fn all() -> Vec<Self> {
        let whole = Self::whole("flown to its end", table());
        let case = |name, abort| Self { name, abort: Some(abort), ..whole.clone() };
        let limited = |name, abort, rate_rad_s, excursion_rad, speed_rad_s| {
            let mut case = case(name, abort);
            let limits = &mut case.table.limits;
            (limits.rate_rad_s, limits.excursion_rad) = (rate_rad_s, excursion_rad);
            limits.speed_rad_s = [speed_rad_s; WHEELS];
            case
        };
        let middle = START_AT + 8;
        let fault = |from, to| Some([from, to]);
        vec![
            whole.clone(),
            limited("rate limit", Abort::Rate, 6e-4, 0.5, 700.0),
            limited("excursion limit", Abort::Excursion, 0.5, 3e-4, 700.0),
            // The wheels of the scenario turn at 200 rad/s.
            limited("speed limit", Abort::Speed, 0.5, 0.5, 206.0),
            Self {
                answering: Answering { lost: fault(middle, middle + 5), ..Answering::default() },
                ..case("gap", Abort::Gap)
            },
            Self {
                answering: Answering {
                    bus_errors: fault(middle, middle + 3),
                    ..Answering::default()
                },
                ..case("glitch", Abort::Glitch)
            },
            Self {
                command: Some((middle, Command::AbortManoeuvre)),
                ..case("command", Abort::Command)
            },
            Self { restart_at: Some(middle), ..case("power cut", Abort::Restart) },
        ]
    }

    /// Upload, start, and the telecommand of the case, each with the number of samples before it.
    pub fn commands(&self) -> Vec<(usize, Command)> {
        let upload = Command::upload(&self.table).map(|command| (UPLOAD_AT, command));
        let start = (START_AT, Command::StartManoeuvre { at_us: 0 });
        upload.chain([start]).chain(self.command).collect()
    }
}

/// Extremes of a flight, over all samples.
#[derive(Clone, Debug, Default)]
pub struct Reached {
    /// The last report of the manoeuvre.
    pub last: Option<ManoeuvreReport>,
    /// Largest torque of a motor, N m, and samples with a torque.
    pub most_n_m: f32,
    /// Samples in flight.
    pub flown: usize,
    /// Largest distance of a wheel from its speed at the start, rad/s.
    pub most_away_rad_s: f32,
    /// The same at the last sample.
    pub away_rad_s: f32,
}

impl Reached {
    /// Adds the telemetry of a sample.
    pub fn add(&mut self, software: &Software<'_, '_>, telemetry: &[Received]) {
        for received in telemetry {
            if let Telemetry::Manoeuvre(report) = received.telemetry {
                self.flown += usize::from(report.state == State::Flying);
                self.most_n_m = report.torque_n_m.iter().fold(self.most_n_m, |a, b| a.max(b.abs()));
                self.last = Some(report);
            }
        }
        let moves = |report: &&ManoeuvreReport| report.state != State::Waiting;
        if let Some(report) = self.last.as_ref().filter(moves) {
            let speeds = software.readings().wheel_speed_rad_s.into_iter();
            let away = speeds.zip(report.start_speed_rad_s).map(|(now, then)| (now - then).abs());
            self.away_rad_s = away.fold(0.0, f32::max);
            self.most_away_rad_s = self.most_away_rad_s.max(self.away_rad_s);
        }
    }

    /// Error text where the flight is not that of the case.
    pub fn check(&self, case: &Case) -> Result<(), String> {
        let (name, Some(last)) = (case.name, &self.last) else {
            return Err(format!("{}: no report", case.name));
        };
        let is_as_expected = last.abort == case.abort
            && last.state == State::AtRest
            && last.torque_n_m == [0.0; WHEELS]
            && self.flown > 0
            && self.most_n_m > 0.0
            && self.most_n_m <= case.table.limits.torque_n_m.into_iter().fold(0.0, f32::max)
            && self.most_away_rad_s > REST_RAD_S
            && self.away_rad_s <= REST_RAD_S;
        if is_as_expected { Ok(()) } else { Err(format!("{name}: {self:?}")) }
    }
}
