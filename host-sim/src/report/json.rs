//! The JSON documents. People script against these: names and shapes are stable, and fields may
//! only be added.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::Matrix3;
use serde::Serialize;

/// What `replay` found in a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReplayReport {
    /// Name of the estimator, as `joint-ekf`.
    pub estimator: String,
    /// Arithmetic of the flight core: `f32` or `f64`.
    pub precision: String,
    /// Samples in the log.
    pub samples: u64,
    /// Samples that the estimate makes use of.
    pub accepted: u64,
    /// Samples refused, by reason. Reasons that didn't occur may be left out.
    pub rejected: BTreeMap<String, u64>,
    /// How far the estimate can be trusted.
    pub status: Status,
    /// The inertia tensor about the centre of mass, body axes, wheels locked and included, kg m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// One sigma of each element, kg m².
    pub sigma_kg_m2: [f64; 6],
    /// Covariance of the elements, kg² m⁴.
    pub covariance_kg2_m4: [[f64; 6]; 6],
    /// Directions of the six-dimensional space of tensors that the data has shown, 0 to 6.
    pub observed_directions: usize,
    /// Whether the data has shown each element.
    pub element_observed: [bool; 6],
    /// Whether the data has shown the tensor's size, rather than only its ratios.
    pub scale_observed: bool,
    /// The tensor divided by its trace.
    pub inertia_over_trace: [[f64; 3]; 3],
    /// One sigma of each element of that.
    pub inertia_over_trace_sigma: [f64; 6],
    /// Whether a rigid body can have this tensor.
    pub physical: bool,
    /// Constant disturbance torque, body axes, N m; null unless it was asked for.
    pub disturbance_torque_n_m: Option<[f64; 3]>,
    /// Gyro bias, body axes, rad/s; null unless it was asked for.
    pub gyro_bias_rad_s: Option<[f64; 3]>,
    /// RMS over samples and axes of measured minus estimated rate, rad/s.
    pub residual_rms_rad_s: f64,
    /// Whether the residuals look like white noise alone; null where that isn't tested.
    pub residuals_white: Option<bool>,
    /// Whether the tensor was brought to the nearest physical one.
    pub projected: bool,
    /// How often what was known before was dropped, since new data contradicted it.
    pub changes: u64,
}

/// How far an estimate can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// All of the tensor was seen, and the model explains the data.
    Converged,
    /// Some directions are unseen.
    Partial,
    /// Nothing of the tensor was seen.
    Unobservable,
    /// The model doesn't explain the data.
    Diverged,
}

/// What `run` found in a simulated flight, beside the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of the gyro noise.
    pub seed: u64,
    /// What `replay` would say of the flight's log.
    #[serde(flatten)]
    pub estimate: ReplayReport,
    /// The true elements at the end of the flight, kg m².
    pub truth_kg_m2: [f64; 6],
    /// Estimated minus true, in per cent of the true element; null where that is zero.
    pub error_percent: [Option<f64>; 6],
    /// Cramér-Rao bound of each element, one sigma, kg m²; null where it is not observed.
    pub bound_kg_m2: [Option<f64>; 6],
}

/// What the firmware estimated in QEMU, and whether the host came to the same.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PilReport {
    /// What `run` would say of it.
    #[serde(flatten)]
    pub run: RunReport,
    /// The comparison.
    pub target: TargetReport,
}

/// How firmware and host compare. There is none if they differ: that is an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetReport {
    /// Samples after which both knew the same to the last bit: all.
    pub identical_samples: u64,
    /// After so many samples the power was cut, and the firmware went on from its checkpoint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restarted_at: Option<usize>,
    /// The most of its stack that the processor has used, bytes.
    pub stack_high_water_bytes: u32,
    /// How long the flight took, s.
    pub wall_s: f64,
}

/// What many simulated flights come to that differ in gyro noise.
///
/// A run counts as diverged if its status says so, or if the error of any element isn't finite or is
/// beyond 20 of its bounds, whatever the status. Diverged runs are counted and left out of `rmse_*`,
/// `bias_*` and NEES. Where each run draws its own spacecraft, so are those whose motion doesn't show
/// all six elements.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct McReport {
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the estimator, as `joint-ekf`.
    pub estimator: String,
    /// Arithmetic of the flight core: `f32` or `f64`.
    pub precision: String,
    /// Seed of the first run; run `i` has this plus `i`.
    pub seed: u64,
    /// Runs that were completed: those asked for, or fewer after Ctrl-C.
    pub runs: u64,
    /// Runs that the figures are of: those neither diverged nor not shown.
    pub used: u64,
    /// Runs that drew a spacecraft whose motion leaves the bound of an element above a tenth of the mean
    /// moment.
    pub not_shown: u64,
    /// Runs that diverged: by their own word, or far from the truth and sure of it.
    pub diverged: u64,
    /// Runs that did not diverge, and say that they haven't converged or are far from the truth.
    pub not_converged: u64,
    /// Runs, of all, in which what was known before was dropped at least once, since new data
    /// contradicted it.
    pub changes: u64,
    /// Runs, of all, whose last residuals don't look like white noise; none where that isn't tested.
    pub residuals_not_white: u64,
    /// The true elements at the end of the flight, kg m²; their mean where runs have different ones.
    pub truth_kg_m2: [f64; 6],
    /// RMS of estimated minus true, kg m²; null if all runs diverged.
    pub rmse_kg_m2: [Option<f64>; 6],
    /// Mean of estimated minus true, kg m²; null if all runs diverged.
    pub bias_kg_m2: [Option<f64>; 6],
    /// Cramér-Rao bound of each element, one sigma, kg m²; null where it is not observed. The RMS of
    /// the bounds where runs have different ones.
    pub bound_kg_m2: [Option<f64>; 6],
    /// RMS of each run's error over its own bound; null where there is no bound.
    pub rmse_over_bound: [Option<f64>; 6],
    /// The same over all elements; null where any has no bound.
    pub rmse_over_bound_of_all: Option<f64>,
    /// Mean of each run's error over its own bound; null where there is no bound.
    pub bias_over_bound: [Option<f64>; 6],
    /// Mean normalised estimation error squared over its six degrees of freedom: 1 for an honest
    /// covariance, above for an overconfident one; null where no run has one.
    pub nees_per_dof: Option<f64>,
    /// Runs that this is the mean of: those used whose covariance is positive definite.
    pub nees_runs: u64,
    /// Low and high: where the mean of that many lies 95 % of the time for an honest covariance.
    pub nees_95: Option<[f64; 2]>,
    /// Samples given to the estimator, all runs together.
    pub steps: u64,
    /// Time that the runs took, s; truth and bound don't count unless each run has its own.
    pub wall_s: f64,
    /// Samples over the time spent in the estimator, summed over threads, 1/s.
    pub steps_per_s_per_core: Option<f64>,
}

/// How well any estimator could do on a scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrlbReport {
    /// Name of the scenario.
    pub scenario: String,
    /// What is taken to be unknown, by name.
    pub unknowns: Vec<String>,
    /// Cramér-Rao bound of each element, one sigma, kg m²; null where it is not observed.
    pub bound_kg_m2: [Option<f64>; 6],
    /// The same in per cent of the true element; null also where that is zero.
    pub bound_percent: [Option<f64>; 6],
    /// Directions of the six-dimensional space of tensors that the motion shows, 0 to 6.
    pub observed_directions: usize,
    /// Error of each element by a constant body torque about x, y and z that isn't modelled, to first
    /// order, kg m² per N m; null where the element is not observed, and altogether where the torque is
    /// among the unknowns.
    pub inertia_error_kg_m2_per_n_m: Option<[Option<[f64; 3]>; 6]>,
    /// One sigma with which a constant torque about each axis stands out of the residuals, N m, the
    /// unknowns adapting to it; null where they imitate it.
    pub torque_bound_n_m: [Option<f64>; 3],
}

impl ReplayReport {
    /// The elements of the tensor, kg m².
    pub fn elements_kg_m2(&self) -> [f64; 6] {
        elements(&self.inertia_kg_m2)
    }

    /// Principal moments, ascending, kg m².
    pub fn principal_moments_kg_m2(&self) -> [f64; 3] {
        let tensor = Matrix3::from(self.inertia_kg_m2);
        let mut moments: [f64; 3] = tensor.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        moments
    }

    /// Samples refused for whatever reason.
    pub fn rejected_total(&self) -> u64 {
        self.rejected.values().sum()
    }
}

impl RunReport {
    /// Sets an estimate beside the truth.
    pub fn new(
        scenario: &str,
        seed: u64,
        estimate: ReplayReport,
        truth_kg_m2: [f64; 6],
        bound_kg_m2: [Option<f64>; 6],
    ) -> Self {
        let found = estimate.elements_kg_m2();
        let error_percent =
            std::array::from_fn(|i| percent(found[i] - truth_kg_m2[i], truth_kg_m2[i]));
        let scenario = scenario.to_owned();
        Self { scenario, seed, estimate, truth_kg_m2, error_percent, bound_kg_m2 }
    }
}

impl CrlbReport {
    /// Sets a bound beside the truth.
    pub fn new(
        scenario: &str,
        unknowns: Vec<String>,
        truth_kg_m2: [f64; 6],
        bound_kg_m2: [Option<f64>; 6],
        observed_directions: usize,
    ) -> Self {
        Self {
            scenario: scenario.to_owned(),
            unknowns,
            bound_kg_m2,
            bound_percent: std::array::from_fn(|i| percent(bound_kg_m2[i]?, truth_kg_m2[i].abs())),
            observed_directions,
            inertia_error_kg_m2_per_n_m: None,
            torque_bound_n_m: [None; 3],
        }
    }

    /// Adds what a constant torque does.
    pub fn with_torque(
        self,
        inertia_error_kg_m2_per_n_m: Option<[Option<[f64; 3]>; 6]>,
        torque_bound_n_m: [Option<f64>; 3],
    ) -> Self {
        Self { inertia_error_kg_m2_per_n_m, torque_bound_n_m, ..self }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Converged => "converged",
            Self::Partial => "partial",
            Self::Unobservable => "unobservable",
            Self::Diverged => "diverged",
        })
    }
}

/// The symmetric matrix of six elements, row by row.
pub fn matrix(elements: &[f64; 6]) -> [[f64; 3]; 3] {
    let [xx, yy, zz, xy, xz, yz] = *elements;
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

/// The six elements of a symmetric matrix.
pub fn elements(matrix: &[[f64; 3]; 3]) -> [f64; 6] {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = *matrix;
    [xx, yy, zz, xy, xz, yz]
}

fn percent(part: f64, whole: f64) -> Option<f64> {
    (whole != 0.0).then(|| 100.0 * part / whole)
}

/// Reports that the tests of this folder share.
#[cfg(test)]
pub(super) mod examples {
    use super::*;

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
            changes: 0,
        }
    }

    pub fn run() -> RunReport {
        let bound = [0.002_75, 0.002_49, 0.003_19, 0.001_12, 0.001_62, 0.000_854].map(Some);
        RunReport::new("stsat3-spin-up", 7, replay(), TRUTH, bound)
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
            truth_kg_m2: TRUTH,
            rmse_kg_m2: bound.map(|bound| Some(1.25 * bound)),
            bias_kg_m2: bound.map(|bound| Some(-0.1 * bound)),
            bound_kg_m2: bound.map(Some),
            rmse_over_bound: [Some(1.25); 6],
            rmse_over_bound_of_all: Some(1.25),
            bias_over_bound: [Some(-0.1); 6],
            nees_per_dof: Some(1.0923),
            nees_runs: 48,
            nees_95: Some([0.8881, 1.1187]),
            steps: 300_050,
            wall_s: 1.26,
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
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn keys(document: &Value) -> Vec<&str> {
        let mut keys: Vec<&str> =
            document.as_object().unwrap().keys().map(String::as_str).collect();
        keys.sort_unstable();
        keys
    }

    const REPLAY_KEYS: [&str; 21] = [
        "accepted",
        "changes",
        "covariance_kg2_m4",
        "disturbance_torque_n_m",
        "element_observed",
        "estimator",
        "gyro_bias_rad_s",
        "inertia_kg_m2",
        "inertia_over_trace",
        "inertia_over_trace_sigma",
        "observed_directions",
        "physical",
        "precision",
        "projected",
        "rejected",
        "residual_rms_rad_s",
        "residuals_white",
        "samples",
        "scale_observed",
        "sigma_kg_m2",
        "status",
    ];

    #[test]
    fn replay_has_the_agreed_names_and_shapes() {
        let document = serde_json::to_value(examples::replay()).unwrap();
        assert_eq!(keys(&document), REPLAY_KEYS);
        assert_eq!(document["status"], "converged");
        assert_eq!(document["rejected"], json!({ "spike": 2, "stuck": 1 }));
        assert_eq!(document["inertia_kg_m2"][0][1], document["inertia_kg_m2"][1][0]);
        assert_eq!(document["inertia_kg_m2"][1][2], 0.6015);
        assert_eq!(document["covariance_kg2_m4"].as_array().unwrap().len(), 6);
        assert!(document["gyro_bias_rad_s"].is_null());
    }

    #[test]
    fn run_is_replay_and_the_truth_in_one_object() {
        let document = serde_json::to_value(examples::run()).unwrap();
        let mut expected = REPLAY_KEYS.to_vec();
        expected.extend(["bound_kg_m2", "error_percent", "scenario", "seed", "truth_kg_m2"]);
        expected.sort_unstable();
        assert_eq!(keys(&document), expected);
        let error = document["error_percent"][0].as_f64().unwrap();
        assert!((error - 100.0 * 0.00102 / 14.2).abs() < 1e-9);
    }

    #[test]
    fn mc_has_the_agreed_names_and_shapes() {
        let document = serde_json::to_value(examples::mc()).unwrap();
        let expected = [
            "bias_kg_m2",
            "bias_over_bound",
            "bound_kg_m2",
            "changes",
            "diverged",
            "estimator",
            "nees_95",
            "nees_per_dof",
            "nees_runs",
            "not_converged",
            "not_shown",
            "precision",
            "residuals_not_white",
            "rmse_kg_m2",
            "rmse_over_bound",
            "rmse_over_bound_of_all",
            "runs",
            "scenario",
            "seed",
            "steps",
            "steps_per_s_per_core",
            "truth_kg_m2",
            "used",
            "wall_s",
        ];
        assert_eq!(keys(&document), expected);
        assert_eq!(document["rmse_over_bound"].as_array().unwrap().len(), 6);
        assert_eq!(document["nees_95"], json!([0.8881, 1.1187]));
    }

    #[test]
    fn unseen_bound_and_error_of_zero_are_null() {
        let document = serde_json::to_value(examples::crlb()).unwrap();
        assert!(document["bound_kg_m2"][2].is_null() && document["bound_percent"][2].is_null());
        assert!((document["bound_percent"][3].as_f64().unwrap() - 1.2918).abs() < 1e-3);
        assert_eq!(document["observed_directions"], 4);
        assert_eq!(document["inertia_error_kg_m2_per_n_m"][0], json!([-1350.0, 12.5, -0.2]));
        assert!(document["inertia_error_kg_m2_per_n_m"][2].is_null());
        assert_eq!(document["torque_bound_n_m"], json!([3.21e-7, 4.5e-5, null]));

        let mut truth = examples::TRUTH;
        truth[3] = 0.0;
        let run = RunReport::new("x", 0, examples::replay(), truth, [None; 6]);
        assert_eq!(run.error_percent[3], None);
    }

    #[test]
    fn elements_and_matrix_are_inverse() {
        let six = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(elements(&matrix(&six)), six);
    }

    #[test]
    fn principal_moments_ascend() {
        let mut report = examples::replay();
        report.inertia_kg_m2 = matrix(&[3.0, 2.0, 2.0, 0.0, 0.0, 1.0]);
        let moments = report.principal_moments_kg_m2();
        assert!((moments[0] - 1.0).abs() + (moments[1] - 3.0).abs() < 1e-12);
    }
}
