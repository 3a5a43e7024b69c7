//! \[Kim2010\]: four estimators by conservation of angular momentum, on one slew with three wheels.

use super::case::{Case, OWN};
use super::distribution::Distribution;
use super::paper::{Paper, PapersFailed};
use crate::estimation::{EstimatorName, Method, Precision};
use crate::input::ELEMENT_NAMES;
use crate::report::plots::{Colour, Dot, Figure, Mark, Panel, Series, flight};
use crate::report::published::{PaperFigure, PublishedTable, Row};

/// A column of Tables 2 and 3. The paper orders the products xy, yz, zx; here they are xy, xz, yz.
struct Column {
    estimator: EstimatorName,
    /// Name in the paper.
    name: &'static str,
    /// Name on the axis of a plot.
    short: &'static str,
    /// Table 2.
    estimated_kg_m2: [f64; 6],
    /// Table 3.
    error_percent: [f64; 6],
    /// Cause of the errors: of the moments, of the products.
    remark: [&'static str; 2],
}

const COLUMNS: [Column; 4] = [
    Column {
        estimator: EstimatorName::MomentumBatch,
        name: "Batch",
        short: "batch",
        estimated_kg_m2: [4.2859, 7.1157, 6.1224, 4.8224, 6.2786, 6.1667],
        error_percent: [69.2018, 58.0296, 69.2248, 5573.3560, 4620.7823, 945.9131],
        remark: [RANK_ONE; 2],
    },
    Column {
        estimator: EstimatorName::MomentumConventional,
        name: "Conventional",
        short: "conventional",
        estimated_kg_m2: [14.1181, 17.5350, 20.6816, 16.3578, 17.4000, 19.1201],
        error_percent: [1.4520, 3.4269, 3.9592, 19144.5041, 12982.6901, 3142.9016],
        remark: [NEGLECTED_PRODUCTS, ONE_AXIS],
    },
    Column {
        estimator: EstimatorName::MomentumPreEstimate,
        name: "Considering pre-estimate",
        short: "pre-estimate",
        estimated_kg_m2: [14.1181, 17.5350, 20.6816, -0.0019, 0.0589, 0.0062],
        error_percent: [1.4520, 3.4269, 3.9592, 102.2033, 55.6939, 98.9418],
        remark: [NEGLECTED_PRODUCTS, PRE_ESTIMATE],
    },
    Column {
        estimator: EstimatorName::MomentumSuggested,
        name: "Suggested",
        short: "suggested",
        estimated_kg_m2: [14.1181, 17.5350, 20.6816, 0.1197, 0.1560, 0.1538],
        error_percent: [1.4520, 3.4269, 3.9592, 40.8686, 17.2956, 73.9096],
        remark: [NEGLECTED_PRODUCTS, NOISE],
    },
];

const RANK_ONE: &str = "the three rates are proportional and the regressor has rank 1: the estimate \
                        depends on the noise and on the length of the record alone";
const NEGLECTED_PRODUCTS: &str = "the formula neglects the products of inertia, which makes the \
                                  moments too large";
const ONE_AXIS: &str = "the formula assumes rotation about one axis: the product takes the value of \
                        a moment";
const PRE_ESTIMATE: &str = "column \"Suggested\" less the contribution of the product estimated \
                            before";
const NOISE: &str = "approximately the moment times n σ² / Σ ω²: depends on the noise and on the \
                     length of the record, not on the product";

/// The slew, and the proportionality of its rates.
pub struct Kim2010 {
    case: Case,
    /// Second singular value of the true rates over the first; 0 for rotation about a fixed axis.
    off_axis: f64,
}

/// Estimates of one seed.
pub struct Kim2010Trial {
    /// In the order of [`COLUMNS`], kg m².
    estimates: [[f64; 6]; 4],
    /// Own estimator, kg m². NaN for an element reported as unobserved.
    own: [f64; 6],
}

impl Paper for Kim2010 {
    type Trial = Kim2010Trial;

    const KEY: &'static str = "Kim2010";

    fn load() -> Result<Self, PapersFailed> {
        let case = Case::load("kim-2010-slew")?;
        let rates: Vec<_> = case.flight.instants.iter().map(|i| i.rate_rad_s).collect();
        let mut singular: Vec<f64> =
            nalgebra::Matrix3xX::from_columns(&rates).singular_values().iter().copied().collect();
        singular.sort_unstable_by(|a, b| b.total_cmp(a));
        let off_axis = singular[1] / singular[0];
        Ok(Self { case, off_axis })
    }

    fn fly(&self, seed: u64) -> Result<Kim2010Trial, PapersFailed> {
        let mut estimates = [[0.0; 6]; 4];
        for (estimate, column) in estimates.iter_mut().zip(&COLUMNS) {
            let flown = self.case.fly(method(column), seed, |_, _| ())?;
            *estimate = flown.estimate.inertia.elements_kg_m2();
        }
        let own = self.case.fly(OWN, seed, |_, _| ())?.estimate;
        let elements = own.inertia.elements_kg_m2();
        let observed = |i: usize| if own.observed.element[i] { elements[i] } else { f64::NAN };
        Ok(Kim2010Trial { estimates, own: std::array::from_fn(observed) })
    }

    /// Tables 2 and 3, one table for each column.
    fn tables(&self, trials: &[Kim2010Trial]) -> Vec<PublishedTable> {
        let columns = || 0..COLUMNS.len();
        let table_2 = columns().map(|column| self.table_2(column, trials));
        table_2.chain(columns().map(|column| self.table_3(column, trials))).collect()
    }

    /// Figures 1 and 2 of the true motion, 3 and 4 of all trials.
    fn figures(
        &self,
        _first_seed: u64,
        trials: &[Kim2010Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        let instants = &self.case.flight.instants;
        let wheels = &self.case.craft().wheels;
        let angles = flight::euler_angles("Euler angles of the slew ([Kim2010] Fig. 1)", instants);
        let title = "Angular rates and control inputs of the slew ([Kim2010] Fig. 2)";
        let inputs = flight::rates_and_control(title, instants, wheels);
        Ok(vec![
            Self::figure("figure-1", angles),
            Self::figure("figure-2", inputs),
            Self::figure("figure-3", self.estimates(trials)),
            Self::figure("figure-4", self.errors(trials)),
        ])
    }
}

impl Kim2010 {
    fn table(
        &self,
        number: &'static str,
        quantity: &str,
        column: usize,
        rows: Vec<Row>,
    ) -> PublishedTable {
        let title = format!("{quantity}, column \"{}\"", COLUMNS[column].name);
        let method = method(&COLUMNS[column]);
        let table = PublishedTable::new(Self::KEY, number, title, &self.case, method, rows);
        // The remark holds for all columns and is printed with the first.
        if column == 0 { table.remark(self.remark()) } else { table }
    }

    fn remark(&self) -> String {
        format!(
            "The slew is a rotation about one fixed axis: the second singular value of the rates is \
             {:.0e} of the first, and {} of 6 directions of the inertia are observable. {} reports \
             observed elements only.",
            self.off_axis, self.case.flight.bound.observed_directions, OWN.estimator
        )
    }

    fn table_2(&self, column: usize, trials: &[Kim2010Trial]) -> PublishedTable {
        let published = &COLUMNS[column];
        let row = |i: usize| {
            let ours = Distribution::over(trials, |trial| trial.estimates[column][i]);
            Row::new(ELEMENT_NAMES[i], "kg m2")
                .truth(self.case.truth_kg_m2()[i])
                .ours(Some(published.estimated_kg_m2[i]), &ours)
                .bound(self.case.bound_kg_m2(i))
                .own(&Distribution::over(trials, |trial| trial.own[i]))
                .remark(published.remark[usize::from(i >= 3)])
        };
        self.table("2", "estimates", column, (0..6).map(row).collect())
    }

    fn table_3(&self, column: usize, trials: &[Kim2010Trial]) -> PublishedTable {
        let row = |i: usize| {
            let error = |kg_m2| self.case.error_percent(i, kg_m2);
            let ours = Distribution::over(trials, |trial| error(trial.estimates[column][i]));
            Row::new(ELEMENT_NAMES[i], "%")
                .ours(Some(COLUMNS[column].error_percent[i]), &ours)
                .bound(self.case.bound_percent(i))
                .own(&Distribution::over(trials, |trial| error(trial.own[i])))
        };
        self.table("3", "errors", column, (0..6).map(row).collect())
    }

    fn estimates(&self, trials: &[Kim2010Trial]) -> Figure {
        let span = (-0.5, COLUMNS.len() as f64 - 0.5);
        let panel = |i: usize| {
            let truth = self.case.truth_kg_m2()[i];
            let published = |column: &Column| column.estimated_kg_m2[i];
            by_method(trials, format!("{}, kg m²", ELEMENT_NAMES[i]), published, &|kg_m2| kg_m2[i])
                .with(Series::level("true", Mark::Dashes, Colour::Truth, span, truth))
        };
        let title =
            format!("Estimates by method, {} runs ([Kim2010] Fig. 3, Table 2)", trials.len());
        Figure::grid(title, "", 2, (0..6).map(panel).collect())
    }

    fn errors(&self, trials: &[Kim2010Trial]) -> Figure {
        let panel = |i: usize| {
            let published = |column: &Column| column.error_percent[i];
            let label = format!("{} error, %", ELEMENT_NAMES[i]);
            let percent = |kg_m2: &[f64; 6]| self.case.error_percent(i, kg_m2[i]);
            by_method(trials, label, published, &percent).logarithmic()
        };
        let title = format!("Errors by method, {} runs ([Kim2010] Fig. 4, Table 3)", trials.len());
        Figure::grid(title, "", 2, (0..6).map(panel).collect())
    }
}

/// A panel with one value per method: the reproduced one with its spread, and the published one.
fn by_method(
    trials: &[Kim2010Trial],
    label: String,
    published: impl Fn(&Column) -> f64,
    value: &dyn Fn(&[f64; 6]) -> f64,
) -> Panel {
    /// Horizontal offset of the two marks of a method, so that they do not overlap.
    const OFFSET: f64 = 0.12;
    let dots = (0..COLUMNS.len()).map(|column| {
        let ours = Distribution::over(trials, |trial| value(&trial.estimates[column]));
        Dot {
            x: column as f64 - OFFSET,
            value: ours.mean().unwrap_or(f64::NAN),
            reach: ours.standard_deviation().unwrap_or(0.0),
        }
    });
    let printed = COLUMNS.iter().enumerate();
    let printed = printed.map(|(index, column)| (index as f64 + OFFSET, published(column)));
    Panel::new(label)
        .categories(&COLUMNS.each_ref().map(|column| column.short))
        .with(Series::dots("ours: mean ± standard deviation of a run", Colour::Main, dots))
        .with(Series::diamonds("published", Colour::Other, printed))
}

fn method(column: &Column) -> Method {
    Method { estimator: column.estimator, precision: Precision::F64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUE_KG_M2: [f64; 6] = [13.9160, 16.9540, 19.8940, 0.0850, 0.1330, 0.5896];
    /// Rounding of Table 2, kg m²: half a unit of the fourth decimal.
    const HALF_DIGIT_KG_M2: f64 = 0.5e-4;
    /// Rounding of Table 3, per cent: half a unit of the fourth decimal.
    const HALF_DIGIT_PERCENT: f64 = 0.5e-4;

    #[test]
    fn errors_of_table_3_follow_from_the_estimates_of_table_2() {
        for column in &COLUMNS {
            for i in 0..6 {
                let error =
                    100.0 * (column.estimated_kg_m2[i] - TRUE_KG_M2[i]).abs() / TRUE_KG_M2[i];
                let rounding = 100.0 * HALF_DIGIT_KG_M2 / TRUE_KG_M2[i] + HALF_DIGIT_PERCENT;
                let difference = (error - column.error_percent[i]).abs();
                assert!(difference < rounding, "{} {}: {error}", column.name, ELEMENT_NAMES[i]);
            }
        }
    }
}
