//! Published systems on the papers' own flights, beside the published values.
//!
//! The seeds are fixed and the values are printed: `cargo test -p tests --test papers -- --nocapture`.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

mod errors;
mod kim_2010;
mod kim_2013;
mod kim_2016;
