//! The link as XTCE 1.2: parameters, containers, telecommands. Names are flat: not every reader has nested systems.

extern crate std;
mod commands;
mod telemetry;
mod types;

use crate::link::telemetry::LINK_VERSION;
use commands::command_meta_data;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;
use std::string::{String, ToString};
use std::vec::Vec;
use telemetry::telemetry_meta_data;

type Xml = Writer<Vec<u8>>;
type Written = io::Result<()>;

/// Name space of XTCE 1.2 and place of its schema.
const SCHEMA: &str = concat!(
    "http://www.omg.org/spec/XTCE/20180204 ",
    "http://www.omg.org/spec/XTCE/20180204/SpaceSystem.xsd"
);
/// Name of the space system.
const NAME: &str = "inertia";

/// The document.
pub fn document() -> String {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let version = LINK_VERSION.to_string();
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None))).unwrap();
    xml.create_element("SpaceSystem")
        .with_attributes([
            ("xmlns", "http://www.omg.org/spec/XTCE/20180204"),
            ("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"),
            ("xsi:schemaLocation", SCHEMA),
            ("name", NAME),
            (
                "shortDescription",
                "Flight computer of the inertia estimator: telemetry and telecommands.",
            ),
        ])
        .write_inner_content(|xml| {
            xml.create_element("Header")
                .with_attributes([("version", version.as_str()), ("validationStatus", "Released")])
                .write_empty()?;
            telemetry_meta_data(xml)?;
            command_meta_data(xml)
        })
        .unwrap();
    String::from_utf8(xml.into_inner()).unwrap() + "\n"
}
