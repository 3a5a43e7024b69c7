//! Firmware and host in lockstep without QEMU: the firmware runs on a thread of this process.

use std::io::{Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use embedded_hal_nb::{nb, serial};
use fsw_target::stand_in::tunnel::{self, Message, Port, Tunnel, TunnelError, parts};

use super::compare::After;
use super::firmware::{Firmware, Image};
use super::hardware::START_US;
use super::setup::{self, NotFlown};
use super::*;
use crate::input::Scenario;
use crate::truth::Flight;
use fsw_target::flight::manoeuvre::Manoeuvre;
use fsw_target::flight::selected::EstimatorId;
use fsw_target::link::command::Command;
use target_tools::board::STM32F405;

/// The first 12 s of a CubeSat with four wheels.
fn scenario() -> Scenario {
    let mut scenario = Scenario::load("cubesat-pyramid").unwrap();
    scenario.duration_s = 12.0;
    scenario
}

/// A serial port on a socket.
struct Socket(UnixStream);

impl Socket {
    fn new(stream: UnixStream) -> Self {
        stream.set_nonblocking(true).unwrap();
        Self(stream)
    }
}

impl serial::ErrorType for Socket {
    type Error = serial::ErrorKind;
}

fn or_would_block<T>(done: std::io::Result<T>) -> nb::Result<T, serial::ErrorKind> {
    done.map_err(|error| match error.kind() {
        std::io::ErrorKind::WouldBlock => nb::Error::WouldBlock,
        _ => nb::Error::Other(serial::ErrorKind::Other),
    })
}

impl serial::Read for Socket {
    fn read(&mut self) -> nb::Result<u8, serial::ErrorKind> {
        let mut byte = [0];
        match or_would_block(self.0.read(&mut byte))? {
            0 => Err(nb::Error::Other(serial::ErrorKind::Other)),
            _ => Ok(byte[0]),
        }
    }
}

impl serial::Write for Socket {
    fn write(&mut self, byte: u8) -> nb::Result<(), serial::ErrorKind> {
        or_would_block(self.0.write(&[byte])).map(|_| ())
    }

    fn flush(&mut self) -> nb::Result<(), serial::ErrorKind> {
        Ok(())
    }
}

impl Port for Socket {
    fn listen(&mut self) -> nb::Result<u8, serial::ErrorKind> {
        let read = serial::Read::read(self);
        if read.is_err() {
            thread::yield_now();
        }
        read
    }
}

/// Lines of a firmware on a thread.
struct OnThread {
    sensors: UnixStream,
    link: UnixStream,
}

impl OnThread {
    fn lines() -> (Self, UnixStream, UnixStream) {
        let (sensors, far_sensors) = UnixStream::pair().unwrap();
        let (link, far_link) = UnixStream::pair().unwrap();
        (Self { sensors: far_sensors, link: far_link }, sensors, link)
    }

    /// The loop of `bin/pil`.
    fn fly(self) -> Option<TunnelError> {
        let tunnel = Tunnel::new(Socket::new(self.sensors));
        let setup = tunnel.hello().ok()?;
        let stated = tunnel.hardware().ok()?;
        let mut estimator = Box::new(setup.estimator(&stated).unwrap());
        let mut manoeuvre = Manoeuvre::new(estimator.craft().spin_inertia_kg_m2);
        let link = Socket::new(self.link);
        let mut computer =
            parts::computer(&tunnel, &setup, (&mut estimator, &mut manoeuvre), link, NOT_MEASURED)
                .ok()?;
        computer.start();
        while tunnel.end().is_none() {
            computer.poll();
            tunnel.pause(computer.waiting_bytes() > 0);
        }
        tunnel.end()
    }
}

/// Time limit of a request. A loaded machine needs several seconds.
const PATIENCE: Duration = Duration::from_secs(20);

/// Stack use on a thread, which is not measured.
const NOT_MEASURED: fn() -> u32 = || 0;

/// Starts a firmware that runs `what`.
fn firmware<R: Send + 'static>(
    patience: Duration,
    what: impl FnOnce(OnThread) -> R + Send + 'static,
) -> (Firmware, JoinHandle<R>) {
    let (far, sensors, link) = OnThread::lines();
    let thread = thread::spawn(move || what(far));
    (Firmware::on(sensors, link, patience, None).unwrap(), thread)
}

fn mission<'a>(scenario: &'a Scenario, flight: &'a Flight, estimator: EstimatorId) -> Mission<'a> {
    Mission {
        scenario,
        flight,
        seed: 3,
        estimator,
        restart_at: None,
        commands: &[],
        answering: None,
    }
}

fn fly_on_threads(
    mission: &Mission<'_>,
    broken: Option<BrokenBit>,
) -> Result<PilFlight, PilFailed> {
    fly(mission, || Ok(firmware(PATIENCE, OnThread::fly).0), broken, |_, _| ())
}

#[test]
fn tunnel_and_direct_connection_give_the_same_flight() {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    let flown = fly_on_threads(&mission(&scenario, &flight, EstimatorId::JointEkf), None).unwrap();
    assert_eq!(flown.compared, 121);
    // The tachometers need three readings before the first speed.
    assert_eq!((flown.outcomes.accepted, flown.wheel_failures, flown.gyro_failures), (118, 3, 0));
    assert_eq!(flown.wheel_doubts, 0);
    assert_eq!(flown.estimator.selected(), EstimatorId::JointEkf);
}

#[test]
fn bit_error_is_detected_at_its_sample() {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    let mission = mission(&scenario, &flight, EstimatorId::JointEkf);
    let broken = BrokenBit { sample: 50, byte: 2, bit: 0 };
    match fly_on_threads(&mission, Some(broken)) {
        Err(PilFailed::Differs(difference)) => {
            assert_eq!(difference.when, After::Sample(50));
            assert!(difference.element.starts_with("estimate "), "{difference}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn power_cut_loses_only_the_start_of_the_tachometers() {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    for estimator in [EstimatorId::Window, EstimatorId::JointEkf] {
        let mission = Mission { restart_at: Some(60), ..mission(&scenario, &flight, estimator) };
        let flown = fly_on_threads(&mission, None).unwrap();
        assert_eq!((flown.compared, flown.wheel_failures), (121, 6));
        assert_eq!((flown.outcomes.accepted, flown.outcomes.gap_resets), (115, 0));
        assert_eq!(flown.estimator.selected(), estimator);
    }
}

#[test]
fn power_cut_without_wheels_changes_no_bit() {
    let mut scenario = Scenario::load("stsat3-spin-up").unwrap();
    scenario.duration_s = 30.0;
    let flight = Flight::simulate(&scenario).unwrap();
    let whole = mission(&scenario, &flight, EstimatorId::JointEkf);
    let cut = Mission { restart_at: Some(123), ..whole };
    let [whole, cut] = [whole, cut].map(|mission| fly_on_threads(&mission, None).unwrap());
    let bits = |flown: &PilFlight| {
        use fsw_core::Estimator;
        let estimate = flown.estimator.estimate();
        (estimate.inertia, estimate.covariance_kg2_m4, flown.estimator.rate_rad_s())
    };
    assert_eq!(bits(&whole), bits(&cut));
    assert_eq!(whole.outcomes, cut.outcomes);
}

/// Error of a flight with a firmware that runs `what`.
fn fly_with<R: Send + 'static>(
    patience: Duration,
    what: impl FnOnce(OnThread) -> R + Send + 'static,
) -> String {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    let mission = mission(&scenario, &flight, EstimatorId::JointEkf);
    let (firmware, _thread) = firmware(patience, what);
    let mut firmware = Some(firmware);
    fly(&mission, || Ok(firmware.take().unwrap()), None, |_, _| ()).unwrap_err().to_string()
}

#[test]
fn silent_firmware_is_an_error_after_the_time_limit() {
    let short = Duration::from_millis(200);
    let error = fly_with(short, |lines| {
        thread::sleep(Duration::from_secs(2));
        drop(lines);
    });
    assert!(error.starts_with("no request from the firmware for "), "{error}");
    assert!(
        error.ends_with("before its first request: is the image a pil of this version?"),
        "{error}"
    );
}

#[test]
fn error_of_a_firmware_that_stops_has_the_number_of_samples() {
    let error = fly_with(PATIENCE, |lines| {
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        let setup = tunnel.hello().unwrap();
        let stated = tunnel.hardware().unwrap();
        let mut estimator = Box::new(setup.estimator(&stated).unwrap());
        let mut manoeuvre = Manoeuvre::new(estimator.craft().spin_inertia_kg_m2);
        let mut computer = parts::computer(
            &tunnel,
            &setup,
            (&mut estimator, &mut manoeuvre),
            Socket::new(lines.link),
            NOT_MEASURED,
        )
        .unwrap();
        computer.start();
        while computer.estimator().selected() != EstimatorId::JointEkf
            || tunnel.now_us() < START_US + 2_000_000
        {
            computer.poll();
        }
    });
    assert_eq!(error, "the connection to the firmware is closed (QEMU stopped), after 20 samples");
}

#[test]
fn restart_of_the_firmware_in_flight_is_an_error() {
    let error = fly_with(PATIENCE, |lines| {
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        tunnel.hello().unwrap();
        let _ = tunnel.hello();
        lines.link
    });
    let expected = "the firmware restarted during the flight: it failed, before the first sample";
    assert_eq!(error, expected);
}

#[test]
fn abort_of_the_firmware_is_an_error_with_its_reason() {
    let error = fly_with(PATIENCE, |lines| {
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        tunnel.hello().unwrap();
        tunnel.report_failure("the estimator rejects the craft").unwrap();
        lines.link
    });
    assert!(error.starts_with("the firmware aborted: the estimator rejects the craft"), "{error}");
}

#[test]
fn firmware_of_another_version_is_rejected() {
    let error = fly_with(PATIENCE, |mut lines| {
        let hello = Message::new(tunnel::HELLO, |fields| fields.put(&[tunnel::VERSION + 1]));
        lines.sensors.write_all(hello.frame().unwrap().bytes()).unwrap();
        lines
    });
    let ours = tunnel::VERSION;
    let expected = format!(
        "the firmware has version {} of the sensor tunnel, this program version {ours}",
        ours + 1
    );
    assert_eq!(error, expected);
}

#[test]
fn firmware_of_another_build_is_rejected() {
    let error = fly_with(PATIENCE, |mut lines| {
        let hello = Message::new(tunnel::HELLO, |fields| {
            fields.put(&[tunnel::VERSION]);
            fields.put(&(tunnel::SOURCES ^ 1).to_be_bytes());
        });
        lines.sensors.write_all(hello.frame().unwrap().bytes()).unwrap();
        lines
    });
    let expected = "the image was built from other sources than this program: rebuild both";
    assert_eq!(error, expected);
}

/// Telecommands during a flight, the dump of a checkpoint included.
#[test]
fn telecommands_have_the_same_effect_on_firmware_and_host() {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    let commands = [
        (20, Command::SaveCheckpoint),
        (30, Command::DumpCheckpoint),
        (40, Command::CloseWindow),
        (50, Command::OpenWindow),
        (60, Command::Select(EstimatorId::JointEkf)),
        (70, Command::SaveCheckpoint),
        (80, Command::Reset),
    ];
    let mission =
        Mission { commands: &commands, ..mission(&scenario, &flight, EstimatorId::Window) };
    let flown = fly_on_threads(&mission, None).unwrap();
    assert_eq!((flown.compared, flown.estimator.selected()), (121, EstimatorId::JointEkf));
}

/// Uploaded, flown to its end, aborted in each way: the wheels answer, and return to their speeds at the start.
#[test]
fn manoeuvre_ends_with_the_wheels_at_their_speeds_of_the_start() {
    let mut scenario = scenario();
    scenario.duration_s = 9.0;
    let flight = Flight::simulate(&scenario).unwrap();
    for case in manoeuvre::Case::all() {
        let commands = case.commands();
        let mission = Mission {
            commands: &commands,
            answering: Some(case.answering),
            restart_at: case.restart_at,
            ..mission(&scenario, &flight, EstimatorId::Window)
        };
        let mut reached = manoeuvre::Reached::default();
        let start = || Ok(firmware(PATIENCE, OnThread::fly).0);
        let flown = fly(&mission, start, None, |software, telemetry| {
            reached.add(software, telemetry);
        });
        assert_eq!(flown.unwrap().compared, 91, "{}", case.name);
        println!("{}: {reached:?}", case.name);
        reached.check(&case).unwrap();
    }
}

#[test]
fn missing_telemetry_is_an_error_after_the_time_limit() {
    let error = fly_with(Duration::from_millis(300), |lines| {
        // Requests samples and sends no telemetry.
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        let setup = tunnel.hello().unwrap();
        let stated = tunnel.hardware().unwrap();
        let mut estimator = Box::new(setup.estimator(&stated).unwrap());
        let mut manoeuvre = Manoeuvre::new(estimator.craft().spin_inertia_kg_m2);
        let (mute, _other_end) = UnixStream::pair().unwrap();
        let mut computer = parts::computer(
            &tunnel,
            &setup,
            (&mut estimator, &mut manoeuvre),
            Socket::new(mute),
            NOT_MEASURED,
        )
        .unwrap();
        computer.start();
        while tunnel.end().is_none() {
            computer.poll();
        }
        lines.link
    });
    assert!(error.starts_with("expected telemetry did not arrive"), "{error}");
}

#[test]
fn mission_that_the_image_cannot_fly_is_rejected_before_the_start() {
    let mut five = scenario();
    five.wheels.push(five.wheels[0].clone());
    let flight = Flight::simulate(&five).unwrap();
    let error = |mission: &Mission<'_>| setup::of(mission).unwrap_err();
    let too_many = mission(&five, &flight, EstimatorId::Window);
    assert_eq!(error(&too_many), NotFlown::TooManyWheels { found: 5 });
    let four = scenario();
    let without_prior = mission(&four, &flight, EstimatorId::EkfSgfRls);
    assert_eq!(error(&without_prior), NotFlown::NoNominalInertia);
    for at in [0, 121, 1000] {
        let cut = mission(&four, &flight, EstimatorId::Window);
        let cut = Mission { restart_at: Some(at), ..cut };
        assert_eq!(error(&cut), NotFlown::NoSuchSample { at, samples: 121 });
    }
}

#[test]
fn missing_image_file_is_an_error() {
    let image = Image::find(&STM32F405, Some(Path::new("no/such/image").into())).unwrap();
    let error = image.start().err().map(|error| error.to_string());
    assert_eq!(error.as_deref(), Some("no/such/image: no such image"));
}
