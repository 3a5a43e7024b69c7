//! Lines and table on the errors of the hardware.

use super::cells::{DIGITS, heading};
use crate::estimation::squared_norm;
use crate::input::ELEMENT_NAMES;
use crate::report::columns::Columns;
use crate::report::json::{HardwareResult, ReplayReport};
use crate::report::number::significant;

/// Largest share of its stated sigma at which a parameter is listed as solved.
const SOLVED: f64 = 0.9;
/// Cosine between a shift and the tensor above which the shift is one of scale.
const ALONG_TENSOR: f64 = 0.9;

/// Line on the largest systematic error, as `scale to 1.1 %: wheel spin inertia, assumed 1 %`, or as `less than the noise: …`;
/// none for ideal hardware.
pub(super) fn systematic(report: &ReplayReport) -> String {
    let of_kind =
        report.hardware.iter().filter(|p| report.largest_systematic.as_ref() == Some(&p.kind));
    let squares = |p: &HardwareResult| squared_norm(&p.effect_kg_m2);
    let Some(largest) = of_kind.max_by(|a, b| squares(a).total_cmp(&squares(b))) else {
        return String::new();
    };
    let origin = if largest.assumed { "assumed" } else { "stated" };
    let stated = format!("{}, {origin} {}", largest.kind, in_words(largest.stated, &largest.unit));
    let reach = if report.is_limited_by_hardware() {
        reach(report, &largest.effect_kg_m2)
    } else {
        "less than the noise".to_owned()
    };
    heading("systematic", &format!("{reach}: {stated}"))
}

/// The scale with its sigma for a shift along the tensor; else the element with the largest systematic sigma.
fn reach(report: &ReplayReport, shift_kg_m2: &[f64; 6]) -> String {
    let tensor = report.elements_kg_m2();
    let product = |a: &[f64; 6], b: &[f64; 6]| {
        let sum: [f64; 6] = std::array::from_fn(|i| a[i] + b[i]);
        0.5 * (squared_norm(&sum) - squared_norm(a) - squared_norm(b))
    };
    let norms = (squared_norm(shift_kg_m2) * squared_norm(&tensor)).sqrt();
    if product(shift_kg_m2, &tensor).abs() > ALONG_TENSOR * norms {
        let trace = tensor[0] + tensor[1] + tensor[2];
        let variance: f64 = report.covariance_kg2_m4[..3].iter().flat_map(|row| &row[..3]).sum();
        return format!("scale to {}", in_words(variance.max(0.0).sqrt() / trace, ""));
    }
    let systematic = &report.sigma_systematic_kg_m2;
    let worst = (0..6).max_by(|a, b| systematic[*a].total_cmp(&systematic[*b])).unwrap_or(0);
    let sigma = significant(report.sigma_kg_m2[worst], DIGITS);
    format!("{} to {sigma} kg m²", ELEMENT_NAMES[worst])
}

/// Table of the parameters whose sigma the data made smaller; empty without any.
pub(super) fn solved(report: &ReplayReport) -> String {
    let mut table = Columns::new(&[
        ("solved", ""),
        ("estimate", ""),
        ("one sigma", ""),
        ("stated", ""),
        ("", ""),
    ]);
    let solved: Vec<_> = report.hardware.iter().filter(|p| p.left() < SOLVED).collect();
    if solved.is_empty() {
        return String::new();
    }
    let contradicted: String = solved.iter().map(|parameter| contradiction(parameter)).collect();
    for parameter in solved {
        let cell = |value: f64| in_words(value, &parameter.unit);
        table.row([
            parameter.name.clone(),
            cell(parameter.value),
            cell(parameter.sigma),
            cell(parameter.stated),
            if parameter.assumed { "assumed" } else { "" }.to_owned(),
        ]);
    }
    format!("\n{}{contradicted}", table.finish())
}

/// Line on a parameter that is not as stated; empty for one that is.
fn contradiction(parameter: &HardwareResult) -> String {
    if !parameter.is_contradicted() {
        return String::new();
    }
    let HardwareResult { name, key, .. } = parameter;
    format!("{name}: beyond five stated sigmas; correct log or craft file (diagnose), or {key}\n")
}

/// A value with its unit: a share in per cent, an angle in degrees.
pub(in crate::report) fn in_words(value: f64, unit: &str) -> String {
    /// Significant digits.
    const SHORT: usize = 2;
    let trimmed = |value: f64| {
        let text = significant(value, SHORT);
        match text.contains('.') && !text.contains('e') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    };
    match unit {
        "" => format!("{} %", trimmed(100.0 * value)),
        "rad" => format!("{}°", trimmed(value.to_degrees())),
        unit => format!("{} {unit}", trimmed(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::json::examples;

    #[test]
    fn largest_error_is_named_with_its_stated_sigma() {
        assert_eq!(
            systematic(&examples::with_hardware()),
            "systematic          scale to 0.58 %: wheel spin inertia, assumed 1 %\n"
        );
        let mut products = examples::with_hardware();
        products.largest_systematic = Some("gyro axes".to_owned());
        assert_eq!(
            systematic(&products),
            "systematic          jzz to 0.118 kg m²: gyro axes, stated 0.1°\n"
        );
        products.sigma_random_kg_m2 = products.sigma_systematic_kg_m2.map(|sigma| 3.0 * sigma);
        assert_eq!(
            systematic(&products),
            "systematic          less than the noise: gyro axes, stated 0.1°\n"
        );
        assert_eq!(systematic(&examples::replay()), "");
    }

    #[test]
    fn parameters_that_the_data_determine_are_listed() {
        assert_eq!(
            solved(&examples::with_hardware()),
            "
solved        estimate  one sigma   stated
gyro axes xy    0.057°    0.0029°     0.1°
time offset    0.012 s  0.00031 s  0.005 s  assumed
"
        );
        assert_eq!(solved(&examples::replay()), "");
    }

    #[test]
    fn parameter_beyond_its_stated_sigma_is_named() {
        let mut report = examples::with_hardware();
        let offset = report.hardware.iter_mut().find(|p| p.name == "time offset").unwrap();
        offset.value = -0.27;
        assert!(solved(&report).ends_with(
            "time offset: beyond five stated sigmas; correct log or craft file (diagnose), or gyro.delay_sigma_s\n"
        ));
    }
}
