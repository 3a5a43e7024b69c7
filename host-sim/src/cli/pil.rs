//! `pil`: the firmware in QEMU, flown with simulated sensors, beside the same software on the host.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::telemetry::{Received, Telemetry};
use nalgebra::Vector3;

use super::campaign::progress_bar;
use super::estimate::{note_what_changes, report};
use super::{Failure, command_line, print};
use crate::estimation::{EstimatorName, Flown, Precision, on_board};
use crate::input::Scenario;
use crate::input::log::LogRow;
use crate::input::scenario::DEFAULT_SCENARIO;
use crate::pil::firmware::Image;
use crate::pil::software::{Readings, Software};
use crate::pil::{Mission, PilFailed, PilFlight, fly, setup};
use crate::recording::history_row;
use crate::report::json::{PilReport, TargetReport};
use crate::report::{HistoryRow, ReportFolder, RunReport, Simulated, table};
use crate::truth::Flight;

#[derive(Debug, Args)]
pub struct Arguments {
    /// A SCENARIO.toml, or the name of a built-in one.
    #[arg(default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// The estimator: one of those in the flight image.
    #[arg(long, value_enum, default_value_t = InTheImage::Window)]
    estimator: InTheImage,
    /// Seed of the gyro's noise, and of what the scenario disperses.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// After so many samples, cut the power and go on from the checkpoint in flash.
    #[arg(long, value_name = "SAMPLE")]
    restart_at: Option<usize>,
    /// The ELF file of the image `pil`; built from source if it isn't given.
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// Write the time history, plots and a report into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
}

/// The estimators that fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum InTheImage {
    /// Our own: each manoeuvre fitted as a whole, at the Cramér-Rao bound.
    Window,
    /// Nine-state filter in UD form.
    JointEkf,
    /// Rate filter, causal Savitzky-Golay, recursive least squares.
    EkfSgfRls,
}

impl InTheImage {
    fn names(self) -> (EstimatorId, EstimatorName) {
        match self {
            Self::Window => (EstimatorId::Window, EstimatorName::Window),
            Self::JointEkf => (EstimatorId::JointEkf, EstimatorName::JointEkf),
            Self::EkfSgfRls => (EstimatorId::EkfSgfRls, EstimatorName::EkfSgfRls),
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, estimator, seed, restart_at, image, out, json } = arguments;
    let scenario = Scenario::load(scenario)?.of_seed(*seed);
    note_what_changes(&scenario);
    note_what_the_image_leaves_out(&scenario);
    let (estimator, name) = estimator.names();
    let flight = Flight::simulate(&scenario)?;
    let mission = Mission {
        scenario: &scenario,
        flight: &flight,
        seed: *seed,
        estimator,
        restart_at: *restart_at,
        commands: &[],
    };
    // Before an image is built in vain.
    setup::of(&mission).map_err(PilFailed::from)?;
    let image = Image::find(image.clone()).map_err(PilFailed::from)?;

    let begun = Instant::now();
    let bar = progress_bar(flight.instants.len() as u64, "samples");
    let mut course = Course { noise_rad_s: scenario.gyro.noise_rad_s, ..Course::default() };
    let flown = fly(
        &mission,
        || image.start(),
        None,
        |software, told| {
            bar.inc(1);
            if out.is_some() {
                course.note(software, told);
            }
        },
    );
    bar.finish_and_clear();
    let (flown, wall) = (flown?, begun.elapsed());

    let report = of_flight(&mission, name, &flown, wall);
    let table = table::pil(&report);
    if let Some(folder) = out {
        let craft = scenario.craft();
        let title = format!("{}, {name}, processor in the loop", scenario.name);
        ReportFolder {
            title: &title,
            command: &command_line(),
            table: &table,
            result: &report,
            history: &course.history,
            simulated: Some(Simulated { log: &course.log, craft: &craft, flight: &flight }),
        }
        .write(folder)?;
    }
    print(*json, &report, &table)
}

/// Says so where the scenario asks for what the flight image hasn't.
fn note_what_the_image_leaves_out(scenario: &Scenario) {
    let craft = scenario.craft();
    if craft.solve_for.torque || craft.solve_for.gyro_bias {
        eprintln!("note: the flight image solves for the inertia alone; [disturbance] is ignored");
    }
    if craft.rate_walk_rad_s_sqrt_s.is_some() || craft.inertia_walk_kg_m2_sqrt_hour.is_some() {
        eprintln!("note: the flight image knows no process noise; [filter] is ignored");
    }
    let gyro = &scenario.gyro;
    if gyro.quantum_rad_s.is_some() || gyro.range_rad_s.is_some() {
        eprintln!(
            "note: the gyro is a BMI088 with its own rounding and range; gyro.quantum_rad_s and \
             gyro.range_rad_s are ignored"
        );
    }
}

/// What is kept of a flight for its folder.
#[derive(Default)]
struct Course {
    noise_rad_s: f64,
    history: Vec<HistoryRow>,
    log: Vec<LogRow>,
}

impl Course {
    /// A sample that was stepped; of one that was skipped the ground is told nothing.
    fn note(&mut self, software: &Software<'_, '_>, told: &[Received]) {
        let outcome = told.iter().find_map(|received| match received.telemetry {
            Telemetry::Estimate(estimate) => estimate.outcome,
            _ => None,
        });
        let Some(outcome) = outcome else { return };
        let row = log_row(&software.readings(), self.log.len() as u64 + 2);
        let known = on_board(software.onboard().clone(), Some(self.noise_rad_s));
        self.history.push(history_row(&row, &outcome, known.as_ref()));
        self.log.push(row);
    }
}

/// What the drivers read, as a log has it: line 1 is its heading.
fn log_row(readings: &Readings, line: u64) -> LogRow {
    let widen = |vector: &fsw_core::Vec3<f32>| Vector3::from_fn(|i, _| f64::from(vector[i]));
    LogRow {
        line,
        time_us: readings.time_us,
        rate_rad_s: widen(&readings.rate_rad_s),
        wheel_speed_rad_s: readings.wheel_speed_rad_s.map(f64::from).to_vec(),
        torque_n_m: widen(&readings.torque_n_m),
        attitude: None,
    }
}

fn of_flight(
    mission: &Mission<'_>,
    name: EstimatorName,
    flown: &PilFlight,
    wall: Duration,
) -> PilReport {
    let estimate = on_board(flown.onboard.clone(), None).estimate();
    let counted = Flown { counts: flown.outcomes, estimate };
    let mut estimate = report(name, Precision::F32, flown.compared, &counted);
    for (reason, count) in
        [("gyro_failed", flown.gyro_failures), ("no_wheel_speed", flown.wheel_failures)]
    {
        if count > 0 {
            estimate.rejected.insert(reason.to_owned(), u64::from(count));
        }
    }
    let scenario = mission.scenario;
    let (truth, bound) = (scenario.final_inertia_kg_m2(), mission.flight.bound.sigma_kg_m2);
    PilReport {
        run: RunReport::new(&scenario.name, mission.seed, estimate, truth, bound),
        target: TargetReport {
            identical_samples: flown.compared as u64,
            restarted_at: mission.restart_at,
            stack_high_water_bytes: flown.stack_high_water_bytes,
            wall_s: wall.as_secs_f64(),
        },
    }
}
