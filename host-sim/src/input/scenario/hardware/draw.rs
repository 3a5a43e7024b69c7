//! True errors of one run: the fixed ones of the scenario plus draws from the stated sigmas.
//!
//! | error | distribution about the fixed value |
//! |---|---|
//! | gyro scale, axes, delay; wheel inertia, axes; torque scale; bias; torque | normal, of the stated sigma |
//! | gyro noise | log-normal factor `exp(σ ν)`, `ν` standard normal |
//! | axis of a mode that gives none | uniform over directions |
//!
//! All numbers are drawn whether used or not: a seed gives the same numbers whichever errors are
//! stated.

use flight_input::craft::MAX_WHEELS;
use flight_input::craft::hardware::{Tachometer, TachometerKind};
use nalgebra::{Unit, Vector3};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::super::definition::Scenario;

/// Offset into the random sequence of a seed, beyond gyro noise and initial estimate.
const BEYOND_THE_INITIAL_ESTIMATE: u128 = 2 << 64;

/// Standard normal numbers of a run.
struct Draws {
    scale: [f64; 3],
    axes: [f64; 6],
    delay: f64,
    noise: f64,
    bias: [f64; 3],
    torque: [f64; 3],
    torque_scale: f64,
    common_spin_inertia: f64,
    wheels: [[f64; 3]; MAX_WHEELS],
    random: Pcg64,
}

impl Draws {
    fn of(seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        random.advance(BEYOND_THE_INITIAL_ESTIMATE);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        Self {
            scale: std::array::from_fn(|_| normal()),
            axes: std::array::from_fn(|_| normal()),
            delay: normal(),
            noise: normal(),
            bias: std::array::from_fn(|_| normal()),
            torque: std::array::from_fn(|_| normal()),
            torque_scale: normal(),
            common_spin_inertia: normal(),
            wheels: std::array::from_fn(|_| std::array::from_fn(|_| normal())),
            random,
        }
    }

    /// A further number.
    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// A direction, uniform over the sphere.
    fn direction(&mut self) -> Unit<Vector3<f64>> {
        let vector = Vector3::from_fn(|_, _| StandardNormal.sample(&mut self.random));
        Unit::new_normalize(vector)
    }
}

impl Scenario {
    /// The scenario with the true hardware of the run with this seed.
    pub(in super::super) fn with_drawn_hardware(mut self, seed: u64) -> Self {
        if self.hardware.is_ideal() && self.true_hardware == Default::default() {
            return self;
        }
        let mut draws = Draws::of(seed);
        let (stated, errors) = (&self.hardware, &mut self.true_hardware);
        let gyro = &mut errors.gyro;
        gyro.scale += Vector3::from(draws.scale) * stated.gyro_scale_sigma;
        for (axis, draw) in gyro.axes_rad.iter_mut().zip(draws.axes) {
            *axis += draw * stated.gyro_axes_sigma_rad;
        }
        gyro.delay_s += stated.gyro_delay_s + draws.delay * stated.gyro_delay_sigma_s;
        gyro.flicker_rad_s = gyro.flicker_rad_s.hypot(stated.bias_instability_rad_s);
        gyro.averaged |= stated.gyro_averaged;
        gyro.noise_factor *= (draws.noise * stated.gyro_noise_tolerance).exp();
        let bias_sigma = stated.bias_sigma_rad_s.unwrap_or(0.0);
        self.gyro.bias_rad_s += Vector3::from(draws.bias) * bias_sigma;
        let torque_sigma = stated.torque_sigma_n_m.unwrap_or(0.0);
        self.disturbance_torque_n_m += Vector3::from(draws.torque) * torque_sigma;
        errors.torque_scale += draws.torque_scale * stated.torque_scale_sigma;
        errors.common_spin_inertia += draws.common_spin_inertia * stated.common_spin_inertia_sigma;
        errors.wheels.resize(self.wheels.len(), Default::default());
        for (index, (wheel, draw)) in errors.wheels.iter_mut().zip(draws.wheels).enumerate() {
            let sigma = |sigmas: &[f64]| sigmas.get(index).copied().unwrap_or(0.0);
            wheel.spin_inertia += draw[0] * sigma(&stated.wheel_spin_inertia_sigma);
            let tilt = sigma(&stated.wheel_axis_sigma_rad);
            wheel.axis_rad[0] += draw[1] * tilt;
            wheel.axis_rad[1] += draw[2] * tilt;
        }
        for mode in &mut errors.modes {
            let drawn = draws.direction();
            mode.axis.get_or_insert(drawn);
        }
        if stated.clock_sigma > 0.0 {
            errors.clock.drift += draws.normal() * stated.clock_sigma;
        }
        self
    }

    /// True if the motion differs from run to run by its drawn hardware.
    pub fn draws_motion(&self) -> bool {
        let stated = &self.hardware;
        let any = |sigmas: &[f64]| sigmas.iter().any(|sigma| *sigma != 0.0);
        stated.torque_sigma_n_m.is_some()
            || stated.torque_scale_sigma != 0.0
            || stated.common_spin_inertia_sigma != 0.0
            || any(&stated.wheel_spin_inertia_sigma)
            || any(&stated.wheel_axis_sigma_rad)
            || self.true_hardware.modes.iter().any(|mode| mode.axis.is_none())
    }

    /// True if a reading depends on the motion between the samples, in any run.
    pub fn needs_trajectory(&self) -> bool {
        let stated = &self.hardware;
        stated.gyro_delay_s != 0.0
            || stated.gyro_delay_sigma_s != 0.0
            || stated.gyro_averaged
            || self.true_hardware.needs_trajectory()
            || self.tachometers().any(|it| it.kind != TachometerKind::Speed || it.latency_s != 0.0)
    }

    /// True tachometer of each wheel: that of `[hardware]`, or the stated one.
    pub fn tachometers(&self) -> impl Iterator<Item = Tachometer> + '_ {
        let of_all = self.true_hardware.tachometer;
        let is_ideal = of_all == Tachometer::default();
        let stated = |wheel: usize| self.hardware.tachometers.get(wheel).copied();
        (0..self.wheels.len())
            .map(move |wheel| stated(wheel).filter(|_| is_ideal).unwrap_or(of_all))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const STATED: &str = r#"name = "test"
duration_s = 60.0
[spacecraft]
inertia_kg_m2 = [3, 4, 5, 0, 0, 0]
[[wheel]]
axis = [0, 0, 1]
spin_inertia_kg_m2 = 1e-3
[[wheel]]
axis = [1, 0, 0]
spin_inertia_kg_m2 = 1e-3
spin_inertia_sigma = 0.03
[wheels]
spin_inertia_sigma = 0.01
axis_sigma_deg = 0.2
[gyro]
rate_hz = 10.0
noise_rad_s = 1e-4
scale_sigma = 0.005
axes_sigma_deg = 0.1
delay_s = 0.02
delay_sigma_s = 0.002
bias_sigma_rad_s = 1e-3
noise_tolerance = 0.2
[disturbance]
torque_sigma_n_m = 1e-5
[hardware]
gyro = { scale = [0.1, 0, 0] }
[[hardware.mode]]
frequency_hz = 0.5
damping = 0.01
inertia_share = 0.03
"#;

    fn scenario() -> Scenario {
        Scenario::from_toml("s.toml", STATED, Path::new("")).unwrap()
    }

    /// Mean and standard deviation of a quantity over seeds.
    fn spread(of: impl Fn(&Scenario) -> f64) -> (f64, f64) {
        let (scenario, count) = (scenario(), 2000);
        let values: Vec<f64> = (0..count).map(|seed| of(&scenario.of_seed(seed))).collect();
        let mean = values.iter().sum::<f64>() / count as f64;
        let square = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count as f64;
        (mean, square.sqrt())
    }

    #[test]
    fn each_error_has_its_stated_sigma_about_its_fixed_value() {
        let degree = 1f64.to_radians();
        for (name, found, mean, sigma) in [
            ("scale", spread(|s| s.true_hardware.gyro.scale.x), 0.1, 0.005),
            ("axes", spread(|s| s.true_hardware.gyro.axes_rad[5]), 0.0, 0.1 * degree),
            ("delay", spread(|s| s.true_hardware.gyro.delay_s), 0.02, 0.002),
            ("noise", spread(|s| s.true_hardware.gyro.noise_factor.ln()), 0.0, 0.2),
            ("bias", spread(|s| s.gyro.bias_rad_s.y), 0.0, 1e-3),
            ("torque", spread(|s| s.disturbance_torque_n_m.z), 0.0, 1e-5),
            ("first wheel", spread(|s| s.true_hardware.wheels[0].spin_inertia), 0.0, 0.01),
            ("second wheel", spread(|s| s.true_hardware.wheels[1].spin_inertia), 0.0, 0.03),
            ("tilt", spread(|s| s.true_hardware.wheels[1].axis_rad[1]), 0.0, 0.2 * degree),
        ] {
            // Five sigma of a mean and of a standard deviation over 2,000 draws.
            assert!((found.0 - mean).abs() < 5.0 * sigma / 2000f64.sqrt(), "{name}: {found:?}");
            assert!((found.1 / sigma - 1.0).abs() < 5.0 / 4000f64.sqrt(), "{name}: {found:?}");
        }
    }

    #[test]
    fn run_is_determined_by_its_seed_and_the_craft_by_the_statement() {
        let scenario = scenario();
        assert_eq!(scenario.of_seed(3), scenario.of_seed(3));
        assert_ne!(scenario.of_seed(3), scenario.of_seed(4));
        assert_eq!(scenario.of_seed(3).craft(), scenario.craft());
        assert!(scenario.craft().solve_for.torque && scenario.craft().solve_for.gyro_bias);
        assert!(scenario.draws_motion() && scenario.needs_trajectory());
        assert!(scenario.of_seed(3).true_hardware.modes[0].axis.is_some());
    }

    #[test]
    fn draw_of_one_error_is_independent_of_the_others() {
        let alone = STATED.replace("scale_sigma = 0.005\n", "");
        let alone = Scenario::from_toml("s.toml", &alone, Path::new("")).unwrap().of_seed(3);
        let both = scenario().of_seed(3);
        assert_eq!(alone.true_hardware.gyro.axes_rad, both.true_hardware.gyro.axes_rad);
        assert_eq!(alone.true_hardware.modes, both.true_hardware.modes);
    }

    #[test]
    fn each_bad_value_is_reported() {
        for (good, bad, expected) in [
            ("[0.1, 0, 0]", "[0.1, 0]", "`hardware.gyro.scale` has 2 entries, but takes 3"),
            ("share = 0.03", "share = 0.7", "`hardware.mode[1].inertia_share` is 0.7; it must"),
            ("damping = 0.01", "damping = 1", "`hardware.mode[1].damping` is 1; it must be zero"),
            ("scale = [", "scales = [", "unknown key `scales` (did you mean `scale`?)"),
            (
                "[[hardware.mode]]",
                "wheel = [{}, {}, {}]\n[[hardware.mode]]",
                "3 [[hardware.wheel]] tables, but 2 wheels",
            ),
        ] {
            let text = STATED.replacen(good, bad, 1);
            let message = Scenario::from_toml("s.toml", &text, Path::new("")).unwrap_err();
            assert!(message.to_string().contains(expected), "{message}");
        }
    }
}
