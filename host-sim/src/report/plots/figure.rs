//! A figure: a title, a legend, and panels.

use plotters::prelude::*;

use super::canvas::{PlotError, failed};
use super::legend::{LEFT, Legend};
use super::panel::Panel;
use super::style::title_style;

/// Panels in one image.
#[derive(Clone, Debug)]
pub struct Figure {
    title: String,
    x_label: String,
    panels: Vec<Panel>,
    columns: usize,
    size: (u32, u32),
}

/// Height of the title's centre, px.
const TITLE_Y: i32 = 24;

impl Figure {
    /// Panels one above the other.
    pub fn stacked(title: impl Into<String>, x_label: &str, panels: Vec<Panel>) -> Self {
        const HEIGHT: u32 = 220;
        let height = HEIGHT * (panels.len().max(2) as u32) + 64;
        Self::new(title, x_label, panels, 1, (960, height))
    }

    /// Rows of `columns` panels.
    pub fn grid(
        title: impl Into<String>,
        x_label: &str,
        columns: usize,
        panels: Vec<Panel>,
    ) -> Self {
        const HEIGHT: u32 = 320;
        let rows = panels.len().div_ceil(columns.max(1)).max(1);
        let height = HEIGHT * (rows as u32) + 64;
        Self::new(title, x_label, panels, columns.max(1), (1260, height))
    }

    fn new(
        title: impl Into<String>,
        x_label: &str,
        panels: Vec<Panel>,
        columns: usize,
        size: (u32, u32),
    ) -> Self {
        Self { title: title.into(), x_label: x_label.to_owned(), panels, columns, size }
    }

    /// The figure as SVG.
    ///
    /// # Errors
    /// A failure of the drawing backend.
    pub fn draw(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, self.size).into_drawing_area();
            root.fill(&WHITE).map_err(failed)?;
            let series = self.panels.iter().flat_map(|panel| &panel.series);
            let legend = Legend::new(series, self.size.0);
            let (head, body) = root.split_vertically(legend.height());
            head.draw_text(&self.title, &title_style(), (LEFT, TITLE_Y)).map_err(failed)?;
            legend.draw(&head)?;
            let rows = self.panels.len().div_ceil(self.columns).max(1);
            let areas = body.split_evenly((rows, self.columns));
            for (index, (panel, area)) in self.panels.iter().zip(&areas).enumerate() {
                let is_lowest = index + self.columns >= self.panels.len();
                panel.draw(area, if is_lowest { &self.x_label } else { "" })?;
            }
            root.present().map_err(failed)?;
        }
        Ok(svg)
    }
}
