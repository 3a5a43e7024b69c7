//! Master key of telecommands as a constant: from the file that `TELECOMMAND_KEY_FILE` names, or none.

use std::{env, error::Error, fs};

/// Environment variable with the path of the key file.
pub const VARIABLE: &str = "TELECOMMAND_KEY_FILE";

/// Rust source of the constant. The file holds 32 hexadecimal digits.
pub fn source() -> Result<String, Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed={VARIABLE}");
    let Some(path) = env::var_os(VARIABLE).filter(|path| !path.is_empty()) else {
        return Ok("pub const MASTER: Option<[u8; 16]> = None;".into());
    };
    let file = path.to_string_lossy();
    println!("cargo:rerun-if-changed={file}");
    let text = fs::read_to_string(&path)
        .map_err(|why| format!("{file}: not readable ({why}); {VARIABLE} names the key file"))?;
    let key = u128::from_str_radix(text.trim(), 16).ok().filter(|_| text.trim().len() == 32);
    let key = key.ok_or_else(|| {
        format!("{file}: not a key; write 32 hexadecimal digits, as `openssl rand -hex 16` prints")
    })?;
    Ok(format!("pub const MASTER: Option<[u8; 16]> = Some({:?});", key.to_be_bytes()))
}
