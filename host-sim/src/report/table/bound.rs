//! Table of `crlb`: the Cramér-Rao bound, and the effect of a constant torque.

use super::cells::{DIGITS, EMPTY, UNOBSERVED, heading, short};
use crate::input::ELEMENT_NAMES;
use crate::report::columns::Columns;
use crate::report::json::CrlbReport;
use crate::report::number::significant;

/// Table of a bound.
pub fn crlb(report: &CrlbReport) -> String {
    let mut table = Columns::new(&[("element", ""), ("bound", "kg m²"), ("bound", "%")]);
    for i in 0..6 {
        table.row([
            ELEMENT_NAMES[i].to_owned(),
            short(report.bound_kg_m2[i], UNOBSERVED),
            short(report.bound_percent[i], EMPTY),
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
        hardware(report),
    ]
    .concat()
}

/// Bounds with stated errors of the hardware, and the effect of each; empty if there are none.
fn hardware(report: &CrlbReport) -> String {
    let (Some(considered), Some(solved)) = (&report.considered_kg_m2, &report.solved_kg_m2) else {
        return String::new();
    };
    let mut table = Columns::new(&[("element", ""), ("considered", "kg m²"), ("solved", "kg m²")]);
    for (i, name) in ELEMENT_NAMES.iter().enumerate() {
        let bounds = [considered, solved].map(|bound| short(bound[i], UNOBSERVED));
        let [considered, solved] = bounds;
        table.row([(*name).to_owned(), considered, solved]);
    }
    let mut effects = Columns::new(&[
        ("one sigma of", ""),
        ("sigma", ""),
        ("jxx", "kg m²"),
        ("jyy", "kg m²"),
        ("jzz", "kg m²"),
        ("jxy", "kg m²"),
        ("jxz", "kg m²"),
        ("jyz", "kg m²"),
        ("posterior", "/ prior"),
    ]);
    for effect in &report.effects {
        let [xx, yy, zz, xy, xz, yz] = effect.inertia_kg_m2.map(|x| significant(x, DIGITS));
        let sigma = format!("{} {}", significant(effect.sigma, DIGITS), effect.unit);
        let shrunk = significant(effect.posterior_over_prior, DIGITS);
        let name = effect.name.clone();
        effects.row([name, sigma.trim_end().to_owned(), xx, yy, zz, xy, xz, yz, shrunk]);
    }
    ["\nwith the stated errors of the hardware\n", &table.finish(), "\n", &effects.finish()]
        .concat()
}

/// Error of each element by an unmodelled constant torque, and the observability of the torque.
fn torque(report: &CrlbReport) -> String {
    let mut table = Columns::new(&[
        ("a constant body torque", ""),
        ("about x", ""),
        ("about y", ""),
        ("about z", ""),
    ]);
    for (name, row) in ELEMENT_NAMES.iter().zip(report.inertia_error_kg_m2_per_n_m.iter().flatten())
    {
        let cells = match row {
            Some(error) => error.map(|error| significant(error, DIGITS)),
            None => [UNOBSERVED; 3].map(str::to_owned),
        };
        let [x, y, z] = cells;
        table.row([format!("  error of {name}, kg m² per N m"), x, y, z]);
    }
    let [x, y, z] = report.torque_bound_n_m.map(|sigma| short(sigma, UNOBSERVED));
    table.row(["  one sigma of the torque, N m".to_owned(), x, y, z]);
    table.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::json::examples;

    #[test]
    fn crlb_table_has_bound_and_effect_of_a_torque() {
        assert_eq!(
            crlb(&examples::crlb()),
            "\
scenario            stsat3-spin-up
unknowns            rate, inertia
observed            4 of 6 directions

element       bound    bound
              kg m²        %
jxx         0.00275   0.0194
jyy         0.00249   0.0144
jzz      unobserved        -
jxy         0.00112     1.29
jxz      unobserved        -
jyz         8.54e-9  1.42e-6

a constant body torque             about x     about y     about z
  error of jxx, kg m² per N m        -1350        12.5      -0.200
  error of jyy, kg m² per N m        -1350        12.5      -0.200
  error of jzz, kg m² per N m   unobserved  unobserved  unobserved
  error of jxy, kg m² per N m        -1350        12.5      -0.200
  error of jxz, kg m² per N m   unobserved  unobserved  unobserved
  error of jyz, kg m² per N m            0           0           0
  one sigma of the torque, N m     3.21e-7     4.50e-5  unobserved
"
        );
    }
}
