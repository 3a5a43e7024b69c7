//! Output folder of the papers: one folder per paper, with its tables and its figures.
//!
//! | file | content |
//! |---|---|
//! | `tables.txt`, `tables.json` | all tables, as on the terminal and as with `--json` |
//! | `kim-2010/tables.csv` … | tables of one paper, one row per quantity |
//! | `kim-2010/figure-1.svg` … | counterpart of each figure of the paper |

use std::io;
use std::path::Path;

use super::table::{PaperFigure, PublishedTable, TablesReport};
use super::text;
use crate::report::files::{OutputError, create_folder, stream, write_json, write_text};

/// Writes tables and figures into `folder`, which is created if it does not exist.
///
/// # Errors
/// A path that cannot be written.
pub fn write_papers(
    folder: &Path,
    report: &TablesReport,
    figures: &[PaperFigure],
) -> Result<(), OutputError> {
    create_folder(folder)?;
    write_json(&folder.join("tables.json"), report)?;
    write_text(&folder.join("tables.txt"), &text::tables(report))?;
    let mut papers: Vec<&str> = report.tables.iter().map(|table| table.paper).collect();
    papers.dedup();
    for paper in papers {
        let of_paper = folder.join(folder_name(paper));
        create_folder(&of_paper)?;
        let tables = report.tables.iter().filter(|table| table.paper == paper);
        stream(&of_paper.join("tables.csv"), |out| write_tables(out, tables))?;
        for figure in figures.iter().filter(|figure| figure.paper == paper) {
            write_text(&of_paper.join(&figure.file), &figure.svg)?;
        }
    }
    Ok(())
}

/// Folder of a paper: `kim-2010` for `Kim2010`.
fn folder_name(paper: &str) -> String {
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
