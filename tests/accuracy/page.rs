//! A table between its markers in a page: `<!-- accuracy NAME -->` and `<!-- /accuracy -->`.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};

use super::tables::Table;
use crate::program::repository;

const END: &str = "<!-- /accuracy -->";

fn path(table: &Table) -> PathBuf {
    repository().join(table.page)
}

/// A page, cut at the markers of a table.
struct Cut {
    before: String,
    between: String,
    after: String,
}

fn cut(table: &Table) -> Result<Cut> {
    let page = fs::read_to_string(path(table)).with_context(|| table.page)?;
    let begin = format!("<!-- accuracy {} -->\n", table.name);
    let missing = || format!("{} has no markers `accuracy {}`", table.page, table.name);
    let (before, rest) = page.split_once(&begin).with_context(missing)?;
    let (between, after) = rest.split_once(END).with_context(missing)?;
    Ok(Cut {
        before: format!("{before}{begin}"),
        between: between.to_owned(),
        after: format!("{END}{after}"),
    })
}

/// Replaces the table of the page.
///
/// # Errors
/// The page cannot be read or written, or lacks the markers.
pub fn rewrite(table: &Table, rows: &[String]) -> Result<()> {
    let Cut { before, after, .. } = cut(table)?;
    let head = table.columns.head();
    fs::write(path(table), format!("{before}\n{head}\n{}\n\n{after}", rows.join("\n")))?;
    Ok(())
}

/// Compares the table of the page with the list: its head, the number of its rows, and the cells
/// that are known without a campaign.
///
/// # Errors
/// The page cannot be read, or differs.
pub fn check(table: &Table) -> Result<()> {
    let Cut { between, .. } = cut(table)?;
    let name = format!("{}, table `{}`", table.page, table.name);
    let rows = between
        .trim()
        .strip_prefix(&table.columns.head())
        .with_context(|| format!("{name}: the head differs from the list"))?;
    let rows: Vec<&str> = rows.lines().filter(|line| !line.is_empty()).collect();
    ensure!(rows.len() == table.rows.len(), "{name}: {} rows", rows.len());
    for (found, row) in rows.iter().zip(table.rows) {
        let expected = table.row_start(row);
        ensure!(found.starts_with(&expected), "{name}: `{found}` should start `{expected}`");
        let columns = |line: &str| line.matches('|').count();
        ensure!(
            columns(found) == columns(table.columns.head().lines().next().unwrap_or_default()),
            "{name}: `{found}` has too few or too many cells"
        );
    }
    Ok(())
}
