//! Estimate report: result of the selected estimator.

use crate::link::packet::ESTIMATE;
use crate::link::wire::{codes, record};
use fsw_core::attitude::NoAttitude;
use fsw_core::gate::Rejection;
use fsw_core::{Coasting, Estimator, Outcome, Reset, Status};
use fsw_roster::EstimatorId;

record! {
    /// Result of the selected estimator after its last step.
    struct EstimateReport {
        /// Time stamp of the last sample stepped, on the clock of the packet time; 0 before the first.
        sample_time_us: u64, "µs";
        /// The selected estimator.
        estimator: EstimatorId, "–";
        /// Usability of the estimate.
        status: Status, "–";
        /// Outcome of the last sample.
        outcome: Option<Outcome>, "–";
        /// True if a rigid body can have this tensor.
        physical: bool, "–";
        /// True if the data alone gives an impossible tensor, and the estimate is the nearest physical one.
        projected: bool, "–";
        /// True if the residuals are consistent with white gyro noise; absent if untested.
        residuals_white: Option<bool>, "–";
        /// Number of independent directions observed in the space of the six elements, 0 to 6.
        observed_directions: u8, "–";
        /// True for each observed element: `jxx jyy jzz jxy jxz jyz`.
        element_observed: [bool; 6], "–";
        /// True if the scale of the tensor, its trace, is observed.
        scale_observed: bool, "–";
        /// Inertia tensor about the centre of mass, body axes, locked wheels included: `jxx jyy jzz jxy jxz jyz`.
        inertia_kg_m2: [f32; 6], "kg m²";
        /// Standard deviation of each element.
        sigma_kg_m2: [f32; 6], "kg m²";
        /// Filtered body rate relative to inertial space, body axes.
        rate_rad_s: [f32; 3], "rad/s";
        /// RMS of measured minus predicted rate over the samples used, all axes.
        residual_rms_rad_s: f32, "rad/s";
        /// Normalised innovation squared of the last predicted sample, summed over the axes; mean 3. Absent if it is not finite.
        nis: Option<f32>, "–";
        /// Constant disturbance torque, body axes; absent if not estimated.
        disturbance_torque_n_m: Option<[f32; 3]>, "N m";
        /// Gyro bias, body axes; absent if not estimated.
        gyro_bias_rad_s: Option<[f32; 3]>, "rad/s";
    }
}

report!(EstimateReport, ESTIMATE);

impl EstimateReport {
    /// Report of `estimator` after the sample at `sample_time_us` with this outcome. Costs a 6 × 6
    /// eigenproblem, as [`Estimator::estimate`] does.
    #[inline(never)]
    pub fn of<E: Estimator<f32, W>, const W: usize>(
        id: EstimatorId,
        estimator: &E,
        sample_time_us: u64,
        outcome: Option<Outcome>,
    ) -> Self {
        let estimate = estimator.estimate();
        Self {
            sample_time_us,
            estimator: id,
            status: estimate.status,
            outcome,
            physical: estimate.inertia.check().is_ok(),
            projected: estimate.projected,
            residuals_white: estimate.residuals_white,
            observed_directions: estimate.observed.directions,
            element_observed: estimate.observed.element,
            scale_observed: estimate.observed.scale,
            inertia_kg_m2: estimate.inertia.elements_kg_m2(),
            sigma_kg_m2: estimate.sigma_kg_m2(),
            rate_rad_s: estimator.rate_rad_s().into(),
            residual_rms_rad_s: estimate.residual_rms_rad_s,
            nis: estimator
                .innovation()
                .map(|innovation| innovation.nis())
                .filter(|nis| nis.is_finite()),
            disturbance_torque_n_m: estimate.disturbance_torque_n_m.map(Into::into),
            gyro_bias_rad_s: estimate.gyro_bias_rad_s.map(Into::into),
        }
    }
}

codes! { Status {
    0 "unobservable" => Unobservable;
    1 "partial" => Partial;
    2 "converged" => Converged;
    3 "diverged" => Diverged;
} }

codes! { Outcome {
    0 "updated" => Updated;
    16 "not_finite" => Coasting(Coasting::Rejected(Rejection::NotFinite));
    17 "out_of_range" => Coasting(Coasting::Rejected(Rejection::OutOfRange));
    18 "out_of_order" => Coasting(Coasting::Rejected(Rejection::OutOfOrder));
    19 "stuck" => Coasting(Coasting::Rejected(Rejection::Stuck));
    20 "spike" => Coasting(Coasting::Spike);
    21 "aligning" => Coasting(Coasting::Aligning);
    22 "refilling" => Coasting(Coasting::Refilling);
    23 "attitude_missing" => Coasting(Coasting::NoAttitude(NoAttitude::Missing));
    24 "attitude_not_finite" => Coasting(Coasting::NoAttitude(NoAttitude::NotFinite));
    25 "attitude_not_unit" => Coasting(Coasting::NoAttitude(NoAttitude::NotUnit));
    26 "waiting_for_rest" => Coasting(Coasting::WaitingForRest);
    32 "reset_first_sample" => Reset(Reset::FirstSample);
    33 "reset_aligned" => Reset(Reset::Aligned);
    34 "reset_gap" => Reset(Reset::Gap);
    35 "reset_lockout" => Reset(Reset::Lockout);
    36 "reset_changed" => Reset(Reset::Changed);
    37 "reset_diverged" => Reset(Reset::Diverged);
    38 "reset_clock" => Reset(Reset::Clock);
    39 "reset_interrupted" => Reset(Reset::Interrupted);
} }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::Coded;

    #[test]
    fn outcomes_have_their_names_in_the_core() {
        for (code, word) in Outcome::CODES {
            let outcome = Outcome::of_code(*code).unwrap();
            assert_eq!(outcome.name(), *word);
            assert_eq!(outcome.code(), (*code, *word));
        }
    }
}
