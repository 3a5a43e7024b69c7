//! A craft file, from its values to Rust source.
//!
//! Decimal text is parsed as f64, rounded to f32 once, and emitted as exact bits: the constant holds
//! the numbers of `host-sim replay --precision f32` for the same file.

use flight_input::Craft;
use fsw_core::estimator::window;
use fsw_core::{Vec3, WheelArray};
use std::fmt::Write as _;

/// A craft file that the image cannot take: the fault and the remedy.
type Rejection = String;

/// The Rust source of `CRAFT`, a constant with `capacity` wheels. An absent wheel is one about z without
/// spin inertia.
///
/// # Errors
/// More than `capacity` wheels, an absent gyro noise, a key without a counterpart in the image, or a value
/// that the estimators reject in f32.
pub fn source(craft: &Craft, capacity: usize) -> Result<String, Rejection> {
    check_keys(craft, capacity)?;
    let noise_rad_s = craft.gyro.noise_rad_s.ok_or(
        "missing key `gyro.noise_rad_s`: the image does not estimate the noise; add it from the data \
         sheet, one sigma per sample",
    )?;
    check_values(craft, noise_rad_s)?;
    let missing = capacity - craft.wheels.len();
    let axes = craft.wheels.iter().map(|wheel| floats(wheel.axis.as_slice()));
    let axes: Vec<_> = axes.chain(vec![floats(&[0.0, 0.0, 1.0]); missing]).collect();
    let spin_inertia = craft.wheels.iter().map(|wheel| wheel.spin_inertia_kg_m2);
    let spin_inertia: Vec<_> = spin_inertia.chain(vec![0.0; missing]).collect();
    let prior = craft.prior.as_ref().map_or("None".to_owned(), |prior| {
        let (inertia, sigma) = (floats(&prior.inertia_kg_m2), floats(&prior.sigma_kg_m2));
        format!("Some(Prior {{ inertia_kg_m2: {inertia}, sigma_kg_m2: {sigma} }})")
    });

    let mut source =
        format!("/// The spacecraft.\npub const CRAFT: Craft<{capacity}> = Craft {{\n");
    for (field, value) in [
        ("wheel_axes", format!("[{}]", axes.join(", "))),
        ("spin_inertia_kg_m2", floats(&spin_inertia)),
        ("gyro_noise_rad_s", float(noise_rad_s)),
        ("hardware", hardware_source(craft, capacity)),
        ("prior", prior),
    ] {
        writeln!(source, "    {field}: {value},").map_err(|error| error.to_string())?;
    }
    Ok(source + "};\n")
}

/// The errors of the hardware as Rust source. An absent wheel has none.
fn hardware_source(craft: &Craft, capacity: usize) -> String {
    let stated = &craft.hardware;
    let of_wheels = |sigma: &[f64]| {
        let all: Vec<_> =
            sigma.iter().copied().chain(std::iter::repeat(0.0)).take(capacity).collect();
        floats(&all)
    };
    let has_wheels = !craft.wheels.is_empty();
    let common = if has_wheels { stated.common_spin_inertia_sigma } else { 0.0 };
    let fields = [
        ("gyro_scale", float(stated.gyro_scale_sigma)),
        ("gyro_axes_rad", float(stated.gyro_axes_sigma_rad)),
        ("delay_s", float(stated.gyro_delay_s)),
        ("delay_sigma_s", float(stated.gyro_delay_sigma_s)),
        ("wheel_inertia", of_wheels(&stated.wheel_spin_inertia_sigma)),
        ("wheel_axis_rad", of_wheels(&stated.wheel_axis_sigma_rad)),
        ("common_wheel_inertia", float(common)),
        ("torque_scale", float(stated.torque_scale_sigma)),
        ("clock", float(stated.clock_sigma)),
        ("mount_rad", floats(&stated.mount_sigma_rad)),
    ];
    let fields: Vec<_> = fields.iter().map(|(field, value)| format!("{field}: {value}")).collect();
    format!("Hardware {{ {} }}", fields.join(", "))
}

/// Rejects keys without a counterpart in the image.
fn check_keys(craft: &Craft, capacity: usize) -> Result<(), Rejection> {
    let wheels = craft.wheels.len();
    if wheels > capacity {
        return Err(format!(
            "{wheels} [[wheel]] tables, but the image has {capacity}; remove some"
        ));
    }
    let image_has_none = [
        ("gyro.range_rad_s", craft.gyro.range_rad_s.is_some()),
        ("gyro.quantum_rad_s", craft.gyro.quantum_rad_s.is_some()),
        ("filter.rate_walk_rad_s_sqrt_s", craft.filter.rate_walk_rad_s_sqrt_s.is_some()),
        (
            "filter.inertia_walk_kg_m2_sqrt_hour",
            craft.filter.inertia_walk_kg_m2_sqrt_hour.is_some(),
        ),
        ("filter.torque_is_smooth", craft.filter.is_torque_smooth),
        ("gyro.scale", craft.hardware.gyro_scale != [0.0; 3]),
        ("gyro.axes_deg", craft.hardware.gyro_axes_rad != [0.0; 6]),
        ("gyro.averaged", craft.hardware.gyro_averaged),
        ("gyro.bias_sigma_rad_s", craft.hardware.bias_sigma_rad_s.is_some()),
        ("gyro.bias_walk_rad_s_sqrt_s", craft.hardware.bias_walk_rad_s_sqrt_s != 0.0),
        ("gyro.bias_instability_rad_s", craft.hardware.bias_instability_rad_s != 0.0),
        ("disturbance.varying_torque_sigma_n_m", craft.hardware.varying_torque_sigma_n_m != 0.0),
        ("disturbance.torque_sigma_n_m", craft.hardware.torque_sigma_n_m.is_some()),
        ("mode", !craft.hardware.modes.is_empty()),
        ("disturbance.torque", craft.solve_for.torque),
        ("disturbance.gyro_bias", craft.solve_for.gyro_bias),
    ];
    match image_has_none.iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => Err(format!("`{key}` has no counterpart in the image; remove it")),
        None => Ok(()),
    }
}

/// Rejects values that the estimators reject in the precision of the image.
fn check_values(craft: &Craft, noise_rad_s: f64) -> Result<(), Rejection> {
    for (index, wheel) in craft.wheels.iter().enumerate() {
        let number = index + 1;
        let axis = Vec3::from(<[f64; 3]>::from(wheel.axis).map(|x| x as f32));
        let spin_inertia_kg_m2 = wheel.spin_inertia_kg_m2 as f32;
        // Zero is the spin inertia of an absent wheel, which the core accepts.
        if spin_inertia_kg_m2 == 0.0 {
            return Err(format!(
                "`wheel[{number}]` in single precision: spin_inertia_kg_m2 rounds to zero; give it in kg m²"
            ));
        }
        WheelArray::new([axis], [spin_inertia_kg_m2])
            .map_err(|why| format!("`wheel[{number}]` in single precision: {why}"))?;
    }
    window::Config::<f32, 0>::new(noise_rad_s as f32)
        .validate::<9, 0, 0>()
        .map_err(|why| format!("`gyro` in single precision: {why}"))?;
    let Some(prior) = &craft.prior else { return Ok(()) };
    let narrow = |values: [f64; 6]| values.map(|x| x as f32);
    fsw_core::Prior {
        inertia_kg_m2: narrow(prior.inertia_kg_m2),
        sigma_kg_m2: narrow(prior.sigma_kg_m2),
    }
    .validate()
    .map_err(|why| format!("`prior` in single precision: {why}"))
}

/// Numbers as an array of exact bits.
pub fn floats(values: &[f64]) -> String {
    let elements: Vec<_> = values.iter().map(|&value| float(value)).collect();
    format!("[{}]", elements.join(", "))
}

fn float(value: f64) -> String {
    format!("f32::from_bits({:#010x})", (value as f32).to_bits())
}
