//! The tables that people read on the terminal.

use super::columns::Table;
use super::json::{
    CrlbReport, McReport, PilReport, ReplayReport, RunReport, TargetReport, elements,
};
use super::number::{fixed, power, significant};
use crate::input::ELEMENT_NAMES;

/// Significant digits of an uncertainty or an error.
const DIGITS: usize = 3;
/// What stands where there is nothing to say.
const NOTHING: &str = "-";
/// What stands for the bound of an element that can't be seen.
const UNSEEN: &str = "unseen";

/// The table of a simulated flight: estimate beside truth and bound.
pub fn run(report: &RunReport) -> String {
    let estimate = &report.estimate;
    let found = estimate.elements_kg_m2();
    let decimals = decimals(&estimate.sigma_kg_m2, &found);
    let mut table = Table::new(&[
        ("element", ""),
        ("true", "kg m²"),
        ("estimated", "kg m²"),
        ("error", "kg m²"),
        ("error", "%"),
        ("one sigma", "kg m²"),
        ("bound", "kg m²"),
        ("error/bound", ""),
    ]);
    for i in 0..6 {
        let error = found[i] - report.truth_kg_m2[i];
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            value(report.truth_kg_m2[i], decimals),
            value(found[i], decimals),
            significant(error, DIGITS),
            or(report.error_percent[i].map(|percent| significant(percent, DIGITS)), NOTHING),
            significant(estimate.sigma_kg_m2[i], DIGITS),
            or(report.bound_kg_m2[i].map(|bound| significant(bound, DIGITS)), UNSEEN),
            or(report.bound_kg_m2[i].map(|bound| fixed(error / bound, 2)), NOTHING),
        ]);
    }
    let scenario = format!("{}, seed {}", report.scenario, report.seed);
    [heading("scenario", &scenario), summary(estimate), "\n".to_owned(), table.finish()].concat()
}

/// The table of a flight of the firmware: that of the run, and how it compares with the host's.
pub fn pil(report: &PilReport) -> String {
    let TargetReport { identical_samples, restarted_at, stack_high_water_bytes, wall_s } =
        report.target;
    let compared =
        format!("{identical_samples} samples, each bit by bit as on the host; {wall_s:.1} s");
    let cut =
        restarted_at.map(|at| format!("after {at} samples; went on from the checkpoint in flash"));
    heading("target", &compared)
        + &cut.map_or(String::new(), |cut| heading("power cut", &cut))
        + &heading("stack", &format!("{stack_high_water_bytes} bytes at most"))
        + &run(&report.run)
}

/// The table of a recorded log: the estimate and what it is worth.
pub fn replay(report: &ReplayReport) -> String {
    let found = report.elements_kg_m2();
    let decimals = decimals(&report.sigma_kg_m2, &found);
    let mut table = Table::new(&[
        ("element", ""),
        ("estimated", "kg m²"),
        ("one sigma", "kg m²"),
        ("one sigma", "%"),
        ("observed", ""),
    ]);
    for i in 0..6 {
        let sigma = report.sigma_kg_m2[i];
        let percent = 100.0 * sigma / found[i].abs();
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            value(found[i], decimals),
            significant(sigma, DIGITS),
            if percent.is_finite() { significant(percent, DIGITS) } else { NOTHING.to_owned() },
            if report.element_observed[i] { "yes" } else { "no" }.to_owned(),
        ]);
    }
    let moments = report.principal_moments_kg_m2().map(|moment| value(moment, decimals)).join(", ");
    let mut parts = vec![
        summary(report),
        "\n".to_owned(),
        table.finish(),
        "\n".to_owned(),
        heading("principal moments", &format!("{moments} kg m²")),
    ];
    if !report.scale_observed && report.observed_directions > 0 {
        parts.push(ratios(report));
    }
    parts.concat()
}

/// The table of a campaign: RMS error and bias beside the bound.
pub fn mc(report: &McReport) -> String {
    let decimals = decimals(&report.rmse_kg_m2.map(Option::unwrap_or_default), &report.truth_kg_m2);
    let mut table = Table::new(&[
        ("element", ""),
        ("true", "kg m²"),
        ("RMS error", "kg m²"),
        ("bias", "kg m²"),
        ("bound", "kg m²"),
        ("RMS/bound", ""),
        ("bias/bound", ""),
    ]);
    let short = |figure: Option<f64>, otherwise| {
        or(figure.map(|figure| significant(figure, DIGITS)), otherwise)
    };
    let ratio = |figure: Option<f64>| or(figure.map(|figure| fixed(figure, 2)), NOTHING);
    for i in 0..6 {
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            value(report.truth_kg_m2[i], decimals),
            short(report.rmse_kg_m2[i], NOTHING),
            short(report.bias_kg_m2[i], NOTHING),
            short(report.bound_kg_m2[i], UNSEEN),
            ratio(report.rmse_over_bound[i]),
            ratio(report.bias_over_bound[i]),
        ]);
    }
    let last_seed = report.seed.wrapping_add(report.runs.saturating_sub(1));
    [
        heading("scenario", &format!("{}, seeds {} to {last_seed}", report.scenario, report.seed)),
        heading("estimator", &format!("{}, {}", report.estimator, report.precision)),
        heading("runs", &runs(report)),
        heading("changes", &format!("found in {} runs", report.changes)),
        heading("residuals", &format!("not white in {} runs", report.residuals_not_white)),
        heading("NEES", &honesty(report)),
        heading("RMS/bound", &of_all(report)),
        heading("speed", &speed(report)),
        "\n".to_owned(),
        table.finish(),
    ]
    .concat()
}

/// How many flew, and how many the figures are of.
fn runs(report: &McReport) -> String {
    let not_shown = match report.not_shown {
        0 => String::new(),
        count => format!("{count} of a motion that doesn't show all elements, "),
    };
    format!(
        "{}: {not_shown}{} diverged (left out below), {} of the others not converged",
        report.runs, report.diverged, report.not_converged
    )
}

/// The figure that sums up all elements.
fn of_all(report: &McReport) -> String {
    let ratio = report.rmse_over_bound_of_all.map(|ratio| fixed(ratio, 3));
    ratio.map_or("none: not all elements are seen".to_owned(), |ratio| {
        format!("{ratio} over all elements of {} runs", report.used)
    })
}

/// NEES, and where it should be.
fn honesty(report: &McReport) -> String {
    let (Some(nees), Some([low, high])) = (report.nees_per_dof, report.nees_95) else {
        let why = if report.used == 0 {
            "every run diverged"
        } else {
            "no covariance is positive definite"
        };
        return format!("none: {why}");
    };
    let (nees, low, high) = (significant(nees, 4), significant(low, 4), significant(high, 4));
    let of = if report.nees_runs == report.used {
        String::new()
    } else {
        format!(", of the {} runs whose covariance is positive definite", report.nees_runs)
    };
    format!("{nees} per degree of freedom (honest: {low} to {high}, 95 %){of}")
}

/// Steps, time, and the estimator's own pace.
fn speed(report: &McReport) -> String {
    let pace = report.steps_per_s_per_core.map_or(String::new(), |pace| {
        format!("; the estimator alone {} steps/s per core", significant(pace, DIGITS))
    });
    format!("{} steps in {} s{pace}", report.steps, significant(report.wall_s, DIGITS))
}

/// The table of a bound: how well any estimator could do.
pub fn crlb(report: &CrlbReport) -> String {
    let mut table = Table::new(&[("element", ""), ("bound", "kg m²"), ("bound", "%")]);
    for i in 0..6 {
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            or(report.bound_kg_m2[i].map(|bound| significant(bound, DIGITS)), UNSEEN),
            or(report.bound_percent[i].map(|percent| significant(percent, DIGITS)), NOTHING),
        ]);
    }
    [
        heading("scenario", &report.scenario),
        heading("unknowns", &report.unknowns.join(", ")),
        heading("observed", &format!("{} of 6 directions", report.observed_directions)),
        "\n".to_owned(),
        table.finish(),
        "\n".to_owned(),
        torque(report),
    ]
    .concat()
}

/// What a constant torque does to the estimate, and how well it is seen.
fn torque(report: &CrlbReport) -> String {
    let mut table = Table::new(&[
        ("a constant body torque", ""),
        ("about x", ""),
        ("about y", ""),
        ("about z", ""),
    ]);
    for (name, row) in ELEMENT_NAMES.iter().zip(report.inertia_error_kg_m2_per_n_m.iter().flatten())
    {
        let cells = match row {
            Some(error) => error.map(|error| significant(error, DIGITS)),
            None => [UNSEEN; 3].map(str::to_owned),
        };
        let [x, y, z] = cells;
        table.row([format!("  error of {name}, kg m² per N m"), x, y, z]);
    }
    let sigma = |sigma: Option<f64>| or(sigma.map(|sigma| significant(sigma, DIGITS)), UNSEEN);
    let [x, y, z] = report.torque_bound_n_m.map(sigma);
    table.row(["  one sigma with which it is seen, N m".to_owned(), x, y, z]);
    table.finish()
}

/// The lines above a table of estimates.
fn summary(report: &ReplayReport) -> String {
    let reasons: Vec<String> = (report.rejected.iter())
        .filter(|(_, count)| **count > 0)
        .map(|(reason, count)| format!("{count} {reason}"))
        .collect();
    let reasons =
        if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join(", ")) };
    let samples = format!(
        "{}, {} accepted, {} rejected{reasons}",
        report.samples,
        report.accepted,
        report.rejected_total()
    );
    let scale = if report.scale_observed { "scale observed" } else { "scale not observed" };
    let observed = format!("{} of 6 directions, {scale}", report.observed_directions);
    let physical = match (report.physical, report.projected) {
        (true, false) => "yes",
        (true, true) => "yes: the nearest to what the data by itself asks for, which no body has",
        (false, _) => "no: no rigid body has this tensor",
    };
    let white = match report.residuals_white {
        None => "",
        Some(true) => ", white",
        Some(false) => ", not white: something acts that the model doesn't know",
    };
    let residual = match report.residual_rms_rad_s {
        0.0 => "none: no sample was predicted".to_owned(),
        rms => format!("{} rad/s RMS{white}", significant(rms, 4)),
    };

    let mut lines = heading("estimator", &format!("{}, {}", report.estimator, report.precision));
    lines += &heading("samples", &samples);
    lines += &heading("status", &report.status.to_string());
    lines += &heading("observed", &observed);
    lines += &heading("physical", physical);
    lines += &heading("residual", &residual);
    if report.changes > 0 {
        let changes = format!("{}, each dropped what was known before", report.changes);
        lines += &heading("changes", &changes);
    }
    if let Some(torque) = &report.disturbance_torque_n_m {
        lines += &heading("disturbance torque", &format!("{} N m", vector(torque)));
    }
    if let Some(bias) = &report.gyro_bias_rad_s {
        lines += &heading("gyro bias", &format!("{} rad/s", vector(bias)));
    }
    lines
}

/// All that torque-free motion without wheels can show.
fn ratios(report: &ReplayReport) -> String {
    let ratio = elements(&report.inertia_over_trace);
    let mut table = Table::new(&[("element", ""), ("over trace", ""), ("one sigma", "")]);
    for i in 0..6 {
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            fixed(ratio[i], 5),
            significant(report.inertia_over_trace_sigma[i], DIGITS),
        ]);
    }
    let caution = "\nOnly the ratios of the tensor were seen; its size is the prior's:\n\n";
    [caution.to_owned(), table.finish()].concat()
}

fn heading(name: &str, text: &str) -> String {
    format!("{name:<20}{text}\n")
}

fn vector(values: &[f64; 3]) -> String {
    values.map(|value| significant(value, DIGITS)).join(", ")
}

fn or(text: Option<String>, otherwise: &str) -> String {
    text.unwrap_or_else(|| otherwise.to_owned())
}

/// Decimals that show two digits of the smallest sigma, within reason: an estimate is read beside
/// its uncertainty.
fn decimals(sigmas: &[f64; 6], elements: &[f64; 6]) -> i32 {
    let smallest =
        sigmas.iter().copied().filter(|sigma| *sigma > 0.0).fold(f64::INFINITY, f64::min);
    let largest = elements.iter().fold(0.0, |largest: f64, element| largest.max(element.abs()));
    let significant_of_largest = |digits: i32| digits - 1 - power(largest);
    if smallest.is_finite() {
        (1 - power(smallest)).clamp(significant_of_largest(4), significant_of_largest(9))
    } else {
        significant_of_largest(6)
    }
}

/// An element, in one column with others: all with the same decimals, or all with an exponent.
fn value(element: f64, decimals: i32) -> String {
    const MOST: i32 = 9;
    if decimals <= MOST {
        fixed(element, decimals)
    } else if element == 0.0 {
        "0".to_owned()
    } else {
        format!("{element:.5e}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::json::{Status, examples, matrix};
    use super::*;

    #[test]
    fn run_table() {
        assert_eq!(
            run(&examples::run()),
            "\
scenario            stsat3-spin-up, seed 7
estimator           joint-ekf, f32
samples             6001, 5998 accepted, 3 rejected (2 spike, 1 stuck)
status              converged
observed            6 of 6 directions, scale observed
physical            yes
residual            0.0001815 rad/s RMS, white

element      true  estimated     error    error  one sigma     bound  error/bound
            kg m²      kg m²     kg m²        %      kg m²     kg m²
jxx      14.20000   14.20102   0.00102  0.00718    0.00275   0.00275         0.37
jyy      17.30000   17.29780  -0.00220  -0.0127    0.00250   0.00249        -0.88
jzz      20.30000   20.30110   0.00110  0.00542    0.00320   0.00319         0.34
jxy       0.08670    0.08722  0.000520    0.600    0.00110   0.00112         0.46
jxz       0.13570    0.13410  -0.00160    -1.18    0.00160   0.00162        -0.99
jyz       0.60160    0.60150  -1.00e-4  -0.0166   0.000860  0.000854        -0.12
"
        );
    }

    #[test]
    fn replay_table() {
        let mut report = examples::replay();
        report.disturbance_torque_n_m = Some([1.5e-6, -2e-7, 0.0]);
        report.gyro_bias_rad_s = Some([0.01, -0.02, 0.003]);
        report.element_observed[4] = false;
        report.observed_directions = 5;
        report.status = Status::Partial;
        assert_eq!(
            replay(&report),
            "\
estimator           joint-ekf, f32
samples             6001, 5998 accepted, 3 rejected (2 spike, 1 stuck)
status              partial
observed            5 of 6 directions, scale observed
physical            yes
residual            0.0001815 rad/s RMS, white
disturbance torque  1.50e-6, -2.00e-7, 0 N m
gyro bias           0.0100, -0.0200, 0.00300 rad/s

element  estimated  one sigma  one sigma  observed
             kg m²      kg m²          %
jxx       14.20102    0.00275     0.0194       yes
jyy       17.29780    0.00250     0.0145       yes
jzz       20.30110    0.00320     0.0158       yes
jxy        0.08722    0.00110       1.26       yes
jxz        0.13410    0.00160       1.19        no
jyz        0.60150   0.000860      0.143       yes

principal moments   14.19627, 17.18303, 20.42062 kg m²
"
        );
    }

    #[test]
    fn replay_table_without_scale_shows_the_ratios() {
        let mut report = examples::replay();
        report.scale_observed = false;
        report.rejected.clear();
        report.inertia_kg_m2 = matrix(&[4.6e-8, 3.7e-9, 5.0e-8, 0.0, 1e-10, 0.0]);
        report.sigma_kg_m2 = [1e-8, 1e-9, 1e-8, 1e-10, 1e-10, 1e-10];
        assert_eq!(
            replay(&report),
            "\
estimator           joint-ekf, f32
samples             6001, 5998 accepted, 0 rejected
status              converged
observed            6 of 6 directions, scale not observed
physical            yes
residual            0.0001815 rad/s RMS, white

element    estimated  one sigma  one sigma  observed
               kg m²      kg m²          %
jxx       4.60000e-8    1.00e-8       21.7       yes
jyy       3.70000e-9    1.00e-9       27.0       yes
jzz       5.00000e-8    1.00e-8       20.0       yes
jxy                0   1.00e-10          -       yes
jxz      1.00000e-10   1.00e-10        100       yes
jyz                0   1.00e-10          -       yes

principal moments   3.70000e-9, 4.59975e-8, 5.00025e-8 kg m²

Only the ratios of the tensor were seen; its size is the prior's:

element  over trace  one sigma
jxx         0.27415    5.31e-5
jyy         0.33393    4.83e-5
jzz         0.39191    6.18e-5
jxy         0.00168    2.12e-5
jxz         0.00259    3.09e-5
jyz         0.01161    1.66e-5
"
        );
    }

    #[test]
    fn mc_table() {
        assert_eq!(
            mc(&examples::mc()),
            "\
scenario            stsat3-spin-up, seeds 100 to 149
estimator           joint-ekf, f32
runs                50: 2 diverged (left out below), 1 of the others not converged
changes             found in 3 runs
residuals           not white in 0 runs
NEES                1.092 per degree of freedom (honest: 0.8881 to 1.119, 95 %)
RMS/bound           1.250 over all elements of 48 runs
speed               300050 steps in 1.26 s; the estimator alone 512346 steps/s per core

element     true  RMS error       bias     bound  RMS/bound  bias/bound
           kg m²      kg m²      kg m²     kg m²
jxx      14.2000    0.00344  -0.000275   0.00275       1.25       -0.10
jyy      17.3000    0.00311  -0.000249   0.00249       1.25       -0.10
jzz      20.3000    0.00399  -0.000319   0.00319       1.25       -0.10
jxy       0.0867    0.00140  -0.000112   0.00112       1.25       -0.10
jxz       0.1357    0.00202  -0.000162   0.00162       1.25       -0.10
jyz       0.6016    0.00107   -8.54e-5  0.000854       1.25       -0.10
"
        );
    }

    #[test]
    fn mc_table_of_what_cannot_be_seen() {
        let mut report = examples::mc();
        report.nees_runs = 40;
        report.bound_kg_m2[0] = None;
        (report.rmse_over_bound[0], report.bias_over_bound[0]) = (None, None);
        report.rmse_over_bound_of_all = None;
        report.not_shown = 3;
        let table = mc(&report);
        assert!(table.contains("50: 3 of a motion that doesn't show all elements, 2 diverged"));
        assert!(table.contains("RMS/bound           none: not all elements are seen\n"));
        assert!(table.contains("95 %), of the 40 runs whose covariance is positive definite"));
        assert!(table.contains("unseen          -           -\n"), "{table}");

        (report.rmse_kg_m2, report.bias_kg_m2) = ([None; 6], [None; 6]);
        (report.nees_per_dof, report.nees_95) = (None, None);
        assert!(
            mc(&report).contains("NEES                none: no covariance is positive definite\n")
        );
        report.used = 0;
        assert!(mc(&report).contains("NEES                none: every run diverged\n"));
    }

    #[test]
    fn crlb_table() {
        assert_eq!(
            crlb(&examples::crlb()),
            "\
scenario            stsat3-spin-up
unknowns            rate, inertia
observed            4 of 6 directions

element    bound    bound
           kg m²        %
jxx      0.00275   0.0194
jyy      0.00249   0.0144
jzz       unseen        -
jxy      0.00112     1.29
jxz       unseen        -
jyz      8.54e-9  1.42e-6

a constant body torque                  about x  about y  about z
  error of jxx, kg m² per N m             -1350     12.5   -0.200
  error of jyy, kg m² per N m             -1350     12.5   -0.200
  error of jzz, kg m² per N m            unseen   unseen   unseen
  error of jxy, kg m² per N m             -1350     12.5   -0.200
  error of jxz, kg m² per N m            unseen   unseen   unseen
  error of jyz, kg m² per N m                 0        0        0
  one sigma with which it is seen, N m  3.21e-7  4.50e-5   unseen
"
        );
    }
}
