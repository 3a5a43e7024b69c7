//! Parts shared by the tests of the pages and by the program `accuracy`. The tests of the project are
//! one target per file or folder beside this library.

pub mod accuracy;
pub mod program;
