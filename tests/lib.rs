//! Parts shared by the tests of the pages and by the programs `accuracy`, `field`, `sbom` and `upsets`. The tests of the project are
//! one target per file or folder beside this library.

pub mod accuracy;
pub mod diagnose;
pub mod field;
pub mod fuzz;
pub mod hardware;
pub mod manoeuvre;
pub mod program;
pub mod supply;
pub mod upsets;
