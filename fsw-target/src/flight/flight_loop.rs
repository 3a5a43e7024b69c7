//! The flight loop: one [`FlightLoop::tick`] per gyro sample, from the sensors to the estimator.
//!
//! Input: the sensors of [`crate::flight::sensors`]. Output: a [`Tick`], which is the outcome of one
//! sample, and the state of the estimator. Generic over all its parts: host and board run the same loop.
//! It may be called from the main loop or from an exception.

use crate::flight::sensors::{DataReady, Gyro, TorqueCommand, WheelTachometers};
use crate::flight::wheel_check::WheelCheck;
use fsw_core::monitor::health::HealthMonitor;
use fsw_core::outcome::OutcomeCounts;
use fsw_core::{Estimator, Outcome, Sample, Vec3};

/// Sensors and actuators, or their substitutes.
#[derive(Debug, Clone, Copy)]
pub struct Sensors<D, G, S, Q> {
    /// Time stamps of gyro samples.
    pub data_ready: D,
    /// Body rate.
    pub gyro: G,
    /// Wheel speeds.
    pub wheels: S,
    /// External torque.
    pub torque: Q,
}

/// Outcome of one [`FlightLoop::tick`]. `G` and `S` are the errors of gyro and tachometers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub enum Tick<G, S> {
    /// No sample was pending.
    Idle,
    /// The estimator was stepped.
    Stepped {
        /// Time stamp of the sample, µs.
        time_us: u64,
        /// Outcome of the step.
        outcome: Outcome,
    },
    /// Gyro read error; the estimator received the drive of the sample, if that was read.
    GyroFailed(G),
    /// Tachometer read error; the sample was skipped.
    WheelsFailed(S),
    /// A newer sample arrived during the readings: the time stamp of the rate is ambiguous, or the wheels
    /// are those of the newer sample. The older sample was skipped.
    Overtaken,
}

/// Counts since start-up; each saturates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples with all readings, by the outcome of the estimator.
    pub outcomes: OutcomeCounts,
    /// Samples without a rate after a gyro read error.
    pub gyro_failed: u32,
    /// Samples skipped after a tachometer read error.
    pub wheels_failed: u32,
    /// Samples skipped because a newer one arrived during the read.
    pub overtaken: u32,
}

/// The flight loop of an estimator `E`, the sensors `D, G, S, Q` and `W` wheels.
#[derive(Debug, Clone, Copy)]
pub struct FlightLoop<E, D, G, S, Q, const W: usize> {
    estimator: E,
    sensors: Sensors<D, G, S, Q>,
    counters: Counters,
    health: HealthMonitor,
    /// None: wheels are not judged.
    wheel_check: Option<WheelCheck<W>>,
    readings: Readings<W>,
}

/// Readings of the last tick with a sample; `None` for one that failed or was overtaken.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Readings<const W: usize> {
    /// Body rate, rad/s.
    pub rate_rad_s: Option<Vec3<f32>>,
    /// Wheel speeds, rad/s.
    pub wheel_speed_rad_s: Option<[f32; W]>,
}

impl<E, D, G, S, Q, const W: usize> FlightLoop<E, D, G, S, Q, W>
where
    E: Estimator<f32, W>,
    D: DataReady,
    G: Gyro,
    S: WheelTachometers<W>,
    Q: TorqueCommand,
{
    /// The flight loop before its first sample.
    pub fn new(estimator: E, sensors: Sensors<D, G, S, Q>) -> Self {
        let (counters, health) = (Counters::default(), HealthMonitor::default());
        let readings = Readings::default();
        Self { estimator, sensors, counters, health, wheel_check: None, readings }
    }

    /// Checks the tachometers against the commanded motor torques from the next sample on.
    pub fn check_wheels(&mut self, check: WheelCheck<W>) {
        self.wheel_check = Some(check);
    }

    /// Reads and steps the pending gyro sample, if there is one. Its time is that of the announcement less
    /// the delay of the gyro.
    ///
    /// A sample with a read error of the tachometers is skipped as a whole. The estimator detects the
    /// gap by the time stamps and bridges it, which a substitute value would prevent. With a read error of the gyro the
    /// estimator receives the drive alone: a rate that is not a number, which its gate rejects.
    pub fn tick(&mut self) -> Tick<G::Error, S::Error> {
        let Some(time_us) = self.sensors.data_ready.take_us() else {
            return Tick::Idle;
        };
        self.readings = Readings::default();
        let rate_rad_s = match self.sensors.gyro.rate_rad_s() {
            Ok(rate_rad_s) => rate_rad_s,
            Err(error) => {
                count(&mut self.counters.gyro_failed);
                self.step_without_rate(time_us);
                return Tick::GyroFailed(error);
            }
        };
        self.readings.rate_rad_s = Some(rate_rad_s);
        let wheel_speed_rad_s = match self.sensors.wheels.speed_rad_s() {
            Ok(speed_rad_s) => speed_rad_s,
            Err(error) => {
                count(&mut self.counters.wheels_failed);
                self.wheel_check.iter_mut().for_each(WheelCheck::interrupt);
                return Tick::WheelsFailed(error);
            }
        };
        if self.sensors.data_ready.has_newer() {
            count(&mut self.counters.overtaken);
            self.readings.rate_rad_s = None;
            return Tick::Overtaken;
        }
        self.readings.wheel_speed_rad_s = Some(wheel_speed_rad_s);
        let time_us = time_us.saturating_sub(self.sensors.gyro.delay_us().into());
        let torque_n_m = self.sensors.torque.torque_n_m();
        if let Some(check) = &mut self.wheel_check {
            let motors_n_m = self.sensors.wheels.motor_torque_n_m();
            check.add(time_us, &rate_rad_s, &wheel_speed_rad_s, &motors_n_m);
            self.health.note_wheels(check.follow().contains(&false));
        }

        let attitude = None; // not measured, and not used by an estimator of the roster
        let sample = Sample { time_us, rate_rad_s, wheel_speed_rad_s, torque_n_m, attitude };
        let outcome = self.estimator.step(&sample);
        self.counters.outcomes.add(&outcome);
        self.health.step(&outcome);
        Tick::Stepped { time_us, outcome }
    }

    /// Passes wheel speeds and torque of a sample without a rate to the estimator, if they are read.
    #[inline(never)]
    fn step_without_rate(&mut self, time_us: u64) {
        let Ok(wheel_speed_rad_s) = self.sensors.wheels.speed_rad_s() else { return };
        if self.sensors.data_ready.has_newer() {
            return;
        }
        let time_us = time_us.saturating_sub(self.sensors.gyro.delay_us().into());
        let (rate_rad_s, torque_n_m) = (Vec3::repeat(f32::NAN), self.sensors.torque.torque_n_m());
        let sample = Sample { time_us, rate_rad_s, wheel_speed_rad_s, torque_n_m, attitude: None };
        // The sample is counted as a read error, and by its outcome only where the estimator restarts.
        let outcome = self.estimator.step(&sample);
        if matches!(outcome, Outcome::Reset(_)) {
            self.counters.outcomes.add(&outcome);
            self.health.step(&outcome);
        }
    }

    /// The estimator.
    pub fn estimator(&self) -> &E {
        &self.estimator
    }

    /// The estimator, for telecommands.
    pub fn estimator_mut(&mut self) -> &mut E {
        &mut self.estimator
    }

    /// The estimator and its health, for reports.
    pub fn estimator_and_health(&mut self) -> (&E, &mut HealthMonitor) {
        (&self.estimator, &mut self.health)
    }

    /// Readings of the last tick with a sample.
    pub fn readings(&self) -> &Readings<W> {
        &self.readings
    }

    /// True for each wheel whose speed follows its commanded torque, or is not judged.
    pub fn wheels_follow(&self) -> [bool; W] {
        self.wheel_check.as_ref().map_or([true; W], WheelCheck::follow)
    }

    /// The sensors.
    pub fn sensors(&self) -> &Sensors<D, G, S, Q> {
        &self.sensors
    }

    /// The sensors, for a restart or a telecommand.
    pub fn sensors_mut(&mut self) -> &mut Sensors<D, G, S, Q> {
        &mut self.sensors
    }

    /// Counts since start-up.
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
    use fsw_core::Coasting;
    use fsw_core::{Estimate, Innovation};

    /// Estimator that records its last sample.
    #[derive(Default)]
    struct Recorder {
        last: Option<Sample<f32, 2>>,
        steps: u32,
    }

    impl Estimator<f32, 2> for Recorder {
        fn step(&mut self, sample: &Sample<f32, 2>) -> Outcome {
            self.last = Some(*sample);
            self.steps += 1;
            if sample.is_finite() { Outcome::Updated } else { Outcome::Coasting(Coasting::Spike) }
        }

        fn estimate(&self) -> Estimate<f32> {
            unimplemented!("not called by the loop")
        }

        fn rate_rad_s(&self) -> Vec3<f32> {
            unimplemented!("not called by the loop")
        }

        fn innovation(&self) -> Option<Innovation<f32>> {
            unimplemented!("not called by the loop")
        }
    }

    /// Sensors with constant readings, each of which can fail.
    #[derive(Clone, Copy)]
    struct ConstantSensors {
        ready_us: Option<u64>,
        has_newer: bool,
        rate_rad_s: Result<[f32; 3], &'static str>,
        speed_rad_s: Result<[f32; 2], &'static str>,
    }

    const HEALTHY: ConstantSensors = ConstantSensors {
        ready_us: Some(1_234_567),
        has_newer: false,
        rate_rad_s: Ok([0.1, -0.2, 0.3]),
        speed_rad_s: Ok([400.0, -500.0]),
    };

    impl DataReady for ConstantSensors {
        fn take_us(&mut self) -> Option<u64> {
            self.ready_us
        }

        fn has_newer(&mut self) -> bool {
            self.has_newer
        }

        fn discard(&mut self) {
            unimplemented!("not called by the loop")
        }

        fn overruns(&self) -> u32 {
            0
        }
    }

    impl Gyro for ConstantSensors {
        type Error = &'static str;

        fn rate_rad_s(&mut self) -> Result<Vec3<f32>, &'static str> {
            self.rate_rad_s.map(Vec3::from)
        }
    }

    impl WheelTachometers<2> for ConstantSensors {
        type Error = &'static str;

        fn speed_rad_s(&mut self) -> Result<[f32; 2], &'static str> {
            self.speed_rad_s
        }
    }

    impl TorqueCommand for ConstantSensors {
        fn torque_n_m(&mut self) -> Vec3<f32> {
            Vec3::new(1e-3, 2e-3, -3e-3)
        }

        fn command(&mut self, _: Vec3<f32>) {
            unimplemented!("not called by the loop")
        }
    }

    fn flight(
        sensors: ConstantSensors,
    ) -> FlightLoop<Recorder, ConstantSensors, ConstantSensors, ConstantSensors, ConstantSensors, 2>
    {
        let sensors =
            Sensors { data_ready: sensors, gyro: sensors, wheels: sensors, torque: sensors };
        FlightLoop::new(Recorder::default(), sensors)
    }

    #[test]
    fn the_estimator_receives_all_readings_of_a_sample() {
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
    fn without_a_sample_the_estimator_is_not_stepped() {
        let mut flight = flight(ConstantSensors { ready_us: None, ..HEALTHY });
        assert_eq!(flight.tick(), Tick::Idle);
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters::default());
    }

    #[test]
    fn a_gyro_error_is_counted_and_leaves_the_drive() {
        let mut flight = flight(ConstantSensors { rate_rad_s: Err("bus"), ..HEALTHY });
        assert_eq!(flight.tick(), Tick::GyroFailed("bus"));
        assert_eq!(flight.tick(), Tick::GyroFailed("bus"));
        let last = flight.estimator().last.expect("two steps");
        assert!(last.rate_rad_s.iter().all(|x| x.is_nan()) && last.is_drive_finite());
        assert_eq!((flight.estimator().steps, last.wheel_speed_rad_s), (2, [400.0, -500.0]));
        assert_eq!(flight.counters(), Counters { gyro_failed: 2, ..Counters::default() });
    }

    #[test]
    fn a_sample_without_any_reading_is_skipped() {
        let failed = ConstantSensors { speed_rad_s: Err("no edge"), ..HEALTHY };
        let mut flight = flight(ConstantSensors { rate_rad_s: Err("bus"), ..failed });
        assert_eq!(flight.tick(), Tick::GyroFailed("bus"));
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters { gyro_failed: 1, ..Counters::default() });
    }

    #[test]
    fn a_tachometer_error_is_counted_and_its_sample_skipped() {
        let mut flight = flight(ConstantSensors { speed_rad_s: Err("no edge"), ..HEALTHY });
        assert_eq!(flight.tick(), Tick::WheelsFailed("no edge"));
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters { wheels_failed: 1, ..Counters::default() });
    }

    #[test]
    fn a_reading_with_an_ambiguous_stamp_is_skipped() {
        let mut flight = flight(ConstantSensors { has_newer: true, ..HEALTHY });
        assert_eq!(flight.tick(), Tick::Overtaken);
        assert_eq!(flight.estimator().steps, 0);
        assert_eq!(flight.counters(), Counters { overtaken: 1, ..Counters::default() });
    }

    /// Sensors whose sample is overtaken while a part is read.
    #[derive(Clone)]
    struct Overtaken<'a>(&'a core::cell::Cell<bool>, u32);

    impl DataReady for Overtaken<'_> {
        fn take_us(&mut self) -> Option<u64> {
            Some(1_000_000)
        }

        fn has_newer(&mut self) -> bool {
            self.0.get()
        }

        fn discard(&mut self) {}

        fn overruns(&self) -> u32 {
            0
        }
    }

    impl WheelTachometers<2> for Overtaken<'_> {
        type Error = &'static str;

        fn speed_rad_s(&mut self) -> Result<[f32; 2], &'static str> {
            self.0.set(self.1 == 1);
            Ok([0.0; 2])
        }
    }

    impl Gyro for Overtaken<'_> {
        type Error = &'static str;

        fn rate_rad_s(&mut self) -> Result<Vec3<f32>, &'static str> {
            Ok(Vec3::zeros())
        }

        fn delay_us(&self) -> u32 {
            5_000
        }
    }

    #[test]
    fn sample_that_arrives_while_the_wheels_are_read_is_not_paired_with_the_older_rate() {
        let newer = core::cell::Cell::new(false);
        for (during_wheels, expected) in [
            (1, Tick::Overtaken),
            (0, Tick::Stepped { time_us: 995_000, outcome: Outcome::Updated }),
        ] {
            let part = Overtaken(&newer, during_wheels);
            let (data_ready, gyro, wheels) = (part.clone(), part.clone(), part);
            let sensors = Sensors { data_ready, gyro, wheels, torque: HEALTHY };
            let mut flight = FlightLoop::new(Recorder::default(), sensors);
            assert_eq!(flight.tick(), expected, "stamped before the delay of the gyro");
            newer.set(false);
        }
    }

    /// Samples at 10 Hz, and wheels that stand still under a motor torque.
    #[derive(Default)]
    struct StuckWheels {
        time_us: u64,
        torque_n_m: f32,
    }

    impl DataReady for StuckWheels {
        fn take_us(&mut self) -> Option<u64> {
            self.time_us += 100_000;
            Some(self.time_us)
        }

        fn has_newer(&mut self) -> bool {
            false
        }

        fn discard(&mut self) {}

        fn overruns(&self) -> u32 {
            0
        }
    }

    impl WheelTachometers<2> for StuckWheels {
        type Error = &'static str;

        fn speed_rad_s(&mut self) -> Result<[f32; 2], &'static str> {
            Ok([100.0; 2])
        }

        fn motor_torque_n_m(&mut self) -> [Option<f32>; 2] {
            [None, Some(self.torque_n_m)]
        }
    }

    #[test]
    fn wheel_that_ignores_its_command_is_named_and_degrades_the_health() {
        use crate::flight::wheel_check::Config;
        use fsw_core::monitor::health::{Driver, Health};
        for (torque_n_m, is_wrong) in [(0.0, false), (1e-3, true)] {
            let wheels = StuckWheels { torque_n_m, ..StuckWheels::default() };
            let data_ready = StuckWheels::default();
            let sensors = Sensors { data_ready, gyro: HEALTHY, wheels, torque: HEALTHY };
            let mut flight = FlightLoop::new(Recorder::default(), sensors);
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            flight.check_wheels(WheelCheck::new(Config::default(), &axes, &[2e-5; 2]));
            for _ in 0..10 {
                let _ = flight.tick();
            }
            assert_eq!(flight.wheels_follow(), [true, !is_wrong]);
            let (_, health) = flight.estimator_and_health();
            let expected = (Health::Degraded, Some(Driver::Wheel));
            assert_eq!((health.health(), health.driver()) == expected, is_wrong);
        }
    }

    #[test]
    fn rejected_samples_are_counted_by_reason() {
        let mut flight =
            flight(ConstantSensors { rate_rad_s: Ok([f32::NAN, 0.0, 0.0]), ..HEALTHY });
        let outcome = Outcome::Coasting(Coasting::Spike);
        assert_eq!(flight.tick(), Tick::Stepped { time_us: 1_234_567, outcome });
        assert_eq!(flight.counters().outcomes.spike, 1);
    }

    #[test]
    fn counters_saturate() {
        let mut counter = u32::MAX;
        count(&mut counter);
        assert_eq!(counter, u32::MAX);
    }
}
