//! \[Kim2010\]: four estimators by conservation of momentum, on one slew with three wheels.

use super::course::{Course, OWN};
use super::distribution::Distribution;
use super::{PapersFailed, figure};
use crate::estimation::{EstimatorName, Method, Precision, SetUpError};
use crate::input::ELEMENT_NAMES;
use crate::report::papers_dir::PaperFigure;
use crate::report::plots::{Colour, Dot, Figure, Mark, Panel, PlotError, Series, flight};
use crate::report::published::{PublishedTable, Row};

const PAPER: &str = "Kim2010";

/// A column of Tables 2 and 3. The paper orders the products xy, yz, zx; here they are xy, xz, yz.
struct Column {
    estimator: EstimatorName,
    /// What the paper calls it.
    name: &'static str,
    /// For an axis of a plot.
    short: &'static str,
    /// Table 2.
    estimated_kg_m2: [f64; 6],
    /// Table 3.
    error_percent: [f64; 6],
    /// Why it is as it is.
    remark: [&'static str; 2],
}

const COLUMNS: [Column; 4] = [
    Column {
        estimator: EstimatorName::MomentumBatch,
        name: "Batch",
        short: "batch",
        estimated_kg_m2: [4.2859, 7.1157, 6.1224, 4.8224, 6.2786, 6.1667],
        error_percent: [69.2018, 58.0296, 69.2248, 5573.3560, 4620.7823, 945.9131],
        remark: [ONLY_NOISE; 2],
    },
    Column {
        estimator: EstimatorName::MomentumConventional,
        name: "Conventional",
        short: "conventional",
        estimated_kg_m2: [14.1181, 17.5350, 20.6816, 16.3578, 17.4000, 19.1201],
        error_percent: [1.4520, 3.4269, 3.9592, 19144.5041, 12982.6901, 3142.9016],
        remark: [MOMENTS, ONE_AXIS],
    },
    Column {
        estimator: EstimatorName::MomentumPreEstimate,
        name: "Considering pre-estimate",
        short: "pre-estimate",
        estimated_kg_m2: [14.1181, 17.5350, 20.6816, -0.0019, 0.0589, 0.0062],
        error_percent: [1.4520, 3.4269, 3.9592, 102.2033, 55.6939, 98.9418],
        remark: [MOMENTS, LEFT_OVER],
    },
    Column {
        estimator: EstimatorName::MomentumSuggested,
        name: "Suggested",
        short: "suggested",
        estimated_kg_m2: [14.1181, 17.5350, 20.6816, 0.1197, 0.1560, 0.1538],
        error_percent: [1.4520, 3.4269, 3.9592, 40.8686, 17.2956, 73.9096],
        remark: [MOMENTS, DIFFERENCES],
    },
];

const ONLY_NOISE: &str = "the three rates are proportional, the regressor has rank 1: what the batch \
                          shows is noise and the length of the record";
const MOMENTS: &str = "too large by what the products of inertia add: the formula neglects them";
const ONE_AXIS: &str =
    "the formula is for turning about one axis: it takes the moment for a product";
const LEFT_OVER: &str =
    "as in column \"Suggested\", less what the product found before it takes away";
const DIFFERENCES: &str = "about the moment times n σ² / Σ ω²: noise and length of the record, not this \
                           product";

/// The slew.
pub struct Study {
    course: Course,
    /// Second singular value of the true rates over the first.
    off_axis: f64,
}

/// One seed.
pub struct Run {
    /// By [`COLUMNS`], kg m².
    estimates: [[f64; 6]; 4],
    /// Our own, kg m²; NaN where it says that the element isn't observed.
    own: [f64; 6],
}

impl Study {
    /// The truth of the slew.
    pub fn new() -> Result<Self, PapersFailed> {
        let course = Course::load("kim-2010-slew")?;
        let rates: Vec<_> = course.flight.instants.iter().map(|i| i.rate_rad_s).collect();
        let mut singular: Vec<f64> =
            nalgebra::Matrix3xX::from_columns(&rates).singular_values().iter().copied().collect();
        singular.sort_unstable_by(|a, b| b.total_cmp(a));
        let off_axis = singular[1] / singular[0];
        Ok(Self { course, off_axis })
    }

    /// Flies one seed.
    pub fn fly(&self, seed: u64) -> Result<Run, SetUpError> {
        let mut estimates = [[0.0; 6]; 4];
        for (estimate, column) in estimates.iter_mut().zip(&COLUMNS) {
            let flown = self.course.fly(method(column), seed, |_, _| ())?;
            *estimate = flown.estimate.inertia.elements_kg_m2();
        }
        let own = self.course.fly(OWN, seed, |_, _| ())?.estimate;
        let elements = own.inertia.elements_kg_m2();
        let seen = |i: usize| if own.observed.element[i] { elements[i] } else { f64::NAN };
        Ok(Run { estimates, own: std::array::from_fn(seen) })
    }

    /// Tables 2 and 3, a table for each column.
    pub fn tables(&self, runs: &[Run]) -> Vec<PublishedTable> {
        let of_all = |rows: fn(&Self, usize, &[Run]) -> PublishedTable| {
            (0..COLUMNS.len()).map(move |which| rows(self, which, runs))
        };
        of_all(Self::table_2).chain(of_all(Self::table_3)).collect()
    }

    fn table(
        &self,
        number: &'static str,
        what: &str,
        which: usize,
        rows: Vec<Row>,
    ) -> PublishedTable {
        let column = &COLUMNS[which];
        PublishedTable {
            paper: PAPER,
            table: number,
            title: format!("{what}, column \"{}\"", column.name),
            scenario: self.course.scenario.name.clone(),
            estimator: column.estimator.to_string(),
            precision: method(column).precision.to_string(),
            own_estimator: Some(OWN.estimator.to_string()),
            observed_directions: self.course.flight.bound.observed_directions,
            rows,
            // Once for all columns.
            remark: (which == 0).then(|| self.remark()),
        }
    }

    fn remark(&self) -> String {
        format!(
            "The slew is about one fixed axis: the second singular value of the rates is {:.0e} of the \
             first, and the motion shows {} of 6 directions of the inertia. {} gives a number only for \
             an element that it has seen.",
            self.off_axis, self.course.flight.bound.observed_directions, OWN.estimator
        )
    }

    fn table_2(&self, which: usize, runs: &[Run]) -> PublishedTable {
        let of = |value: &dyn Fn(&Run) -> f64| Distribution::new(runs.iter().map(value));
        let column = &COLUMNS[which];
        let row = |i: usize| {
            Row::new(ELEMENT_NAMES[i], "kg m2")
                .truth(self.course.truth_kg_m2()[i])
                .ours(Some(column.estimated_kg_m2[i]), &of(&|run| run.estimates[which][i]))
                .bound(self.course.bound_kg_m2(i))
                .own(&of(&|run| run.own[i]))
                .remark(column.remark[usize::from(i >= 3)])
        };
        self.table("2", "estimates", which, (0..6).map(row).collect())
    }

    fn table_3(&self, which: usize, runs: &[Run]) -> PublishedTable {
        let of = |value: &dyn Fn(&Run) -> f64| Distribution::new(runs.iter().map(value));
        let column = &COLUMNS[which];
        let row = |i: usize| {
            let error = |kg_m2| self.course.error_percent(i, kg_m2);
            Row::new(ELEMENT_NAMES[i], "%")
                .ours(Some(column.error_percent[i]), &of(&|run| error(run.estimates[which][i])))
                .bound(self.course.bound_percent(i))
                .own(&of(&|run| error(run.own[i])))
        };
        self.table("3", "errors", which, (0..6).map(row).collect())
    }

    /// The figures of the paper: 1 and 2 of the truth, 3 and 4 of all runs.
    pub fn figures(&self, runs: &[Run]) -> Result<Vec<PaperFigure>, PapersFailed> {
        let instants = &self.course.flight.instants;
        let wheels = &self.course.craft().wheels;
        let angles = flight::euler_angles("Euler angles of the slew ([Kim2010] Fig. 1)", instants)?;
        let title = "Angular rates and control inputs of the slew ([Kim2010] Fig. 2)";
        let inputs = flight::rates_and_control(title, instants, wheels)?;
        Ok(vec![
            figure(PAPER, "figure-1.svg", angles),
            figure(PAPER, "figure-2.svg", inputs),
            figure(PAPER, "figure-3.svg", self.estimates(runs)?),
            figure(PAPER, "figure-4.svg", self.errors(runs)?),
        ])
    }

    fn estimates(&self, runs: &[Run]) -> Result<String, PlotError> {
        let span = (-0.5, COLUMNS.len() as f64 - 0.5);
        let panel = |i: usize| {
            let truth = self.course.truth_kg_m2()[i];
            let published = |column: &Column| column.estimated_kg_m2[i];
            by_method(runs, format!("{}, kg m²", ELEMENT_NAMES[i]), published, &|kg_m2| kg_m2[i])
                .with(Series::level("true", Mark::Dashes, Colour::Truth, span, truth))
        };
        let title = format!("Estimates by method, {} runs ([Kim2010] Fig. 3, Table 2)", runs.len());
        Figure::grid(title, "", 2, (0..6).map(panel).collect()).draw()
    }

    fn errors(&self, runs: &[Run]) -> Result<String, PlotError> {
        let panel = |i: usize| {
            let published = |column: &Column| column.error_percent[i];
            let label = format!("{} error, %", ELEMENT_NAMES[i]);
            let percent = |kg_m2: &[f64; 6]| self.course.error_percent(i, kg_m2[i]);
            by_method(runs, label, published, &percent).logarithmic()
        };
        let title = format!("Errors by method, {} runs ([Kim2010] Fig. 4, Table 3)", runs.len());
        Figure::grid(title, "", 2, (0..6).map(panel).collect()).draw()
    }
}

/// A value for each method: ours with its spread, and the published one.
fn by_method(
    runs: &[Run],
    label: String,
    published: impl Fn(&Column) -> f64,
    value: &dyn Fn(&[f64; 6]) -> f64,
) -> Panel {
    /// Ours and the published one stand side by side.
    const APART: f64 = 0.12;
    let dots = (0..COLUMNS.len()).map(|which| {
        let ours = Distribution::new(runs.iter().map(|run| value(&run.estimates[which])));
        Dot {
            x: which as f64 - APART,
            value: ours.mean().unwrap_or(f64::NAN),
            reach: ours.standard_deviation().unwrap_or(0.0),
        }
    });
    let printed = COLUMNS.iter().enumerate();
    let printed = printed.map(|(which, column)| (which as f64 + APART, published(column)));
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
    /// Half a unit of the last digit of Table 2, and of Table 3.
    const HALF_DIGIT_KG_M2: f64 = 0.5e-4;
    const HALF_DIGIT_PERCENT: f64 = 0.5e-4;

    #[test]
    fn table_3_follows_from_table_2() {
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
