//! Torque profiles: torque over time, of a wheel's motor or external.
//!
//! | `kind` | keys of a wheel's profile | keys of the external torque's profile |
//! |---|---|---|
//! | `"constant"` | `value_n_m` = number | `value_n_m` = list of 3 |
//! | `"multisine"` | `amplitude_n_m`, `frequency_hz`, `phase_rad` = lists of one length | lists of 3 such lists |
//! | optional | `sweep_hz_s` = list of that length (chirps) | list of 3 such lists |
//! | optional | `points_hz` = number: linear between points at this rate | the same |
//! | `"table"` | `csv` = file with columns `t_s`, `x` | `csv` = file with columns `t_s`, `x`, `y`, `z` |
//! | `"points"` | `time_s`, `point_n_m` = lists of one length | `point_n_m` = list of 3 such lists |
//!
//! Torque is linear between the rows of a table and between points. Any kind may have `during_s`, a
//! list of `[start, end]`: the torque acts only in these intervals, with time counted from each start.

mod csv_table;
mod keys;
mod lists;
mod read;
mod torque;

pub(super) use keys::{EXTERNAL_TABLE, ExternalProfileFile, WHEEL_TABLE, WheelProfileFile};
pub(super) use lists::intervals_s;
pub(super) use read::{Surroundings, external_profile, wheel_profile};
pub use torque::{ExternalTorque, Sine, TorqueProfile};
