//! Interface of a published system, and the errors of its reproduction.

use thiserror::Error;

use crate::campaign::RunFailed;
use crate::estimation::SetUpError;
use crate::input::InputError;
use crate::report::plots::Figure;
use crate::report::published::folder::folder_name;
use crate::report::published::{PaperFigure, PublishedTable};
use crate::truth::IntegrationFailed;

/// A published system: its scenarios, its estimators, its tables and its figures.
pub trait Paper: Sized + Send + Sync {
    /// Results of all estimators of the paper for one seed.
    type Trial: Send + Sync;

    /// Key in the bibliography, as `Kim2010`.
    const KEY: &'static str;

    /// Simulates the true motion of the paper's scenarios.
    ///
    /// # Errors
    /// A scenario that cannot be read or integrated.
    fn load() -> Result<Self, PapersFailed>;

    /// Flies all estimators of the paper on the noise of one seed.
    ///
    /// # Errors
    /// An estimator that rejects its configuration.
    fn fly(&self, seed: u64) -> Result<Self::Trial, PapersFailed>;

    /// The paper's tables: published values beside the statistics of the trials.
    fn tables(&self, trials: &[Self::Trial]) -> Vec<PublishedTable>;

    /// Counterparts of the paper's figures. Time histories are those of `first_seed`.
    ///
    /// # Errors
    /// An estimator that rejects its configuration.
    fn figures(
        &self,
        first_seed: u64,
        trials: &[Self::Trial],
    ) -> Result<Vec<PaperFigure>, PapersFailed>;

    /// A figure of this paper: its name, as that of its file.
    fn figure(name: &str, figure: Figure) -> PaperFigure {
        let folder = folder_name(Self::KEY);
        PaperFigure { paper: Self::KEY, figure: figure.named(format!("{folder}/{name}")) }
    }
}

/// A reproduction failed.
#[derive(Debug, Error)]
pub enum PapersFailed {
    /// A built-in scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] InputError),
    /// The true motion of a scenario cannot be integrated.
    #[error(transparent)]
    Integration(#[from] IntegrationFailed),
    /// An estimator rejects its configuration.
    #[error(transparent)]
    SetUp(#[from] SetUpError),
    /// A run of a campaign failed.
    #[error(transparent)]
    Run(#[from] RunFailed),
}
