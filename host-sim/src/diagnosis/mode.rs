//! Search for a flexible appendage or a sloshing liquid: an oscillator on the body.
//!
//! ```text
//! H = J ω + h_w + M q̇,   q̈ + 2 ζ Ω q̇ + Ω² q = −ω̇
//! ```
//!
//! J inertia with the appendage locked, M modal inertia (six elements), q deflection of each body axis, at rest at first,
//! Ω undamped frequency with the body held. With q̇ from the rates of an earlier fit the model is linear in M:
//! `M q̇ = G(q̇) m`. (Measured rates would not do: their noise in q̇ imitates that of the residuals.)
//! The frequencies tried are those just below the largest lines of the residual spectrum, since a free body raises the
//! frequency of its appendage by `1 / √(1 − M/J)`. A fit without oscillator has no oscillation in its rates, so that the
//! first search finds the raised frequency, a second one with the rates of the first fit that of the appendage. Each is judged by a score test: the decrease of chi-square of the
//! linear problem at the fit of the log as it is, `gᵀ (A_mm − A_mc A_cc⁻¹ A_cm)⁻¹ g`.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::fit::{Fit, Problem, Unknowns};
use super::model::{Signal, Unknown};
use super::pass::of_elements;
use super::record::{MARGIN, Record};

/// Damping ratios tried, the first in the search for the frequency.
const DAMPING: [f64; 3] = [0.01, 0.003, 0.03];
/// Largest lines of the spectrum that are tried.
const LINES: usize = 3;
/// Lowest line, periods in the record.
const FEWEST_PERIODS: f64 = 2.0;
/// Largest rise of the frequency by the motion of the body, share.
const RISE: f64 = 0.1;
/// Frequencies tried below a line.
const TRIALS: usize = 8;
/// Elements of the modal inertia.
const ELEMENTS: usize = 6;

/// An oscillator that explains residuals.
pub(super) struct Oscillator {
    pub frequency_hz: f64,
    pub damping: f64,
    pub unknowns: Unknowns,
}

/// The oscillator of the largest score at the fit `null`, driven by the rates of the fit `drive`; none for a record too short for a spectrum.
pub(super) fn search(problem: &Problem<'_>, null: &Fit, drive: &Fit) -> Option<Oscillator> {
    let record = problem.record;
    let rates = rates(record, drive);
    // Frequency and damping of the largest score.
    let best = |trials: Vec<[f64; 2]>| {
        let scored = trials.into_par_iter().filter_map(|[frequency_hz, damping]| {
            let unknowns = unknowns(record, &rates, problem.unknowns, [frequency_hz, damping]);
            Some((problem.score(&unknowns, null)?, [frequency_hz, damping]))
        });
        scored.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, trial)| trial)
    };
    let step = RISE / TRIALS as f64;
    let below = |line_hz: f64| {
        // From one step above the line.
        (0..=TRIALS).map(move |trial| [line_hz * (1.0 + step - step * trial as f64), DAMPING[0]])
    };
    let residuals: Vec<_> = null.rows.iter().map(|[_, residual]| *residual).collect();
    let lines = lines(record, &residuals);
    let [coarse_hz, _] = best(lines.into_iter().flat_map(below).collect())?;
    let finer = (-3..=3).map(|k| [coarse_hz * (1.0 + 0.25 * step * f64::from(k)), DAMPING[0]]);
    let [frequency_hz, _] = best(finer.collect())?;
    let [frequency_hz, damping] = best(DAMPING.map(|damping| [frequency_hz, damping]).into())?;
    let unknowns = unknowns(record, &rates, problem.unknowns, [frequency_hz, damping]);
    Some(Oscillator { frequency_hz, damping, unknowns })
}

/// Rates of a fit, and measured rates where it has none.
fn rates(record: &Record, fit: &Fit) -> Vec<Vector3<f64>> {
    let mut rates = record.rate_rad_s.clone();
    for (rate, [predicted, _]) in rates.iter_mut().skip(MARGIN).zip(&fit.rows) {
        *rate = *predicted;
    }
    rates
}

/// The unknowns `base` and the modal inertia of an oscillator.
fn unknowns(
    record: &Record,
    rates: &[Vector3<f64>],
    base: &Unknowns,
    [frequency_hz, damping]: [f64; 2],
) -> Unknowns {
    let mut names = base.names.clone();
    names.extend((0..ELEMENTS).map(Unknown::Modal));
    Unknowns { modal: signals(record, rates, frequency_hz, damping), ..Unknowns::of(names) }
}

/// Momentum by each element of the modal inertia, `G(q̇)` by columns, at the rows and midway.
fn signals(
    record: &Record,
    rates: &[Vector3<f64>],
    frequency_hz: f64,
    damping: f64,
) -> Vec<Signal> {
    let rates = deflection_rates(record, rates, frequency_hz, damping);
    let middle = |k: usize| {
        let inner = |k: usize| (rates[k] + rates[k + 1]) * 9.0 - rates[k - 1] - rates[k + 2];
        match k >= 1 && k + 2 < rates.len() {
            true => inner(k) / 16.0,
            false => (rates[k] + rates[k + 1]) * 0.5,
        }
    };
    let middles: Vec<Vector3<f64>> = (0..rates.len() - 1).map(middle).collect();
    let of = |element: usize, values: &[Vector3<f64>]| {
        values.iter().map(|rate| of_elements(rate).column(element).into_owned()).collect()
    };
    (0..ELEMENTS).map(|e| Signal { at: of(e, &rates), middle: of(e, &middles) }).collect()
}

/// q̇ of each axis at each row. With `u = q̇ + ω`: `q′ = u − ω`, `u′ = −2 ζ Ω (u − ω) − Ω² q`, and ω linear between
/// rows; classical Runge-Kutta steps of at most a twentieth of a period.
fn deflection_rates(
    record: &Record,
    rates: &[Vector3<f64>],
    frequency_hz: f64,
    damping: f64,
) -> Vec<Vector3<f64>> {
    const STEPS_PER_PERIOD: f64 = 20.0;
    let omega = 2.0 * std::f64::consts::PI * frequency_hz;
    let slope = |q: &Vector3<f64>, u: &Vector3<f64>, rate: &Vector3<f64>| {
        let relative = u - rate;
        (relative, -relative * (2.0 * damping * omega) - q * (omega * omega))
    };
    let (mut q, mut u) = (Vector3::zeros(), rates[0]);
    let mut all = vec![Vector3::zeros()];
    for row in 1..rates.len() {
        let interval_s = record.time_s[row] - record.time_s[row - 1];
        let steps = (interval_s * frequency_hz * STEPS_PER_PERIOD).ceil().clamp(1.0, 1e3) as usize;
        let step_s = interval_s / steps as f64;
        for step in 0..steps {
            let rate = |part: f64| {
                let share = (step as f64 + part) / steps as f64;
                rates[row - 1] + (rates[row] - rates[row - 1]) * share
            };
            let (start, middle, end) = (rate(0.0), rate(0.5), rate(1.0));
            let a = slope(&q, &u, &start);
            let b = slope(&(q + a.0 * (0.5 * step_s)), &(u + a.1 * (0.5 * step_s)), &middle);
            let c = slope(&(q + b.0 * (0.5 * step_s)), &(u + b.1 * (0.5 * step_s)), &middle);
            let d = slope(&(q + c.0 * step_s), &(u + c.1 * step_s), &end);
            q += (a.0 + (b.0 + c.0) * 2.0 + d.0) * (step_s / 6.0);
            u += (a.1 + (b.1 + c.1) * 2.0 + d.1) * (step_s / 6.0);
        }
        all.push(u - rates[row]);
    }
    all
}

/// Frequencies of the largest lines of the residuals' spectrum, Hz: maxima of the periodogram of equally spaced rows,
/// all axes together, at half the spacing of its independent frequencies.
fn lines(record: &Record, residuals: &[Vector3<f64>]) -> Vec<f64> {
    let rows = residuals.len();
    if rows < 2 {
        return Vec::new();
    }
    let span_s = record.time_s[record.len() - 1] - record.time_s[0];
    let period_s = span_s / (record.len() - 1) as f64;
    let power: Vec<f64> =
        (0..rows).map(|k| power(residuals, k as f64 / (2 * rows) as f64)).collect();
    let lowest = (2.0 * FEWEST_PERIODS) as usize;
    let mut maxima: Vec<usize> = (lowest.max(1)..rows.saturating_sub(1))
        .filter(|k| power[*k] > power[k - 1] && power[*k] >= power[k + 1])
        .collect();
    maxima.sort_by(|a, b| power[*b].total_cmp(&power[*a]));
    maxima.iter().take(LINES).map(|k| *k as f64 / (2 * rows) as f64 / period_s).collect()
}

/// Power at a frequency, cycles per row: Goertzel's recursion.
fn power(residuals: &[Vector3<f64>], frequency: f64) -> f64 {
    let cosine = 2.0 * (2.0 * std::f64::consts::PI * frequency).cos();
    let (mut last, mut before) = (Vector3::zeros(), Vector3::zeros());
    for residual in residuals {
        (last, before) = (residual + last * cosine - before, last);
    }
    last.norm_squared() + before.norm_squared() - cosine * last.dot(&before)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(rates: Vec<Vector3<f64>>, step_s: f64) -> Record {
        let rows = rates.len();
        Record {
            time_s: (0..rows).map(|row| row as f64 * step_s).collect(),
            rate_rad_s: rates,
            wheel_rad_s: Vec::new(),
            torque_n_m: vec![Vector3::zeros(); rows],
            weight: vec![1.0; rows],
            wheels: Vec::new(),
            noise_rad_s: 1e-4,
        }
    }

    /// After a step of the rate by `w` the deflection is that of a free oscillator with `q̇ = −w`:
    /// `q̇ = −w e^(−ζΩt) (cos Ω_d t − ζΩ/Ω_d sin Ω_d t)`.
    #[test]
    fn step_of_rate_excites_a_free_oscillation() {
        let (frequency_hz, damping, step_s) = (0.5, 0.02, 0.05);
        let w = Vector3::new(0.1, -0.2, 0.3);
        let mut rates = vec![w; 200];
        rates[0] = Vector3::zeros();
        let found = deflection_rates(&record(rates.clone(), step_s), &rates, frequency_hz, damping);
        let omega = 2.0 * std::f64::consts::PI * frequency_hz;
        let damped = omega * (1.0 - damping * damping).sqrt();
        for (row, rate) in found.iter().enumerate().skip(2) {
            // The step is a ramp over the first interval, centred half an interval before row 1.
            let t = (row as f64 - 0.5) * step_s;
            let shape = (damped * t).cos() - damping * omega / damped * (damped * t).sin();
            let expected = -w * ((-damping * omega * t).exp() * shape);
            // A ramp instead of a step: (Ω Δt)² / 24 = 0.1 %.
            assert!((rate - expected).norm() < 2e-3 * w.norm(), "{row}: {rate} {expected}");
        }
    }

    #[test]
    fn spectrum_has_the_line_of_a_sine() {
        let step_s = 0.1;
        let sine = |row: usize| (2.0 * std::f64::consts::PI * 0.73 * row as f64 * step_s).sin();
        let residuals: Vec<_> = (0..600).map(|row| Vector3::new(0.0, sine(row), 0.1)).collect();
        let found = lines(&record(residuals.clone(), step_s), &residuals);
        assert!((found[0] - 0.73).abs() < 0.005, "{found:?}");
    }
}
