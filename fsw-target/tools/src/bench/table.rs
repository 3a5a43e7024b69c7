//! Printed table of the bench: counts, comparison with the peers, cycles, budgets.

use super::{CYCLES_PER_US, Checked, CyclesOf, Flash, OURS, Table};
use crate::budgets::Figure;
use std::fmt;

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_counts(f)?;
        self.write_slices(f)?;
        self.write_work(f)?;
        self.write_outcomes(f)?;
        self.write_ratios(f)?;
        self.write_cycles(f)?;
        writeln!(f, "\n{:<24}{:<12}{:>10}{:>10}", "budget", "", "measured", "at most")?;
        for checked in &self.checked {
            writeln!(f, "{checked}")?;
        }
        for flash in &self.flash {
            writeln!(f, "{flash}")?;
        }
        Ok(())
    }
}

impl Table {
    fn write_counts(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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
        Ok(())
    }

    fn write_slices(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{:<24}{:<20}{:>8}{:>10}{:>10}",
            "slices of work", "", "number", "median", "worst"
        )?;
        for s in self.slices_of_all_flights() {
            writeln!(
                f,
                "{:<24}{:<20}{:>8}{:>10}{:>10}",
                s.name, s.kind, s.slices, s.median, s.worst
            )?;
        }
        Ok(())
    }

    /// Delay of a fit over all blocks, in samples and at three sample rates.
    fn write_work(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{:<24}{:<12}{:>8}{:>10}{:>10}{:>10}{:>10}",
            "samples with work left",
            "flight",
            "number",
            "longest",
            "1 Hz, s",
            "10 Hz, s",
            "100 Hz, s"
        )?;
        for w in &self.work {
            let [one, ten, hundred] = [1.0, 10.0, 100.0].map(|hz| f64::from(w.longest) / hz);
            writeln!(
                f,
                "{:<24}{:<12}{:>8}{:>10}{one:>10.0}{ten:>10.1}{hundred:>10.2}",
                w.name, w.flight, w.busy, w.longest
            )?;
        }
        Ok(())
    }

    fn write_outcomes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n{:<24}{:<20}{:>8}{:>10}", "by outcome, all flights", "", "steps", "worst")?;
        for o in self.outcomes_of_all_flights() {
            writeln!(f, "{:<24}{:<20}{:>8}{:>10}", o.name, o.outcome, o.steps, o.worst)?;
        }
        Ok(())
    }

    fn write_ratios(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n{:<24}{:>20}{:>20}", "times our instructions", OURS[0], OURS[1])?;
        for (name, ratios) in self.ratios() {
            let ratios: String = ratios.iter().map(|ratio| format!("{ratio:>20.1}")).collect();
            writeln!(f, "{name:<24}{ratios}")?;
        }
        Ok(())
    }

    fn write_cycles(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\ncycles a step, estimated (see target_tools::cycles), and at 168 MHz")?;
        writeln!(
            f,
            "{:<24}{:>10}{:>10}{:>10}{:>10}{:>16}{:>10}",
            "", "median", "µs", "worst", "µs", "range", "of all, µs"
        )?;
        self.cycles.iter().try_for_each(|cycles| self.write_cycles_of(f, cycles))
    }

    /// One row. The last column scales the worst step of all flights by the cycles per instruction
    /// of the traced one.
    fn write_cycles_of(&self, f: &mut fmt::Formatter<'_>, cycles: &CyclesOf) -> fmt::Result {
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
        )
    }
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (figure, digits) = match self.budget.figure {
            Figure::WorstStep => ("worst step", 0),
            Figure::Spread => ("spread", 2),
            Figure::WorstSlice => ("worst slice", 0),
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

/// Remark beside a figure.
fn verdict(is_reached: bool, is_held: bool) -> &'static str {
    match (is_reached, is_held) {
        (true, _) => "",
        (false, true) => "  not reached, held",
        (false, false) => "  EXCEEDED",
    }
}
