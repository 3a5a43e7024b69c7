//! The committed flight, ready to fly: the recording [`cubesat_pyramid`] and the nine-state filter.
//!
//! The image `bin/replay` flies it on the target, and the test of the workspace flies it on the
//! host; both must come to the same bits.

use crate::flight::flight_loop::{FlightLoop, Sensors};
use crate::stand_in::recording::cubesat_pyramid::{CRAFT, WHEELS};
use crate::stand_in::recording::{Recording, cubesat_pyramid};
use fsw_core::ConfigError;
use fsw_core::estimator::joint_ekf::Config;
use fsw_steps::{Fast, JointEkf};

/// A recording with as many wheels as [`cubesat_pyramid`].
pub type Flight = Recording<'static, WHEELS>;

/// The flight loop of this flight: one recording plays all its sensors.
pub type ReplayLoop<'a> =
    FlightLoop<Fast<JointEkf>, &'a Flight, &'a Flight, &'a Flight, &'a Flight, WHEELS>;

/// The recording, standing before its first row.
pub fn recording() -> Flight {
    Recording::new(&cubesat_pyramid::ROWS)
}

/// The flight loop over `recording`, with the estimator that the craft file describes.
///
/// # Errors
/// Names the value of the craft file that the estimator refuses.
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
    fn the_committed_flight_is_accepted_and_converges() {
        let recording = recording();
        let mut flight = flight_loop(&recording).unwrap();
        while flight.tick() != Tick::Idle {}
        assert_eq!(flight.counters().outcomes.accepted as usize, cubesat_pyramid::ROWS.len());
        assert_eq!(flight.estimator().estimate().status, Status::Converged);
    }
}
