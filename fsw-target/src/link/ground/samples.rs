//! Packets with their values, one JSON object per line, for readers and writers of other origin.
//!
//! Telemetry: `{"packet": HEX, "container": NAME, "values": {PARAMETER: value}}`, absent parameters left out.
//! Telecommands: `{"command": NAME, "arguments": {ARGUMENT: value}, "packet": HEX, "tagged_packet": HEX, "tagged_by":
//! {"slot": N, "key": HEX, "counter": N}}`.

extern crate std;
use super::arguments::arguments;
use super::fields::parameters;
use crate::link::Command;
use crate::link::authentication::Key;
use crate::link::command::fixtures::one_of_each as every_command;
use crate::link::documentation::codes;
use crate::link::packet::{Packet, SequenceCount};
use crate::link::telemetry::fixtures::{estimate, manoeuvre, one_of_each, status};
use crate::link::telemetry::{EstimateReport, ManoeuvreReport, Report, StatusReport, Telemetry};
use crate::link::wire::{Coded, Value};
use serde_json::{Map, json};
use std::format;
use std::string::String;

/// On-board time of the packets, µs.
const TIME_US: u64 = 123_456_789;
/// Key slot and key of the packets with a tag.
const SLOT_KEY: (u8, Key) = (1, Key::new([7; 16]));
/// Counter of the telecommands with a tag.
const COUNTER: u32 = 70_000;
/// Bytes of a telecommand without a tag before its arguments: primary header and function code.
const BEFORE_ARGUMENTS: usize = 7;

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn packet(telemetry: &Telemetry, key: Option<&(u8, Key)>) -> Packet {
    let count = SequenceCount::new(77);
    let packet = match telemetry {
        Telemetry::Estimate(report) => report.packet(TIME_US, count, key),
        Telemetry::Status(report) => report.packet(TIME_US, count, key),
        Telemetry::Checkpoint(part) => part.packet(TIME_US, count, key),
        Telemetry::Manoeuvre(report) => report.packet(TIME_US, count, key),
    };
    packet.unwrap()
}

fn telemetry_line(telemetry: &Telemetry, key: Option<&(u8, Key)>) -> String {
    let packet = packet(telemetry, key);
    let mut values = Map::new();
    for parameter in parameters(telemetry) {
        let value = match parameter.value {
            None => continue,
            Some(Value::Whole(number)) => json!(number),
            Some(Value::Number(number)) => json!(f64::from(number)),
            Some(Value::Flag(flag)) => json!(flag),
            Some(Value::Word(word)) => json!(word),
        };
        values.insert(parameter.name, value);
    }
    let tag = if key.is_some() { "with_tag" } else { "without_tag" };
    let container = format!("{}_{tag}", telemetry.kind());
    format!(
        "{}\n",
        json!({"packet": hex(packet.bytes()), "container": container, "values": values})
    )
}

fn argument(element: &str, bytes: &[u8]) -> serde_json::Value {
    let whole = bytes.iter().fold(0_u64, |whole, byte| whole << 8 | u64::from(*byte));
    match element {
        "f32" => json!(f64::from(f32::from_bits(whole as u32))),
        "bool" => json!(whole == 1),
        "u8" | "u16" | "u32" | "u64" => json!(whole),
        coded => {
            let (_, words) = codes().into_iter().find(|(name, _)| *name == coded).unwrap();
            json!(words.iter().find(|(code, _)| u64::from(*code) == whole).unwrap().1)
        }
    }
}

fn command_line(command: &Command) -> String {
    let packet = command.packet(SequenceCount::new(0)).unwrap();
    let mut offset = BEFORE_ARGUMENTS;
    let mut values = Map::new();
    for described in arguments(command.function()) {
        let bytes = &packet.bytes()[offset..offset + described.bytes];
        values.insert(described.name, argument(described.element, bytes));
        offset += described.bytes;
    }
    let (slot, key) = SLOT_KEY;
    let tagged = command.tagged_packet(&key, slot, COUNTER).unwrap();
    let line = json!({
        "command": command.function().code().1,
        "arguments": values,
        "packet": hex(packet.bytes()),
        "tagged_packet": hex(tagged.bytes()),
        "tagged_by": {"slot": slot, "key": hex(key.bytes()), "counter": COUNTER},
    });
    format!("{line}\n")
}

/// Reports without a value in any field that may be absent.
fn sparse() -> [Telemetry; 3] {
    [
        Telemetry::Estimate(EstimateReport {
            outcome: None,
            health_driver: None,
            residuals_white: None,
            nis: None,
            disturbance_torque_n_m: None,
            gyro_bias_rad_s: None,
            sigma_systematic_kg_m2: None,
            largest_systematic: None,
            time_offset_s: None,
            ..estimate()
        }),
        Telemetry::Status(StatusReport {
            last_failure: None,
            gyro_identity: None,
            last_command: None,
            last_command_done: None,
            telemetry_slot: None,
            ..status()
        }),
        Telemetry::Manoeuvre(ManoeuvreReport {
            abort: None,
            table_checksum: None,
            table_error: None,
            ..manoeuvre()
        }),
    ]
}

/// All samples.
pub fn lines() -> String {
    let full = one_of_each();
    let sparse = sparse();
    let is_present = |telemetry: &Telemetry| {
        let mut parameters = parameters(telemetry).into_iter();
        parameters.find(|parameter| parameter.present.is_some() && parameter.value.is_some())
    };
    assert_eq!(sparse.iter().find_map(is_present).map(|parameter| parameter.name), None);

    let plain = full.iter().map(|telemetry| telemetry_line(telemetry, None));
    let tagged = full.iter().map(|telemetry| telemetry_line(telemetry, Some(&SLOT_KEY)));
    let absent = sparse.iter().map(|telemetry| telemetry_line(telemetry, None));
    let commands = every_command();
    plain.chain(tagged).chain(absent).chain(commands.iter().map(command_line)).collect()
}
