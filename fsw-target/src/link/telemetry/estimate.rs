//! What the selected estimator knows.

use crate::link::packet::ESTIMATE;
use crate::link::wire::{codes, record};
use fsw_core::attitude::NoAttitude;
use fsw_core::gate::Rejection;
use fsw_core::{Coasting, Estimator, Outcome, Reset, Status};
use fsw_steps::EstimatorId;

record! {
    /// What the selected estimator knows, and what became of the last sample.
    struct EstimateReport {
        /// Time stamp of the last sample that was stepped, by the same clock as the packet's time; 0 before the first.
        sample_time_us: u64, "µs";
        /// The selected estimator.
        estimator: EstimatorId, "–";
        /// Whether to use the estimate.
        status: Status, "–";
        /// What became of the last sample.
        outcome: Option<Outcome>, "–";
        /// Whether a rigid body can have this tensor.
        physical: bool, "–";
        /// Whether the data by itself asks for a tensor that no body has, so that this is the physical one nearest to it.
        projected: bool, "–";
        /// Whether the residuals look like the gyro's white noise alone; missing where that isn't tested.
        residuals_white: Option<bool>, "–";
        /// Independent directions in the space of the six elements that the data has shown, 0 to 6.
        observed_directions: u8, "–";
        /// Which elements the data has shown: `jxx jyy jzz jxy jxz jyz`.
        element_observed: [bool; 6], "–";
        /// Whether the data has shown the size of the tensor, its trace.
        scale_observed: bool, "–";
        /// The tensor's entries about the centre of mass in body axes, wheels included and locked: `jxx jyy jzz jxy jxz jyz`.
        inertia_kg_m2: [f32; 6], "kg m²";
        /// One sigma of each.
        sigma_kg_m2: [f32; 6], "kg m²";
        /// Filtered body rate relative to inertial space, body axes.
        rate_rad_s: [f32; 3], "rad/s";
        /// Measured minus predicted rate, RMS over the samples used, all axes.
        residual_rms_rad_s: f32, "rad/s";
        /// Innovation squared over its variance, summed over the axes of the last sample that was predicted: 3 on average.
        nis: Option<f32>, "–";
        /// Constant disturbance torque, body axes, where the estimator solves for one.
        disturbance_torque_n_m: Option<[f32; 3]>, "N m";
        /// Gyro bias, body axes, where the estimator solves for one.
        gyro_bias_rad_s: Option<[f32; 3]>, "rad/s";
    }
}

report!(EstimateReport, ESTIMATE);

impl EstimateReport {
    /// What `flying` knows. `outcome` is that of its last sample, which was taken at
    /// `sample_time_us`. Costs an eigenproblem of six, as [`Estimator::estimate`] does.
    #[inline(never)]
    pub fn of<E: Estimator<f32, W>, const W: usize>(
        estimator: EstimatorId,
        flying: &E,
        sample_time_us: u64,
        outcome: Option<Outcome>,
    ) -> Self {
        let estimate = flying.estimate();
        Self {
            sample_time_us,
            estimator,
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
            rate_rad_s: flying.rate_rad_s().into(),
            residual_rms_rad_s: estimate.residual_rms_rad_s,
            nis: flying.innovation().map(|innovation| innovation.nis()),
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
} }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::Coded;

    #[test]
    fn outcomes_have_the_names_of_the_core() {
        for (code, word) in Outcome::CODES {
            let outcome = Outcome::of_code(*code).unwrap();
            assert_eq!(outcome.name(), *word);
            assert_eq!(outcome.code(), (*code, *word));
        }
    }
}
