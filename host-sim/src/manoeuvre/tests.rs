//! A design flown by the truth.

use std::sync::atomic::{AtomicBool, Ordering};

use flight_input::craft::Thruster;
use flight_input::inertia::tensor;
use nalgebra::Vector3;

use super::problem::Problem;
use super::*;
use crate::input::Scenario;
use crate::input::scenario::SimulatedThruster;
use crate::truth::{Flight, Instant};

/// A satellite with a pyramid of wheels, its prior, and a short search.
fn request(excursion_deg: f64) -> Request {
    Request {
        duration_s: 30.0,
        limits: Limits {
            excursion_rad: excursion_deg.to_radians(),
            rate_rad_s: Some(0.02),
            torque_share: 1.0,
            momentum_share: 0.5,
            return_rad: 0.1f64.to_radians(),
            keep_out: vec![KeepOut {
                boresight: Vector3::x(),
                direction: Vector3::new(1.0, 0.0, 1.02).normalize(),
                half_angle_rad: 45f64.to_radians(),
            }],
        },
        criterion: Criterion::A,
        treatment: Treatment::Considered,
        uses_prior: true,
        seed: 3,
        effort: Effort { starts: 2, rounds: 3, iterations: 15, samples: 3 },
    }
}

const SATELLITE: &str = r#"name = "satellite"
duration_s = 30
[spacecraft]
inertia_kg_m2 = [0.30, 0.27, 0.18, 0.01, -0.01, 0.005]
[prior]
inertia_kg_m2 = [0.26, 0.26, 0.16, 0, 0, 0]
sigma_kg_m2 = [0.03, 0.03, 0.02, 0.01, 0.01, 0.01]
[gyro]
rate_hz = 10
noise_rad_s = 1e-4
scale_sigma = 0.002
[disturbance]
torque = true
"#;

fn satellite(speed_rad_s: f64) -> Scenario {
    let text = satellite_text(speed_rad_s);
    Scenario::from_toml("s.toml", &text, std::path::Path::new("")).unwrap()
}

fn satellite_text(speed_rad_s: f64) -> String {
    let axes = ["[1, 1, 1]", "[1, -1, -1]", "[-1, 1, -1]", "[-1, -1, 1]"];
    let wheel = |(index, axis): (usize, &&str)| {
        let speed = if index == 0 { speed_rad_s } else { 0.0 };
        format!(
            "[[wheel]]\naxis = {axis}\nspin_inertia_kg_m2 = 2e-5\nmax_torque_n_m = 2e-3\n\
             max_speed_rad_s = 600\nspeed_rad_s = {speed}\n"
        )
    };
    let wheels: String = axes.iter().enumerate().map(wheel).collect();
    format!("{SATELLITE}{wheels}")
}

fn run(scenario: &Scenario, request: &Request) -> Design {
    design(scenario, request, &AtomicBool::new(false), &|_| ()).unwrap()
}

/// The scenario that flies a design, read from its files.
fn flown_scenario(scenario: &Scenario, design: &Design) -> Scenario {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in flown(scenario, &design.best.table) {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    Scenario::load(folder.path().join("scenario.toml").to_str().unwrap()).unwrap()
}

fn excursion_rad(instant: &Instant, scenario: &Scenario) -> f64 {
    instant.attitude.angle_to(&scenario.spacecraft.attitude)
}

#[test]
fn truth_keeps_every_limit_throughout_the_prior_and_returns() {
    for speed_rad_s in [0.0, 40.0] {
        let (scenario, request) = (satellite(speed_rad_s), request(6.0));
        let design = run(&scenario, &request);
        let mut flown = flown_scenario(&scenario, &design);
        let limits = &request.limits;
        let problem = Problem::new(&scenario, &request).unwrap();
        let mut widest = 0.0f64;
        for inertia_kg_m2 in problem.samples(12, 77).unwrap() {
            flown.spacecraft.inertia_kg_m2 = inertia_kg_m2;
            let flight = Flight::simulate(&flown).unwrap();
            for instant in &flight.instants {
                let excursion = excursion_rad(instant, &flown);
                widest = widest.max(excursion / limits.excursion_rad);
                assert!(instant.rate_rad_s.norm() <= limits.rate_rad_s.unwrap());
                assert!(instant.wheel_speed_rad_s.iter().all(|speed| speed.abs() <= 300.0));
                let cone = &limits.keep_out[0];
                assert!(cone.angle_rad(&instant.attitude) >= cone.half_angle_rad);
            }
            let end = flight.instants.last().unwrap();
            assert!(excursion_rad(end, &flown) <= limits.return_rad, "{speed_rad_s}");
            assert!(tensor(&inertia_kg_m2).determinant() > 0.0);
        }
        let torques = design.best.table.torque_n_m.concat();
        assert!(torques.iter().all(|torque| torque.abs() <= 2e-3));
        assert!(widest <= 1.0, "{widest}");
    }
}

/// The satellite with pairs of thrusters beside its wheels or in their place.
fn with_thrusters(has_wheels: bool) -> Scenario {
    let mut text = satellite_text(0.0);
    for torque in [[0.004, 0.0, 0.0], [0.0, 0.004, 0.0], [0.0, 0.001, 0.003]] {
        for sign in [1.0, -1.0] {
            let torque = torque.map(|x: f64| sign * x);
            text += &format!("[[thruster]]\ntorque_n_m = {torque:?}\nmin_pulse_s = 0.2\n");
        }
    }
    text += "[torque]\nkind = 'constant'\nvalue_n_m = [0, 0, 0]\nscale_sigma = 0.03\n";
    let mut scenario = Scenario::from_toml("s.toml", &text, std::path::Path::new("")).unwrap();
    if !has_wheels {
        scenario.wheels.clear();
    }
    scenario.hardware.common_spin_inertia_sigma = if has_wheels { 0.03 } else { 0.0 };
    scenario
}

#[test]
fn truth_flies_the_pulses_within_the_limits_and_with_the_sigma_of_the_report() {
    for has_wheels in [false, true] {
        let (scenario, mut request) = (with_thrusters(has_wheels), request(6.0));
        request.uses_prior = false;
        let design = run(&scenario, &request);
        let limits = &request.limits;
        let mut flown = flown_scenario(&scenario, &design);
        let pulses: Vec<&[f64; 2]> =
            flown.torque.thrusters.iter().flat_map(|of| &of.on_s).collect();
        let is_whole = |share: f64| (share - share.round()).abs() < 1e-4 && share > 0.5;
        assert!(pulses.len() > 8 && pulses.iter().all(|[on, off]| is_whole((off - on) / 0.2)));
        let problem = Problem::new(&scenario, &request).unwrap();
        for inertia_kg_m2 in problem.samples(8, 77).unwrap() {
            flown.spacecraft.inertia_kg_m2 = inertia_kg_m2;
            let flight = Flight::simulate(&flown).unwrap();
            for instant in &flight.instants {
                assert!(excursion_rad(instant, &flown) <= limits.excursion_rad);
                assert!(instant.rate_rad_s.norm() <= limits.rate_rad_s.unwrap());
                assert!(instant.wheel_speed_rad_s.iter().all(|speed| speed.abs() <= 300.0));
            }
            let end = flight.instants.last().unwrap();
            assert!(excursion_rad(end, &flown) <= limits.return_rad);
            assert!(end.rate_rad_s.norm() <= 1.01 * design.best.end_rate_rad_s);
        }
        let accuracy = accuracy(&scenario, &request, &design.best).unwrap();
        flown.spacecraft.inertia_kg_m2 = accuracy.inertia_kg_m2;
        let bound = Flight::simulate(&flown).unwrap().bound;
        let considered = bound.hardware.unwrap().considered_kg_m2;
        for i in 0..6 {
            let [noise, all] = [bound.sigma_kg_m2[i].unwrap(), considered[i].unwrap()];
            assert!((accuracy.random_kg_m2[i] / noise - 1.0).abs() < 0.01, "{i} {has_wheels}");
            assert!((accuracy.after_kg_m2[i] / all - 1.0).abs() < 0.01, "{i} {has_wheels}");
        }
        // The scale: that of the thrusters alone, and of thrusters and wheels together.
        let scale = accuracy.after_kg_m2[0] / accuracy.inertia_kg_m2[0];
        let least = if has_wheels { 0.03 / 2f64.sqrt() } else { 0.03 };
        assert!(scale > 0.99 * least && scale < 1.5 * 0.03, "{scale}");
    }
}

/// Dither of the craft file of the documentation: with attitude control against one sigma of the disturbance torque
/// the body stays within 0.05 deg.
#[test]
fn dither_stays_within_its_excursion_beside_attitude_control() {
    let craft = concat!(env!("CARGO_MANIFEST_DIR"), "/templates/craft-50kg.toml");
    let scenario = subject(craft, 10.0).unwrap();
    let mut request = Request {
        duration_s: 180.0,
        effort: Effort { starts: 1, rounds: 2, iterations: 8, samples: 1 },
        ..request(0.04)
    };
    request.limits.keep_out.clear();
    let design = run(&scenario, &request);
    let folder = tempfile::tempdir().unwrap();
    for (name, mut text) in flown(&scenario, &design.best.table) {
        if name == "scenario.toml" {
            text += "\n[control]\nnatural_frequency_rad_s = 0.05\ndamping_ratio = 0.7\n";
        }
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut dither = Scenario::load(folder.path().join("scenario.toml").to_str().unwrap()).unwrap();
    dither.disturbance_torque_n_m = Vector3::repeat(1e-6);
    let flight = Flight::simulate(&dither).unwrap();
    let widest = flight.instants.iter().map(|at| excursion_rad(at, &dither)).fold(0.0, f64::max);
    assert!(widest < 0.05f64.to_radians(), "{}", widest.to_degrees());
    assert!(widest > 0.03f64.to_radians(), "{}", widest.to_degrees());
}

#[test]
fn sigma_of_the_report_is_the_bound_of_the_flown_scenario() {
    let (mut scenario, mut request) = (satellite(0.0), request(6.0));
    request.uses_prior = false;
    let design = run(&scenario, &request);
    let accuracy = accuracy(&scenario, &request, &design.best).unwrap();
    scenario.spacecraft.inertia_kg_m2 = accuracy.inertia_kg_m2;
    let bound = Flight::simulate(&flown_scenario(&scenario, &design)).unwrap().bound;
    let considered = bound.hardware.unwrap().considered_kg_m2;
    for i in 0..6 {
        let [noise, all] = [bound.sigma_kg_m2[i].unwrap(), considered[i].unwrap()];
        assert!((accuracy.random_kg_m2[i] / noise - 1.0).abs() < 1e-3);
        assert!((accuracy.after_kg_m2[i] / all - 1.0).abs() < 1e-3);
    }
    assert!(design.gain() > 1.0, "{}", design.gain());
}

#[test]
fn table_is_the_same_on_any_number_of_threads_and_of_its_seed() {
    let (scenario, request) = (satellite(0.0), request(3.0));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&scenario, &request).best.table)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn stop_gives_the_best_so_far() {
    let (scenario, request) = (satellite(0.0), request(3.0));
    let stop = AtomicBool::new(false);
    let stopped = design(&scenario, &request, &stop, &|progress| {
        stop.store(progress.done >= 1, Ordering::Relaxed);
    });
    let stopped = stopped.unwrap();
    assert!(stopped.starts[0] < stopped.starts[1]);
    assert!(stopped.best.log_size.is_finite());
}

#[test]
fn craft_file_and_scenario_give_the_same_design() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("craft.toml");
    let scenario = satellite(0.0);
    std::fs::write(&path, scenario.craft().to_toml()).unwrap();
    let craft = subject(path.to_str().unwrap(), 10.0).unwrap();
    assert_eq!(craft.hardware, scenario.hardware);
    let request = request(3.0);
    assert_eq!(run(&craft, &request).best.table, run(&scenario, &request).best.table);
}

#[test]
fn each_missing_or_contradictory_input_is_named() {
    let message = |change: &dyn Fn(&mut Scenario, &mut Request)| {
        let (mut scenario, mut request) = (satellite(0.0), request(3.0));
        change(&mut scenario, &mut request);
        let stop = AtomicBool::new(false);
        design(&scenario, &request, &stop, &|_| ()).unwrap_err().to_string()
    };
    let expect = |found: String, part: &str| assert!(found.contains(part), "{found}");
    expect(message(&|scenario, _| scenario.wheels.clear()), "no [[wheel]] and no [[thruster]]");
    let thruster = |x: f64, min_pulse_s: f64| SimulatedThruster {
        thruster: Thruster { torque_n_m: Vector3::new(x, 0.0, 0.0), min_pulse_s },
        on_s: Vec::new(),
    };
    expect(
        message(&|scenario, _| {
            scenario.torque.thrusters =
                vec![thruster(0.01, 0.1), thruster(-0.01, 0.1), thruster(0.02, 0.1)];
        }),
        "thruster[3] has the torque [0.02, 0.0, 0.0] N m, and no other thruster has its opposite",
    );
    expect(
        message(&|scenario, _| {
            scenario.torque.thrusters = vec![thruster(0.01, 0.1), thruster(-0.01, 3.0)];
        }),
        "thruster[1]: 10 pulses of `min_pulse_s` fit in 30 s; a design takes at least 16",
    );
    expect(
        message(&|scenario, _| scenario.wheels[1].wheel.limits.max_speed_rad_s = None),
        "wheel[2] has no `max_speed_rad_s`",
    );
    expect(
        message(&|scenario, _| scenario.wheels[0].speed_rad_s = 301.0),
        "wheel[1] starts at 301",
    );
    expect(
        message(&|scenario, _| scenario.spacecraft.rate_rad_s.x = 0.01),
        "the body turns at 0.01",
    );
    expect(message(&|_, request| request.duration_s = 5.0), "50 samples");
    expect(
        message(&|_, request| request.limits.keep_out[0].half_angle_rad = 0.9),
        "keep-out cone 1: the boresight is 45.6 deg",
    );
    expect(
        message(&|scenario, _| {
            scenario.prior.as_mut().unwrap().inertia_kg_m2 = [1e-5, 1e-5, 1e-5, 0.0, 0.0, 0.0]
        }),
        "does not carry the wheels",
    );
}
