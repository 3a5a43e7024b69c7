//! Test of the simulator against the closed solution of torque-free motion.
//!
//! Principal moments `A < B < C`, energy `2E = A p² + B q² + C r²`, momentum
//! `M² = A² p² + B² q² + C² r²`. For `M² > 2 E B`, with the Jacobi elliptic functions of modulus `k`:
//!
//! ```text
//! p = √((2EC − M²) / (A (C − A))) cn τ
//! q = √((2EC − M²) / (B (C − B))) sn τ
//! r = √((M² − 2EA) / (C (C − A))) dn τ
//! τ = τ₀ + t √((C − B)(M² − 2EA) / (ABC)),   k² = (B − A)(2EC − M²) / ((C − B)(M² − 2EA))
//! ```
//!
//! Source: L. D. Landau, E. M. Lifshitz, *Mechanics*, 3rd edition, 1976, section 37. Case: the tumbling
//! brick of the simulation check cases of the NASA Engineering and Safety Center, case 2.

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::flight::Flight;
use crate::input::Scenario;

/// Principal moments of the brick, slug ft².
const BRICK_SLUG_FT2: [f64; 3] = [0.001_894_220, 0.006_211_019, 0.007_194_665];
/// One slug ft², kg m²: 1 lbf ft s² with 0.3048 m and 4.448 221 615 260 5 N.
const KG_M2_PER_SLUG_FT2: f64 = 0.3048 * 4.448_221_615_260_5;
/// Rates at the start, deg/s.
const RATE_DEG_S: [f64; 3] = [10.0, 20.0, 30.0];
/// Duration: twenty times that of the check case, s.
const DURATION_S: f64 = 600.0;
/// Largest difference of a rate from the closed solution, rad/s: 6,000 steps between samples, each
/// with a relative tolerance of 1e-12.
const MAX_DIFFERENCE_RAD_S: f64 = 1e-11;

/// Amplitude `am`, `sn`, `cn` and `dn` of `u` for modulus `k`, by the arithmetic-geometric mean:
/// M. Abramowitz, I. A. Stegun,
/// *Handbook of Mathematical Functions*, 1964, 16.4.
fn jacobi(u: f64, k: f64) -> [f64; 4] {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    let mut ratios = Vec::new();
    let mut scale = 1.0;
    while a - b > f64::EPSILON * a {
        let (mean, difference) = (0.5 * (a + b), 0.5 * (a - b));
        (b, a) = ((a * b).sqrt(), mean);
        ratios.push(difference / mean);
        scale *= 2.0;
    }
    let amplitude = ratios
        .iter()
        .rev()
        .fold(scale * a * u, |phase, ratio| 0.5 * (phase + (ratio * phase.sin()).asin()));
    let (sn, cn) = amplitude.sin_cos();
    [amplitude, sn, cn, (1.0 - (k * sn).powi(2)).sqrt()]
}

/// Closed solution of one motion.
struct Solution {
    /// Factors of cn, sn and dn, rad/s.
    amplitude_rad_s: Vector3<f64>,
    frequency_rad_s: f64,
    modulus: f64,
    phase: f64,
}

impl Solution {
    /// Solution of these principal moments, kg m², that starts from these positive rates.
    fn new(moments: [f64; 3], rate_rad_s: [f64; 3]) -> Self {
        let [a, b, c] = moments;
        let momenta = std::array::from_fn::<_, 3, _>(|i| moments[i] * rate_rad_s[i]);
        let square = momenta.iter().map(|h| h * h).sum::<f64>();
        let energy = (0..3).map(|i| momenta[i] * rate_rad_s[i]).sum::<f64>();
        assert!(square > energy * b, "the rate circles the axis of the largest moment");
        let (high, low) = (energy * c - square, square - energy * a);
        let amplitude_rad_s =
            Vector3::new(high / (a * (c - a)), high / (b * (c - b)), low / (c * (c - a)))
                .map(f64::sqrt);
        let modulus = ((b - a) * high / ((c - b) * low)).sqrt();
        // am(τ₀) from sn and cn, then τ₀ by Newton: the derivative of am is dn.
        let start = (rate_rad_s[1] / amplitude_rad_s.y).atan2(rate_rad_s[0] / amplitude_rad_s.x);
        let mut phase = start;
        for _ in 0..10 {
            let [amplitude, _, _, dn] = jacobi(phase, modulus);
            phase -= (amplitude - start) / dn;
        }
        let frequency_rad_s = ((c - b) * low / (a * b * c)).sqrt();
        Self { amplitude_rad_s, frequency_rad_s, modulus, phase }
    }

    fn rate_rad_s(&self, time_s: f64) -> Vector3<f64> {
        let [_, sn, cn, dn] = jacobi(self.phase + self.frequency_rad_s * time_s, self.modulus);
        self.amplitude_rad_s.component_mul(&Vector3::new(cn, sn, dn))
    }
}

/// The brick in body axes that are turned from its principal axes by `turn`.
fn brick(turn: &Rotation3<f64>) -> Scenario {
    let moments = BRICK_SLUG_FT2.map(|moment| moment * KG_M2_PER_SLUG_FT2);
    let tensor = turn * Matrix3::from_diagonal(&moments.into()) * turn.transpose();
    let rate = turn * Vector3::from(RATE_DEG_S.map(f64::to_radians));
    let elements = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| tensor[at]);
    let text = format!(
        "name = 'brick'\nduration_s = {DURATION_S:?}\n[spacecraft]\ninertia_kg_m2 = {elements:?}\n\
         rate_rad_s = {:?}\n[gyro]\nrate_hz = 10\nnoise_rad_s = 1e-6\n",
        rate.as_slice()
    );
    Scenario::from_toml("brick.toml", &text, Path::new("")).unwrap()
}

#[test]
fn tumbling_brick_follows_the_closed_solution_in_any_body_axes() {
    let moments = BRICK_SLUG_FT2.map(|moment| moment * KG_M2_PER_SLUG_FT2);
    let exact = Solution::new(moments, RATE_DEG_S.map(f64::to_radians));
    for turn in [Rotation3::identity(), Rotation3::from_euler_angles(0.4, -1.1, 2.3)] {
        let flight = Flight::simulate(&brick(&turn)).unwrap();
        assert_eq!(flight.instants.len(), 6001);
        let differences = flight.instants.iter().map(|instant| {
            let expected = turn * exact.rate_rad_s(instant.time_us as f64 * 1e-6);
            (instant.rate_rad_s - expected).amax()
        });
        let largest = differences.fold(0.0, f64::max);
        assert!(largest < MAX_DIFFERENCE_RAD_S, "{largest:e} rad/s");
    }
}

#[test]
fn elliptic_functions_have_their_tabulated_values() {
    // u = 0.5 and k² = 0.5.
    let [_, sn, cn, dn] = jacobi(0.5, 0.5f64.sqrt());
    for (found, expected) in [
        (sn, 0.470_750_473_655_657_3),
        (cn, 0.882_266_394_890_440_3),
        (dn, 0.942_972_425_777_385_7),
    ] {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
    // Without modulus: the circular functions; after a period of 4 K: the start.
    assert!((jacobi(1.0, 0.0)[1] - 1.0f64.sin()).abs() < 1e-15);
    let quarter = 1.854_074_677_301_371_8; // K for k² = 0.5
    assert!(jacobi(4.0 * quarter, 0.5f64.sqrt())[1].abs() < 1e-14);
}
