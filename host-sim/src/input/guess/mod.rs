//! Draft of a craft file from a log: columns by their names and units, the clock by its increments.
//!
//! ```text
//! header ──► names: words, index, unit ──► candidates of each sensor, by score ──► draft
//! values ──► clock, size of the rates ─────────────────────────────────────────┘
//! ```
//!
//! A draft is a text for a person to confirm: each line says what it is derived from. What no log shows,
//! as the axis and the spin inertia of a wheel, has a value that is rejected until it is filled in.

mod clock;
mod draft;
mod name;
mod sensors;

use flight_input::csv_source::{Column, CsvSource};

pub use draft::{NothingFound, draft};

/// The numbers of a column, without cells at fault.
fn numbers(source: &CsvSource, name: &str) -> Vec<f64> {
    let Ok(column) = source.column(name, |_| true) else { return Vec::new() };
    let number = |column: &Column| {
        source.rows().iter().filter_map(|row| source.finite_number(row, column).ok()).collect()
    };
    number(&column)
}

/// Size that all but one in a hundred of the values stay below.
fn usual_size(mut values: Vec<f64>) -> f64 {
    values.iter_mut().for_each(|value| *value = value.abs());
    values.sort_by(f64::total_cmp);
    values.get(values.len() * 99 / 100).copied().unwrap_or(0.0)
}
