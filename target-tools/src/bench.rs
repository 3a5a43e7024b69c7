//! The bench image in QEMU: what each step costs, as a table beside its budgets.

use crate::budgets::{self, Budget, Figure};
use crate::{firmware, qemu};
use anyhow::{Context, Result, bail};
use std::fmt;
use std::time::Duration;

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
}

/// A budget with what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The limit.
    pub budget: Budget,
    /// The largest over all flights; none if the bench hasn't counted it.
    pub measured: Option<f64>,
}

/// All that the bench counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One for each name and flight, in the bench's order.
    pub counts: Vec<Count>,
    /// One for each budget.
    pub judged: Vec<Judged>,
}

/// Builds the image, runs it in QEMU and reads its log. Each log line that isn't a count is given
/// to `on_line`.
pub fn run(mut on_line: impl FnMut(&str)) -> Result<Table> {
    let elf = firmware::build("bench")?;
    let run = qemu::run_counting(&elf, qemu::MACHINE, LIMIT, |line| {
        if !is_count(line) {
            on_line(line);
        }
    })?;
    if !run.success {
        bail!("the bench reported a failure: {}", run.lines.last().map_or("", String::as_str));
    }
    Table::of(&run.lines)
}

impl Table {
    /// From the lines of the bench's log.
    fn of(lines: &[String]) -> Result<Self> {
        let counts: Vec<Count> = lines
            .iter()
            .filter(|line| is_count(line))
            .map(|line| read(line))
            .collect::<Result<_>>()?;
        let judged = budgets::INSTRUCTIONS
            .iter()
            .map(|budget| Judged { budget: *budget, measured: measured(budget, &counts) })
            .collect();
        Ok(Self { counts, judged })
    }

    /// The budgets that are exceeded, or whose figure is missing.
    pub fn exceeded(&self) -> Vec<&Judged> {
        self.judged.iter().filter(|judged| !judged.is_kept()).collect()
    }
}

impl Judged {
    /// Whether it was measured and is within the limit.
    pub fn is_kept(&self) -> bool {
        self.measured.is_some_and(|measured| measured <= self.budget.at_most)
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

fn is_count(line: &str) -> bool {
    line.starts_with("count ")
}

/// Reads `count name=… flight=… steps=… worst=… at=… median=…`.
fn read(line: &str) -> Result<Count> {
    let value = |key: &str| {
        line.split_whitespace()
            .find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
            .with_context(|| format!("no {key} in {line:?}"))
    };
    let number = |key: &str| {
        value(key)?.parse::<u32>().with_context(|| format!("{key} is no number in {line:?}"))
    };
    Ok(Count {
        name: value("name")?.into(),
        flight: value("flight")?.into(),
        steps: number("steps")?,
        worst: number("worst")?,
        at: number("at")?,
        median: number("median")?,
    })
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "instructions a step, Cortex-M4F, f32, counted in QEMU")?;
        writeln!(
            f,
            "{:<24}{:<12}{:>8}{:>10}{:>10}{:>8}{:>10}",
            "", "flight", "steps", "median", "worst", "at", "spread"
        )?;
        for c in &self.counts {
            let spread = c.spread();
            writeln!(
                f,
                "{:<24}{:<12}{:>8}{:>10}{:>10}{:>8}{spread:>10.2}",
                c.name, c.flight, c.steps, c.median, c.worst, c.at
            )?;
        }
        writeln!(f, "\n{:<24}{:<12}{:>10}{:>10}", "budget", "", "measured", "at most")?;
        for judged in &self.judged {
            writeln!(f, "{judged}")?;
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
        let verdict = if self.is_kept() { "" } else { "  EXCEEDED" };
        let name = self.budget.name;
        write!(f, "{name:<24}{figure:<12}{measured:>10}{at_most:>10.digits$}{verdict}")
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

    const LONG: &str = "count name=joint-ekf flight=long steps=9 worst=5000 at=3 median=4000";
    const SHORT: &str = "count name=joint-ekf flight=short steps=5 worst=4000 at=1 median=2000";

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
        assert!(table(&["count name=a flight=b steps=x worst=1 at=1 median=1"]).is_err());
    }
}
