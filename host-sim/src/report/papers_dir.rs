//! The folder of the papers: one folder for each, with its tables and its figures.
//!
//! | file | what |
//! |---|---|
//! | `tables.txt`, `tables.json` | all tables, as printed and as `--json` |
//! | `kim-2010/tables.csv` … | the tables of one paper, a row for each quantity |
//! | `kim-2010/figure-1.svg` … | the counterpart of each figure of the paper |

use std::fs;
use std::io;
use std::path::Path;

use super::out_dir::{OutputError, unwritable};
use super::published::{PublishedTable, TablesReport};
use super::published_text;

/// A figure, and where it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperFigure {
    /// Key of the paper, as `Kim2010`.
    pub paper: &'static str,
    /// Name of the file, without folder.
    pub file: String,
    /// The picture.
    pub svg: String,
}

/// Writes everything into `folder`, which is made if need be.
pub fn write_papers(
    folder: &Path,
    report: &TablesReport,
    figures: &[PaperFigure],
) -> Result<(), OutputError> {
    make(folder)?;
    let json = serde_json::to_string_pretty(report).map_err(OutputError::Json)?;
    write(&folder.join("tables.json"), &(json + "\n"))?;
    write(&folder.join("tables.txt"), &published_text::tables(report))?;
    let mut papers: Vec<&str> = report.tables.iter().map(|table| table.paper).collect();
    papers.dedup();
    for paper in papers {
        let of_paper = folder.join(folder_name(paper));
        make(&of_paper)?;
        let path = of_paper.join("tables.csv");
        let tables = report.tables.iter().filter(|table| table.paper == paper);
        fs::File::create(&path)
            .and_then(|file| write_tables(file, tables))
            .map_err(|reason| unwritable(&path, reason))?;
        for figure in figures.iter().filter(|figure| figure.paper == paper) {
            write(&of_paper.join(&figure.file), &figure.svg)?;
        }
    }
    Ok(())
}

fn make(folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(|reason| unwritable(folder, reason))
}

fn write(path: &Path, text: &str) -> Result<(), OutputError> {
    fs::write(path, text).map_err(|reason| unwritable(path, reason))
}

/// `Kim2010` as `kim-2010`.
fn folder_name(paper: &str) -> String {
    let year = paper.find(|c: char| c.is_ascii_digit()).unwrap_or(paper.len());
    format!("{}-{}", &paper[..year].to_lowercase(), &paper[year..])
}

fn write_tables<'a, W: io::Write>(
    out: W,
    tables: impl Iterator<Item = &'a PublishedTable>,
) -> io::Result<()> {
    let mut out = csv::Writer::from_writer(out);
    out.write_record([
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
    ])?;
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
    fn folders_are_called_after_the_papers() {
        assert_eq!(folder_name("Kim2010"), "kim-2010");
        assert_eq!(folder_name("Bellar2019"), "bellar-2019");
    }
}
