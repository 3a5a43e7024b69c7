//! Outcome of one step: updated, coasting or reset, with the reason.

use crate::attitude::NoAttitude;
use crate::gate::Rejection;

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// It updated the estimate.
    Updated,
    /// The estimate stands as it was, or was only predicted.
    Coasting(Coasting),
    /// Part of the state was set anew.
    Reset(Reset),
}

/// Why a sample didn't update the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Coasting {
    /// The gate refused it.
    Rejected(Rejection),
    /// Too far from the prediction to be the gyro's noise; the state was predicted without it.
    Spike,
    /// It was taken in, but what has moved so far isn't enough for a first estimate.
    Aligning,
    /// It went into the rate, but the window of the differentiator is still filling (after a
    /// start, or because this sample came unevenly spaced): the inertia waits.
    Refilling,
    /// This estimator needs the attitude, and the sample's can't be used.
    NoAttitude(NoAttitude),
    /// This estimator starts from rest, and the body moves.
    WaitingForRest,
}

/// Why part of the state was set anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reset {
    /// The first usable sample: the rate starts from it.
    FirstSample,
    /// The motion so far gave a first estimate of the inertia; the filter starts from it.
    Aligned,
    /// Too long without samples to predict across: the rate starts anew, the inertia stays.
    Gap,
    /// So many spikes in a row that it is the estimate that must be wrong (a deployment, a
    /// docking): all starts anew from the motion, and no prior is believed any more.
    Lockout,
    /// A manoeuvre's data contradict, by a chi-square test, what was known of the inertia before
    /// it (a prior, or earlier manoeuvres): that is dropped.
    Changed,
    /// The state left the finite numbers, or its inertia had no inverse: all starts anew.
    Diverged,
}

crate::persist!([] enum Reset {
    0 => FirstSample, 1 => Aligned, 2 => Gap, 3 => Lockout, 4 => Changed, 5 => Diverged
});

impl Outcome {
    /// What and why, in a word or two: for logs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Updated => "updated",
            Self::Coasting(Coasting::Rejected(why)) => why.name(),
            Self::Coasting(Coasting::Spike) => "spike",
            Self::Coasting(Coasting::Aligning) => "aligning",
            Self::Coasting(Coasting::Refilling) => "refilling",
            Self::Coasting(Coasting::NoAttitude(why)) => why.name(),
            Self::Coasting(Coasting::WaitingForRest) => "waiting_for_rest",
            Self::Reset(Reset::FirstSample) => "reset_first_sample",
            Self::Reset(Reset::Aligned) => "reset_aligned",
            Self::Reset(Reset::Gap) => "reset_gap",
            Self::Reset(Reset::Lockout) => "reset_lockout",
            Self::Reset(Reset::Changed) => "reset_changed",
            Self::Reset(Reset::Diverged) => "reset_diverged",
        }
    }

    /// Whether the sample was made use of.
    pub fn used_sample(&self) -> bool {
        match self {
            Self::Updated | Self::Reset(_) => true,
            Self::Coasting(Coasting::Aligning | Coasting::Refilling) => true,
            Self::Coasting(
                Coasting::Rejected(_)
                | Coasting::Spike
                | Coasting::NoAttitude(_)
                | Coasting::WaitingForRest,
            ) => false,
        }
    }
}
