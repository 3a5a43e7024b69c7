//! An image in QEMU: decoded log and exit status.
//!
//! The image logs by defmt on the first serial port and ends by semihosting, as QEMU's exit status. A
//! time limit ends every other run.

use crate::cycles::Trace;
use crate::image::{self, BoardTest};
use anyhow::{Context, Result, bail};
use defmt_decoder::{DecodeError, StreamDecoder, Table};
use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// QEMU machine with an STM32F405.
pub const MACHINE: &str = "netduinoplus2";

/// QEMU program.
pub(crate) const QEMU: &str = "qemu-system-arm";

/// Result of a run.
#[derive(Debug, Clone)]
pub struct Run {
    /// Log lines, without levels.
    pub lines: Vec<String>,
    /// True if the image reported success.
    pub success: bool,
}

/// Runs the image `elf` on `machine` to its end, or to the time `limit`, which is an error. Passes
/// each log line to `on_line` as it arrives.
pub fn run(elf: &Path, machine: &str, limit: Duration, on_line: impl FnMut(&str)) -> Result<Run> {
    run_with(elf, machine, &[], limit, on_line, None)
}

/// As [`run`], with 256 ns of virtual time per instruction: a timer of the machine then counts
/// instructions, exactly and reproducibly.
pub fn run_counting(
    elf: &Path,
    machine: &str,
    limit: Duration,
    on_line: impl FnMut(&str),
) -> Result<Run> {
    run_with(elf, machine, &COUNTING, limit, on_line, None)
}

/// As [`run_counting`], with an execution trace, read by `trace`: about a microsecond per block.
pub fn run_tracing(elf: &Path, machine: &str, limit: Duration, trace: &mut Trace) -> Result<Run> {
    let options = [&COUNTING[..], &["-d", "in_asm,exec,nochain"]].concat();
    run_with(elf, machine, &options, limit, |_| {}, Some(trace))
}

/// Runs one test of the image `elf`, built with embedded-test, as `probe-rs run` does on a board: the command line of
/// semihosting names the function, and a fresh machine stands for the reset.
pub fn run_test(elf: &Path, machine: &str, limit: Duration, test: &BoardTest) -> Result<Run> {
    let command = format!("arg=run_addr,arg={}", test.address);
    let options = ["-semihosting-config", &format!("enable=on,target=native,{command}")];
    run_with(elf, machine, &options, limit, |_| {}, None)
}

const COUNTING: [&str; 2] = ["-icount", "shift=8"];

fn run_with(
    elf: &Path,
    machine: &str,
    options: &[&str],
    limit: Duration,
    mut on_line: impl FnMut(&str),
    trace: Option<&mut Trace>,
) -> Result<Run> {
    let image = image::read(elf)?;
    let table = Table::parse(&image)?
        .with_context(|| format!("{} has no defmt log table", elf.display()))?;
    let mut decoder = table.new_stream_decoder();

    let errors = if trace.is_some() { Stdio::piped() } else { Stdio::inherit() };
    let (mut qemu, serial) = start(elf, machine, options, errors)?;
    let chunks = read_in_background(serial);

    let mut lines = Vec::new();
    std::thread::scope(|scope| {
        let reading = trace
            .zip(qemu.stderr.take())
            .map(|(trace, log)| scope.spawn(|| trace.read(BufReader::new(log))));
        let received = receive(&chunks, limit, |chunk| {
            decoder.received(chunk);
            for line in decode(decoder.as_mut()) {
                on_line(&line);
                lines.push(line);
            }
        });
        if received.is_err() {
            stop(&mut qemu)?;
            return received;
        }
        if let Some(Ok(read)) = reading.map(|reading| reading.join()) {
            read?;
        }
        Ok(())
    })?;
    let status: ExitStatus = qemu.wait().context("waiting for QEMU failed")?;
    Ok(Run { lines, success: status.success() })
}

/// Starts QEMU with the first serial port on a pipe.
fn start(
    elf: &Path,
    machine: &str,
    options: &[&str],
    errors: Stdio,
) -> Result<(Child, ChildStdout)> {
    let mut child = Command::new(QEMU)
        .args(["-machine", machine, "-display", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(options)
        .args(["-serial", "stdio", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(errors)
        .spawn()
        .with_context(|| {
            format!("cannot start {QEMU}: install it (Debian: apt-get install {QEMU})")
        })?;
    let serial = child.stdout.take().context("the serial port of QEMU is not connected")?;
    Ok((child, serial))
}

/// Reads on a thread, so that waiting for a chunk can time out.
fn read_in_background(mut serial: ChildStdout) -> Receiver<Vec<u8>> {
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        let mut buffer = [0; 4096];
        while let Ok(count @ 1..) = serial.read(&mut buffer) {
            if sender.send(buffer[..count].to_vec()).is_err() {
                break;
            }
        }
    });
    receiver
}

/// Passes the chunks to `take` until the sender ends, or fails after `limit`.
fn receive(chunks: &Receiver<Vec<u8>>, limit: Duration, mut take: impl FnMut(&[u8])) -> Result<()> {
    let deadline = Instant::now() + limit;
    loop {
        match chunks.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(chunk) => take(&chunk),
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {
                bail!("the image did not end within {} s", limit.as_secs())
            }
        }
    }
}

/// Complete log lines received. A corrupt frame becomes a line of its own.
fn decode(decoder: &mut dyn StreamDecoder) -> Vec<String> {
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(frame.display_message().to_string()),
            Err(DecodeError::UnexpectedEof) => return lines,
            Err(DecodeError::Malformed) => lines.push("(broken log frame)".into()),
        }
    }
}

fn stop(qemu: &mut Child) -> Result<()> {
    qemu.kill().context("stopping QEMU failed")?;
    qemu.wait().context("waiting for QEMU failed")?;
    Ok(())
}
