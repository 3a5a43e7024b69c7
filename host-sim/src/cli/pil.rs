//! `pil`: the firmware in QEMU with simulated sensors, compared with the same software on the host.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use target_tools::board::{BOARDS, Board, STM32F405};

use super::estimate::note_changes;
use super::flight_estimator::FlightEstimator;
use super::notes::Notes;
use super::progress::Progress;
use super::{Failure, command_line, print};
use crate::estimation::{Method, Precision};
use crate::input::scenario::{DEFAULT_SCENARIO, SourceFile};
use crate::input::{Scenario, scenario};
use crate::pil::firmware::Image;
use crate::pil::{Mission, PilFailed, fly, setup};
use crate::report::json::PilReport;
use crate::report::pil::PilHistory;
use crate::report::{FlightResult, ReportFolder, Simulated, table};
use crate::truth::Flight;

#[derive(Debug, Args)]
pub struct Arguments {
    /// SCENARIO.toml, or name of a built-in scenario
    #[arg(default_value = DEFAULT_SCENARIO)]
    scenario: String,
    /// Estimator of the flight image
    #[arg(long, value_enum, default_value = "window")]
    estimator: FlightEstimator,
    /// Seed of gyro noise and dispersion
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Cut the power after this many samples, and continue from the checkpoint in flash
    #[arg(long, value_name = "SAMPLE")]
    restart_at: Option<usize>,
    /// Board of the firmware, by its machine in QEMU
    #[arg(long, default_value = STM32F405.feature, value_parser = boards())]
    board: Board,
    /// ELF file of the image `pil`; without it, the image is built from source
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// Write a report for the browser, time history and plot data into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document instead of a table
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scenario, estimator, seed, restart_at, board, image, out, json } = arguments;
    let sources = scenario::sources(scenario);
    let scenario = Scenario::load(scenario)?.of_seed(*seed);
    let mut notes = Notes::default();
    note_changes(&scenario, &mut notes);
    note_ignored_keys(&scenario, &mut notes);
    let FlightEstimator { id, name } = *estimator;
    let method = Method { estimator: name, precision: Precision::F32 };
    let flight = Flight::simulate(&scenario)?;
    let mission = Mission {
        scenario: &scenario,
        flight: &flight,
        seed: *seed,
        estimator: id,
        restart_at: *restart_at,
        commands: &[],
        answering: None,
    };
    // A mission that cannot be flown fails before the image is built.
    setup::of(&mission).map_err(PilFailed::from)?;
    let image = Image::find(board, image.clone()).map_err(PilFailed::from)?;

    let begun = Instant::now();
    let bar = Progress::new(flight.instants.len() as u64, "samples");
    let mut history = PilHistory::new(scenario.gyro.noise_rad_s);
    let result = fly(
        &mission,
        || image.start(),
        None,
        |software, telemetry| {
            bar.inc(1);
            if out.is_some() {
                history.add(software, telemetry);
            }
        },
    );
    bar.finish();
    let mut report = PilReport::new(&mission, method, &result?, begun.elapsed());
    report.run.estimate.notes = notes.into_list();
    let table = table::pil(&report);
    if let Some(folder) = out {
        write_folder(folder, &mission, &sources?, &report, &history)?;
    }
    print(*json, &report, &table)
}

/// Parser of the name of a board.
fn boards() -> impl TypedValueParser<Value = Board> {
    PossibleValuesParser::new(BOARDS.map(|board| board.feature))
        .try_map(|name| Board::of_name(&name))
}

fn write_folder(
    folder: &Path,
    mission: &Mission<'_>,
    sources: &[SourceFile],
    report: &PilReport,
    history: &PilHistory,
) -> Result<(), Failure> {
    let Mission { scenario, flight, .. } = mission;
    let craft = scenario.craft();
    let estimator = &report.run.estimate.estimator;
    ReportFolder {
        title: &format!("{}, {estimator}, processor in the loop", scenario.name),
        command: &command_line(),
        result: FlightResult::Pil(report),
        history: &history.rows,
        inputs: &[],
        simulated: Some(Simulated { log: &history.log, craft: &craft, flight, scenario: sources }),
    }
    .write(folder)?;
    Ok(())
}

/// Notes on keys of the scenario that the flight image does not support.
fn note_ignored_keys(scenario: &Scenario, notes: &mut Notes) {
    let craft = scenario.craft();
    if craft.solve_for.torque || craft.solve_for.gyro_bias {
        notes.add("the flight image estimates the inertia alone; [disturbance] is ignored");
    }
    if craft.filter.rate_walk_rad_s_sqrt_s.is_some()
        || craft.filter.inertia_walk_kg_m2_sqrt_hour.is_some()
    {
        notes.add("the flight image has no process noise; [filter] is ignored");
    }
    if !scenario.faults.is_empty() {
        notes.add("the sensors of the loop are models of the chips; [[fault]] is ignored");
    }
    let stated = &craft.hardware;
    if stated.bias_sigma_rad_s.is_some() || stated.torque_sigma_n_m.is_some() {
        notes.add(
            "the flight image takes gyro bias and disturbance torque as zero; gyro.bias_sigma_rad_s and \
             disturbance.torque_sigma_n_m are ignored",
        );
    }
    let hardware = &scenario.true_hardware;
    if scenario.tachometers().any(|it| it != Default::default())
        || hardware.clock != Default::default()
    {
        notes.add(
            "the wheels have encoders on the flight computer's own timer; [wheels.tachometer], \
             [hardware.tachometer] and [hardware.clock] are ignored",
        );
    }
    let gyro = &scenario.gyro;
    if gyro.quantum_rad_s.is_some() || gyro.range_rad_s.is_some() {
        notes.add(
            "the gyro is a BMI088 with its own quantum and range; gyro.quantum_rad_s and \
             gyro.range_rad_s are ignored",
        );
    }
}
