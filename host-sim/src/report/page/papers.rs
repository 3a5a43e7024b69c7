//! Page of the papers: tables and figures of each.

use maud::html;

use super::{Kind, Page, files, places, section};
use crate::report::plots::Figure;
use crate::report::published::text;
use crate::report::published::{PaperFigure, TablesReport};

/// The page.
pub(in crate::report) fn papers(
    report: &TablesReport,
    figures: &[PaperFigure],
    command: &str,
    all_files: &[(&str, &str)],
) -> String {
    let mut papers: Vec<&str> = report.tables.iter().map(|table| table.paper).collect();
    papers.dedup();
    let tables = |paper: &str| {
        let tables = report.tables.iter().filter(|table| table.paper == paper);
        tables.map(text::table).collect::<Vec<_>>()
    };
    let body = html! {
        section { p { (text::introduction(report)) } }
        @for paper in &papers {
            (section(paper, html! {
                @for table in tables(paper) { pre .wide { (table) } }
                (places(figures.iter().filter(|f| f.paper == *paper).map(|f| &f.figure)))
            }))
        }
        (files(all_files))
    };
    let drawn: Vec<Figure> =
        figures.iter().map(|f| f.figure.clone()).filter(|f| !f.is_empty()).collect();
    let verdict = format!(
        "{} tables and {} figures of {} papers, reproduced with {} runs each.",
        report.tables.len(),
        drawn.len(),
        papers.len(),
        report.runs
    );
    let title = "Published systems, reproduced";
    Page { title, verdict: &verdict, kind: Kind::Good, command, body, figures: &drawn }.html()
}
