//! Types of parameters and arguments.

extern crate std;
use super::{Written, Xml};
use crate::link::documentation::codes;
use quick_xml::events::BytesText;
use std::format;
use std::string::ToString;

pub fn text(xml: &mut Xml, element: &str, content: &str) -> Written {
    xml.create_element(element).write_text_content(BytesText::new(content)).map(|_| ())
}

fn units(xml: &mut Xml, unit: &str) -> Written {
    if unit == "–" {
        return xml.create_element("UnitSet").write_empty().map(|_| ());
    }
    xml.create_element("UnitSet").write_inner_content(|xml| text(xml, "Unit", unit)).map(|_| ())
}

fn integer_encoding(xml: &mut Xml, bits: usize) -> Written {
    let bits = bits.to_string();
    xml.create_element("IntegerDataEncoding")
        .with_attributes([("sizeInBits", bits.as_str()), ("encoding", "unsigned")])
        .write_empty()
        .map(|_| ())
}

fn valid_range(xml: &mut Xml, range: Option<(f64, f64)>) -> Written {
    let Some((least, most)) = range else { return Ok(()) };
    let limits = [("minInclusive", least.to_string()), ("maxInclusive", most.to_string())];
    xml.create_element("ValidRangeSet")
        .write_inner_content(|xml| {
            xml.create_element("ValidRange")
                .with_attributes(limits.iter().map(|(name, limit)| (*name, limit.as_str())))
                .write_empty()
                .map(|_| ())
        })
        .map(|_| ())
}

/// Length of an element on the line, bytes.
pub fn bytes(element: &str) -> usize {
    match element {
        "u64" => 8,
        "u32" | "f32" => 4,
        "u16" => 2,
        _ => 1,
    }
}

/// A parameter or argument type: `kind` is `Parameter` or `Argument`.
pub fn data_type(
    xml: &mut Xml,
    kind: &str,
    name: &str,
    (element, unit): (&str, &str),
    range: Option<(f64, f64)>,
) -> Written {
    let bits = (8 * bytes(element)).to_string();
    let booleans = [("zeroStringValue", "false"), ("oneStringValue", "true")];
    let (class, attributes) = match element {
        "f32" => ("Float", &[("sizeInBits", bits.as_str())][..]),
        "bool" => ("Boolean", &booleans[..]),
        "u8" | "u16" | "u32" | "u64" => {
            ("Integer", &[("signed", "false"), ("sizeInBits", bits.as_str())][..])
        }
        _ => ("Enumerated", &[][..]),
    };
    let tag = format!("{class}{kind}Type");
    xml.create_element(tag.as_str())
        .with_attribute(("name", name))
        .with_attributes(attributes.iter().copied())
        .write_inner_content(|xml| {
            units(xml, unit)?;
            match class {
                "Float" => float_encoding(xml, &bits)?,
                _ => integer_encoding(xml, 8 * bytes(element))?,
            }
            match class {
                "Enumerated" => enumeration(xml, element),
                _ => valid_range(xml, range),
            }
        })
        .map(|_| ())
}

fn float_encoding(xml: &mut Xml, bits: &str) -> Written {
    xml.create_element("FloatDataEncoding")
        .with_attributes([("sizeInBits", bits), ("encoding", "IEEE754_1985")])
        .write_empty()
        .map(|_| ())
}

fn enumeration(xml: &mut Xml, coded: &str) -> Written {
    let Some((_, words)) = codes().into_iter().find(|(name, _)| *name == coded) else {
        panic!("{coded} is not listed in documentation::codes");
    };
    // An absent value is zero on the line. A reader without conditions finds a label for it too.
    let absent = words.iter().all(|(code, _)| *code != 0).then_some(&(0, "none"));
    xml.create_element("EnumerationList")
        .write_inner_content(|xml| {
            absent.into_iter().chain(words).try_for_each(|(code, word)| {
                xml.create_element("Enumeration")
                    .with_attributes([("value", code.to_string().as_str()), ("label", word)])
                    .write_empty()
                    .map(|_| ())
            })
        })
        .map(|_| ())
}

/// Type of a header field or checksum of `bits` bits.
pub fn bits_type(xml: &mut Xml, name: &str, bits: usize, unit: &str) -> Written {
    xml.create_element("IntegerParameterType")
        .with_attributes([
            ("name", name),
            ("signed", "false"),
            ("sizeInBits", bits.to_string().as_str()),
        ])
        .write_inner_content(|xml| {
            units(xml, unit)?;
            integer_encoding(xml, bits)
        })
        .map(|_| ())
}

/// Bytes of fixed length, or of `packet_length` × 8 less a constant.
pub fn binary_type(xml: &mut Xml, name: &str, bits: Result<usize, i64>) -> Written {
    let size = |xml: &mut Xml| match bits {
        Ok(bits) => text(xml, "FixedValue", &bits.to_string()),
        Err(less) => xml
            .create_element("DynamicValue")
            .write_inner_content(|xml| {
                xml.create_element("ParameterInstanceRef")
                    .with_attribute(("parameterRef", "packet_length"))
                    .write_empty()?;
                xml.create_element("LinearAdjustment")
                    .with_attributes([("slope", "8"), ("intercept", (-less).to_string().as_str())])
                    .write_empty()
                    .map(|_| ())
            })
            .map(|_| ()),
    };
    xml.create_element("BinaryParameterType")
        .with_attribute(("name", name))
        .write_inner_content(|xml| {
            units(xml, "–")?;
            xml.create_element("BinaryDataEncoding")
                .write_inner_content(|xml| {
                    xml.create_element("SizeInBits").write_inner_content(size)?;
                    Ok(())
                })
                .map(|_| ())
        })
        .map(|_| ())
}
