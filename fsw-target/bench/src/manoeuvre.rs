//! Steps of a manoeuvre's player: four wheels, a table of the largest size, then the return to rest.

use crate::counter::Counter;
use crate::tally::Tally;
use fsw_core::Vec3;
use fsw_core::manoeuvre::{Abort, Limits, Player, Reading, Table};
use fsw_target::flight::craft::WHEELS;
use fsw_target::flight::manoeuvre::{FlightTable, SPLINES};

/// Samples in flight and back at rest, at 50 Hz.
const FLYING: u64 = 400;
const STEPS: u64 = 600;
const PERIOD_US: u64 = 20_000;
/// Spin inertia of each wheel, kg m².
const SPIN_KG_M2: [f32; WHEELS] = [1.47e-5; WHEELS];

fn table() -> FlightTable {
    let torque = |i: usize| 4e-4 * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let limits = Limits {
        torque_n_m: [1e-3; WHEELS],
        speed_rad_s: [680.0; WHEELS],
        rate_rad_s: 0.5,
        excursion_rad: 0.5,
    };
    let coefficients_n_m = [core::array::from_fn(torque); WHEELS];
    Table { knot_us: 200_000, repeats: 1, splines: SPLINES as u32, limits, coefficients_n_m }
}

/// Counts the steps.
///
/// # Errors
/// A manoeuvre that does not return to rest.
#[inline(never)]
pub fn count_all(counter: &mut Counter, tally: &mut Tally) -> Result<(), &'static str> {
    let table = table();
    table.validate(&SPIN_KG_M2).map_err(|_| "the table of the manoeuvre is not valid")?;
    let mut player = Player::new(SPIN_KG_M2);
    let mut speeds = [0.0_f32; WHEELS];
    tally.clear();
    player.start(0);
    for k in 0..STEPS {
        if k == FLYING {
            player.abort(&table, Abort::Command);
        }
        let rate = Vec3::new(1e-3, -2e-3, 1e-3) * if k % 50 < 25 { 1.0 } else { -1.0 };
        let reading = Reading { rate_rad_s: Some(rate), wheel_speed_rad_s: speeds.map(Some) };
        let mut torque_n_m = [0.0; WHEELS];
        let time_us = k * PERIOD_US;
        tally.add(counter.count(|| torque_n_m = player.step(&table, time_us, &reading)));
        for (speed, torque) in speeds.iter_mut().zip(torque_n_m) {
            *speed += torque / SPIN_KG_M2[0] * 0.02;
        }
    }
    tally.report("manoeuvre", "abort", "complete");
    if player.is_active() { Err("the manoeuvre does not end") } else { Ok(()) }
}
