//! The committed flight: the recording [`cubesat_pyramid`] with the nine-state filter `joint-ekf`.
//!
//! The image `bin/replay` runs it on the target, a test of the workspace on the host; state and covariance
//! must be equal bit for bit. So must be the [`digest`] of the recording by each estimator that flies.

use crate::flight::computer::SLICES_PER_SAMPLE;
use crate::flight::flight_loop::{FlightLoop, Sensors, Tick};
use crate::flight::selected::{EstimatorId, Refused, SelectedEstimator};
use crate::stand_in::recording::cubesat_pyramid::{CRAFT, WHEELS};
use crate::stand_in::recording::{Recording, cubesat_pyramid};
use fsw_core::estimator::joint_ekf::Config;
use fsw_core::{ConfigError, Estimator, Prior};
use fsw_steps::{Fast, JointEkf};

/// The recording [`cubesat_pyramid`].
pub type Flight = Recording<'static, WHEELS>;

/// The flight loop of this flight.
pub type ReplayLoop<'a> =
    FlightLoop<Fast<JointEkf>, &'a Flight, &'a Flight, &'a Flight, &'a Flight, WHEELS>;

/// The recording before its first row.
pub fn recording() -> Flight {
    Recording::new(&cubesat_pyramid::ROWS)
}

/// The flight loop on `recording`, with an estimator of the spacecraft in its craft file.
///
/// # Errors
/// Names the value of the craft file that the estimator does not accept.
pub fn flight_loop(recording: &Flight) -> Result<ReplayLoop<'_>, ConfigError> {
    let config = Config { prior: CRAFT.prior, ..Config::new(CRAFT.gyro_noise_rad_s) };
    let estimator = Fast(JointEkf::new(config, CRAFT.wheels()?)?);
    let sensors =
        Sensors { data_ready: recording, gyro: recording, wheels: recording, torque: recording };
    Ok(FlightLoop::new(estimator, sensors))
}

/// Prior of [`digest`], kg m²: `ekf-sgf-rls` needs one, and the craft file has none.
const PRIOR: Prior<f32> = Prior {
    inertia_kg_m2: [0.05, 0.1, 0.1, 0.0, 0.0, 0.0],
    sigma_kg_m2: [0.02, 0.02, 0.02, 0.005, 0.005, 0.005],
};

/// Digest of the recording by the estimator `id`, with the errors of the hardware and the work of `window` as in flight:
/// the bits of rate and innovation after each sample, and of inertia and covariance at the end.
///
/// # Errors
/// The estimator is not built in, or does not accept the craft file.
pub fn digest(estimator: &mut SelectedEstimator, id: EstimatorId) -> Result<u64, Refused> {
    estimator.configure(CRAFT)?;
    estimator.set_prior(PRIOR)?;
    estimator.select(id)?;
    let recording = &recording();
    let sensors =
        Sensors { data_ready: recording, gyro: recording, wheels: recording, torque: recording };
    let mut flight = FlightLoop::new(estimator, sensors);
    let mut digest = Digest::EMPTY;
    while flight.tick() != Tick::Idle {
        flight.estimator_mut().work(SLICES_PER_SAMPLE);
        let estimator = flight.estimator();
        digest.add(estimator.rate_rad_s().as_slice());
        if let Some(innovation) = estimator.innovation() {
            digest.add(innovation.rate_rad_s.as_slice());
        }
    }
    let estimate = flight.estimator().estimate();
    digest.add(&estimate.inertia.elements_kg_m2());
    digest.add(estimate.covariance_kg2_m4.as_slice());
    Ok(digest.0)
}

/// 64-bit FNV-1a of the little-endian bytes of numbers.
struct Digest(u64);

impl Digest {
    const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    fn add(&mut self, numbers: &[f32]) {
        for byte in numbers.iter().flat_map(|number| number.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::Status;

    #[test]
    fn the_committed_flight_converges_with_every_sample_accepted() {
        let recording = recording();
        let mut flight = flight_loop(&recording).unwrap();
        while flight.tick() != Tick::Idle {}
        assert_eq!(flight.counters().outcomes.accepted as usize, cubesat_pyramid::ROWS.len());
        assert_eq!(flight.estimator().estimate().status, Status::Converged);
    }

    #[test]
    fn digests_of_the_estimators_differ_and_repeat() {
        let mut estimator = SelectedEstimator::uninitialised();
        let mut all = EstimatorId::BUILT_IN.iter().map(|&id| digest(&mut estimator, id).unwrap());
        let [first, second, third] = [(); 3].map(|()| all.next().unwrap());
        assert!(first != second && second != third && third != first);
        assert_eq!(digest(&mut estimator, EstimatorId::BUILT_IN[0]), Ok(first));
    }
}
