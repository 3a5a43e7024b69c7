//! The whole way but the processor: the firmware's end of the tunnel runs on a thread of this process.

use std::io::{Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use embedded_hal_nb::{nb, serial};
use fsw_target::stand_in::tunnel::{self, Message, Port, Tunnel, TunnelError, parts};

use super::*;

/// A minute of a CubeSat with four wheels, as far as a test needs it.
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

/// A firmware on a thread: what `bin/pil` does. It may give up after some samples.
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

    /// As `bin/pil` flies.
    fn fly(self) -> Option<TunnelError> {
        let tunnel = Tunnel::new(Socket::new(self.sensors));
        let setup = tunnel.hello().ok()?;
        let mut onboard = Box::new(setup.estimator().unwrap());
        let link = Socket::new(self.link);
        let mut computer =
            parts::computer(&tunnel, &setup, &mut onboard, link, NOT_MEASURED).ok()?;
        computer.start();
        while tunnel.end().is_none() {
            computer.poll();
            tunnel.pause(computer.waiting_bytes() > 0);
        }
        tunnel.end()
    }
}

const PATIENCE: Duration = Duration::from_secs(20);

/// A thread's stack isn't painted.
const NOT_MEASURED: fn() -> u32 = || 0;

/// Starts a firmware that does `what`.
fn firmware<R: Send + 'static>(
    patience: Duration,
    what: impl FnOnce(OnThread) -> R + Send + 'static,
) -> (Firmware, JoinHandle<R>) {
    let (far, sensors, link) = OnThread::lines();
    let thread = thread::spawn(move || what(far));
    (Firmware::on(sensors, link, patience, None).unwrap(), thread)
}

fn mission<'a>(scenario: &'a Scenario, flight: &'a Flight, estimator: EstimatorId) -> Mission<'a> {
    Mission { scenario, flight, seed: 3, estimator, restart_at: None, commands: &[] }
}

fn fly_on_threads(mission: &Mission<'_>, broken: Option<BrokenBit>) -> Result<Flown, PilFailed> {
    fly(mission, || Ok(firmware(PATIENCE, OnThread::fly).0), broken, |_, _| ())
}

#[test]
fn through_the_tunnel_and_beside_it_the_same_flight_comes_out() {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    let flown = fly_on_threads(&mission(&scenario, &flight, EstimatorId::JointEkf), None).unwrap();
    assert_eq!(flown.compared, 121);
    // Until the tachometers have seen three readings there are no wheel speeds.
    assert_eq!((flown.outcomes.accepted, flown.wheel_failures, flown.gyro_failures), (118, 3, 0));
    assert_eq!(flown.onboard.selected(), EstimatorId::JointEkf);
}

#[test]
fn a_broken_bit_is_found_at_its_sample() {
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
fn a_power_cut_costs_only_what_the_tachometers_need_to_start() {
    let scenario = scenario();
    let flight = Flight::simulate(&scenario).unwrap();
    for estimator in [EstimatorId::Window, EstimatorId::JointEkf] {
        let mission = Mission { restart_at: Some(60), ..mission(&scenario, &flight, estimator) };
        let flown = fly_on_threads(&mission, None).unwrap();
        assert_eq!((flown.compared, flown.wheel_failures), (121, 6));
        assert_eq!((flown.outcomes.accepted, flown.outcomes.gap_resets), (115, 0));
        assert_eq!(flown.onboard.selected(), estimator);
    }
}

#[test]
fn without_wheels_a_power_cut_changes_no_bit() {
    let mut scenario = Scenario::load("stsat3-spin-up").unwrap();
    scenario.duration_s = 30.0;
    let flight = Flight::simulate(&scenario).unwrap();
    let whole = mission(&scenario, &flight, EstimatorId::JointEkf);
    let cut = Mission { restart_at: Some(123), ..whole };
    let [whole, cut] = [whole, cut].map(|mission| fly_on_threads(&mission, None).unwrap());
    let bits = |flown: &Flown| {
        use fsw_core::Estimator;
        let estimate = flown.onboard.estimate();
        (estimate.inertia, estimate.covariance_kg2_m4, flown.onboard.rate_rad_s())
    };
    assert_eq!(bits(&whole), bits(&cut));
    assert_eq!(whole.outcomes, cut.outcomes);
}

/// What comes of a firmware that does this.
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
fn a_firmware_that_is_silent_is_given_up() {
    let short = Duration::from_millis(200);
    let error = fly_with(short, |lines| {
        thread::sleep(Duration::from_secs(2));
        drop(lines);
    });
    assert!(error.starts_with("the firmware has been silent for "), "{error}");
    assert!(
        error.ends_with("before it said hello: is the image a pil of this version?"),
        "{error}"
    );
}

#[test]
fn a_firmware_that_stops_in_flight_says_where() {
    let error = fly_with(PATIENCE, |lines| {
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        let setup = tunnel.hello().unwrap();
        let mut onboard = Box::new(setup.estimator().unwrap());
        let mut computer =
            parts::computer(&tunnel, &setup, &mut onboard, Socket::new(lines.link), NOT_MEASURED)
                .unwrap();
        computer.start();
        while computer.estimator().selected() != EstimatorId::JointEkf
            || tunnel.now_us() < 2_000_000
        {
            computer.poll();
        }
    });
    assert_eq!(error, "the firmware's line has ended (QEMU stopped), after 20 samples");
}

#[test]
fn a_firmware_that_restarts_by_itself_is_noticed() {
    let error = fly_with(PATIENCE, |lines| {
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        tunnel.hello().unwrap();
        let _ = tunnel.hello();
        lines.link
    });
    let expected =
        "the firmware has restarted by itself: something failed in it, before the first sample";
    assert_eq!(error, expected);
}

#[test]
fn a_firmware_that_gives_up_says_why() {
    let error = fly_with(PATIENCE, |lines| {
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        tunnel.hello().unwrap();
        tunnel.report_failure("the estimator rejects the craft").unwrap();
        lines.link
    });
    assert!(error.starts_with("the firmware gave up: the estimator rejects the craft"), "{error}");
}

#[test]
fn a_firmware_of_another_version_is_told_apart() {
    let error = fly_with(PATIENCE, |mut lines| {
        let hello = Message::new(tunnel::HELLO, |fields| fields.put(&[tunnel::VERSION + 1]));
        lines.sensors.write_all(hello.frame().unwrap().bytes()).unwrap();
        lines
    });
    let expected = "the firmware speaks version 3 of the sensor tunnel, this program 2";
    assert_eq!(error, expected);
}

#[test]
fn a_firmware_of_other_sources_is_refused_before_it_flies() {
    let error = fly_with(PATIENCE, |mut lines| {
        let hello = Message::new(tunnel::HELLO, |fields| {
            fields.put(&[tunnel::VERSION]);
            fields.put(&(tunnel::SOURCES ^ 1).to_be_bytes());
        });
        lines.sensors.write_all(hello.frame().unwrap().bytes()).unwrap();
        lines
    });
    let expected = "the image was built from other sources than this program: build both anew";
    assert_eq!(error, expected);
}

/// What the ground may ask for in the midst of a flight, a checkpoint sent to it among it.
#[test]
fn commands_in_flight_do_the_same_at_both_ends() {
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
    assert_eq!((flown.compared, flown.onboard.selected()), (121, EstimatorId::JointEkf));
}

#[test]
fn telemetry_that_never_comes_is_not_waited_for_without_end() {
    let error = fly_with(Duration::from_millis(300), |lines| {
        // Asks for samples again and again, and tells the ground nothing.
        let tunnel = Tunnel::new(Socket::new(lines.sensors));
        let setup = tunnel.hello().unwrap();
        let mut onboard = Box::new(setup.estimator().unwrap());
        let (mute, _other_end) = UnixStream::pair().unwrap();
        let mut computer =
            parts::computer(&tunnel, &setup, &mut onboard, Socket::new(mute), NOT_MEASURED)
                .unwrap();
        computer.start();
        while tunnel.end().is_none() {
            computer.poll();
        }
        lines.link
    });
    assert!(error.starts_with("the firmware owes telemetry"), "{error}");
}

#[test]
fn what_the_image_has_no_room_for_is_refused_before_anything_starts() {
    let mut five = scenario();
    five.wheels.push(five.wheels[0].clone());
    let flight = Flight::simulate(&five).unwrap();
    let refused = |mission: &Mission<'_>| setup::of(mission).unwrap_err();
    let too_many = mission(&five, &flight, EstimatorId::Window);
    assert_eq!(refused(&too_many), NotFlown::TooManyWheels { found: 5 });
    let four = scenario();
    let without_prior = mission(&four, &flight, EstimatorId::EkfSgfRls);
    assert_eq!(refused(&without_prior), NotFlown::NoNominalInertia);
    for at in [0, 121, 1000] {
        let cut = mission(&four, &flight, EstimatorId::Window);
        let cut = Mission { restart_at: Some(at), ..cut };
        assert_eq!(refused(&cut), NotFlown::NoSuchSample { at, samples: 121 });
    }
}

#[test]
fn a_file_that_is_no_image_is_said_so() {
    let image = firmware::Image::find(Some(Path::new("no/such/image").into())).unwrap();
    let error = image.start().err().map(|error| error.to_string());
    assert_eq!(error.as_deref(), Some("no/such/image: there is no such image"));
}
