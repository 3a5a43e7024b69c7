//! An image in QEMU: its log, decoded, and its status.
//!
//! The image logs by defmt on the first serial port and ends by semihosting, which becomes QEMU's
//! exit status. A run that doesn't end is ended after a time limit.

use crate::cycles::Trace;
use anyhow::{Context, Result, bail};
use defmt_decoder::{DecodeError, StreamDecoder, Table};
use std::io::{BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// The QEMU machine that has the flight computer's chip, an STM32F405.
pub const MACHINE: &str = "netduinoplus2";

/// A program that emulates the chip.
pub(crate) const QEMU: &str = "qemu-system-arm";

/// What an image said, and how it ended.
#[derive(Debug, Clone)]
pub struct Run {
    /// The lines of its log, without levels.
    pub lines: Vec<String>,
    /// Whether it reported success.
    pub success: bool,
}

/// Runs the image `elf` on `machine` until it ends, or fails after `limit`. Each log line is
/// given to `on_line` as it arrives.
pub fn run(elf: &Path, machine: &str, limit: Duration, on_line: impl FnMut(&str)) -> Result<Run> {
    run_with(elf, machine, &[], limit, on_line, None)
}

/// Like [`run`], but virtual time advances by 256 ns with each instruction, so that a timer of the
/// machine counts instructions: exactly, and the same in every run.
pub fn run_counting(
    elf: &Path,
    machine: &str,
    limit: Duration,
    on_line: impl FnMut(&str),
) -> Result<Run> {
    run_with(elf, machine, &COUNTING, limit, on_line, None)
}

/// Like [`run_counting`], and `trace` reads what is executed. It takes about a microsecond a block.
pub fn run_tracing(elf: &Path, machine: &str, limit: Duration, trace: &mut Trace) -> Result<Run> {
    let options = [&COUNTING[..], &["-d", "in_asm,exec,nochain"]].concat();
    run_with(elf, machine, &options, limit, |_| {}, Some(trace))
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
    let image = std::fs::read(elf).with_context(|| format!("could not read {}", elf.display()))?;
    let table = Table::parse(&image)?
        .with_context(|| format!("{} has no defmt log table", elf.display()))?;
    let mut decoder = table.new_stream_decoder();

    let errors = if trace.is_some() { Stdio::piped() } else { Stdio::inherit() };
    let (mut qemu, serial) = start(elf, machine, options, errors)?;
    let chunks = read_in_background(serial);
    let deadline = Instant::now() + limit;

    let mut lines = Vec::new();
    std::thread::scope(|scope| {
        let reading = trace
            .zip(qemu.stderr.take())
            .map(|(trace, log)| scope.spawn(|| trace.read(BufReader::new(log))));
        loop {
            match chunks.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(chunk) => {
                    decoder.received(&chunk);
                    for line in decode(decoder.as_mut()) {
                        on_line(&line);
                        lines.push(line);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {
                    stop(&mut qemu)?;
                    bail!("the image was still running after {} s", limit.as_secs());
                }
            }
        }
        if let Some(Ok(read)) = reading.map(|reading| reading.join()) {
            read?;
        }
        Ok(())
    })?;
    let status: ExitStatus = qemu.wait().context("could not wait for QEMU")?;
    Ok(Run { lines, success: status.success() })
}

/// Starts QEMU with the image's serial port on a pipe.
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
        .with_context(|| format!("no {QEMU}: install it (Debian: apt-get install {QEMU})"))?;
    let serial = child.stdout.take().context("QEMU's serial port is not connected")?;
    Ok((child, serial))
}

/// Reads on a thread of its own, so that waiting can have an end.
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

/// The lines that are complete by now. A frame that is broken shows as a line, so that a test
/// which expects another one fails with its cause in sight.
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
    qemu.kill().context("could not stop QEMU")?;
    qemu.wait().context("could not wait for QEMU")?;
    Ok(())
}
