//! A simulated flight: the true motion at every gyro sample, and its Cramér-Rao bound.

use std::iter::Peekable;

use nalgebra::{UnitQuaternion, Vector3};

use super::bound::hardware::{HardwareBound, HardwareInformation, HardwareSensitivities};
use super::bound::information::{Bound, Information};
use super::bound::sensitivities::Sensitivities;
use super::bound::torque_effect::TorqueEffect;
use super::bound::unknowns::Unknowns;
use super::integrate::{Equations, IntegrationFailed, advance};
use super::spacecraft::Spacecraft;
use super::trajectory::Trajectory;
use crate::input::scenario::Scenario;
use crate::input::scenario::change::Stretch;

/// Allowance for rounding in duration × rate, so that a duration of an integer number of periods
/// includes its last sample.
const SAMPLE_COUNT_ROUNDING: f64 = 1e-12;

/// True state at one gyro sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Instant {
    /// Time since the start, µs.
    pub time_us: u64,
    /// Body rate relative to inertial space, body axes, rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// `jxx jyy jzz jxy jxz jyz`, kg m².
    pub inertia_kg_m2: [f64; 6],
    /// Rotation from body axes to inertial axes.
    pub attitude: UnitQuaternion<f64>,
    /// Wheel speeds relative to the body, rad/s.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Commanded external torque, known to the estimator, body axes, N m.
    pub torque_n_m: Vector3<f64>,
}

/// True states at all gyro samples, and the bound.
#[derive(Clone, Debug)]
pub struct Flight {
    /// States in order of time, the first at time zero.
    pub instants: Vec<Instant>,
    /// Cramér-Rao bound of the motion; after the last sudden change of the inertia if there is one.
    /// See [`bound`](super::bound).
    pub bound: Bound,
    /// Motion between the samples, if a sensor of the scenario depends on it.
    pub trajectory: Option<Trajectory>,
}

impl Flight {
    /// Simulates the scenario. The truth is the same for every seed of the gyro noise.
    ///
    /// # Errors
    /// [`IntegrationFailed`] if the motion cannot be integrated.
    pub fn simulate(scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        let mut propagation = Propagation {
            scenario,
            kinks_s: kinks_s(scenario),
            times_us: sample_times_us(scenario).peekable(),
            instants: Vec::new(),
        };
        let mut craft = Spacecraft::new(scenario);
        let (mut end, mut information) =
            propagation.stretch(&craft, &scenario.stretch(0), craft.initial_state())?;
        for stretch in scenario.stretches().skip(1) {
            let next = Spacecraft::of_stretch(scenario, &stretch);
            let start = craft.becomes(&next, &end);
            (end, information) = propagation.stretch(&next, &stretch, start)?;
            craft = next;
        }
        let mut bound = information.bound(scenario.gyro.reading_variance_rad2_s2());
        bound.hardware = hardware_bound(scenario)?;
        let trajectory = trajectory(scenario)?;
        Ok(Self { instants: propagation.instants, bound, trajectory })
    }

    /// Adds the motion between the samples, which a sensor outside the scenario needs.
    ///
    /// # Errors
    /// As of [`Self::simulate`].
    pub fn with_trajectory(self, scenario: &Scenario) -> Result<Self, IntegrationFailed> {
        Ok(Self { trajectory: Some(Trajectory::simulate(scenario)?), ..self })
    }

    /// Simulates the motion alone, with the bound of a scenario that differs in its hardware only.
    ///
    /// # Errors
    /// As of [`Self::simulate`].
    pub fn with_bound(scenario: &Scenario, bound: Bound) -> Result<Self, IntegrationFailed> {
        let mut propagation = Propagation {
            scenario,
            kinks_s: kinks_s(scenario),
            times_us: sample_times_us(scenario).peekable(),
            instants: Vec::new(),
        };
        let mut craft = Spacecraft::new(scenario);
        let mut end = craft.initial_state();
        for (index, stretch) in scenario.stretches().enumerate() {
            if index > 0 {
                let next = Spacecraft::of_stretch(scenario, &stretch);
                end = craft.becomes(&next, &end);
                craft = next;
            }
            end = propagation.motion(&craft, &stretch, end)?;
        }
        let trajectory = trajectory(scenario)?;
        Ok(Self { instants: propagation.instants, bound, trajectory })
    }
}

/// Bound with the stated errors of the hardware, over the last stretch of the flight; none if there is no
/// error.
fn hardware_bound(scenario: &Scenario) -> Result<Option<HardwareBound>, IntegrationFailed> {
    let kinks_s = kinks_s(scenario);
    let mut craft = Spacecraft::new(scenario);
    let mut stretch = scenario.stretch(0);
    if HardwareSensitivities::new(&craft, scenario).is_none() {
        return Ok(None);
    }
    let mut state = craft.initial_state();
    for later in scenario.stretches().skip(1) {
        state = advance_past_kinks(&craft, &kinks_s, stretch.from_s, later.from_s, state)?;
        let next = Spacecraft::of_stretch(scenario, &later);
        state = craft.becomes(&next, &state);
        (craft, stretch) = (next, later);
    }
    let Some(equations) = HardwareSensitivities::new(&craft, scenario) else { return Ok(None) };
    let mut information = HardwareInformation::new(&equations);
    let mut state = equations.from_motion(state);
    let mut now_s = stretch.from_s;
    for time_s in sample_times_us(scenario).map(seconds).filter(|time_s| *time_s >= stretch.from_s)
    {
        state = advance_past_kinks(&equations, &kinks_s, now_s, time_s, state)?;
        now_s = time_s;
        information.add(&equations, time_s, &state);
    }
    let noise_rad_s = scenario.gyro.reading_variance_rad2_s2().sqrt();
    Ok(Some(information.bound(&equations, noise_rad_s)))
}

/// Motion between the samples, if a sensor of the scenario depends on it.
fn trajectory(scenario: &Scenario) -> Result<Option<Trajectory>, IntegrationFailed> {
    scenario.needs_trajectory().then(|| Trajectory::simulate(scenario)).transpose()
}

/// Effect of a constant torque on a scenario with this bound. A scenario that does not solve for the
/// torque is simulated once more with the torque among the unknowns.
///
/// # Errors
/// [`IntegrationFailed`] if the motion cannot be integrated.
pub fn torque_effect(
    scenario: &Scenario,
    bound: &Bound,
) -> Result<Option<TorqueEffect>, IntegrationFailed> {
    if scenario.solve_for.torque {
        return Ok(bound.torque.clone());
    }
    let mut with_torque = scenario.clone();
    with_torque.solve_for.torque = true;
    Ok(Flight::simulate(&with_torque)?.bound.torque)
}

/// Propagation of a flight, stretch by stretch.
struct Propagation<'a, Times: Iterator<Item = u64>> {
    scenario: &'a Scenario,
    /// Times of torque kinks, ascending, s.
    kinks_s: Vec<f64>,
    /// Times of the remaining samples, µs.
    times_us: Peekable<Times>,
    /// States at the past samples.
    instants: Vec<Instant>,
}

impl<Times: Iterator<Item = u64>> Propagation<'_, Times> {
    /// Propagates to the next sudden change, or to the last sample. Returns the state there and the
    /// information of the stretch.
    fn stretch(
        &mut self,
        craft: &Spacecraft<'_>,
        stretch: &Stretch,
        start: Vec<f64>,
    ) -> Result<(Vec<f64>, Information), IntegrationFailed> {
        let unknowns = Unknowns::of(self.scenario);
        let equations = Sensitivities::new(craft, unknowns);
        let mut information = Information::new(unknowns, craft.mean_moment_kg_m2());
        let mut state = equations.from_motion(start);
        let mut now_s = stretch.from_s;
        let is_within = |time_us: &u64| stretch.to_s.is_none_or(|to_s| seconds(*time_us) < to_s);
        while let Some(time_us) = self.times_us.next_if(is_within) {
            let time_s = seconds(time_us);
            state = advance_past_kinks(&equations, &self.kinks_s, now_s, time_s, state)?;
            now_s = time_s;
            information.add(&equations.of_rate(&state));
            self.record(craft, stretch, time_us, &state);
        }
        state.truncate(craft.dimension());
        if let Some(to_s) = stretch.to_s {
            state = advance_past_kinks(craft, &self.kinks_s, now_s, to_s, state)?;
        }
        Ok((state, information))
    }

    /// The same without information. Returns the state at the end.
    fn motion(
        &mut self,
        craft: &Spacecraft<'_>,
        stretch: &Stretch,
        mut state: Vec<f64>,
    ) -> Result<Vec<f64>, IntegrationFailed> {
        let mut now_s = stretch.from_s;
        let is_within = |time_us: &u64| stretch.to_s.is_none_or(|to_s| seconds(*time_us) < to_s);
        while let Some(time_us) = self.times_us.next_if(is_within) {
            let time_s = seconds(time_us);
            state = advance_past_kinks(craft, &self.kinks_s, now_s, time_s, state)?;
            now_s = time_s;
            self.record(craft, stretch, time_us, &state);
        }
        match stretch.to_s {
            Some(to_s) => advance_past_kinks(craft, &self.kinks_s, now_s, to_s, state),
            None => Ok(state),
        }
    }

    /// Adds the state at a sample.
    fn record(&mut self, craft: &Spacecraft<'_>, stretch: &Stretch, time_us: u64, state: &[f64]) {
        let (time_s, motion) = (seconds(time_us), craft.motion(state));
        self.instants.push(Instant {
            time_us,
            rate_rad_s: motion.rate_rad_s,
            inertia_kg_m2: stretch.inertia_at_kg_m2(time_s),
            attitude: motion.attitude,
            wheel_speed_rad_s: motion.wheel_speed_rad_s,
            torque_n_m: self.scenario.torque.at(time_s),
        });
    }
}

/// Times of the gyro samples from zero to the end of the scenario, rounded to the resolution of the
/// time stamp, 1 µs, so that stamp and truth agree exactly.
fn sample_times_us(scenario: &Scenario) -> impl Iterator<Item = u64> {
    let rate_hz = scenario.gyro.rate_hz;
    let last = (scenario.duration_s * rate_hz * (1.0 + SAMPLE_COUNT_ROUNDING)).floor() as u64;
    (0..=last).map(move |index| (index as f64 / rate_hz * 1e6).round() as u64)
}

/// Integrates from one time to another, with a stop at each kink in between.
pub(super) fn advance_past_kinks(
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

/// Times at which a torque or its slope may jump, ascending, s.
pub(super) fn kinks_s(scenario: &Scenario) -> Vec<f64> {
    let pulses = scenario.true_hardware.pulses.iter();
    let pulses = pulses.flat_map(|pulse| [pulse.time_s, pulse.time_s + pulse.duration_s]);
    let motors = scenario.wheels.iter().flat_map(|motor| motor.torque.breakpoints_s());
    let external = scenario.torque.breakpoints_s().into_iter();
    let mut kinks_s: Vec<f64> = external.chain(motors).chain(pulses).collect();
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
    fn disturbance_acts_like_a_command_and_is_unknown_to_the_estimator() {
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
    fn sample_at_the_time_of_a_change_has_the_new_inertia() {
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
