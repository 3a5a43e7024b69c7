//! Document of `design`: a designed manoeuvre, its accuracy, and standard manoeuvres within the same limits.

use serde::Serialize;

use crate::input::Scenario;
use crate::manoeuvre::{
    Accuracy, Criterion, Design, LimitKind, Manoeuvre, Request, TradeRow, Treatment,
};

/// Result of `design`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignReport {
    /// Name of the scenario or craft.
    pub scenario: String,
    /// Duration, s.
    pub duration_s: f64,
    /// Criterion: `a`, `d` or `e`.
    pub optimality: &'static str,
    /// Errors of the hardware: `considered` or `solved`.
    pub hardware: &'static str,
    /// Seed.
    pub seed: u64,
    /// Expected inertia, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// One sigma of the prior, kg m². Null if the inertia is known.
    pub sigma_before_kg_m2: Option<[f64; 6]>,
    /// One sigma after the manoeuvre, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// Part of it without considered errors of the hardware, kg m².
    pub sigma_random_kg_m2: [f64; 6],
    /// One sigma of the direction of each principal axis, ascending moments, before, deg. Null above 90.
    pub axes_before_deg: [Option<f64>; 3],
    /// The same after the manoeuvre.
    pub axes_deg: [Option<f64>; 3],
    /// Time at which each further direction has a sigma below a tenth of the mean moment, s.
    pub observed_s: [Option<f64>; 6],
    /// Sigma of the best standard manoeuvre over that of the design.
    pub gain: f64,
    /// Standard manoeuvres within the same limits, best first.
    pub fixed: Vec<FixedRow>,
    /// Cosines of the best frequency.
    pub tuned: Option<FixedRow>,
    /// Limits: their use and their share in what limits the design, largest first.
    pub limits: Vec<LimitRow>,
    /// Largest body rate within two sigma of the prior, rad/s.
    pub peak_rate_rad_s: f64,
    /// Largest body rate at the end within two sigma of the prior, rad/s: with thrusters of second order in the excursion.
    pub end_rate_rad_s: f64,
    /// Time between the rows of the torque table, s.
    pub step_s: f64,
    /// Torque of each motor on its wheel, N m, one row a step.
    pub torque_n_m: Vec<Vec<f64>>,
    /// Time between the knots of the spline, s.
    pub knot_s: f64,
    /// Number of times that the pattern of the spline is flown.
    pub repeats: usize,
    /// Coefficients of the cubic B-splines of each wheel, N m; the support of the first begins at the start.
    pub coefficients_n_m: Vec<Vec<f64>>,
    /// Pulses of each thruster: times on and off, s.
    pub thruster_on_s: Vec<Vec<[f64; 2]>>,
}

/// Result of `design --trade`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TradeReport {
    /// Name of the scenario or craft.
    pub scenario: String,
    /// Quantity: `excursion`, deg; `duration`, s; `noise`, rad/s.
    pub quantity: &'static str,
    /// One row a value.
    pub rows: Vec<TradeRow>,
}

/// A standard manoeuvre.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FixedRow {
    /// Name.
    pub name: String,
    /// Its sigma over that of the design.
    pub sigma_over_design: f64,
}

/// A kind of limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitRow {
    /// Name.
    pub limit: &'static str,
    /// Share of the limit that is used, at the inertia of the prior where most is used.
    pub used: f64,
    /// Share in what limits the design.
    pub share: f64,
}

impl DesignReport {
    /// Report of a design.
    pub fn new(
        scenario: &Scenario,
        request: &Request,
        design: &Design,
        accuracy: &Accuracy,
    ) -> Self {
        let fixed = |fixed: &Manoeuvre| FixedRow {
            name: fixed.name.clone(),
            sigma_over_design: design.gain_over(fixed),
        };
        let degrees = |axes: [Option<f64>; 3]| axes.map(|axis| axis.map(f64::to_degrees));
        Self {
            scenario: scenario.name.clone(),
            duration_s: request.duration_s,
            optimality: match request.criterion {
                Criterion::A => "a",
                Criterion::D => "d",
                Criterion::E => "e",
            },
            hardware: match request.treatment {
                Treatment::Considered => "considered",
                Treatment::Solved => "solved",
            },
            seed: request.seed,
            inertia_kg_m2: accuracy.inertia_kg_m2,
            sigma_before_kg_m2: accuracy.before_kg_m2,
            sigma_kg_m2: accuracy.after_kg_m2,
            sigma_random_kg_m2: accuracy.random_kg_m2,
            axes_before_deg: degrees(accuracy.axes_before_rad),
            axes_deg: degrees(accuracy.axes_after_rad),
            observed_s: accuracy.observed_s,
            gain: design.gain(),
            fixed: design.fixed.iter().map(fixed).collect(),
            tuned: design.tuned.as_ref().map(fixed),
            limits: limits(design),
            peak_rate_rad_s: design.best.peak_rate_rad_s,
            end_rate_rad_s: design.best.end_rate_rad_s,
            step_s: design.best.table.step_s,
            torque_n_m: design.best.table.torque_n_m.clone(),
            knot_s: design.knot_s,
            repeats: design.repeats,
            coefficients_n_m: design.coefficients_n_m.clone(),
            thruster_on_s: design.best.table.thruster_pulses_s(scenario),
        }
    }
}

fn limits(design: &Design) -> Vec<LimitRow> {
    let used = |wanted: LimitKind| {
        let found = design.best.usage.iter().find(|(kind, _)| *kind == wanted);
        found.and_then(|(_, used)| *used)
    };
    let row = |(kind, share): &(LimitKind, f64)| {
        Some(LimitRow { limit: kind.name(), used: used(*kind)?, share: *share })
    };
    design.limiting.iter().filter_map(row).collect()
}
