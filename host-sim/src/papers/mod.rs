//! Reproduction of the published systems on their own scenarios.
//!
//! Input: a first seed and a number of runs. Output: a [`TablesReport`] with the published values
//! beside the reproduced ones, and a counterpart of each published figure.
//!
//! ```text
//!  kim_2010 ──────┐
//!  kim_2013 ──────┤ Paper: scenarios, published values,
//!  kim_2016 ──────┼─► one trial per seed, tables, figures
//!  bellar_2019 ───┤        │
//!  elhariry_2026 ─┘        └─► Papers::fly, seed by seed ─► Reproduction ─► report
//! ```
//!
//! A new paper is a file with an implementation of [`Paper`] and a line in `roster`.
//!
//! A seed flies every paper, so that all tables of an interrupted run have the same number of
//! trials. The seeds are spread over rayon's threads and the trials are sorted by seed: the result
//! does not depend on the number of threads.

mod bellar_2019;
mod case;
pub mod distribution;
pub(crate) mod elhariry_2026;
mod kim_2010;
mod kim_2013;
mod kim_2016;
mod paper;
mod rank_test;
mod table;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::iter::{ParallelBridge, ParallelIterator};

use crate::report::TablesReport;
use crate::report::published::{PaperFigure, PublishedTable};
pub use paper::{Paper, PapersFailed};

/// Every paper, in the order of the report.
fn roster() -> Result<Vec<Box<dyn AnyPaper>>, PapersFailed> {
    Ok(vec![
        Entry::<kim_2010::Kim2010>::load()?,
        Entry::<kim_2013::Kim2013>::load()?,
        Entry::<kim_2016::Kim2016>::load()?,
        Entry::<bellar_2019::Bellar2019>::load()?,
        Entry::<elhariry_2026::ElHariry2026>::load()?,
    ])
}

/// Every paper of the roster, with the true motion of its scenarios.
pub struct Papers {
    entries: Vec<Box<dyn AnyPaper>>,
}

/// Every paper with its trials, in the order of the seeds.
pub struct Reproduction {
    entries: Vec<Box<dyn AnyPaper>>,
    first_seed: u64,
    runs: u64,
}

impl Papers {
    /// Simulates the true motion of all scenarios.
    ///
    /// # Errors
    /// A scenario that cannot be read or integrated.
    pub fn load() -> Result<Self, PapersFailed> {
        Ok(Self { entries: roster()? })
    }

    /// Flies `runs` seeds from `first_seed` on all of rayon's threads. `done` is called after each.
    ///
    /// Once `stop` is set, no further seed is begun. Seeds are begun in ascending order and each
    /// one that was begun is completed: an interrupted run equals a shorter one.
    ///
    /// # Errors
    /// The first trial that failed.
    pub fn fly(
        self,
        first_seed: u64,
        runs: u64,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<Reproduction, PapersFailed> {
        let mut entries = self.entries;
        let fly_seed = |index: u64| {
            let seed = first_seed.wrapping_add(index);
            let flown = entries.iter().try_for_each(|entry| entry.fly(index, seed));
            done();
            flown.map(|()| 1)
        };
        let runs = (0..runs)
            .take_while(|_| !stop.load(Ordering::Relaxed))
            .par_bridge()
            .map(fly_seed)
            .try_reduce(|| 0, |sum, one| Ok(sum + one))?;
        entries.iter_mut().for_each(|entry| entry.complete());
        Ok(Reproduction { entries, first_seed, runs })
    }
}

impl Reproduction {
    /// Number of seeds flown.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// All tables.
    pub fn tables(&self) -> TablesReport {
        let tables = self.entries.iter().flat_map(|entry| entry.tables()).collect();
        TablesReport { runs: self.runs, seed: self.first_seed, tables }
    }

    /// All figures.
    ///
    /// # Errors
    /// An estimator that rejects its configuration.
    pub fn figures(&self) -> Result<Vec<PaperFigure>, PapersFailed> {
        let mut figures = Vec::new();
        for entry in &self.entries {
            figures.extend(entry.figures(self.first_seed)?);
        }
        Ok(figures)
    }
}

/// A [`Paper`] behind an object-safe interface.
trait AnyPaper: Send + Sync {
    /// Flies a seed. The trial is stored under `index`.
    fn fly(&self, index: u64, seed: u64) -> Result<(), PapersFailed>;

    /// Sorts the trials by index.
    fn complete(&mut self);

    /// Tables over the sorted trials.
    fn tables(&self) -> Vec<PublishedTable>;

    /// Figures over the sorted trials.
    fn figures(&self, first_seed: u64) -> Result<Vec<PaperFigure>, PapersFailed>;
}

/// A paper and its trials.
struct Entry<P: Paper> {
    paper: P,
    /// Index and trial, in the order in which the threads completed them.
    unsorted: Mutex<Vec<(u64, P::Trial)>>,
    /// In the order of the seeds.
    trials: Vec<P::Trial>,
}

impl<P: Paper + 'static> Entry<P> {
    fn load() -> Result<Box<dyn AnyPaper>, PapersFailed> {
        let paper = P::load()?;
        Ok(Box::new(Self { paper, unsorted: Mutex::default(), trials: Vec::new() }))
    }
}

impl<P: Paper> AnyPaper for Entry<P> {
    fn fly(&self, index: u64, seed: u64) -> Result<(), PapersFailed> {
        let trial = self.paper.fly(seed)?;
        self.unsorted.lock().unwrap_or_else(PoisonError::into_inner).push((index, trial));
        Ok(())
    }

    fn complete(&mut self) {
        let unsorted = self.unsorted.get_mut().unwrap_or_else(PoisonError::into_inner);
        unsorted.sort_unstable_by_key(|(index, _)| *index);
        self.trials = unsorted.drain(..).map(|(_, trial)| trial).collect();
    }

    fn tables(&self) -> Vec<PublishedTable> {
        self.paper.tables(&self.trials)
    }

    fn figures(&self, first_seed: u64) -> Result<Vec<PaperFigure>, PapersFailed> {
        self.paper.figures(first_seed, &self.trials)
    }
}
