//! Flexible appendages and sloshing liquids: linear oscillators coupled to the rotation of the body.
//!
//! With the modal coordinate `η`, √kg m, and the coupling vector `D`, √(kg m²), of each oscillator
//! (P. W. Likins, *Dynamics and Control of Flexible Space Vehicles*, JPL TR 32-1329, 1970):
//!
//! ```text
//! J_b ω̇ + Σ D η̈ + ω × (J_b ω + Σ hᵢ aᵢ + Σ D η̇) = τ
//! η̈ + 2 ζ Ω η̇ + Ω² η + Dᵀ ω̇ = 0
//! ```
//!
//! `J_b` includes the oscillators at rest. Elimination of `η̈` leaves
//! `(J_b − Σ D Dᵀ) ω̇ = τ + Σ D (2 ζ Ω η̇ + Ω² η) − ω × (…)`. A mode of share `s` about the axis `a` has
//! `D = √(s aᵀ J a) a`.
//!
//! The state has `q = η/√J̄` and its derivative, rad and rad/s, with the mean moment `J̄`, and the
//! coupling `d = D/√J̄`.
//!
//! Assumption: small deflections; the inertia does not change with them.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::input::scenario::hardware::TrueMode;

/// One oscillator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Oscillator {
    /// Coupling `d = D/√J̄`.
    pub coupling: Vector3<f64>,
    /// `Ω`, rad/s.
    pub frequency_rad_s: f64,
    /// `ζ`.
    pub damping: f64,
}

impl Oscillator {
    /// Oscillator on a body of this inertia, kg m², with the mean moment as the unit of inertia. None
    /// if the axis was not drawn.
    pub fn new(
        mode: &TrueMode,
        inertia_kg_m2: &Matrix3<f64>,
        mean_moment_kg_m2: f64,
    ) -> Option<Self> {
        let axis = mode.axis?.into_inner();
        let modal_kg_m2 = mode.inertia_share * axis.dot(&(inertia_kg_m2 * axis));
        Some(Self {
            coupling: axis * (modal_kg_m2 / mean_moment_kg_m2).sqrt(),
            frequency_rad_s: TAU * mode.frequency_hz,
            damping: mode.damping,
        })
    }

    /// `d dᵀ`.
    pub fn inertia(&self) -> Matrix3<f64> {
        self.coupling * self.coupling.transpose()
    }

    /// Force of spring and damper, `2 ζ Ω q̇ + Ω² q`, rad/s².
    pub fn restoring_rad_s2(&self, deflection: f64, velocity: f64) -> f64 {
        let frequency = self.frequency_rad_s;
        2.0 * self.damping * frequency * velocity + frequency * frequency * deflection
    }

    /// `q̈` under this angular acceleration, rad/s².
    pub fn acceleration_rad_s2(
        &self,
        deflection: f64,
        velocity: f64,
        angular_rad_s2: &Vector3<f64>,
    ) -> f64 {
        -self.coupling.dot(angular_rad_s2) - self.restoring_rad_s2(deflection, velocity)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use crate::input::Scenario;
    use crate::truth::integrate::advance;
    use crate::truth::spacecraft::Spacecraft;

    /// A body of 5 kg m² about z with an oscillator of share 0.3 at 0.5 Hz about z.
    fn scenario(damping: f64, extra: &str) -> Scenario {
        let text = format!(
            "name = 'flexible'\nduration_s = 60\n[spacecraft]\n\
             inertia_kg_m2 = [3, 4, 5, 0.1, 0.2, -0.1]\n{extra}\n[gyro]\nrate_hz = 10\n\
             noise_rad_s = 1e-4\n[hardware]\n[[hardware.mode]]\nfrequency_hz = 0.5\n\
             damping = {damping}\ninertia_share = 0.3\naxis = [0, 0, 1]\n"
        );
        Scenario::from_toml("s.toml", &text, Path::new("")).unwrap()
    }

    #[test]
    fn free_frequency_is_that_of_two_masses_on_a_spring() {
        let mut scenario = scenario(0.0, "");
        scenario.spacecraft.inertia_kg_m2 = [3.0, 4.0, 5.0, 0.0, 0.0, 0.0];
        let craft = Spacecraft::new(&scenario);
        // A deflection of the oscillator alone: the body swings against it about z.
        let mut state = craft.initial_state();
        let (deflection, velocity) = (7, 8);
        state[deflection] = 1e-3;
        // 3.5 kg m² of body on the spring of 1.5 kg m²: Ω² (1 + 1.5/3.5).
        let free_hz = 0.5 * (5.0f64 / 3.5).sqrt();
        let quarter_s = 0.25 / free_hz;
        state = advance(&craft, 0.0, quarter_s, state).unwrap();
        assert!(state[deflection].abs() < 1e-13, "{}", state[deflection]);
        let expected = -1e-3 * std::f64::consts::TAU * free_hz;
        assert!((state[velocity] / expected - 1.0).abs() < 1e-10);
        // Momentum 5 ω + √5 √1.5 q̇ = 0, with the mean moment 4.
        let modal = (1.5f64 / 4.0).sqrt() * 4.0 * state[velocity];
        assert!((5.0 * state[2] + modal).abs() < 1e-12, "{}", state[2]);
    }

    #[test]
    fn momentum_and_energy_are_conserved_without_damping() {
        let scenario = scenario(0.0, "rate_rad_s = [0.1, -0.2, 0.15]");
        let craft = Spacecraft::new(&scenario);
        let mut state = craft.initial_state();
        state[7] = 0.05;
        let momentum = craft.inertial_momentum_n_m_s(0.0, &state);
        let energy = craft.energy_j(0.0, &state);
        for second in 0..60 {
            let t = f64::from(second);
            state = advance(&craft, t, t + 1.0, state).unwrap();
            let change = craft.inertial_momentum_n_m_s(t + 1.0, &state) - momentum;
            assert!(change.norm() < 1e-11, "{t}: {change}");
            assert!((craft.energy_j(t + 1.0, &state) / energy - 1.0).abs() < 1e-11, "{t}");
        }
    }

    #[test]
    fn damping_takes_energy_and_leaves_momentum() {
        let scenario = scenario(0.05, "rate_rad_s = [0.1, -0.2, 0.15]");
        let craft = Spacecraft::new(&scenario);
        let mut state = craft.initial_state();
        state[7] = 0.05;
        let momentum: Vector3<f64> = craft.inertial_momentum_n_m_s(0.0, &state);
        let mut energy = craft.energy_j(0.0, &state);
        for second in 0..60 {
            let t = f64::from(second);
            state = advance(&craft, t, t + 1.0, state).unwrap();
            let now = craft.energy_j(t + 1.0, &state);
            assert!(now < energy, "{t}");
            energy = now;
            let change = craft.inertial_momentum_n_m_s(t + 1.0, &state) - momentum;
            assert!(change.norm() < 1e-11, "{t}: {change}");
        }
    }

    #[test]
    fn decay_is_that_of_the_free_damping_ratio() {
        let mut scenario = scenario(0.02, "");
        scenario.spacecraft.inertia_kg_m2 = [3.0, 4.0, 5.0, 0.0, 0.0, 0.0];
        let craft = Spacecraft::new(&scenario);
        let mut state = craft.initial_state();
        state[7] = 1e-3;
        let start = craft.energy_j(0.0, &state);
        // q̈ (1 − s) + 2 ζ Ω q̇ + Ω² q = 0 with s = 0.3: the amplitude falls with ζ Ω/(1 − s).
        let rate = 0.02 * std::f64::consts::TAU * 0.5 / 0.7;
        let period_s = 1.0 / (0.5 / 0.7f64.sqrt() * (1.0 - 0.02f64.powi(2) / 0.7).sqrt());
        state = advance(&craft, 0.0, 10.0 * period_s, state).unwrap();
        let expected = (-2.0 * rate * 10.0 * period_s).exp();
        let found = craft.energy_j(10.0 * period_s, &state) / start;
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn momentum_is_conserved_across_a_change_of_the_body() {
        let text = "rate_rad_s = [0.1, -0.2, 0.15]\n[[change]]\ntime_s = 10\n\
                    inertia_factor = [1.2, 1.1, 1.3, 1, 1, 1]";
        let scenario = scenario(0.01, text);
        let [before, after] =
            [0, 1].map(|index| Spacecraft::of_stretch(&scenario, &scenario.stretch(index)));
        let state = advance(&before, 0.0, 10.0, before.initial_state()).unwrap();
        let next = before.becomes(&after, &state);
        let change = after.inertial_momentum_n_m_s(10.0, &next)
            - before.inertial_momentum_n_m_s(10.0, &state);
        assert!(change.norm() < 1e-14, "{change}");
    }
}
