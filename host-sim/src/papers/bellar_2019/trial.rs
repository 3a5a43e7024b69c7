//! One seed of \[Bellar2019\]: the flight of Table 3, and a run of the campaign.

use nalgebra::Vector3;

use crate::campaign::{Campaign, CampaignRun, RunFailed, Truths, Verdict};
use crate::estimation::{AnyEstimator, EstimatorName, Method, Precision, SetUpError};
use crate::input::Scenario;
use crate::papers::case::{Case, OWN};
use crate::papers::paper::PapersFailed;

/// Criterion of convergence: the largest error of an element, share of the mean moment, that is not
/// exceeded again. Own choice, since the paper gives none.
const CONVERGED_WITHIN: f64 = 0.01;
/// Interval between two checks of convergence, samples. Reading an estimate costs more than a step.
pub(super) const CHECKED_EVERY: usize = 10;

pub(super) const PUBLISHED: Method =
    Method { estimator: EstimatorName::JointEkfPublished, precision: Precision::F64 };

/// Filters of the campaign: as printed, in UD form with the same initial state, and the own
/// estimator.
pub(super) const CAMPAIGN: [Method; 5] = [
    PUBLISHED,
    Method { precision: Precision::F32, ..PUBLISHED },
    Method { estimator: EstimatorName::JointEkfUnaligned, precision: Precision::F64 },
    Method { estimator: EstimatorName::JointEkfUnaligned, precision: Precision::F32 },
    OWN,
];

/// The flight of Table 3, and the campaign.
pub struct Bellar2019 {
    pub(super) case: Case,
    pub(super) campaign: Scenario,
    pub(super) truths: Truths,
}

/// Results of one seed.
pub struct Bellar2019Trial {
    /// The printed filter on the flight of Table 3.
    pub(super) published: OneFlight,
    /// The own estimator on the same flight.
    pub(super) own: OneFlight,
    /// In the order of [`CAMPAIGN`].
    pub(super) campaign: [CampaignRun; 5],
}

/// Results of one estimator on the flight of Table 3.
pub(super) struct OneFlight {
    /// Verdict at the end.
    pub verdict: Verdict,
    /// Estimate at the end, kg m².
    pub estimate_kg_m2: [f64; 6],
    /// RMS over samples and axes of estimated minus true rate, deg/s.
    pub rate_rmse_deg_s: f64,
    /// RMS over samples and axes of the rate's one sigma by the filter's covariance, deg/s.
    pub rate_sigma_deg_s: f64,
    /// Time of convergence, s. NaN without convergence.
    pub convergence_s: f64,
}

impl Bellar2019 {
    /// Simulates the true motion of both scenarios.
    pub(super) fn simulate() -> Result<Self, PapersFailed> {
        let campaign = Scenario::load("bellar-2019-campaign")?;
        let truths = Truths::simulate(&campaign)?;
        Ok(Self { case: Case::load("bellar-2019")?, campaign, truths })
    }

    /// Flies one seed.
    pub(super) fn trial(&self, seed: u64) -> Result<Bellar2019Trial, RunFailed> {
        let [a, b, c, d, e] = CAMPAIGN.map(|method| self.campaign_run(method, seed));
        Ok(Bellar2019Trial {
            published: self.one_flight(PUBLISHED, seed)?,
            own: self.one_flight(OWN, seed)?,
            campaign: [a?, b?, c?, d?, e?],
        })
    }

    fn campaign_run(&self, method: Method, seed: u64) -> Result<CampaignRun, RunFailed> {
        let Method { estimator, precision } = method;
        let (scenario, truths) = (&self.campaign, &self.truths);
        Campaign { scenario, truths, estimator, precision, first_seed: seed, runs: 1 }.run_one(0)
    }

    fn one_flight(&self, method: Method, seed: u64) -> Result<OneFlight, SetUpError> {
        let truth_kg_m2 = self.case.truth_kg_m2();
        let limit = CONVERGED_WITHIN * truth_kg_m2[..3].iter().sum::<f64>() / 3.0;
        let is_close = |estimator: &dyn AnyEstimator| {
            let elements = estimator.estimate().inertia.elements_kg_m2();
            (0..6).all(|i| (elements[i] - truth_kg_m2[i]).abs() < limit)
        };
        let (mut error, mut sigma) = (MeanSquare::default(), MeanSquare::default());
        let mut convergence_s = f64::NAN;
        let flown = self.case.fly(method, seed, |index, estimator| {
            let instant = &self.case.flight.instants[index];
            // The first estimate is the initial state of Table 2, degrees per second off.
            if index > 0 {
                error.add(estimator.rate_rad_s() - instant.rate_rad_s);
            }
            if let Some(one_sigma) = estimator.rate_sigma_rad_s() {
                sigma.add(one_sigma);
            }
            if index % CHECKED_EVERY == 0 {
                let time_s = instant.time_us as f64 * 1e-6;
                convergence_s = match is_close(estimator) {
                    true if convergence_s.is_nan() => time_s,
                    true => convergence_s,
                    false => f64::NAN,
                };
            }
        })?;
        Ok(OneFlight {
            verdict: self.case.reference().score(&flown.estimate).verdict,
            estimate_kg_m2: flown.estimate.inertia.elements_kg_m2(),
            rate_rmse_deg_s: error.root().to_degrees(),
            rate_sigma_deg_s: sigma.root().to_degrees(),
            convergence_s,
        })
    }
}

/// Mean square over the components of vectors.
#[derive(Default)]
struct MeanSquare {
    sum: f64,
    count: f64,
}

impl MeanSquare {
    fn add(&mut self, vector: Vector3<f64>) {
        self.sum += vector.norm_squared();
        self.count += 3.0;
    }

    fn root(&self) -> f64 {
        (self.sum / self.count).sqrt()
    }
}
