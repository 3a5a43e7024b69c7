//! Health: nominal, degraded or lost, with hysteresis, from the verdicts of the other monitors.
//!
//! Input: the [`Outcome`] of each sample, and the [`Estimate`] at the rate of telemetry. Output: [`Health`], and the
//! [`Driver`] of its last change for the worse. It has no limit of its own on a measured quantity: each row is the
//! verdict of the monitor named.
//!
//! | evidence | health | driver | verdict of |
//! |---|---|---|---|
//! | 3 or more of the last 32 samples refused | degraded | `gate` or `prediction` | [`gate`](crate::gate); [`spikes`](super::spikes), [`outliers`](super::outliers), attitude |
//! | all of the last 32 samples refused | lost | the same | the same |
//! | gap in time, change of the clock | degraded | `gap` | [`gate`](crate::gate) |
//! | lock-out, interruption, change: data contradict the estimate, wheels against momentum included | degraded | `contradiction` | [`shift`](super::shift), chi-square tests of the estimators |
//! | residuals not white against the known noise | degraded | `residuals` | [`whiteness`](super::whiteness) |
//! | no longer converged after it was | degraded | `excitation` | [`observability`](super::observability) |
//! | speed of a wheel against its command | degraded | `wheel` | the flight software, [`HealthMonitor::note_wheels`] |
//! | status `diverged` | lost | `model` | [`innovation`](super::innovation), fits |
//! | state or covariance not finite, covariance not positive | lost | `numbers` | the estimators, [`is_covariance`] |
//!
//! Evidence of an estimate, other than its numbers, counts once all estimates over [`HYSTERESIS`] samples have some: in the
//! middle of a fit, `window` reports for a second what the next pass refutes. It holds until an estimate without evidence.
//!
//! A worse level begins with its evidence. A better one needs [`HYSTERESIS`] samples in a row without evidence of the
//! present one. Nominal is therefore left at most once in 32 samples, and any 32 samples in a row have at most three
//! changes: for the better, to degraded, to lost.
//!
//! Before the first convergence, or after a change of the inertia, an estimate that is not converged is no evidence: the
//! status says so.

use crate::estimate::{Estimate, Status};
use crate::math::{Entries, Mat, scalar::Real};
use crate::outcome::{Coasting, Outcome, Reset};

/// Samples without evidence before a better level: 3 s at 10 Hz. The number of bits of the record of refusals.
pub const HYSTERESIS: u32 = u32::BITS;

/// Refused samples of the last 32 that are evidence. White noise has one in 10⁴ samples refused at most
/// (limits of four sigmas and more): three in 32 by chance once in 10⁸ samples. A share of 10 % that lasts is found.
const REFUSED: u32 = 3;

/// Usability of an estimator's service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Health {
    /// No evidence against data, model or numbers.
    #[default]
    Nominal,
    /// The estimate holds, but data or model are in doubt, or part of the data is missing.
    Degraded,
    /// The estimate is not usable.
    Lost,
}

/// Evidence that caused a change for the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Driver {
    /// Samples refused by the gate, or without a usable attitude.
    Gate,
    /// Samples too far from the prediction.
    Prediction,
    /// Gap in time, or change of the clock.
    Gap,
    /// Data that contradict the estimate.
    Contradiction,
    /// Residuals that are not white noise.
    Residuals,
    /// Directions no longer observed, or a tensor of no rigid body.
    Excitation,
    /// A wheel whose speed does not follow its command.
    Wheel,
    /// Residuals that the model does not explain.
    Model,
    /// Numbers that are not finite, or a covariance that is not positive.
    Numbers,
}

impl Health {
    /// Name in logs and telemetry.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Degraded => "degraded",
            Self::Lost => "lost",
        }
    }
}

impl Driver {
    /// Name in logs and telemetry.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gate => "gate",
            Self::Prediction => "prediction",
            Self::Gap => "gap",
            Self::Contradiction => "contradiction",
            Self::Residuals => "residuals",
            Self::Excitation => "excitation",
            Self::Wheel => "wheel",
            Self::Model => "model",
            Self::Numbers => "numbers",
        }
    }

    /// Level of one item of this evidence. Refused samples that last are worse.
    fn level(self) -> Health {
        match self {
            Self::Model | Self::Numbers => Health::Lost,
            _ => Health::Degraded,
        }
    }
}

/// Health of one estimator, in some twenty bytes.
///
/// ```
/// use fsw_core::monitor::health::{Driver, HYSTERESIS, Health, HealthMonitor};
/// use fsw_core::{Coasting, Outcome};
///
/// let mut monitor = HealthMonitor::default();
/// for _ in 0..3 {
///     assert_eq!(monitor.health(), Health::Nominal);
///     monitor.step(&Outcome::Coasting(Coasting::Spike));
/// }
/// assert_eq!((monitor.health(), monitor.driver()), (Health::Degraded, Some(Driver::Prediction)));
/// // With the thirtieth sample fewer than three of the last 32 are refused: the first one of the hysteresis.
/// for _ in 0..29 + HYSTERESIS {
///     assert_eq!(monitor.health(), Health::Degraded);
///     monitor.step(&Outcome::Updated);
/// }
/// assert_eq!(monitor.health(), Health::Nominal);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HealthMonitor {
    health: Health,
    driver: Option<Driver>,
    /// Refused samples of the last 32, the newest as the lowest bit.
    refused: u32,
    /// Verdict on the last refused sample.
    refusal: Option<Driver>,
    /// Evidence of the last estimate, once it counts.
    of_estimate: Option<Driver>,
    /// Samples since the first estimate of a series with evidence, up to 255; none without.
    suspect: Option<u8>,
    /// A wheel does not follow its command.
    is_wheel_wrong: bool,
    /// Samples in a row without evidence of the present level, up to [`HYSTERESIS`].
    clean: u8,
    has_converged: bool,
}

impl HealthMonitor {
    /// Adds the outcome of a sample.
    #[inline(never)] // one copy in an image
    pub fn step(&mut self, outcome: &Outcome) {
        let event = self.event(outcome);
        self.suspect = self.suspect.map(|samples| samples.saturating_add(1));
        let refusal = match outcome {
            Outcome::Coasting(Coasting::Rejected(_) | Coasting::NoAttitude(_)) => {
                Some(Driver::Gate)
            }
            Outcome::Coasting(Coasting::Spike) => Some(Driver::Prediction),
            _ => None,
        };
        self.refused = self.refused << 1 | u32::from(refusal.is_some());
        self.refusal = refusal.or(self.refusal);
        let of_refusals = match self.refused.count_ones() {
            u32::BITS => self.refusal.map(|driver| (Health::Lost, driver)),
            REFUSED.. => self.refusal.map(|driver| (Health::Degraded, driver)),
            _ => None,
        };
        let wheel = self.is_wheel_wrong.then_some(Driver::Wheel);
        let others = [event, self.of_estimate, wheel];
        let others = others.into_iter().flatten().map(|driver| (driver.level(), driver));
        // The first of the worst.
        let mut worst: Option<(Health, Driver)> = None;
        for evidence in others.chain(of_refusals) {
            if worst.is_none_or(|(health, _)| evidence.0 > health) {
                worst = Some(evidence);
            }
        }
        self.judge(worst);
    }

    /// Adds the estimate after the last sample: at the rate of telemetry, since it costs more than a step.
    pub fn estimate<T: Real>(&mut self, estimate: &Estimate<T>) {
        let is_converged = estimate.status == Status::Converged;
        self.has_converged |= is_converged;
        if !is_covariance(&estimate.covariance_kg2_m4) {
            (self.suspect, self.of_estimate) = (None, Some(Driver::Numbers));
            return;
        }
        let evidence = if estimate.status == Status::Diverged {
            Some(Driver::Model)
        } else if estimate.residuals_white == Some(false) {
            Some(Driver::Residuals)
        } else if self.has_converged && !is_converged {
            Some(Driver::Excitation)
        } else {
            None
        };
        self.suspect = evidence.and(self.suspect.or(Some(0)));
        let counts = self.suspect.is_some_and(|samples| u32::from(samples) >= HYSTERESIS);
        self.of_estimate = evidence.filter(|_| counts);
    }

    /// Notes the result of a check of the wheels against their commands, true if one does not follow it: for flight
    /// software that knows the commands.
    pub fn note_wheels(&mut self, is_wrong: bool) {
        self.is_wheel_wrong = is_wrong;
    }

    /// Present health.
    pub fn health(&self) -> Health {
        self.health
    }

    /// Evidence of the last change for the worse; `None` before the first.
    pub fn driver(&self) -> Option<Driver> {
        self.driver
    }

    /// Evidence of the outcome itself.
    fn event(&mut self, outcome: &Outcome) -> Option<Driver> {
        let Outcome::Reset(why) = outcome else { return None };
        if matches!(why, Reset::Changed | Reset::Diverged) {
            // The earlier estimate is discarded: convergence begins again.
            self.has_converged = false;
            (self.suspect, self.of_estimate) = (None, None);
        }
        match why {
            Reset::FirstSample | Reset::Aligned => None,
            Reset::Gap | Reset::Clock => Some(Driver::Gap),
            Reset::Lockout | Reset::Interrupted | Reset::Changed => Some(Driver::Contradiction),
            Reset::Diverged => Some(Driver::Numbers),
        }
    }

    /// Changes the level: at once for the worse, after the hysteresis for the better.
    fn judge(&mut self, worst: Option<(Health, Driver)>) {
        let level = worst.map_or(Health::Nominal, |(health, _)| health);
        if level >= self.health {
            self.clean = 0;
        } else {
            self.clean = self.clean.saturating_add(1);
        }
        let is_better = level < self.health && u32::from(self.clean) >= HYSTERESIS;
        if level > self.health || is_better {
            self.health = level;
            self.driver = worst.map_or(self.driver, |(_, driver)| Some(driver));
            self.clean = 0;
        }
    }
}

/// True for a finite covariance whose variances and minors of two rows are not negative, to the rounding of `f32` over
/// six elements: necessary for a positive covariance, and what a filter that loses it violates first.
pub fn is_covariance<T: Real>(covariance: &Mat<T, 6, 6>) -> bool {
    let slack = T::lit(1.0 + 1e-4);
    let is_minor_positive = |i: usize, k: usize| {
        let (a, b, c) = (covariance.at(i, i), covariance.at(k, k), covariance.at(i, k));
        // Without squares, which may leave the range of the type; false for NaN.
        a >= T::zero() && b >= T::zero() && c.abs() <= a.sqrt() * b.sqrt() * slack
    };
    covariance.iter().all(|element| element.is_finite())
        && (0..6).all(|i| (i..6).all(|k| is_minor_positive(i, k)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::NoAttitude;
    use crate::gate::Rejection;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    const SPIKE: Outcome = Outcome::Coasting(Coasting::Spike);
    const STUCK: Outcome = Outcome::Coasting(Coasting::Rejected(Rejection::Stuck));

    fn of_status(status: Status) -> Estimate<f32> {
        Estimate { status, ..Estimate::nothing() }
    }

    /// The level after each of these outcomes.
    fn run(monitor: &mut HealthMonitor, outcome: Outcome, samples: u32) -> Health {
        (0..samples).for_each(|_| monitor.step(&outcome));
        monitor.health()
    }

    #[test]
    fn refused_samples_degrade_and_their_run_loses() {
        let mut monitor = HealthMonitor::default();
        assert_eq!(run(&mut monitor, STUCK, 2), Health::Nominal);
        assert_eq!(run(&mut monitor, Outcome::Updated, 31), Health::Nominal);
        assert_eq!(run(&mut monitor, STUCK, 3), Health::Degraded);
        assert_eq!(run(&mut monitor, STUCK, 28), Health::Degraded);
        assert_eq!(run(&mut monitor, STUCK, 1), Health::Lost);
        assert_eq!(monitor.driver(), Some(Driver::Gate));
        // A usable sample ends the run: degraded after the hysteresis, then nominal.
        assert_eq!(run(&mut monitor, Outcome::Updated, 31), Health::Lost);
        assert_eq!(run(&mut monitor, Outcome::Updated, 1), Health::Nominal);
    }

    #[test]
    fn each_reset_is_evidence_but_those_of_a_start() {
        for (why, health) in [
            (Reset::FirstSample, Health::Nominal),
            (Reset::Aligned, Health::Nominal),
            (Reset::Gap, Health::Degraded),
            (Reset::Clock, Health::Degraded),
            (Reset::Lockout, Health::Degraded),
            (Reset::Interrupted, Health::Degraded),
            (Reset::Changed, Health::Degraded),
            (Reset::Diverged, Health::Lost),
        ] {
            let mut monitor = HealthMonitor::default();
            assert_eq!(run(&mut monitor, Outcome::Reset(why), 1), health, "{why:?}");
            assert_eq!(run(&mut monitor, Outcome::Updated, HYSTERESIS - 1), health, "{why:?}");
            assert_eq!(run(&mut monitor, Outcome::Updated, 1), Health::Nominal, "{why:?}");
        }
    }

    #[test]
    fn estimates_are_evidence_once_they_last() {
        let converged = of_status(Status::Converged);
        let mut indefinite = converged;
        indefinite.covariance_kg2_m4[(0, 1)] = 2.0 * indefinite.covariance_kg2_m4[(0, 0)];
        for (estimate, health, driver) in [
            (of_status(Status::Diverged), Health::Lost, Driver::Model),
            (indefinite, Health::Lost, Driver::Numbers),
            (
                Estimate { residuals_white: Some(false), ..converged },
                Health::Degraded,
                Driver::Residuals,
            ),
            (of_status(Status::Partial), Health::Degraded, Driver::Excitation),
        ] {
            let mut monitor = HealthMonitor::default();
            monitor.estimate(&of_status(Status::Partial));
            assert_eq!(
                run(&mut monitor, Outcome::Updated, 1),
                Health::Nominal,
                "not converged yet"
            );
            // A series shorter than the hysteresis is none; numbers that are not valid count at once.
            let at_once = if driver == Driver::Numbers { health } else { Health::Nominal };
            monitor.estimate(&converged);
            monitor.estimate(&estimate);
            assert_eq!(run(&mut monitor, Outcome::Updated, HYSTERESIS - 1), at_once);
            monitor.estimate(&converged);
            assert_eq!(run(&mut monitor, Outcome::Updated, HYSTERESIS), Health::Nominal);
            monitor.estimate(&estimate);
            run(&mut monitor, Outcome::Updated, HYSTERESIS);
            monitor.estimate(&estimate);
            assert_eq!(run(&mut monitor, Outcome::Updated, 100), health);
            assert_eq!(monitor.driver(), Some(driver));
            monitor.estimate(&converged);
            assert_eq!(run(&mut monitor, Outcome::Updated, HYSTERESIS), Health::Nominal);
            assert_eq!(monitor.driver(), Some(driver), "kept");
        }
    }

    #[test]
    fn convergence_begins_again_after_a_change() {
        let mut monitor = HealthMonitor::default();
        monitor.estimate(&of_status(Status::Converged));
        monitor.step(&Outcome::Reset(Reset::Changed));
        monitor.estimate(&of_status(Status::Partial));
        assert_eq!(run(&mut monitor, Outcome::Updated, HYSTERESIS), Health::Nominal);
    }

    #[test]
    fn wheel_is_evidence_while_it_is_noted() {
        let mut monitor = HealthMonitor::default();
        monitor.note_wheels(true);
        assert_eq!(run(&mut monitor, Outcome::Updated, 50), Health::Degraded);
        assert_eq!(monitor.driver(), Some(Driver::Wheel));
        monitor.note_wheels(false);
        assert_eq!(run(&mut monitor, Outcome::Updated, HYSTERESIS), Health::Nominal);
    }

    /// Any outcome, any verdict on an estimate, any note.
    fn any_input() -> impl Strategy<Value = (Outcome, Option<(Status, Option<bool>)>, bool)> {
        let outcomes = [
            Outcome::Updated,
            SPIKE,
            STUCK,
            Outcome::Coasting(Coasting::Aligning),
            Outcome::Reset(Reset::FirstSample),
            Outcome::Reset(Reset::Gap),
            Outcome::Reset(Reset::Lockout),
            Outcome::Reset(Reset::Changed),
            Outcome::Reset(Reset::Diverged),
        ];
        // Mostly quiet, so that levels improve too.
        let outcome = prop_oneof![
            9 => Just(Outcome::Updated),
            1 => prop::sample::select(outcomes.to_vec()),
        ];
        let statuses = [Status::Converged, Status::Partial, Status::Unobservable, Status::Diverged];
        let status = prop_oneof![
            4 => Just(Status::Converged),
            1 => prop::sample::select(statuses.to_vec()),
        ];
        let white = prop_oneof![4 => Just(Some(true)), 1 => any::<Option<bool>>()];
        let estimate = prop_oneof![6 => Just(None), 1 => (status, white).prop_map(Some)];
        (outcome, estimate, prop::bool::weighted(0.02))
    }

    proptest! {
        /// Levels worsen with evidence alone, improve after 32 samples alone, and have a driver.
        #[test]
        fn any_sequence_keeps_the_hysteresis(inputs in prop::collection::vec(any_input(), 1..1500)) {
            let mut monitor = HealthMonitor::default();
            let (mut last, mut changed_at, mut left_nominal_at) = (Health::Nominal, None, None);
            for (k, (outcome, estimate, is_wrong)) in inputs.into_iter().enumerate() {
                if let Some((status, residuals_white)) = estimate {
                    monitor.estimate(&Estimate { residuals_white, ..of_status(status) });
                }
                monitor.note_wheels(is_wrong);
                monitor.step(&outcome);
                let health = monitor.health();
                prop_assert_eq!(monitor.driver().is_some(), left_nominal_at.is_some() || health > last);
                let hysteresis = HYSTERESIS as usize;
                if health < last {
                    prop_assert!(changed_at.is_some_and(|at| k >= at + hysteresis), "at {}", k);
                }
                if last == Health::Nominal && health > last {
                    prop_assert!(left_nominal_at.is_none_or(|at| k > at + hysteresis), "at {}", k);
                    left_nominal_at = Some(k);
                }
                if health != last {
                    changed_at = Some(k);
                }
                last = health;
            }
        }
    }

    #[test]
    fn refusals_name_their_verdict() {
        let no_attitude = Outcome::Coasting(Coasting::NoAttitude(NoAttitude::Missing));
        for (outcome, driver) in
            [(SPIKE, Driver::Prediction), (STUCK, Driver::Gate), (no_attitude, Driver::Gate)]
        {
            let mut monitor = HealthMonitor::default();
            assert_eq!(run(&mut monitor, outcome, 3), Health::Degraded);
            assert_eq!(monitor.driver(), Some(driver));
        }
    }

    /// Of two items of evidence the worse one counts; further evidence of the present level leaves the driver.
    #[test]
    fn driver_is_that_of_the_last_change_for_the_worse() {
        let mut monitor = HealthMonitor::default();
        monitor.note_wheels(true);
        assert_eq!(run(&mut monitor, Outcome::Updated, 1), Health::Degraded);
        assert_eq!(run(&mut monitor, Outcome::Reset(Reset::Gap), 1), Health::Degraded);
        assert_eq!(monitor.driver(), Some(Driver::Wheel));
        assert_eq!(run(&mut monitor, STUCK, HYSTERESIS), Health::Lost);
        assert_eq!(monitor.driver(), Some(Driver::Gate));
        // Of two items of one level the outcome itself counts.
        let mut monitor = HealthMonitor::default();
        monitor.note_wheels(true);
        assert_eq!(run(&mut monitor, Outcome::Reset(Reset::Gap), 1), Health::Degraded);
        assert_eq!(monitor.driver(), Some(Driver::Gap));
    }

    #[test]
    fn names_are_distinct() {
        use Driver::*;
        let drivers =
            [Gate, Prediction, Gap, Contradiction, Residuals, Excitation, Wheel, Model, Numbers];
        let levels = [Health::Nominal, Health::Degraded, Health::Lost];
        let names = drivers.iter().map(Driver::name).chain(levels.iter().map(Health::name));
        assert_eq!(names.collect::<BTreeSet<_>>().len(), drivers.len() + levels.len());
    }

    /// Full correlation is one, and a tenth more is none, whatever the size.
    #[test]
    fn covariance_is_judged_alike_at_any_size() {
        for variance in [1e-30f32, 1e-6, 1.0, 1e30] {
            let correlated = |rho: f32| {
                let mut covariance = Mat::<f32, 6, 6>::identity() * variance;
                (covariance[(4, 2)], covariance[(2, 4)]) = (rho * variance, rho * variance);
                is_covariance(&covariance)
            };
            assert!(correlated(1.0) && correlated(-1.0), "{variance}");
            assert!(!correlated(1.1) && !correlated(-1.1), "{variance}");
        }
    }
}
