//! 11\. Time stamps that jump, and transient faults of ten seconds in motion that goes on, with 9, 12
//! and 15 unknowns.

use anyhow::Result;

use super::super::campaign::{Campaign, Check, Limits};
use super::super::fault::Fault;
use super::super::scenarios::{Pyramid, source};

/// Motion, s.
const MOTION_S: f64 = 240.0;
/// A transient fault of ten seconds, s.
const FAULT_S: [f64; 2] = [100.0, 110.0];
/// A fault of twenty seconds, s.
const LONG_FAULT_S: [f64; 2] = [100.0, 120.0];
/// Longest time from the end of a fault until the estimate is right for good, s.
const RECOVERY_S: f64 = 60.0;

/// Samples after which a clock that was set is followed.
const MAX_OUT_OF_ORDER: u32 = 20;

/// Number of unknowns, and the table that asks for them.
const UNKNOWNS: [(u8, &str); 3] = [
    (9, ""),
    (12, "[disturbance]\ntorque = true\n"),
    (15, "[disturbance]\ntorque = true\ngyro_bias = true\n"),
];

const LIMITS: Limits =
    Limits { converged: Some(0.99), diverged: Some(0.0), told: Some(1.0), ..Limits::HONEST };

/// The campaigns.
pub fn list() -> Result<Vec<Campaign>> {
    let faults = [
        ("gyro-garbage", Fault::GyroGarbage(FAULT_S)),
        ("wheel-garbage", Fault::WheelGarbage(FAULT_S)),
        ("axis-held", Fault::AxisHeld(LONG_FAULT_S)),
        ("bias-pulse", Fault::BiasPulse(10.0, FAULT_S)),
    ];
    let stamps = [
        ("stamp-ahead", Fault::StampAhead),
        ("back-1s", Fault::ClockBack(1.0)),
        ("back-1h", Fault::ClockBack(3600.0)),
    ];
    let mut list = Vec::new();
    for (unknowns, tables) in UNKNOWNS {
        let scenario = Pyramid { motion_s: MOTION_S, tables, ..Pyramid::PLAIN }.scenario()?;
        for (name, fault) in stamps {
            list.push(Campaign {
                fault,
                small: 4,
                limits: Limits {
                    over_bound: Some(1.5),
                    out_of_order: Some(MAX_OUT_OF_ORDER),
                    ..LIMITS
                },
                ..Campaign::new(
                    11,
                    format!("clock/{name}-{unknowns}"),
                    source(scenario.clone()),
                    100,
                )
            });
        }
        for (name, fault) in faults {
            let during = if name == "axis-held" { LONG_FAULT_S } else { FAULT_S };
            list.push(Campaign {
                fault,
                small: 4,
                check: Check::EachSecond(during),
                limits: Limits { recovery_s: Some(RECOVERY_S), ..LIMITS },
                ..Campaign::new(
                    11,
                    format!("transient/{name}-{unknowns}"),
                    source(scenario.clone()),
                    100,
                )
            });
        }
    }
    Ok(list)
}
