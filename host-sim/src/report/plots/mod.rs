//! Plots as data: the page of a report draws them, and a CSV file beside it has their points.
//!
//! ```text
//! flight   plots of one flight: rates, errors, accelerations, inertia, sigma, wheels, attitude
//! figure   title, panels ◄── panel  axes ◄── series  curve, band, bars, dots
//! style    colours and lines by role         decimate   points that a page draws
//! histogram  bars of a distribution
//! ```

mod decimate;
mod figure;
pub mod flight;
pub mod histogram;
mod panel;
mod series;
mod style;

pub use figure::Figure;
pub use panel::Panel;
pub use series::{Dot, Series};
pub use style::{Colour, Mark};

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::super::history::HistoryRow;
    use super::Figure;
    use super::flight::{ALL_ELEMENTS, inertia, innovations, rates};
    use crate::truth::Instant;

    /// A filter that converges, 6,000 samples.
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
                    rate_sigma_rad_s: (k > 0).then_some([1e-4; 3]),
                    acceleration: None,
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

    /// A constant truth, at the first and the last sample.
    fn truth(inertia_kg_m2: [f64; 6]) -> [Instant; 2] {
        [0, 599_900_000].map(|time_us| Instant {
            time_us,
            rate_rad_s: Vector3::zeros(),
            inertia_kg_m2,
            attitude: UnitQuaternion::identity(),
            wheel_speed_rad_s: Vec::new(),
            torque_n_m: Vector3::zeros(),
        })
    }

    #[test]
    fn plots_have_labels_and_names() {
        let history = history();
        let rates = rates("Body rate", &history);
        let innovations = innovations("Rate innovation", &history);
        let truth = truth([14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016]);
        let inertia = inertia("Inertia", &history, Some(&truth), &ALL_ELEMENTS);
        for (figure, words) in [
            (&rates, ["measured", "estimated", "rate z, rad/s", "time, s"]),
            (
                &innovations,
                ["±3 sigma", "measured minus predicted", "innovation x, rad/s", "time, s"],
            ),
            (&inertia, ["jxx, kg m²", "jyz, kg m²", "true", "estimated"]),
        ] {
            let json = serde_json::to_string(figure).unwrap();
            for word in words {
                assert!(json.contains(word), "{word}");
            }
        }
    }

    #[test]
    fn plot_of_a_long_history_is_limited_in_size() {
        /// Largest size of a plot after decimation.
        const LIMIT_BYTES: usize = 700_000;
        let history = history();
        let size = |figure: &Figure| serde_json::to_string(figure).unwrap().len();
        assert!(size(&rates("Body rate", &history)) < LIMIT_BYTES);
        assert!(size(&inertia("Inertia", &history, None, &ALL_ELEMENTS)) < LIMIT_BYTES);
    }

    #[test]
    fn short_constant_or_non_finite_history_has_plots() {
        let mut rows = history();
        rows.truncate(1);
        assert!(!inertia("Inertia", &rows, None, &ALL_ELEMENTS).is_empty());
        assert!(innovations("", &rows).is_empty());
        assert!(rates("", &[]).is_empty());
        rows[0].inertia_kg_m2 = [f64::NAN; 6];
        rows[0].measured_rate_rad_s = [f64::INFINITY, 1e300, -1e-300];
        let figure = inertia("Inertia", &rows, Some(&truth([0.0; 6])), &ALL_ELEMENTS);
        serde_json::to_string(&figure).unwrap();
        serde_json::to_string(&rates("", &rows)).unwrap();
    }
}
