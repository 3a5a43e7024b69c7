//! Logs as people have them: foreign forms, malformed files, many at once.

mod malformed;
mod many;
mod shapes;
