//! Interpolated wheel speeds: their error as an uncertain time offset between gyro and wheels.

use flight_input::log::Interpolation;

use super::Craft;

/// Adds the error of the interpolation to the stated sigma of the time offset, and returns a note.
///
/// With `e` the error of the speeds, one sigma, and `Ω̇` their rate of change, RMS, an offset of
/// `d = √(Σ (Iₛ e)² / Σ (Iₛ Ω̇)²)` makes the momentum of the wheels wrong by as much: the sums are over
/// the wheels of spin inertia `Iₛ`. None for wheels of constant speed.
pub fn add_error(craft: &mut Craft, interpolation: &Interpolation) -> Option<String> {
    let inertia = craft.wheels.iter().map(|wheel| wheel.spin_inertia_kg_m2);
    let square = |values: &[f64]| -> f64 {
        inertia.clone().zip(values).map(|(inertia, value)| (inertia * value).powi(2)).sum()
    };
    let error = square(&interpolation.sigma_rad_s);
    let slope = square(&interpolation.slope_rad_s2);
    if error == 0.0 || slope == 0.0 {
        return None;
    }
    let offset_s = (error / slope).sqrt();
    let stated = craft.hardware.gyro_delay_sigma_s;
    craft.hardware.gyro_delay_sigma_s = stated.hypot(offset_s);
    Some(format!(
        "the error of the interpolated wheel speeds is in the sigma, as a time offset of {:.2e} s beside \
         gyro.delay_sigma_s, {stated} s",
        offset_s
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_gives_the_error_of_the_momentum() {
        let wheel = "[[wheel]]\naxis = [1, 0, 0]\nspin_inertia_kg_m2 = 1e-3\n";
        let text = format!("{wheel}{wheel}[gyro]\ndelay_sigma_s = 0.003\n");
        let mut craft = Craft::from_toml("craft.toml", &text).unwrap();
        let interpolation = Interpolation {
            sigma_rad_s: vec![0.04, 0.0],
            slope_rad_s2: vec![6.0, 8.0],
            period_s: 1.0,
        };
        assert!(add_error(&mut craft, &interpolation).unwrap().contains("offset of 4.00e-3 s"));
        assert!((craft.hardware.gyro_delay_sigma_s - 0.005).abs() < 1e-15);
    }
}
