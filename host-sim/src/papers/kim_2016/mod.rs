//! \[Kim2016\]: rate filter, Savitzky-Golay derivative over six samples, batch least squares.
//!
//! The numbers of Tables 3 and 4 were lost in printing. Tables 5 and 6 are reproduced. The paper
//! calls its polynomial quartic and prints the weights of a parabola (Table 2, Eq. (10)): Table 5 is
//! computed with both.
//!
//! ```text
//! trial    flight of one seed, error of the derivative
//! tables   Tables 5 and 6
//! figures  Figures 1 to 5
//! ```

mod figures;
mod tables;
mod trial;

use super::case::Case;
use super::paper::{Paper, PapersFailed};
use crate::report::plots::flight::true_accelerations;
use crate::report::published::{PaperFigure, PublishedTable};
pub use trial::Kim2016;
use trial::Kim2016Trial;

impl Paper for Kim2016 {
    type Trial = Kim2016Trial;

    const KEY: &'static str = "Kim2016";

    fn load() -> Result<Self, PapersFailed> {
        let case = Case::load("kim-2016")?;
        let truth_rad_s2 = true_accelerations(&case.flight.instants).collect();
        Ok(Self { case, truth_rad_s2 })
    }

    fn fly(&self, seed: u64) -> Result<Kim2016Trial, PapersFailed> {
        Ok(self.trial(seed)?)
    }

    fn tables(&self, trials: &[Kim2016Trial]) -> Vec<PublishedTable> {
        vec![self.table_5(trials), self.table_6(trials)]
    }

    fn figures(
        &self,
        first_seed: u64,
        trials: &[Kim2016Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        self.all_figures(first_seed, trials)
    }
}
