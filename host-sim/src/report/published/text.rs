//! Tables of the papers as text: one block per table, one row per quantity.

use super::table::{PublishedTable, Row, TablesReport};
use crate::report::columns::Columns;
use crate::report::number::{fixed, power, significant};

/// Longest line, characters.
const WIDTH: usize = 100;
/// Significant digits of a number without a spread.
const DIGITS: usize = 4;
/// Cell without a value.
const EMPTY: &str = "-";

/// All tables, after a paragraph on how to read them.
pub fn tables(report: &TablesReport) -> String {
    let introduction = wrapped(&introduction(report), "");
    let blocks = report.tables.iter().map(table);
    std::iter::once(introduction).chain(blocks).collect::<Vec<_>>().join("\n")
}

/// How to read the tables.
pub fn introduction(report: &TablesReport) -> String {
    let last_seed = report.seed.wrapping_add(report.runs.saturating_sub(1));
    format!(
        "{} runs of each table, seeds {} to {last_seed}: mean ± standard deviation of one run. \
         Percentile: share of our runs below the published value; near 0 or 100 the published \
         value differs from ours. Bound: Cramér-Rao bound, one sigma. Errors are absolute values.",
        report.runs, report.seed
    )
}

/// One table: heading, columns, remarks.
pub fn table(table: &PublishedTable) -> String {
    let title = format!("[{}] {}: {}", table.paper, place(table.table), table.title);
    let flight = format!(
        "scenario {}, {} of 6 directions observable; ours: {}, {}",
        table.scenario, table.observed_directions, table.estimator, table.precision
    );
    let has = Present::of(&table.rows);
    let mut remarks: Vec<&str> = Vec::new();
    let mut columns = Columns::new(&header(table, has));
    for row in &table.rows {
        let note = row.remark.as_deref().map_or(String::new(), |remark| {
            let index = remarks.iter().position(|other| *other == remark);
            letter(index.unwrap_or_else(|| {
                remarks.push(remark);
                remarks.len() - 1
            }))
        });
        columns.row(cells(row, has, note));
    }
    let mut text = [wrapped(&title, ""), wrapped(&flight, ""), "\n".to_owned()].concat();
    text += &columns.finish();
    for (index, remark) in remarks.iter().enumerate() {
        text += &wrapped(&format!("{} {remark}", letter(index)), "    ");
    }
    if let Some(remark) = &table.remark {
        text += &wrapped(remark, "");
    }
    text
}

/// Columns of a table that have a value in any row.
#[derive(Clone, Copy)]
struct Present {
    truth: bool,
    bound: bool,
    percentile: bool,
    own: bool,
}

impl Present {
    fn of(rows: &[Row]) -> Self {
        let any = |value: fn(&Row) -> Option<f64>| rows.iter().any(|row| value(row).is_some());
        Self {
            truth: any(|row| row.truth),
            bound: any(|row| row.bound),
            percentile: any(|row| row.percentile),
            own: any(|row| row.own_mean),
        }
    }
}

/// `Table 2` for `2`. Other places have names.
fn place(table: &str) -> String {
    match table.starts_with(|first: char| first.is_ascii_digit()) {
        true => format!("Table {table}"),
        false => table.to_owned(),
    }
}

fn header(table: &PublishedTable, has: Present) -> Vec<(&str, &'static str)> {
    let mut columns = vec![("", "")];
    columns.extend(has.truth.then_some(("true", "")));
    columns.extend([("published", ""), ("ours", "")]);
    columns.extend(has.percentile.then_some(("percentile", "")));
    columns.extend(has.bound.then_some(("bound", "")));
    let own = table.own_estimator.as_deref().filter(|_| has.own);
    columns.extend(own.map(|name| (name, "")));
    columns.push(("", ""));
    columns
}

fn cells(row: &Row, has: Present, note: String) -> Vec<String> {
    // All digits, as printed in the paper.
    let number = |x: Option<f64>| x.map_or(EMPTY.to_owned(), |x| x.to_string());
    let quantity = match row.unit {
        "" => row.quantity.clone(),
        unit => format!("{}, {}", row.quantity, unit.replace('2', "²")),
    };
    let mut cells = vec![quantity];
    cells.extend(has.truth.then(|| number(row.truth)));
    cells.push(number(row.published));
    cells.push(with_spread(row.mean, row.sd));
    let percentile = row.percentile.map_or(EMPTY.to_owned(), |percent| fixed(percent, 1));
    cells.extend(has.percentile.then_some(percentile));
    let bound = row.bound.map_or(EMPTY.to_owned(), |bound| significant(bound, 3));
    cells.extend(has.bound.then_some(bound));
    cells.extend(has.own.then(|| with_spread(row.own_mean, row.own_sd)));
    cells.push(note);
    cells
}

/// A mean with two digits of its spread, as `14.118 ± 0.023`.
fn with_spread(mean: Option<f64>, sd: Option<f64>) -> String {
    const MOST_DECIMALS: i32 = 7;
    match (mean, sd) {
        (None, _) => EMPTY.to_owned(),
        // A smaller spread is a rounding error.
        (Some(mean), Some(sd)) if sd > 1e-12 * mean.abs() => {
            let decimals = 1 - power(sd);
            match decimals <= MOST_DECIMALS && mean.abs() < 1e7 {
                true => format!("{} ± {}", fixed(mean, decimals), fixed(sd, decimals)),
                false => format!("{} ± {}", significant(mean, 3), significant(sd, 2)),
            }
        }
        (Some(mean), _) => significant(mean, DIGITS),
    }
}

/// `(a)`, `(b)`, … for the remarks of a table.
fn letter(index: usize) -> String {
    let letter = char::from_u32('a' as u32 + index as u32).unwrap_or('?');
    format!("({letter})")
}

/// Breaks a paragraph into lines of at most [`WIDTH`] characters.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let fits = |line: &String| line.chars().count() + 1 + word.chars().count() <= WIDTH;
        match lines.last_mut() {
            Some(line) if line.trim().is_empty() => line.push_str(word),
            Some(line) if fits(line) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("{indent}{word}")),
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_determines_the_decimals() {
        for (mean, sd, text) in [
            (14.118_12, 0.0234, "14.118 ± 0.023"),
            (0.0081, 0.000_021, "0.008100 ± 0.000021"),
            (5573.0, 310.0, "5573 ± 310"),
            (1e-9, 2e-10, "1.00e-9 ± 2.0e-10"),
        ] {
            assert_eq!(with_spread(Some(mean), Some(sd)), text);
        }
        assert_eq!(with_spread(Some(50.0), Some(0.0)), "50.00");
        assert_eq!(with_spread(None, None), "-");
    }

    fn row(quantity: &str) -> Row {
        Row {
            quantity: quantity.to_owned(),
            unit: "kg m2",
            truth: Some(14.2),
            published: Some(14.1905),
            mean: Some(14.198),
            sd: Some(0.0031),
            percentile: Some(1.25),
            bound: Some(0.002_75),
            own_mean: Some(14.2001),
            own_sd: Some(0.0029),
            remark: Some("3.4 bounds off".to_owned()),
        }
    }

    fn example() -> TablesReport {
        TablesReport {
            runs: 20,
            seed: 0,
            tables: vec![PublishedTable {
                paper: "Bellar2019",
                table: "3",
                title: "estimation results".to_owned(),
                scenario: "bellar-2019".to_owned(),
                estimator: "joint-ekf-published".to_owned(),
                precision: "f64".to_owned(),
                own_estimator: Some("joint-ekf".to_owned()),
                observed_directions: 6,
                rows: vec![row("jxx"), row("jyy")],
                remark: None,
            }],
        }
    }

    #[test]
    fn table_has_every_column_unit_and_remark() {
        let report = example();
        let text = tables(&report);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        let (_, block) = text.split_once("\n\n").unwrap();
        assert_eq!(
            block,
            "\
[Bellar2019] Table 3: estimation results
scenario bellar-2019, 6 of 6 directions observable; ours: joint-ekf-published, f64

            true  published              ours  percentile    bound         joint-ekf
jxx, kg m²  14.2    14.1905  14.1980 ± 0.0031         1.2  0.00275  14.2001 ± 0.0029  (a)
jyy, kg m²  14.2    14.1905  14.1980 ± 0.0031         1.2  0.00275  14.2001 ± 0.0029  (a)
(a) 3.4 bounds off
"
        );
    }
}
