//! The problem of a design: spacecraft, prior, limits and objective.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use thiserror::Error;

use super::columns::{Columns, Treatment};
use super::information::Criterion;
use super::limits::Limits;
use super::motion::Model;
use crate::input::Scenario;
use crate::input::craft::Prior;
use flight_input::craft::Thruster;
use flight_input::inertia::tensor;

/// A wheel as the design needs it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DesignWheel {
    pub axis: Vector3<f64>,
    pub spin_inertia_kg_m2: f64,
    /// Largest torque allowed, N m.
    pub max_torque_n_m: f64,
    /// Largest speed allowed, rad/s.
    pub max_speed_rad_s: f64,
    /// Speed at the start, rad/s.
    pub speed_rad_s: f64,
}

/// Two thrusters of opposite torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    /// Places of the two among the thrusters.
    pub thrusters: [usize; 2],
    /// Torque of the first on the body while on, N m.
    pub torque_n_m: Vector3<f64>,
    /// Samples of the gyro in the shortest pulse.
    pub pulse_samples: usize,
}

/// Limits, criterion and effort of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Duration, s.
    pub duration_s: f64,
    /// Limits of the motion.
    pub limits: Limits,
    /// Measure to be minimised.
    pub criterion: Criterion,
    /// Treatment of stated errors of the hardware.
    pub treatment: Treatment,
    /// The prior of the inertia is information of its estimate. Otherwise it is the range of the design
    /// alone.
    pub uses_prior: bool,
    /// Seed of starts and of samples of the prior.
    pub seed: u64,
    /// Amount of computation.
    pub effort: Effort,
}

/// Amount of computation of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Best fixed and random manoeuvres from which the optimiser starts.
    pub starts: usize,
    /// Rounds of the augmented Lagrangian.
    pub rounds: usize,
    /// Iterations of the optimiser in a round.
    pub iterations: u64,
    /// Samples of the prior in the objective; one if the inertia is known.
    pub samples: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self { starts: 4, rounds: 6, iterations: 30, samples: 5 }
    }
}

/// A spacecraft for which no manoeuvre can be designed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DesignError {
    /// Neither wheels nor thrusters.
    #[error(
        "no [[wheel]] and no [[thruster]]: a manoeuvre is torque of reaction wheels or thrusters; add them"
    )]
    NoSource,
    /// A thruster whose torque no other opposes.
    #[error(
        "thruster[{thruster}] has the torque {torque_n_m:?} N m, and no other thruster has its opposite: a \
         manoeuvre returns to rest; add it, or remove thruster[{thruster}]"
    )]
    NoOpposite {
        /// Number of the thruster, from 1.
        thruster: usize,
        /// Its torque, N m.
        torque_n_m: [f64; 3],
    },
    /// A shortest pulse of a large part of the manoeuvre.
    #[error(
        "thruster[{thruster}]: {pulses} pulses of `min_pulse_s` fit in {duration_s} s; a design takes at least \
         {least}: give a longer --duration"
    )]
    FewPulses {
        /// Number of the thruster, from 1.
        thruster: usize,
        /// Pulses in the manoeuvre.
        pulses: usize,
        /// Duration, s.
        duration_s: f64,
        /// Pulses required.
        least: usize,
    },
    /// A wheel without limits.
    #[error(
        "wheel[{wheel}] has no `{key}`; add it from the data sheet: without limits no manoeuvre is best"
    )]
    NoLimit {
        /// Number of the wheel, from 1.
        wheel: usize,
        /// The missing key.
        key: &'static str,
    },
    /// A wheel that starts above its limit.
    #[error(
        "wheel[{wheel}] starts at {speed_rad_s} rad/s, beyond the {limit_rad_s} rad/s allowed; lower \
         `speed_rad_s` or raise `--momentum`"
    )]
    StartsTooFast {
        /// Number of the wheel, from 1.
        wheel: usize,
        /// Its speed at the start, rad/s.
        speed_rad_s: f64,
        /// Speed allowed, rad/s.
        limit_rad_s: f64,
    },
    /// No prior in a craft file.
    #[error("no [prior]: a design needs the expected inertia and its sigma; add [prior]")]
    NoPrior,
    /// No noise.
    #[error("no `gyro.noise_rad_s`: the design depends on it; add it from the data sheet")]
    NoNoise,
    /// Inertia of the prior that does not carry its wheels.
    #[error(
        "the prior's inertia does not carry the wheels (locked and included) throughout its two sigma; \
         reduce `prior.sigma_kg_m2`"
    )]
    PriorTooWide,
    /// A body that turns.
    #[error(
        "the body turns at {rate_rad_s} rad/s at the start; the excursion is measured from an attitude at \
         rest: set `spacecraft.rate_rad_s` to zero"
    )]
    Turning {
        /// Rate at the start, rad/s.
        rate_rad_s: f64,
    },
    /// A boresight that starts in a forbidden cone.
    #[error(
        "keep-out cone {cone}: the boresight is {angle_deg:.1} deg from the direction at the start, inside \
         the cone of {limit_deg:.1} deg; start from another attitude"
    )]
    StartsInCone {
        /// Number of the cone, from 1.
        cone: usize,
        /// Angle at the start, deg.
        angle_deg: f64,
        /// Half angle of the cone, deg.
        limit_deg: f64,
    },
    /// A manoeuvre too short for its parametrisation.
    #[error(
        "{duration_s} s at {rate_hz} Hz are {samples:.0} samples; a design takes at least {least}: give a \
         longer --duration"
    )]
    TooShort {
        /// Duration, s.
        duration_s: f64,
        /// Samples per second, Hz.
        rate_hz: f64,
        /// Samples.
        samples: f64,
        /// Samples required.
        least: usize,
    },
    /// Stopped before the first start was evaluated.
    #[error("stopped before a manoeuvre was found; there is no result")]
    Stopped,
    /// No manoeuvre within the limits.
    #[error("no manoeuvre within the limits observes the inertia; relax excursion, rate or cones")]
    Nothing,
}

impl DesignError {
    /// True if another input would be accepted; false if the computation had no result.
    pub fn is_of_input(&self) -> bool {
        !matches!(self, Self::Stopped | Self::Nothing)
    }
}

/// The problem.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub wheels: Vec<DesignWheel>,
    pub pairs: Vec<Pair>,
    /// Inertia expected, and one sigma; zero if known.
    pub prior: Prior,
    /// Mean moment of the prior: unit of inertia and torque.
    pub unit_kg_m2: f64,
    pub attitude: UnitQuaternion<f64>,
    pub noise_rad_s: f64,
    pub rate_hz: f64,
    pub duration_s: f64,
    pub columns: Columns,
    pub limits: Limits,
    pub criterion: Criterion,
}

/// Fewest samples of a manoeuvre: seven knots of eight samples.
const LEAST_SAMPLES: usize = 56;
/// Fewest pulses of a thruster in a manoeuvre: four for each of four sections of a slew.
const LEAST_PULSES: usize = 16;
/// Share by which opposite torques may differ: rounding of the data sheet.
const OPPOSITE: f64 = 1e-6;
/// Rate at the start below which the body is at rest, rad/s.
const REST_RAD_S: f64 = 1e-9;

impl Problem {
    /// The problem of a scenario; its prior, or its inertia if known, is the expected inertia.
    pub(super) fn new(scenario: &Scenario, request: &Request) -> Result<Self, DesignError> {
        let prior = scenario.prior.clone().unwrap_or(Prior {
            inertia_kg_m2: scenario.spacecraft.inertia_kg_m2,
            sigma_kg_m2: [0.0; 6],
        });
        let unit_kg_m2 = prior.inertia_kg_m2[..3].iter().sum::<f64>() / 3.0;
        let is_information = request.uses_prior && prior.sigma_kg_m2 != [0.0; 6];
        let sigma = is_information.then_some(&prior.sigma_kg_m2);
        let columns = Columns::new(scenario, request.treatment, sigma, unit_kg_m2);
        let problem = Self {
            wheels: wheels(scenario, &request.limits)?,
            pairs: pairs(scenario, request.duration_s)?,
            unit_kg_m2,
            attitude: scenario.spacecraft.attitude,
            noise_rad_s: scenario.gyro.reading_variance_rad2_s2().sqrt(),
            rate_hz: scenario.gyro.rate_hz,
            duration_s: request.duration_s,
            columns,
            limits: request.limits.clone(),
            criterion: request.criterion,
            prior,
        };
        problem.check(scenario)?;
        Ok(problem)
    }

    fn check(&self, scenario: &Scenario) -> Result<(), DesignError> {
        if self.channels() == 0 {
            return Err(DesignError::NoSource);
        }
        let rate_rad_s = scenario.spacecraft.rate_rad_s.norm();
        if rate_rad_s > REST_RAD_S {
            return Err(DesignError::Turning { rate_rad_s });
        }
        let samples = self.duration_s * self.rate_hz;
        if samples < LEAST_SAMPLES as f64 {
            let Self { duration_s, rate_hz, .. } = *self;
            return Err(DesignError::TooShort {
                duration_s,
                rate_hz,
                samples,
                least: LEAST_SAMPLES,
            });
        }
        for (index, cone) in self.limits.keep_out.iter().enumerate() {
            let angle_rad = cone.angle_rad(&self.attitude);
            if angle_rad <= cone.half_angle_rad {
                return Err(DesignError::StartsInCone {
                    cone: index + 1,
                    angle_deg: angle_rad.to_degrees(),
                    limit_deg: cone.half_angle_rad.to_degrees(),
                });
            }
        }
        Ok(())
    }

    /// Spacecraft of one inertia with these columns.
    pub(super) fn model<'a>(
        &'a self,
        columns: &'a Columns,
        inertia_kg_m2: &[f64; 6],
    ) -> Option<Model<'a>> {
        Model::new((&self.wheels, &self.pairs), columns, tensor(inertia_kg_m2), self.unit_kg_m2)
    }

    /// Number of wheels and pairs of thrusters.
    pub(super) fn channels(&self) -> usize {
        self.wheels.len() + self.pairs.len()
    }

    /// Axial momentum of the wheels at the start, at rest, N m s.
    pub(super) fn start_momentum(&self) -> Vec<f64> {
        self.wheels.iter().map(|wheel| wheel.spin_inertia_kg_m2 * wheel.speed_rad_s).collect()
    }

    /// True if the total momentum is zero throughout.
    pub(super) fn is_without_momentum(&self) -> bool {
        let momentum: Vector3<f64> =
            self.wheels.iter().zip(self.start_momentum()).map(|(wheel, h)| wheel.axis * h).sum();
        let largest: f64 =
            self.wheels.iter().map(|w| w.spin_inertia_kg_m2 * w.max_speed_rad_s).sum();
        momentum.norm() <= 1e-12 * largest
    }

    /// State of a model at the start.
    pub(super) fn start(&self, model: &Model<'_>) -> Vec<f64> {
        let q = &self.attitude;
        model.start(&Vector3::zeros(), [q.w, q.i, q.j, q.k], &self.start_momentum())
    }

    /// Torques of the wheels, levels of the pairs, that give a torque on the body: `u = −A⁺ τ` with the axes `A` of the
    /// wheels; with pairs each channel in units of its limit.
    pub(super) fn distribution(&self) -> Vec<Vector3<f64>> {
        if !self.pairs.is_empty() {
            return self.weighted_distribution();
        }
        let axes: Matrix3<f64> = self.wheels.iter().map(|w| w.axis * w.axis.transpose()).sum();
        let inverse = axes.pseudo_inverse(1e-9).unwrap_or_else(|_| Matrix3::zeros());
        self.wheels.iter().map(|wheel| -(inverse * wheel.axis)).collect()
    }

    /// `u = L Wᵀ (W Wᵀ)⁺ τ` with the limits `L` of the channels and the torques `W` on the body at the limits.
    fn weighted_distribution(&self) -> Vec<Vector3<f64>> {
        let wheels = self.wheels.iter().map(|wheel| (-wheel.axis, wheel.max_torque_n_m));
        let pairs = self.pairs.iter().map(|pair| (pair.torque_n_m, 1.0));
        let all: Vec<(Vector3<f64>, f64)> = wheels.chain(pairs).collect();
        let at_limit = |(torque, limit): &(Vector3<f64>, f64)| torque * *limit;
        let sum: Matrix3<f64> = all.iter().map(|of| at_limit(of) * at_limit(of).transpose()).sum();
        let epsilon = 1e-9 * sum.trace();
        let inverse = sum.pseudo_inverse(epsilon).unwrap_or_else(|_| Matrix3::zeros());
        all.iter().map(|of| inverse * at_limit(of) * of.1).collect()
    }
}

/// Thrusters in pairs of opposite torque.
pub(super) fn pairs(scenario: &Scenario, duration_s: f64) -> Result<Vec<Pair>, DesignError> {
    let thrusters: Vec<Thruster> = scenario.craft().thrusters;
    let mut pairs: Vec<Pair> = Vec::new();
    let mut free: Vec<usize> = (0..thrusters.len()).collect();
    while !free.is_empty() {
        let first = free.remove(0);
        let torque_n_m = thrusters[first].torque_n_m;
        let is_opposite = |other: &usize| {
            (thrusters[*other].torque_n_m + torque_n_m).norm() <= OPPOSITE * torque_n_m.norm()
        };
        let thruster = first + 1;
        let opposite = free.iter().position(is_opposite);
        let opposite =
            opposite.ok_or(DesignError::NoOpposite { thruster, torque_n_m: torque_n_m.into() })?;
        let second = free.remove(opposite);
        let min_pulse_s = thrusters[first].min_pulse_s.max(thrusters[second].min_pulse_s);
        let samples = min_pulse_s * scenario.gyro.rate_hz;
        let pulse_samples = ((samples - OPPOSITE).ceil() as usize).max(1);
        let pulses = (duration_s * scenario.gyro.rate_hz) as usize / pulse_samples;
        if pulses < LEAST_PULSES {
            let least = LEAST_PULSES;
            return Err(DesignError::FewPulses { thruster, pulses, duration_s, least });
        }
        pairs.push(Pair { thrusters: [first, second], torque_n_m, pulse_samples });
    }
    Ok(pairs)
}

fn wheels(scenario: &Scenario, limits: &Limits) -> Result<Vec<DesignWheel>, DesignError> {
    let of = |(index, simulated): (usize, &crate::input::scenario::SimulatedWheel)| {
        let missing = |key| DesignError::NoLimit { wheel: index + 1, key };
        let wheel = &simulated.wheel;
        let torque = wheel.limits.max_torque_n_m.ok_or_else(|| missing("max_torque_n_m"))?;
        let speed = wheel.limits.max_speed_rad_s.ok_or_else(|| missing("max_speed_rad_s"))?;
        let limit_rad_s = limits.momentum_share * speed;
        if simulated.speed_rad_s.abs() >= limit_rad_s {
            let speed_rad_s = simulated.speed_rad_s;
            return Err(DesignError::StartsTooFast { wheel: index + 1, speed_rad_s, limit_rad_s });
        }
        Ok(DesignWheel {
            axis: wheel.axis,
            spin_inertia_kg_m2: wheel.spin_inertia_kg_m2,
            max_torque_n_m: limits.torque_share * torque,
            max_speed_rad_s: limit_rad_s,
            speed_rad_s: simulated.speed_rad_s,
        })
    };
    scenario.wheels.iter().enumerate().map(of).collect()
}
