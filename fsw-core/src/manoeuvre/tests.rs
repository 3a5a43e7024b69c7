extern crate std;
use super::*;
use crate::math::Vec3;
use proptest::prelude::*;
use std::vec::Vec;

type Small = Table<f32, 2, 8>;

const SPIN_KG_M2: [f32; 2] = [1.5e-5, 0.0];

/// One wheel, a torque that reverses.
fn table() -> Small {
    let mut table = Small {
        knot_us: 200_000,
        repeats: 2,
        splines: 8,
        limits: Limits {
            torque_n_m: [1e-3, 0.0],
            speed_rad_s: [100.0, 0.0],
            rate_rad_s: 0.1,
            excursion_rad: 0.05,
        },
        coefficients_n_m: [[0.0; 8]; 2],
    };
    table.coefficients_n_m[0] = [1e-3, 1e-3, -1e-3, -1e-3, -1e-3, -1e-3, 1e-3, 1e-3];
    table
}

/// A wheel that answers exactly, on a body at rest.
struct Plant {
    player: Player<f32, 2>,
    now_us: u64,
    speed_rad_s: f32,
    torque_n_m: f32,
    rate_rad_s: f32,
}

impl Plant {
    fn new(speed_rad_s: f32) -> Self {
        let player = Player::new(SPIN_KG_M2);
        Self { player, now_us: 1_000_000, speed_rad_s, torque_n_m: 0.0, rate_rad_s: 0.0 }
    }

    fn advance(&mut self, us: u64) {
        self.now_us += us;
        self.speed_rad_s += self.torque_n_m / SPIN_KG_M2[0] * us as f32 * 1e-6;
    }

    fn reading(&self) -> Reading<f32, 2> {
        Reading {
            rate_rad_s: Some(Vec3::new(self.rate_rad_s, 0.0, 0.0)),
            wheel_speed_rad_s: [Some(self.speed_rad_s), None],
        }
    }

    fn step(&mut self, table: &Small, reading: &Reading<f32, 2>) -> State {
        self.torque_n_m = self.player.step(table, self.now_us, reading)[0];
        self.player.progress().state
    }

    /// Steps of 0.1 s with exact readings. Returns the states.
    fn fly(&mut self, table: &Small, steps: u32) -> Vec<State> {
        let step = |_| {
            self.advance(100_000);
            self.step(table, &self.reading())
        };
        (0..steps).map(step).collect()
    }

    /// Steps until the end, within the stated time, s.
    fn ends(&mut self, table: &Small, mut reading: impl FnMut(&Self) -> Reading<f32, 2>) -> f32 {
        let start_us = self.now_us;
        while self.player.is_active() {
            self.advance(100_000);
            let now = reading(self);
            self.step(table, &now);
            assert!(self.now_us - start_us < 60_000_000, "does not end");
        }
        (self.now_us - start_us) as f32 * 1e-6
    }
}

fn started(speed_rad_s: f32) -> (Small, Plant) {
    let (table, mut plant) = (table(), Plant::new(speed_rad_s));
    assert_eq!(table.validate(&SPIN_KG_M2), Ok(()));
    plant.fly(&table, 3);
    assert!(plant.player.start(0));
    assert!(!plant.player.start(0), "one at a time");
    (table, plant)
}

#[test]
fn flown_manoeuvre_ends_at_the_speeds_of_the_start() {
    let (table, mut plant) = started(20.0);
    let states = plant.fly(&table, 60);
    assert_eq!(states[0], State::Flying);
    let progress = plant.player.progress();
    assert_eq!((progress.state, progress.abort), (State::AtRest, None));
    assert_eq!(progress.flown_us, table.duration_us());
    assert_eq!(table.duration_us(), 2 * 11 * 200_000);
    assert!((plant.speed_rad_s - 20.0).abs() < 1.0, "{}", plant.speed_rad_s);
    assert_eq!(plant.torque_n_m, 0.0);
}

#[test]
fn torque_is_the_spline_of_the_table() {
    let table = table();
    let b = |x: f64| {
        let y = (x - 2.0).abs();
        if y < 1.0 {
            2.0 / 3.0 - y * y + 0.5 * y * y * y
        } else if y < 2.0 {
            (2.0 - y).powi(3) / 6.0
        } else {
            0.0
        }
    };
    for ms in 0..4_400_u32 {
        let x = f64::from(ms % 2_200) / 200.0;
        let coefficients = table.coefficients_n_m[0].iter().enumerate();
        let expected: f64 = coefficients.map(|(j, c)| f64::from(*c) * b(x - j as f64)).sum();
        let [torque, other] = table.torque_n_m(ms * 1_000);
        assert!((f64::from(torque) - expected).abs() < 1e-9, "{ms}: {torque} {expected}");
        assert_eq!(other, 0.0);
    }
    assert_eq!(table.torque_n_m(0), [0.0; 2]);
    assert_eq!(table.torque_n_m(table.duration_us()), [0.0; 2]);
}

#[test]
fn each_violation_aborts_to_the_speed_of_the_start() {
    type Disturb = fn(&mut Plant) -> Reading<f32, 2>;
    let cases: [(Abort, Disturb); 6] = [
        (Abort::Gap, |plant| {
            plant.advance(400_000);
            plant.reading()
        }),
        (Abort::Glitch, |plant| Reading { rate_rad_s: None, ..plant.reading() }),
        (Abort::Rate, |plant| Reading {
            rate_rad_s: Some(Vec3::new(0.2, 0.0, 0.0)),
            ..plant.reading()
        }),
        (Abort::Excursion, |plant| Reading {
            rate_rad_s: Some(Vec3::new(0.09, 0.0, 0.0)),
            ..plant.reading()
        }),
        (Abort::Speed, |plant| Reading {
            wheel_speed_rad_s: [Some(101.0), None],
            ..plant.reading()
        }),
        (Abort::Wheel, |plant| Reading { wheel_speed_rad_s: [None; 2], ..plant.reading() }),
    ];
    for (why, disturb) in cases {
        let (table, mut plant) = started(-30.0);
        plant.fly(&table, 6);
        for _ in 0..8 {
            plant.advance(100_000);
            let reading = disturb(&mut plant);
            plant.step(&table, &reading);
            if plant.player.progress().abort.is_some() {
                break;
            }
        }
        assert_eq!(plant.player.progress().abort, Some(why));
        let time_s = plant.ends(&table, |plant| plant.reading());
        assert!(time_s <= table.rest_s(&SPIN_KG_M2), "{why:?}: {time_s} s");
        assert_eq!(plant.player.progress().state, State::AtRest);
        assert!((plant.speed_rad_s + 30.0).abs() <= 1.0, "{why:?}: {}", plant.speed_rad_s);
    }
}

#[test]
fn start_requires_rate_and_speeds() {
    let (table, mut plant) = started(0.0);
    plant.advance(100_000);
    plant.step(&table, &Reading { wheel_speed_rad_s: [None; 2], ..plant.reading() });
    let progress = plant.player.progress();
    assert_eq!((progress.state, progress.abort), (State::AtRest, Some(Abort::Wheel)));
    assert!(plant.player.start(plant.now_us + 1_000_000));
    assert_eq!(plant.fly(&table, 9).last(), Some(&State::Waiting));
    assert_eq!(plant.fly(&table, 1), [State::Flying]);
    assert!(plant.player.abort(&table, Abort::Command));
    assert!(!plant.player.abort(&table, Abort::Command));
}

#[test]
fn wheels_return_after_a_restart_once_their_speeds_are_known() {
    let (table, mut plant) = (table(), Plant::new(60.0));
    plant.player.rest_after_restart(&table, [10.0, 0.0]);
    let mut missing = 3;
    plant.ends(&table, |plant| {
        let known = missing == 0;
        missing -= i32::from(!known);
        if known { plant.reading() } else { Reading::NONE }
    });
    let progress = plant.player.progress();
    assert_eq!((progress.state, progress.abort), (State::AtRest, Some(Abort::Restart)));
    assert!((plant.speed_rad_s - 10.0).abs() <= 1.0, "{}", plant.speed_rad_s);
    // Without any reading: zero torque, and an end.
    let mut blind = Plant::new(60.0);
    blind.player.rest_after_restart(&table, [10.0, 0.0]);
    assert!(blind.ends(&table, |_| Reading::NONE) <= table.rest_s(&SPIN_KG_M2) + 0.2);
    assert_eq!(blind.player.progress().state, State::NotAtRest);
    assert_eq!(blind.speed_rad_s, 60.0);
}

#[test]
fn invalid_tables_are_named() {
    type Change = fn(&mut Small);
    let cases: [(TableError, Change); 13] = [
        (TableError::Knot, |t| t.knot_us = 9_999),
        (TableError::Splines, |t| t.splines = 0),
        (TableError::Splines, |t| t.splines = 9),
        (TableError::Repeats, |t| t.repeats = 0),
        (TableError::Duration, |t| (t.repeats, t.knot_us) = (1_000, 400_000)),
        (TableError::RateLimit, |t| t.limits.rate_rad_s = f32::NAN),
        (TableError::ExcursionLimit, |t| t.limits.excursion_rad = 2.0),
        (TableError::TorqueLimit(1), |t| t.limits.torque_n_m[0] = -1.0),
        (TableError::SpeedLimit(1), |t| t.limits.speed_rad_s[0] = 0.0),
        (TableError::NoWheel(2), |t| t.coefficients_n_m[1][3] = 1e-5),
        (TableError::Coefficient(1), |t| t.coefficients_n_m[0][7] = f32::INFINITY),
        (TableError::Torque(1), |t| t.limits.torque_n_m[0] = 9.9e-4),
        (TableError::Torque(1), |t| t.coefficients_n_m[0] = [f32::MAX; 8]),
    ];
    for (error, change) in cases {
        let mut table = table();
        change(&mut table);
        assert_eq!(table.validate(&SPIN_KG_M2), Err(error));
    }
    assert_eq!(Small::EMPTY.validate(&SPIN_KG_M2), Err(TableError::Knot));
}

fn any_table() -> impl Strategy<Value = Small> {
    let coefficients = prop::array::uniform8(-1.5e-3_f32..1.5e-3);
    (coefficients, 1_u32..4, 50_000_u32..1_000_000, 1_u32..9).prop_map(|(c, repeats, knot, n)| {
        let mut table = Small { repeats, knot_us: knot, splines: n, ..table() };
        table.coefficients_n_m[0] = c;
        table
    })
}

/// A speed of a wheel: exact, missing, or not finite.
fn any_read() -> impl Strategy<Value = u8> {
    prop_oneof![12 => Just(0_u8), 1 => Just(1), 1 => Just(2), 1 => Just(3)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3_000))]

    /// Largest torque found by the extremes of the cubics against 100 places a knot.
    #[test]
    fn valid_table_never_exceeds_its_torque(table in any_table()) {
        let most = (0..100 * (table.splines + 3)).fold(0.0_f32, |most, k| {
            let time_us = (u64::from(k) * u64::from(table.knot_us) / 100) as u32;
            most.max(table.torque_n_m(time_us)[0].abs())
        });
        let limit = table.limits.torque_n_m[0];
        match table.validate(&SPIN_KG_M2) {
            Ok(()) => prop_assert!(most <= limit * (1.0 + 1e-5), "{most}"),
            Err(error) => {
                prop_assert_eq!(error, TableError::Torque(1));
                // The extreme lies within half a hundredth of a knot of a place.
                prop_assert!(most > limit * (1.0 - 1e-3), "{most}");
            }
        }
    }

    /// Any table, missing and undefined readings, jitter up to the longest gap: torque and speed stay within their
    /// limits, and an abort ends within the stated time.
    #[test]
    fn limits_hold_whatever_the_inputs(
        table in any_table(),
        start in -90.0_f32..90.0,
        inputs in prop::collection::vec((10_000_u64..=300_000, any_read(), any::<f32>()), 20..80),
        abort_at in 0_usize..80,
    ) {
        let mut plant = Plant::new(start);
        plant.fly(&table, 3);
        plant.player.start(0);
        for (k, (us, read, number)) in inputs.into_iter().enumerate() {
            plant.advance(us);
            if k == abort_at {
                plant.player.abort(&table, Abort::Command);
            }
            let mut reading = plant.reading();
            match read {
                1 => reading.wheel_speed_rad_s[0] = None,
                2 => reading.wheel_speed_rad_s[0] = Some(f32::NAN),
                3 => reading.rate_rad_s = Some(Vec3::repeat(number)),
                _ => {}
            }
            plant.step(&table, &reading);
            prop_assert!(plant.torque_n_m.abs() <= table.limits.torque_n_m[0]);
            prop_assert!(plant.speed_rad_s.abs() <= 100.0 * (1.0 + 1e-5), "{}", plant.speed_rad_s);
        }
        plant.player.abort(&table, Abort::Command);
        let waits = matches!(plant.player.progress().state, State::Resting);
        let time_s = plant.ends(&table, |plant| plant.reading());
        prop_assert!(time_s <= table.rest_s(&SPIN_KG_M2), "{time_s}");
        if waits {
            prop_assert_eq!(plant.player.progress().state, State::AtRest);
            prop_assert!((plant.speed_rad_s - start).abs() <= 1.01);
        }
    }

    /// Numbers of any bits: the torque is finite and within its limit, and the player ends.
    #[test]
    fn any_bits_are_stepped_without_a_panic(
        inputs in prop::collection::vec((any::<u64>(), any::<[f32; 4]>()), 1..40),
    ) {
        let (table, mut player) = (table(), Player::<f32, 2>::new(SPIN_KG_M2));
        player.start(0);
        for (time_us, [x, y, z, speed]) in inputs {
            let rate_rad_s = Some(Vec3::new(x, y, z));
            let reading = Reading { rate_rad_s, wheel_speed_rad_s: [Some(speed), Some(x)] };
            let [torque, other] = player.step(&table, time_us, &reading);
            prop_assert!(torque.abs() <= 1e-3 && other == 0.0);
        }
    }
}
