//! The bench image in QEMU: what each step costs, as a table beside its budgets.

use crate::budgets::{self, Budget, Bytes, Figure};
use crate::cycles::{Cycles, Trace};
use crate::{firmware, image, qemu};
use anyhow::{Context, Result, bail, ensure};
use std::fmt;
use std::time::Duration;

/// What the bench counts of our covariance, and of what others do of the same work.
const OURS: [&str; 2] = ["covariance-ud", "covariance-ud-walk"];
const PEERS: [&str; 4] = ["dense-nalgebra", "adskalman", "adskalman-joseph", "minikalman"];

/// 168 MHz.
const CYCLES_PER_US: f64 = 168.0;

/// Instructions that are counted with a step, and are none of it.
const AROUND_A_STEP: u32 = 50;

/// All flights take seconds in QEMU; a busy machine may take far longer.
const LIMIT: Duration = Duration::from_secs(600);

/// What was counted under one name on one flight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Count {
    /// What was stepped.
    pub name: String,
    /// Which flight.
    pub flight: String,
    /// How many steps.
    pub steps: u32,
    /// Instructions of the most expensive step.
    pub worst: u32,
    /// Which one that was, from 0.
    pub at: u32,
    /// Instructions of the median step.
    pub median: u32,
    /// Status of the estimate at the end of the flight.
    pub status: String,
}

/// The steps of one outcome within a [`Count`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutcomeCount {
    /// What was stepped.
    pub name: String,
    /// Which flight.
    pub flight: String,
    /// What became of the samples.
    pub outcome: String,
    /// How many steps.
    pub steps: u32,
    /// Instructions of the most expensive one.
    pub worst: u32,
}

/// A budget with what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The limit.
    pub budget: Budget,
    /// The largest over all flights; none if the bench hasn't counted it.
    pub measured: Option<f64>,
}

/// Cycles of the steps of the flight that was traced.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CyclesOf {
    /// What was stepped.
    pub name: String,
    /// Of the median step.
    pub median: Cycles,
    /// Of the most expensive one.
    pub worst: Cycles,
}

/// Flash of an image, with what it may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flash {
    /// Which image.
    pub name: String,
    /// The limit.
    pub limit: Bytes,
    /// What it takes.
    pub bytes: u64,
}

/// All that the bench counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One for each name and flight, in the bench's order.
    pub counts: Vec<Count>,
    /// The same by outcome.
    pub outcomes: Vec<OutcomeCount>,
    /// One for each budget.
    pub judged: Vec<Judged>,
    /// Estimated, of one flight.
    pub cycles: Vec<CyclesOf>,
    /// Of the flight images.
    pub flash: Vec<Flash>,
}

/// Builds the image, runs it in QEMU and reads its log.
pub fn run() -> Result<Table> {
    let elf = firmware::build_of("fsw-bench", "bench", &[])?;
    let run = qemu::run_counting(&elf, qemu::MACHINE, LIMIT, |_| {})?;
    if !run.success {
        bail!("the bench reported a failure: {}", run.lines.join("\n"));
    }
    Ok(Table { cycles: cycles()?, flash: flash()?, ..Table::of(&run.lines)? })
}

/// The steps of one flight, traced.
fn cycles() -> Result<Vec<CyclesOf>> {
    let elf = firmware::build_of("fsw-bench", "bench", &["--features", "one-flight"])?;
    let mut trace = Trace::new(image::functions(&elf, &["step_fast", "step_covariance"])?);
    let run = qemu::run_tracing(&elf, qemu::MACHINE, LIMIT, &mut trace)?;
    let mut calls = trace.calls.into_iter();
    // The log says what was stepped, in its order, and how often.
    let of_count = |count: Count| {
        let mut steps: Vec<_> = calls.by_ref().take(count.steps as usize).collect();
        let traced = steps.iter().map(|step| step.instructions).max().unwrap_or_default();
        // What is counted is a little more than the function: its call, by way of a wrapper.
        let is_whole = steps.len() == count.steps as usize
            && (count.worst.saturating_sub(AROUND_A_STEP)..=count.worst).contains(&traced);
        ensure!(is_whole, "{}: {traced} traced of {} instructions", count.name, count.worst);
        steps.sort_by_key(|step| step.of_refill[1]);
        let median = steps.get(steps.len() / 2).copied().unwrap_or_default();
        let worst = steps.last().copied().unwrap_or_default();
        Ok(CyclesOf { name: count.name, median, worst })
    };
    let counts = Table::of(&run.lines)?.counts;
    counts.into_iter().map(of_count).collect()
}

/// Of the flight image, and of those with one estimator. The one with all comes last, so that it is
/// what is left in the target folder.
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
        let judged = budgets::INSTRUCTIONS
            .iter()
            .map(|budget| Judged { budget: *budget, measured: measured(budget, &counts) })
            .collect();
        Ok(Self { counts, outcomes, judged, cycles: Vec::new(), flash: Vec::new() })
    }

    /// Whether every figure is there and within its limit.
    pub fn is_kept(&self) -> bool {
        self.exceeded().is_empty() && self.flash.iter().all(|f| f.bytes <= f.limit.held)
    }

    /// The budgets of instructions that are exceeded, or whose figure is missing.
    pub fn exceeded(&self) -> Vec<&Judged> {
        self.judged.iter().filter(|judged| !judged.is_kept()).collect()
    }

    /// The median step of what is counted once.
    fn median(&self, name: &str) -> Option<f64> {
        self.counts.iter().find(|count| count.name == name).map(|count| f64::from(count.median))
    }

    /// How many times our instructions each of the others takes for the same work, over each of ours.
    fn ratios(&self) -> Vec<(&'static str, Vec<f64>)> {
        let ours: Vec<f64> = OURS.iter().filter_map(|name| self.median(name)).collect();
        let over_ours = |median: f64| ours.iter().map(|own| median / own).collect();
        PEERS.iter().filter_map(|name| Some((*name, over_ours(self.median(name)?)))).collect()
    }

    /// All steps of a name and an outcome together.
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

impl Judged {
    /// Whether it was measured and is within the limit.
    pub fn is_kept(&self) -> bool {
        self.measured.is_some_and(|measured| measured <= self.budget.held)
    }
}

fn measured(budget: &Budget, counts: &[Count]) -> Option<f64> {
    counts
        .iter()
        .filter(|count| count.name == budget.name)
        .map(|count| match budget.figure {
            Figure::WorstStep => f64::from(count.worst),
            Figure::Spread => count.spread(),
        })
        .reduce(f64::max)
}

impl Count {
    /// The most expensive step over the median one.
    pub fn spread(&self) -> f64 {
        f64::from(self.worst) / f64::from(self.median)
    }
}

/// A line `KIND key=value key=value …`.
#[derive(Clone, Copy)]
struct Words<'a>(&'a str);

impl<'a> Words<'a> {
    /// If it is of this kind.
    fn of(line: &'a str, kind: &str) -> Option<Self> {
        line.strip_prefix(kind)?.strip_prefix(' ').map(Self)
    }

    fn value(self, key: &str) -> Result<&'a str> {
        self.0
            .split_whitespace()
            .find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
            .with_context(|| format!("no {key} in {:?}", self.0))
    }

    fn number(self, key: &str) -> Result<u32> {
        self.value(key)?.parse().with_context(|| format!("{key} is no number in {:?}", self.0))
    }

    fn count(self) -> Result<Count> {
        Ok(Count {
            name: self.value("name")?.into(),
            flight: self.value("flight")?.into(),
            steps: self.number("steps")?,
            worst: self.number("worst")?,
            at: self.number("at")?,
            median: self.number("median")?,
            status: self.value("status")?.into(),
        })
    }

    fn outcome(self) -> Result<OutcomeCount> {
        Ok(OutcomeCount {
            name: self.value("name")?.into(),
            flight: self.value("flight")?.into(),
            outcome: self.value("outcome")?.into(),
            steps: self.number("steps")?,
            worst: self.number("worst")?,
        })
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "instructions a step, Cortex-M4F, f32, counted in QEMU")?;
        writeln!(
            f,
            "{:<24}{:<12}{:>8}{:>10}{:>10}{:>8}{:>10}  ends",
            "", "flight", "steps", "median", "worst", "at", "spread"
        )?;
        for c in &self.counts {
            let spread = c.spread();
            writeln!(
                f,
                "{:<24}{:<12}{:>8}{:>10}{:>10}{:>8}{spread:>10.2}  {}",
                c.name, c.flight, c.steps, c.median, c.worst, c.at, c.status
            )?;
        }
        writeln!(f, "\n{:<24}{:<20}{:>8}{:>10}", "by outcome, all flights", "", "steps", "worst")?;
        for o in self.outcomes_of_all_flights() {
            writeln!(f, "{:<24}{:<20}{:>8}{:>10}", o.name, o.outcome, o.steps, o.worst)?;
        }
        writeln!(f, "\n{:<24}{:>20}{:>20}", "times our instructions", OURS[0], OURS[1])?;
        for (name, ratios) in self.ratios() {
            let ratios: String = ratios.iter().map(|ratio| format!("{ratio:>20.1}")).collect();
            writeln!(f, "{name:<24}{ratios}")?;
        }
        writeln!(f, "\ncycles a step, estimated (see target_tools::cycles), and at 168 MHz")?;
        writeln!(
            f,
            "{:<24}{:>10}{:>10}{:>10}{:>10}{:>16}{:>10}",
            "", "median", "µs", "worst", "µs", "range", "of all, µs"
        )?;
        for cycles in &self.cycles {
            let of_all = self.counts.iter().filter(|count| count.name == cycles.name);
            let most = of_all.map(|count| count.worst).max().unwrap_or_default();
            let each = f64::from(cycles.worst.of_refill[1]) / f64::from(cycles.worst.instructions);
            let [least, worst, largest] = cycles.worst.of_refill;
            let median = cycles.median.of_refill[1];
            writeln!(
                f,
                "{:<24}{median:>10}{:>10.1}{worst:>10}{:>10.1}{:>16}{:>10.1}",
                cycles.name,
                f64::from(median) / CYCLES_PER_US,
                f64::from(worst) / CYCLES_PER_US,
                format!("{least}-{largest}"),
                each * f64::from(most) / CYCLES_PER_US,
            )?;
        }
        writeln!(f, "\n{:<24}{:<12}{:>10}{:>10}", "budget", "", "measured", "at most")?;
        for judged in &self.judged {
            writeln!(f, "{judged}")?;
        }
        for flash in &self.flash {
            writeln!(f, "{flash}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Judged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (figure, digits) = match self.budget.figure {
            Figure::WorstStep => ("worst step", 0),
            Figure::Spread => ("spread", 2),
        };
        let measured = self.measured.map_or("none".into(), |value| format!("{value:.digits$}"));
        let at_most = self.budget.at_most;
        let is_reached = self.measured.is_some_and(|measured| measured <= self.budget.at_most);
        let verdict = verdict(is_reached, self.is_kept());
        let name = self.budget.name;
        write!(f, "{name:<24}{figure:<12}{measured:>10}{at_most:>10.digits$}{verdict}")
    }
}

impl fmt::Display for Flash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, limit, bytes } = self;
        let verdict = verdict(*bytes <= limit.at_most, *bytes <= limit.held);
        write!(f, "{name:<24}{:<12}{bytes:>10}{:>10}{verdict}", "flash", limit.at_most)
    }
}

/// What to say beside a figure.
fn verdict(is_reached: bool, is_held: bool) -> &'static str {
    match (is_reached, is_held) {
        (true, _) => "",
        (false, true) => "  not reached, held",
        (false, false) => "  EXCEEDED",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(lines: &[&str]) -> Result<Table> {
        Table::of(&lines.iter().map(|line| line.to_string()).collect::<Vec<_>>())
    }

    fn judged(table: &Table, name: &str, figure: Figure) -> Judged {
        let is_it = |j: &&Judged| j.budget.name == name && j.budget.figure == figure;
        table.judged.iter().find(is_it).unwrap().clone()
    }

    const LONG: &str =
        "count name=joint-ekf flight=long steps=9 worst=5000 at=3 median=4000 status=a";
    const SHORT: &str =
        "count name=joint-ekf flight=short steps=5 worst=4000 at=1 median=2000 status=a";

    #[test]
    fn the_worst_flight_counts() {
        let table = table(&["about to count", LONG, SHORT]).unwrap();
        assert_eq!(table.counts.len(), 2);
        let worst = judged(&table, "joint-ekf", Figure::WorstStep);
        assert_eq!(worst.measured, Some(5000.0));
        assert!(worst.is_kept());
        let spread = judged(&table, "joint-ekf", Figure::Spread);
        assert_eq!(spread.measured, Some(2.0));
        assert!(!spread.is_kept());
        assert!(table.exceeded().contains(&&spread));
    }

    #[test]
    fn what_is_not_counted_is_not_kept() {
        let table = table(&[LONG]).unwrap();
        assert!(!judged(&table, "ekf-sgf-rls", Figure::WorstStep).is_kept());
    }

    #[test]
    fn a_line_that_lacks_a_figure_is_an_error() {
        assert!(table(&["count name=joint-ekf flight=long steps=9 worst=5000"]).is_err());
        assert!(table(&["count name=a flight=b steps=x worst=1 at=1 median=1 status=a"]).is_err());
    }
}
