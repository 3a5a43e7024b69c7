//! A recorded flight, from its log to Rust source: the numbers of `host-sim replay --precision f32`
//! for the same files.

use super::craft::floats;
use flight_input::log::LogRow;
use std::fmt::{Error, Write as _};

/// The Rust source of `WHEELS` and `ROWS`.
pub fn source(rows: &[LogRow], wheels: usize) -> Result<String, Error> {
    let mut source = format!("/// Number of wheels.\npub const WHEELS: usize = {wheels};\n");
    let samples = rows.len();
    writeln!(source, "/// The log.\npub static ROWS: [Row<WHEELS>; {samples}] = [")?;
    for row in rows {
        writeln!(source, "    Row {{")?;
        writeln!(source, "        time_us: {},", row.time_us)?;
        writeln!(source, "        rate_rad_s: {},", floats(row.rate_rad_s.as_slice()))?;
        writeln!(source, "        wheel_speed_rad_s: {},", floats(&row.wheel_speed_rad_s))?;
        writeln!(source, "        torque_n_m: {},", floats(row.torque_n_m.as_slice()))?;
        writeln!(source, "    }},")?;
    }
    writeln!(source, "];")?;
    Ok(source)
}
