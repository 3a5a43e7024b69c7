//! The field campaigns in their small version. Campaigns whose limits hold are asserted; `cargo run
//! --release -p tests --bin field` flies all of them, with the listed number of runs.

#![allow(clippy::unwrap_used, reason = "a test that cannot continue fails")]

use std::collections::HashSet;

use tests::field::campaigns::all;
use tests::field::figures::Figures;
use tests::field::flying::fly_all;
use tests::field::motion::Library;
use tests::field::table;

#[test]
fn names_of_campaigns_are_unique() {
    let campaigns = all().unwrap();
    let names: HashSet<&str> = campaigns.iter().map(|campaign| campaign.name.as_str()).collect();
    assert_eq!(names.len(), campaigns.len());
}

/// Flies the small version of every campaign whose limits hold.
#[test]
fn held_limits_hold() {
    let mut library = Library::default();
    let mut missed = Vec::new();
    println!("{}", table::head());
    for campaign in all().unwrap().iter().filter(|campaign| campaign.held && campaign.small > 0) {
        for precision in campaign.precisions {
            let runs = fly_all(campaign, *precision, &mut library, 0, campaign.small).unwrap();
            let figures = Figures::of(&runs);
            let row = table::row(campaign, *precision, &figures);
            println!("{row}");
            if !figures.missed(campaign).is_empty() {
                missed.push(row);
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
