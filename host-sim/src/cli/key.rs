//! Key files of telecommands, and `derive-key`: the key of a slot from the master key.
//!
//! A key file holds 32 hexadecimal digits, as `openssl rand -hex 16` prints.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, value_parser};
use fsw_target::link::authentication::{Key, SLOTS};

use super::{Failure, print_line};
use crate::report::packet::hex;

/// Largest number of a key slot.
const LAST_SLOT: i64 = SLOTS as i64 - 1;

#[derive(Debug, Args)]
pub struct Arguments {
    /// File with the master key of the flight image, 32 hexadecimal digits
    #[arg(value_name = "MASTER")]
    master: PathBuf,
    /// Key slot: 0 changes keys, 1 and 2 carry telecommands
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = value_parser!(u8).range(..=LAST_SLOT))]
    slot: u8,
    /// Generation of the key, as the status reports it; 0 for the first key
    ///
    /// The generation after a change-key is the counter of that telecommand.
    #[arg(long, value_name = "N", default_value_t = 0)]
    generation: u32,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let key = read(&arguments.master)?.of_slot(arguments.slot, arguments.generation);
    print_line(&hex(key.bytes()))
}

/// Key of a file.
///
/// # Errors
/// An unreadable file, or one that holds no key.
pub fn read(path: &Path) -> Result<Key, Failure> {
    let file = path.display().to_string();
    let text = fs::read_to_string(path)
        .map_err(|error| Failure::UnreadableKey { file: file.clone(), error })?;
    let digits = text.trim();
    let is_key = digits.len() == 32 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    match u128::from_str_radix(digits, 16) {
        Ok(key) if is_key => Ok(Key::new(key.to_be_bytes())),
        _ => Err(Failure::NoKey { file }),
    }
}
