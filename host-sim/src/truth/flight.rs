//! A simulated flight: the true motion at every gyro sample.

use nalgebra::{UnitQuaternion, Vector3};

use super::bound::Sensitivities;
use super::integrate::{Equations, IntegrationFailed, advance};
use super::spacecraft::Spacecraft;
use super::{Bound, Unknowns};
use crate::input::scenario::Scenario;
use crate::sensor::gyro::variance_rad2_s2;

/// The truth at one gyro sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Instant {
    /// Time since the start, µs.
    pub time_us: u64,
    /// Body rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Rotation that takes body axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
    /// Wheel speeds relative to the body, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// External torque that the estimator is told of, body axes, N m.
    pub torque_n_m: Vector3<f64>,
}

/// The truth at every sample, and the bound it sets.
#[derive(Clone, Debug)]
pub struct Flight {
    /// Gyro sample by gyro sample, the first at time zero.
    pub instants: Vec<Instant>,
    /// What no unbiased estimator can beat on this motion.
    pub bound: Bound,
}

impl Flight {
    /// Flies the scenario once. Gyro noise comes later: the truth is the same for every seed.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let craft = Spacecraft::new(scenario);
        let equations = Sensitivities::new(&craft, Unknowns::of(scenario));
        let mut bound = equations.empty_bound();
        let mut instants = Vec::new();
        let mut state = equations.initial_state();
        let kinks_s = kinks_s(scenario);
        let mut now_s = 0.0;
        for time_us in sample_times_us(scenario) {
            let time_s = seconds(time_us);
            state = advance_past_kinks(&equations, &kinks_s, now_s, time_s, state)?;
            now_s = time_s;
            let motion = craft.motion(&state);
            bound.add(&equations.of_rate(&state));
            instants.push(Instant {
                time_us,
                rate_rad_s: motion.rate_rad_s,
                attitude: motion.attitude,
                wheel_speed_rad_s: motion.wheel_speed_rad_s,
                torque_n_m: scenario.torque.at(time_s),
            });
        }
        Ok(Self { instants, bound: bound.finish(variance_rad2_s2(&scenario.gyro)) })
    }
}

/// When the gyro is sampled: from zero to the end of the scenario, rounded to the microsecond
/// that the time stamp can hold, so that stamp and truth agree exactly.
fn sample_times_us(scenario: &Scenario) -> impl Iterator<Item = u64> {
    let rate_hz = scenario.gyro.rate_hz;
    // A duration of so many periods includes the last one, whatever the rounding of the product.
    let last = (scenario.duration_s * rate_hz * (1.0 + 1e-12)).floor() as u64;
    (0..=last).map(move |index| (index as f64 / rate_hz * 1e6).round() as u64)
}

/// Integrates from one time to another, with a stop wherever a torque may jump or bend.
fn advance_past_kinks(
    equations: &impl Equations,
    kinks_s: &[f64],
    from_s: f64,
    to_s: f64,
    mut state: Vec<f64>,
) -> Result<Vec<f64>, IntegrationFailed> {
    let first = kinks_s.partition_point(|kink_s| *kink_s <= from_s);
    let between = kinks_s[first..].iter().copied().take_while(|kink_s| *kink_s < to_s);
    let mut now_s = from_s;
    for stop_s in between.chain([to_s]) {
        if now_s < stop_s {
            state = advance(equations, now_s, stop_s, state)?;
            now_s = stop_s;
        }
    }
    Ok(state)
}

/// Where a torque or its slope may jump, ascending.
fn kinks_s(scenario: &Scenario) -> Vec<f64> {
    let motors = scenario.wheels.iter().flat_map(|motor| motor.torque.breakpoints_s());
    let mut kinks_s: Vec<f64> = scenario.torque.breakpoints_s().into_iter().chain(motors).collect();
    kinks_s.sort_by(f64::total_cmp);
    kinks_s
}

fn seconds(time_us: u64) -> f64 {
    time_us as f64 * 1e-6
}
