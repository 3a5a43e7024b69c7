//! Flights with a flipped bit in processes of their own, so that an abort, a fault or a hang ends a process and is
//! counted.

use std::fmt;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};

use super::Effect;

/// Time without the end of a flight after which it hangs: a hundred times a flight with all of its work.
const HANG: Duration = Duration::from_secs(20);

/// Number of flights by effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// By [`Effect`], in the order of [`Effect::ALL`].
    pub by_effect: [u64; Effect::ALL.len()],
    /// The process ended: a fault of the processor or an abort.
    pub crashed: u64,
    /// The flight did not end in time.
    pub hung: u64,
}

impl Tally {
    /// Number of flights.
    pub fn flights(&self) -> u64 {
        self.by_effect.iter().sum::<u64>() + self.crashed + self.hung
    }

    fn add(&mut self, other: &Self) {
        for (sum, more) in self.by_effect.iter_mut().zip(other.by_effect) {
            *sum += more;
        }
        self.crashed += other.crashed;
        self.hung += other.hung;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [harmless, detected, silent, panicked] = self.by_effect;
        let Self { crashed, hung, .. } = self;
        write!(f, "{:>8} flights: {harmless:>8} harmless {detected:>7} detected", self.flights())?;
        let share = 100.0 * silent as f64 / self.flights().max(1) as f64;
        write!(f, " {silent:>6} silent ({share:.3} %) {panicked:>6} panics {crashed:>5} crashes")?;
        write!(f, " {hung:>4} hangs")
    }
}

/// The runs of one worker: `first..last`.
#[derive(Clone, Copy, Debug)]
pub struct Runs {
    /// First run.
    pub first: u64,
    /// Run after the last one.
    pub last: u64,
}

/// Flies `runs` in `threads` processes at a time. `command` is the worker without its runs; `show` is called with
/// each run whose code is not that of a harmless or detected one.
///
/// # Errors
/// A worker that cannot be started.
pub fn fly(
    command: impl Fn(Runs) -> Command + Sync,
    runs: Runs,
    threads: u64,
    show: impl Fn(u64, &str) + Sync,
) -> Result<Tally> {
    let share = (runs.last - runs.first).div_ceil(threads.max(1));
    let parts = (0..threads.max(1)).map(|i| Runs {
        first: (runs.first + i * share).min(runs.last),
        last: (runs.first + (i + 1) * share).min(runs.last),
    });
    let (command, show) = (&command, &show);
    thread::scope(|scope| {
        let workers: Vec<_> =
            parts.map(|part| scope.spawn(move || fly_part(command, part, show))).collect();
        let mut tally = Tally::default();
        for worker in workers {
            tally.add(&worker.join().ok().context("a thread of the campaign panicked")??);
        }
        Ok(tally)
    })
}

/// Flies the runs of one thread: a new process after each that ended or hung.
fn fly_part(
    command: &(impl Fn(Runs) -> Command + Sync),
    runs: Runs,
    show: &(impl Fn(u64, &str) + Sync),
) -> Result<Tally> {
    let (mut tally, mut next) = (Tally::default(), runs.first);
    while next < runs.last {
        let mut child = command(Runs { first: next, last: runs.last })
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("starting a worker")?;
        let end = listen(&mut child, &mut tally, &mut next, show)?;
        let status = child.wait()?;
        if next < runs.last {
            let counter = if end == End::Hung { &mut tally.hung } else { &mut tally.crashed };
            *counter += 1;
            show(next, &format!("{end:?}, {status}"));
            next += 1;
        }
    }
    Ok(tally)
}

/// End of a worker's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Closed,
    Hung,
}

/// Counts the codes of a worker, a line each, until its output ends.
fn listen(
    child: &mut Child,
    tally: &mut Tally,
    next: &mut u64,
    show: &impl Fn(u64, &str),
) -> Result<End> {
    let lines = lines(child)?;
    loop {
        match lines.recv_timeout(HANG) {
            Ok(code) => {
                let place = Effect::ALL.iter().position(|effect| effect.code() == code);
                // Any other line is the one before each flight or after the clean one.
                let Some(place) = place else { continue };
                tally.by_effect[place] += 1;
                if place > 1 {
                    show(*next, &code);
                }
                *next += 1;
            }
            Err(RecvTimeoutError::Disconnected) => return Ok(End::Closed),
            Err(RecvTimeoutError::Timeout) => {
                child.kill()?;
                return Ok(End::Hung);
            }
        }
    }
}

fn lines(child: &mut Child) -> Result<Receiver<String>> {
    let output = child.stdout.take().context("output of a worker")?;
    let (sender, receiver) = channel();
    thread::spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    Ok(receiver)
}
