//! A scenario: a spacecraft and its flight.

use flight_input::craft::{
    Craft, Filter, GyroData, InitialEstimate, LogFormat, Prior, SolveFor, StatedHardware,
};
use fsw_core::Inertia;
use nalgebra::Vector3;

use super::change::{Changes, Stretch};
use super::control::Control;
use super::dispersion::Dispersion;
use super::fault::Fault;
use super::gyro::SimulatedGyro;
use super::hardware::TrueHardware;
use super::profile::ExternalTorque;
use super::spacecraft::Spacecraft;
use super::wheel::SimulatedWheel;

/// A spacecraft and its flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name in reports.
    pub name: String,
    /// Duration of the flight, s.
    pub duration_s: f64,
    /// The body at the start.
    pub spacecraft: Spacecraft,
    /// Changes of its inertia in flight.
    pub changes: Changes,
    /// The reaction wheels, in the order of the estimator's wheel speeds.
    pub wheels: Vec<SimulatedWheel>,
    /// Commanded external torque, known to the estimator.
    pub torque: ExternalTorque,
    /// Attitude controller, if the loop is closed. Its torque is added to the motors' profiles.
    pub control: Option<Control>,
    /// The gyro.
    pub gyro: SimulatedGyro,
    /// Errors of the hardware as known to the estimator. Ideal unless stated.
    pub hardware: StatedHardware,
    /// True errors of the hardware, unknown to the estimator. Those drawn by the seed are included
    /// once drawn: see [`Scenario::of_seed`].
    pub true_hardware: TrueHardware,
    /// True constant external torque unknown to the estimator, body axes, N m.
    pub disturbance_torque_n_m: Vector3<f64>,
    /// Faults between sensors and estimator, in the order of their application.
    pub faults: Vec<Fault>,
    /// Unknowns of the estimator besides the inertia.
    pub solve_for: SolveFor,
    /// Prior inertia of the estimator, if any.
    pub prior: Option<Prior>,
    /// Process noise of the filters. The smoothness of the torque is that of its profile.
    pub filter: Filter,
    /// Differences between the runs of a campaign.
    pub dispersion: Dispersion,
    /// Initial state of the estimator, once drawn: see [`Scenario::of_seed`].
    pub initial_estimate: Option<InitialEstimate>,
}

impl Scenario {
    /// A free body without wheels, torque, disturbance, prior or dispersion.
    pub(super) fn free(
        name: String,
        duration_s: f64,
        spacecraft: Spacecraft,
        gyro: SimulatedGyro,
    ) -> Self {
        Self {
            name,
            duration_s,
            spacecraft,
            changes: Changes::default(),
            wheels: Vec::new(),
            torque: ExternalTorque::ZERO,
            control: None,
            gyro,
            hardware: StatedHardware::default(),
            true_hardware: TrueHardware::default(),
            disturbance_torque_n_m: Vector3::zeros(),
            faults: Vec::new(),
            solve_for: SolveFor::default(),
            prior: None,
            filter: Filter::default(),
            dispersion: Dispersion::default(),
            initial_estimate: None,
        }
    }

    /// The spacecraft as known to the estimator: without true inertia, bias and disturbance.
    ///
    /// A drawn initial estimate replaces the prior if it is physical.
    pub fn craft(&self) -> Craft {
        let drawn = self.initial_estimate.as_ref().map(|start| Prior {
            inertia_kg_m2: start.inertia_kg_m2,
            sigma_kg_m2: start.sigma_kg_m2,
        });
        let physical = drawn.filter(|start| Inertia::new(start.inertia_kg_m2).check().is_ok());
        Craft {
            wheels: self.wheels.iter().map(|simulated| simulated.wheel.clone()).collect(),
            thrusters: self.torque.thrusters.iter().map(|simulated| simulated.thruster).collect(),
            gyro: GyroData {
                noise_rad_s: Some(self.gyro.noise_rad_s),
                range_rad_s: self.gyro.range_rad_s,
                quantum_rad_s: self.gyro.quantum_rad_s,
            },
            hardware: self.hardware.clone(),
            prior: physical.or_else(|| self.prior.clone()),
            filter: Filter { is_torque_smooth: self.torque.is_smooth(), ..self.filter },
            solve_for: self.solve_for,
            log: LogFormat::default(),
            initial_estimate: self.initial_estimate.clone(),
        }
    }

    /// The wheels with their true axes and spin inertias.
    pub fn true_wheels(&self) -> Vec<SimulatedWheel> {
        let wheels = self.wheels.iter().enumerate();
        wheels.map(|(index, wheel)| self.true_hardware.true_wheel(index, wheel)).collect()
    }

    /// The flight in stretches between sudden changes; a single one without changes.
    pub fn stretches(&self) -> impl Iterator<Item = Stretch> {
        (0..=self.changes.sudden.len()).map(|index| self.stretch(index))
    }

    /// The stretch after `after` sudden changes.
    pub fn stretch(&self, after: usize) -> Stretch {
        self.changes.stretch(after, self.spacecraft.inertia_kg_m2)
    }

    /// The true elements at a time of the flight, kg m².
    pub fn inertia_at_kg_m2(&self, time_s: f64) -> [f64; 6] {
        let begun = self.changes.sudden.partition_point(|change| change.time_s <= time_s);
        self.stretch(begun).inertia_at_kg_m2(time_s)
    }

    /// The true elements at the end of the flight, kg m²: the reference of the last estimate.
    pub fn final_inertia_kg_m2(&self) -> [f64; 6] {
        self.inertia_at_kg_m2(self.duration_s)
    }
}
