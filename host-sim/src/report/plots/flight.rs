//! Plots of one flight over time: rates, innovations, inertia, accelerations, wheels, attitude.

use nalgebra::Vector3;

use super::decimate::Point;
use super::figure::Figure;
use super::panel::Panel;
use super::series::Series;
use super::style::{Colour, Mark};
use crate::input::ELEMENT_NAMES;
use crate::input::craft::Wheel;
use crate::report::history::HistoryRow;
use crate::truth::flight::Instant;

/// Part of the time at the start that the vertical scale of an estimate need not contain. The initial
/// errors exceed the later ones by orders of magnitude.
const SETTLING: f64 = 0.25;
/// The same for quantities that settle within seconds.
const BRIEF_SETTLING: f64 = 0.03;
/// Half the width of a band, sigmas: 99.7 % of a normal distribution.
const BAND_SIGMAS: f64 = 3.0;

const AXES: [&str; 3] = ["x", "y", "z"];
const TIME: &str = "time, s";

/// Panels for x, y and z, one above the other.
fn by_axis(title: &str, panel: impl Fn(usize, &str) -> Panel) -> Figure {
    let panels = (0..3).map(|axis| panel(axis, AXES[axis])).collect();
    Figure::stacked(title, TIME, panels)
}

/// A value over time. Rows without a value are skipped.
fn over_time<'a>(
    history: &'a [HistoryRow],
    value: impl Fn(&HistoryRow) -> Option<f64> + 'a,
) -> impl Iterator<Item = Point> + 'a {
    history.iter().filter_map(move |row| Some((row.time_s, value(row)?)))
}

/// ±3 sigma about a value over time. Rows without a value are skipped.
fn band_over_time<'a>(
    history: &'a [HistoryRow],
    middle_and_sigma: impl Fn(&HistoryRow) -> Option<(f64, f64)> + 'a,
) -> impl Iterator<Item = (f64, f64, f64)> + 'a {
    history.iter().filter_map(move |row| {
        let (middle, sigma) = middle_and_sigma(row)?;
        let reach = BAND_SIGMAS * sigma;
        Some((row.time_s, middle - reach, middle + reach))
    })
}

/// Measured and estimated body rate with ±3 sigma of the estimate, rad/s; one panel per axis.
pub fn rates(title: &str, history: &[HistoryRow]) -> Figure {
    by_axis(title, |axis, name| {
        let band = band_over_time(history, move |row| {
            Some((row.estimated_rate_rad_s[axis], row.rate_sigma_rad_s?[axis]))
        });
        let measured = over_time(history, move |row| Some(row.measured_rate_rad_s[axis]));
        let estimated = over_time(history, move |row| Some(row.estimated_rate_rad_s[axis]));
        Panel::new(format!("rate {name}, rad/s"))
            .with(Series::curve("measured", Mark::Wide, Colour::Light, measured))
            .with(Series::band("±3 sigma of the estimate", Colour::Main, band))
            .with(Series::curve("estimated", Mark::Thin, Colour::Main, estimated))
    })
}

/// Estimated minus true rate with ±3 sigma of the estimate, deg/s as in the papers.
pub fn rate_errors(title: &str, history: &[HistoryRow], truth: &[Instant]) -> Figure {
    by_axis(title, |axis, name| {
        let error = history.iter().zip(truth).map(|(row, instant)| {
            let error = row.estimated_rate_rad_s[axis] - instant.rate_rad_s[axis];
            (row.time_s, error.to_degrees())
        });
        let band = band_over_time(history, move |row| {
            Some((0.0, row.rate_sigma_rad_s?[axis].to_degrees()))
        });
        Panel::new(format!("rate error {name}, deg/s"))
            .with(Series::band("±3 sigma of the estimate", Colour::Main, band))
            .with(Series::curve("estimated minus true", Mark::Thin, Colour::Main, error))
            .fit_after(BRIEF_SETTLING)
    })
}

/// Variance of the estimated rate by the filter's covariance, (deg/s)².
pub fn rate_variances(title: &str, history: &[HistoryRow]) -> Figure {
    by_axis(title, |axis, name| {
        let variance =
            over_time(history, move |row| Some(row.rate_sigma_rad_s?[axis].to_degrees().powi(2)));
        Panel::new(format!("variance {name}, (deg/s)²"))
            .with(Series::curve("by the filter's covariance", Mark::Line, Colour::Main, variance))
            .logarithmic()
    })
}

/// Innovation, measured minus predicted rate, with ±3 sigma of its predicted variance, rad/s.
pub fn innovations(title: &str, history: &[HistoryRow]) -> Figure {
    by_axis(title, |axis, name| {
        let band =
            band_over_time(history, move |row| Some((0.0, row.innovation_sigma_rad_s?[axis])));
        let innovation = over_time(history, move |row| Some(row.innovation_rad_s?[axis]));
        Panel::new(format!("innovation {name}, rad/s"))
            .with(Series::band("±3 sigma expected", Colour::Main, band))
            .with(Series::curve("measured minus predicted", Mark::Thin, Colour::Main, innovation))
    })
}

/// Elements of the inertia with ±3 sigma, and the truth if it is known, kg m².
pub fn inertia(
    title: &str,
    history: &[HistoryRow],
    truth: Option<&[Instant]>,
    elements: &[usize],
) -> Figure {
    let panel = |&i: &usize| {
        let band =
            band_over_time(history, move |row| Some((row.inertia_kg_m2[i], row.sigma_kg_m2[i])));
        let estimate = over_time(history, move |row| Some(row.inertia_kg_m2[i]));
        let mut panel = Panel::new(format!("{}, kg m²", ELEMENT_NAMES[i]))
            .with(Series::band("±3 sigma", Colour::Main, band))
            .with(Series::curve("estimated", Mark::Line, Colour::Main, estimate))
            .fit_after(SETTLING);
        if let Some(truth) = truth {
            let truth =
                truth.iter().map(move |instant| (seconds(instant), instant.inertia_kg_m2[i]));
            panel = panel.with(Series::curve("true", Mark::Dashes, Colour::Truth, truth));
        }
        panel
    };
    Figure::grid(title, TIME, 3, elements.iter().map(panel).collect())
}

/// Sigma of each element, kg m²: it falls when the motion shows the element.
pub fn sigmas(title: &str, history: &[HistoryRow]) -> Figure {
    let panel = ALL_ELEMENTS.iter().fold(Panel::new("one sigma, kg m²"), |panel, &i| {
        let mark = if i < 3 { Mark::Line } else { Mark::Dashes };
        let sigma = over_time(history, move |row| Some(row.sigma_kg_m2[i]));
        panel.with(Series::curve(ELEMENT_NAMES[i], mark, Colour::ALL[i], sigma))
    });
    Figure::stacked(title, TIME, vec![panel.logarithmic()])
}

/// Error of each element with ±3 sigma, per cent of the true element.
pub fn inertia_errors(
    title: &str,
    history: &[HistoryRow],
    truth_kg_m2: &[f64; 6],
    elements: &[usize],
) -> Figure {
    let panel = |&i: &usize| {
        let truth = truth_kg_m2[i];
        let percent = move |row: &HistoryRow| 100.0 * (row.inertia_kg_m2[i] - truth) / truth;
        let band = band_over_time(history, move |row| {
            Some((percent(row), 100.0 * row.sigma_kg_m2[i] / truth.abs()))
        });
        let error = over_time(history, move |row| Some(percent(row)));
        let zero = over_time(history, |_| Some(0.0));
        Panel::new(format!("{} error, %", ELEMENT_NAMES[i]))
            .with(Series::band("±3 sigma", Colour::Main, band))
            .with(Series::curve("estimated minus true", Mark::Line, Colour::Main, error))
            .with(Series::curve("none", Mark::Dashes, Colour::Truth, zero))
            .fit_after(SETTLING)
    };
    Figure::grid(title, TIME, 3, elements.iter().map(panel).collect())
}

/// Angular acceleration estimated from the rates, and the truth if it is known, deg/s².
pub fn accelerations(title: &str, history: &[HistoryRow], truth: Option<&[Instant]>) -> Figure {
    by_axis(title, |axis, name| {
        let estimated = history.iter().filter_map(move |row| {
            let acceleration = row.acceleration?;
            Some((row.time_s - acceleration.delay_s, acceleration.rad_s2[axis].to_degrees()))
        });
        let panel = Panel::new(format!("acceleration {name}, deg/s²"))
            .with(Series::curve("estimated", Mark::Thin, Colour::Main, estimated))
            .fit_after(BRIEF_SETTLING);
        let Some(truth) = truth else { return panel };
        let truth = true_accelerations(truth).map(move |(t, a)| (t, a[axis].to_degrees()));
        panel.with(Series::curve("true", Mark::Line, Colour::Truth, truth))
    })
}

/// Estimated minus true angular acceleration, deg/s².
pub fn acceleration_errors(title: &str, history: &[HistoryRow], truth: &[Instant]) -> Figure {
    let truth: Vec<(f64, [f64; 3])> = true_accelerations(truth).collect();
    by_axis(title, |axis, name| {
        let error = history.iter().filter_map(|row| {
            let acceleration = row.acceleration?;
            let time_s = row.time_s - acceleration.delay_s;
            let error = acceleration.rad_s2[axis] - interpolated(&truth, time_s)?[axis];
            Some((time_s, error.to_degrees()))
        });
        Panel::new(format!("error {name}, deg/s²"))
            .with(Series::curve("estimated minus true", Mark::Thin, Colour::Main, error))
            .fit_after(BRIEF_SETTLING)
    })
}

/// Linear interpolation of a vector over time. None outside the points.
pub fn interpolated(points: &[(f64, [f64; 3])], time_s: f64) -> Option<[f64; 3]> {
    let after = points.partition_point(|point| point.0 < time_s);
    let (from, to) = (points.get(after.checked_sub(1)?)?, points.get(after)?);
    let part = (time_s - from.0) / (to.0 - from.0);
    Some(std::array::from_fn(|i| from.1[i] + part * (to.1[i] - from.1[i])))
}

/// Time halfway between two samples, s, and derivative of the true rate there, rad/s².
///
/// `ω̇(t + h/2) = (ω(t + h) − ω(t)) / h + O(h²)`.
pub fn true_accelerations(truth: &[Instant]) -> impl Iterator<Item = (f64, [f64; 3])> {
    truth.windows(2).map(|pair| {
        let [from, to] = [pair[0].time_us, pair[1].time_us].map(|us| us as f64 * 1e-6);
        let change = pair[1].rate_rad_s - pair[0].rate_rad_s;
        (0.5 * (from + to), (change / (to - from)).into())
    })
}

/// Wheel speeds in one panel, rad/s. None without wheels.
pub fn wheel_speeds(title: &str, flight: &[Instant]) -> Option<Figure> {
    let wheels = flight.first()?.wheel_speed_rad_s.len();
    let speed = |wheel: usize| {
        flight.iter().map(move |instant| (seconds(instant), instant.wheel_speed_rad_s[wheel]))
    };
    let panel = (0..wheels).fold(Panel::new("wheel speed, rad/s"), |panel, wheel| {
        let name = format!("wheel {}", wheel + 1);
        let colour = Colour::ALL[wheel % Colour::ALL.len()];
        panel.with(Series::curve(&name, Mark::Line, colour, speed(wheel)))
    });
    (wheels > 0).then(|| Figure::stacked(title, TIME, vec![panel]))
}

/// Body rate, rad/s, and torque of the wheels on the body, N m, in one panel each.
pub fn rates_and_control(title: &str, flight: &[Instant], wheels: &[Wheel]) -> Figure {
    let rates = by_colour("rate, rad/s", |axis| {
        flight.iter().map(|instant| (seconds(instant), instant.rate_rad_s[axis])).collect()
    });
    Figure::stacked(title, TIME, vec![rates, control(flight, wheels)])
}

/// Torque of the wheels on the body in one panel, N m. None without wheels.
pub fn control_torque(title: &str, flight: &[Instant], wheels: &[Wheel]) -> Option<Figure> {
    (!wheels.is_empty()).then(|| Figure::stacked(title, TIME, vec![control(flight, wheels)]))
}

fn control(flight: &[Instant], wheels: &[Wheel]) -> Panel {
    let torque: Vec<(f64, Vector3<f64>)> = control_torque_n_m(flight, wheels).collect();
    by_colour("torque of the wheels, N m", |axis| {
        torque.iter().map(|(time_s, torque)| (*time_s, torque[axis])).collect()
    })
}

/// Time halfway between two samples, s, and torque of the wheels on the body, N m.
///
/// `τ = −d/dt Σ a Iₛ (Ω + a · ω)`, with the spin axis `a`, the spin inertia `Iₛ`, kg m², and the speed
/// `Ω` relative to the body, rad/s, of each wheel, and the body rate `ω`, rad/s.
fn control_torque_n_m<'a>(
    flight: &'a [Instant],
    wheels: &'a [Wheel],
) -> impl Iterator<Item = (f64, Vector3<f64>)> + 'a {
    let momentum = |instant: &Instant| -> Vector3<f64> {
        let of_wheel = |(wheel, speed): (&Wheel, &f64)| {
            wheel.axis * (wheel.spin_inertia_kg_m2 * (speed + wheel.axis.dot(&instant.rate_rad_s)))
        };
        wheels.iter().zip(&instant.wheel_speed_rad_s).map(of_wheel).sum()
    };
    flight.windows(2).map(move |pair| {
        let (from, to) = (seconds(&pair[0]), seconds(&pair[1]));
        (0.5 * (from + to), (momentum(&pair[0]) - momentum(&pair[1])) / (to - from))
    })
}

/// One panel with the three axes in different colours.
fn by_colour(y_label: &str, points: impl Fn(usize) -> Vec<Point>) -> Panel {
    const COLOURS: [Colour; 3] = [Colour::Main, Colour::Other, Colour::Third];
    // Different widths keep coinciding curves visible.
    const MARKS: [Mark; 3] = [Mark::Wide, Mark::Line, Mark::Dashes];
    (0..3).fold(Panel::new(y_label), |panel, axis| {
        panel.with(Series::curve(AXES[axis], MARKS[axis], COLOURS[axis], points(axis)))
    })
}

/// True attitude as roll, pitch and yaw, deg. Rotation order: yaw, pitch, roll.
pub fn euler_angles(title: &str, flight: &[Instant]) -> Figure {
    const NAMES: [&str; 3] = ["roll", "pitch", "yaw"];
    by_axis(title, |axis, _| {
        let angle = flight.iter().map(|instant| {
            let (roll, pitch, yaw) = instant.attitude.euler_angles();
            (seconds(instant), [roll, pitch, yaw][axis].to_degrees())
        });
        Panel::new(format!("{}, deg", NAMES[axis])).with(Series::curve(
            "true attitude",
            Mark::Line,
            Colour::Main,
            angle,
        ))
    })
}

/// All elements of the inertia, for [`inertia`].
pub const ALL_ELEMENTS: [usize; 6] = [0, 1, 2, 3, 4, 5];

fn seconds(instant: &Instant) -> f64 {
    instant.time_us as f64 * 1e-6
}
