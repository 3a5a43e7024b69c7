//! Interpolated wheel speeds: their error as noise of the gyro.

use flight_input::log::Interpolation;
use nalgebra::Matrix3;

use super::Craft;

/// White noise of the rate, one sigma per sample and axis, rad/s, that has the effect of the
/// interpolation's error; none for a singular tensor.
///
/// An error `e` of the wheel speeds, one sigma, is one of the momentum, and shows in the rate as
/// `δω = J⁻¹ Σ aᵢ Iₛᵢ eᵢ`, with the axis `a` and the spin inertia `Iₛ` of each wheel. Its mean square over the axes
/// is `tr(J⁻¹ C J⁻¹) / 3`, `C = Σ aᵢ aᵢᵀ (Iₛᵢ eᵢ)²`. Assumption: the error is common to the `n` samples of one
/// interval between readings. White noise of `√n` times its size has the same mean over them.
pub fn rate_noise_rad_s(
    craft: &Craft,
    interpolation: &Interpolation,
    inertia_kg_m2: &Matrix3<f64>,
    sample_period_s: f64,
) -> Option<f64> {
    let inverse = inertia_kg_m2.try_inverse()?;
    let errors = craft.wheels.iter().zip(&interpolation.sigma_rad_s);
    let momentum: Matrix3<f64> = errors
        .map(|(wheel, sigma)| {
            wheel.axis * wheel.axis.transpose() * (wheel.spin_inertia_kg_m2 * sigma).powi(2)
        })
        .sum();
    let square = (inverse * momentum * inverse.transpose()).trace() / 3.0;
    let samples = (interpolation.period_s / sample_period_s).max(1.0);
    let noise = (square * samples).sqrt();
    noise.is_finite().then_some(noise)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_that_of_the_momentum_over_the_inertia() {
        let wheel = |axis: &str| format!("[[wheel]]\naxis = {axis}\nspin_inertia_kg_m2 = 1e-3\n");
        let text = ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"].map(wheel).concat();
        let craft = Craft::from_toml("craft.toml", &text).unwrap();
        let interpolation = Interpolation {
            sigma_rad_s: vec![0.5, 0.5, 0.5],
            period_s: 0.9,
            left_out: vec![0; 3],
            assumed: Vec::new(),
        };
        let inertia = Matrix3::from_diagonal_element(2.0);
        let noise = rate_noise_rad_s(&craft, &interpolation, &inertia, 0.1).unwrap();
        assert!((noise - 3.0 * 0.5e-3 / 2.0).abs() < 1e-15, "{noise}");
        assert_eq!(rate_noise_rad_s(&craft, &interpolation, &Matrix3::zeros(), 0.1), None);
    }
}
