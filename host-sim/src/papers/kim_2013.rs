//! \[Kim2013\]: rate filter, causal Savitzky-Golay derivative, recursive least squares.
//!
//! The slides have one error table of a single flight, and one over time of 10,000.

use super::course::{Course, OWN};
use super::distribution::Distribution;
use super::{PapersFailed, figure};
use crate::estimation::{EstimatorName, Method, Precision, SetUpError};
use crate::input::ELEMENT_NAMES;
use crate::report::papers_dir::PaperFigure;
use crate::report::plots::flight;
use crate::report::published::{PublishedTable, Row};

const PAPER: &str = "Kim2013";

/// Error of one flight averaged over its time, per cent: jxx, jyy, jzz.
const AVERAGE_ERROR_PERCENT: [f64; 3] = [10.71, 10.66, 8.47];
/// Error of that flight at its end, per cent.
const FINAL_ERROR_PERCENT: [f64; 3] = [2.38, 2.60, 2.50];

/// Time, s, and error averaged over 10,000 trials, per cent.
const ERROR_OVER_TIME_PERCENT: [(f64, [f64; 3]); 7] = [
    (0.0, [50.0, 50.0, 50.0]),
    (100.0, [10.50, 11.57, 8.30]),
    (200.0, [5.05, 6.64, 6.43]),
    (300.0, [4.78, 5.56, 5.43]),
    (400.0, [5.84, 5.16, 5.32]),
    (500.0, [5.60, 4.63, 4.76]),
    (600.0, [2.84, 2.89, 2.84]),
];

const PUBLISHED: Method = Method { estimator: EstimatorName::EkfSgfRls, precision: Precision::F64 };

/// An error is taken at every so many samples for its average over time: reading an estimate out
/// costs more than the step that makes it.
const AVERAGED_EVERY: usize = 10;

/// The scenario, and the bound at each time of the table.
pub struct Study {
    course: Course,
    bound_percent: Vec<[Option<f64>; 3]>,
}

/// One seed.
pub struct Run {
    published: Errors,
    own: Errors,
}

/// Sizes of errors of jxx, jyy, jzz in per cent.
struct Errors {
    average: [f64; 3],
    over_time: Vec<[f64; 3]>,
}

impl Study {
    /// The truth of the scenario.
    pub fn new() -> Result<Self, PapersFailed> {
        let course = Course::load("kim-2013")?;
        let mut bound_percent = Vec::new();
        for (time_s, _) in ERROR_OVER_TIME_PERCENT {
            let mut until = course.scenario.clone();
            until.duration_s = time_s;
            bound_percent.push(match time_s > 0.0 {
                true => {
                    let until = Course::new(until)?;
                    std::array::from_fn(|i| until.bound_percent(i))
                }
                false => [None; 3],
            });
        }
        Ok(Self { course, bound_percent })
    }

    /// Flies one seed.
    pub fn fly(&self, seed: u64) -> Result<Run, SetUpError> {
        Ok(Run { published: self.errors(PUBLISHED, seed)?, own: self.errors(OWN, seed)? })
    }

    fn errors(&self, method: Method, seed: u64) -> Result<Errors, SetUpError> {
        let samples_per_s = self.course.scenario.gyro.rate_hz;
        let sample = |time_s: f64| (time_s * samples_per_s).round() as usize;
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        let mut over_time = Vec::new();
        self.course.fly(method, seed, |number, estimator| {
            let is_tabled = ERROR_OVER_TIME_PERCENT.iter().any(|(t, _)| sample(*t) == number);
            if !is_tabled && number % AVERAGED_EVERY != 0 {
                return;
            }
            let elements = estimator.estimate().inertia.elements_kg_m2();
            let error = std::array::from_fn(|i| self.course.error_percent(i, elements[i]));
            for i in 0..3 {
                sum[i] += error[i];
            }
            count += 1.0;
            if is_tabled {
                over_time.push(error);
            }
        })?;
        Ok(Errors { average: sum.map(|sum| sum / count), over_time })
    }

    /// The tables of the slides.
    pub fn tables(&self, runs: &[Run]) -> Vec<PublishedTable> {
        vec![self.one_flight(runs), self.over_time(runs)]
    }

    fn table(&self, place: &'static str, title: &str, rows: Vec<Row>) -> PublishedTable {
        PublishedTable {
            paper: PAPER,
            table: place,
            title: title.to_owned(),
            scenario: self.course.scenario.name.clone(),
            estimator: PUBLISHED.estimator.to_string(),
            precision: PUBLISHED.precision.to_string(),
            own_estimator: Some(OWN.estimator.to_string()),
            observed_directions: self.course.flight.bound.observed_directions,
            rows,
            remark: None,
        }
    }

    fn one_flight(&self, runs: &[Run]) -> PublishedTable {
        let of = |value: &dyn Fn(&Run) -> f64| Distribution::new(runs.iter().map(value));
        let last = |errors: &Errors, i: usize| errors.over_time.last().map_or(f64::NAN, |e| e[i]);
        let mut rows = Vec::new();
        for i in 0..3 {
            let ours = of(&|run| run.published.average[i]);
            rows.push(
                Row::new(format!("{} average", ELEMENT_NAMES[i]), "%")
                    .ours(Some(AVERAGE_ERROR_PERCENT[i]), &ours)
                    .own(&of(&|run| run.own.average[i])),
            );
        }
        for i in 0..3 {
            let ours = of(&|run| last(&run.published, i));
            rows.push(
                Row::new(format!("{} final", ELEMENT_NAMES[i]), "%")
                    .ours(Some(FINAL_ERROR_PERCENT[i]), &ours)
                    .bound(self.course.bound_percent(i))
                    .own(&of(&|run| last(&run.own, i))),
            );
        }
        let title = "error of one flight, averaged over its time and at its end";
        let mut table = self.table("slide 16", title, rows);
        table.remark = Some(format!(
            "Gyro rate, process noise and initial covariance, which set these errors, aren't given. \
             {} is told that the products are zero, one sigma 0.01 kg m², the bound isn't.",
            OWN.estimator
        ));
        table
    }

    fn over_time(&self, runs: &[Run]) -> PublishedTable {
        let mut rows = Vec::new();
        for (k, (time_s, published)) in ERROR_OVER_TIME_PERCENT.iter().enumerate() {
            for i in 0..3 {
                let of = |value: &dyn Fn(&Run) -> Option<f64>| {
                    Distribution::new(runs.iter().filter_map(value))
                };
                let at = |errors: &Errors| errors.over_time.get(k).map(|error| error[i]);
                rows.push(
                    Row::new(format!("{} at {time_s} s", ELEMENT_NAMES[i]), "%")
                        .ours(Some(published[i]), &of(&|run| at(&run.published)))
                        .bound(self.bound_percent[k][i])
                        .own(&of(&|run| at(&run.own))),
                );
            }
        }
        let mut table = self.table("slide 17", "error over time, mean of 10,000 trials", rows);
        table.remark = Some(
            "The published values are means, to be set beside our means; the percentile is among \
             single runs."
                .to_owned(),
        );
        table
    }

    /// The figures of the slides, of the first seed.
    pub fn figures(&self, seed: u64) -> Result<Vec<PaperFigure>, PapersFailed> {
        let (_, history) = self.course.history(PUBLISHED, seed)?;
        let truth = &self.course.flight.instants;
        let inertia = self.course.truth_kg_m2();
        let by = |what: &str, slide: u32| {
            format!("{what}, ekf-sgf-rls, seed {seed} ([Kim2013] slide {slide})")
        };
        let rates = flight::rates(&by("Angular rate filtered by the EKF", 13), &history)?;
        let errors = flight::rate_errors(&by("Error of the filtered rate", 13), &history, truth)?;
        let accelerations = flight::accelerations(
            &by("Angular acceleration by the SGF", 14),
            &history,
            Some(truth),
        )?;
        let acceleration_errors = flight::acceleration_errors(
            &by("Error of the angular acceleration by the SGF", 15),
            &history,
            truth,
        )?;
        let moments = flight::inertia(
            &by("Moments of inertia by RLS", 16),
            &history,
            Some(truth),
            &[0, 1, 2],
        )?;
        let percent =
            flight::inertia_errors(&by("Error over time", 16), &history, inertia, &[0, 1, 2])?;
        Ok(vec![
            figure(PAPER, "slide-13-rates.svg", rates),
            figure(PAPER, "slide-13-rate-errors.svg", errors),
            figure(PAPER, "slide-14-accelerations.svg", accelerations),
            figure(PAPER, "slide-15-acceleration-errors.svg", acceleration_errors),
            figure(PAPER, "slide-16-inertia.svg", moments),
            figure(PAPER, "slide-16-inertia-errors.svg", percent),
        ])
    }
}
