//! Test: the tables of `link.md` match the types. A failing test prints the expected table.

extern crate std;
use super::authentication::Authentication;
use super::command::Function;
use super::telemetry::fixtures::{estimate, manoeuvre, status};
use super::telemetry::{
    BrownOutLevel, CheckpointState, ClockSource, GyroState, HardwareError, ResetCause, TableFault,
    Telemetry,
};
use super::wire::{About, Coded, Shape, Value, Visitor};
use crate::runtime::failure::Kind as FailureKind;
use fsw_core::manoeuvre::{Abort, State};
use fsw_core::monitor::health::{Driver, Health};
use fsw_core::{Outcome, Status};
use fsw_roster::EstimatorId;
use std::string::String;
use std::vec::Vec;
use std::{format, print, println};

/// Text of the page.
pub const LINK: &str = include_str!("link.md");

/// Length of primary and secondary header, bytes.
const USER_DATA: usize = 15;

/// Rows of one packet's table.
struct Table {
    offset: usize,
    groups: Vec<&'static str>,
    rows: String,
}

impl Visitor for Table {
    fn open(&mut self, about: &About) {
        self.groups.push(about.name);
    }

    fn close(&mut self) {
        self.groups.pop();
    }

    fn field(&mut self, about: &About, shape: Shape, _: Option<&[Value]>) {
        let optional = if shape.optional { "? " } else { "" };
        let count = if shape.count > 1 { format!(" × {}", shape.count) } else { String::new() };
        let kind = format!("{optional}{}{count}", shape.element);
        let name = [&self.groups[1..], &[about.name]].concat().join(".");
        let (offset, unit, meaning) = (self.offset, about.unit, about.meaning.trim());
        self.rows += &format!("| {offset} | {kind} | `{name}` | {unit} | {meaning} |\n");
        self.offset += shape.bytes;
    }
}

fn table(telemetry: &Telemetry) -> String {
    let mut table = Table { offset: USER_DATA, groups: Vec::new(), rows: String::new() };
    telemetry.visit(&mut table);
    let crc =
        format!("| {} | u16 | | – | Checksum, after the tag if there is one. |\n", table.offset);
    format!(
        "| offset | type | field | unit | meaning |\n|---|---|---|---|---|\n{}{crc}",
        table.rows
    )
}

/// Codes with their words.
type Words = &'static [(u8, &'static str)];

/// Names and codes of all types with one-byte codes, in the order of the page.
pub fn codes() -> [(&'static str, Words); 17] {
    [
        codes_of::<EstimatorId>(),
        codes_of::<Status>(),
        codes_of::<Outcome>(),
        codes_of::<Health>(),
        codes_of::<Driver>(),
        codes_of::<HardwareError>(),
        codes_of::<ResetCause>(),
        codes_of::<FailureKind>(),
        codes_of::<ClockSource>(),
        codes_of::<GyroState>(),
        codes_of::<Function>(),
        codes_of::<CheckpointState>(),
        codes_of::<BrownOutLevel>(),
        codes_of::<Authentication>(),
        codes_of::<State>(),
        codes_of::<Abort>(),
        codes_of::<TableFault>(),
    ]
}

fn codes_of<C: Coded>() -> (&'static str, Words) {
    (C::NAME, C::CODES)
}

fn row((name, codes): (&str, Words)) -> String {
    let word = |(code, word): &(u8, &str)| format!("{code} `{word}`");
    let words: Vec<String> = codes.iter().map(word).collect();
    format!("| {name} | {} |\n", words.join(", "))
}

fn assert_documented(part: &str) {
    if !LINK.contains(part) {
        println!("expected in link.md:");
        print!("{part}");
        panic!("link.md differs from the types: replace its table by the one above");
    }
}

#[test]
fn tables_of_packets_match_the_types() {
    assert_documented(&table(&Telemetry::Estimate(estimate())));
    assert_documented(&table(&Telemetry::Status(status())));
    assert_documented(&table(&Telemetry::Manoeuvre(manoeuvre())));
}

#[test]
fn codes_match_the_types() {
    assert_documented(&codes().map(row).concat());
}
