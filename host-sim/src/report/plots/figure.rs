//! A figure: a title, and panels. Its points as a table, and as the page draws them.

use std::collections::BTreeSet;
use std::io;

use serde::{Serialize, Serializer};

use super::panel::{DrawnPanel, Panel};
use super::series::{Column, Series};

/// Panels with one title.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name, unique in its page and valid as that of a file.
    pub name: String,
    /// Title.
    pub title: String,
    x_label: String,
    panels: Vec<Panel>,
    columns: usize,
}

impl Figure {
    /// Panels one above the other.
    pub fn stacked(title: impl Into<String>, x_label: &str, panels: Vec<Panel>) -> Self {
        Self::grid(title, x_label, 1, panels)
    }

    /// Rows of up to `columns` panels.
    pub fn grid(
        title: impl Into<String>,
        x_label: &str,
        columns: usize,
        panels: Vec<Panel>,
    ) -> Self {
        let (title, x_label) = (title.into(), x_label.to_owned());
        Self { name: String::new(), title, x_label, panels, columns: columns.max(1) }
    }

    /// Gives the figure its name.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// True without any point.
    pub fn is_empty(&self) -> bool {
        self.panels.iter().flat_map(|panel| &panel.series).all(Series::is_empty)
    }

    /// Writes all points as CSV: the horizontal axis, then a column for each series of each panel. Positions that a
    /// series does not have are empty cells.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_csv<W: io::Write>(&self, out: W) -> io::Result<()> {
        let columns: Vec<Column> = self.panels.iter().flat_map(columns_of).collect();
        // The order of non-negative numbers is that of their bits; negative ones come first, reversed.
        let key = |x: f64| {
            let bits = x.to_bits() as i64;
            bits ^ (((bits >> 63) as u64) >> 1) as i64
        };
        let positions: BTreeSet<i64> =
            columns.iter().flat_map(|(_, points)| points).map(|point| key(point.0)).collect();
        let mut rows: Vec<Vec<String>> =
            vec![vec![String::new(); columns.len() + 1]; positions.len()];
        let positions: Vec<i64> = positions.into_iter().collect();
        for (place, (_, points)) in columns.iter().enumerate() {
            for (x, y) in points {
                if let Ok(row) = positions.binary_search(&key(*x)) {
                    rows[row][0] = format!("{x:?}");
                    rows[row][place + 1] = format!("{y:?}");
                }
            }
        }
        let mut out = csv::Writer::from_writer(out);
        let x_label = if self.x_label.is_empty() { "position" } else { &self.x_label };
        out.write_record(
            [x_label].into_iter().chain(columns.iter().map(|(name, _)| name.as_str())),
        )?;
        rows.iter().try_for_each(|row| out.write_record(row))?;
        out.flush()
    }
}

/// Columns of a panel, named after its vertical axis and its series.
fn columns_of(panel: &Panel) -> Vec<Column> {
    let named = |(name, points): Column| (format!("{}: {name}", panel.y_label), points);
    panel.series.iter().flat_map(Series::columns).map(named).collect()
}

/// The figure as the page draws it.
impl Serialize for Figure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Drawn<'a> {
            name: &'a str,
            x_label: &'a str,
            columns: usize,
            panels: Vec<DrawnPanel<'a>>,
        }
        let panels = self.panels.iter().map(Panel::drawn).collect();
        let (name, x_label) = (self.name.as_str(), self.x_label.as_str());
        Drawn { name, x_label, columns: self.columns, panels }.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::super::style::{Colour, Mark};
    use super::*;

    #[test]
    fn table_joins_the_series_by_position() {
        let panel = Panel::new("rate x, rad/s")
            .with(Series::curve("measured", Mark::Thin, Colour::Main, [(-1.5, 1.0), (2.0, 2.0)]))
            .with(Series::band("±3 sigma", Colour::Main, [(2.0, 1.0, 3.0)]));
        let mut bytes = Vec::new();
        Figure::stacked("rates", "time, s", vec![panel]).write_csv(&mut bytes).unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "\"time, s\",\"rate x, rad/s: measured\",\"rate x, rad/s: ±3 sigma, low\",\
             \"rate x, rad/s: ±3 sigma, high\"\n-1.5,1.0,,\n2.0,2.0,1.0,3.0\n"
        );
    }
}
