//! Fields of a telemetry packet as XTCE parameters: one parameter per element, and one for each presence byte.

extern crate std;
use crate::link::telemetry::Telemetry;
use crate::link::wire::{About, Shape, Value, Visitor};
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// Length of primary and secondary header, bytes.
pub const HEADER_BYTES: usize = 15;

/// A parameter of a packet.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name, unique in all packets.
    pub name: String,
    /// Type on the line, a name of [`Shape::element`].
    pub element: &'static str,
    /// Unit; a dash for none.
    pub unit: &'static str,
    /// Meaning, with the number of the element.
    pub meaning: String,
    /// Offset from the start of the packet, bytes.
    pub offset: usize,
    /// Parameter that is false while this one is absent.
    pub present: Option<String>,
    /// Value of the visited report; `None` for an absent one.
    pub value: Option<Value>,
}

/// Parameters of one packet, in the order of the line.
#[derive(Default)]
struct Fields {
    groups: Vec<&'static str>,
    offset: usize,
    parameters: Vec<Parameter>,
}

impl Fields {
    fn push(&mut self, parameter: Parameter, bytes: usize) {
        self.parameters.push(Parameter { offset: self.offset, ..parameter });
        self.offset += bytes;
    }

    fn presence(&mut self, name: &str, is_present: bool) -> String {
        let present = format!("{name}_present");
        let parameter = Parameter {
            name: present.clone(),
            element: "bool",
            unit: "–",
            meaning: format!("True if {name} has a value."),
            offset: 0,
            present: None,
            value: Some(Value::Flag(is_present)),
        };
        self.push(parameter, 1);
        present
    }
}

impl Visitor for Fields {
    fn open(&mut self, about: &About) {
        self.groups.push(about.name);
    }

    fn close(&mut self) {
        self.groups.pop();
    }

    fn field(&mut self, about: &About, shape: Shape, values: Option<&[Value]>) {
        let name = [&self.groups[..], &[about.name]].concat().join("_");
        let present = shape.optional.then(|| self.presence(&name, values.is_some()));
        let bytes = (shape.bytes - usize::from(shape.optional)) / shape.count;
        for number in 1..=shape.count {
            let is_array = shape.count > 1;
            let suffix = if is_array { format!("_{number}") } else { String::new() };
            let which = format!("Element {number} of {}. ", shape.count);
            let meaning = if is_array { which } else { String::new() } + about.meaning.trim();
            let parameter = Parameter {
                name: name.clone() + &suffix,
                element: shape.element,
                unit: about.unit,
                meaning,
                offset: 0,
                present: present.clone(),
                value: values.map(|values| values[number - 1]),
            };
            self.push(parameter, bytes);
        }
    }
}

/// Parameters of a packet's user data.
pub fn parameters(telemetry: &Telemetry) -> Vec<Parameter> {
    let mut fields = Fields { offset: HEADER_BYTES, ..Fields::default() };
    telemetry.visit(&mut fields);
    fields.parameters
}

/// Type of a parameter or argument: element and unit as an identifier.
pub fn type_name(element: &str, unit: &str) -> String {
    let unit = match unit {
        "–" => String::new(),
        unit => {
            let spelled = unit.replace('/', "_per_").replace('²', "2").replace('µ', "u");
            "_".to_string() + &spelled.replace(' ', "_")
        }
    };
    element.to_string() + &unit
}
