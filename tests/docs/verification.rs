//! The tables of `fsw-target/docs/verification.md`: a promise, its tests, a number, a command.
//!
//! | comment before a table | meaning |
//! |---|---|
//! | `<!-- text of: PAGE, HEADING -->` | promises are quotations; each sentence of that section has one |
//! | `<!-- table of: PAGE, HEADING -->` | the same for each row of its tables, and numbers are quotations of the row |
//! | none | promises in the words of the page |

use std::fs;

use tests::program::repository;

use super::command::word_lists;
use super::workspace::Workspace;

const PAGE: &str = "fsw-target/docs/verification.md";

/// A table of the page.
pub struct Table {
    source: Option<Source>,
    rows: Vec<Row>,
}

/// Section that the promises of a table quote.
struct Source {
    name: String,
    is_table: bool,
    /// Sentences or rows, white space normalised.
    parts: Vec<String>,
}

struct Row {
    promise: String,
    tests: Vec<String>,
    number: String,
    command: String,
}

/// Every table of the page.
pub fn tables() -> Vec<Table> {
    tables_of(&fs::read_to_string(repository().join(PAGE)).unwrap())
}

fn tables_of(page: &str) -> Vec<Table> {
    let mut tables: Vec<Table> = Vec::new();
    let (mut source, mut is_inside) = (None, false);
    for line in page.lines() {
        if let Some(comment) = line.strip_prefix("<!-- ") {
            source = Source::of(comment.trim_end_matches("-->").trim());
        }
        let Some(cells) = cells(line) else {
            is_inside = false;
            continue;
        };
        if !is_inside {
            tables.push(Table { source: source.take(), rows: Vec::new() });
            is_inside = true;
        }
        let row = Row::of(&cells);
        // Neither the heading nor the line below it.
        if row.promise != "promise" && !row.promise.starts_with("---") {
            tables.last_mut().unwrap().rows.push(row);
        }
    }
    tables
}

/// Cells of a row of a table; `None` for another line.
fn cells(line: &str) -> Option<Vec<String>> {
    let row = line.trim().strip_prefix('|')?.strip_suffix('|')?;
    Some(row.split('|').map(normal).collect())
}

/// One space between words.
fn normal(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Row {
    fn of(cells: &[String]) -> Self {
        let cell = |index: usize| cells.get(index).cloned().unwrap_or_default();
        let code = |text: &str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        let command = cell(3).trim_matches('`').to_owned();
        Self { promise: cell(0), tests: code(&cell(1)), number: cell(2), command }
    }
}

impl Source {
    fn of(comment: &str) -> Option<Self> {
        let is_table = comment.starts_with("table of: ");
        let (_, name) = comment.split_once(" of: ")?;
        let (page, heading) = name.split_once(", ")?;
        let text = fs::read_to_string(repository().join(page)).unwrap();
        let section = section(&text, heading);
        let parts = if is_table { rows(&section) } else { sentences(&section) };
        Some(Self { name: name.to_owned(), is_table, parts })
    }
}

/// Lines from a heading to the next one, without comments and fenced blocks.
fn section(text: &str, heading: &str) -> Vec<String> {
    let mut is_inside = false;
    let mut is_fenced = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            is_fenced = !is_fenced;
        } else if line.starts_with('#') && !is_fenced {
            is_inside = line.trim_start_matches('#').trim() == heading;
        } else if is_inside && !is_fenced && !line.starts_with("<!--") {
            lines.push(line.to_owned());
        }
    }
    lines
}

/// Rows of the tables, without their headings.
fn rows(lines: &[String]) -> Vec<String> {
    let is_rule = |line: &String| line.starts_with("|---");
    let is_body = |index: usize| {
        lines[index].starts_with('|')
            && !is_rule(&lines[index])
            && !lines.get(index + 1).is_some_and(is_rule)
    };
    (0..lines.len()).filter(|index| is_body(*index)).map(|index| normal(&lines[index])).collect()
}

/// Sentences: an item of a list ends one, too.
fn sentences(lines: &[String]) -> Vec<String> {
    let mut text = String::new();
    for line in lines {
        let item = line.strip_prefix("- ");
        text.push_str(if item.is_some() || line.trim().is_empty() { "\n" } else { " " });
        text.push_str(item.unwrap_or(line));
    }
    let sentences = text.lines().flat_map(|line| {
        let line = normal(line);
        line.split_inclusive(". ").map(|sentence| sentence.trim().to_owned()).collect::<Vec<_>>()
    });
    sentences.filter(|sentence| !sentence.is_empty()).collect()
}

impl Table {
    /// Faults of the rows, and parts of the source without a row.
    pub fn complaints(&self, workspace: &Workspace) -> Vec<String> {
        let of_row = |row: &Row| {
            let why = row.complaint(workspace).or_else(|| self.misquoted(row));
            why.map(|why| format!("`{}`: {why}", row.promise))
        };
        let mut complaints: Vec<String> = self.rows.iter().filter_map(of_row).collect();
        if let Some(source) = &self.source {
            if source.parts.is_empty() {
                complaints.push(format!("`{}` has no text", source.name));
            }
            let has_row = |part: &&String| self.rows.iter().any(|row| part.contains(&row.promise));
            let without = source.parts.iter().filter(|part| !has_row(part));
            complaints.extend(without.map(|part| format!("{}: no row for `{part}`", source.name)));
        }
        complaints
    }

    /// A promise that is not in its source, or a number that is not in its row there.
    fn misquoted(&self, row: &Row) -> Option<String> {
        let source = self.source.as_ref()?;
        let mut parts = source.parts.iter().filter(|part| part.contains(&row.promise)).peekable();
        if parts.peek().is_none() {
            return Some(format!("is not in {}", source.name));
        }
        let is_quoted = !source.is_table
            || source.name.ends_with("Estimators")
            || parts.any(|part| part.contains(&row.number));
        (!is_quoted).then(|| format!("{} has another number than `{}`", source.name, row.number))
    }
}

impl Row {
    fn complaint(&self, workspace: &Workspace) -> Option<String> {
        if self.tests.is_empty() {
            return Some("has no test".into());
        }
        if self.number != "none" && !self.number.contains(|c: char| c.is_ascii_digit()) {
            return Some("has no number".into());
        }
        let missing = self.tests.iter().find(|test| !exists(test));
        if let Some(test) = missing {
            return Some(format!("the test `{test}` does not exist"));
        }
        let check = |words: Vec<String>| workspace.check(&words).err();
        let faults = word_lists(&self.command).into_iter().filter_map(check).next();
        match self.command.is_empty() {
            true => Some("has no command".into()),
            false => faults.map(|why| format!("`{}`: {why}", self.command)),
        }
    }
}

/// True for `PATH` of a program or of documentation with tests, and for `PATH::FUNCTION` of a test in Rust or Python.
fn exists(test: &str) -> bool {
    let (path, function) = match test.split_once("::") {
        Some((path, function)) => (path, Some(function)),
        None => (test, None),
    };
    let Ok(text) = fs::read_to_string(repository().join(path)) else { return false };
    match function {
        Some(function) if path.ends_with(".py") => text.contains(&format!("def {function}(")),
        Some(function) => {
            let definition = [format!("fn {function}("), format!("fn {function}<")];
            let is_defined = definition.iter().any(|definition| text.contains(definition));
            is_defined && text.contains("#[test]")
        }
        None => text.contains("fn main(") || text.contains("//! ```\n"),
    }
}

/// Rows with one fault each: a number, a test, a command, a quotation; and a sentence without a row.
#[test]
fn faults_of_a_table_are_named() {
    let row = "`tests/docs/main.rs::links_lead_to_files`";
    let page = format!(
        "<!-- text of: README.md, Ordinary logs -->\n| promise | test | number | command |\n\
         |---|---|---|---|\n\
         | Rest is collapsed | {row} | | `cargo test` |\n\
         | spikes | `tests/docs/main.rs::none` | 1 | `cargo test` |\n\
         | bad frames | {row} | 1 | `cargo fly` |\n\
         | nowhere to be found | {row} | 1 | `cargo test` |\n\
         | Events are printed | {row} | 1 | `cargo test` |\n"
    );
    let tables = tables_of(&page);
    assert_eq!((tables.len(), tables[0].rows.len()), (1, 5));
    let complaints = tables[0].complaints(&Workspace::load()).join("\n");
    for expected in [
        "`Rest is collapsed`: has no number",
        "the test `tests/docs/main.rs::none` does not exist",
        "cargo has no verb or alias `fly`",
        "`nowhere to be found`: is not in README.md, Ordinary logs",
        "no row for `Change, transient fault",
    ] {
        assert!(complaints.contains(expected), "{expected} is missing in {complaints}");
    }
    assert!(!complaints.contains("Events"), "{complaints}");
}
