//! Master key of telecommands of the flight image.
//!
//! The build script reads it from the file that the environment variable `TELECOMMAND_KEY_FILE` names: 32
//! hexadecimal digits. Without the variable the image has no key, and telemetry reports it.

use crate::link::authentication::Key;

mod generated {
    include!(concat!(env!("OUT_DIR"), "/key.rs"));
}

/// Master key; `None` in an image without a key.
pub const MASTER_KEY: Option<Key> = match generated::MASTER {
    Some(bytes) => Some(Key::new(bytes)),
    None => None,
};
