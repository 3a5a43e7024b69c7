//! The published systems on their own scenarios: what was printed, and what comes out here.
//!
//! ```text
//!  kim_2010 ─┐ published values, the study that flies a seed,
//!  kim_2013 ─┤ the rows, the figures
//!  kim_2016 ─┼──► Papers::fly, all of them seed by seed ──► TablesReport, figures ──► report
//!  bellar_2019
//!  elhariry_2026 (another's benchmark)
//! ```
//!
//! A seed flies every study, so that an early end leaves all tables with the same runs. Seeds are
//! spread over rayon's threads and put back in order: the numbers are the same however many there
//! are.

mod bellar_2019;
mod course;
pub mod distribution;
mod elhariry_2026;
mod kim_2010;
mod kim_2013;
mod kim_2016;
mod observability;
mod row;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::iter::{ParallelBridge, ParallelIterator};
use thiserror::Error;

use crate::campaign::RunFailed;
use crate::estimation::SetUpError;
use crate::input::InputError;
use crate::report::TablesReport;
use crate::report::papers_dir::PaperFigure;
use crate::report::plots::PlotError;
use crate::truth::IntegrationFailed;

/// A study could not be set up, flown or drawn.
#[derive(Debug, Error)]
pub enum PapersFailed {
    /// A built-in scenario.
    #[error(transparent)]
    Scenario(#[from] InputError),
    /// Its truth.
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
    /// An estimator.
    #[error(transparent)]
    SetUp(#[from] SetUpError),
    /// A run of a campaign.
    #[error(transparent)]
    Run(#[from] RunFailed),
    /// A figure.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// Every study, its truths simulated.
pub struct Papers {
    kim_2010: kim_2010::Study,
    kim_2013: kim_2013::Study,
    kim_2016: kim_2016::Study,
    bellar_2019: bellar_2019::Study,
    elhariry_2026: elhariry_2026::Study,
}

/// What the seeds gave, in their order.
pub struct Flown {
    first_seed: u64,
    kim_2010: Vec<kim_2010::Run>,
    kim_2013: Vec<kim_2013::Run>,
    kim_2016: Vec<kim_2016::Run>,
    bellar_2019: Vec<bellar_2019::Run>,
    elhariry_2026: Vec<elhariry_2026::Run>,
}

struct OneSeed {
    kim_2010: kim_2010::Run,
    kim_2013: kim_2013::Run,
    kim_2016: kim_2016::Run,
    bellar_2019: bellar_2019::Run,
    elhariry_2026: elhariry_2026::Run,
}

impl Papers {
    /// Simulates all truths.
    pub fn new() -> Result<Self, PapersFailed> {
        Ok(Self {
            kim_2010: kim_2010::Study::new()?,
            kim_2013: kim_2013::Study::new()?,
            kim_2016: kim_2016::Study::new()?,
            bellar_2019: bellar_2019::Study::new()?,
            elhariry_2026: elhariry_2026::Study::new()?,
        })
    }

    /// Flies so many seeds from the first on, on all of rayon's threads, and calls `done` after each.
    ///
    /// Once `stop` is set no further seed is begun. Seeds are begun in order and those begun are
    /// completed, so what comes back is what fewer of them would have given.
    pub fn fly(
        &self,
        first_seed: u64,
        runs: u64,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<Flown, PapersFailed> {
        let fly_one = |index: u64| {
            let one = self.one(first_seed.wrapping_add(index)).map(|one| (index, one));
            done();
            one
        };
        let mut all: Vec<(u64, OneSeed)> = (0..runs)
            .take_while(|_| !stop.load(Ordering::Relaxed))
            .par_bridge()
            .map(fly_one)
            .collect::<Result<_, _>>()?;
        all.sort_unstable_by_key(|(index, _)| *index);
        let mut flown = Flown {
            first_seed,
            kim_2010: Vec::new(),
            kim_2013: Vec::new(),
            kim_2016: Vec::new(),
            bellar_2019: Vec::new(),
            elhariry_2026: Vec::new(),
        };
        for (_, one) in all {
            flown.kim_2010.push(one.kim_2010);
            flown.kim_2013.push(one.kim_2013);
            flown.kim_2016.push(one.kim_2016);
            flown.bellar_2019.push(one.bellar_2019);
            flown.elhariry_2026.push(one.elhariry_2026);
        }
        Ok(flown)
    }

    fn one(&self, seed: u64) -> Result<OneSeed, PapersFailed> {
        Ok(OneSeed {
            kim_2010: self.kim_2010.fly(seed)?,
            kim_2013: self.kim_2013.fly(seed)?,
            kim_2016: self.kim_2016.fly(seed)?,
            bellar_2019: self.bellar_2019.fly(seed)?,
            elhariry_2026: self.elhariry_2026.fly(seed)?,
        })
    }

    /// All tables.
    pub fn tables(&self, flown: &Flown) -> TablesReport {
        let mut tables = self.kim_2010.tables(&flown.kim_2010);
        tables.extend(self.kim_2013.tables(&flown.kim_2013));
        tables.extend(self.kim_2016.tables(&flown.kim_2016));
        tables.extend(self.bellar_2019.tables(&flown.bellar_2019));
        tables.extend(self.elhariry_2026.tables(&flown.elhariry_2026));
        TablesReport { runs: flown.runs(), seed: flown.first_seed, tables }
    }

    /// All figures.
    pub fn figures(&self, flown: &Flown) -> Result<Vec<PaperFigure>, PapersFailed> {
        let seed = flown.first_seed;
        let mut figures = self.kim_2010.figures(&flown.kim_2010)?;
        figures.extend(self.kim_2013.figures(seed)?);
        figures.extend(self.kim_2016.figures(seed, &flown.kim_2016)?);
        figures.extend(self.bellar_2019.figures(seed, &flown.bellar_2019)?);
        Ok(figures)
    }
}

impl Flown {
    /// How many seeds were flown.
    pub fn runs(&self) -> u64 {
        self.kim_2013.len() as u64
    }
}

fn figure(paper: &'static str, file: &str, svg: String) -> PaperFigure {
    PaperFigure { paper, file: file.to_owned(), svg }
}
