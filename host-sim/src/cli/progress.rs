//! Interrupt and progress bar of the verbs that take long.

use std::io::{self, IsTerminal};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

/// Exit code of an interrupted program: 128 + SIGINT.
const INTERRUPTED: i32 = 130;

/// Flag that Ctrl-C sets. A second Ctrl-C ends the program at once, since a run may take long.
pub(super) fn stop_on_ctrl_c() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            process::exit(INTERRUPTED);
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        eprintln!("note: Ctrl-C ends this program without a result ({error})");
    }
    stop
}

/// Note of a campaign that Ctrl-C ended early.
pub(super) fn note_if_stopped(complete: u64, requested: u64) {
    if complete < requested {
        eprintln!("note: stopped after {complete} of {requested} runs; the result is of these");
    }
}

/// Progress bar on stderr over `count` items; hidden unless stderr is a terminal.
pub(super) fn progress_bar(count: u64, items: &str) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = format!("{{wide_bar}} {{pos}} of {{len}} {items}{{msg}}, {{eta}} left");
    let style = ProgressStyle::with_template(&template);
    let bar = ProgressBar::new(count);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
