//! Interrupt and progress of the verbs that take long.

use std::io::{self, IsTerminal};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Exit code of an interrupted program: 128 + SIGINT.
const INTERRUPTED: i32 = 130;

/// Time between two lines of progress where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(30);

/// Flag that Ctrl-C, SIGTERM and SIGHUP set. A second signal ends the program at once, since a run may take long.
pub(super) fn stop_on_signal() -> Arc<AtomicBool> {
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

/// Note of a campaign that a signal ended early.
pub(super) fn note_if_stopped(complete: u64, requested: u64) {
    if complete < requested {
        eprintln!("note: stopped after {complete} of {requested} runs; the result is of these");
    }
}

/// Progress on stderr over a number of items: a bar on a terminal, else a line every 30 s.
pub(super) struct Progress {
    bar: ProgressBar,
    items: &'static str,
    /// Time of the last line; none on a terminal.
    last_line: Option<Mutex<Instant>>,
}

impl Progress {
    /// Of `count` items, as `"runs"`.
    pub(super) fn new(count: u64, items: &'static str) -> Self {
        if !io::stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::hidden());
            return Self { bar, items, last_line: Some(Mutex::new(Instant::now())) };
        }
        let template = format!("{{wide_bar}} {{pos}} of {{len}} {items}{{msg}}, {{eta}} left");
        let style = ProgressStyle::with_template(&template);
        let bar = ProgressBar::new(count);
        let bar = match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        Self { bar, items, last_line: None }
    }

    /// Adds items that are done.
    pub(super) fn inc(&self, count: u64) {
        self.bar.inc(count);
        self.line();
    }

    /// Items that are done, their number, and what is said beside.
    pub(super) fn set(&self, done: u64, count: u64, message: String) {
        self.bar.set_length(count);
        self.bar.set_position(done);
        self.bar.set_message(message);
        self.line();
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn line(&self) {
        let Some(mut last) = self.last_line.as_ref().and_then(|last| last.try_lock().ok()) else {
            return;
        };
        if last.elapsed() < LINE_INTERVAL {
            return;
        }
        *last = Instant::now();
        let (done, count) = (self.bar.position(), self.bar.length().unwrap_or_default());
        let left = HumanDuration(self.bar.eta());
        eprintln!("{done} of {count} {}{}, {left} left", self.items, self.bar.message());
    }
}
