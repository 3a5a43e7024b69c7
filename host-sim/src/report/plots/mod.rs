//! The three plots of a report: what was measured, how well it was predicted, what it says of the
//! inertia.

mod clip;
mod decimate;
mod figure;
mod ticks;

use super::history::HistoryRow;
use crate::input::ELEMENT_NAMES;
use figure::{Colour, Curve, Figure, Mark, Panel};

pub use figure::PlotError;

/// The part of the time, from the start, whose errors need not fit a panel of an inertia element.
///
/// At first nothing is known: on a scale that shows that, the rest would be a straight line.
const SETTLING: f64 = 0.25;
/// Sigmas of a band: 99.7 % of a normal distribution.
const BAND_SIGMAS: f64 = 3.0;

/// Body rates, measured and estimated, as SVG; a panel per axis.
pub fn rates(history: &[HistoryRow]) -> Result<String, PlotError> {
    let panel = |axis: usize, name: &str| {
        Panel::new(format!("rate {name}, rad/s"))
            .curve(Curve::new("measured", Mark::Wide, Colour::Light, history, |row| {
                Some(row.measured_rate_rad_s[axis])
            }))
            .curve(Curve::new("estimated", Mark::Thin, Colour::Main, history, |row| {
                Some(row.estimated_rate_rad_s[axis])
            }))
    };
    Figure::stacked("Body rate", [panel(0, "x"), panel(1, "y"), panel(2, "z")]).draw()
}

/// Measured minus predicted rate with the ±3 sigma that the estimator expects, as SVG.
pub fn innovations(history: &[HistoryRow]) -> Result<String, PlotError> {
    let panel = |axis: usize, name: &str| {
        Panel::new(format!("innovation {name}, rad/s"))
            .band("±3 sigma expected", history, |row| {
                let reach = BAND_SIGMAS * row.innovation_sigma_rad_s?[axis];
                Some((-reach, reach))
            })
            .curve(Curve::new(
                "measured minus predicted",
                Mark::Thin,
                Colour::Main,
                history,
                |row| Some(row.innovation_rad_s?[axis]),
            ))
    };
    Figure::stacked("Rate innovation", [panel(0, "x"), panel(1, "y"), panel(2, "z")]).draw()
}

/// Each element of the inertia with its ±3 sigma and, if it is known, the truth, as SVG.
pub fn inertia(
    history: &[HistoryRow],
    truth_kg_m2: Option<&[f64; 6]>,
) -> Result<String, PlotError> {
    let panels = std::array::from_fn(|i| {
        let mut panel = Panel::new(format!("{}, kg m²", ELEMENT_NAMES[i]))
            .band("±3 sigma", history, |row| {
                let reach = BAND_SIGMAS * row.sigma_kg_m2[i];
                Some((row.inertia_kg_m2[i] - reach, row.inertia_kg_m2[i] + reach))
            })
            .curve(Curve::new("estimated", Mark::Line, Colour::Main, history, |row| {
                Some(row.inertia_kg_m2[i])
            }))
            .fit_after(SETTLING);
        if let Some(truth) = truth_kg_m2 {
            panel = panel.curve(Curve::new("true", Mark::Dashes, Colour::Truth, history, |_| {
                Some(truth[i])
            }));
        }
        panel
    });
    Figure::grid("Inertia; the scale fits the last three quarters of the time", panels).draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A filter that settles, 6,000 samples long.
    fn history() -> Vec<HistoryRow> {
        (0..6000)
            .map(|k| {
                let t = f64::from(k) * 0.1;
                let noise = (f64::from(k) * 12.9898).sin() * 2e-4;
                let sigma = 30.0 / (1.0 + t * t / 10.0);
                let rate = [t * 7e-5, t * 6e-5 + (t / 20.0).sin() * 0.01, -t * 1e-4];
                HistoryRow {
                    time_s: t,
                    measured_rate_rad_s: rate.map(|rate| rate + noise),
                    estimated_rate_rad_s: rate,
                    innovation_rad_s: (k > 0).then_some([noise, -noise, noise / 2.0]),
                    innovation_sigma_rad_s: (k > 0)
                        .then_some([1.8e-4 * (1.0 + 3.0 / (1.0 + t)); 3]),
                    nis: None,
                    inertia_kg_m2: [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016]
                        .map(|truth| truth + sigma * (t / 60.0).sin()),
                    sigma_kg_m2: [sigma; 6],
                    outcome: "updated",
                }
            })
            .collect()
    }

    const TRUTH: [f64; 6] = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];

    #[test]
    fn plots_name_what_they_show() {
        let history = history();
        let rates = rates(&history).unwrap();
        let innovations = innovations(&history).unwrap();
        let inertia = inertia(&history, Some(&TRUTH)).unwrap();
        for (svg, words) in [
            (&rates, ["Body rate", "measured", "estimated", "rate z, rad/s", "time, s"]),
            (
                &innovations,
                ["Rate innovation", "±3 sigma", "innovation x, rad/s", "time, s", "600"],
            ),
            (&inertia, ["jxx, kg m²", "jyz, kg m²", "true", "estimated", "time, s"]),
        ] {
            assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
            for word in words {
                assert!(svg.contains(word), "{word}");
            }
        }
    }

    #[test]
    fn long_history_makes_a_small_plot() {
        const LIMIT_BYTES: usize = 1_000_000;
        let history = history();
        assert!(rates(&history).unwrap().len() < LIMIT_BYTES);
        assert!(inertia(&history, None).unwrap().len() < LIMIT_BYTES);
    }

    #[test]
    fn short_constant_or_wild_history_is_drawn_all_the_same() {
        let mut rows = history();
        rows.truncate(1);
        inertia(&rows, None).unwrap();
        innovations(&rows).unwrap();
        rates(&[]).unwrap();
        rows[0].inertia_kg_m2 = [f64::NAN; 6];
        rows[0].measured_rate_rad_s = [f64::INFINITY, 1e300, -1e-300];
        inertia(&rows, Some(&[0.0; 6])).unwrap();
        rates(&rows).unwrap();
    }
}
