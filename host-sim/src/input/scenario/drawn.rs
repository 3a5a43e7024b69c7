//! Values that a run draws from its seed, by name, for the rows of a campaign.
//!
//! | drawn by | names |
//! |---|---|
//! | `[random_spacecraft]` | `drawn_duration_s`, `drawn_gyro_…`, `drawn_rate_…`, `drawn_wheels`, `drawn_wheel_N_…` |
//! | `[dispersion.initial_estimate]` | `drawn_initial_…` |
//! | stated errors of the hardware | the error by the name of its key without `_sigma`: `drawn_gyro_scale_x`, … |
//!
//! The true inertia is drawn too; it is a result of every run and has columns of its own.

use flight_input::ELEMENT_NAMES;
use flight_input::craft::StatedHardware;

use super::definition::Scenario;

/// Axes of a vector.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Pairs of axes of a misalignment, in its order.
const PAIRS: [&str; 6] = ["xy", "xz", "yx", "yz", "zx", "zy"];
/// Largest number of wheels of a random spacecraft.
const RANDOM_WHEELS: usize = 4;

/// Receiver of names and values.
type Visit<'a> = dyn FnMut(String, Option<f64>) + 'a;

impl Scenario {
    /// Names of the values that the runs of this scenario draw, in the order of [`Self::drawn_values`].
    pub fn drawn_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        self.each_drawn(self, &mut |name, _| names.push(name));
        names
    }

    /// Values that the run of this seed draws. None for the wheels that its spacecraft does not have.
    pub fn drawn_values(&self, seed: u64) -> Vec<Option<f64>> {
        let mut values = Vec::new();
        self.each_drawn(&self.of_seed(seed), &mut |_, value| values.push(value));
        values
    }

    /// Groups are those of this scenario, values those of `run`.
    fn each_drawn(&self, run: &Self, visit: &mut Visit<'_>) {
        let random = self.dispersion.spacecraft.as_ref();
        let wheels = random.map_or(self.wheels.len(), |_| RANDOM_WHEELS);
        if random.is_some() {
            spacecraft(run, wheels, visit);
        }
        if self.dispersion.initial_estimate.is_some() {
            let start = run.initial_estimate.as_ref();
            for (i, axis) in AXES.iter().enumerate() {
                let rate = start.map(|start| start.rate_rad_s[i]);
                visit(format!("drawn_initial_rate_{axis}_rad_s"), rate);
            }
            for (i, element) in ELEMENT_NAMES.iter().enumerate() {
                let value = start.map(|start| start.inertia_kg_m2[i]);
                visit(format!("drawn_initial_{element}_kg_m2"), value);
            }
        }
        let stated = random.map_or(&self.hardware, |random| &random.hardware);
        gyro(stated, run, visit);
        disturbances(stated, run, visit);
        wheel_errors(stated, run, wheels, visit);
        let modes = random.map_or(&self.true_hardware, |random| &random.true_hardware);
        for (index, _) in modes.modes.iter().enumerate().filter(|(_, mode)| mode.axis.is_none()) {
            let axis = run.true_hardware.modes.get(index).and_then(|mode| mode.axis);
            let name = |axis: &str| format!("drawn_mode_{}_axis_{axis}", index + 1);
            vector(name, axis.map(|axis| axis.into_inner().into()), visit);
        }
    }
}

fn vector(name: impl Fn(&str) -> String, value: Option<[f64; 3]>, visit: &mut Visit<'_>) {
    for (i, axis) in AXES.iter().enumerate() {
        visit(name(axis), value.map(|value| value[i]));
    }
}

/// A random spacecraft: its record, gyro, start and wheels.
fn spacecraft(run: &Scenario, wheels: usize, visit: &mut Visit<'_>) {
    visit("drawn_duration_s".to_owned(), Some(run.duration_s));
    visit("drawn_gyro_rate_hz".to_owned(), Some(run.gyro.rate_hz));
    visit("drawn_gyro_noise_rad_s".to_owned(), Some(run.gyro.noise_rad_s));
    let rate = Some(run.spacecraft.rate_rad_s.into());
    vector(|axis| format!("drawn_rate_{axis}_rad_s"), rate, visit);
    visit("drawn_wheels".to_owned(), Some(run.wheels.len() as f64));
    for index in 0..wheels {
        let (number, wheel) = (index + 1, run.wheels.get(index));
        let axis = wheel.map(|wheel| wheel.wheel.axis.into());
        vector(|axis| format!("drawn_wheel_{number}_axis_{axis}"), axis, visit);
        let inertia = wheel.map(|wheel| wheel.wheel.spin_inertia_kg_m2);
        visit(format!("drawn_wheel_{number}_spin_inertia_kg_m2"), inertia);
        visit(format!("drawn_wheel_{number}_speed_rad_s"), wheel.map(|wheel| wheel.speed_rad_s));
    }
}

/// Errors of gyro and clock.
fn gyro(stated: &StatedHardware, run: &Scenario, visit: &mut Visit<'_>) {
    let errors = &run.true_hardware.gyro;
    if stated.gyro_scale_sigma != 0.0 {
        vector(|axis| format!("drawn_gyro_scale_{axis}"), Some(errors.scale.into()), visit);
    }
    if stated.gyro_axes_sigma_rad != 0.0 {
        for (pair, angle_rad) in PAIRS.iter().zip(errors.axes_rad) {
            visit(format!("drawn_gyro_axes_{pair}_rad"), Some(angle_rad));
        }
    }
    let scalars = [
        ("drawn_gyro_delay_s", stated.gyro_delay_sigma_s, errors.delay_s),
        ("drawn_gyro_noise_factor", stated.gyro_noise_tolerance, errors.noise_factor),
        ("drawn_clock_drift", stated.clock_sigma, run.true_hardware.clock.drift),
    ];
    for (name, _, value) in scalars.into_iter().filter(|(_, sigma, _)| *sigma != 0.0) {
        visit(name.to_owned(), Some(value));
    }
    if stated.bias_sigma_rad_s.is_some() {
        let bias = Some(run.gyro.bias_rad_s.into());
        vector(|axis| format!("drawn_gyro_bias_{axis}_rad_s"), bias, visit);
    }
}

/// Disturbance torque, and the scale of the external torque.
fn disturbances(stated: &StatedHardware, run: &Scenario, visit: &mut Visit<'_>) {
    if stated.torque_sigma_n_m.is_some() {
        let torque = Some(run.disturbance_torque_n_m.into());
        vector(|axis| format!("drawn_disturbance_torque_{axis}_n_m"), torque, visit);
    }
    if stated.torque_scale_sigma != 0.0 {
        visit("drawn_torque_scale".to_owned(), Some(run.true_hardware.torque_scale));
    }
}

/// Errors of spin inertias, share, and of axes.
fn wheel_errors(stated: &StatedHardware, run: &Scenario, wheels: usize, visit: &mut Visit<'_>) {
    let errors = &run.true_hardware;
    if stated.common_spin_inertia_sigma != 0.0 {
        visit("drawn_common_spin_inertia".to_owned(), Some(errors.common_spin_inertia));
    }
    let any = |sigmas: &[f64]| sigmas.iter().any(|sigma| *sigma != 0.0);
    for index in 0..wheels {
        let number = index + 1;
        let wheel = (index < run.wheels.len()).then(|| errors.wheel(index));
        if any(&stated.wheel_spin_inertia_sigma) {
            let share = wheel.map(|wheel| wheel.spin_inertia);
            visit(format!("drawn_wheel_{number}_spin_inertia"), share);
        }
        if any(&stated.wheel_axis_sigma_rad) {
            for tilt in 0..2 {
                let angle_rad = wheel.map(|wheel| wheel.axis_rad[tilt]);
                visit(format!("drawn_wheel_{number}_tilt_{}_rad", tilt + 1), angle_rad);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_has_a_value_for_each_name() {
        for (name, expected) in [
            ("cubesat-pyramid", vec![]),
            ("bellar-2019-campaign", vec!["drawn_initial_rate_x_rad_s", "drawn_initial_jyz_kg_m2"]),
            ("random-spacecraft", vec!["drawn_duration_s", "drawn_wheel_4_speed_rad_s"]),
            ("cubesat-pyramid-data-sheet", vec!["drawn_gyro_scale_x", "drawn_wheel_4_tilt_2_rad"]),
            ("random-spacecraft-data-sheet", vec!["drawn_wheels", "drawn_wheel_1_spin_inertia"]),
        ] {
            let scenario = Scenario::load(name).unwrap();
            let names = scenario.drawn_names();
            assert_eq!(names.is_empty(), expected.is_empty(), "{name}: {names:?}");
            for wanted in expected {
                assert!(names.iter().any(|name| name == wanted), "{name}: {names:?}");
            }
            for seed in 0..5 {
                assert_eq!(scenario.drawn_values(seed).len(), names.len(), "{name}");
            }
            if !names.is_empty() {
                assert_ne!(scenario.drawn_values(3), scenario.drawn_values(4), "{name}");
            }
            let mut distinct = names.clone();
            distinct.sort_unstable();
            distinct.dedup();
            assert_eq!(distinct.len(), names.len(), "{name}");
        }
    }

    #[test]
    fn values_are_those_of_the_scenario_that_flies() {
        let scenario = Scenario::load("cubesat-pyramid-data-sheet").unwrap();
        let at = scenario.drawn_names().iter().position(|name| name == "drawn_gyro_scale_y");
        let found = scenario.drawn_values(7)[at.unwrap()];
        assert_eq!(found, Some(scenario.of_seed(7).true_hardware.gyro.scale.y));
    }
}
