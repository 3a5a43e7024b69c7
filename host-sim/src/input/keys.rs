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
    page += "\n## CRAFT.toml\n";
    page.extend(craft::TABLES.iter().map(table));
    page +=
        "\n## LOG.csv\n\nColumns in any order, separated by commas; other columns are ignored.\n";
    page += &rows("column", &log::COLUMNS);
    page
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
