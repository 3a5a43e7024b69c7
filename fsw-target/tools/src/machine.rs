//! An image in QEMU with its serial ports in our hands: what a ground station, or a simulated
//! sensor, sees of it.
//!
//! Such an image doesn't end by itself and uses no semihosting. Each port is a socket in a folder
//! of its own; dropping the [`Machine`] ends QEMU.

use crate::qemu::{MACHINE, QEMU};
use anyhow::{Context, Result, bail};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// QEMU connects within milliseconds of its start; a busy machine may take far longer.
const CONNECT_LIMIT: Duration = Duration::from_secs(20);

/// A running image.
#[derive(Debug)]
pub struct Machine {
    qemu: Child,
    /// Holds the sockets.
    _folder: TempDir,
}

impl Machine {
    /// Starts the image `elf` on the flight computer's chip. The first of the P streams is USART1,
    /// the next USART2, and so on.
    ///
    /// # Errors
    /// No QEMU, or one that doesn't connect.
    pub fn start<const P: usize>(elf: &Path) -> Result<(Self, [UnixStream; P])> {
        let folder = tempfile::tempdir().context("no folder for the serial ports' sockets")?;
        let mut command = Command::new(QEMU);
        command
            .args(["-machine", MACHINE, "-display", "none", "-monitor", "none", "-kernel"])
            .arg(elf)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        let mut listeners = Vec::new();
        for port in 0..P {
            let path = folder.path().join(format!("usart{}", port + 1));
            let listener = UnixListener::bind(&path)
                .with_context(|| format!("no socket {}", path.display()))?;
            listener.set_nonblocking(true)?;
            command.arg("-serial").arg(format!("unix:{}", path.display()));
            listeners.push(listener);
        }
        let qemu = command
            .spawn()
            .with_context(|| format!("no {QEMU}: install it (Debian: apt-get install {QEMU})"))?;
        // From here on QEMU is ended whatever goes wrong.
        let mut machine = Self { qemu, _folder: folder };
        let mut streams = Vec::new();
        for listener in &listeners {
            streams.push(machine.accept(listener)?);
        }
        match streams.try_into() {
            Ok(streams) => Ok((machine, streams)),
            Err(_) => bail!("not every serial port was connected"),
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
                    return Err(error).context("a serial port could not be connected");
                }
                Err(_) => {}
            }
            if let Some(status) = self.qemu.try_wait()? {
                bail!("QEMU ended before it connected its serial ports: {status}");
            }
            if Instant::now() > deadline {
                bail!("QEMU did not connect its serial ports in {} s", CONNECT_LIMIT.as_secs());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // It may have ended by itself; nothing more can be done about one that can't be ended.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}
