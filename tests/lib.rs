//! Parts shared by the tests and by the program `accuracy`.

pub mod accuracy;
pub mod program;
