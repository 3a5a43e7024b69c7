//! Scenarios of the field campaigns, as text for the simulator's reader.

use std::path::Path;

use anyhow::Result;
use host_sim::input::Scenario;

use super::motion::Source;

/// The 6U CubeSat of `cubesat-pyramid`: true elements, kg m².
const CUBESAT: &str = "[0.058, 0.104, 0.118, -0.0021, 0.0016, 0.0028]";

/// Axis, speed, frequencies and phases of each wheel of `cubesat-pyramid`.
const PYRAMID: [(&str, f64, &str, &str); 4] = [
    ("[1, 1, 1]", 200.0, "[0.05, 0.17]", "[0.0, 1.0]"),
    ("[-1, 1, 1]", -200.0, "[0.07, 0.13]", "[0.4, 2.2]"),
    ("[-1, -1, 1]", 200.0, "[0.06, 0.19]", "[1.0, 0.3]"),
    ("[1, -1, 1]", -200.0, "[0.04, 0.23]", "[1.6, 1.7]"),
];

/// A flight of the CubeSat of `cubesat-pyramid`: rest, motion of its wheels, and coasting.
#[derive(Clone, Copy, Debug)]
pub struct Pyramid<'a> {
    /// Rest before the motion, s.
    pub rest_s: f64,
    /// Motion, s.
    pub motion_s: f64,
    /// Time after the motion, wheels undriven, s.
    pub after_s: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Gyro noise, rad/s.
    pub noise_rad_s: f64,
    /// Further tables of the scenario.
    pub tables: &'a str,
}

impl Pyramid<'_> {
    /// One minute of motion at 10 Hz, from the first sample to the last.
    pub const PLAIN: Self = Self {
        rest_s: 0.0,
        motion_s: 60.0,
        after_s: 0.0,
        rate_hz: 10.0,
        noise_rad_s: 1e-4,
        tables: "",
    };

    /// The scenario.
    ///
    /// # Errors
    /// A value outside the range of its key.
    pub fn scenario(&self) -> Result<Scenario> {
        let Self { rest_s, motion_s, after_s, rate_hz, noise_rad_s, tables } = *self;
        let end_s = rest_s + motion_s;
        let mut wheels = String::new();
        for (axis, speed, frequency, phase) in PYRAMID {
            wheels += &format!(
                "[[wheel]]\naxis = {axis}\nspin_inertia_kg_m2 = 2.1e-5\nspeed_rad_s = {speed:?}\n\
                 torque = {{ kind = \"multisine\", amplitude_n_m = [9e-4, 6e-4], \
                 frequency_hz = {frequency}, phase_rad = {phase}, \
                 during_s = [[{rest_s:?}, {end_s:?}]] }}\n"
            );
        }
        let duration_s = end_s + after_s;
        read(&format!(
            "name = \"pyramid\"\nduration_s = {duration_s:?}\n\
             [spacecraft]\ninertia_kg_m2 = {CUBESAT}\n{wheels}\
             [gyro]\nrate_hz = {rate_hz:?}\nnoise_rad_s = {noise_rad_s:?}\n{tables}"
        ))
    }
}

/// A scenario from its text.
///
/// # Errors
/// An unknown key, or a value outside the range of its key.
pub fn read(text: &str) -> Result<Scenario> {
    Ok(Scenario::from_toml("scenario of the field campaigns", text, Path::new(""))?)
}

/// A built-in scenario.
///
/// # Errors
/// There is none of this name.
pub fn built_in(name: &str) -> Result<Scenario> {
    Ok(Scenario::load(name)?)
}

/// A scenario as the source of a campaign.
pub fn source(scenario: Scenario) -> Source {
    Source::Scenario(Box::new(scenario))
}

/// A free body of these elements, initial rate, gyro and duration, without wheels.
///
/// # Errors
/// A value outside the range of its key.
pub fn free_body(
    inertia_kg_m2: [f64; 6],
    rate_rad_s: [f64; 3],
    rate_hz: f64,
    noise_rad_s: f64,
    duration_s: f64,
) -> Result<Scenario> {
    read(&format!(
        "name = \"free body\"\nduration_s = {duration_s:?}\n\
         [spacecraft]\ninertia_kg_m2 = {inertia_kg_m2:?}\nrate_rad_s = {rate_rad_s:?}\n\
         [gyro]\nrate_hz = {rate_hz:?}\nnoise_rad_s = {noise_rad_s:?}\n"
    ))
}

/// A thrown object with one wheel along z that spins up from 170 to 1,300 rad/s within 0.6 s, sampled
/// at 500 Hz: the kind of throw of \[Blaha2025\], with white noise.
///
/// # Errors
/// None: the text is constant.
pub fn throw() -> Result<Scenario> {
    read(
        "name = \"throw\"\nduration_s = 0.6\n\
         [spacecraft]\ninertia_kg_m2 = [3.1e-4, 2.6e-4, 4.4e-4, 1.2e-5, -0.8e-5, 1.5e-5]\n\
         rate_rad_s = [4.0, -6.5, 2.5]\n\
         [[wheel]]\naxis = [0, 0, 1]\nspin_inertia_kg_m2 = 1.691e-6\nspeed_rad_s = 170.0\n\
         torque = { kind = \"constant\", value_n_m = 3.2e-3 }\n\
         [gyro]\nrate_hz = 500.0\nnoise_rad_s = 5e-3\n",
    )
}

/// A racquet-like body that tumbles about its intermediate axis, sampled at 100 Hz.
///
/// # Errors
/// None: the numbers are constant.
pub fn racquet() -> Result<Scenario> {
    let inertia_kg_m2 = [0.0188, 0.0015, 0.0200, 0.0001, -0.0002, 0.0003];
    free_body(inertia_kg_m2, [6.0, 1.5, 0.8], 100.0, 3e-3, 3.0)
}

/// The brick of check-case 2 of the NASA Engineering and Safety Center in its tumble without torque
/// from 10, 20 and 30 deg/s, 30 s at 10 Hz, with this gyro noise.
///
/// # Errors
/// A value outside the range of its key.
pub fn brick(noise_rad_s: f64) -> Result<Scenario> {
    // 0.001894220, 0.006211019, 0.007194665 slug ft².
    let inertia_kg_m2 = [0.0025682, 0.0084210, 0.0097547, 0.0, 0.0, 0.0];
    let rate_rad_s = [10.0f64, 20.0, 30.0].map(f64::to_radians);
    free_body(inertia_kg_m2, rate_rad_s, 10.0, noise_rad_s, 30.0)
}

/// The CubeSat in a slow tumble with wheels that are undriven and turn freely from rest.
///
/// # Errors
/// A value outside the range of its key.
pub fn free_wheels(
    wheels: usize,
    rate_hz: f64,
    noise_rad_s: f64,
    duration_s: f64,
) -> Result<Scenario> {
    let mut tables = String::new();
    for (axis, ..) in PYRAMID.iter().take(wheels) {
        tables += &format!("[[wheel]]\naxis = {axis}\nspin_inertia_kg_m2 = 2.1e-5\n");
    }
    read(&format!(
        "name = \"free wheels\"\nduration_s = {duration_s:?}\n\
         [spacecraft]\ninertia_kg_m2 = {CUBESAT}\nrate_rad_s = [0.05, -0.04, 0.06]\n{tables}\
         [gyro]\nrate_hz = {rate_hz:?}\nnoise_rad_s = {noise_rad_s:?}\n"
    ))
}
