//! Fuzzes a target, or all of them in turn.
//!
//! ```text
//! cargo run -p tests --bin fuzz -- --seconds 8                             a minute: all targets
//! cargo run -p tests --bin fuzz -- --seconds 514                           an hour
//! cargo run -p tests --bin fuzz -- --target step --executions 10000000
//! cargo run -p tests --bin fuzz -- --target step --case 12345              a finding again, with its panic
//! ```
//!
//! The profile `dev` is optimised and has overflow checks and debug assertions. A finding is printed with its case, and
//! the exit status is then 1.

use std::io::{Write, stderr, stdout};
use std::panic::set_hook;
use std::process::{ExitCode, exit};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Parser;
use tests::fuzz::Target;

/// Duration of a case above which it hangs: a thousand times that of the slowest one, for a busy machine.
const HANG: Duration = Duration::from_secs(300);
/// Findings of a target after which it ends.
const MOST_FINDINGS: usize = 10;

/// Feed random input to everything that reads.
#[derive(Debug, Parser)]
struct Arguments {
    /// This target only.
    #[arg(long, value_enum)]
    target: Option<Target>,
    /// Seconds for each target.
    #[arg(long, default_value_t = 8)]
    seconds: u64,
    /// Executions of each target, in place of a duration.
    #[arg(long)]
    executions: Option<u64>,
    /// First case.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// This case only.
    #[arg(long)]
    case: Option<u64>,
    /// Threads.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

/// Cases of one target, shared by the threads.
struct Session {
    target: Target,
    next: AtomicU64,
    executions: AtomicU64,
    findings: Mutex<Vec<String>>,
    /// Case and begin of each thread's execution.
    running: Vec<Mutex<Option<(u64, Instant)>>>,
    slowest: Mutex<(Duration, u64)>,
    has_ended: AtomicBool,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let targets = arguments.target.map_or(Target::ALL.to_vec(), |target| vec![target]);
    if let Some(case) = arguments.case {
        for target in targets {
            writeln!(stdout(), "{target:?} case {case}: {:?}", target.execute(case))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    set_hook(Box::new(|_| {}));
    let mut is_clean = true;
    for target in targets {
        is_clean &= fuzz(&arguments, target)?;
    }
    Ok(if is_clean { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Fuzzes one target and prints its row; true without a finding.
fn fuzz(arguments: &Arguments, target: Target) -> Result<bool> {
    let begun = Instant::now();
    let session = Session {
        target,
        next: AtomicU64::new(arguments.first),
        executions: AtomicU64::new(0),
        findings: Mutex::default(),
        running: (0..arguments.threads).map(|_| Mutex::default()).collect(),
        slowest: Mutex::default(),
        has_ended: AtomicBool::new(false),
    };
    let shared = &session;
    thread::scope(|scope| {
        let workers: Vec<_> = (0..arguments.threads)
            .map(|thread| scope.spawn(move || shared.work(thread, arguments, begun)))
            .collect();
        scope.spawn(|| session.watch());
        for worker in workers {
            let _ = worker.join();
        }
        session.has_ended.store(true, Ordering::Relaxed);
    });
    let findings = session.findings.into_inner().unwrap_or_default();
    for finding in &findings {
        writeln!(stdout(), "{finding}")?;
    }
    let (slowest, case) = session.slowest.into_inner().unwrap_or_default();
    let cases = session.next.into_inner() - arguments.first;
    writeln!(
        stdout(),
        "{:<10} {cases:>9} cases {:>11} executions {:>3} findings, slowest {:.2} s (case {case}), {:.0} s",
        format!("{target:?}").to_lowercase(),
        session.executions.into_inner(),
        findings.len(),
        slowest.as_secs_f64(),
        begun.elapsed().as_secs_f64(),
    )?;
    Ok(findings.is_empty())
}

impl Session {
    /// Executes cases until the time or the number is reached.
    fn work(&self, thread: usize, arguments: &Arguments, begun: Instant) {
        let is_due = || match arguments.executions {
            Some(most) => self.executions.load(Ordering::Relaxed) < most,
            None => begun.elapsed() < Duration::from_secs(arguments.seconds),
        };
        while is_due() && self.findings().len() < MOST_FINDINGS {
            let case = self.next.fetch_add(1, Ordering::Relaxed);
            let started = Instant::now();
            self.set_running(thread, Some((case, started)));
            let executed = self.target.execute(case);
            self.set_running(thread, None);
            let duration = started.elapsed();
            if let Ok(mut slowest) = self.slowest.lock() {
                *slowest = (*slowest).max((duration, case));
            }
            match executed {
                Ok(executions) => drop(self.executions.fetch_add(executions, Ordering::Relaxed)),
                Err(why) => self.findings().push(format!("{:?} case {case}: {why}", self.target)),
            }
        }
    }

    /// Ends the process where a case hangs.
    fn watch(&self) {
        while !self.has_ended.load(Ordering::Relaxed) {
            thread::sleep(Duration::from_millis(100));
            for place in &self.running {
                let running = place.lock().map_or(None, |running| *running);
                if let Some((case, started)) = running
                    && started.elapsed() > HANG
                {
                    let _ = writeln!(stderr(), "{:?} case {case}: hangs", self.target);
                    exit(1);
                }
            }
        }
    }

    fn set_running(&self, thread: usize, running: Option<(u64, Instant)>) {
        if let Some(Ok(mut place)) = self.running.get(thread).map(Mutex::lock) {
            *place = running;
        }
    }

    fn findings(&self) -> std::sync::MutexGuard<'_, Vec<String>> {
        self.findings.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
