//! An image in QEMU with its serial ports as sockets, for a ground station or simulated sensors.
//!
//! The image runs without end and uses no semihosting. Each port is a socket in a temporary folder.
//! Dropping the [`Machine`] ends QEMU.

use crate::qemu::{MACHINE, QEMU};
use anyhow::{Context, Result, bail};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Limit of the connection time. QEMU connects within milliseconds on an idle machine.
const CONNECT_LIMIT: Duration = Duration::from_secs(20);

/// A running image.
#[derive(Debug)]
pub struct Machine {
    qemu: Child,
    /// Folder of the sockets.
    _folder: TempDir,
}

impl Machine {
    /// Starts the image `elf` on an STM32F405. The P streams are USART1, USART2 and so on.
    ///
    /// # Errors
    /// QEMU is missing, or does not connect.
    pub fn start<const P: usize>(elf: &Path) -> Result<(Self, [UnixStream; P])> {
        Self::start_on(MACHINE, elf)
    }

    /// As [`start`](Self::start), on a machine of QEMU. The P streams are its first serial ports.
    ///
    /// # Errors
    /// As there.
    pub fn start_on<const P: usize>(machine: &str, elf: &Path) -> Result<(Self, [UnixStream; P])> {
        let folder = tempfile::tempdir().context("no temporary folder for the serial ports")?;
        let mut command = Command::new(QEMU);
        command
            .args(["-machine", machine, "-display", "none", "-monitor", "none", "-kernel"])
            .arg(elf)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        let mut listeners = Vec::new();
        for port in 0..P {
            let path = folder.path().join(format!("usart{}", port + 1));
            let listener = UnixListener::bind(&path)
                .with_context(|| format!("cannot create the socket {}", path.display()))?;
            listener.set_nonblocking(true)?;
            command.arg("-serial").arg(format!("unix:{}", path.display()));
            listeners.push(listener);
        }
        let qemu = command.spawn().with_context(|| {
            format!("cannot start {QEMU}: install it (Debian: apt-get install {QEMU})")
        })?;
        // From here on, dropping the machine ends QEMU.
        let mut machine = Self { qemu, _folder: folder };
        let mut streams = Vec::new();
        for listener in &listeners {
            streams.push(machine.accept(listener)?);
        }
        match streams.try_into() {
            Ok(streams) => Ok((machine, streams)),
            Err(_) => bail!("QEMU connected fewer serial ports than {P}"),
        }
    }

    fn accept(&mut self, listener: &UnixListener) -> Result<UnixStream> {
        let deadline = Instant::now() + CONNECT_LIMIT;
        loop {
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false)?;
                    return Ok(stream);
                }
                Err(error) if error.kind() != std::io::ErrorKind::WouldBlock => {
                    return Err(error).context("connection of a serial port failed");
                }
                Err(_) => {}
            }
            if let Some(status) = self.qemu.try_wait()? {
                bail!("QEMU ended before it connected its serial ports: {status}");
            }
            if Instant::now() > deadline {
                bail!("QEMU did not connect its serial ports within {} s", CONNECT_LIMIT.as_secs());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // Errors are ignored: QEMU may have ended before.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}
