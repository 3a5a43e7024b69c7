//! The accuracy tables of the pages: the campaigns behind them, and the rows that they give.
//!
//! ```text
//!  tables::TABLES ─► campaign::Row ─► host-sim mc … --json ─► cells ─► page, between its markers
//! ```
//!
//! The first cell of a row is the command that prints its figures, so that a page and the list are
//! compared without a campaign.

pub mod campaign;
pub mod page;
pub mod tables;
mod unmodelled;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use anyhow::Result;

use crate::program::HostSim;
use campaign::Row;
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
pub fn fly_all(
    host_sim: &HostSim,
    runs: Runs,
    progress: impl Fn(&str),
) -> Result<Vec<Vec<String>>> {
    let mut flown = HashMap::new();
    let mut cells = |table: &Table, row: &Row| {
        let count = runs.of(row.runs);
        if table.columns == Columns::WhiteResiduals {
            progress(&format!("{}, torque about {}", row.scenario, row.title));
            return unmodelled::cells(host_sim, row, count);
        }
        let report = match flown.entry(row.command()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => {
                progress(unknown.key());
                unknown.insert(row.fly(host_sim, count)?)
            }
        };
        campaign::cells(table.columns, report)
    };
    let mut rows = |table: &Table| {
        table.rows.iter().map(|row| Ok(table.row(row, &cells(table, row)?))).collect()
    };
    TABLES.iter().map(&mut rows).collect()
}
