//! Reports assembled from the results of estimation, a simulated flight and its bound.

use std::collections::BTreeMap;

use fsw_core::monitor::health::{Driver, Health};
use fsw_core::{Innovation, Outcome, Status as CoreStatus};

use super::history::{AccelerationRow, HistoryRow};
use super::json::{
    CrlbReport, EffectRow, HardwareResult, HealthChange, ReplayReport, RunReport, Spikes, Status,
    matrix,
};
use crate::campaign::Reference;
use crate::estimation::{
    self, AnyEstimator, EstimationResult, HealthHistory, Method, largest_systematic,
};
use crate::input::Scenario;
use crate::input::log::LogRow;
use crate::truth::{Bound, Effect, Flight, TorqueEffect};

impl HistoryRow {
    /// State of the estimator after one row of the log.
    pub fn new(row: &LogRow, outcome: &Outcome, estimator: &dyn AnyEstimator) -> Self {
        let estimate = estimator.estimate();
        let mut history = Self {
            time_s: row.time_us as f64 * 1e-6,
            measured_rate_rad_s: row.rate_rad_s.into(),
            estimated_rate_rad_s: estimator.rate_rad_s().into(),
            rate_sigma_rad_s: estimator.rate_sigma_rad_s().map(Into::into),
            acceleration: estimator
                .acceleration()
                .map(|a| AccelerationRow { rad_s2: a.rad_s2.into(), delay_s: a.delay_s }),
            innovation_rad_s: None,
            innovation_sigma_rad_s: None,
            nis: None,
            inertia_kg_m2: estimate.inertia.elements_kg_m2(),
            sigma_kg_m2: estimate.sigma_kg_m2(),
            outcome: outcome.name(),
        };
        history.set_innovation(estimator.innovation());
        history
    }

    /// Sets innovation, its sigma and its NIS.
    pub fn set_innovation(&mut self, innovation: Option<Innovation<f64>>) {
        self.innovation_rad_s = innovation.map(|i| i.rate_rad_s.into());
        self.innovation_sigma_rad_s = innovation.map(|i| i.variance_rad2_s2.map(f64::sqrt).into());
        self.nis = innovation.map(|i| i.nis());
    }
}

impl ReplayReport {
    /// Report of a log of this many samples.
    pub fn new(method: Method, samples: usize, result: &EstimationResult) -> Self {
        let EstimationResult { counts, events, estimate, hardware } = result;
        let elements = estimate.inertia.elements_kg_m2();
        let (over_trace, over_trace_sigma) = estimate.over_trace();
        let rejected = counts.rejected().into_iter().filter(|(_, count)| *count > 0);
        Self {
            estimator: method.estimator.to_string(),
            precision: method.precision.to_string(),
            samples: samples as u64,
            accepted: u64::from(counts.accepted),
            rejected: rejected.map(|(name, count)| (name.to_owned(), u64::from(count))).collect(),
            status: estimate.status.into(),
            inertia_kg_m2: matrix(&elements),
            sigma_kg_m2: estimate.sigma_kg_m2(),
            sigma_random_kg_m2: estimate.sigma_random_kg_m2.unwrap_or(estimate.sigma_kg_m2()),
            sigma_systematic_kg_m2: estimate.sigma_systematic_kg_m2(),
            largest_systematic: largest_systematic(hardware).map(str::to_owned),
            hardware: hardware.iter().map(HardwareResult::from).collect(),
            covariance_kg2_m4: estimate.covariance_kg2_m4.into(),
            observed_directions: usize::from(estimate.observed.directions),
            element_observed: estimate.observed.element,
            scale_observed: estimate.observed.scale,
            inertia_over_trace: matrix(&over_trace),
            inertia_over_trace_sigma: over_trace_sigma,
            physical: estimate.inertia.check().is_ok(),
            disturbance_torque_n_m: estimate.disturbance_torque_n_m.map(Into::into),
            gyro_bias_rad_s: estimate.gyro_bias_rad_s.map(Into::into),
            residual_rms_rad_s: estimate.residual_rms_rad_s,
            residuals_white: estimate.residuals_white,
            projected: estimate.projected,
            restarts: seconds(&events.restarts_us),
            gaps: seconds(&events.gaps_us),
            interruptions: seconds(&events.interruptions_us),
            changes: seconds(&events.changes_us),
            spikes: Spikes {
                count: events.spikes_us.len() as u64,
                first_s: seconds(&events.spikes_us[..events.spikes_us.len().min(Spikes::LISTED)]),
            },
            health: Health::Nominal.name().to_owned(),
            health_driver: None,
            health_changes: Vec::new(),
            explanations: Vec::new(),
            skipped_rows: BTreeMap::new(),
            notes: Vec::new(),
        }
    }
}

impl ReplayReport {
    /// The same with the health over the log.
    pub fn with_health(self, health: &HealthHistory) -> Self {
        let driver = |driver: Option<Driver>| driver.map(|driver| driver.name().to_owned());
        let change = |change: &estimation::HealthChange| HealthChange {
            t_s: change.time_us as f64 / 1e6,
            health: change.health.name().to_owned(),
            driver: driver(change.driver),
        };
        Self {
            health: health.health().name().to_owned(),
            health_driver: driver(health.driver()),
            health_changes: health.changes().iter().map(change).collect(),
            ..self
        }
    }
}

fn seconds(times_us: &[u64]) -> Vec<f64> {
    times_us.iter().map(|time_us| *time_us as f64 / 1e6).collect()
}

impl RunReport {
    /// Estimate of a simulated flight compared with its truth and bound.
    pub fn of_flight(
        scenario: &Scenario,
        seed: u64,
        flight: &Flight,
        estimate: ReplayReport,
    ) -> Self {
        let reference = Reference {
            truth_kg_m2: scenario.final_inertia_kg_m2(),
            bound_kg_m2: flight.bound.sigma_kg_m2,
            joint_bound_kg_m2: flight.bound.joint_kg_m2(),
        };
        Self::new(&scenario.name, seed, estimate, &reference)
    }
}

impl CrlbReport {
    /// Bound of a scenario, and the effect of a constant torque.
    pub fn of_bound(scenario: &Scenario, bound: &Bound, torque: Option<&TorqueEffect>) -> Self {
        let report = Self::new(
            &scenario.name,
            bound.unknowns.names().into_iter().map(str::to_owned).collect(),
            scenario.final_inertia_kg_m2(),
            bound.sigma_kg_m2,
            bound.observed_directions,
        );
        let report = report.of_hardware(bound);
        match torque {
            Some(modelled) if scenario.solve_for.torque => {
                report.with_torque(None, modelled.together_n_m)
            }
            Some(unmodelled) => {
                let error = unmodelled.inertia_error_kg_m2_per_n_m;
                report.with_torque(Some(error), unmodelled.alone_n_m)
            }
            None => report,
        }
    }

    /// Adds the bounds with the stated errors of the hardware, if there are any.
    fn of_hardware(self, bound: &Bound) -> Self {
        let Some(hardware) = &bound.hardware else { return self };
        let effect = |effect: &Effect| EffectRow {
            name: effect.name.clone(),
            sigma: effect.sigma,
            unit: effect.unit.to_owned(),
            inertia_kg_m2: effect.inertia_kg_m2,
            posterior_over_prior: effect.posterior_over_prior,
        };
        let effects = hardware.effects.iter().map(effect).collect();
        self.with_hardware(hardware.considered_kg_m2, hardware.solved_kg_m2, effects)
    }
}

impl From<Status> for CoreStatus {
    fn from(status: Status) -> Self {
        match status {
            Status::Converged => Self::Converged,
            Status::Partial => Self::Partial,
            Status::Unobservable => Self::Unobservable,
            Status::Diverged => Self::Diverged,
        }
    }
}

impl From<CoreStatus> for Status {
    fn from(status: CoreStatus) -> Self {
        match status {
            CoreStatus::Converged => Self::Converged,
            CoreStatus::Partial => Self::Partial,
            CoreStatus::Unobservable => Self::Unobservable,
            CoreStatus::Diverged => Self::Diverged,
        }
    }
}
