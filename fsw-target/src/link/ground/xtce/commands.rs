//! Telecommands without sequence count, tag and checksum, which the bridge completes.

extern crate std;
use super::types::{data_type, text};
use super::{Written, Xml};
use crate::link::command::Function;
use crate::link::documentation::LINK;
use crate::link::ground::arguments::{Argument, arguments};
use crate::link::packet::COMMAND;
use crate::link::wire::Coded;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// Name of the type of an argument.
fn argument_type(function: &str, argument: &Argument) -> String {
    format!("{function}_{}", argument.name)
}

fn fixed_value(xml: &mut Xml, name: &str, value: &[u8]) -> Written {
    let digits: String = value.iter().map(|byte| format!("{byte:02x}")).collect();
    xml.create_element("FixedValueEntry")
        .with_attributes([
            ("name", name),
            ("binaryValue", digits.as_str()),
            ("sizeInBits", (8 * value.len()).to_string().as_str()),
        ])
        .write_empty()
        .map(|_| ())
}

/// Effect of a telecommand and its arguments: last cells of its rows in `link.md`.
fn effect(code: u8, name: &str) -> String {
    let start = format!("| {code} | {name} |");
    let mut rows = LINK.lines().skip_while(|line| !line.starts_with(&start));
    let Some(first) = rows.next() else {
        panic!("link.md has no row of the telecommand {name}, starting {start}");
    };
    let further = rows.take_while(|row| row.starts_with("| | |"));
    let cell = |row: &'static str| row.trim_end_matches([' ', '|']).rsplit(" | ").next();
    let cells: Vec<&str> = [first].into_iter().chain(further).filter_map(cell).collect();
    cells.join(". ")
}

fn command(xml: &mut Xml, code: u8, name: &str) -> Written {
    let arguments = arguments(Function::of_code(code).unwrap());
    let user_data = 1 + arguments.iter().map(|argument| argument.bytes).sum::<usize>();
    // The length field counts the checksum, minus one.
    let length = (user_data as u16 + 2 - 1).to_be_bytes();
    xml.create_element("MetaCommand").with_attribute(("name", name)).write_inner_content(
        |xml| {
            text(xml, "LongDescription", &effect(code, name))?;
            xml.create_element("BaseMetaCommand")
                .with_attribute(("metaCommandRef", "telecommand"))
                .write_empty()?;
            if !arguments.is_empty() {
                xml.create_element("ArgumentList").write_inner_content(|xml| {
                    arguments.iter().try_for_each(|argument| {
                        xml.create_element("Argument")
                            .with_attributes([
                                ("name", argument.name.as_str()),
                                ("argumentTypeRef", argument_type(name, argument).as_str()),
                                ("shortDescription", argument.meaning.as_str()),
                            ])
                            .write_empty()
                            .map(|_| ())
                    })
                })?;
            }
            xml.create_element("CommandContainer")
                .with_attribute(("name", name))
                .write_inner_content(|xml| command_container(xml, length, code, &arguments))?;
            Ok(())
        },
    )?;
    Ok(())
}

fn command_container(xml: &mut Xml, length: [u8; 2], code: u8, arguments: &[Argument]) -> Written {
    xml.create_element("EntryList").write_inner_content(|xml| {
        fixed_value(xml, "packet_length", &length)?;
        fixed_value(xml, "function", &[code])?;
        arguments.iter().try_for_each(|argument| {
            xml.create_element("ArgumentRefEntry")
                .with_attribute(("argumentRef", argument.name.as_str()))
                .write_empty()
                .map(|_| ())
        })
    })?;
    xml.create_element("BaseContainer")
        .with_attribute(("containerRef", "telecommand"))
        .write_empty()?;
    Ok(())
}

fn base_command(xml: &mut Xml) -> Written {
    // Telecommand without a tag: type 1, no secondary header; unsegmented, count 0.
    let packet_id = (0x1000 | COMMAND.value()).to_be_bytes();
    xml.create_element("MetaCommand")
        .with_attributes([("name", "telecommand"), ("abstract", "true")])
        .write_inner_content(|xml| {
            xml.create_element("CommandContainer")
                .with_attribute(("name", "telecommand"))
                .write_inner_content(|xml| {
                    xml.create_element("EntryList").write_inner_content(|xml| {
                        fixed_value(xml, "packet_id", &packet_id)?;
                        fixed_value(xml, "sequence", &[0xc0, 0])
                    })?;
                    Ok(())
                })?;
            Ok(())
        })?;
    Ok(())
}

/// The part of telecommands.
pub fn command_meta_data(xml: &mut Xml) -> Written {
    xml.create_element("CommandMetaData").write_inner_content(|xml| {
        xml.create_element("ArgumentTypeSet").write_inner_content(|xml| {
            for (code, name) in Function::CODES {
                for argument in arguments(Function::of_code(*code).unwrap()) {
                    let of = argument_type(name, &argument);
                    let element = (argument.element, argument.unit);
                    data_type(xml, "Argument", &of, element, argument.range)?;
                }
            }
            Ok(())
        })?;
        xml.create_element("MetaCommandSet").write_inner_content(|xml| {
            base_command(xml)?;
            Function::CODES.iter().try_for_each(|(code, name)| command(xml, *code, name))
        })?;
        Ok(())
    })?;
    Ok(())
}
