//! The bench image in QEMU: instructions per estimator step, as a table with the budgets.

mod log;
mod table;

use crate::budgets::{self, Budget, Bytes, Figure};
use crate::cycles::{Cycles, Trace};
use crate::{firmware, image, qemu};
use anyhow::{Result, bail, ensure};
use log::Words;
use std::time::Duration;

/// Covariance of `joint-ekf`, by its names in the log of the bench.
const OURS: [&str; 2] = ["covariance-ud", "covariance-ud-walk"];
/// Other Kalman filters on the same problem.
const PEERS: [&str; 4] = ["dense-nalgebra", "adskalman", "adskalman-joseph", "minikalman"];

/// Clock of the STM32F405: 168 MHz.
const CYCLES_PER_US: f64 = 168.0;

/// Largest number of instructions counted around a step: its call through a wrapper.
const AROUND_A_STEP: u32 = 64;

/// Time limit of a run. All flights take seconds on an idle machine.
const LIMIT: Duration = Duration::from_secs(600);

/// Counts of one estimator on one flight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Count {
    /// Name of the estimator or filter.
    pub name: String,
    /// Name of the flight.
    pub flight: String,
    /// Number of steps.
    pub steps: u32,
    /// Instructions of the most expensive step.
    pub worst: u32,
    /// Index of that step, from 0.
    pub at: u32,
    /// Instructions of the median step.
    pub median: u32,
    /// Status of the estimate at the end of the flight.
    pub status: String,
}

/// Counts of the steps with one outcome.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutcomeCount {
    /// Name of the estimator or filter.
    pub name: String,
    /// Name of the flight.
    pub flight: String,
    /// Outcome.
    pub outcome: String,
    /// Number of steps.
    pub steps: u32,
    /// Instructions of the most expensive step.
    pub worst: u32,
}

/// Counts of the slices of one kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SliceCount {
    /// Name of the estimator.
    pub name: String,
    /// Name of the flight.
    pub flight: String,
    /// Kind of the slices.
    pub kind: String,
    /// Number of slices.
    pub slices: u32,
    /// Instructions of the most expensive slice.
    pub worst: u32,
    /// Instructions of the median slice.
    pub median: u32,
}

/// Samples after whose slices work was left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkCount {
    /// Name of the estimator.
    pub name: String,
    /// Name of the flight.
    pub flight: String,
    /// Number of these samples.
    pub busy: u32,
    /// Longest run of them: the delay of the fit over all blocks.
    pub longest: u32,
}

/// A budget and its measured figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Limit.
    pub budget: Budget,
    /// Largest figure over all flights; `None` if missing in the log.
    pub measured: Option<f64>,
}

/// Cycles of an estimator on the traced flight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CyclesOf {
    /// Name of the estimator or filter.
    pub name: String,
    /// Cycles of the median step.
    pub median: Cycles,
    /// Cycles of the most expensive step.
    pub worst: Cycles,
}

/// Flash of an image and its limit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flash {
    /// Name of the image.
    pub name: String,
    /// Limit.
    pub limit: Bytes,
    /// Measured, bytes.
    pub bytes: u64,
}

/// Result of the bench.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Counts by name and flight, in the order of the log.
    pub counts: Vec<Count>,
    /// Counts by name, flight and outcome.
    pub outcomes: Vec<OutcomeCount>,
    /// Counts of the slices of work by name, flight and kind.
    pub slices: Vec<SliceCount>,
    /// Work left after the slices of a sample, by name and flight.
    pub work: Vec<WorkCount>,
    /// Instruction budgets.
    pub checked: Vec<Checked>,
    /// Estimated cycles, of the shortest flight.
    pub cycles: Vec<CyclesOf>,
    /// Flash of the flight images.
    pub flash: Vec<Flash>,
}

/// Builds the bench image, runs it in QEMU and reads its log.
///
/// # Errors
/// A build fails, QEMU is missing, or the image reports a failure.
pub fn run() -> Result<Table> {
    let elf = firmware::build_of("fsw-bench", "bench", &[])?;
    let run = qemu::run_counting(&elf, qemu::MACHINE, LIMIT, |_| {})?;
    if !run.success {
        bail!("the bench image reported a failure, its log:\n{}", run.lines.join("\n"));
    }
    Ok(Table { cycles: cycles()?, flash: flash()?, ..Table::of(&run.lines)? })
}

/// Cycles of the steps of the shortest flight, from an execution trace.
fn cycles() -> Result<Vec<CyclesOf>> {
    let elf = firmware::build_of("fsw-bench", "bench", &["--features", "one-flight"])?;
    let mut trace = Trace::new(image::functions(&elf, &["step_fast", "step_covariance"])?);
    let run = qemu::run_tracing(&elf, qemu::MACHINE, LIMIT, &mut trace)?;
    let mut calls = trace.calls.into_iter();
    // The log gives name and number of steps in the order of the trace.
    let of_count = |count: Count| {
        let mut steps: Vec<_> = calls.by_ref().take(count.steps as usize).collect();
        let traced = steps.iter().map(|step| step.instructions).max().unwrap_or_default();
        // The count includes the call of the traced function.
        let is_whole = steps.len() == count.steps as usize
            && (count.worst.saturating_sub(AROUND_A_STEP)..=count.worst).contains(&traced);
        ensure!(
            is_whole,
            "{}: the trace has {traced} instructions of the worst step, the count {}",
            count.name,
            count.worst
        );
        steps.sort_by_key(|step| step.of_refill[1]);
        let median = steps.get(steps.len() / 2).copied().unwrap_or_default();
        let worst = steps.last().copied().unwrap_or_default();
        Ok(CyclesOf { name: count.name, median, worst })
    };
    let counts = Table::of(&run.lines)?.counts;
    counts.into_iter().map(of_count).collect()
}

/// Flash of the flight images. The one with all estimators is built last, so that it remains in the
/// target folder.
fn flash() -> Result<Vec<Flash>> {
    let with_one = budgets::FLIGHT_FLASH_WITH_ONE.iter().map(|(name, limit)| {
        let features = format!("{},{name}", firmware::BOARD);
        let arguments = ["--no-default-features", "--features", &features];
        Flash::of(&format!("flight, {name}"), &arguments, *limit)
    });
    with_one.chain([Flash::of("flight, all three", &[], budgets::FLIGHT_FLASH)]).collect()
}

impl Flash {
    fn of(name: &str, arguments: &[&str], limit: Bytes) -> Result<Self> {
        let elf = firmware::build_with("flight", arguments)?;
        Ok(Self { name: name.into(), limit, bytes: image::memory(&elf)?.flash })
    }
}

impl Table {
    /// From the lines of the bench's log.
    fn of(lines: &[String]) -> Result<Self> {
        let of_kind =
            |kind: &'static str| lines.iter().filter_map(move |line| Words::of(line, kind));
        let counts = of_kind("count").map(|words| words.count()).collect::<Result<Vec<_>>>()?;
        let outcomes = of_kind("outcome").map(|words| words.outcome()).collect::<Result<_>>()?;
        let slices = of_kind("slice").map(|words| words.slice()).collect::<Result<Vec<_>>>()?;
        let work = of_kind("work").map(|words| words.work()).collect::<Result<_>>()?;
        let checked = budgets::INSTRUCTIONS
            .iter()
            .map(|budget| Checked { budget: *budget, measured: measured(budget, &counts, &slices) })
            .collect();
        Ok(Self { counts, outcomes, slices, work, checked, cycles: Vec::new(), flash: Vec::new() })
    }

    /// True if every figure is present and within its limit.
    pub fn is_kept(&self) -> bool {
        self.exceeded().is_empty() && self.flash.iter().all(|f| f.bytes <= f.limit.held)
    }

    /// Instruction budgets that are exceeded or without a figure.
    pub fn exceeded(&self) -> Vec<&Checked> {
        self.checked.iter().filter(|checked| !checked.is_kept()).collect()
    }

    /// Median of a filter that is counted on one flight.
    fn median(&self, name: &str) -> Option<f64> {
        self.counts.iter().find(|count| count.name == name).map(|count| f64::from(count.median))
    }

    /// Instructions of each peer relative to each of [`OURS`], for the same work.
    fn ratios(&self) -> Vec<(&'static str, Vec<f64>)> {
        let ours: Vec<f64> = OURS.iter().filter_map(|name| self.median(name)).collect();
        let over_ours = |median: f64| ours.iter().map(|own| median / own).collect();
        PEERS.iter().filter_map(|name| Some((*name, over_ours(self.median(name)?)))).collect()
    }

    /// Counts of slices by name and kind, over the flights; the median is that of the flight with most
    /// of them.
    fn slices_of_all_flights(&self) -> Vec<SliceCount> {
        let mut all: Vec<SliceCount> = Vec::new();
        let mut flights: Vec<&SliceCount> = self.slices.iter().collect();
        flights.sort_by_key(|slice| std::cmp::Reverse(slice.slices));
        for s in flights {
            match all.iter_mut().find(|a| a.name == s.name && a.kind == s.kind) {
                Some(a) => (a.slices, a.worst) = (a.slices + s.slices, a.worst.max(s.worst)),
                None => all.push(s.clone()),
            }
        }
        all.sort_by(|a, b| (a.name.len(), &a.name).cmp(&(b.name.len(), &b.name)));
        all
    }

    /// Counts by name and outcome, summed over the flights.
    fn outcomes_of_all_flights(&self) -> Vec<OutcomeCount> {
        let mut all: Vec<OutcomeCount> = Vec::new();
        for o in &self.outcomes {
            let is_it = |a: &&mut OutcomeCount| a.name == o.name && a.outcome == o.outcome;
            match all.iter_mut().find(is_it) {
                Some(a) => {
                    (a.steps, a.worst) = (a.steps + o.steps, a.worst.max(o.worst));
                }
                None => all.push(o.clone()),
            }
        }
        all
    }
}

impl Checked {
    /// True if the figure is present and within its limit.
    pub fn is_kept(&self) -> bool {
        self.measured.is_some_and(|measured| measured <= self.budget.held)
    }
}

/// Largest figure of a budget over all flights.
fn measured(budget: &Budget, counts: &[Count], slices: &[SliceCount]) -> Option<f64> {
    let counts = counts.iter().filter(|count| count.name == budget.name);
    match budget.figure {
        Figure::WorstStep => counts.map(|count| f64::from(count.worst)).reduce(f64::max),
        Figure::Spread => counts.map(Count::spread).reduce(f64::max),
        Figure::WorstSlice => {
            let slices = slices.iter().filter(|slice| slice.name == budget.name);
            slices.map(|slice| f64::from(slice.worst)).reduce(f64::max)
        }
    }
}

impl Count {
    /// Ratio of the most expensive step to the median step.
    pub fn spread(&self) -> f64 {
        f64::from(self.worst) / f64::from(self.median)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(lines: &[&str]) -> Result<Table> {
        Table::of(&lines.iter().map(|line| line.to_string()).collect::<Vec<_>>())
    }

    fn checked(table: &Table, name: &str, figure: Figure) -> Checked {
        let is_it = |j: &&Checked| j.budget.name == name && j.budget.figure == figure;
        table.checked.iter().find(is_it).unwrap().clone()
    }

    const LONG: &str =
        "count name=joint-ekf flight=long steps=9 worst=5000 at=3 median=4000 status=a";
    const SHORT: &str =
        "count name=joint-ekf flight=short steps=5 worst=4000 at=1 median=2000 status=a";

    #[test]
    fn worst_flight_is_compared_with_the_budget() {
        let table = table(&["about to count", LONG, SHORT]).unwrap();
        assert_eq!(table.counts.len(), 2);
        let worst = checked(&table, "joint-ekf", Figure::WorstStep);
        assert_eq!(worst.measured, Some(5000.0));
        assert!(worst.is_kept());
        let spread = checked(&table, "joint-ekf", Figure::Spread);
        assert_eq!(spread.measured, Some(2.0));
        assert!(!spread.is_kept());
        assert!(table.exceeded().contains(&&spread));
    }

    #[test]
    fn budget_without_a_figure_is_not_kept() {
        let table = table(&[LONG]).unwrap();
        assert!(!checked(&table, "ekf-sgf-rls", Figure::WorstStep).is_kept());
    }

    #[test]
    fn line_without_a_figure_is_an_error() {
        assert!(table(&["count name=joint-ekf flight=long steps=9 worst=5000"]).is_err());
        assert!(table(&["count name=a flight=b steps=x worst=1 at=1 median=1 status=a"]).is_err());
    }
}
