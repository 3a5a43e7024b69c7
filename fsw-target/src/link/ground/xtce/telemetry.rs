//! Telemetry: parameters, and containers of the packets.
//!
//! Optional values keep their place in a packet without them, hence their entries state position and condition. Tag and
//! checksum follow in containers of their own.

extern crate std;
use super::types::{binary_type, bits_type, bytes, data_type, text};
use super::{Written, Xml};
use crate::link::authentication::TAG_BYTES;
use crate::link::ground::fields::{HEADER_BYTES, Parameter, parameters, type_name};
use crate::link::packet::{CHECKPOINT, ESTIMATE, MANOEUVRE, STATUS};
use crate::link::telemetry::Telemetry;
use crate::link::telemetry::fixtures::one_of_each;
use std::collections::BTreeSet;
use std::string::{String, ToString};
use std::vec::Vec;
use std::{format, vec};

/// Fields of the headers: name, bits, unit, meaning.
const HEADER: [(&str, usize, &str, &str); 9] = [
    ("ccsds_version", 3, "–", "Version of the packet format: 0."),
    ("packet_type", 1, "–", "0 for telemetry."),
    ("secondary_header", 1, "–", "1 for telemetry."),
    ("apid", 11, "–", "Application process identifier: kind of the packet."),
    ("sequence_flags", 2, "–", "3: unsegmented."),
    ("sequence_count", 14, "–", "Sequence count of the APID, dropped packets included."),
    ("packet_length", 16, "–", "Bytes after the primary header, minus one."),
    ("time_us", 64, "µs", "On-board time of the packet since the start."),
    ("tag_slot", 8, "–", "Key slot of the tag plus one; 0 for a packet without a tag."),
];

/// Bytes of a checkpoint packet beside its checkpoint bytes that its length field counts, less one: secondary header,
/// `index`, `parts`, checksum.
const AROUND_CHECKPOINT: i64 = 9 + 4 + 2 - 1;

/// Name of the type of a header field.
fn bits_name(bits: usize, unit: &str) -> String {
    type_name(&format!("bits_{bits}"), unit)
}

fn parameter_types(xml: &mut Xml, packets: &[Packet]) -> Written {
    let sizes: BTreeSet<_> = HEADER.iter().map(|(_, bits, unit, _)| (*bits, *unit)).collect();
    for (bits, unit) in sizes {
        bits_type(xml, &bits_name(bits, unit), bits, unit)?;
    }
    binary_type(xml, "tag", Ok(8 * TAG_BYTES))?;
    binary_type(xml, "checkpoint_bytes", Err(8 * AROUND_CHECKPOINT))?;
    let tagged = AROUND_CHECKPOINT + TAG_BYTES as i64;
    binary_type(xml, "checkpoint_bytes_with_tag", Err(8 * tagged))?;
    let used: BTreeSet<(&str, &str)> =
        packets.iter().flat_map(|packet| &packet.parameters).map(|p| (p.element, p.unit)).collect();
    for (element, unit) in used {
        data_type(xml, "Parameter", &type_name(element, unit), (element, unit), None)?;
    }
    Ok(())
}

fn parameter(xml: &mut Xml, name: &str, of: &str, meaning: &str) -> Written {
    xml.create_element("Parameter")
        .with_attributes([("name", name), ("parameterTypeRef", of), ("shortDescription", meaning)])
        .write_empty()
        .map(|_| ())
}

fn parameter_set(xml: &mut Xml, packets: &[Packet]) -> Written {
    for (name, bits, unit, meaning) in HEADER {
        parameter(xml, name, &bits_name(bits, unit), meaning)?;
    }
    parameter(xml, "tag", "tag", "AES-128-CMAC of all bytes before it.")?;
    parameter(xml, "checksum", "bits_16", "CRC-16 of all bytes before it.")?;
    for name in ["checkpoint_bytes", "checkpoint_bytes_with_tag"] {
        parameter(xml, name, name, "Checkpoint bytes.")?;
    }
    for p in packets.iter().flat_map(|packet| &packet.parameters) {
        parameter(xml, &p.name, &type_name(p.element, p.unit), &p.meaning)?;
    }
    Ok(())
}

/// A kind of telemetry packet.
struct Packet {
    name: &'static str,
    apid: u16,
    parameters: Vec<Parameter>,
    /// Offset of the end of the parameters, bytes.
    end: usize,
    /// Parameters of variable length after them, without and with a tag.
    rest: Option<[&'static str; 2]>,
}

impl Packet {
    fn of(telemetry: &Telemetry) -> Self {
        let (apid, rest) = match telemetry {
            Telemetry::Estimate(_) => (ESTIMATE, None),
            Telemetry::Status(_) => (STATUS, None),
            Telemetry::Manoeuvre(_) => (MANOEUVRE, None),
            Telemetry::Checkpoint(_) => {
                (CHECKPOINT, Some(["checkpoint_bytes", "checkpoint_bytes_with_tag"]))
            }
        };
        let parameters = parameters(telemetry);
        let end = parameters.last().map_or(HEADER_BYTES, |last| last.offset + bytes(last.element));
        Self { name: telemetry.kind(), apid: apid.value(), parameters, end, rest }
    }
}

fn comparison(xml: &mut Xml, parameter: &str, operator: &str, value: &str) -> Written {
    xml.create_element("Comparison")
        .with_attributes([
            ("parameterRef", parameter),
            ("comparisonOperator", operator),
            ("value", value),
        ])
        .write_empty()
        .map(|_| ())
}

fn entry(xml: &mut Xml, name: &str, offset: Option<usize>, condition: Option<&str>) -> Written {
    let element = xml.create_element("ParameterRefEntry").with_attribute(("parameterRef", name));
    if offset.is_none() && condition.is_none() {
        return element.write_empty().map(|_| ());
    }
    element
        .write_inner_content(|xml| {
            if let Some(offset) = offset {
                xml.create_element("LocationInContainerInBits")
                    .with_attribute(("referenceLocation", "containerStart"))
                    .write_inner_content(|xml| {
                        text(xml, "FixedValue", &(8 * offset).to_string())
                    })?;
            }
            if let Some(present) = condition {
                xml.create_element("IncludeCondition")
                    .write_inner_content(|xml| comparison(xml, present, "==", "true"))?;
            }
            Ok(())
        })
        .map(|_| ())
}

fn container(
    xml: &mut Xml,
    name: &str,
    base: Option<(&str, &str, &str, &str)>,
    is_abstract: bool,
    entries: impl Fn(&mut Xml) -> Written,
) -> Written {
    xml.create_element("SequenceContainer")
        .with_attributes([("name", name), ("abstract", if is_abstract { "true" } else { "false" })])
        .write_inner_content(|xml| {
            xml.create_element("EntryList").write_inner_content(entries)?;
            let Some((base, parameter, operator, value)) = base else { return Ok(()) };
            xml.create_element("BaseContainer")
                .with_attribute(("containerRef", base))
                .write_inner_content(|xml| {
                    xml.create_element("RestrictionCriteria")
                        .write_inner_content(|xml| comparison(xml, parameter, operator, value))
                        .map(|_| ())
                })?;
            Ok(())
        })
        .map(|_| ())
}

/// The packet, and its ends without and with a tag.
fn packet_containers(xml: &mut Xml, packet: &Packet) -> Written {
    let apid = packet.apid.to_string();
    container(xml, packet.name, Some(("packet", "apid", "==", &apid)), true, |xml| {
        packet
            .parameters
            .iter()
            .try_for_each(|p| entry(xml, &p.name, Some(p.offset), p.present.as_deref()))
    })?;
    for (is_tagged, operator, suffix) in [(false, "==", "without_tag"), (true, "!=", "with_tag")] {
        let base = (packet.name, "tag_slot", operator, "0");
        let mut rest: Vec<&str> = vec![];
        rest.extend(packet.rest.map(|names| names[usize::from(is_tagged)]));
        if is_tagged {
            rest.push("tag");
        }
        rest.push("checksum");
        container(xml, &format!("{}_{suffix}", packet.name), Some(base), false, |xml| {
            let mut offset = Some(packet.end);
            rest.iter().try_for_each(|name| entry(xml, name, offset.take(), None))
        })?;
    }
    Ok(())
}

/// The part of telemetry.
pub fn telemetry_meta_data(xml: &mut Xml) -> Written {
    let packets = one_of_each().map(|telemetry| Packet::of(&telemetry));
    xml.create_element("TelemetryMetaData").write_inner_content(|xml| {
        xml.create_element("ParameterTypeSet")
            .write_inner_content(|xml| parameter_types(xml, &packets))?;
        xml.create_element("ParameterSet")
            .write_inner_content(|xml| parameter_set(xml, &packets))?;
        xml.create_element("ContainerSet").write_inner_content(|xml| {
            container(xml, "packet", None, true, |xml| {
                HEADER.iter().try_for_each(|(name, ..)| entry(xml, name, None, None))
            })?;
            packets.iter().try_for_each(|packet| packet_containers(xml, packet))
        })?;
        Ok(())
    })?;
    Ok(())
}
