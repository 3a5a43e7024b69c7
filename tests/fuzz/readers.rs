//! Readers of files: mutated seeds, the built-in scenarios among them.

use std::path::Path;

use flight_input::{Craft, RecordedLog};
use host_sim::input::Scenario;
use host_sim::input::scenario::{built_in_names, sources};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{Executed, one_of, text};

/// Seeds: committed files.
const LOGS: [&str; 3] = [
    include_str!("seeds/log/plain.csv"),
    include_str!("seeds/log/semicolon.csv"),
    include_str!("seeds/log/attitude.csv"),
];
const CRAFTS: [&str; 2] =
    [include_str!("seeds/craft/plain.toml"), include_str!("seeds/craft/foreign.toml")];

/// A log. Accepted rows are finite and in order of time.
pub fn log(random: &mut Pcg64) -> Executed {
    let seed = one_of(random, &LOGS);
    let bytes = text::mutate(random, seed);
    let wheels = random.random_range(0..5);
    if let Ok(log) = RecordedLog::decode("fuzz.csv", &bytes, wheels) {
        let is_finite = log.rows.iter().all(|row| {
            row.rate_rad_s.iter().chain(row.torque_n_m.iter()).all(|x| x.is_finite())
                && row.wheel_speed_rad_s.iter().all(|x| x.is_finite())
        });
        let in_order = log.rows.windows(2).all(|pair| pair[0].time_us < pair[1].time_us);
        if !is_finite || !in_order {
            return Err(format!("accepted: {}", String::from_utf8_lossy(&bytes)));
        }
    }
    Ok(1)
}

/// A craft file.
pub fn craft(random: &mut Pcg64) -> Executed {
    let seed = one_of(random, &CRAFTS);
    let bytes = text::mutate(random, seed);
    let text = String::from_utf8_lossy(&bytes);
    let _ = Craft::from_toml("fuzz.toml", &text).map_err(|error| error.to_string());
    Ok(1)
}

/// A scenario, a built-in one as its seed.
pub fn scenario(random: &mut Pcg64) -> Executed {
    let names: Vec<&str> = built_in_names().collect();
    let name = one_of(random, &names);
    let files = sources(name).map_err(|error| format!("{name}: {error}"))?;
    let seed = files.first().ok_or("no file")?;
    let bytes = text::mutate(random, &seed.text);
    let text = String::from_utf8_lossy(&bytes);
    let _ = Scenario::from_toml("fuzz.toml", &text, Path::new("/nonexistent"))
        .map_err(|error| error.to_string());
    Ok(1)
}
