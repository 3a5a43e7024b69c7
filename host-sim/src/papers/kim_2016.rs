//! \[Kim2016\]: rate filter, Savitzky-Golay derivative over six samples, batch least squares.
//!
//! Tables 3 and 4 lost their numbers in printing; Tables 5 and 6 are reproduced. The paper calls
//! its polynomial quartic and prints a parabola's weights (Table 2, Eq. (10)): Table 5 is flown
//! with both.

use fsw_core::math::savgol::{Differentiator, Fit, Growth, Pushed};
use nalgebra::Vector3;

use super::course::{Course, OWN};
use super::distribution::Distribution;
use super::{PapersFailed, figure};
use crate::estimation::{EstimatorName, Method, Precision, SetUpError};
use crate::input::ELEMENT_NAMES;
use crate::report::papers_dir::PaperFigure;
use crate::report::plots::flight::{self, interpolated, true_accelerations};
use crate::report::plots::{Colour, Dot, Figure, Mark, Panel, Series};
use crate::report::published::{PublishedTable, Row};

const PAPER: &str = "Kim2016";

/// Table 5: RMS error of the acceleration on each axis by backward difference, deg/s².
const BACKWARD_DEG_S2: [f64; 3] = [0.0081, 0.0081, 0.0081];
/// Table 5: the same by Savitzky-Golay.
const SAVITZKY_GOLAY_DEG_S2: [f64; 3] = [0.0058, 0.0058, 0.0057];
/// Table 5: by how much the second is smaller, per cent.
const DIFFERENCE_PERCENT: [f64; 3] = [28.28, 28.58, 29.13];

/// Table 6: estimates, kg m².
const ESTIMATED_KG_M2: [f64; 6] = [14.1823, 17.2876, 20.2859, 0.0864, 0.1350, 0.6009];
/// Table 6: their errors, per cent.
const ERROR_PERCENT: [f64; 6] = [0.12, 0.07, 0.07, 0.39, 0.48, 0.12];

const PUBLISHED: Method = Method { estimator: EstimatorName::EkfSgfLls, precision: Precision::F64 };

/// Samples between two estimates: 40 s.
const BATCH_S: f64 = 40.0;
/// Ours: errors of the acceleration count from here on, s. The paper doesn't say how its filter
/// starts; ours starts on a noisy sample, and the large first corrections would drown the rest.
const SETTLED_S: f64 = 40.0;
/// Windows of Figure 1.
const WINDOWS: std::ops::RangeInclusive<usize> = 2..=20;
/// The longest of them, and then some.
const CAPACITY: usize = 32;
/// Squares of Figure 4 are averaged over so long, s.
const MSE_OVER_S: f64 = 10.0;

const AXES: [&str; 3] = ["x", "y", "z"];

/// The scenario.
pub struct Study {
    course: Course,
    /// Time halfway between samples, s, and true acceleration, rad/s².
    truth_rad_s2: Vec<(f64, [f64; 3])>,
}

/// One seed.
pub struct Run {
    /// RMS errors, deg/s².
    backward: [f64; 3],
    parabola: [f64; 3],
    quartic: [f64; 3],
    /// Estimates at the end of each batch, kg m².
    batches: Vec<[f64; 6]>,
    estimate: [f64; 6],
    own: [f64; 6],
}

impl Study {
    /// The truth of the scenario.
    pub fn new() -> Result<Self, PapersFailed> {
        let course = Course::load("kim-2016")?;
        let truth_rad_s2 = true_accelerations(&course.flight.instants).collect();
        Ok(Self { course, truth_rad_s2 })
    }

    /// Flies one seed.
    pub fn fly(&self, seed: u64) -> Result<Run, SetUpError> {
        let per_batch = (BATCH_S * self.course.scenario.gyro.rate_hz).round() as usize;
        let mut rates = Vec::with_capacity(self.course.flight.instants.len());
        let mut batches = Vec::new();
        let flown = self.course.fly(PUBLISHED, seed, |number, estimator| {
            rates.push(estimator.rate_rad_s());
            if number > 0 && number % per_batch == 0 {
                batches.push(estimator.estimate().inertia.elements_kg_m2());
            }
        })?;
        let own = self.course.fly(OWN, seed, |_, _| ())?;
        let rms = |fit| self.rms_error_deg_s2(&rates, fit);
        Ok(Run {
            backward: rms(backward_difference())?,
            parabola: rms(Fit::centred(6, 2, 1))?,
            quartic: rms(Fit::centred(6, 4, 1))?,
            batches,
            estimate: flown.estimate.inertia.elements_kg_m2(),
            own: own.estimate.inertia.elements_kg_m2(),
        })
    }

    /// Time, s, and error, rad/s², of the derivative of filtered rates.
    fn errors_rad_s2(
        &self,
        rates_rad_s: &[Vector3<f64>],
        fit: Fit<f64>,
    ) -> Result<Vec<(f64, [f64; 3])>, SetUpError> {
        let mut differentiator =
            Differentiator::<f64, 3, CAPACITY>::new(fit, Growth::WaitUntilFull, 0.1)?;
        let instants = self.course.flight.instants.iter().zip(rates_rad_s);
        let errors = instants.filter_map(|(instant, rate)| {
            let pushed = differentiator.push(instant.time_us, (*rate).into());
            let Pushed::Fitted(fitted) = pushed else { return None };
            let time_s = instant.time_us as f64 * 1e-6 - fitted.delay_s;
            let truth = interpolated(&self.truth_rad_s2, time_s)?;
            Some((time_s, std::array::from_fn(|i| fitted.derivative_per_s[i] - truth[i])))
        });
        Ok(errors.collect())
    }

    fn rms_error_deg_s2(
        &self,
        rates_rad_s: &[Vector3<f64>],
        fit: Fit<f64>,
    ) -> Result<[f64; 3], SetUpError> {
        let errors = self.errors_rad_s2(rates_rad_s, fit)?;
        let errors: Vec<_> = errors.into_iter().filter(|error| error.0 >= SETTLED_S).collect();
        let count = errors.len() as f64;
        Ok(std::array::from_fn(|i| {
            let square: f64 = errors.iter().map(|(_, error)| error[i] * error[i]).sum();
            (square / count).sqrt().to_degrees()
        }))
    }

    /// The tables of the paper.
    pub fn tables(&self, runs: &[Run]) -> Vec<PublishedTable> {
        vec![self.table_5(runs), self.table_6(runs)]
    }

    fn table(&self, number: &'static str, title: &str, rows: Vec<Row>) -> PublishedTable {
        PublishedTable {
            paper: PAPER,
            table: number,
            title: title.to_owned(),
            scenario: self.course.scenario.name.clone(),
            estimator: PUBLISHED.estimator.to_string(),
            precision: PUBLISHED.precision.to_string(),
            own_estimator: None,
            observed_directions: self.course.flight.bound.observed_directions,
            rows,
            remark: None,
        }
    }

    fn table_5(&self, runs: &[Run]) -> PublishedTable {
        let of = |value: &dyn Fn(&Run) -> f64| Distribution::new(runs.iter().map(value));
        let less = |from: f64, to: f64| 100.0 * (1.0 - to / from);
        let mut rows = Vec::new();
        for (i, axis) in AXES.iter().enumerate() {
            let rms = |name: &str, published, ours| {
                Row::new(format!("{axis} {name}"), "deg/s2").ours(Some(published), &ours)
            };
            let difference = |name: &str, ours| {
                Row::new(format!("{axis} {name}"), "%").ours(Some(DIFFERENCE_PERCENT[i]), &ours)
            };
            rows.push(rms("backward difference", BACKWARD_DEG_S2[i], of(&|run| run.backward[i])));
            let published = SAVITZKY_GOLAY_DEG_S2[i];
            rows.push(rms("SGF, as printed", published, of(&|run| run.parabola[i])));
            let printed = of(&|run| less(run.backward[i], run.parabola[i]));
            rows.push(difference("less, as printed", printed).remark(PARABOLA));
            rows.push(rms("SGF, quartic", published, of(&|run| run.quartic[i])));
            let quartic = of(&|run| less(run.backward[i], run.quartic[i]));
            rows.push(difference("less, quartic", quartic).remark(QUARTIC));
        }
        let title = "RMS error of the angular acceleration of the filtered rates";
        let mut table = self.table("5", title, rows);
        table.remark = Some(format!(
            "Ours from {SETTLED_S} s on. How noisy the filtered rates are follows from the process \
             noise, which was lost in printing."
        ));
        table
    }

    fn table_6(&self, runs: &[Run]) -> PublishedTable {
        let of = |value: &dyn Fn(&Run) -> f64| Distribution::new(runs.iter().map(value));
        let our_noise = of(&|run| run.parabola[0]).mean().unwrap_or(f64::NAN);
        let against_table_5 = format!(
            "hardly goes with Table 5: noise of the acceleration pulls least squares off, ours as \
             far with {:.0} times less of it",
            SAVITZKY_GOLAY_DEG_S2[0] / our_noise
        );
        let mut rows = Vec::new();
        for i in 0..6 {
            rows.push(
                Row::new(ELEMENT_NAMES[i], "kg m2")
                    .truth(self.course.truth_kg_m2()[i])
                    .ours(Some(ESTIMATED_KG_M2[i]), &of(&|run| run.estimate[i]))
                    .bound(self.course.bound_kg_m2(i))
                    .own(&of(&|run| run.own[i])),
            );
        }
        for i in 0..6 {
            let error = |kg_m2| self.course.error_percent(i, kg_m2);
            let bound = self.course.bound_percent(i);
            let row = Row::new(format!("{} error", ELEMENT_NAMES[i]), "%")
                .ours(Some(ERROR_PERCENT[i]), &of(&|run| error(run.estimate[i])))
                .bound(bound)
                .own(&of(&|run| error(run.own[i])));
            let is_below = bound.is_some_and(|bound| ERROR_PERCENT[i] < bound);
            rows.push(match is_below {
                true => row.remark(BELOW_BOUND),
                false => row.remark(against_table_5.clone()),
            });
        }
        let mut table = self.table("6", "estimates at the end, and their errors", rows);
        table.own_estimator = Some(OWN.estimator.to_string());
        table
    }

    /// The figures of the paper: 1 to 4 of the first seed, 5 of all runs.
    pub fn figures(&self, seed: u64, runs: &[Run]) -> Result<Vec<PaperFigure>, PapersFailed> {
        let (_, history) = self.course.history(PUBLISHED, seed)?;
        let truth = &self.course.flight.instants;
        let rates: Vec<Vector3<f64>> =
            history.iter().map(|row| row.estimated_rate_rad_s.into()).collect();
        let by = |what: &str, figure: u32| {
            format!("{what}, ekf-sgf-lls, seed {seed} ([Kim2016] Fig. {figure})")
        };
        let filtered = flight::rates(&by("Angular rate filtered by the EKF", 2), &history)?;
        let errors = flight::rate_errors(&by("Error of the filtered rate", 3), &history, truth)?;
        Ok(vec![
            figure(PAPER, "figure-1.svg", self.window_sizes(&rates)?.draw()?),
            figure(PAPER, "figure-2.svg", filtered),
            figure(PAPER, "figure-3.svg", errors),
            figure(PAPER, "figure-4.svg", self.mean_squares(&rates)?.draw()?),
            figure(PAPER, "figure-5.svg", self.over_batches(runs).draw()?),
        ])
    }

    fn window_sizes(&self, rates: &[Vector3<f64>]) -> Result<Figure, SetUpError> {
        let mut points: [[Vec<(f64, f64)>; 2]; 3] = Default::default();
        for window in WINDOWS {
            for (which, order) in [2, 4].into_iter().enumerate() {
                if window <= order {
                    continue;
                }
                let rms = self.rms_error_deg_s2(rates, Fit::centred(window, order, 1))?;
                for axis in 0..3 {
                    points[axis][which].push((window as f64, rms[axis]));
                }
            }
        }
        let backward = self.rms_error_deg_s2(rates, backward_difference())?;
        let panels = points.into_iter().enumerate().map(|(axis, [parabola, quartic])| {
            let span = (*WINDOWS.start() as f64, *WINDOWS.end() as f64);
            let level = backward[axis];
            Panel::new(format!("RMS error {}, deg/s²", AXES[axis]))
                .with(Series::level(
                    "backward difference",
                    Mark::Dashes,
                    Colour::Truth,
                    span,
                    level,
                ))
                .with(Series::curve("parabola", Mark::Line, Colour::Main, parabola))
                .with(Series::curve("quartic", Mark::Line, Colour::Other, quartic))
        });
        let title =
            "Error of the acceleration against window size ([Kim2016] Fig. 1; 6 was chosen)";
        Ok(Figure::stacked(title, "samples in the window", panels.collect()))
    }

    fn mean_squares(&self, rates: &[Vector3<f64>]) -> Result<Figure, SetUpError> {
        let per_stretch = (MSE_OVER_S * self.course.scenario.gyro.rate_hz).round() as usize;
        let mean_squares = |fit, axis: usize| -> Result<Vec<(f64, f64)>, SetUpError> {
            let errors = self.errors_rad_s2(rates, fit)?;
            let stretches = errors.chunks_exact(per_stretch);
            let mean_square = |stretch: &[(f64, [f64; 3])]| {
                let squares = stretch.iter().map(|(_, error)| error[axis].to_degrees().powi(2));
                (stretch[0].0 + MSE_OVER_S / 2.0, squares.sum::<f64>() / stretch.len() as f64)
            };
            Ok(stretches.map(mean_square).collect())
        };
        let panel = |axis: usize| {
            let backward = mean_squares(backward_difference(), axis)?;
            let printed = mean_squares(Fit::centred(6, 2, 1), axis)?;
            let quartic = mean_squares(Fit::centred(6, 4, 1), axis)?;
            Ok(Panel::new(format!("MSE {}, (deg/s²)²", AXES[axis]))
                .with(Series::curve("backward difference", Mark::Line, Colour::Truth, backward))
                .with(Series::curve("SGF, as printed", Mark::Line, Colour::Main, printed))
                .with(Series::curve("SGF, quartic", Mark::Line, Colour::Other, quartic))
                .logarithmic())
        };
        let panels = (0..3).map(panel).collect::<Result<_, SetUpError>>()?;
        let title = "Mean square error of the acceleration over 10 s each ([Kim2016] Fig. 4)";
        Ok(Figure::stacked(title, "time, s", panels))
    }

    fn over_batches(&self, runs: &[Run]) -> Figure {
        let count = runs.first().map_or(0, |run| run.batches.len());
        let panel = |i: usize| {
            let dots = (0..count).map(|k| {
                let of_batch = Distribution::new(runs.iter().map(|run| run.batches[k][i]));
                Dot {
                    x: (k + 1) as f64,
                    value: of_batch.mean().unwrap_or(f64::NAN),
                    reach: of_batch.standard_deviation().unwrap_or(0.0),
                }
            });
            let truth = self.course.truth_kg_m2()[i];
            let span = (1.0, count as f64);
            Panel::new(format!("{}, kg m²", ELEMENT_NAMES[i]))
                .with(Series::level("true", Mark::Dashes, Colour::Truth, span, truth))
                .with(Series::dots("estimated: mean ± standard deviation", Colour::Main, dots))
        };
        let title = format!("Estimates of {} runs, one every 40 s ([Kim2016] Fig. 5)", runs.len());
        let panels = (0..6).map(panel).collect();
        Figure::grid(title, "number of estimation processes", 3, panels)
    }
}

const PARABOLA: &str = "the weights of Table 2 and Eq. (10), labelled quartic, are a parabola's";
const QUARTIC: &str = "a true quartic: 28.4 % less in the limit of a slow filter, as published, so \
                       likely what the paper ran";
const BELOW_BOUND: &str = "below the bound: one lucky run";

/// \[Kim2016\] Eq. (11): the straight line through two samples, at the newer one.
fn backward_difference() -> Fit<f64> {
    Fit::newest(2, 1, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a unit of the last digit of what is printed.
    const HALF_DIGIT_PERCENT: f64 = 0.005;

    #[test]
    fn the_errors_of_table_6_follow_from_its_estimates() {
        const TRUE_KG_M2: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
        for i in 0..6 {
            let error = 100.0 * (ESTIMATED_KG_M2[i] / TRUE_KG_M2[i] - 1.0).abs();
            let rounding = 100.0 * 0.5e-4 / TRUE_KG_M2[i] + HALF_DIGIT_PERCENT;
            assert!((error - ERROR_PERCENT[i]).abs() < rounding, "{}: {error}", ELEMENT_NAMES[i]);
        }
    }

    #[test]
    fn the_differences_of_table_5_follow_from_its_columns() {
        for i in 0..3 {
            let ratio = SAVITZKY_GOLAY_DEG_S2[i] / BACKWARD_DEG_S2[i];
            let difference = 100.0 * (1.0 - ratio);
            let digit = 0.5e-4 / BACKWARD_DEG_S2[i];
            let rounding = 100.0 * digit * (1.0 + ratio) + HALF_DIGIT_PERCENT;
            assert!((difference - DIFFERENCE_PERCENT[i]).abs() < rounding, "{difference}");
        }
    }

    /// The derivative of a random walk of the rate, which is what a slow filter leaves: each step
    /// counts with the sum of the weights after it, and a backward difference with one.
    #[test]
    fn a_true_quartic_gives_the_published_difference_on_a_random_walk() {
        use fsw_core::math::savgol::Kernel;
        let less_percent = |order| {
            let kernel = Kernel::<f64, 6>::new(&Fit::centred(6, order, 1)).unwrap();
            let weights = kernel.weights();
            let steps = (1..6).map(|k| weights[k..].iter().sum::<f64>().powi(2));
            100.0 * (1.0 - steps.sum::<f64>().sqrt())
        };
        assert!((less_percent(4) - 28.4).abs() < 0.1, "{}", less_percent(4));
        assert!((less_percent(2) - 54.0).abs() < 0.1, "{}", less_percent(2));
    }
}
