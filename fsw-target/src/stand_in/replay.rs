//! The committed flight: the recording [`cubesat_pyramid`] with the nine-state filter `joint-ekf`.
//!
//! The image `bin/replay` runs it on the target, a test of the workspace on the host; state and covariance
//! must be equal bit for bit.

use crate::flight::flight_loop::{FlightLoop, Sensors};
use crate::stand_in::recording::cubesat_pyramid::{CRAFT, WHEELS};
use crate::stand_in::recording::{Recording, cubesat_pyramid};
use fsw_core::ConfigError;
use fsw_core::estimator::joint_ekf::Config;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::flight_loop::Tick;
    use fsw_core::{Estimator, Status};

    #[test]
    fn the_committed_flight_converges_with_every_sample_accepted() {
        let recording = recording();
        let mut flight = flight_loop(&recording).unwrap();
        while flight.tick() != Tick::Idle {}
        assert_eq!(flight.counters().outcomes.accepted as usize, cubesat_pyramid::ROWS.len());
        assert_eq!(flight.estimator().estimate().status, Status::Converged);
    }
}
