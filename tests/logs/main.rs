//! Logs as people have them: foreign forms, malformed files, many at once.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

mod malformed;
mod many;
mod shapes;
