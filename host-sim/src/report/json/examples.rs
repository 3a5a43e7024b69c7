//! Reports for the tests of `report`.

use std::collections::BTreeMap;

use super::{
    CrlbReport, HardwareResult, McReport, ReplayReport, RunReport, Spikes, Status, matrix,
};
use crate::campaign::Reference;

pub const TRUTH: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];

pub fn replay() -> ReplayReport {
    let elements = [14.201_02, 17.297_8, 20.301_1, 0.087_22, 0.134_1, 0.601_5];
    let sigma_kg_m2 = [0.002_75, 0.002_5, 0.003_2, 0.001_1, 0.001_6, 0.000_86];
    let mut covariance_kg2_m4 = [[0.0; 6]; 6];
    for (i, sigma) in sigma_kg_m2.iter().enumerate() {
        covariance_kg2_m4[i][i] = sigma * sigma;
    }
    ReplayReport {
        estimator: "joint-ekf".to_owned(),
        precision: "f32".to_owned(),
        samples: 6001,
        accepted: 5998,
        rejected: BTreeMap::from([("spike".to_owned(), 2), ("stuck".to_owned(), 1)]),
        status: Status::Converged,
        inertia_kg_m2: matrix(&elements),
        sigma_kg_m2,
        sigma_random_kg_m2: sigma_kg_m2,
        sigma_systematic_kg_m2: [0.0; 6],
        largest_systematic: None,
        hardware: Vec::new(),
        covariance_kg2_m4,
        observed_directions: 6,
        element_observed: [true; 6],
        scale_observed: true,
        inertia_over_trace: matrix(&elements.map(|element| element / 51.8)),
        inertia_over_trace_sigma: sigma_kg_m2.map(|sigma| sigma / 51.8),
        physical: true,
        disturbance_torque_n_m: None,
        gyro_bias_rad_s: None,
        residual_rms_rad_s: 1.8151e-4,
        residuals_white: Some(true),
        projected: false,
        restarts: Vec::new(),
        gaps: Vec::new(),
        interruptions: Vec::new(),
        changes: Vec::new(),
        spikes: Spikes { count: 2, first_s: vec![12.3, 45.6] },
        health: "nominal".to_owned(),
        health_driver: None,
        health_changes: Vec::new(),
        explanations: Vec::new(),
        skipped_rows: BTreeMap::new(),
        notes: Vec::new(),
    }
}

/// The report with a tensor that the stated hardware limits: scale to 0.58 %.
pub fn with_hardware() -> ReplayReport {
    const SCALE: f64 = 0.0058;
    let mut report = replay();
    let elements = report.elements_kg_m2();
    report.sigma_systematic_kg_m2 = elements.map(|element| SCALE * element.abs());
    for i in 0..6 {
        let (random, systematic) = (report.sigma_random_kg_m2[i], report.sigma_systematic_kg_m2[i]);
        report.sigma_kg_m2[i] = random.hypot(systematic);
        for k in 0..6 {
            report.covariance_kg2_m4[i][k] += SCALE * SCALE * elements[i] * elements[k];
        }
    }
    let parameter = |name: &str, kind: &str, key: &str, unit: &str| HardwareResult {
        name: name.to_owned(),
        kind: kind.to_owned(),
        value: 0.001,
        sigma: 5e-5,
        stated: 0.1_f64.to_radians(),
        key: key.to_owned(),
        assumed: false,
        unit: unit.to_owned(),
        effect_kg_m2: [0.0, 1e-3, 0.0, 2e-3, 0.0, 0.0],
    };
    report.hardware = vec![
        parameter("gyro axes xy", "gyro axes", "gyro.axes_sigma_deg", "rad"),
        HardwareResult {
            value: 2e-4,
            sigma: 0.0099,
            stated: 0.01,
            effect_kg_m2: elements.map(|element| 0.005 * element),
            ..parameter(
                "wheel spin inertia 1",
                "wheel spin inertia",
                "wheel.spin_inertia_sigma",
                "",
            )
        },
        HardwareResult {
            value: 0.012,
            sigma: 3.1e-4,
            stated: 0.005,
            ..parameter("time offset", "time offset", "gyro.delay_sigma_s", "s")
        },
    ];
    let assumed = ["wheel.spin_inertia_sigma", "gyro.delay_sigma_s"];
    report.hardware.iter_mut().for_each(|parameter| parameter.mark_assumed(&assumed));
    report.largest_systematic = Some("wheel spin inertia".to_owned());
    report
}

pub fn run() -> RunReport {
    let bound_kg_m2 = [0.002_75, 0.002_49, 0.003_19, 0.001_12, 0.001_62, 0.000_854].map(Some);
    let reference = Reference { truth_kg_m2: TRUTH, bound_kg_m2, joint_bound_kg_m2: [None; 6] };
    RunReport::new("stsat3-spin-up", 7, replay(), &reference)
}

pub fn mc() -> McReport {
    let bound = [0.002_75, 0.002_49, 0.003_19, 0.001_12, 0.001_62, 0.000_854];
    McReport {
        scenario: "stsat3-spin-up".to_owned(),
        estimator: "joint-ekf".to_owned(),
        precision: "f32".to_owned(),
        seed: 100,
        runs: 50,
        used: 48,
        not_shown: 0,
        diverged: 2,
        not_converged: 1,
        changes: 3,
        residuals_not_white: 0,
        silent_lies: 0,
        truth_kg_m2: TRUTH,
        rmse_kg_m2: bound.map(|bound| Some(1.25 * bound)),
        bias_kg_m2: bound.map(|bound| Some(-0.1 * bound)),
        bound_kg_m2: bound.map(Some),
        joint_bound_kg_m2: [None; 6],
        rmse_over_joint_bound: [None; 6],
        rmse_over_bound: [Some(1.25); 6],
        rmse_over_bound_of_all: Some(1.25),
        bias_over_bound: [Some(-0.1); 6],
        sigma_kg_m2: bound.map(Some),
        sigma_random_kg_m2: bound.map(Some),
        sigma_systematic_kg_m2: [Some(0.0); 6],
        largest_systematic: None,
        nees_per_dof: Some(1.0923),
        nees_runs: 48,
        nees_95: Some([0.8881, 1.1187]),
        steps: 300_050,
        wall_s: Some(1.26),
        steps_per_s_per_core: Some(512_345.6),
    }
}

pub fn crlb() -> CrlbReport {
    let bound = [Some(0.002_75), Some(0.002_49), None, Some(0.001_12), None, Some(8.54e-9)];
    let unknowns = ["rate", "inertia"].map(str::to_owned).to_vec();
    let error = [-1350.0, 12.5, -0.2];
    let rows = [Some(error), Some(error), None, Some(error), None, Some([0.0; 3])];
    CrlbReport::new("stsat3-spin-up", unknowns, TRUTH, bound, 4)
        .with_torque(Some(rows), [Some(3.21e-7), Some(4.5e-5), None])
}
