//! Page of several logs: a row and a point of each plot for every result.

use maud::{Markup, html};

use super::{Kind, Page, files, places, section};
use crate::input::ELEMENT_NAMES;
use crate::report::json::{LogReport, ReplayReport, Status};
use crate::report::number::significant;
use crate::report::plots::{Colour, Dot, Figure, Panel, Series};
use crate::report::table::{DIGITS, EMPTY};

/// Half the length of a whisker, sigmas.
const WHISKER_SIGMAS: f64 = 3.0;

/// The page, and its figure; `links` are the folders of the results, where they have one.
pub(in crate::report) fn logs(
    reports: &[LogReport],
    links: &[Option<String>],
    command: &str,
    all_files: &[(&str, &str)],
) -> (String, Vec<Figure>) {
    let figure = elements(reports);
    let figures: Vec<Figure> = (!figure.is_empty()).then_some(figure).into_iter().collect();
    let count = |status: Option<Status>| {
        reports.iter().filter(|report| report.result.as_ref().map(|r| r.status) == status).count()
    };
    let counts = [
        (count(Some(Status::Converged)), "converged"),
        (count(Some(Status::Partial)), "partial"),
        (count(Some(Status::Unobservable)), "unobservable"),
        (count(Some(Status::Diverged)), "diverged"),
        (count(None), "failed"),
    ];
    let named = counts.iter().filter(|(count, _)| *count > 0);
    let named: Vec<String> = named.map(|(count, name)| format!("{count} {name}")).collect();
    let kind = match counts[0].0 {
        good if good == reports.len() => Kind::Good,
        0 => Kind::Bad,
        _ => Kind::Partial,
    };
    let title = format!("{} results", reports.len());
    let verdict = format!("{}.", named.join(", "));
    let body = html! {
        (section("Tensors, by result in the order of the table", places(&figures)))
        (section("Results", rows(reports, links)))
        (files(all_files))
    };
    let page = Page { title: &title, verdict: &verdict, kind, command, body, figures: &figures };
    (page.html(), figures)
}

/// Each element with whiskers, one series for each estimator.
fn elements(reports: &[LogReport]) -> Figure {
    let mut estimators: Vec<&str> = Vec::new();
    let results = || {
        let numbered = reports.iter().enumerate();
        numbered.filter_map(|(i, report)| Some((i + 1, report.result.as_ref()?)))
    };
    for (_, result) in results() {
        if !estimators.contains(&result.estimator.as_str()) {
            estimators.push(&result.estimator);
        }
    }
    let panel = |i: usize| {
        let of = |estimator: &str| {
            let is_observed =
                |r: &ReplayReport| r.observed_directions > 0 && r.status != Status::Diverged;
            let dots = results().filter(|(_, r)| r.estimator == estimator && is_observed(r));
            dots.map(|(x, r)| Dot {
                x: x as f64,
                value: r.elements_kg_m2()[i],
                reach: WHISKER_SIGMAS * r.sigma_kg_m2[i],
            })
            .collect::<Vec<_>>()
        };
        estimators.iter().enumerate().fold(
            Panel::new(format!("{}, kg m²", ELEMENT_NAMES[i])),
            |panel, (place, estimator)| {
                let colour = Colour::ALL[place % Colour::ALL.len()];
                panel.with(Series::dots(&format!("{estimator}, ±3 sigma"), colour, of(estimator)))
            },
        )
    };
    let title = "Elements of the tensor; results that diverged are left out";
    Figure::grid(title, "result", 3, (0..6).map(panel).collect()).named("data/elements")
}

fn rows(reports: &[LogReport], links: &[Option<String>]) -> Markup {
    let number = |value: f64| significant(value, DIGITS);
    html! {
        div .scroll {
            table {
                thead { tr {
                    th { "" } th .text { "log" } th .text { "estimator" } th .text { "status" } th { "samples" }
                    th { "observed" } th .text { "white" }
                    @for name in ELEMENT_NAMES { th { (name) } th { "σ" } }
                } }
                tbody {
                    @for (i, (report, link)) in reports.iter().zip(links).enumerate() {
                        tr {
                            td { (i + 1) }
                            td .text {
                                @match link {
                                    Some(link) => a href={ (link) "/report.html" } { (report.log) },
                                    None => (report.log),
                                }
                            }
                            @match &report.result {
                                Some(result) => {
                                    td .text { (result.estimator) }
                                    td .text { (result.status) }
                                    td { (result.samples) }
                                    td { (result.observed_directions) }
                                    td .text { (white(result)) }
                                    @for (element, sigma) in result.elements_kg_m2().iter().zip(&result.sigma_kg_m2) {
                                        td { (number(*element)) }
                                        td { (number(*sigma)) }
                                    }
                                }
                                None => {
                                    td .text { (report.estimator.as_deref().unwrap_or(EMPTY)) }
                                    td .text { "failed" }
                                    td .text colspan="15" { (report.error.as_deref().unwrap_or_default()) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn white(result: &ReplayReport) -> &'static str {
    match result.residuals_white {
        Some(true) => "yes",
        Some(false) => "no",
        None => EMPTY,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::report::json::examples;

    #[test]
    fn every_result_has_a_row_and_a_failed_one_its_reason() {
        let good = LogReport::of(Path::new("logs/a.csv"), examples::replay());
        let bad = LogReport::failed(Path::new("logs/b.csv"), "window", "logs/b.csv: no row");
        let links = [Some("a".to_owned()), None];
        let (html, figures) = logs(&[good, bad], &links, "host-sim replay", &[]);
        assert_eq!(figures.len(), 1);
        for words in ["1 converged, 1 failed.", "href=\"a/report.html\"", "logs/b.csv: no row"] {
            assert!(html.contains(words), "{words}");
        }
    }
}
