#![doc = include_str!("../../docs/keys.md")]

use std::fmt::Write as _;

use flight_input::key::{Key, Table};
use flight_input::{craft, log};

use super::scenario;

const HEAD: &str = "\
# Keys of scenario and craft files, columns of logs

All tables, keys and columns of the input files. An unknown key is rejected; the error names the most
similar known key. Quantities are in SI units, vectors in body axes. Inertia elements are tensor
entries in the order `jxx jyy jzz jxy jxz jyz`.

The page is generated from the readers; a test compares the two. To regenerate it after a change of a
key:

<!-- not run: writes this page -->
```sh
cargo run -p host-sim --example keys
```
";

/// The reference page in Markdown: scenario, craft file, log.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    page += "\n## SCENARIO.toml\n";
    page.extend(scenario::TABLES.iter().map(table));
    page += &fault_kinds();
    page += "\n## CRAFT.toml\n";
    page.extend(craft::TABLES.iter().map(table));
    page +=
        "\n## LOG.csv\n\nColumns in any order, separated by commas; other columns are ignored.\n";
    page += &rows("column", &log::COLUMNS);
    page
}

/// The table of fault kinds.
fn fault_kinds() -> String {
    let mut rows = "\nKinds of faults. A key outside the column `keys` is rejected.\n\n\
        | kind | magnitude | unit | range | keys | effect |\n|---|---|---|---|---|---|\n"
        .to_owned();
    let or_dash = |text: &'static str| if text.is_empty() { "–" } else { text };
    for row in &scenario::fault::KINDS {
        let takes: Vec<String> = row.takes.iter().map(|key| format!("`{}`", key.name)).collect();
        let range = if row.magnitude.is_empty() { "–" } else { row.range.words };
        let _ = writeln!(
            rows,
            "| `{}` | {} | {} | {range} | {} | {} |",
            row.name,
            or_dash(row.magnitude),
            or_dash(row.unit),
            takes.join(", "),
            row.meaning
        );
    }
    rows
}

fn table(table: &Table) -> String {
    let heading = if table.header.is_empty() { "Top level" } else { table.header };
    let heading = if table.header.is_empty() { heading.into() } else { format!("`{heading}`") };
    format!("\n### {heading}\n\n{}\n{}", table.about, rows("key", table.keys))
}

fn rows(first: &str, keys: &[Key]) -> String {
    let mut rows = format!("\n| {first} | type | unit | range | default | meaning |\n");
    rows += "|---|---|---|---|---|---|\n";
    for key in keys {
        let Key { name, value, unit, range, default, meaning } = key;
        let unit = if unit.is_empty() { "–" } else { unit };
        let default = default.unwrap_or("required");
        let _ = writeln!(
            rows,
            "| `{name}` | {value} | {unit} | {} | {default} | {meaning} |",
            range.words
        );
    }
    rows
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn page_is_that_of_the_readers() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/keys.md");
        let written = fs::read_to_string(path).unwrap();
        assert!(written == page(), "run: cargo run -p host-sim --example keys");
    }
}
