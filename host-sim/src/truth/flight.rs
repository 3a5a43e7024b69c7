//! A simulated flight: the true motion at every gyro sample.

use std::iter::Peekable;

use nalgebra::{UnitQuaternion, Vector3};

use super::bound::{Information, Sensitivities};
use super::integrate::{Equations, IntegrationFailed, advance};
use super::spacecraft::Spacecraft;
use super::{Bound, Unknowns};
use crate::input::scenario::Scenario;
use crate::input::scenario::change::Stretch;
use crate::sensor::gyro::variance_rad2_s2;

/// The truth at one gyro sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Instant {
    /// Time since the start, µs.
    pub time_us: u64,
    /// Body rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// `jxx jyy jzz jxy jxz jyz`, kg m².
    pub inertia_kg_m2: [f64; 6],
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
    /// What no unbiased estimator can beat on this motion; where the inertia changes suddenly, on what
    /// follows the last change. See [`bound`](super::bound).
    pub bound: Bound,
}

impl Flight {
    /// Flies the scenario once. Gyro noise comes later: the truth is the same for every seed.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let mut course = Course {
            scenario,
            kinks_s: kinks_s(scenario),
            times_us: sample_times_us(scenario).peekable(),
            instants: Vec::new(),
        };
        let mut craft = Spacecraft::new(scenario);
        let (mut end, mut shown) =
            course.fly(&craft, &scenario.stretch(0), craft.initial_state())?;
        for stretch in scenario.stretches().skip(1) {
            let next = Spacecraft::of_stretch(scenario, &stretch);
            let start = craft.becomes(&next, &end);
            (end, shown) = course.fly(&next, &stretch, start)?;
            craft = next;
        }
        let bound = shown.finish(variance_rad2_s2(&scenario.gyro));
        Ok(Self { instants: course.instants, bound })
    }
}

/// A flight under way.
struct Course<'a, Times: Iterator<Item = u64>> {
    scenario: &'a Scenario,
    kinks_s: Vec<f64>,
    /// Of the samples still to come.
    times_us: Peekable<Times>,
    /// What has been flown.
    instants: Vec<Instant>,
}

impl<Times: Iterator<Item = u64>> Course<'_, Times> {
    /// Flies on to the next sudden change, or to the last sample. The state there, and what this
    /// stretch shows.
    fn fly(
        &mut self,
        craft: &Spacecraft<'_>,
        stretch: &Stretch,
        start: Vec<f64>,
    ) -> Result<(Vec<f64>, Information), IntegrationFailed> {
        let equations = Sensitivities::new(craft, Unknowns::of(self.scenario));
        let mut shown = equations.empty_information();
        let mut state = equations.from_motion(start);
        let mut now_s = stretch.from_s;
        let is_within = |time_us: &u64| stretch.to_s.is_none_or(|to_s| seconds(*time_us) < to_s);
        while let Some(time_us) = self.times_us.next_if(is_within) {
            let time_s = seconds(time_us);
            state = advance_past_kinks(&equations, &self.kinks_s, now_s, time_s, state)?;
            now_s = time_s;
            shown.add(&equations.of_rate(&state));
            let motion = craft.motion(&state);
            self.instants.push(Instant {
                time_us,
                rate_rad_s: motion.rate_rad_s,
                inertia_kg_m2: stretch.inertia_at_kg_m2(time_s),
                attitude: motion.attitude,
                wheel_speed_rad_s: motion.wheel_speed_rad_s,
                torque_n_m: self.scenario.torque.at(time_s),
            });
        }
        state.truncate(craft.dimension());
        if let Some(to_s) = stretch.to_s {
            state = advance_past_kinks(craft, &self.kinks_s, now_s, to_s, state)?;
        }
        Ok((state, shown))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::scenario::ExternalTorque;
    use crate::input::scenario::change::SuddenChange;

    #[test]
    fn a_disturbance_moves_the_body_as_a_command_does_and_is_told_to_nobody() {
        let commanded = Scenario::load("stsat3-spin-up").unwrap();
        let disturbed = Scenario {
            torque: ExternalTorque::ZERO,
            disturbance_torque_n_m: commanded.torque.at(0.0),
            ..commanded.clone()
        };
        assert_eq!(disturbed.craft(), commanded.craft());
        let [commanded, disturbed] =
            [commanded, disturbed].map(|scenario| Flight::simulate(&scenario).unwrap());
        for (commanded, disturbed) in commanded.instants.iter().zip(&disturbed.instants) {
            assert!((commanded.rate_rad_s - disturbed.rate_rad_s).norm() < 1e-12);
            assert_eq!(disturbed.torque_n_m, Vector3::zeros());
        }
    }

    #[test]
    fn a_sample_at_the_very_time_of_a_change_sees_what_follows() {
        let mut scenario = Scenario::load("stsat3-spin-up").unwrap();
        scenario.changes.sudden = vec![SuddenChange {
            time_s: 300.0,
            inertia_kg_m2: scenario.spacecraft.inertia_kg_m2.map(|j| 2.0 * j),
        }];
        let instants = Flight::simulate(&scenario).unwrap().instants;
        assert_eq!(instants.len(), 6001);
        let rate = |index: usize| instants[index].rate_rad_s.norm();
        // Twice the inertia, half the rate; a tenth of a second's torque is 1e-5 rad/s.
        assert!((rate(3000) - 0.5 * rate(2999)).abs() < 2e-5, "{} {}", rate(2999), rate(3000));
        assert!((rate(2999) - rate(2998)).abs() < 2e-5);
        assert_eq!(instants[2999].inertia_kg_m2, scenario.spacecraft.inertia_kg_m2);
        assert_eq!(instants[3000].inertia_kg_m2, scenario.final_inertia_kg_m2());
    }
}
