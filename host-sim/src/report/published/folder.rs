//! Output folder of the papers: a page, and one folder per paper with its tables and the points of its figures.
//!
//! | file | content |
//! |---|---|
//! | `report.html` | all tables and figures |
//! | `tables.txt`, `tables.json` | all tables, as on the terminal and as with `--json` |
//! | `kim-2010/tables.csv` … | tables of one paper, one row per quantity |
//! | `kim-2010/figure-1.csv` … | counterpart of each figure of the paper |

use std::io;
use std::path::Path;

use super::table::{PaperFigure, PublishedTable, TablesReport};
use super::text;
use crate::report::files::{Folder, OutputError};
use crate::report::page;

/// Writes tables and figures into `folder`, which is created if it does not exist; files of an earlier report are
/// removed.
///
/// # Errors
/// A path that cannot be written.
pub fn write_papers(
    folder: &Path,
    report: &TablesReport,
    figures: &[PaperFigure],
    command: &str,
) -> Result<(), OutputError> {
    const FILES: [(&str, &str); 2] =
        [("tables.json", "all tables"), ("tables.txt", "all tables, as text")];
    let mut folder = Folder::open(folder, &[])?;
    folder.text("report.html", &page::papers(report, figures, command, &FILES))?;
    folder.json("tables.json", report)?;
    folder.text("tables.txt", &text::tables(report))?;
    for tables in report.tables.chunk_by(|a, b| a.paper == b.paper) {
        let name = format!("{}/tables.csv", folder_name(tables[0].paper));
        folder.stream(&name, |out| write_tables(out, tables.iter()))?;
    }
    for PaperFigure { figure, .. } in figures {
        folder.stream(&format!("{}.csv", figure.name), |out| figure.write_csv(out))?;
    }
    Ok(())
}

/// Folder of a paper: `kim-2010` for `Kim2010`.
pub fn folder_name(paper: &str) -> String {
    let year = paper.find(|c: char| c.is_ascii_digit()).unwrap_or(paper.len());
    format!("{}-{}", &paper[..year].to_lowercase(), &paper[year..])
}

const CSV_COLUMNS: [&str; 14] = [
    "table",
    "estimator",
    "precision",
    "quantity",
    "unit",
    "truth",
    "published",
    "mean",
    "sd",
    "percentile",
    "bound",
    "own_mean",
    "own_sd",
    "remark",
];

/// Writes the tables of one paper as CSV.
fn write_tables<'a, W: io::Write>(
    out: W,
    tables: impl Iterator<Item = &'a PublishedTable>,
) -> io::Result<()> {
    let mut out = csv::Writer::from_writer(out);
    out.write_record(CSV_COLUMNS)?;
    for table in tables {
        for row in &table.rows {
            let mut cells =
                [table.table, &table.estimator, &table.precision, &row.quantity, row.unit]
                    .map(str::to_owned)
                    .to_vec();
            let numbers = [
                row.truth,
                row.published,
                row.mean,
                row.sd,
                row.percentile,
                row.bound,
                row.own_mean,
                row.own_sd,
            ];
            cells.extend(numbers.map(|number| number.map_or(String::new(), |x| format!("{x:?}"))));
            cells.push(row.remark.clone().unwrap_or_default());
            out.write_record(&cells)?;
        }
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_have_the_names_of_the_papers() {
        assert_eq!(folder_name("Kim2010"), "kim-2010");
        assert_eq!(folder_name("Bellar2019"), "bellar-2019");
    }
}
