//! \[Kim2013\]: rate filter, causal Savitzky-Golay derivative, recursive least squares.
//!
//! The slides print the errors of a single flight, and the errors over time averaged over 10,000
//! flights.

use super::case::{Case, OWN};
use super::distribution::Distribution;
use super::paper::{Paper, PapersFailed};
use crate::estimation::{EstimatorName, Method, Precision, SetUpError};
use crate::input::ELEMENT_NAMES;
use crate::report::plots::flight;
use crate::report::published::{PaperFigure, PublishedTable, Row};

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

/// Interval of the errors in the average over time, samples. Reading an estimate costs more than a
/// step.
const AVERAGED_EVERY: usize = 10;

/// The scenario, and its bound at each time of the table.
pub struct Kim2013 {
    case: Case,
    bound_percent: Vec<[Option<f64>; 3]>,
}

/// Errors of one seed.
pub struct Kim2013Trial {
    published: Errors,
    own: Errors,
}

/// Absolute errors of jxx, jyy, jzz, per cent.
struct Errors {
    /// Mean over the flight.
    average: [f64; 3],
    /// At the times of [`ERROR_OVER_TIME_PERCENT`].
    over_time: Vec<[f64; 3]>,
}

impl Paper for Kim2013 {
    type Trial = Kim2013Trial;

    const KEY: &'static str = "Kim2013";

    fn load() -> Result<Self, PapersFailed> {
        let case = Case::load("kim-2013")?;
        let mut bound_percent = Vec::new();
        for (time_s, _) in ERROR_OVER_TIME_PERCENT {
            let mut until = case.scenario.clone();
            until.duration_s = time_s;
            bound_percent.push(match time_s > 0.0 {
                true => {
                    let until = Case::new(until)?;
                    std::array::from_fn(|i| until.bound_percent(i))
                }
                false => [None; 3],
            });
        }
        Ok(Self { case, bound_percent })
    }

    fn fly(&self, seed: u64) -> Result<Kim2013Trial, PapersFailed> {
        Ok(Kim2013Trial { published: self.errors(PUBLISHED, seed)?, own: self.errors(OWN, seed)? })
    }

    fn tables(&self, trials: &[Kim2013Trial]) -> Vec<PublishedTable> {
        vec![self.one_flight(trials), self.over_time(trials)]
    }

    /// The figures of the slides, of the first seed.
    fn figures(
        &self,
        first_seed: u64,
        _trials: &[Kim2013Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        let (_, history) = self.case.history(PUBLISHED, first_seed)?;
        let truth = &self.case.flight.instants;
        let inertia = self.case.truth_kg_m2();
        let title = |quantity: &str, slide: u32| {
            format!("{quantity}, ekf-sgf-rls, seed {first_seed} ([Kim2013] slide {slide})")
        };
        let rates = flight::rates(&title("Angular rate filtered by the EKF", 13), &history);
        let errors = title("Error of the filtered rate", 13);
        let errors = flight::rate_errors(&errors, &history, truth);
        let accelerations = title("Angular acceleration by the SGF", 14);
        let accelerations = flight::accelerations(&accelerations, &history, Some(truth));
        let acceleration_errors = title("Error of the angular acceleration by the SGF", 15);
        let acceleration_errors =
            flight::acceleration_errors(&acceleration_errors, &history, truth);
        let moments = title("Moments of inertia by RLS", 16);
        let moments = flight::inertia(&moments, &history, Some(truth), &[0, 1, 2]);
        let percent = title("Error over time", 16);
        let percent = flight::inertia_errors(&percent, &history, inertia, &[0, 1, 2]);
        Ok(vec![
            Self::figure("slide-13-rates", rates),
            Self::figure("slide-13-rate-errors", errors),
            Self::figure("slide-14-accelerations", accelerations),
            Self::figure("slide-15-acceleration-errors", acceleration_errors),
            Self::figure("slide-16-inertia", moments),
            Self::figure("slide-16-inertia-errors", percent),
        ])
    }
}

impl Kim2013 {
    fn errors(&self, method: Method, seed: u64) -> Result<Errors, SetUpError> {
        let samples_per_s = self.case.scenario.gyro.rate_hz;
        let sample = |time_s: f64| (time_s * samples_per_s).round() as usize;
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        let mut over_time = Vec::new();
        self.case.fly(method, seed, |index, estimator| {
            let is_tabled = ERROR_OVER_TIME_PERCENT.iter().any(|(t, _)| sample(*t) == index);
            if !is_tabled && index % AVERAGED_EVERY != 0 {
                return;
            }
            let elements = estimator.estimate().inertia.elements_kg_m2();
            let error = std::array::from_fn(|i| self.case.error_percent(i, elements[i]));
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

    fn table(&self, place: &'static str, title: &str, rows: Vec<Row>) -> PublishedTable {
        PublishedTable::new(Self::KEY, place, title, &self.case, PUBLISHED, rows)
    }

    fn one_flight(&self, trials: &[Kim2013Trial]) -> PublishedTable {
        let last = |errors: &Errors, i: usize| errors.over_time.last().map_or(f64::NAN, |e| e[i]);
        let average = |i: usize| {
            let ours = Distribution::over(trials, |trial| trial.published.average[i]);
            Row::new(format!("{} average", ELEMENT_NAMES[i]), "%")
                .ours(Some(AVERAGE_ERROR_PERCENT[i]), &ours)
                .own(&Distribution::over(trials, |trial| trial.own.average[i]))
        };
        let at_end = |i: usize| {
            let ours = Distribution::over(trials, |trial| last(&trial.published, i));
            Row::new(format!("{} final", ELEMENT_NAMES[i]), "%")
                .ours(Some(FINAL_ERROR_PERCENT[i]), &ours)
                .bound(self.case.bound_percent(i))
                .own(&Distribution::over(trials, |trial| last(&trial.own, i)))
        };
        let rows = (0..3).map(average).chain((0..3).map(at_end)).collect();
        let title = "error of one flight, averaged over its time and at its end";
        self.table("slide 16", title, rows).remark(format!(
            "The slides do not give the gyro rate, the process noise and the initial covariance, \
             which determine these errors. {} has a prior on the products, zero with one sigma \
             0.01 kg m²; the bound has none.",
            OWN.estimator
        ))
    }

    fn over_time(&self, trials: &[Kim2013Trial]) -> PublishedTable {
        let mut rows = Vec::new();
        for (k, (time_s, published)) in ERROR_OVER_TIME_PERCENT.iter().enumerate() {
            for i in 0..3 {
                let at = |errors: &Errors| errors.over_time.get(k).map(|error| error[i]);
                let ours = trials.iter().filter_map(|trial| at(&trial.published));
                let own = trials.iter().filter_map(|trial| at(&trial.own));
                rows.push(
                    Row::new(format!("{} at {time_s} s", ELEMENT_NAMES[i]), "%")
                        .ours(Some(published[i]), &Distribution::new(ours))
                        .bound(self.bound_percent[k][i])
                        .own(&Distribution::new(own)),
                );
            }
        }
        self.table("slide 17", "error over time, mean of 10,000 trials", rows).remark(
            "The published values are means over the trials and compare with the means here. The \
             percentile refers to single runs.",
        )
    }
}
