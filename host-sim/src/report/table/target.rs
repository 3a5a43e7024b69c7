//! Table of `pil`: the estimate of the firmware, and its comparison with the host.

use super::cells::heading;
use super::estimate::run;
use crate::report::json::{PilReport, TargetReport};

/// Table of a flight of the firmware: the table of `run` below the comparison.
pub fn pil(report: &PilReport) -> String {
    let TargetReport { identical_samples, restarted_at, stack_high_water_bytes, wall_s } =
        report.target;
    let compared =
        format!("{identical_samples} samples, bitwise identical to the host; {wall_s:.1} s");
    let power_cut = restarted_at.map_or(String::new(), |samples| {
        let resumed = format!("after {samples} samples; resumed from the checkpoint in flash");
        heading("power cut", &resumed)
    });
    heading("target", &compared)
        + &power_cut
        + &heading("stack", &format!("{stack_high_water_bytes} bytes at most"))
        + &run(&report.run)
}
