//! Adaptive integration of `ẏ = f(t, y)` from one time to another.
//!
//! Method: explicit Runge-Kutta of order 8 by Dormand and Prince with the error estimates of orders 5
//! and 3 (DOP853; \[Hairer1993\] section II.5), from the crate `differential-equations`. Each call ends exactly at the next sample or kink
//! of a torque, so that no sample is interpolated and no step straddles a jump.

use differential_equations::prelude::{Error, ExplicitRungeKutta, IVP, ODE};
use thiserror::Error;

/// Relative tolerance per step. Momentum and energy drift by less than 1e-10 over 600 s of tumbling
/// (tested).
const RELATIVE_TOLERANCE: f64 = 1e-12;
/// Absolute tolerance per step, for states of the size of a rate in rad/s or of a quaternion: far
/// below the resolution of any gyro.
const ABSOLUTE_TOLERANCE: f64 = 1e-14;
/// Largest number of steps between two samples. A step of this tolerance turns the body by about a tenth of a radian or
/// more: motion that needs more turns by hundreds of revolutions between two samples.
const MAX_STEPS: usize = 30_000;

/// Error of an integration.
#[derive(Clone, Debug, Error, PartialEq)]
#[error(
    "the motion cannot be integrated from t = {from_s} s to {to_s} s ({reason}); \
     check the scenario for unrealistic torques and rates"
)]
pub struct IntegrationFailed {
    /// Start of the interval, s.
    pub from_s: f64,
    /// End of the interval, s.
    pub to_s: f64,
    /// Reason given by the solver.
    pub reason: String,
}

/// System of ordinary differential equations `ẏ = f(t, y)`.
pub trait Equations {
    /// Writes `f(t, y)` to `derivative`, of the same length as `state`.
    fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]);
}

/// Equations in the form of the crate `differential-equations`.
struct OdeAdapter<'a, E> {
    equations: &'a E,
    /// Largest time before the end, s. A jump at the end belongs to the next interval.
    last_s: f64,
}

impl<E: Equations> ODE<f64, Vec<f64>> for OdeAdapter<'_, E> {
    fn diff(&self, time_s: f64, state: &Vec<f64>, derivative: &mut Vec<f64>) {
        self.equations.derivative(time_s.min(self.last_s), state, derivative);
    }
}

/// State at `to_s` from the state at `from_s`.
///
/// # Errors
/// [`IntegrationFailed`] if the solver fails or a state is not finite.
pub fn advance(
    equations: &impl Equations,
    from_s: f64,
    to_s: f64,
    state: Vec<f64>,
) -> Result<Vec<f64>, IntegrationFailed> {
    let failed = |reason: String| IntegrationFailed { from_s, to_s, reason };
    let method = ExplicitRungeKutta::dop853()
        .rtol(RELATIVE_TOLERANCE)
        .atol(ABSOLUTE_TOLERANCE)
        .h0(to_s - from_s)
        .max_steps(MAX_STEPS);
    let adapter = OdeAdapter { equations, last_s: to_s.next_down() };
    let solution = IVP::ode(&adapter, from_s, to_s, state)
        .method(method)
        .solve()
        .map_err(|error| failed(reason(&error)))?;
    let (_, end) = solution.last().map_err(|error| failed(error.to_string()))?;
    if end.iter().any(|x| !x.is_finite()) {
        return Err(failed("a state is not finite".into()));
    }
    Ok(end.clone())
}

fn reason(error: &Error<f64, Vec<f64>>) -> String {
    match error {
        Error::MaxSteps { t, .. } => format!("more than {MAX_STEPS} steps up to t = {t} s"),
        Error::StepSize { t, .. } => format!("the step vanishes at t = {t} s"),
        Error::Stiffness { t, .. } => format!("the equations are stiff at t = {t} s"),
        Error::BadInput { msg } => msg.clone(),
        other => format!("{other:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Forced;

    impl Equations for Forced {
        fn derivative(&self, time_s: f64, state: &[f64], derivative: &mut [f64]) {
            derivative[0] = state[1];
            derivative[1] = time_s.cos() * 3.0 - 4.0 * state[0];
        }
    }

    #[test]
    fn forced_oscillator_matches_its_solution() {
        // ẍ + 4 x = 3 cos t, x(0) = 1, ẋ(0) = 0: x = cos t. The equations depend on time, hence on the
        // nodes of the method's tableau.
        let mut state = vec![1.0, 0.0];
        for k in 0..100 {
            let t = f64::from(k) * 0.1;
            state = advance(&Forced, t, t + 0.1, state).unwrap();
        }
        assert!((state[0] - 10.0f64.cos()).abs() < 1e-11, "{}", state[0] - 10.0f64.cos());
    }

    #[test]
    fn jump_at_the_end_belongs_to_the_next_interval() {
        struct SwitchedOff;
        impl Equations for SwitchedOff {
            fn derivative(&self, time_s: f64, _: &[f64], derivative: &mut [f64]) {
                derivative[0] = if time_s < 1.0 { 3.0 } else { 0.0 };
            }
        }
        let before = advance(&SwitchedOff, 0.0, 1.0, vec![0.0]).unwrap();
        let after = advance(&SwitchedOff, 1.0, 2.0, before).unwrap();
        assert!((after[0] - 3.0).abs() < 1e-14, "{}", after[0]);
    }

    #[test]
    fn divergent_solution_is_an_error() {
        struct Divergent;
        impl Equations for Divergent {
            fn derivative(&self, _: f64, state: &[f64], derivative: &mut [f64]) {
                derivative[0] = state[0] * state[0];
            }
        }
        let error = advance(&Divergent, 0.0, 2.0, vec![1.0]).unwrap_err();
        assert_eq!((error.from_s, error.to_s), (0.0, 2.0));
    }
}
