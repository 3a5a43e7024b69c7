//! Flights of the bench: the committed recording, and two longer synthetic flights with every event
//! that makes a step more expensive.
//!
//! The truth of a synthetic flight is the gyrostat of fsw-core, integrated from sample to sample. The
//! gyro adds white noise, and the plan adds faults. None of it is counted.

use crate::noise::Noise;
use fsw_core::dynamics::gyrostat::Gyrostat;
use fsw_core::dynamics::interval::{Drive, Interval};
use fsw_core::dynamics::step::runge_kutta_4;
use fsw_core::{Inertia, Sample, Vec3, WheelArray};
use fsw_target::flight::craft::WHEELS;
use fsw_target::stand_in::recording::cubesat_pyramid::{CRAFT, ROWS};

/// Sample interval, as in the recording.
const PERIOD_US: u64 = 100_000;
const PERIOD_S: f32 = 0.1;

/// Inertia of the recording's CubeSat, scenario `cubesat-pyramid`.
const CUBESAT_KG_M2: [f32; 6] = [0.058, 0.104, 0.118, -0.0021, 0.0016, 0.0028];
/// Inertia with deployed panels.
const DEPLOYED_KG_M2: [f32; 6] = [0.064, 0.125, 0.143, -0.0021, 0.0016, 0.0028];

/// Excitation by the wheels: mean speed, rad/s, and two sines per wheel, slow and fast, with
/// frequencies in 0.01 Hz.
const MEAN_SPEED_RAD_S: [f32; WHEELS] = [200.0, -200.0, 200.0, -200.0];
const SLOW_CENTIHERTZ: [u32; WHEELS] = [5, 7, 6, 4];
const FAST_CENTIHERTZ: [u32; WHEELS] = [17, 13, 19, 23];
const SLOW_RAD_S: f32 = 90.0;
const FAST_RAD_S: f32 = 35.0;

/// Period of 0.01 Hz, half samples.
const HALF_SAMPLES: u32 = 2_000;

/// Duration of the ramps of an excitation, samples.
const RAMP: u32 = 50;

/// Events of a flight by sample number.
pub struct Plan {
    /// Name in the table.
    pub name: &'static str,
    /// Number of samples.
    pub samples: u32,
    rate_rad_s: [f32; 3],
    /// First and last sample of each excitation by the wheels.
    excitation: &'static [(u32, u32)],
    /// First and last sample of each thrust, and its torque, N m.
    thrust: &'static [(u32, u32, [f32; 3])],
    /// First sample with deployed panels.
    deployed_from: u32,
    faults: &'static [(u32, Fault)],
}

/// Fault of a sample.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// A rate off by a thousand sigma.
    Spike,
    NotFinite,
    Saturated,
    /// A repeated reading.
    Stuck,
    /// A missing sample.
    Lost,
    /// A repeated time stamp.
    OutOfOrder,
    /// A delay by a third of the sample interval.
    Late,
}

/// Rest, an excitation with every fault, rest; an excitation with a panel deployment, rest; and an
/// excitation, long enough to fill a window of 512 blocks, which then merges blocks.
pub const MISSION: Plan = Plan {
    name: "mission",
    samples: 8_000,
    rate_rad_s: [0.0; 3],
    excitation: &[(100, 1_400), (2_000, 3_000), (3_700, 8_000)],
    thrust: &[(7_000, 7_030, [2e-3, -1e-3, 1e-3]), (7_200, 7_230, [-2e-3, 1e-3, -1e-3])],
    deployed_from: 2_600,
    faults: &[
        (700, Fault::Spike),
        (720, Fault::NotFinite),
        (740, Fault::Saturated),
        (760, Fault::OutOfOrder),
        (780, Fault::Late),
        (800, Fault::Lost),
        (821, Fault::Spike),
        (822, Fault::Spike),
        (823, Fault::Spike),
        (4_500, Fault::Spike),
    ],
};

/// Many turns of a fast tumbling body with thrusts: the flight that stores the most blocks.
pub const TUMBLE: Plan = Plan {
    name: "tumble",
    samples: 4_000,
    rate_rad_s: [0.5, -0.3, 0.6],
    excitation: &[(200, 4_000)],
    thrust: &[
        (300, 330, [2e-3, 1e-3, 0.0]),
        (600, 630, [-2e-3, 0.0, 1e-3]),
        (1_500, 1_530, [0.0, 2e-3, -1e-3]),
        (2_500, 2_530, [1e-3, -2e-3, 0.0]),
    ],
    deployed_from: u32::MAX,
    faults: &[],
};

/// Samples with repeated readings, and missing samples.
const STUCK: core::ops::Range<u32> = 840..860;
const SILENT: core::ops::Range<u32> = 900..950;

/// Synthetic flight, sample by sample.
pub struct Flight {
    plan: &'static Plan,
    wheels: WheelArray<f32, WHEELS>,
    rate_rad_s: Vec3<f32>,
    last_measured: Vec3<f32>,
    noise: Noise,
    next: u32,
}

impl Flight {
    /// A flight before its first sample.
    pub fn new(plan: &'static Plan, wheels: WheelArray<f32, WHEELS>) -> Self {
        let rate_rad_s = Vec3::from(plan.rate_rad_s);
        Self { plan, wheels, rate_rad_s, last_measured: rate_rad_s, noise: Noise::new(), next: 0 }
    }
}

impl Iterator for Flight {
    type Item = Sample<f32, WHEELS>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.next < self.plan.samples {
            let sample = self.sample();
            let is_lost = self.plan.fault(self.next) == Some(Fault::Lost);
            self.advance();
            if !is_lost {
                return Some(sample);
            }
        }
        None
    }
}

impl Flight {
    /// Readings of the sensors at this sample.
    fn sample(&mut self) -> Sample<f32, WHEELS> {
        let noise_rad_s = CRAFT.gyro_noise_rad_s;
        let noise = Vec3::from_fn(|_, _| self.noise.standard() * noise_rad_s);
        let time_us = u64::from(self.next) * PERIOD_US;
        let mut sample = Sample {
            time_us,
            rate_rad_s: self.rate_rad_s + noise,
            wheel_speed_rad_s: self.plan.wheel_speed_rad_s(2 * self.next),
            torque_n_m: self.plan.torque_n_m(self.next),
            attitude: None,
        };
        match self.plan.fault(self.next) {
            Some(Fault::Spike) => sample.rate_rad_s.y += 1e3 * noise_rad_s,
            Some(Fault::NotFinite) => sample.rate_rad_s.x = f32::NAN,
            Some(Fault::Saturated) => sample.rate_rad_s.z = 1e3,
            Some(Fault::Stuck) => sample.rate_rad_s = self.last_measured,
            Some(Fault::OutOfOrder) => sample.time_us -= PERIOD_US,
            Some(Fault::Late) => sample.time_us += PERIOD_US / 3,
            Some(Fault::Lost) | None => {}
        }
        self.last_measured = sample.rate_rad_s;
        sample
    }

    /// Integrates to the next sample.
    fn advance(&mut self) {
        let drive = |half_samples: u32, torque_n_m: Vec3<f32>| Drive {
            torque_n_m,
            wheel_momentum_n_m_s: self
                .wheels
                .momentum_n_m_s(&self.plan.wheel_speed_rad_s(half_samples)),
        };
        let now = 2 * self.next;
        let (torque, later) =
            (self.plan.torque_n_m(self.next), self.plan.torque_n_m(self.next + 1));
        let interval = Interval {
            duration_s: PERIOD_S,
            start: drive(now, torque),
            middle: drive(now + 1, (torque + later) * 0.5),
            end: drive(now + 2, later),
        };
        if let Some(body) = Gyrostat::new(&self.plan.inertia(self.next)) {
            self.rate_rad_s = runge_kutta_4(&body, &self.rate_rad_s, &interval);
        }
        self.next += 1;
        if self.next == self.plan.deployed_from {
            self.deploy();
        }
    }

    /// Deployment: the inertia changes at once, at constant momentum of body and wheels.
    fn deploy(&mut self) {
        let momentum = Inertia::new(CUBESAT_KG_M2).matrix_kg_m2() * self.rate_rad_s;
        if let Some(inverse) = Inertia::new(DEPLOYED_KG_M2).inverse() {
            self.rate_rad_s = inverse * momentum;
        }
    }
}

impl Plan {
    fn inertia(&self, sample: u32) -> Inertia<f32> {
        Inertia::new(if sample < self.deployed_from { CUBESAT_KG_M2 } else { DEPLOYED_KG_M2 })
    }

    fn fault(&self, sample: u32) -> Option<Fault> {
        let listed = self.faults.iter().find(|(at, _)| *at == sample).map(|(_, fault)| *fault);
        if self.faults.is_empty() || listed.is_some() {
            return listed;
        }
        if STUCK.contains(&sample) {
            return Some(Fault::Stuck);
        }
        SILENT.contains(&sample).then_some(Fault::Lost)
    }

    fn torque_n_m(&self, sample: u32) -> Vec3<f32> {
        let firing = self.thrust.iter().find(|(from, to, _)| (*from..*to).contains(&sample));
        firing.map_or(Vec3::zeros(), |(_, _, torque)| Vec3::from(*torque))
    }

    /// Wheel speeds at a time in half samples.
    fn wheel_speed_rad_s(&self, half_samples: u32) -> [f32; WHEELS] {
        let share: f32 = self.excitation.iter().map(|phase| ramp(half_samples, *phase)).sum();
        core::array::from_fn(|i| {
            let slow = SLOW_RAD_S * sine(SLOW_CENTIHERTZ[i] * half_samples);
            let fast = FAST_RAD_S * sine(FAST_CENTIHERTZ[i] * half_samples);
            MEAN_SPEED_RAD_S[i] + share * (slow + fast)
        })
    }
}

/// Smooth rise from 0 to 1 and back, between two samples.
fn ramp(half_samples: u32, (from, to): (u32, u32)) -> f32 {
    let after = |start: u32| half_samples as f32 * 0.5 - start as f32;
    let x = (after(from).min(-after(to)) / RAMP as f32).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Sine of an angle in turns / [`HALF_SAMPLES`]: Taylor series up to the ninth power, error 4e-6 at a
/// quarter turn. The sine of libm uses doubles, which the chip emulates.
fn sine(angle: u32) -> f32 {
    let turns = (angle % HALF_SAMPLES) as f32 / HALF_SAMPLES as f32;
    let x = match turns {
        ..=0.25 => turns,
        ..=0.75 => 0.5 - turns,
        _ => turns - 1.0,
    } * core::f32::consts::TAU;
    let q = x * x;
    x * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0))))
}

/// The committed recording.
pub fn recorded() -> impl Iterator<Item = Sample<f32, WHEELS>> {
    ROWS.iter().map(|row| Sample {
        time_us: row.time_us,
        rate_rad_s: Vec3::from(row.rate_rad_s),
        wheel_speed_rad_s: row.wheel_speed_rad_s,
        torque_n_m: Vec3::from(row.torque_n_m),
        attitude: None,
    })
}
