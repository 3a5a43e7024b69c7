//! Tables 5 and 6 of \[Kim2016\].

use super::trial::{Kim2016, Kim2016Trial, PUBLISHED, SETTLED_S};
use crate::input::ELEMENT_NAMES;
use crate::papers::distribution::Distribution;
use crate::papers::paper::Paper;
use crate::report::published::{PublishedTable, Row};

/// Table 5: RMS error of the acceleration on each axis by backward difference, deg/s².
const BACKWARD_DEG_S2: [f64; 3] = [0.0081, 0.0081, 0.0081];
/// Table 5: RMS error by Savitzky-Golay, deg/s².
const SAVITZKY_GOLAY_DEG_S2: [f64; 3] = [0.0058, 0.0058, 0.0057];
/// Table 5: reduction of the error, per cent.
const DIFFERENCE_PERCENT: [f64; 3] = [28.28, 28.58, 29.13];

/// Table 6: estimates, kg m².
const ESTIMATED_KG_M2: [f64; 6] = [14.1823, 17.2876, 20.2859, 0.0864, 0.1350, 0.6009];
/// Table 6: errors of the estimates, per cent.
const ERROR_PERCENT: [f64; 6] = [0.12, 0.07, 0.07, 0.39, 0.48, 0.12];

const PARABOLA: &str =
    "the weights of Table 2 and Eq. (10), labelled quartic, are those of a parabola";
const QUARTIC: &str = "weights of a quartic: 28.4 % less in the limit of a slow filter, as \
                       published, so probably the weights used in the paper";
const BELOW_BOUND: &str = "below the bound: possible for a single run only";

impl Kim2016 {
    fn table(&self, number: &'static str, title: &str, rows: Vec<Row>) -> PublishedTable {
        PublishedTable::new(Self::KEY, number, title, &self.case, PUBLISHED, rows)
    }

    /// RMS error of the acceleration, with the printed weights and with those of a quartic.
    pub(super) fn table_5(&self, trials: &[Kim2016Trial]) -> PublishedTable {
        let rows = ["x", "y", "z"].into_iter().enumerate();
        let rows = rows.flat_map(|(axis, name)| rows_of_axis(axis, name, trials)).collect();
        let title = "RMS error of the angular acceleration of the filtered rates";
        self.table("5", title, rows).without_own().remark(format!(
            "Ours from {SETTLED_S} s on. The noise of the filtered rates depends on the process \
             noise, which was lost in printing."
        ))
    }

    /// Estimates at the end of the flight, and their errors.
    pub(super) fn table_6(&self, trials: &[Kim2016Trial]) -> PublishedTable {
        let noise_deg_s2 = Distribution::over(trials, |trial| trial.parabola[0]).mean();
        let against_table_5 = format!(
            "inconsistent with Table 5: noise of the acceleration biases least squares; ours has \
             the same bias with {:.0} times less noise",
            SAVITZKY_GOLAY_DEG_S2[0] / noise_deg_s2.unwrap_or(f64::NAN)
        );
        let estimate = |i: usize| {
            Row::new(ELEMENT_NAMES[i], "kg m2")
                .truth(self.case.truth_kg_m2()[i])
                .ours(
                    Some(ESTIMATED_KG_M2[i]),
                    &Distribution::over(trials, |trial| trial.estimate[i]),
                )
                .bound(self.case.bound_kg_m2(i))
                .own(&Distribution::over(trials, |trial| trial.own[i]))
        };
        let error = |i: usize| {
            let percent = |kg_m2| self.case.error_percent(i, kg_m2);
            let bound = self.case.bound_percent(i);
            let ours = Distribution::over(trials, |trial| percent(trial.estimate[i]));
            let row = Row::new(format!("{} error", ELEMENT_NAMES[i]), "%")
                .ours(Some(ERROR_PERCENT[i]), &ours)
                .bound(bound)
                .own(&Distribution::over(trials, |trial| percent(trial.own[i])));
            let is_below = bound.is_some_and(|bound| ERROR_PERCENT[i] < bound);
            row.remark(if is_below { BELOW_BOUND } else { &against_table_5 })
        };
        let rows = (0..6).map(estimate).chain((0..6).map(error)).collect();
        self.table("6", "estimates at the end, and their errors", rows)
    }
}

/// The rows of Table 5 for one axis.
fn rows_of_axis(axis: usize, name: &str, trials: &[Kim2016Trial]) -> [Row; 5] {
    let rms = |quantity: &str, published, of: fn(&Kim2016Trial) -> &[f64; 3]| {
        let ours = Distribution::over(trials, |trial| of(trial)[axis]);
        Row::new(format!("{name} {quantity}"), "deg/s2").ours(Some(published), &ours)
    };
    let reduction = |quantity: &str, of: fn(&Kim2016Trial) -> &[f64; 3]| {
        let percent = |trial: &Kim2016Trial| 100.0 * (1.0 - of(trial)[axis] / trial.backward[axis]);
        Row::new(format!("{name} {quantity}"), "%")
            .ours(Some(DIFFERENCE_PERCENT[axis]), &Distribution::over(trials, percent))
    };
    let published = SAVITZKY_GOLAY_DEG_S2[axis];
    [
        rms("backward difference", BACKWARD_DEG_S2[axis], |trial| &trial.backward),
        rms("SGF, as printed", published, |trial| &trial.parabola),
        reduction("less, as printed", |trial| &trial.parabola).remark(PARABOLA),
        rms("SGF, quartic", published, |trial| &trial.quartic),
        reduction("less, quartic", |trial| &trial.quartic).remark(QUARTIC),
    ]
}

#[cfg(test)]
mod tests {
    use fsw_core::math::savgol::Fit;

    use super::*;

    /// Rounding of the printed percentages: half a unit of the second decimal.
    const HALF_DIGIT_PERCENT: f64 = 0.005;
    /// Rounding of the printed estimates, kg m², and accelerations, deg/s²: half a unit of the
    /// fourth decimal.
    const HALF_DIGIT: f64 = 0.5e-4;

    #[test]
    fn errors_of_table_6_follow_from_its_estimates() {
        const TRUE_KG_M2: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
        for i in 0..6 {
            let error = 100.0 * (ESTIMATED_KG_M2[i] / TRUE_KG_M2[i] - 1.0).abs();
            let rounding = 100.0 * HALF_DIGIT / TRUE_KG_M2[i] + HALF_DIGIT_PERCENT;
            assert!((error - ERROR_PERCENT[i]).abs() < rounding, "{}: {error}", ELEMENT_NAMES[i]);
        }
    }

    #[test]
    fn differences_of_table_5_follow_from_its_columns() {
        for i in 0..3 {
            let ratio = SAVITZKY_GOLAY_DEG_S2[i] / BACKWARD_DEG_S2[i];
            let difference = 100.0 * (1.0 - ratio);
            let digit = HALF_DIGIT / BACKWARD_DEG_S2[i];
            let rounding = 100.0 * digit * (1.0 + ratio) + HALF_DIGIT_PERCENT;
            assert!((difference - DIFFERENCE_PERCENT[i]).abs() < rounding, "{difference}");
        }
    }

    /// A slow filter leaves a random walk of the rate. Each step of the walk enters the derivative
    /// with the sum of the weights after it, and the backward difference with weight one.
    #[test]
    fn quartic_gives_the_published_difference_on_a_random_walk() {
        /// The published differences are 28.28, 28.58 and 29.13 %; the limit is known to 0.1 %.
        const TOLERANCE_PERCENT: f64 = 0.1;
        use fsw_core::math::savgol::Kernel;
        let less_percent = |order| {
            let kernel = Kernel::<f64, 6>::new(&Fit::centred(6, order, 1)).unwrap();
            let weights = kernel.weights();
            let steps = (1..6).map(|k| weights[k..].iter().sum::<f64>().powi(2));
            100.0 * (1.0 - steps.sum::<f64>().sqrt())
        };
        assert!((less_percent(4) - 28.4).abs() < TOLERANCE_PERCENT, "{}", less_percent(4));
        assert!((less_percent(2) - 54.0).abs() < TOLERANCE_PERCENT, "{}", less_percent(2));
    }
}
