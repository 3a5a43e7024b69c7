//! The matrix: every fault × every estimator × every precision, with statistics over the runs of a cell.
//!
//! Run `i` has the seed `first_seed + i`. A task is one run of one estimator: its clean flight, and a flight
//! with each fault. Tasks are spread over rayon's threads and sorted afterwards, so that the numbers are
//! independent of the number of threads.

use std::sync::atomic::{AtomicBool, Ordering};

use fsw_core::Status;
use rayon::iter::{ParallelBridge, ParallelIterator};

use super::flight::Conditions;
use super::{Entry, Judged, Record, inject, interval_us};
use crate::campaign::{RunFailed, Truths};
use crate::estimation::{Method, Setup};
use crate::input::Scenario;
use crate::input::craft::hardware::Tachometer;
use crate::simulation::sensors;

/// Largest final error over that of the clean flight after a transient that discards no data from before it.
pub const MAX_OVER_CLEAN: f64 = 1.2;
/// Longest time of a silently wrong estimate in flight, s.
pub const MAX_WRONG_S: f64 = 60.0;
/// Longest total time with a health worse than that of the clean flight after a transient, s.
pub const MAX_OUTAGE_S: f64 = 60.0;

/// Scenario, faults, estimators and number of runs.
pub struct Matrix<'a> {
    /// Scenario; its own faults are not flown.
    pub scenario: &'a Scenario,
    /// Its truths and bounds.
    pub truths: &'a Truths,
    /// Faults.
    pub entries: &'a [Entry],
    /// Estimators and precisions.
    pub methods: &'a [Method],
    /// Seed of the first run.
    pub first_seed: u64,
    /// Runs of a cell.
    pub runs: u64,
}

/// Runs of one estimator and one fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Estimator and precision.
    pub method: Method,
    /// Name of the fault; none for the clean flight.
    pub fault: Option<String>,
    /// Statistics.
    pub row: Row,
}

/// Statistics of a cell. Times in s; worst is the longest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Runs.
    pub runs: usize,
    /// Runs in which the estimator panicked.
    pub panics: usize,
    /// Runs in which it reported a number that is not finite.
    pub not_finite: usize,
    /// Runs in which the fault was detected.
    pub detected: usize,
    /// Median time to the detection.
    pub detection_s: Option<f64>,
    /// Longest time to the detection.
    pub detection_worst_s: Option<f64>,
    /// Clean flights that report a fault.
    pub false_alarms: usize,
    /// Runs in which the health is worse than in the clean flight; clean flights that are not nominal at some time after
    /// their convergence.
    pub degraded: usize,
    /// Longest time from the start of the fault until then.
    pub degraded_s: Option<f64>,
    /// Runs that end with the health of the clean flight.
    pub nominal: usize,
    /// Longest time from the end of the fault until that health for good, of these runs.
    pub nominal_s: Option<f64>,
    /// Longest total time after the end of the fault with a health that is worse than that of the clean flight, s.
    pub outage_s: f64,
    /// Runs that end converged.
    pub converged: usize,
    /// Runs whose final estimate is a silent lie.
    pub silent: usize,
    /// Runs with a silently wrong estimate in flight.
    pub silent_in_flight: usize,
    /// Longest time from the start of the fault to a silently wrong estimate.
    pub wrong_s: f64,
    /// Runs that end as right as the clean flight.
    pub recovered: usize,
    /// Longest time from the end of the fault until the estimate is as right as the clean one for good,
    /// of the recovered runs.
    pub recovery_s: Option<f64>,
    /// Mean NEES per degree of freedom from the start of the fault to a minute after its end.
    pub nees_during: Option<f64>,
    /// Mean NEES per degree of freedom of the final estimates.
    pub nees_after: Option<f64>,
    /// RMS over runs and elements of final error over bound.
    pub over_bound: Option<f64>,
    /// The same over that of the clean flights.
    pub over_clean: Option<f64>,
    /// Requirements that the cell misses.
    pub missed: Vec<String>,
}

/// Judged flights of one task: the clean one, then one for each fault.
struct Task {
    run: u64,
    method: usize,
    false_alarm: bool,
    is_degraded: bool,
    flights: Vec<Judged>,
}

impl Matrix<'_> {
    /// Flies the matrix on all of rayon's threads: for each estimator its clean flights, then each fault.
    /// `done` is called after each task, of which there is one for each run and estimator. No task starts
    /// once `stop` is set.
    ///
    /// # Errors
    /// The error of any flight.
    pub fn fly(&self, stop: &AtomicBool, done: impl Fn() + Sync) -> Result<Vec<Cell>, RunFailed> {
        let methods = self.methods.len();
        let tasks = (0..self.runs).flat_map(|run| (0..methods).map(move |method| (run, method)));
        let mut tasks: Vec<Task> = tasks
            .take_while(|_| !stop.load(Ordering::Relaxed))
            .par_bridge()
            .map(|(run, method)| {
                let task = self.task(run, method);
                done();
                task
            })
            .collect::<Result<_, _>>()?;
        tasks.sort_unstable_by_key(|task| (task.method, task.run));
        let of = |index: usize| tasks.iter().filter(move |task| task.method == index);
        Ok((self.methods.iter().enumerate())
            .filter(|(index, _)| of(*index).next().is_some())
            .flat_map(|(index, method)| self.cells(*method, &of(index).collect::<Vec<_>>()))
            .collect())
    }

    /// Flies one run of one estimator.
    fn task(&self, run: u64, method: usize) -> Result<Task, RunFailed> {
        let seed = self.first_seed.wrapping_add(run);
        let mut scenario = Scenario { faults: Vec::new(), ..self.scenario.of_seed(seed) };
        // The driver of the flight computer corrects its readings.
        scenario.hardware.tachometers.fill(Tachometer::default());
        let truth = self.truths.of_run(&scenario, seed)?;
        let log = sensors(&scenario, &truth.flight, seed);
        let craft = scenario.craft();
        let Method { estimator, precision } = self.methods[method];
        let setup = Setup {
            estimator,
            precision,
            craft: &craft,
            gyro_noise_rad_s: craft.gyro.reading_sigma_rad_s(),
            sample_period_s: 1.0 / scenario.gyro.rate_hz,
            refuse_spikes: true,
        };
        let conditions =
            Conditions { setup: &setup, scenario: &scenario, reference: &truth.reference, seed };
        let noise_rad_s = scenario.gyro.noise_rad_s;
        let clean = Record::fly(&conditions, &inject(log.clone(), &[], noise_rad_s, seed), &[])?;
        let mut flights = vec![Judged::new(&clean, &clean, [0; 2])];
        for entry in self.entries {
            let faults = std::slice::from_ref(&entry.fault);
            let samples = inject(log.clone(), faults, noise_rad_s, seed);
            let record = Record::fly(&conditions, &samples, faults)?;
            let interval = interval_us(&entry.fault, 0, seed);
            flights.push(Judged::new(&record, &clean, interval));
        }
        // The clean flight is compared with itself, which hides its own silent lie.
        flights[0].is_silent = clean.is_silent();
        Ok(Task {
            run,
            method,
            false_alarm: clean.has_alarm(),
            is_degraded: clean.is_degraded(),
            flights,
        })
    }

    /// Cells of one estimator, from its tasks in the order of the runs.
    fn cells(&self, method: Method, tasks: &[&Task]) -> Vec<Cell> {
        let rows = |index: usize| -> Row {
            let flights: Vec<Judged> = tasks.iter().map(|task| task.flights[index]).collect();
            Row::of(&flights)
        };
        let mut clean = rows(0);
        clean.false_alarms = tasks.iter().filter(|task| task.false_alarm).count();
        clean.degraded = tasks.iter().filter(|task| task.is_degraded).count();
        clean.judge(None, None);
        let bound = clean.over_bound;
        let mut cells = vec![Cell { method, fault: None, row: clean }];
        for (index, entry) in self.entries.iter().enumerate() {
            let mut row = rows(index + 1);
            row.judge(bound, entry.most_over_clean(self.scenario.duration_s));
            cells.push(Cell { method, fault: Some(entry.name.clone()), row });
        }
        cells
    }
}

impl Row {
    /// Statistics of flights, in their order.
    fn of(flights: &[Judged]) -> Self {
        let count = |is: &dyn Fn(&Judged) -> bool| flights.iter().filter(|f| is(f)).count();
        let mut detections: Vec<f64> = flights.iter().filter_map(|f| f.detection_s).collect();
        detections.sort_by(f64::total_cmp);
        let sum = |of: &dyn Fn(&Judged) -> [f64; 2]| {
            let add = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b + d];
            flights.iter().map(of).fold([0.0; 2], add)
        };
        let mean = |[sum, count]: [f64; 2]| (count > 0.0).then(|| sum / count);
        let longest = |times: &mut dyn Iterator<Item = f64>| times.reduce(f64::max);
        Self {
            runs: flights.len(),
            panics: count(&|f| f.panicked),
            not_finite: count(&|f| !f.is_finite),
            detected: detections.len(),
            detection_s: detections.get(detections.len() / 2).copied(),
            detection_worst_s: detections.last().copied(),
            false_alarms: 0,
            degraded: count(&|f| f.degraded_s.is_some()),
            degraded_s: longest(&mut flights.iter().filter_map(|f| f.degraded_s)),
            nominal: count(&|f| f.nominal_s.is_some()),
            nominal_s: longest(&mut flights.iter().filter_map(|f| f.nominal_s)),
            outage_s: longest(&mut flights.iter().map(|f| f.outage_s)).unwrap_or(0.0),
            converged: count(&|f| f.status == Some(Status::Converged)),
            silent: count(&|f| f.is_silent),
            silent_in_flight: count(&|f| f.wrong_s > 0.0),
            wrong_s: longest(&mut flights.iter().map(|f| f.wrong_s)).unwrap_or(0.0),
            recovered: count(&|f| f.recovery_s.is_some()),
            recovery_s: longest(&mut flights.iter().filter_map(|f| f.recovery_s)),
            nees_during: mean(sum(&|f| f.nees_during)),
            nees_after: mean(sum(&|f| f.nees_after.map_or([0.0; 2], |nees| [nees, 1.0]))),
            over_bound: mean(sum(&|f| f.over_bound)).map(f64::sqrt),
            over_clean: None,
            missed: Vec::new(),
        }
    }

    /// Compares with the clean flights and lists the requirements that are missed. `most_over_clean`: largest error over
    /// that of the clean flights, where it has a limit.
    fn judge(&mut self, clean_over_bound: Option<f64>, most_over_clean: Option<f64>) {
        let ratio = |own: f64, clean: f64| own / clean;
        self.over_clean = self.over_bound.zip(clean_over_bound).map(|(a, b)| ratio(a, b));
        let mut check = |holds: bool, text: String| {
            if !holds {
                self.missed.push(text);
            }
        };
        check(self.panics == 0, format!("{} panicked", self.panics));
        check(self.not_finite == 0, format!("{} not finite", self.not_finite));
        check(self.silent == 0, format!("{} silent", self.silent));
        check(self.wrong_s <= MAX_WRONG_S, format!("silent for {:.0} s", self.wrong_s));
        if let Some(most) = most_over_clean {
            // A ratio that is not a number is missed, too.
            let holds = self.over_clean.is_none_or(|ratio| ratio <= most);
            check(holds, format!("error/clean > {most:.2}"));
            check(self.outage_s <= MAX_OUTAGE_S, format!("outage of {:.0} s", self.outage_s));
        }
    }
}
