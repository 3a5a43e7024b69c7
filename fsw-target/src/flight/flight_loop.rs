//! The flight loop: one [`FlightLoop::tick`] per gyro sample, from the sensors to the estimator.
//!
//! Input: the sensors of [`crate::flight::sensors`]. Output: a [`Tick`] that says what happened, and the
//! estimate of the estimator. Generic over all its parts, so that the host flies the same loop as
//! the board. It may be called from the main loop or from the data-ready interrupt's priority.

use crate::flight::sensors::{DataReady, Gyro, TorqueCommand, WheelTachometers};
use fsw_core::outcome::OutcomeCounts;
use fsw_core::{Estimator, Outcome, Sample};

/// The hardware, or what plays its part.
#[derive(Debug, Clone, Copy)]
pub struct Sensors<D, G, S, Q> {
    /// Announces each gyro sample with its time stamp.
    pub data_ready: D,
    /// Body rate.
    pub gyro: G,
    /// Wheel speeds.
    pub wheels: S,
    /// Commanded external torque.
    pub torque: Q,
}

/// What one [`FlightLoop::tick`] did. `G` and `S` are the errors of the gyro and the tachometers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Tick<G, S> {
    /// No sample was ready.
    Idle,
    /// The estimator was stepped.
    Stepped {
        /// Time stamp of the sample, µs.
        time_us: u64,
        /// What became of it.
        outcome: Outcome,
    },
    /// The gyro could not be read; the sample was skipped.
    GyroFailed(G),
    /// A wheel tachometer could not be read; the sample was skipped.
    WheelsFailed(S),
    /// A newer sample came while the gyro was read, so that its time stamp is in doubt; the sample
    /// was skipped for the newer one.
    Overtaken,
}

/// What happened since start-up. The counts stop at their maximum.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// What became of the samples that reached the estimator.
    pub outcomes: OutcomeCounts,
    /// Samples skipped because the gyro could not be read.
    pub gyro_failed: u32,
    /// Samples skipped because a wheel tachometer could not be read.
    pub wheels_failed: u32,
    /// Samples skipped because a newer one came while they were read.
    pub overtaken: u32,
}

/// The flight loop over an estimator `E`, the sensors `D, G, S, Q` and `W` wheels.
#[derive(Debug, Clone, Copy)]
pub struct FlightLoop<E, D, G, S, Q, const W: usize> {
    estimator: E,
    sensors: Sensors<D, G, S, Q>,
    counters: Counters,
}

impl<E, D, G, S, Q, const W: usize> FlightLoop<E, D, G, S, Q, W>
where
    E: Estimator<f32, W>,
    D: DataReady,
    G: Gyro,
    S: WheelTachometers<W>,
    Q: TorqueCommand,
{
    /// A flight loop that has seen no sample yet.
    pub fn new(estimator: E, sensors: Sensors<D, G, S, Q>) -> Self {
        Self { estimator, sensors, counters: Counters::default() }
    }

    /// Handles the next gyro sample, if one is ready.
    ///
    /// A sample whose gyro or tachometers cannot be read is skipped whole: the estimator bridges
    /// the gap from the time stamps, which a made-up value would hide from it.
    pub fn tick(&mut self) -> Tick<G::Error, S::Error> {
        let Some(time_us) = self.sensors.data_ready.take_us() else {
            return Tick::Idle;
        };
        let rate_rad_s = match self.sensors.gyro.rate_rad_s() {
            Ok(rate_rad_s) => rate_rad_s,
            Err(error) => {
                count(&mut self.counters.gyro_failed);
                return Tick::GyroFailed(error);
            }
        };
        if self.sensors.data_ready.has_newer() {
            count(&mut self.counters.overtaken);
            return Tick::Overtaken;
        }
        let wheel_speed_rad_s = match self.sensors.wheels.speed_rad_s() {
            Ok(speed_rad_s) => speed_rad_s,
            Err(error) => {
                count(&mut self.counters.wheels_failed);
                return Tick::WheelsFailed(error);
            }
        };
        let torque_n_m = self.sensors.torque.torque_n_m();

        let attitude = None; // The sensors have none, and the flying estimator needs none.
        let sample = Sample { time_us, rate_rad_s, wheel_speed_rad_s, torque_n_m, attitude };
        let outcome = self.estimator.step(&sample);
        self.counters.outcomes.add(&outcome);
        Tick::Stepped { time_us, outcome }
    }

    /// The estimator, with its estimate.
    pub fn estimator(&self) -> &E {
        &self.estimator
    }

    /// The estimator, to be told what the ground wants.
    pub fn estimator_mut(&mut self) -> &mut E {
        &mut self.estimator
    }

    /// The sensors.
    pub fn sensors(&self) -> &Sensors<D, G, S, Q> {
        &self.sensors
    }

    /// The sensors, to be started anew or told what the ground wants.
    pub fn sensors_mut(&mut self) -> &mut Sensors<D, G, S, Q> {
        &mut self.sensors
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::{Coasting, Vec3};
    use fsw_core::{Estimate, Innovation};

    /// Remembers what it was given.
    #[derive(Default)]
    struct Listener {
        last: Option<Sample<f32, 2>>,
        steps: u32,
    }

    impl Estimator<f32, 2> for Listener {
        fn step(&mut self, sample: &Sample<f32, 2>) -> Outcome {
            self.last = Some(*sample);
            self.steps += 1;
            if sample.is_finite() { Outcome::Updated } else { Outcome::Coasting(Coasting::Spike) }
        }

        fn estimate(&self) -> Estimate<f32> {
            unimplemented!("the loop never asks")
        }

        fn rate_rad_s(&self) -> Vec3<f32> {
            unimplemented!("the loop never asks")
        }

        fn innovation(&self) -> Option<Innovation<f32>> {
            unimplemented!("the loop never asks")
        }
    }

    /// A bench set-up whose parts can be made to fail.
    #[derive(Clone, Copy)]
    struct Bench {
        ready_us: Option<u64>,
        has_newer: bool,
        rate_rad_s: Result<[f32; 3], &'static str>,
        speed_rad_s: Result<[f32; 2], &'static str>,
    }

    const HEALTHY: Bench = Bench {
        ready_us: Some(1_234_567),
        has_newer: false,
        rate_rad_s: Ok([0.1, -0.2, 0.3]),
        speed_rad_s: Ok([400.0, -500.0]),
    };

    impl DataReady for Bench {
        fn take_us(&mut self) -> Option<u64> {
            self.ready_us
        }

        fn has_newer(&mut self) -> bool {
            self.has_newer
        }

        fn forget(&mut self) {
            unimplemented!("the loop never forgets")
        }

        fn overruns(&self) -> u32 {
            0
        }
    }

    impl Gyro for Bench {
        type Error = &'static str;

        fn rate_rad_s(&mut self) -> Result<Vec3<f32>, &'static str> {
            self.rate_rad_s.map(Vec3::from)
        }
    }

    impl WheelTachometers<2> for Bench {
        type Error = &'static str;

        fn speed_rad_s(&mut self) -> Result<[f32; 2], &'static str> {
            self.speed_rad_s
        }
    }

    impl TorqueCommand for Bench {
        fn torque_n_m(&mut self) -> Vec3<f32> {
            Vec3::new(1e-3, 2e-3, -3e-3)
        }

        fn command(&mut self, _: Vec3<f32>) {
            unimplemented!("the loop never commands")
        }
    }

    fn flight(bench: Bench) -> FlightLoop<Listener, Bench, Bench, Bench, Bench, 2> {
        let sensors = Sensors { data_ready: bench, gyro: bench, wheels: bench, torque: bench };
        FlightLoop::new(Listener::default(), sensors)
    }

    #[test]
    fn the_sample_arrives_intact() {
        let mut flight = flight(HEALTHY);
        let stepped = Tick::Stepped { time_us: 1_234_567, outcome: Outcome::Updated };
        assert_eq!(flight.tick(), stepped);
        let sample = Sample {
            time_us: 1_234_567,
            rate_rad_s: Vec3::new(0.1, -0.2, 0.3),
            wheel_speed_rad_s: [400.0, -500.0],
            torque_n_m: Vec3::new(1e-3, 2e-3, -3e-3),
            attitude: None,
        };
        assert_eq!(flight.estimator().last, Some(sample));
        assert_eq!(flight.counters().outcomes.accepted, 1);
    }

    #[test]
    fn without_a_sample_nothing_happens() {
        let mut flight = flight(Bench { ready_us: None, ..HEALTHY });
        assert_eq!(flight.tick(), Tick::Idle);
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters::default());
    }

    #[test]
    fn a_failing_gyro_is_counted_and_its_sample_skipped() {
        let mut flight = flight(Bench { rate_rad_s: Err("bus"), ..HEALTHY });
        assert_eq!(flight.tick(), Tick::GyroFailed("bus"));
        assert_eq!(flight.tick(), Tick::GyroFailed("bus"));
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters { gyro_failed: 2, ..Counters::default() });
    }

    #[test]
    fn a_failing_tachometer_is_counted_and_its_sample_skipped() {
        let mut flight = flight(Bench { speed_rad_s: Err("no edge"), ..HEALTHY });
        assert_eq!(flight.tick(), Tick::WheelsFailed("no edge"));
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters { wheels_failed: 1, ..Counters::default() });
    }

    #[test]
    fn a_reading_that_may_be_of_a_newer_sample_is_not_given_the_older_stamp() {
        let mut flight = flight(Bench { has_newer: true, ..HEALTHY });
        assert_eq!(flight.tick(), Tick::Overtaken);
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters { overtaken: 1, ..Counters::default() });
    }

    #[test]
    fn what_the_estimator_refuses_is_counted_by_its_reason() {
        let mut flight = flight(Bench { rate_rad_s: Ok([f32::NAN, 0.0, 0.0]), ..HEALTHY });
        let outcome = Outcome::Coasting(Coasting::Spike);
        assert_eq!(flight.tick(), Tick::Stepped { time_us: 1_234_567, outcome });
        assert_eq!(flight.counters().outcomes.spike, 1);
    }

    #[test]
    fn a_full_counter_stays_full() {
        let mut counter = u32::MAX;
        count(&mut counter);
        assert_eq!(counter, u32::MAX);
    }
}
