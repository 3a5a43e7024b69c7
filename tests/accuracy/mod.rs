//! The accuracy tables of the pages: the campaigns behind them, and the rows that they give.
//!
//! ```text
//!  tables::TABLES ─► row::Row ─► host-sim mc … --json ─► cells ─► page, between its markers
//! ```
//!
//! The first cell of a row is the command that prints its figures, so that a page and the list are
//! compared without a campaign.

pub mod campaign;
pub mod page;
pub mod tables;
mod unmodelled;

use std::collections::HashMap;

use anyhow::Result;

use tables::{Columns, TABLES, Table};

/// Number of runs of each campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// As the list gives it.
    AsListed,
    /// The same small number for each: a check that the list can be flown.
    Few(u64),
}

impl Runs {
    fn of(self, listed: u64) -> u64 {
        match self {
            Self::AsListed => listed,
            Self::Few(runs) => runs,
        }
    }
}

/// The rows of every table, in the order of [`TABLES`].
///
/// A campaign that stands in two tables is flown once. `progress` receives each command.
///
/// # Errors
/// A campaign cannot be flown.
pub fn fly_all(runs: Runs, mut progress: impl FnMut(&str)) -> Result<Vec<Vec<String>>> {
    let mut flown = HashMap::new();
    TABLES.iter().map(|table| rows(table, runs, &mut flown, &mut progress)).collect()
}

type Flown = HashMap<String, serde_json::Value>;

fn rows(
    table: &Table,
    runs: Runs,
    flown: &mut Flown,
    progress: &mut impl FnMut(&str),
) -> Result<Vec<String>> {
    let mut rows = Vec::new();
    for row in table.rows {
        progress(&row.command());
        let cells = match table.columns {
            Columns::WhiteResiduals => unmodelled::cells(row, runs.of(row.runs))?,
            _ => {
                let arguments = row.arguments(runs.of(row.runs)).join(" ");
                if !flown.contains_key(&arguments) {
                    flown.insert(arguments.clone(), row.fly(runs.of(row.runs))?);
                }
                campaign::cells(table.columns, &flown[&arguments])?
            }
        };
        rows.push(table.row(row, &cells));
    }
    Ok(rows)
}
