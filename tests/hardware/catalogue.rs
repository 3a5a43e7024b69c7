//! Rows of the catalogue: an imperfection at a level, as an edit of an ideal scenario.
//!
//! Levels are those of data sheets and beyond: a gyro's scale factor from 0.1 % (calibrated) to 3 %, a wheel's spin
//! inertia from 0.3 to 3 %. The edit states the level, unless the row is about an imperfection that no key states.
//! A torque of the environment is drawn for each flight, since its sigma is that of all orbits and dipoles.

use host_sim::input::Scenario;
use host_sim::input::craft::Mode;
use host_sim::input::craft::hardware::{Tachometer, TachometerKind};
use host_sim::input::scenario::hardware::{GyroErrors, Orbit, Pulse, TrueMode, WheelErrors};
use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64;

/// Scenarios of the catalogue: wheels that swing, wheels that slew, thrusters.
pub const SCENARIOS: [&str; 3] = ["cubesat-pyramid", "microsat-slew", "stsat3-spin-up"];
/// The same with everything at data-sheet level at once.
pub const DATA_SHEET: [&str; 3] =
    ["cubesat-pyramid-data-sheet", "microsat-slew-data-sheet", "stsat3-spin-up-data-sheet"];

/// One degree per hour, rad/s.
const DEG_PER_HOUR: f64 = std::f64::consts::PI / 180.0 / 3600.0;
/// One revolution per minute, rad/s.
const RPM: f64 = std::f64::consts::TAU / 60.0;

/// Stream of the generator for imperfections that are drawn here.
const DRAWN_STREAM: u128 = 0x0e27;

/// Edit of an ideal scenario for a flight of this seed.
type Edit = Box<dyn Fn(&mut Scenario, u64) + Send + Sync>;

/// An imperfection at a level.
pub struct Case {
    /// Imperfection.
    pub name: &'static str,
    /// Level in words.
    pub level: String,
    /// True for wheels, false for external torque; none for any scenario.
    pub needs_wheels: Option<bool>,
    /// True where each flight has an imperfection of its own.
    pub is_drawn: bool,
    edit: Edit,
}

impl Case {
    /// The scenario with the imperfection, as drawn for the flight of a seed; none where it does not apply.
    pub fn of(&self, ideal: &Scenario, seed: u64) -> Option<Scenario> {
        let has_wheels = !ideal.wheels.is_empty();
        if self.needs_wheels.is_some_and(|needs| needs != has_wheels) {
            return None;
        }
        let mut scenario = ideal.clone();
        (self.edit)(&mut scenario, seed);
        Some(scenario)
    }
}

/// Rows under construction.
#[derive(Default)]
struct Rows {
    rows: Vec<Case>,
    name: &'static str,
    needs_wheels: Option<bool>,
}

impl Rows {
    fn group(&mut self, name: &'static str, needs_wheels: Option<bool>) -> &mut Self {
        (self.name, self.needs_wheels) = (name, needs_wheels);
        self
    }

    fn add(
        &mut self,
        level: impl Into<String>,
        edit: impl Fn(&mut Scenario) + Send + Sync + 'static,
    ) {
        self.push(level.into(), false, Box::new(move |scenario, _| edit(scenario)));
    }

    fn add_drawn(
        &mut self,
        level: impl Into<String>,
        edit: impl Fn(&mut Scenario, &mut Pcg64) + Send + Sync + 'static,
    ) {
        let drawn = move |scenario: &mut Scenario, seed: u64| {
            edit(scenario, &mut Pcg64::new(seed.into(), DRAWN_STREAM));
        };
        self.push(level.into(), true, Box::new(drawn));
    }

    fn push(&mut self, level: String, is_drawn: bool, edit: Edit) {
        let (name, needs_wheels) = (self.name, self.needs_wheels);
        self.rows.push(Case { name, level, needs_wheels, is_drawn, edit });
    }
}

/// All rows.
pub fn all() -> Vec<Case> {
    let mut rows = Rows::default();
    rows.group("none", None).add("–", |_| ());
    gyro_errors(&mut rows);
    bias(&mut rows);
    delays(&mut rows);
    clock(&mut rows);
    tachometers(&mut rows);
    wheels(&mut rows);
    torques(&mut rows);
    flexible(&mut rows);
    noise(&mut rows);
    rows.rows
}

fn percent(share: f64) -> String {
    format!("{} %", (share * 1e4).round() / 100.0)
}

fn gyro_errors(rows: &mut Rows) {
    rows.group("gyro scale factor", None);
    for share in [0.001, 0.003, 0.005, 0.01, 0.03] {
        rows.add(percent(share), move |s| s.hardware.gyro_scale_sigma = share);
    }
    rows.group("gyro axes", None);
    for deg in [0.05f64, 0.1, 0.3, 0.5, 1.5] {
        let edit = move |s: &mut Scenario| s.hardware.gyro_axes_sigma_rad = deg.to_radians();
        rows.add(format!("{deg}°"), edit);
    }
}

fn bias(rows: &mut Rows) {
    let ask = |s: &mut Scenario, sigma: f64| {
        s.hardware.bias_sigma_rad_s = Some(sigma);
        s.solve_for.gyro_bias = true;
    };
    rows.group("gyro bias", None);
    for deg_s in [0.003f64, 0.01, 0.03, 0.1, 1.0] {
        rows.add(format!("{deg_s} deg/s"), move |s| ask(s, deg_s.to_radians()));
    }
    rows.group("gyro bias walk", None);
    for walk in [1e-6, 3e-6, 1e-5, 3e-5] {
        rows.add(format!("{walk:.0e} rad/s/√s"), move |s| {
            ask(s, 1e-3);
            s.hardware.bias_walk_rad_s_sqrt_s = walk;
            s.gyro.bias_walk_rad_s_sqrt_s = walk;
        });
    }
    rows.group("gyro flicker", None);
    for deg_h in [2.0, 8.0, 24.0] {
        rows.add(format!("{deg_h} deg/h"), move |s| {
            ask(s, 1e-3);
            s.hardware.bias_instability_rad_s = deg_h * DEG_PER_HOUR;
        });
    }
}

fn delays(rows: &mut Rows) {
    rows.group("gyro filter lag", None);
    for ms in [1.0, 5.0, 20.0, 60.0] {
        rows.add(format!("{ms} ms"), move |s| {
            s.true_hardware.gyro.lag_s = ms * 1e-3;
            s.hardware.gyro_delay_sigma_s = ms * 1e-3;
            // The filter reduces an amplitude by (ω τ)² / 2; 0.2 Hz are the fastest drive of the pyramid.
            s.hardware.gyro_scale_sigma = 0.5 * (std::f64::consts::TAU * 0.2 * ms * 1e-3).powi(2);
        });
    }
    rows.group("gyro late", None);
    for ms in [5.0, 15.0, 50.0, 100.0] {
        rows.add(format!("{ms} ms"), move |s| s.hardware.gyro_delay_sigma_s = ms * 1e-3);
    }
    rows.group("tachometer late", Some(true));
    for ms in [5.0, 15.0, 50.0, 100.0] {
        rows.add(format!("{ms} ms"), move |s| {
            s.true_hardware.tachometer.latency_s = ms * 1e-3;
            s.hardware.gyro_delay_sigma_s = ms * 1e-3;
        });
    }
    rows.group("gyro averaged", None);
    rows.add("stated", |s| s.hardware.gyro_averaged = true);
    rows.add("not stated", |s| s.true_hardware.gyro.averaged = true);
    rows.group("gyro and tachometer averaged", Some(true)).add("–", |s| {
        s.true_hardware.gyro.averaged = true;
        s.true_hardware.tachometer.kind = TachometerKind::Mean;
    });
}

fn clock(rows: &mut Rows) {
    rows.group("jitter", None);
    for share in [0.1, 0.3] {
        rows.add(format!("±{}", percent(share)), move |s| s.true_hardware.clock.jitter = share);
    }
    rows.group("clock drift", None);
    for ppm in [100.0, 300.0, 10_000.0] {
        rows.add(format!("{ppm} ppm"), move |s| s.hardware.clock_sigma = ppm * 1e-6);
    }
}

fn tachometers(rows: &mut Rows) {
    let counting = |window_s: Option<f64>| Tachometer {
        kind: TachometerKind::Count { window_s },
        ..Tachometer::default()
    };
    rows.group("tachometer counts 6/turn", Some(true));
    for window_s in [0.1, 1.0] {
        let edit = move |s: &mut Scenario| s.true_hardware.tachometer = counting(Some(window_s));
        rows.add(format!("in {window_s} s"), edit);
    }
    rows.group("tachometer period, not stated", Some(true)).add("6/turn, 1 µs", |s| {
        s.true_hardware.tachometer.kind = TachometerKind::Period { resolution_s: 1e-6 };
        // The mean over the last edge interval is 0.5 to 1.5 of it old: 7 ms at 150 rad/s.
        s.hardware.gyro_delay_sigma_s = 7e-3;
    });
    let mut stated = |name, levels: &[(&str, Tachometer)]| {
        rows.group(name, Some(true));
        for (level, tachometer) in levels.iter().copied() {
            rows.add(level, move |s| s.hardware.tachometers.fill(tachometer));
        }
    };
    let ideal = Tachometer::default();
    let of_kind = |kind| Tachometer { kind, ..ideal };
    let period = |edges_per_turn, resolution_s| Tachometer {
        edges_per_turn,
        ..of_kind(TachometerKind::Period { resolution_s })
    };
    stated("tachometer mean, stated", &[("–", of_kind(TachometerKind::Mean))]);
    stated(
        "tachometer counts 6/turn, stated",
        &[("in 0.1 s", counting(Some(0.1))), ("in 1 s", counting(Some(1.0)))],
    );
    stated(
        "tachometer period, stated",
        &[
            ("6/turn, 1 µs", period(6.0, 1e-6)),
            ("6/turn, 10 µs", period(6.0, 1e-5)),
            ("24/turn, 1 µs", period(24.0, 1e-6)),
        ],
    );
    let rounded = |rpm| Tachometer { quantum_rad_s: rpm * RPM, ..ideal };
    stated("tachometer rounded, stated", &[("3 rpm", rounded(3.0)), ("10 rpm", rounded(10.0))]);
    let held = |hold_s| Tachometer { hold_s, ..ideal };
    stated("tachometer held, stated", &[("1 s", held(1.0)), ("3 s", held(3.0))]);
    rows.group("tachometer rounded", Some(true));
    for rpm in [1.0, 3.0, 10.0] {
        let edit = move |s: &mut Scenario| s.true_hardware.tachometer.quantum_rad_s = rpm * RPM;
        rows.add(format!("{rpm} rpm"), edit);
    }
    rows.group("tachometer held", Some(true));
    for hold_s in [1.0, 3.0] {
        let edit = move |s: &mut Scenario| s.true_hardware.tachometer.hold_s = hold_s;
        rows.add(format!("{hold_s} s"), edit);
    }
}

fn wheels(rows: &mut Rows) {
    rows.group("wheel spin inertia, each", Some(true));
    for share in [0.003, 0.01, 0.03] {
        rows.add(percent(share), move |s| s.hardware.wheel_spin_inertia_sigma.fill(share));
    }
    rows.group("wheel spin inertia, common", Some(true))
        .add("1 %", |s| s.hardware.common_spin_inertia_sigma = 0.01);
    rows.group("wheel axes", Some(true));
    for deg in [0.1f64, 0.2, 0.6, 1.0] {
        let edit = move |s: &mut Scenario| s.hardware.wheel_axis_sigma_rad.fill(deg.to_radians());
        rows.add(format!("{deg}°"), edit);
    }
    rows.group("wheel static imbalance", Some(true));
    for times in [1.0, 3.0] {
        rows.add(format!("{times} ×"), move |s| {
            // 0.1 g mm of a CubeSat's wheel at 2 cm, ten times that of a microsatellite's.
            let size = if s.spacecraft.inertia_kg_m2[0] < 1.0 { 5e-7 } else { 5e-6 };
            let one = WheelErrors {
                static_imbalance_kg_m: times * size,
                position_m: Vector3::new(0.02, 0.02, 0.02),
                ..WheelErrors::default()
            };
            s.true_hardware.wheels = vec![one; s.wheels.len()];
        });
    }
}

/// Field of the Earth at 500 km, T, root mean square over an inclined orbit.
const FIELD_T: f64 = 3.5e-5;

/// Unit vector of any direction, with equal probability.
fn direction(random: &mut Pcg64) -> Vector3<f64> {
    let z: f64 = random.random_range(-1.0..=1.0);
    let azimuth = random.random_range(0.0..std::f64::consts::TAU);
    let across = (1.0 - z * z).sqrt();
    Vector3::new(across * azimuth.cos(), across * azimuth.sin(), z)
}

/// Any circular orbit at 500 km, without a torque.
fn orbit(random: &mut Pcg64) -> Orbit {
    Orbit {
        altitude_km: 500.0,
        inclination_rad: random.random_range(0.0..std::f64::consts::PI),
        phase_rad: random.random_range(0.0..std::f64::consts::TAU),
        gravity_gradient: false,
        dipole_a_m2: Vector3::zeros(),
        air_density_kg_m3: 0.0,
        drag_area_m2: 0.0,
        pressure_centre_m: Vector3::zeros(),
    }
}

fn torques(rows: &mut Rows) {
    let ask = |s: &mut Scenario, sigma: f64| {
        s.hardware.torque_sigma_n_m = Some(sigma);
        s.solve_for.torque = true;
    };
    rows.group("constant torque", None);
    for torque in [1e-7, 1e-6, 1e-5, 1e-4] {
        rows.add(format!("{torque:.0e} N m"), move |s| ask(s, torque));
    }
    rows.group("residual dipole", None);
    for times in [1.0, 3.0, 10.0] {
        rows.add_drawn(format!("{times} ×"), move |s, random| {
            // 0.01, 0.1 and 0.3 A m² for 5, 50 and 150 kg, in any direction.
            let moment = s.spacecraft.inertia_kg_m2[0];
            let dipole = if moment < 1.0 {
                0.01
            } else if moment < 10.0 {
                0.1
            } else {
                0.3
            };
            let dipole = times * dipole;
            s.true_hardware.orbit =
                Some(Orbit { dipole_a_m2: direction(random) * dipole, ..orbit(random) });
            // In a field of 25 to 50 µT: mean square of an axis over all directions.
            ask(s, dipole * FIELD_T / 3f64.sqrt());
            s.hardware.varying_torque_sigma_n_m = dipole * FIELD_T * (2.0f64 / 9.0).sqrt();
        });
    }
    rows.group("gravity gradient", None).add_drawn("500 km", move |s, random| {
        s.true_hardware.orbit = Some(Orbit { gravity_gradient: true, ..orbit(random) });
        let spread = 0.3 * s.spacecraft.inertia_kg_m2[2];
        let torque = 1.5 * 1.1e-3 * 1.1e-3 * spread;
        ask(s, torque);
        // RMS of an axis over all attitudes, of 3 n² (J₂ − J₃) y z for a unit vector: a third of the largest one.
        s.hardware.varying_torque_sigma_n_m = torque / 3.0;
    });
    rows.group("3 pulses not in the log", None);
    for times in [1.0, 3.0, 10.0] {
        rows.add(format!("{times} ×"), move |s| {
            let impulse = 1e-4 * s.spacecraft.inertia_kg_m2[0];
            s.true_hardware.pulses = [0.2, 0.45, 0.7]
                .into_iter()
                .zip([Vector3::x(), -Vector3::y(), Vector3::z()])
                .map(|(share, axis)| Pulse {
                    time_s: share * s.duration_s,
                    duration_s: 0.02,
                    torque_n_m: axis * (times * impulse / 0.02),
                })
                .collect();
        });
    }
    rows.group("known torque", Some(false));
    for share in [0.01, 0.05] {
        rows.add(percent(share), move |s| s.hardware.torque_scale_sigma = share);
    }
}

/// Knowledge of a mode.
#[derive(Clone, Copy)]
enum Statement {
    /// None.
    Absent,
    /// Frequency and damping as they are.
    Exact,
    /// The frequency a tenth below the true one, and a sigma of a tenth.
    Uncertain,
    /// The frequency a tenth below the true one, as exact.
    Wrong,
}

fn flexible(rows: &mut Rows) {
    let mut mode = |name, frequency_hz: f64, damping: f64, shares: &[f64], statement: Statement| {
        rows.group(name, None);
        for share in shares.iter().copied() {
            rows.add(percent(share), move |s| {
                let axis = None;
                let mode = TrueMode { frequency_hz, damping, inertia_share: share, axis };
                s.true_hardware.modes = vec![mode];
                let stated = |factor, frequency_sigma| Mode {
                    frequency_hz: factor * frequency_hz,
                    damping,
                    frequency_sigma,
                    damping_sigma: 0.0,
                };
                s.hardware.modes = match statement {
                    Absent => Vec::new(),
                    Exact => vec![stated(1.0, 0.0)],
                    Uncertain => vec![stated(0.9, 0.1)],
                    Wrong => vec![stated(0.9, 0.0)],
                };
            });
        }
    };
    use Statement::{Absent, Exact, Uncertain, Wrong};
    mode("flexible mode 0.5 Hz, not stated", 0.5, 0.01, &[0.01, 0.03, 0.09], Absent);
    mode("flexible mode 2 Hz, not stated", 2.0, 0.01, &[0.03], Absent);
    mode("slosh 0.05 Hz, not stated", 0.05, 0.05, &[0.01, 0.02, 0.06], Absent);
    mode("flexible mode 0.2 Hz, stated", 0.2, 0.01, &[0.01, 0.03, 0.09], Exact);
    mode("flexible mode 0.5 Hz, stated", 0.5, 0.01, &[0.01, 0.03, 0.09], Exact);
    mode("flexible mode 1 Hz, stated", 1.0, 0.005, &[0.03, 0.09], Exact);
    mode("flexible mode 2 Hz, stated", 2.0, 0.01, &[0.03, 0.09], Exact);
    mode("slosh 0.05 Hz, stated", 0.05, 0.05, &[0.02, 0.06], Exact);
    mode("flexible mode 0.5 Hz, 10 % off, σ 10 %", 0.5, 0.01, &[0.01, 0.03, 0.09], Uncertain);
    mode("slosh 0.05 Hz, 10 % off, σ 10 %", 0.05, 0.05, &[0.02], Uncertain);
    mode("flexible mode 0.5 Hz, 10 % off, σ 0", 0.5, 0.01, &[0.01, 0.03, 0.09], Wrong);
}

fn noise(rows: &mut Rows) {
    rows.group("gyro noise over the stated", None);
    for factor in [0.5f64, 1.2, 2.0, 3.0] {
        rows.add(format!("{factor}"), move |s| s.true_hardware.gyro.noise_factor = factor);
    }
    rows.group("gyro noise coloured", None);
    for correlation in [0.3, 0.7, 0.9] {
        let edit = move |s: &mut Scenario| s.true_hardware.gyro.noise_correlation = correlation;
        rows.add(format!("ρ {correlation}"), edit);
    }
    rows.group("outliers of 10 to 50 σ", None);
    for share in [0.001, 0.003, 0.01] {
        let edit = move |s: &mut Scenario| s.true_hardware.gyro.outlier_share = share;
        rows.add(percent(share), edit);
    }
    rows.group("outliers of 3 to 6 σ", None).add("1 %", |s| {
        let gyro = &s.true_hardware.gyro;
        s.true_hardware.gyro =
            GyroErrors { outlier_share: 0.01, outlier_sigma: [3.0, 6.0], ..gyro.clone() };
    });
    rows.group("gyro quantum", None)
        .add("125 deg/s, 16 bit", |s| s.gyro.quantum_rad_s = Some(6.66e-5));
}
