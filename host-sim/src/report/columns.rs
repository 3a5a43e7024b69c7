//! Alignment of text in columns.

/// Rows of cells: the first column flush left, the others flush right, and a line of units under the
/// names if any column has a unit.
pub(super) struct Columns {
    rows: Vec<Vec<String>>,
}

impl Columns {
    /// Names and units of the columns.
    pub(super) fn new(columns: &[(&str, &str)]) -> Self {
        let names = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
        let units: Vec<String> = columns.iter().map(|(_, unit)| (*unit).to_owned()).collect();
        let has_units = units.iter().any(|unit| !unit.is_empty());
        Self { rows: if has_units { vec![names, units] } else { vec![names] } }
    }

    /// Adds a row.
    pub(super) fn row(&mut self, cells: impl Into<Vec<String>>) {
        self.rows.push(cells.into());
    }

    /// The aligned text.
    pub(super) fn finish(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                if column == 0 {
                    line += &format!("{cell:<width$}");
                } else {
                    line += &format!("  {cell:>width$}");
                }
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}
