//! A telemetry packet as one line of text or of JSON.
//!
//! Both visit the fields of the packet: they contain every field, with the name and the unit of the
//! link's documentation (`fsw-target/src/link/link.md`).

use std::fmt::Write as _;

use fsw_target::link::telemetry::{Received, Telemetry};
use fsw_target::link::wire::{About, Shape, Value, Visitor};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::number::significant;

/// Significant digits of a number in a line of text.
const DIGITS: usize = 6;

/// One line of text: time, s, kind, sequence count, fields. Zero counts in a group and fields without
/// a value are left out.
pub fn text(packet: &Received) -> String {
    let (time_s, telemetry) = (packet.time_us as f64 * 1e-6, &packet.telemetry);
    let mut line = format!("{time_s:13.6} s  {} {}", telemetry.kind(), packet.sequence_count);
    write_text(&mut line, "", &fields(telemetry));
    if let Telemetry::Checkpoint(part) = telemetry {
        let _ = write!(line, "  bytes {}", part.bytes().len());
    }
    line
}

/// One line of JSON with all fields. A missing value and a NaN are `null`. An `f32` has the fewest
/// digits that read back as the same bits.
///
/// # Errors
/// Those of `serde_json`; no packet causes one.
pub fn json(packet: &Received) -> Result<String, serde_json::Error> {
    let Received { time_us, sequence_count, slot, telemetry } = packet;
    let mut all = vec![
        ("kind", Node::One(Value::Word(telemetry.kind()))),
        ("time_us", Node::One(Value::Whole(*time_us))),
        ("sequence_count", Node::One(Value::Whole(sequence_count.value().into()))),
        ("tag_slot", slot.map_or(Node::Missing, |slot| Node::One(Value::Whole(slot.into())))),
    ];
    all.extend(fields(telemetry));
    if let Telemetry::Checkpoint(part) = telemetry {
        all.push(("bytes", Node::Hex(hex(part.bytes()))));
    }
    serde_json::to_string(&Node::Group(all))
}

/// Bytes as pairs of hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Names and values of the fields of a packet.
type Fields = Vec<(&'static str, Node)>;

/// Value of a field.
enum Node {
    Missing,
    One(Value),
    Several(Vec<Value>),
    Hex(String),
    Group(Fields),
}

fn fields(telemetry: &Telemetry) -> Fields {
    let mut walk = Walk { open: Vec::new(), done: Vec::new() };
    telemetry.visit(&mut walk);
    walk.done
}

/// Visitor that collects the fields in nested groups.
struct Walk {
    open: Vec<(&'static str, Fields)>,
    done: Fields,
}

impl Visitor for Walk {
    fn open(&mut self, about: &About) {
        self.open.push((about.name, Vec::new()));
    }

    fn close(&mut self) {
        let Some((name, fields)) = self.open.pop() else { return };
        match self.open.last_mut() {
            Some((_, outer)) => outer.push((name, Node::Group(fields))),
            None => self.done = fields,
        }
    }

    fn field(&mut self, about: &About, shape: Shape, values: Option<&[Value]>) {
        let node = match (values, shape.count) {
            (None, _) => Node::Missing,
            (Some([value]), 1) => Node::One(*value),
            (Some(values), _) => Node::Several(values.to_vec()),
        };
        if let Some((_, fields)) = self.open.last_mut() {
            fields.push((about.name, node));
        }
    }
}

fn write_text(line: &mut String, group: &str, fields: &Fields) {
    for (name, node) in fields {
        let text = match node {
            Node::Missing => continue,
            Node::One(Value::Whole(0)) if !group.is_empty() => continue,
            Node::Group(fields) => {
                write_text(line, &format!("{group}{name}."), fields);
                continue;
            }
            Node::One(value) => word(value),
            Node::Several(values) => values.iter().map(word).collect::<Vec<_>>().join(" "),
            Node::Hex(digits) => digits.clone(),
        };
        let _ = write!(line, "  {group}{name} {text}");
    }
}

fn word(value: &Value) -> String {
    match value {
        Value::Whole(count) => count.to_string(),
        Value::Number(number) => significant((*number).into(), DIGITS),
        Value::Flag(flag) => if *flag { "yes" } else { "no" }.to_owned(),
        Value::Word(word) => (*word).to_owned(),
    }
}

impl Serialize for Node {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Missing => to.serialize_none(),
            Self::One(value) => Json(*value).serialize(to),
            Self::Several(values) => to.collect_seq(values.iter().map(|value| Json(*value))),
            Self::Hex(digits) => to.serialize_str(digits),
            Self::Group(fields) => {
                let mut map = to.serialize_map(Some(fields.len()))?;
                for (name, node) in fields {
                    map.serialize_entry(name, node)?;
                }
                map.end()
            }
        }
    }
}

/// A value as JSON.
struct Json(Value);

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::Whole(count) => to.serialize_u64(count),
            Value::Number(number) => to.serialize_f32(number),
            Value::Flag(flag) => to.serialize_bool(flag),
            Value::Word(word) => to.serialize_str(word),
        }
    }
}
