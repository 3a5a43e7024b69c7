//! The driver on wheels with a known motion.

extern crate std;

use super::*;
use core::f64::consts::TAU;

/// Edges per turn: twelve pulses.
const EDGES: u16 = 24;
const STEP_RAD: f64 = TAU / EDGES as f64;
const TICKS_PER_S: u32 = 1_000_000;
const ZERO_AFTER_S: f32 = 0.5;
/// Motor torque over spin inertia, with margin.
const LARGEST_RAD_S2: f32 = 300.0;
/// Sample interval, s.
const SAMPLE_S: f64 = 0.1;

/// A wheel of constant acceleration.
#[derive(Clone, Copy)]
struct Wheel {
    speed_rad_s: f64,
    slope_rad_s2: f64,
}

impl Wheel {
    fn speed_rad_s(&self, time_s: f64) -> f64 {
        self.speed_rad_s + self.slope_rad_s2 * time_s
    }

    /// Angle in units of the angle between edges; starts halfway between two.
    fn angle(&self, time_s: f64) -> f64 {
        0.5 + (self.speed_rad_s + 0.5 * self.slope_rad_s2 * time_s) * time_s / STEP_RAD
    }

    /// Edges between two times, in order: time, and the levels of A and B just after it.
    fn edges(&self, from_s: f64, to_s: f64) -> std::vec::Vec<(f64, bool, bool)> {
        const SLICES: u32 = 10_000;
        let slice_s = (to_s - from_s) / f64::from(SLICES);
        let mut edges = std::vec::Vec::new();
        for slice in 0..SLICES {
            let (mut before_s, mut after_s) =
                (from_s + slice_s * f64::from(slice), from_s + slice_s * f64::from(slice + 1));
            let (from, to) = (self.angle(before_s).floor(), self.angle(after_s).floor());
            if from == to {
                continue;
            }
            for _ in 0..40 {
                let middle_s = 0.5 * (before_s + after_s);
                if self.angle(middle_s).floor() == from {
                    before_s = middle_s;
                } else {
                    after_s = middle_s;
                }
            }
            let a = to.rem_euclid(2.0) == 1.0;
            edges.push((after_s, a, a != (to > from)));
        }
        edges
    }
}

fn ticks(time_s: f64) -> u32 {
    (time_s * f64::from(TICKS_PER_S)) as u64 as u32
}

/// A board with one wheel, read at a fixed rate; its timer starts at `offset_s`.
struct Board {
    wheel: Wheel,
    filter: EdgeFilter,
    time_s: f64,
    offset_s: f64,
}

impl Board {
    fn new(speed_rad_s: f64, slope_rad_s2: f64) -> Self {
        let wheel = Wheel { speed_rad_s, slope_rad_s2 };
        Self { wheel, filter: EdgeFilter::new(100), time_s: 0.0, offset_s: 0.0 }
    }
}

impl CaptureTimer<1> for Board {
    type Error = &'static str;

    fn ticks_per_s(&self) -> u32 {
        TICKS_PER_S
    }

    /// The next reading, [`SAMPLE_S`] after the last.
    fn captured(&mut self) -> Result<[Captured; 1], Self::Error> {
        let to_s = self.time_s + SAMPLE_S;
        for (time_s, a, b) in self.wheel.edges(self.time_s, to_s) {
            self.filter.edge(ticks(self.offset_s + time_s), a, b);
        }
        self.time_s = to_s;
        Ok([self.filter.captured(ticks(self.offset_s + to_s))])
    }
}

fn config() -> Config<1> {
    Config {
        edges_per_turn: [EDGES],
        reversed: [false],
        zero_after_s: ZERO_AFTER_S,
        largest_acceleration_rad_s2: LARGEST_RAD_S2,
        delay_us: 0,
    }
}

fn tach(board: Board) -> WheelTach<Board, 1> {
    WheelTach::new(board, &config()).unwrap()
}

/// Largest and RMS error of the valid readings, rad/s.
fn errors_rad_s(tach: &mut WheelTach<Board, 1>, readings: u32) -> (f64, f64) {
    let (mut largest, mut squares, mut count) = (0.0f64, 0.0, 0);
    for _ in 0..readings {
        let Ok([speed]) = tach.speed_rad_s() else { continue };
        let board = tach.timer();
        let error = f64::from(speed) - board.wheel.speed_rad_s(board.time_s);
        largest = largest.max(error.abs());
        squares += error * error;
        count += 1;
    }
    assert!(count + 15 > readings, "{count} of {readings} readings");
    (largest, (squares / f64::from(count)).sqrt())
}

#[test]
fn fast_wheel_is_accurate_to_the_tick() {
    for speed_rad_s in [628.0, -628.0, 100.3] {
        let (largest, rms) = errors_rad_s(&mut tach(Board::new(speed_rad_s, 0.0)), 100);
        let tick = speed_rad_s.abs() / (f64::from(TICKS_PER_S) * SAMPLE_S);
        // An interval between edges is up to one edge shorter than a sample: 2.7 % at 100 rad/s.
        assert!(largest < 1.05 * 3.4 * tick, "{speed_rad_s}: {largest} rad/s");
        assert!(rms < 1.15 * 1.1 * tick, "{speed_rad_s}: {rms} rad/s RMS");
    }
}

#[test]
fn accelerating_wheel_has_no_delay() {
    // 20 mN m on a wheel of 4e-4 kg m².
    let slope_rad_s2 = 50.0;
    let (largest, _) = errors_rad_s(&mut tach(Board::new(200.0, slope_rad_s2)), 80);
    // The mean over the last interval lags by 50 ms: 2.5 rad/s.
    assert!(largest < 0.02, "{largest} rad/s");
}

#[test]
fn speed_is_continuous_through_zero() {
    // From 20 to −20 rad/s; the last edge before zero is up to 0.23 s old at the next edge.
    let mut tach = tach(Board::new(20.0, -10.0));
    let (largest, rms) = errors_rad_s(&mut tach, 40);
    assert!(rms < 0.15 && largest < 0.6, "{largest} rad/s, {rms} rad/s RMS");
    // Several edges per sample again: full accuracy.
    let (largest, _) = errors_rad_s(&mut tach, 20);
    assert!(largest < 0.01, "{largest} rad/s");
}

#[test]
fn slow_wheel_is_measured_down_to_one_edge_per_time_out() {
    let slowest_rad_s = STEP_RAD / f64::from(ZERO_AFTER_S);
    let (largest, _) = errors_rad_s(&mut tach(Board::new(1.05 * slowest_rad_s, 0.0)), 200);
    assert!(largest < 1e-4, "{largest} rad/s");
    // At half the slowest speed: zero between edges.
    let mut tach = tach(Board::new(0.5 * slowest_rad_s, 0.0));
    let mut speeds = (0..100).filter_map(|_| tach.speed_rad_s().ok());
    assert!(speeds.any(|[speed]| speed == 0.0));
}

#[test]
fn speed_of_a_stopped_wheel_falls_to_zero_within_the_time_out() {
    let config = Config { largest_acceleration_rad_s2: f32::INFINITY, ..config() };
    let mut tach = WheelTach::new(Board::new(30.0, 0.0), &config).unwrap();
    for _ in 0..10 {
        let _ = tach.speed_rad_s();
    }
    // The wheel locks at once.
    let stopped_s = tach.timer().time_s;
    let wheel = Wheel { speed_rad_s: 0.0, slope_rad_s2: 0.0 };
    tach.timer().wheel = wheel;
    let mut bound = 30.1f64;
    loop {
        let [speed] = tach.speed_rad_s().unwrap();
        let since_s = tach.timer().time_s - stopped_s;
        bound = bound.min(STEP_RAD / since_s);
        assert!(f64::from(speed) <= 1.26 * bound, "{since_s} s: {speed} rad/s");
        if speed == 0.0 {
            // The readings are a tenth of a second apart.
            assert!((since_s - f64::from(ZERO_AFTER_S)).abs() < 0.11, "{since_s} s");
            break;
        }
        assert!(since_s < 1.0);
    }
}

#[test]
fn wheel_that_leaves_rest_is_measured_from_its_first_edges() {
    let mut tach = tach(Board::new(0.0, 0.0));
    while tach.speed_rad_s().is_err() {}
    assert_eq!(tach.speed_rad_s(), Ok([0.0]));
    let offset_s = tach.timer().time_s;
    *tach.timer() = Board { offset_s, filter: tach.timer().filter, ..Board::new(0.0, 100.0) };
    let [speed] = tach.speed_rad_s().unwrap();
    assert!((speed - 10.0).abs() < 2.0, "{speed} rad/s");
    // The start is uncertain by half an edge; two thirds of it enter the next speed.
    let [speed] = tach.speed_rad_s().unwrap();
    assert!((speed - 20.0).abs() < 2.0, "{speed} rad/s");
    tach.speed_rad_s().unwrap();
    let [speed] = tach.speed_rad_s().unwrap();
    assert!((speed - 40.0).abs() < 0.01, "{speed} rad/s");
}

#[test]
fn speed_is_missing_until_it_is_known() {
    let mut spinning = tach(Board::new(100.0, 0.0));
    for _ in 0..3 {
        assert_eq!(spinning.speed_rad_s(), Err(Error::Starting { wheel: 0 }));
    }
    assert!(spinning.speed_rad_s().is_ok());

    // A wheel at rest counts as standing after the time-out.
    let mut standing = tach(Board::new(0.0, 0.0));
    for _ in 0..5 {
        assert_eq!(standing.speed_rad_s(), Err(Error::Starting { wheel: 0 }));
    }
    assert_eq!(standing.speed_rad_s(), Ok([0.0]));
}

#[test]
fn timer_may_wrap() {
    let wrap_s = 2.0f64.powi(32) / f64::from(TICKS_PER_S);
    let board = Board { offset_s: wrap_s - 2.05, ..Board::new(200.0, 50.0) };
    let (largest, _) = errors_rad_s(&mut tach(board), 40);
    assert!(largest < 0.02, "{largest} rad/s");
    // A wheel stays standing beyond the timer's range.
    let mut tach = tach(Board::new(0.0, 0.0));
    for _ in 0..6 {
        let _ = tach.speed_rad_s();
    }
    for _ in 0..10 {
        tach.timer().offset_s += 0.3 * wrap_s;
        assert_eq!(tach.speed_rad_s(), Ok([0.0]));
    }
}

#[test]
fn instant_may_precede_the_last_edge() {
    /// Reads 20 ms after the requested instant.
    struct Late(Board);
    impl CaptureTimer<1> for Late {
        type Error = &'static str;
        fn ticks_per_s(&self) -> u32 {
            TICKS_PER_S
        }
        fn captured(&mut self) -> Result<[Captured; 1], Self::Error> {
            let [captured] = self.0.captured()?;
            Ok([Captured { now_ticks: captured.now_ticks - 20_000, ..captured }])
        }
    }
    let mut tach = WheelTach::new(Late(Board::new(200.0, 50.0)), &config()).unwrap();
    for _ in 0..20 {
        let Ok([speed]) = tach.speed_rad_s() else { continue };
        let Late(board) = tach.timer();
        let expected = board.wheel.speed_rad_s(board.time_s - 0.02);
        assert!((f64::from(speed) - expected).abs() < 0.02, "{speed} rad/s");
    }
}

#[test]
fn reversed_mounting_reverses_the_sign() {
    let config = Config { reversed: [true], ..config() };
    let mut tach = WheelTach::new(Board::new(100.0, 20.0), &config).unwrap();
    for _ in 0..5 {
        let _ = tach.speed_rad_s();
    }
    let [speed] = tach.speed_rad_s().unwrap();
    assert!((speed + 112.0).abs() < 0.01, "{speed} rad/s");
}

#[test]
fn place_without_a_wheel_has_zero_speed() {
    let config = Config { edges_per_turn: [0], ..config() };
    let mut tach = WheelTach::new(Board::new(100.0, 0.0), &config).unwrap();
    assert_eq!(tach.speed_rad_s(), Ok([0.0]));
}

#[test]
fn timer_error_passes_through() {
    struct Broken;
    impl CaptureTimer<2> for Broken {
        type Error = &'static str;
        fn ticks_per_s(&self) -> u32 {
            TICKS_PER_S
        }
        fn captured(&mut self) -> Result<[Captured; 2], Self::Error> {
            Err("overcapture")
        }
    }
    let config = Config {
        edges_per_turn: [EDGES; 2],
        reversed: [false; 2],
        zero_after_s: 1.0,
        largest_acceleration_rad_s2: LARGEST_RAD_S2,
        delay_us: 0,
    };
    let mut tach = WheelTach::new(Broken, &config).unwrap();
    assert_eq!(tach.speed_rad_s(), Err(Error::Timer("overcapture")));
}

/// A board that loses edges for two seconds, as during a flash erase.
struct Stalled {
    board: Board,
    failing: bool,
}

impl CaptureTimer<1> for Stalled {
    type Error = &'static str;

    fn ticks_per_s(&self) -> u32 {
        TICKS_PER_S
    }

    fn captured(&mut self) -> Result<[Captured; 1], Self::Error> {
        if self.failing {
            self.board.time_s += 2.0;
            self.board.filter = EdgeFilter::new(100);
            return Err("lost edges");
        }
        self.board.captured()
    }
}

#[test]
fn lost_edges_give_no_speed() {
    let speed_rad_s = 400.0;
    let stalled = Stalled { board: Board::new(speed_rad_s, 0.0), failing: false };
    let mut tach = WheelTach::new(stalled, &config()).unwrap();
    let mut readings = 0;
    for reading in 0..30 {
        tach.timer().failing = reading == 10;
        let Ok([speed]) = tach.speed_rad_s() else { continue };
        assert!((f64::from(speed) - speed_rad_s).abs() < 0.1, "{speed} rad/s in {reading}");
        readings += 1;
    }
    assert!(readings > 20, "{readings}");
}

#[test]
fn invalid_configuration_is_rejected() {
    let refused = |config: Config<1>| WheelTach::new(Board::new(0.0, 0.0), &config).err();
    for zero_after_s in [0.0, -1.0, f32::NAN, 2200.0] {
        let config = Config { zero_after_s, ..config() };
        assert_eq!(refused(config), Some(ConfigError::ZeroAfter));
    }
    for largest_acceleration_rad_s2 in [0.0, -1.0, f32::NAN] {
        let config = Config { largest_acceleration_rad_s2, ..config() };
        assert_eq!(refused(config), Some(ConfigError::LargestAcceleration));
    }
}

/// A board whose Hall line dies at a time: no edge any more.
struct DeadLine {
    board: Board,
    dies_at_s: f64,
}

impl CaptureTimer<1> for DeadLine {
    type Error = &'static str;

    fn ticks_per_s(&self) -> u32 {
        TICKS_PER_S
    }

    fn captured(&mut self) -> Result<[Captured; 1], Self::Error> {
        let filter = self.board.filter;
        let captured = self.board.captured();
        if self.board.time_s > self.dies_at_s {
            self.board.filter = filter;
            return Ok([filter.captured(ticks(self.board.time_s))]);
        }
        captured
    }
}

#[test]
fn dead_line_is_an_error_and_not_a_standing_wheel() {
    for speed_rad_s in [25.0, -100.0, 600.0] {
        let dead = DeadLine { board: Board::new(speed_rad_s, 0.0), dies_at_s: 2.05 };
        let mut tach = WheelTach::new(dead, &config()).unwrap();
        let mut found_s = None;
        for _ in 0..60 {
            let speed = tach.speed_rad_s();
            assert_ne!(speed, Ok([0.0]), "at {speed_rad_s} rad/s");
            if speed == Err(Error::SignalLost { wheel: 0 }) {
                found_s = found_s.or(Some(tach.timer().board.time_s));
                assert_eq!(tach.are_valid(), [false]);
            }
        }
        assert!(found_s.is_some_and(|time_s| time_s < 2.3), "{speed_rad_s}: {found_s:?}");
        // By telecommand the parked wheel counts as standing, and its sensor can be used again.
        assert!(tach.assume(0, Some(1.5)));
        assert_eq!((tach.speed_rad_s(), tach.are_valid()), (Ok([1.5]), [true]));
        assert!(tach.assume(0, None));
        assert_eq!(tach.speed_rad_s(), Err(Error::SignalLost { wheel: 0 }));
    }
    let none = Config { edges_per_turn: [0], ..config() };
    let mut none = WheelTach::new(Board::new(0.0, 0.0), &none).unwrap();
    assert!(!none.assume(0, Some(1.0)), "no sensor");
}

/// The hardest braking is no dead line.
#[test]
fn wheel_braked_to_a_stop_is_standing() {
    let board = Board::new(100.0, -0.9 * f64::from(LARGEST_RAD_S2));
    let mut tach = WheelTach::new(Braked(board), &config()).unwrap();
    let readings: std::vec::Vec<_> = (0..20).map(|_| tach.speed_rad_s()).collect();
    assert_eq!(readings.last(), Some(&Ok([0.0])));
    assert!(!readings.contains(&Err(Error::SignalLost { wheel: 0 })), "{readings:?}");
}

/// A wheel that brakes after one second, and stands.
struct Braked(Board);

impl CaptureTimer<1> for Braked {
    type Error = &'static str;

    fn ticks_per_s(&self) -> u32 {
        TICKS_PER_S
    }

    fn captured(&mut self) -> Result<[Captured; 1], Self::Error> {
        let Wheel { speed_rad_s, slope_rad_s2 } = self.0.wheel;
        let from_s = self.0.time_s;
        let to_s = from_s + SAMPLE_S;
        // Time of the motion: stretched so that the wheel turns at its first speed for one second.
        let stop_s = 1.0 + speed_rad_s / -slope_rad_s2;
        let angle = |time_s: f64| {
            let braking_s = (time_s.min(stop_s) - 1.0).max(0.0);
            let turned =
                speed_rad_s * time_s.min(stop_s) + 0.5 * slope_rad_s2 * braking_s * braking_s;
            0.5 + turned / STEP_RAD
        };
        const SLICES: u32 = 20_000;
        for slice in 0..SLICES {
            let time = |slice: u32| from_s + (to_s - from_s) * f64::from(slice) / f64::from(SLICES);
            let (before, after) = (angle(time(slice)).floor(), angle(time(slice + 1)).floor());
            if before != after {
                let a = after.rem_euclid(2.0) == 1.0;
                self.0.filter.edge(ticks(time(slice + 1)), a, !a);
            }
        }
        self.0.time_s = to_s;
        Ok([self.0.filter.captured(ticks(to_s))])
    }
}

/// Two wheels, the first of which loses edges in one reading.
struct OneLoses([Board; 2], u32);

impl CaptureTimer<2> for OneLoses {
    type Error = &'static str;

    fn ticks_per_s(&self) -> u32 {
        TICKS_PER_S
    }

    fn captured(&mut self) -> Result<[Captured; 2], Self::Error> {
        self.1 += 1;
        let [[mut first], [second]] = [self.0[0].captured()?, self.0[1].captured()?];
        first.lost = self.1 == 10;
        Ok([first, second])
    }
}

#[test]
fn lost_edges_of_one_wheel_leave_the_other() {
    let wheels = OneLoses([Board::new(400.0, 0.0), Board::new(-300.0, 5.0)], 0);
    let config = Config {
        edges_per_turn: [EDGES; 2],
        reversed: [false; 2],
        zero_after_s: ZERO_AFTER_S,
        largest_acceleration_rad_s2: LARGEST_RAD_S2,
        delay_us: 0,
    };
    let mut tach = WheelTach::new(wheels, &config).unwrap();
    let valid: std::vec::Vec<_> = (0..16)
        .map(|_| {
            let _ = tach.speed_rad_s();
            tach.are_valid()
        })
        .collect();
    let both = [true, true];
    assert_eq!(valid[8], both);
    assert_eq!(valid[9..12], [[false, true]; 3], "three readings of the first wheel");
    assert_eq!(valid[12..], [both; 4]);
}

/// Rate and speeds belong to the instant before the delay of the gyro.
#[test]
fn speed_is_that_of_the_instant_before_the_delay() {
    let slope_rad_s2 = 100.0;
    for delay_us in [0, 5_000, 13_000] {
        let config = Config { delay_us, ..config() };
        let mut tach = WheelTach::new(Board::new(200.0, slope_rad_s2), &config).unwrap();
        for reading in 0..20 {
            let Ok([speed]) = tach.speed_rad_s() else { continue };
            let time_s = tach.timer().time_s - 1e-6 * f64::from(delay_us);
            let expected = 200.0 + slope_rad_s2 * time_s;
            assert!((f64::from(speed) - expected).abs() < 0.05, "{speed} in {reading}");
        }
    }
}

/// Levels after each edge of A in forward rotation.
const FORWARD: [(bool, bool); 2] = [(true, false), (false, true)];

/// A filter after five forward edges, 1000 ticks apart; the next is due at 5000.
fn turning_filter() -> EdgeFilter {
    let mut filter = EdgeFilter::new(100);
    for k in 0..5 {
        let (a, b) = FORWARD[k % 2];
        filter.edge(1000 * k as u32, a, b);
    }
    assert_eq!(filter.captured(0).edges, 5);
    filter
}

/// State after the next true edge.
fn after_the_next(mut filter: EdgeFilter) -> Captured {
    let (a, b) = FORWARD[1];
    filter.edge(5000, a, b);
    filter.captured(5100)
}

#[test]
fn glitch_leaves_no_trace() {
    let clean = Captured { edges: 6, last_edge_ticks: 5000, now_ticks: 5100, lost: false };
    assert_eq!(after_the_next(turning_filter()), clean);

    // A short pulse of A: one edge forward, one back.
    let mut filter = turning_filter();
    filter.edge(4500, false, false);
    filter.edge(4510, true, false);
    assert_eq!(filter.captured(0).last_edge_ticks, 4000);
    assert_eq!(after_the_next(filter), clean);

    // A pulse that ended before the interrupt read the level.
    let mut filter = turning_filter();
    filter.edge(4500, true, false);
    assert_eq!(after_the_next(filter), clean);
    assert_eq!(filter.glitches(), 1);

    // Bouncing contacts: the last bounce counts.
    let mut filter = turning_filter();
    filter.edge(4990, false, true);
    filter.edge(4995, true, true);
    assert_eq!(after_the_next(filter), clean);

    // Edges faster than the fastest wheel.
    let mut filter = turning_filter();
    filter.edge(4010, false, true);
    filter.edge(4020, true, false);
    assert_eq!(after_the_next(filter), clean);
    assert_eq!(filter.glitches(), 2);
}

#[test]
fn dithering_on_an_edge_does_not_count() {
    let mut filter = turning_filter();
    for k in 0..10 {
        // Back over the edge that raised A, and forward again.
        let forward = k % 2 == 1;
        filter.edge(10_000 + 1000 * k, forward, false);
    }
    assert_eq!(filter.captured(0).edges, 5);
    assert_eq!(filter.glitches(), 0);
}

#[test]
fn edges_count_back_in_reverse_rotation() {
    let mut filter = turning_filter();
    // The same edges backward: A falls while B is low, rises while B is high.
    for k in 0..5 {
        let a = k % 2 == 1;
        filter.edge(10_000 + 1000 * k, a, a);
    }
    assert_eq!(filter.captured(0).edges, 1);
}
