//! Random spacecraft and limits: a short design each, flown by the truth with an inertia of the prior.
//!
//! | quantity | distribution |
//! |---|---|
//! | inertia | of `random-spacecraft`, 1 to 500 kg |
//! | wheels | three orthogonal or four of a pyramid; a quarter of the spacecraft with a momentum bias |
//! | acceleration | log-uniform, 1e-4 to 0.03 rad/s², of the smallest moment |
//! | momentum | rates of 0.3 to 5 deg/s, log-uniform, of the smallest moment |
//! | duration, excursion | 10 to 60 s; 0.1 to 20 deg, log-uniform |
//! | prior | two sigma of 0 to 50 % of the moments, products a tenth |
//! | cone | half of the designs, 30 deg about a direction 35 deg from a random boresight |
//!
//! The true inertia is uniform within two sigma of the prior, and physical.

use std::fmt;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use host_sim::input::Scenario;
use host_sim::input::scenario::TorqueProfile;
use host_sim::manoeuvre::{
    Criterion, DesignError, Effort, KeepOut, Limits, Request, Treatment, design,
};
use host_sim::truth::Flight;
use host_sim::truth::Unknowns;
use host_sim::truth::bound::information::Information;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Short searches: limits do not depend on the quality of a design.
const EFFORT: Effort = Effort { starts: 1, rounds: 2, iterations: 6, samples: 1 };
/// Gyro samples per second, Hz.
const RATE_HZ: f64 = 10.0;
/// Speed of a wheel at its largest momentum, rad/s.
const SPEED_RAD_S: f64 = 600.0;

/// A design flown by the truth: use of each limit, 1 at the limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlownDesign {
    /// False if there is no manoeuvre within the limits.
    pub exists: bool,
    /// Torque of a wheel.
    pub torque: f64,
    /// Speed of a wheel.
    pub speed: f64,
    /// Rotation from the start.
    pub excursion: f64,
    /// Largest share of the cone's half angle over the angle from its axis; zero without a cone.
    pub cone: f64,
    /// Rotation left at the end over 0.1 deg.
    pub left: f64,
}

impl FlownDesign {
    /// Limits that are exceeded.
    pub fn missed(&self) -> Option<String> {
        let all = [
            ("torque", self.torque),
            ("speed", self.speed),
            ("excursion", self.excursion),
            ("cone", self.cone),
            ("return", self.left),
        ];
        let missed = all.iter().filter(|(_, used)| *used > 1.0);
        let text: Vec<String> = missed.map(|(name, used)| format!("{name} {used:.4}")).collect();
        (!text.is_empty()).then(|| text.join(", "))
    }
}

/// Largest use of each limit over many designs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Worst {
    /// Designs, and those without a manoeuvre.
    pub designs: u64,
    /// Spacecraft without a manoeuvre within their limits.
    pub none: u64,
    /// Designs that exceed a limit.
    pub missed: u64,
    worst: FlownDesign,
}

impl Worst {
    /// Adds a design.
    pub fn add(&mut self, flown: &FlownDesign) {
        self.designs += 1;
        self.none += u64::from(!flown.exists);
        self.missed += u64::from(flown.missed().is_some());
        let worst = &mut self.worst;
        worst.torque = worst.torque.max(flown.torque);
        worst.speed = worst.speed.max(flown.speed);
        worst.excursion = worst.excursion.max(flown.excursion);
        worst.cone = worst.cone.max(flown.cone);
        worst.left = worst.left.max(flown.left);
    }
}

impl fmt::Display for Worst {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FlownDesign { torque, speed, excursion, cone, left, .. } = self.worst;
        write!(
            out,
            "{} designs, {} without a manoeuvre, {} MISSED; largest use: torque {torque:.4}, speed {speed:.4}, \
             excursion {excursion:.4}, cone {cone:.4}, left at the end {:.4} deg",
            self.designs,
            self.none,
            self.missed,
            0.1 * left
        )
    }
}

/// Designs for the spacecraft of a seed and flies the result.
///
/// # Errors
/// A fault of this program, or a motion that cannot be integrated.
pub fn fly(seed: u64) -> Result<FlownDesign> {
    let mut random = Pcg64::seed_from_u64(seed);
    let (scenario, request) = problem(&mut random, seed)?;
    let found = match design(&scenario, &request, &AtomicBool::new(false), &|_| ()) {
        Ok(found) => found,
        Err(DesignError::Nothing) => return Ok(FlownDesign::default()),
        Err(error) => return Err(error).with_context(|| format!("seed {seed}")),
    };
    let mut flown = scenario.clone();
    flown.duration_s = request.duration_s;
    flown.spacecraft.inertia_kg_m2 = truth(&mut random, &scenario);
    let table = &found.best.table;
    let time_s: Vec<f64> = (0..table.torque_n_m.len())
        .map(|row| (row as f64 * table.step_s * 1e6).round() / 1e6)
        .collect();
    for (index, wheel) in flown.wheels.iter_mut().enumerate() {
        let value_n_m = table.torque_n_m.iter().map(|row| row[index]).collect();
        wheel.torque = TorqueProfile::Table { time_s: time_s.clone(), value_n_m };
    }
    // The motion alone: a bound without data.
    let bound = Information::new(Unknowns::of(&flown), 1.0).bound(1.0);
    let flight = Flight::with_bound(&flown, bound)?;
    let mut used = FlownDesign { exists: true, ..FlownDesign::default() };
    for (index, wheel) in scenario.wheels.iter().enumerate() {
        let limits = &wheel.wheel.limits;
        let torque = limits.max_torque_n_m.context("torque")?;
        let speed = limits.max_speed_rad_s.context("speed")?;
        let rows = table.torque_n_m.iter().map(|row| row[index].abs() / torque);
        used.torque = rows.fold(used.torque, f64::max);
        let speeds = flight.instants.iter().map(|i| i.wheel_speed_rad_s[index].abs() / speed);
        used.speed = speeds.fold(used.speed, f64::max);
    }
    for instant in &flight.instants {
        let turned = instant.attitude.angle_to(&scenario.spacecraft.attitude);
        used.excursion = used.excursion.max(turned / request.limits.excursion_rad);
        used.left = turned / request.limits.return_rad;
        for cone in &request.limits.keep_out {
            used.cone = used.cone.max(cone.half_angle_rad / cone.angle_rad(&instant.attitude));
        }
    }
    Ok(used)
}

fn problem(random: &mut Pcg64, seed: u64) -> Result<(Scenario, Request)> {
    let body = Scenario::load("random-spacecraft")?.of_seed(seed).spacecraft.inertia_kg_m2;
    let least = tensor(&body).symmetric_eigenvalues().min();
    let mut log_uniform =
        |least: f64, most: f64| least * (most / least).powf(random.random::<f64>());
    let torque_n_m = least * log_uniform(1e-4, 0.03);
    let momentum = least * log_uniform(0.3, 5.0).to_radians();
    let excursion_rad = log_uniform(0.1, 20.0).to_radians();
    let prior_error = 0.5 * random.random::<f64>();
    let mean = body[..3].iter().sum::<f64>() / 3.0;
    let sigma: Vec<f64> = (0..6)
        .map(|i| (0.5 * prior_error * if i < 3 { body[i] } else { 0.1 * mean }).max(1e-9 * mean))
        .collect();
    let mut text = format!(
        "name = 'random'\nduration_s = 1\n[spacecraft]\ninertia_kg_m2 = {body:?}\nattitude_deg = {:?}\n\
         [prior]\ninertia_kg_m2 = {body:?}\nsigma_kg_m2 = {sigma:?}\n\
         [gyro]\nrate_hz = {RATE_HZ}\nnoise_rad_s = 1e-4\n[disturbance]\ntorque = true\n",
        [0.0; 3].map(|_: f64| 360.0 * random.random::<f64>()),
    );
    text += &wheels(random, torque_n_m, momentum);
    let scenario = Scenario::from_toml("random", &text, Path::new(""))?;
    let keep_out = if random.random::<bool>() { vec![cone(random, &scenario)] } else { Vec::new() };
    let limits = Limits {
        excursion_rad,
        rate_rad_s: None,
        torque_share: 1.0,
        momentum_share: 1.0,
        return_rad: 0.1f64.to_radians(),
        keep_out,
    };
    let request = Request {
        duration_s: (10.0 + 50.0 * random.random::<f64>()).round(),
        limits,
        criterion: Criterion::A,
        treatment: Treatment::Considered,
        uses_prior: false,
        seed,
        effort: EFFORT,
    };
    Ok((scenario, request))
}

/// Wheel tables: three orthogonal wheels or four of a pyramid; in a quarter of the cases with a momentum bias.
fn wheels(random: &mut Pcg64, torque_n_m: f64, momentum_n_m_s: f64) -> String {
    let axes: &[[f64; 3]] = if random.random::<bool>() {
        &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    } else {
        &[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
    };
    let is_biased = random.random::<f64>() < 0.25;
    let wheel = |axis: &[f64; 3]| {
        let speed =
            if is_biased { 0.3 * SPEED_RAD_S * (random.random::<f64>() - 0.5) } else { 0.0 };
        format!(
            "[[wheel]]\naxis = {axis:?}\nspin_inertia_kg_m2 = {:?}\nmax_torque_n_m = {torque_n_m:?}\n\
             max_speed_rad_s = {SPEED_RAD_S:?}\nspeed_rad_s = {speed:?}\n",
            momentum_n_m_s / SPEED_RAD_S
        )
    };
    axes.iter().map(wheel).collect()
}

/// A cone of 30 deg whose axis is 35 deg from the boresight at the start.
fn cone(random: &mut Pcg64, scenario: &Scenario) -> KeepOut {
    let mut unit = || Vector3::from_fn(|_, _| random.random::<f64>() - 0.5).normalize();
    let (boresight, about) = (unit(), unit());
    let axis = nalgebra::Unit::new_normalize(boresight.cross(&about));
    let turned = Rotation3::from_axis_angle(&axis, 35f64.to_radians()) * boresight;
    let direction = scenario.spacecraft.attitude * turned;
    KeepOut { boresight, direction, half_angle_rad: 30f64.to_radians() }
}

/// An inertia within two sigma of the prior, of a rigid body.
fn truth(random: &mut Pcg64, scenario: &Scenario) -> [f64; 6] {
    let Some(prior) = &scenario.prior else { return scenario.spacecraft.inertia_kg_m2 };
    loop {
        let drawn: [f64; 6] = std::array::from_fn(|i| {
            prior.inertia_kg_m2[i]
                + 2.0 * prior.sigma_kg_m2[i] * (2.0 * random.random::<f64>() - 1.0)
        });
        let mut moments: Vec<f64> =
            tensor(&drawn).symmetric_eigenvalues().iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        if moments[0] > 0.0 && moments[2] <= moments[0] + moments[1] {
            return drawn;
        }
    }
}

fn tensor([xx, yy, zz, xy, xz, yz]: &[f64; 6]) -> Matrix3<f64> {
    Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
}
