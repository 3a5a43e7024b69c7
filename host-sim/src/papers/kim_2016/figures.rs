//! Figures 1 to 5 of \[Kim2016\].

use fsw_core::math::savgol::Fit;
use nalgebra::Vector3;

use super::trial::{Kim2016, Kim2016Trial, PUBLISHED, backward_difference};
use crate::estimation::SetUpError;
use crate::input::ELEMENT_NAMES;
use crate::papers::distribution::Distribution;
use crate::papers::paper::{Paper, PapersFailed};
use crate::report::plots::{Colour, Dot, Figure, Mark, Panel, Series, flight};
use crate::report::published::PaperFigure;

/// Windows of Figure 1, samples.
const WINDOWS: std::ops::RangeInclusive<usize> = 2..=20;
/// Averaging interval of Figure 4, s.
const MSE_OVER_S: f64 = 10.0;

const AXES: [&str; 3] = ["x", "y", "z"];

impl Kim2016 {
    /// Figures 1 to 4 of the first seed, 5 of all trials.
    pub(super) fn all_figures(
        &self,
        first_seed: u64,
        trials: &[Kim2016Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        let (_, history) = self.case.history(PUBLISHED, first_seed)?;
        let truth = &self.case.flight.instants;
        let rates: Vec<Vector3<f64>> =
            history.iter().map(|row| row.estimated_rate_rad_s.into()).collect();
        let title = |quantity: &str, figure: u32| {
            format!("{quantity}, ekf-sgf-lls, seed {first_seed} ([Kim2016] Fig. {figure})")
        };
        let filtered = flight::rates(&title("Angular rate filtered by the EKF", 2), &history);
        let errors = title("Error of the filtered rate", 3);
        let errors = flight::rate_errors(&errors, &history, truth);
        Ok(vec![
            Self::figure("figure-1", self.window_sizes(&rates)?),
            Self::figure("figure-2", filtered),
            Self::figure("figure-3", errors),
            Self::figure("figure-4", self.mean_squares(&rates)?),
            Self::figure("figure-5", self.over_batches(trials)),
        ])
    }

    /// RMS error of the acceleration by window size and order of the polynomial.
    fn window_sizes(&self, rates: &[Vector3<f64>]) -> Result<Figure, SetUpError> {
        let mut points: [[Vec<(f64, f64)>; 2]; 3] = Default::default();
        for window in WINDOWS {
            for (index, order) in [2, 4].into_iter().enumerate() {
                if window <= order {
                    continue;
                }
                let rms = self.rms_error_deg_s2(rates, Fit::centred(window, order, 1))?;
                for axis in 0..3 {
                    points[axis][index].push((window as f64, rms[axis]));
                }
            }
        }
        let backward = self.rms_error_deg_s2(rates, backward_difference())?;
        let span = (*WINDOWS.start() as f64, *WINDOWS.end() as f64);
        let panels = points.into_iter().enumerate().map(|(axis, [parabola, quartic])| {
            let backward = Series::level(
                "backward difference",
                Mark::Dashes,
                Colour::Truth,
                span,
                backward[axis],
            );
            Panel::new(format!("RMS error {}, deg/s²", AXES[axis]))
                .with(backward)
                .with(Series::curve("parabola", Mark::Line, Colour::Main, parabola))
                .with(Series::curve("quartic", Mark::Line, Colour::Other, quartic))
        });
        let title =
            "Error of the acceleration against window size ([Kim2016] Fig. 1; 6 was chosen)";
        Ok(Figure::stacked(title, "samples in the window", panels.collect()))
    }

    /// Mean square error of the acceleration over intervals of [`MSE_OVER_S`].
    fn mean_squares(&self, rates: &[Vector3<f64>]) -> Result<Figure, SetUpError> {
        let samples = (MSE_OVER_S * self.case.scenario.gyro.rate_hz).round() as usize;
        let mean_squares = |fit, axis: usize| -> Result<Vec<(f64, f64)>, SetUpError> {
            let errors = self.errors_rad_s2(rates, fit)?;
            let mean_square = |interval: &[(f64, [f64; 3])]| {
                let squares = interval.iter().map(|(_, error)| error[axis].to_degrees().powi(2));
                (interval[0].0 + MSE_OVER_S / 2.0, squares.sum::<f64>() / interval.len() as f64)
            };
            Ok(errors.chunks_exact(samples).map(mean_square).collect())
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

    /// Estimates at the end of each batch: mean and standard deviation over the trials.
    fn over_batches(&self, trials: &[Kim2016Trial]) -> Figure {
        let count = trials.first().map_or(0, |trial| trial.batches.len());
        let panel = |i: usize| {
            let dots = (0..count).map(|k| {
                let of_batch = Distribution::over(trials, |trial| trial.batches[k][i]);
                Dot {
                    x: (k + 1) as f64,
                    value: of_batch.mean().unwrap_or(f64::NAN),
                    reach: of_batch.standard_deviation().unwrap_or(0.0),
                }
            });
            let truth = self.case.truth_kg_m2()[i];
            let span = (1.0, count as f64);
            Panel::new(format!("{}, kg m²", ELEMENT_NAMES[i]))
                .with(Series::level("true", Mark::Dashes, Colour::Truth, span, truth))
                .with(Series::dots("estimated: mean ± standard deviation", Colour::Main, dots))
        };
        let title =
            format!("Estimates of {} runs, one every 40 s ([Kim2016] Fig. 5)", trials.len());
        let panels = (0..6).map(panel).collect();
        Figure::grid(title, "number of estimation processes", 3, panels)
    }
}
