//! The page of a report: one HTML file that opens without a network.
//!
//! ```text
//! flight, logs, campaign, faults, design, papers: sections ─┐
//! plots::Figure as JSON, uPlot, report.js, report.css ──────┴─► Page ──► report.html
//! ```
//!
//! uPlot (MIT licence, `assets/uPlot.LICENSE`) draws the plots; `assets/report.js` translates a figure into its
//! options. The content security policy of the page forbids any request.

mod campaign;
mod design;
mod events;
mod faults;
mod flight;
mod hardware;
mod logs;
mod papers;
mod tensor;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::plots::Figure;
pub(super) use campaign::{Distributions, campaign};
pub(super) use design::{design, trade};
pub(super) use faults::faults;
pub(super) use flight::{Flown, flight};
pub(super) use logs::logs;
pub(super) use papers::papers;

const UPLOT: &str = include_str!("../../../assets/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../../assets/uPlot.min.css");
const UPLOT_LICENSE: &str = include_str!("../../../assets/uPlot.LICENSE");
const SCRIPT: &str = include_str!("../../../assets/report.js");
const STYLE: &str = include_str!("../../../assets/report.css");

/// Scripts and styles of the page itself, and nothing from elsewhere.
const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// Content of a page.
pub(super) struct Page<'a> {
    /// Heading.
    pub title: &'a str,
    /// Result in one or two sentences.
    pub verdict: &'a str,
    /// Kind of the result, as a class of the verdict.
    pub kind: Kind,
    /// Command line that reproduces it.
    pub command: &'a str,
    /// Sections.
    pub body: Markup,
    /// Figures that the sections place.
    pub figures: &'a [Figure],
}

/// Kind of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// As desired.
    Good,
    /// Valid in part.
    Partial,
    /// Not to be used.
    Bad,
}

impl Page<'_> {
    /// The file.
    pub fn html(&self) -> String {
        let figures = serde_json::to_string(self.figures).unwrap_or_default();
        // A script element ends at the first `</`, also within a string.
        let figures = figures.replace('<', "\\u003c");
        let class = match self.kind {
            Kind::Good => "verdict good",
            Kind::Partial => "verdict partial",
            Kind::Bad => "verdict bad",
        };
        let version = env!("CARGO_PKG_VERSION");
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(UPLOT_STYLE)) (PreEscaped(STYLE)) }
                }
                body {
                    header { h1 { (self.title) } p class=(class) { (self.verdict) } }
                    main { (self.body) }
                    footer {
                        p { "Created by host-sim " (version) ":" }
                        pre { (self.command) }
                        p { "Drag over a plot to zoom, double-click to return. On a touch screen, two fingers zoom." }
                        details {
                            summary { "Licence of the plotting library uPlot" }
                            pre { (UPLOT_LICENSE) }
                        }
                    }
                    script type="application/json" id="figures" { (PreEscaped(figures)) }
                    script { (PreEscaped(UPLOT)) }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        }
        .into_string()
    }
}

/// A section with a heading; nothing for an empty body.
fn section(heading: &str, body: Markup) -> Markup {
    if body.0.is_empty() {
        return body;
    }
    html! { section { h2 { (heading) } (body) } }
}

/// Place of a figure, and the link to its points; nothing for a figure without points.
fn place(figure: &Figure) -> Markup {
    if figure.is_empty() {
        return html! {};
    }
    html! {
        figure {
            figcaption {
                (figure.title) " " a href={ (figure.name) ".csv" } { "CSV" }
            }
            div .panels data-figure=(figure.name) {}
        }
    }
}

/// Places of several.
fn places<'a>(figures: impl IntoIterator<Item = &'a Figure>) -> Markup {
    html! { @for figure in figures { (place(figure)) } }
}

/// A table that scrolls sideways on a narrow page. Columns without a number are flush left, others flush right.
fn table(header: &[&str], rows: &[Vec<String>]) -> Markup {
    let is_number = |cell: &String| {
        cell.trim_end_matches(['°', '%', ' ']).parse::<f64>().is_ok_and(f64::is_finite)
    };
    let has_number = |place: usize| rows.iter().filter_map(|row| row.get(place)).any(is_number);
    let classes: Vec<Option<&str>> =
        (0..header.len()).map(|place| (!has_number(place)).then_some("text")).collect();
    html! {
        div .scroll {
            table {
                thead { tr { @for (cell, class) in header.iter().zip(&classes) { th class=[class] { (cell) } } } }
                tbody {
                    @for row in rows {
                        tr { @for (cell, class) in row.iter().zip(&classes) { td class=[class] { (cell) } } }
                    }
                }
            }
        }
    }
}

/// A list of names and texts.
fn facts(facts: &[(&str, String)]) -> Markup {
    html! { dl { @for (name, text) in facts { dt { (name) } dd { (text) } } } }
}

/// Links to files of the folder.
fn files(files: &[(&str, &str)]) -> Markup {
    let list = html! { ul { @for (name, content) in files { li { a href=(name) { (name) } ": " (content) } } } };
    section("Files", list)
}

/// Notes, one sentence each.
fn notes(notes: &[String]) -> Markup {
    let list = html! { ul { @for note in notes { li { (note) } } } };
    if notes.is_empty() {
        html! {}
    } else {
        section("Notes", list)
    }
}

#[cfg(test)]
mod tests {
    use super::super::plots::{Colour, Mark, Panel, Series};
    use super::*;

    #[test]
    fn page_is_self_contained_and_its_data_do_not_end_the_script() {
        let curve = Series::curve("</script><b>", Mark::Line, Colour::Main, [(0.0, 1.0)]);
        let figure =
            Figure::stacked("a < b", "t", vec![Panel::new("a, m").with(curve)]).named("data/a");
        let body = place(&figure);
        let page = Page {
            title: "a & b",
            verdict: "All <six>.",
            kind: Kind::Good,
            command: "host-sim run",
            body,
            figures: &[figure],
        };
        let html = page.html();
        assert!(html.contains("a &amp; b") && html.contains("All &lt;six&gt;."));
        assert!(html.contains("\\u003c/script>\\u003cb>") && html.contains("href=\"data/a.csv\""));
        assert_eq!(html.matches("</script>").count(), 3);
        for request in ["src=\"", "@import", "url(", "fetch(", "XMLHttpRequest"] {
            assert!(!html.contains(request), "{request}");
        }
    }
}
