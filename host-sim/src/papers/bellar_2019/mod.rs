//! \[Bellar2019\]: the nine-state filter, one flight and a Monte Carlo campaign.
//!
//! ```text
//! trial    one seed: the flight of Table 3, and a run of the campaign by five filters
//! tables   Table 3, the figures of the text, the campaign
//! figures  Figures 1 to 8
//! ```

mod figures;
mod tables;
mod trial;

use super::paper::{Paper, PapersFailed};
use crate::report::published::{PaperFigure, PublishedTable};
pub use trial::Bellar2019;
use trial::{Bellar2019Trial, CAMPAIGN};

impl Paper for Bellar2019 {
    type Trial = Bellar2019Trial;

    const KEY: &'static str = "Bellar2019";

    fn load() -> Result<Self, PapersFailed> {
        Self::simulate()
    }

    fn fly(&self, seed: u64) -> Result<Bellar2019Trial, PapersFailed> {
        Ok(self.trial(seed)?)
    }

    fn tables(&self, trials: &[Bellar2019Trial]) -> Vec<PublishedTable> {
        let campaign = (0..CAMPAIGN.len()).map(|method| self.monte_carlo(method, trials));
        [self.table_3(trials), self.text(trials)].into_iter().chain(campaign).collect()
    }

    fn figures(
        &self,
        first_seed: u64,
        trials: &[Bellar2019Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed> {
        self.all_figures(first_seed, trials)
    }
}
