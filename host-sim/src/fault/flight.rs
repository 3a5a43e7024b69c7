//! One flight with a fault, judged from its first sample to its last and compared with the clean flight
//! of the same seed.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use fsw_core::monitor::health::{Health, HealthMonitor};
use fsw_core::{Coasting, Estimate, Outcome, Reset, Status};

use super::{Computer, Timed};
use crate::campaign::{Reference, Score};
use crate::estimation::{AnyEstimator, SetUpError, Setup};
use crate::input::Scenario;
use crate::input::scenario::Fault;

/// Time between two judgements of the estimate, µs.
const CHECK_US: u64 = 1_000_000;
/// Time after the end of a fault that counts as its transient, µs: a minute.
pub const TRANSIENT_US: u64 = 60_000_000;

/// The estimate at one time of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Check {
    status: Status,
    is_not_white: bool,
    is_within_sigmas: bool,
    nees: Option<f64>,
}

/// Record of one flight: estimates over time, events, final estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Estimates by time, in periods of [`CHECK_US`].
    checks: BTreeMap<u64, Check>,
    /// Times of rejected samples, spikes and resets, µs.
    events_us: Vec<u64>,
    /// Resets other than the start and the first estimate.
    resets: u32,
    /// Final estimate; none after a panic.
    last: Option<(Score, Check)>,
    /// Every number that the estimator reported was finite.
    is_finite: bool,
    /// Health after each sample, by its time, µs since the first sample.
    health: BTreeMap<u64, Health>,
    monitor: HealthMonitor,
    /// Time of the first converged estimate, µs.
    converged_us: Option<u64>,
}

/// Conditions of a flight.
pub struct Conditions<'a> {
    /// Set-up of the estimator.
    pub setup: &'a Setup<'a>,
    /// The scenario of the seed.
    pub scenario: &'a Scenario,
    /// Truth at the end, and bound.
    pub reference: &'a Reference,
    /// Seed.
    pub seed: u64,
}

impl Record {
    /// Flies the samples.
    ///
    /// # Errors
    /// See [`SetUpError`].
    pub fn fly(
        conditions: &Conditions<'_>,
        samples: &[Timed],
        faults: &[Fault],
    ) -> Result<Self, SetUpError> {
        let Conditions { setup, seed, .. } = *conditions;
        let mut estimator = Computer::with(setup, faults, seed)?;
        let mut record = Self {
            checks: BTreeMap::new(),
            events_us: Vec::new(),
            resets: 0,
            last: None,
            is_finite: true,
            health: BTreeMap::new(),
            monitor: HealthMonitor::default(),
            converged_us: None,
        };
        // A panic leaves the estimator and the last check unfinished; neither is used afterwards.
        let flown = catch_unwind(AssertUnwindSafe(|| {
            samples.iter().for_each(|sample| record.step(conditions, estimator.as_mut(), sample));
            estimator.finish();
            estimator.estimate()
        }));
        if let Ok(estimate) = flown {
            record.is_finite &= is_finite(&estimate);
            let score = conditions.reference.score(&estimate);
            let check = Check::new(&estimate, &score);
            record.last = Some((score, check));
        }
        Ok(record)
    }

    fn step(
        &mut self,
        conditions: &Conditions<'_>,
        estimator: &mut dyn AnyEstimator,
        sample: &Timed,
    ) {
        let outcome = estimator.step(&sample.row);
        match outcome {
            Outcome::Coasting(Coasting::Rejected(_) | Coasting::Spike) => {
                self.events_us.push(sample.elapsed_us);
            }
            Outcome::Reset(why) => {
                self.events_us.push(sample.elapsed_us);
                let is_start = matches!(why, Reset::FirstSample | Reset::Aligned);
                self.resets += u32::from(!is_start);
            }
            Outcome::Updated | Outcome::Coasting(_) => {}
        }
        self.monitor.step(&outcome);
        self.health.insert(sample.elapsed_us, self.monitor.health());
        self.is_finite &= estimator.rate_rad_s().iter().all(|rate| rate.is_finite());
        let due = sample.elapsed_us / CHECK_US;
        if self.checks.last_key_value().is_some_and(|(last, _)| *last >= due) {
            return;
        }
        let truth_kg_m2 = conditions.scenario.inertia_at_kg_m2(sample.elapsed_us as f64 * 1e-6);
        let estimate = estimator.estimate();
        self.is_finite &= is_finite(&estimate);
        self.monitor.estimate(&estimate);
        if estimate.status == Status::Converged {
            self.converged_us.get_or_insert(sample.elapsed_us);
        }
        let score = Reference { truth_kg_m2, ..*conditions.reference }.score(&estimate);
        self.checks.insert(due, Check::new(&estimate, &score));
    }

    /// The estimator panicked.
    pub fn panicked(&self) -> bool {
        self.last.is_none()
    }

    /// Every number that the estimator reported was finite.
    pub fn is_finite(&self) -> bool {
        self.is_finite
    }

    /// Score of the final estimate; none after a panic.
    pub fn score(&self) -> Option<&Score> {
        self.last.as_ref().map(|(score, _)| score)
    }

    /// The final estimate is converged, not called non-white, and beyond its sigmas.
    pub fn is_silent(&self) -> bool {
        self.last.as_ref().is_some_and(|(_, check)| check.is_silent())
    }

    /// A flight without fault that reports one: a reset, a status below an earlier one, or residuals that are not
    /// white.
    pub fn has_alarm(&self) -> bool {
        let mut best = rank(Status::Diverged);
        self.resets > 0
            || self.checks.values().any(|check| {
                best = best.min(rank(check.status));
                check.is_not_white || rank(check.status) > best
            })
    }
}

impl Record {
    /// Health at this time.
    fn health_at(&self, us: u64) -> Health {
        self.health.range(..=us).next_back().map_or(Health::Nominal, |(_, health)| *health)
    }

    /// True for a flight that is not nominal at some time after its first convergence.
    pub fn is_degraded(&self) -> bool {
        let after = self.converged_us.map(|from| self.health.range(from..));
        after.into_iter().flatten().any(|(_, health)| *health != Health::Nominal)
    }

    /// Time from `start_us` until the health is worse than that of the clean flight, s.
    fn degraded_s(&self, clean: &Self, start_us: u64) -> Option<f64> {
        let mut after = self.health.range(start_us..);
        let (us, _) = after.find(|(us, health)| **health > clean.health_at(**us))?;
        Some((us - start_us) as f64 * 1e-6)
    }

    /// Time from `end_us` until the health is that of the clean flight for good, s; none if it is not at the end.
    fn nominal_s(&self, clean: &Self, end_us: u64) -> Option<f64> {
        let is_worse = |us: u64, health: Health| health > clean.health_at(us);
        let worse = self.health.iter().rev().find(|(us, health)| is_worse(**us, **health));
        let (last, _) = self.health.last_key_value()?;
        match worse {
            Some((us, _)) if us == last => None,
            Some((us, _)) => Some(us.saturating_sub(end_us) as f64 * 1e-6),
            None => Some(0.0),
        }
    }

    /// Total time after `end_us` with a health that is worse than that of the clean flight, s.
    fn outage_s(&self, clean: &Self, end_us: u64) -> f64 {
        let (mut total_us, mut from_us) = (0, None);
        for (us, health) in self.health.range(end_us..) {
            total_us += from_us.map_or(0, |from: u64| us - from);
            // Until the next sample.
            from_us = (*health > clean.health_at(*us)).then_some(*us);
        }
        total_us as f64 * 1e-6
    }
}

impl Check {
    fn new(estimate: &Estimate<f64>, score: &Score) -> Self {
        Self {
            status: estimate.status,
            is_not_white: estimate.residuals_white == Some(false),
            is_within_sigmas: score.is_within_sigmas(),
            nees: score.nees,
        }
    }

    fn is_silent(&self) -> bool {
        self.status == Status::Converged && !self.is_not_white && !self.is_within_sigmas
    }

    /// Reports a fault that the clean flight does not report at this time.
    fn is_announced(&self, clean: &Self) -> bool {
        rank(self.status) > rank(clean.status) || (self.is_not_white && !clean.is_not_white)
    }
}

/// Comparison of a flight with its clean one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// The estimator panicked.
    pub panicked: bool,
    /// Every number that the estimator reported was finite.
    pub is_finite: bool,
    /// Time from the start of the fault to the first event or report that the clean flight does not
    /// have, s.
    pub detection_s: Option<f64>,
    /// Time from the start of the fault until the health is worse than that of the clean flight, s.
    pub degraded_s: Option<f64>,
    /// Time from the end of the fault until the health is that of the clean flight for good, s; none if it is not at
    /// the end.
    pub nominal_s: Option<f64>,
    /// Total time after the end of the fault with a health that is worse than that of the clean flight, s.
    pub outage_s: f64,
    /// The final estimate is a silent lie.
    pub is_silent: bool,
    /// Time from the start of the fault to the last silently wrong estimate in flight, s; zero without.
    pub wrong_s: f64,
    /// Time from the end of the fault until the estimate is as right as the clean one for good, s; none
    /// if it is not at the end.
    pub recovery_s: Option<f64>,
    /// Sum and number of NEES over six from the start of the fault to a minute after its end, of the
    /// estimates called converged.
    pub nees_during: [f64; 2],
    /// NEES over six of the final estimate.
    pub nees_after: Option<f64>,
    /// Sum of squares of final error over bound, and their number.
    pub over_bound: [f64; 2],
    /// Status of the final estimate.
    pub status: Option<Status>,
}

impl Judged {
    /// Judges the flight with a fault of this interval.
    pub fn new(record: &Record, clean: &Record, [start_us, end_us]: [u64; 2]) -> Self {
        let after = start_us / CHECK_US + 1;
        let (mut wrong_s, mut right_from) = (0.0, None);
        let mut nees_during = [0.0; 2];
        for (at, check) in record.checks.range(after..) {
            let Some(clean) = clean.checks.get(at) else { continue };
            let since_s = |from_us: u64| (at * CHECK_US) as f64 * 1e-6 - from_us as f64 * 1e-6;
            if check.is_silent() && !clean.is_silent() {
                wrong_s = since_s(start_us);
            }
            let is_right =
                !check.is_announced(clean) && (check.is_within_sigmas || !clean.is_within_sigmas);
            right_from =
                if is_right { right_from.or(Some(since_s(end_us).max(0.0))) } else { None };
            let is_transient = at * CHECK_US <= end_us + TRANSIENT_US;
            if let Some(nees) = check.nees.filter(|_| is_transient && is_converged(check)) {
                nees_during = [nees_during[0] + nees / 6.0, nees_during[1] + 1.0];
            }
        }
        let score = record.score();
        let ratios = score.iter().flat_map(|score| score.error_over_bound).flatten();
        Self {
            panicked: record.panicked(),
            is_finite: record.is_finite,
            detection_s: detection_s(record, clean, start_us),
            degraded_s: record.degraded_s(clean, start_us),
            nominal_s: record.nominal_s(clean, end_us),
            outage_s: record.outage_s(clean, end_us),
            is_silent: record.is_silent() && !clean.is_silent(),
            wrong_s,
            recovery_s: right_from.filter(|_| score.is_some()),
            nees_during,
            nees_after: score.and_then(|score| score.nees).map(|nees| nees / 6.0),
            over_bound: ratios.fold([0.0; 2], |[sum, n], ratio| [sum + ratio * ratio, n + 1.0]),
            status: score.map(|score| score.status),
        }
    }
}

fn is_converged(check: &Check) -> bool {
    check.status == Status::Converged
}

/// Time from the start to the first event or report that the clean flight does not have, s.
fn detection_s(record: &Record, clean: &Record, start_us: u64) -> Option<f64> {
    let is_new = |us: &&u64| **us >= start_us && !clean.events_us.contains(us);
    let event = record.events_us.iter().find(is_new).copied();
    let is_reported = |(at, check): &(&u64, &Check)| {
        clean.checks.get(at).is_some_and(|clean| check.is_announced(clean))
    };
    let after = start_us / CHECK_US + 1;
    let report = record.checks.range(after..).find(is_reported).map(|(at, _)| at * CHECK_US);
    let first_us = event.into_iter().chain(report).min()?;
    Some(first_us.saturating_sub(start_us) as f64 * 1e-6)
}

/// Order of the statuses: a larger one claims less.
fn rank(status: Status) -> u8 {
    match status {
        Status::Converged => 0,
        Status::Partial => 1,
        Status::Unobservable => 2,
        Status::Diverged => 3,
    }
}

fn is_finite(estimate: &Estimate<f64>) -> bool {
    let inertia = estimate.inertia.elements_kg_m2();
    inertia.iter().chain(estimate.covariance_kg2_m4.iter()).all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record with this health at each second.
    fn record(health: &[Health]) -> Record {
        Record {
            checks: BTreeMap::new(),
            events_us: Vec::new(),
            resets: 0,
            last: None,
            is_finite: true,
            health: (0..).map(|s| s * 1_000_000).zip(health.iter().copied()).collect(),
            monitor: HealthMonitor::default(),
            converged_us: None,
        }
    }

    /// Two intervals after the end of the fault, of which the clean flight has a second of its own.
    #[test]
    fn outage_is_the_time_of_a_worse_health_after_the_fault() {
        use Health::{Degraded as D, Lost as L, Nominal as N};
        let clean = record(&[N, N, N, N, D, N, N, N, N]);
        let flight = record(&[N, D, D, L, D, N, D, D, N]);
        assert_eq!(flight.outage_s(&clean, 2_000_000), 4.0);
        assert_eq!(flight.outage_s(&clean, 8_000_000), 0.0);
        assert_eq!(clean.outage_s(&clean, 0), 0.0);
        assert_eq!(flight.nominal_s(&clean, 2_000_000), Some(5.0));
    }
}
