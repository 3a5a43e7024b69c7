//! The build script's constant of a craft file: bits of the values, and rejections with key and
//! remedy.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

#[path = "../build/craft.rs"]
mod craft;

use flight_input::Craft;

const GOOD: &str = "[[wheel]]\naxis = [0, 0, 2]\nspin_inertia_kg_m2 = 2.1e-5\n\
                    [gyro]\nnoise_rad_s = 1e-4\n";
const CAPACITY: usize = 4;

fn source(text: &str) -> Result<String, String> {
    craft::source(&Craft::from_toml("craft.toml", text).unwrap(), CAPACITY)
}

#[test]
fn values_are_emitted_as_single_precision_bits() {
    let source = source(GOOD).unwrap();
    for value in [1.0, 2.1e-5, 1e-4] {
        let bits = format!("f32::from_bits({:#010x})", (value as f32).to_bits());
        assert!(source.contains(&bits), "{value}: {source}");
    }
    assert!(source.contains("Craft<4>") && source.contains("prior: None"), "{source}");
}

#[test]
fn keys_without_a_counterpart_are_rejected() {
    for (text, expected) in [
        ("range_rad_s = 4", "`gyro.range_rad_s` has no counterpart in the image; remove it"),
        ("quantum_rad_s = 1e-5", "`gyro.quantum_rad_s` has no counterpart in the image"),
        ("[filter]\nrate_walk_rad_s_sqrt_s = 0", "`filter.rate_walk_rad_s_sqrt_s` has no"),
        ("[filter]\ninertia_walk_kg_m2_sqrt_hour = 1", "`filter.inertia_walk_kg_m2_sqrt_hour` has"),
        ("[filter]\ntorque_is_smooth = true", "`filter.torque_is_smooth` has no counterpart"),
        ("[disturbance]\ntorque = true", "`disturbance.torque` has no counterpart"),
        ("[disturbance]\ngyro_bias = true", "`disturbance.gyro_bias` has no counterpart"),
    ] {
        let message = source(&format!("{GOOD}{text}\n")).unwrap_err();
        assert!(message.starts_with(expected), "{message}\n  expected: {expected}");
    }
}

#[test]
fn stated_hardware_is_emitted_and_absent_wheels_have_none() {
    let text = format!(
        "{GOOD}scale_sigma = 0.003\ndelay_sigma_s = 0.002\n[wheels]\nspin_inertia_sigma = 0.02\n"
    );
    let source = source(&text).unwrap();
    let bits = |value: f32| format!("f32::from_bits({:#010x})", value.to_bits());
    for expected in [
        format!("gyro_scale: {}", bits(0.003)),
        format!("delay_sigma_s: {}", bits(0.002)),
        format!("wheel_inertia: [{}, {1}, {1}, {1}]", bits(0.02), bits(0.0)),
        // The data sheet's value of an absent key.
        format!("gyro_axes_rad: {}", bits(0.1f64.to_radians() as f32)),
    ] {
        assert!(source.contains(&expected), "{expected}: {source}");
    }
}

#[test]
fn absent_gyro_noise_is_rejected() {
    let message = source(&GOOD.replace("noise_rad_s = 1e-4", "")).unwrap_err();
    assert!(message.starts_with("missing key `gyro.noise_rad_s`: "), "{message}");
}

#[test]
fn surplus_wheels_are_rejected() {
    let wheel = &GOOD[..GOOD.find("[gyro]").unwrap()];
    let message = source(&format!("{}{GOOD}", wheel.repeat(CAPACITY))).unwrap_err();
    assert_eq!(message, "5 [[wheel]] tables, but the image has 4; remove some");
}

#[test]
fn values_beyond_single_precision_are_rejected() {
    for (good, bad, expected) in [
        ("2.1e-5", "1e-60", "`wheel[1]` in single precision: "),
        ("1e-4", "1e-60", "`gyro` in single precision: "),
    ] {
        let message = source(&GOOD.replace(good, bad)).unwrap_err();
        assert!(message.starts_with(expected), "{message}");
    }
    let prior =
        "[prior]\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\nsigma_kg_m2 = [1, 1, 1, 1, 1, 1e60]\n";
    let message = source(&format!("{GOOD}{prior}")).unwrap_err();
    assert!(message.starts_with("`prior` in single precision: "), "{message}");
}

#[test]
fn craft_file_of_a_simulated_flight_is_accepted() {
    let text = Craft::from_toml("craft.toml", GOOD).unwrap().to_toml();
    assert_eq!(source(&text), source(GOOD));
}
