//! Gyro noise measured from a log, for a craft that doesn't state it.

use crate::input::log::LogRow;

/// One sigma of white noise per sample, rad/s, from third differences of the rates, or `None`
/// where the log is too short or doesn't change at all.
///
/// `z₃ − 3 z₂ + 3 z₁ − z₀` removes any motion that is a parabola over four samples, and has 20
/// times the variance of the noise. The median of its size (0.6745 sigma for a normal
/// distribution) isn't moved by spikes. Coloured noise, such as vibration, is underestimated.
pub fn from_third_differences(rows: &[LogRow]) -> Option<f64> {
    let mut sizes: Vec<f64> = rows
        .windows(4)
        .flat_map(|w| {
            let d = w[3].rate_rad_s - (w[2].rate_rad_s - w[1].rate_rad_s) * 3.0 - w[0].rate_rad_s;
            [d.x.abs(), d.y.abs(), d.z.abs()]
        })
        .collect();
    if sizes.is_empty() {
        return None;
    }
    sizes.sort_by(f64::total_cmp);
    let sigma = sizes[sizes.len() / 2] / 0.6745 / 20.0f64.sqrt();
    (sigma > 0.0).then_some(sigma)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::scenario::Scenario;
    use crate::simulation::log_of;
    use crate::truth::Flight;

    #[test]
    fn finds_the_noise_under_the_motion() {
        let scenario = Scenario::load("cubesat-pyramid").unwrap();
        let log = log_of(&scenario, &Flight::simulate(&scenario).unwrap(), 3);
        let ratio = from_third_differences(&log).unwrap() / scenario.gyro.noise_rad_s;
        // 600 samples a axis: a median of 1,800 correlated values scatters by about 4 %.
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_silent_log_has_no_noise_to_measure() {
        assert_eq!(from_third_differences(&[]), None);
    }
}
