//! `telemetry`: packets of a flight computer's serial line, one line of output each.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::path::PathBuf;

use clap::Args;

use super::{Failure, key};
use crate::ground::{GroundReceiver, Reception};
use crate::input::InputError;
use crate::input::error::{Place, Problem};
use crate::report::packet;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Bytes of the serial line: a port in raw mode, a recorded file, or - for stdin
    #[arg(value_name = "FILE")]
    source: PathBuf,
    /// Print one JSON document per line, with every field, instead of text
    #[arg(long)]
    json: bool,
    /// File with a slot's key: print only packets with a tag of this key, and note the others as damaged
    ///
    /// The telecommand tag-telemetry of that slot makes the flight computer tag its packets.
    #[arg(long, value_name = "FILE")]
    key: Option<PathBuf>,
}

/// Largest number of bytes per read. A port returns what it has.
const CHUNK: usize = 4096;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = arguments.source.display().to_string();
    let unreadable = |error| InputError {
        place: Place { file: file.clone(), line: None },
        problem: Problem::Unreadable(error),
    };
    let mut source: Box<dyn Read> = match file.as_str() {
        "-" => Box::new(io::stdin()),
        _ => Box::new(File::open(&arguments.source).map_err(unreadable)?),
    };

    let mut ground = match &arguments.key {
        Some(file) => GroundReceiver::with_key(key::read(file)?),
        None => GroundReceiver::default(),
    };
    let mut chunk = [0; CHUNK];
    loop {
        let bytes = match source.read(&mut chunk) {
            Ok(0) => break,
            Ok(length) => &chunk[..length],
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => return Err(unreadable(error).into()),
        };
        for byte in bytes {
            let Some(reception) = ground.push(*byte) else { continue };
            if !show(&mut ground, &reception, arguments.json)? {
                return Ok(());
            }
        }
    }
    if let Some(cut) = ground.end() {
        eprintln!("note: {cut}");
    }
    match ground.packets() {
        0 => Err(Failure::NoTelemetry { file, bytes: ground.bytes() }),
        _ => Ok(()),
    }
}

/// Prints a packet to stdout, and damaged or missing ones to stderr. Returns false once the reader
/// of stdout has closed it.
fn show(ground: &mut GroundReceiver, reception: &Reception, json: bool) -> Result<bool, Failure> {
    let received = match reception {
        Reception::Packet(packet) => packet,
        Reception::Damaged(damaged) => {
            eprintln!("note: {damaged}");
            return Ok(true);
        }
    };
    let missing = ground.missing_before(received);
    if missing > 0 {
        let (kind, count) = (received.telemetry.kind(), received.sequence_count);
        eprintln!("note: missing before {kind} {count}: {missing}");
    }
    let line = match json {
        true => packet::json(received).map_err(Failure::Json)?,
        false => packet::text(received),
    };
    match writeln!(io::stdout(), "{line}") {
        // A closed pipe, as with `head`, is not an error.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        other => other.map(|()| true).map_err(Failure::Print),
    }
}
