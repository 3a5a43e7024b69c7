//! Tests: every field, argument, packet and telecommand of the types is in the description, read by an XML reader.

extern crate std;
use super::arguments::arguments;
use super::xtce::document;
use crate::link::Command;
use crate::link::command::fixtures::one_of_each as every_command;
use crate::link::command::{CommandError, Function};
use crate::link::packet::{self, Apid, Header, Packet, Secondary, SequenceCount};
use crate::link::telemetry::fixtures::one_of_each;
use crate::link::telemetry::{
    EstimateReport, ManoeuvreReport, StatusReport, Telemetry, TelemetryError,
};
use crate::link::wire::{Coded, Wire};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, BTreeSet};
use std::println;
use std::string::{String, ToString};
use std::vec::Vec;

/// Contents of the file.
#[derive(Default)]
struct Inventory {
    /// Bits of each parameter and argument type of fixed length.
    bits: BTreeMap<String, usize>,
    /// Type of each parameter, and of each argument as `command/argument`.
    types: BTreeMap<String, String>,
    /// Entries of each container and telecommand.
    entries: BTreeMap<String, Vec<String>>,
    /// APIDs with a container.
    apids: BTreeSet<u16>,
    /// Telecommands that can be sent.
    commands: BTreeSet<String>,
}

impl Inventory {
    fn read() -> Self {
        let (mut inventory, mut path) = (Self::default(), Vec::<(String, String)>::new());
        let document = document();
        let mut reader = Reader::from_str(&document);
        loop {
            match reader.read_event().unwrap() {
                Event::Start(element) => {
                    inventory.element(&element, &path);
                    path.push((tag(&element), attribute(&element, "name").unwrap_or_default()));
                }
                Event::Empty(element) => inventory.element(&element, &path),
                Event::End(_) => drop(path.pop()),
                Event::Eof => return inventory,
                _ => {}
            }
        }
    }

    fn element(&mut self, element: &BytesStart<'_>, path: &[(String, String)]) {
        let get = |name| attribute(element, name).unwrap_or_default();
        // Innermost element around this one that has a name.
        let owner = || path.iter().rev().find(|(_, name)| !name.is_empty()).unwrap().1.clone();
        match tag(element).as_str() {
            "IntegerDataEncoding" | "FloatDataEncoding" => {
                self.bits.insert(owner(), get("sizeInBits").parse().unwrap());
            }
            "Parameter" => drop(self.types.insert(get("name"), get("parameterTypeRef"))),
            "Argument" => {
                self.types.insert(owner() + "/" + &get("name"), get("argumentTypeRef"));
            }
            "ParameterRefEntry" => {
                self.entries.entry(owner()).or_default().push(get("parameterRef"));
            }
            "ArgumentRefEntry" => {
                let entry = owner() + "/" + &get("argumentRef");
                self.entries.entry(owner()).or_default().push(entry);
            }
            "MetaCommand" if get("abstract") != "true" => {
                self.commands.insert(get("name"));
            }
            "Comparison" if get("parameterRef") == "apid" => {
                self.apids.insert(get("value").parse().unwrap());
            }
            _ => {}
        }
    }

    /// Number of entries of a container or telecommand, and their bytes.
    fn size(&self, name: &str) -> (usize, usize) {
        let entries = self.entries.get(name).map_or(&[][..], Vec::as_slice);
        let bits: usize = entries.iter().map(|entry| self.bits[&self.types[entry]]).sum();
        (entries.len(), bits / 8)
    }
}

fn tag(element: &BytesStart<'_>) -> String {
    element.name().as_ref().to_string()
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let attribute = element.try_get_attribute(name).unwrap()?;
    Some(attribute.value.to_string())
}

#[test]
fn every_packet_that_the_receiver_knows_is_described() {
    let secondary = Secondary::Telemetry { time_us: 0, slot: None };
    let is_known = |apid: &u16| {
        let header =
            Header { apid: Apid::new(*apid), sequence_count: SequenceCount::new(0), secondary };
        let packet = Packet::new(&header, None, &|_| ()).unwrap();
        !matches!(Telemetry::decode(packet.bytes()), Err(TelemetryError::UnknownKind { .. }))
    };
    let known: BTreeSet<u16> = (0..0x800).filter(is_known).collect();
    assert_eq!(Inventory::read().apids, known);
}

#[test]
fn every_field_is_described() {
    let inventory = Inventory::read();
    let mut parameters = 0;
    for telemetry in one_of_each() {
        let expected = match telemetry {
            Telemetry::Estimate(_) => EstimateReport::BYTES,
            Telemetry::Status(_) => StatusReport::BYTES,
            Telemetry::Checkpoint(_) => 2 * u16::BYTES,
            Telemetry::Manoeuvre(_) => ManoeuvreReport::BYTES,
        };
        let (entries, described) = inventory.size(telemetry.kind());
        assert_eq!(described, expected, "bytes of {}", telemetry.kind());
        parameters += entries;
    }
    println!("{parameters} parameters in {} packets", inventory.apids.len());
}

#[test]
fn every_telecommand_and_argument_is_described() {
    let inventory = Inventory::read();
    let functions: BTreeSet<String> =
        Function::CODES.iter().map(|(_, name)| (*name).to_string()).collect();
    assert_eq!(inventory.commands, functions);
    let mut count = 0;
    for command in every_command() {
        let name = command.function().code().1;
        let packet = command.packet(SequenceCount::new(0)).unwrap();
        let parsed = packet::parse(packet.bytes()).unwrap();
        let (entries, bytes) = inventory.size(name);
        assert_eq!(1 + bytes, parsed.data.len(), "bytes of {name}");
        count += entries;
    }
    assert_eq!(every_command().len(), functions.len());
    println!("{count} arguments of {} telecommands", functions.len());
}

/// Next value beyond a limit of a type.
fn beyond(element: &str, limit: f64, is_upper: bool) -> Vec<u8> {
    let whole = if is_upper { limit as u32 + 1 } else { (limit as u32).wrapping_sub(1) };
    let number = limit as f32;
    match element {
        "f32" if is_upper => number.next_up().to_be_bytes().to_vec(),
        "f32" => number.next_down().to_be_bytes().to_vec(),
        "u32" => whole.to_be_bytes().to_vec(),
        "u8" => Vec::from([whole as u8]),
        other => panic!("no range of {other}"),
    }
}

/// A value beyond a described limit is rejected, and the valid arguments of the fixture are within them.
#[test]
fn ranges_are_those_of_the_flight_software() {
    let mut limits = 0;
    for command in every_command() {
        let packet = command.packet(SequenceCount::new(0)).unwrap();
        let user_data = packet::parse(packet.bytes()).unwrap().data.to_vec();
        let mut offset = 1;
        for argument in arguments(command.function()) {
            let place = offset..offset + argument.bytes;
            offset = place.end;
            let Some((least, most)) = argument.range else { continue };
            for (limit, is_upper) in [(least, false), (most, true)] {
                let mut changed = user_data.clone();
                changed[place.clone()].copy_from_slice(&beyond(argument.element, limit, is_upper));
                let decoded = Command::decode(&changed);
                let is_refused = matches!(decoded, Err(CommandError::Argument(_)));
                assert!(is_refused, "{}: {decoded:?}", argument.name);
                limits += 1;
            }
        }
    }
    println!("{limits} limits");
}
