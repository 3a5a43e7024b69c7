//! Figures of a campaign over its runs, and their comparison with the limits.

use fsw_core::Status;
use fsw_core::outcome::OutcomeCounts;

use super::campaign::{Campaign, Limits};
use super::run::Run;

/// Width of the allowance for scatter where fewer runs are flown than the limit is meant for, sigmas.
const SCATTER_SIGMAS: f64 = 3.5;

/// Figures over the runs of a campaign.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Number of runs.
    pub runs: usize,
    /// Number of runs that cannot be flown, with the first reason.
    pub failed: usize,
    /// Reason of the first of them.
    pub failure: Option<String>,
    /// Numbers of runs with status converged, partial, unobservable, diverged.
    pub status: [usize; 4],
    /// Number of runs with residuals called not white.
    pub not_white: usize,
    /// RMS error over bound of the converged runs, least and largest of the elements that have one.
    pub over_bound: Option<[f64; 2]>,
    /// Mean NEES per degree of freedom of the converged runs.
    pub nees: Option<f64>,
    /// Largest error over sigma of the runs that are converged and not called other than white.
    pub worst_sigmas: f64,
    /// Number of runs with an unannounced wrong estimate, or a claim against the check.
    pub silent: usize,
    /// Seed of the first of them.
    pub silent_seed: Option<u64>,
    /// RMS error over that of the reference.
    pub over_reference: Option<f64>,
    /// Number of runs with a visible fault, and of those that count it.
    pub visible: [usize; 2],
    /// Most samples of one run that are rejected as out of order.
    pub out_of_order: u32,
    /// Number of runs with a change, an interruption or a lockout.
    pub changed: usize,
    /// Longest time from the event to the last unannounced wrong estimate, s.
    pub wrong_s: f64,
    /// Longest time from the end of the event until the estimate is right for good, s.
    pub recovery_s: f64,
    /// Number of runs in which the two precisions disagree.
    pub disagree: usize,
    /// Sums of the counts.
    pub counts: OutcomeCounts,
}

/// Sums over the converged runs.
#[derive(Default)]
struct Sums {
    squares: [f64; 6],
    bounded: [usize; 6],
    nees: f64,
    nees_runs: usize,
    reference: [f64; 2],
}

impl Figures {
    /// Figures of these runs, summed in their order.
    pub fn of(runs: &[Result<Run, String>]) -> Self {
        let (mut figures, mut sums) =
            (Self { runs: runs.len(), ..Self::default() }, Sums::default());
        for run in runs {
            match run {
                Ok(run) => figures.add(run, &mut sums),
                Err(reason) => {
                    figures.failed += 1;
                    figures.failure.get_or_insert_with(|| reason.clone());
                }
            }
        }
        let rms: Vec<f64> = (0..6)
            .filter(|i| sums.bounded[*i] > 0)
            .map(|i| (sums.squares[i] / sums.bounded[i] as f64).sqrt())
            .collect();
        figures.over_bound = (!rms.is_empty()).then(|| {
            let least = rms.iter().copied().fold(f64::INFINITY, f64::min);
            [least, rms.iter().copied().fold(0.0, f64::max)]
        });
        figures.nees = (sums.nees_runs > 0).then(|| sums.nees / sums.nees_runs as f64 / 6.0);
        let [own, reference] = sums.reference;
        figures.over_reference = (reference > 0.0).then(|| (own / reference).sqrt());
        figures
    }

    fn add(&mut self, run: &Run, sums: &mut Sums) {
        self.status[index(run.score.status)] += 1;
        self.not_white += usize::from(run.white == Some(false));
        self.visible[0] += usize::from(run.is_visible);
        self.visible[1] += usize::from(run.is_visible && run.is_told());
        let c = &run.counts;
        let resets = c.change_resets + c.lockout_resets + c.interruption_resets;
        self.changed += usize::from(resets > 0);
        self.out_of_order = self.out_of_order.max(run.counts.out_of_order);
        self.disagree += usize::from(run.extra.disagrees);
        self.wrong_s = self.wrong_s.max(run.extra.wrong_s);
        self.recovery_s = self.recovery_s.max(run.extra.recovery_s);
        if run.extra.silent > 0 {
            self.silent += 1;
            self.silent_seed.get_or_insert(run.seed);
        }
        add_counts(&mut self.counts, &run.counts);
        sums.reference[0] += run.extra.squares[0];
        sums.reference[1] += run.extra.squares[1];
        if run.score.status != Status::Converged {
            return;
        }
        if run.white != Some(false) {
            self.worst_sigmas = self.worst_sigmas.max(run.worst_sigmas());
        }
        for i in 0..6 {
            if let Some(ratio) = run.score.error_over_bound[i] {
                sums.squares[i] += ratio * ratio;
                sums.bounded[i] += 1;
            }
        }
        if let Some(nees) = run.score.nees {
            sums.nees += nees;
            sums.nees_runs += 1;
        }
    }

    /// The limits that these figures miss, each in a few words.
    pub fn missed(&self, campaign: &Campaign) -> Vec<String> {
        let Limits { converged, found, diverged, over_bound, nees, .. } = campaign.limits;
        let share = |count: usize| count as f64 / self.runs.max(1) as f64;
        let scatter = self.scatter(campaign);
        let mut missed = self.missed_of_the_check(campaign);
        let mut check = |holds: bool, text: String| {
            if !holds {
                missed.push(text);
            }
        };
        check(self.failed == 0, format!("{} failed", self.failed));
        if let Some(least) = converged {
            check(share(self.status[0]) >= least, format!("converged < {least}"));
        }
        if let Some(least) = found {
            let holds = share(self.status[0] + self.status[1]) >= least;
            check(holds, format!("found < {least}"));
        }
        if let Some(most) = diverged {
            check(share(self.status[3]) <= most, format!("diverged > {most}"));
        }
        if let Some(most) = over_bound {
            let worst = self.over_bound.map_or(f64::INFINITY, |[_, worst]| worst);
            check(worst <= most * (1.0 + scatter), format!("RMS/bound > {most}"));
        }
        if let Some([least, most]) = nees {
            // The relative scatter of a NEES of six degrees of freedom is √(2/3) that of an RMS.
            let wide = scatter * (2.0f64 / 3.0).sqrt();
            let range = least - wide..=most + wide;
            let holds = self.nees.is_some_and(|nees| range.contains(&nees));
            check(holds, format!("NEES outside {least} to {most}"));
        }
        missed
    }

    /// Missed limits of comparison, fault and time.
    fn missed_of_the_check(&self, campaign: &Campaign) -> Vec<String> {
        let Limits { over_reference, told, out_of_order, changes, silent, .. } = campaign.limits;
        let Limits { wrong_s, recovery_s, .. } = campaign.limits;
        let share = |count: usize| count as f64 / self.runs.max(1) as f64;
        let mut missed = Vec::new();
        let mut check = |holds: bool, text: String| {
            if !holds {
                missed.push(text);
            }
        };
        check(share(self.silent) <= silent, format!("silent > {silent}"));
        check(self.disagree == 0, format!("{} disagree", self.disagree));
        if let Some(most) = over_reference {
            // None where the record determines no element.
            let ratio = self.over_reference.unwrap_or(0.0);
            let most_now = most * (1.0 + self.scatter(campaign));
            check(ratio <= most_now, format!("RMS/reference > {most}"));
        }
        let [visible, told_of_them] = self.visible;
        if let Some(least) = told {
            check(told_of_them as f64 >= least * visible as f64, format!("told < {least}"));
        }
        if let Some(most) = out_of_order {
            let found = self.out_of_order;
            check(found <= most, format!("{found} out of order > {most}"));
        }
        if let Some(most) = changes {
            check(share(self.changed) <= most, format!("changes > {most}"));
        }
        if let Some(most) = wrong_s {
            check(self.wrong_s <= most, format!("wrong for > {most} s"));
        }
        if let Some(most) = recovery_s {
            check(self.recovery_s <= most, format!("recovery > {most} s"));
        }
        missed
    }

    /// Allowance for the relative scatter of an RMS, `√(1/2n)`, beyond that of the number of runs for
    /// which the limit is meant.
    fn scatter(&self, campaign: &Campaign) -> f64 {
        let of = |runs: f64| (0.5 / runs.max(1.0)).sqrt();
        SCATTER_SIGMAS * (of(self.runs as f64) - of(campaign.runs as f64)).max(0.0)
    }
}

fn index(status: Status) -> usize {
    match status {
        Status::Converged => 0,
        Status::Partial => 1,
        Status::Unobservable => 2,
        Status::Diverged => 3,
    }
}

fn add_counts(sum: &mut OutcomeCounts, counts: &OutcomeCounts) {
    for (sum, count) in [
        (&mut sum.accepted, counts.accepted),
        (&mut sum.not_finite, counts.not_finite),
        (&mut sum.out_of_range, counts.out_of_range),
        (&mut sum.out_of_order, counts.out_of_order),
        (&mut sum.stuck, counts.stuck),
        (&mut sum.spike, counts.spike),
        (&mut sum.gap_resets, counts.gap_resets),
        (&mut sum.lockout_resets, counts.lockout_resets),
        (&mut sum.interruption_resets, counts.interruption_resets),
        (&mut sum.change_resets, counts.change_resets),
        (&mut sum.divergence_resets, counts.divergence_resets),
    ] {
        *sum = sum.saturating_add(count);
    }
}
