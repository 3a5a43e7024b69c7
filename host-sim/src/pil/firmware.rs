//! The image `pil` in QEMU, the line on which it asks for its sensors, and its link to the ground.

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use fsw_target::drivers::wheel_tach::Captured;
use fsw_target::flight::craft::WHEELS;
use fsw_target::link::Receiver;
use fsw_target::link::frame::{DELIMITER, FrameReceiver, MAX_PACKET};
use fsw_target::link::telemetry::Received;
use fsw_target::link::wire::{Unreadable, Wire, Writer};
use fsw_target::stand_in::tunnel::{self, Captures, Message, Setup};
use target_tools::firmware::build;
use target_tools::machine::Machine;
use thiserror::Error;

use super::bench::Announced;
use super::flash::OutOfBounds;
use crate::sensor::bmi088::BusFault;

/// The firmware answers within milliseconds; a busy machine may take far longer.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// While it asks for nothing it may be held up by a link that nobody empties: looked at so often.
const LISTEN: Duration = Duration::from_millis(5);

/// Why the line to the firmware is of no use any more.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LineFailed {
    /// It doesn't say anything.
    #[error("the firmware has been silent for {} s", .0.as_secs())]
    Silent(Duration),
    /// The other end is gone.
    #[error("the firmware's line has ended (QEMU stopped)")]
    Ended,
    /// What came isn't a request.
    #[error("the firmware sent what isn't a request: {0}")]
    Garbled(&'static str),
    /// It speaks of another protocol.
    #[error("the firmware speaks version {0} of the sensor tunnel, this program {ours}", ours = tunnel::VERSION)]
    OtherVersion(u8),
    /// It is of another build.
    #[error("the image was built from other sources than this program: build both anew")]
    OtherSources,
    /// Telemetry that doesn't come.
    #[error("the firmware owes telemetry, and {} s were not enough for it", .0.as_secs())]
    NoTelemetry(Duration),
    /// What came on the link isn't telemetry.
    #[error("what the firmware sends to the ground isn't telemetry: {0}")]
    NotTelemetry(String),
    /// It says hello again, in flight.
    #[error("the firmware has restarted by itself: something failed in it")]
    Restarted,
    /// It gave up.
    #[error("the firmware gave up: {0}")]
    GaveUp(String),
    /// The socket.
    #[error("the line to the firmware failed: {0}")]
    Socket(io::ErrorKind),
}

/// What the firmware wants.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Who it is.
    Hello,
    /// The next sample.
    Next,
    /// A transaction on the gyro's bus.
    Transfer {
        /// Bytes to the chip.
        written: Vec<u8>,
        /// How many it wants back.
        read: u8,
    },
    /// Time to pass.
    Wait {
        /// How much.
        us: u32,
    },
    /// What the wheels' timer holds.
    Captures,
    /// What is in the flash.
    FlashRead {
        /// From here.
        offset: u32,
        /// So many bytes.
        length: u8,
    },
    /// To clear bits of the flash.
    FlashWrite {
        /// From here.
        offset: u32,
        /// To these.
        bytes: Vec<u8>,
    },
    /// To set all bits of pages of the flash.
    FlashErase {
        /// From here.
        from: u32,
        /// Up to before here.
        to: u32,
    },
}

/// How a firmware is started.
#[derive(Clone, Debug)]
pub struct Image {
    elf: PathBuf,
}

impl Image {
    /// The image of this file, or the one that is built from source.
    ///
    /// # Errors
    /// No compiler.
    pub fn find(elf: Option<PathBuf>) -> anyhow::Result<Self> {
        let elf = match elf {
            Some(elf) => elf,
            None => build("pil")?,
        };
        Ok(Self { elf })
    }

    /// Starts it in QEMU.
    ///
    /// # Errors
    /// No QEMU.
    pub fn start(&self) -> anyhow::Result<Firmware> {
        anyhow::ensure!(self.elf.is_file(), "{}: there is no such image", self.elf.display());
        let (machine, [link, sensors]) = Machine::start::<2>(&self.elf)?;
        Firmware::on(sensors, link, PATIENCE, Some(machine))
    }
}

/// A running firmware.
pub struct Firmware {
    sensors: UnixStream,
    link: UnixStream,
    patience: Duration,
    frames: FrameReceiver<MAX_PACKET>,
    /// Bytes from the sensors' line that have arrived, last first.
    arrived: Vec<u8>,
    receiver: Receiver,
    /// What it has told the ground, and nobody has asked for yet.
    heard: Vec<Received>,
    /// What it has been told last.
    told: Announced,
    /// Ends QEMU; none where somebody else does.
    _machine: Option<Machine>,
}

impl Firmware {
    /// A firmware at the other end of these lines.
    ///
    /// # Errors
    /// A line without time-outs.
    pub fn on(
        sensors: UnixStream,
        link: UnixStream,
        patience: Duration,
        machine: Option<Machine>,
    ) -> anyhow::Result<Self> {
        sensors.set_read_timeout(Some(LISTEN.min(patience)))?;
        link.set_nonblocking(true)?;
        Ok(Self {
            sensors,
            link,
            patience,
            frames: FrameReceiver::new(),
            arrived: Vec::new(),
            receiver: Receiver::default(),
            heard: Vec::new(),
            told: Announced { time_us: 0, torque_n_m: [0.0; 3] },
            _machine: machine,
        })
    }

    /// How long it may be silent.
    pub fn patience(&self) -> Duration {
        self.patience
    }

    /// What it has told the ground by now.
    ///
    /// # Errors
    /// A link that ended, or what isn't telemetry.
    pub fn telemetry(&mut self) -> Result<Vec<Received>, LineFailed> {
        self.listen()?;
        Ok(std::mem::take(&mut self.heard))
    }

    /// Takes what has come on the link.
    fn listen(&mut self) -> Result<(), LineFailed> {
        let mut buffer = [0; 4096];
        loop {
            match self.link.read(&mut buffer) {
                Ok(0) => return Err(LineFailed::Ended),
                Ok(count) => {
                    for found in buffer[..count].iter().filter_map(|byte| self.receiver.push(*byte))
                    {
                        let found = found.map_err(|why| LineFailed::NotTelemetry(why.to_string()));
                        self.heard.push(found?);
                    }
                }
                Err(error) => match failure(&error) {
                    None => return Ok(()),
                    Some(failed) => return Err(failed),
                },
            }
        }
    }

    /// Sends a command on the link.
    ///
    /// # Errors
    /// The line's.
    pub fn command(&mut self, frame: &[u8]) -> Result<(), LineFailed> {
        // Shorter than any socket's buffer.
        self.link
            .write_all(frame)
            .map_err(|error| failure(&error).unwrap_or(LineFailed::Socket(error.kind())))
    }

    /// Waits for the next request.
    ///
    /// # Errors
    /// Silence, an end, a broken frame, or a firmware that gives up.
    pub fn request(&mut self) -> Result<Request, LineFailed> {
        loop {
            let byte = self.byte()?;
            match self.frames.push(byte) {
                None => {}
                Some(Err(_)) => return Err(LineFailed::Garbled("a broken frame")),
                Some(Ok(packet)) => return understand(packet),
            }
        }
    }

    fn byte(&mut self) -> Result<u8, LineFailed> {
        let begun = Instant::now();
        loop {
            if let Some(byte) = self.arrived.pop() {
                return Ok(byte);
            }
            let mut buffer = [0; 512];
            match self.sensors.read(&mut buffer) {
                Ok(0) => return Err(LineFailed::Ended),
                Ok(count) => self.arrived.extend(buffer[..count].iter().rev()),
                Err(error) => match failure(&error) {
                    Some(failed) => return Err(failed),
                    None if begun.elapsed() > self.patience => {
                        return Err(LineFailed::Silent(self.patience));
                    }
                    None => self.listen()?,
                },
            }
        }
    }

    fn reply(&mut self, kind: u8, fields: impl FnOnce(&mut Writer<'_>)) -> Result<(), LineFailed> {
        let frame = Message::new(kind, fields)
            .frame()
            .ok_or(LineFailed::Garbled("a request for more than a message holds"))?;
        // The delimiter that cuts off noise isn't needed here, and costs time.
        let bytes = frame.bytes().strip_prefix(&[DELIMITER]).unwrap_or(frame.bytes());
        let written = self.sensors.write_all(bytes);
        written.map_err(|error| failure(&error).unwrap_or(LineFailed::Socket(error.kind())))
    }

    fn reply_or_no<E>(&mut self, kind: u8, answer: Result<&[u8], E>) -> Result<(), LineFailed> {
        match answer {
            Ok(bytes) => self.reply(kind, |fields| fields.put(bytes)),
            Err(_) => self.reply(tunnel::NO, |_| ()),
        }
    }

    /// Answers [`Request::Hello`].
    ///
    /// # Errors
    /// The line's, as for every answer.
    pub fn introduce(&mut self, setup: &Setup) -> Result<(), LineFailed> {
        self.told.time_us = setup.now_us;
        self.reply(tunnel::HELLO, |fields| setup.put(fields))
    }

    /// Answers [`Request::Next`].
    ///
    /// # Errors
    /// The line's.
    pub fn announce(&mut self, announced: &Announced) -> Result<(), LineFailed> {
        let elapsed_us = announced.time_us.saturating_sub(self.told.time_us);
        let elapsed_us = u32::try_from(elapsed_us)
            .map_err(|_| LineFailed::Garbled("more than an hour between two samples"))?;
        let before = std::mem::replace(&mut self.told, *announced);
        if announced.torque_n_m.map(f32::to_bits) == before.torque_n_m.map(f32::to_bits) {
            return self.reply(tunnel::NEXT, |fields| elapsed_us.put(fields));
        }
        self.reply(tunnel::NEXT_WITH_TORQUE, |fields| {
            elapsed_us.put(fields);
            announced.torque_n_m.put(fields);
        })
    }

    /// Answers [`Request::Next`]: not yet.
    ///
    /// # Errors
    /// The line's.
    pub fn idle(&mut self) -> Result<(), LineFailed> {
        self.reply(tunnel::IDLE, |_| ())
    }

    /// Answers [`Request::Next`]: there is none.
    ///
    /// # Errors
    /// The line's.
    pub fn end(&mut self) -> Result<(), LineFailed> {
        self.reply(tunnel::NO, |_| ())
    }

    /// Answers [`Request::Transfer`].
    ///
    /// # Errors
    /// The line's.
    pub fn transferred(&mut self, answer: Result<&[u8], BusFault>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::TRANSFER, answer)
    }

    /// Answers [`Request::Wait`].
    ///
    /// # Errors
    /// The line's.
    pub fn waited(&mut self) -> Result<(), LineFailed> {
        self.reply(tunnel::WAIT, |_| ())
    }

    /// Answers [`Request::Captures`].
    ///
    /// # Errors
    /// The line's.
    pub fn captured(&mut self, captured: &[Captured; WHEELS]) -> Result<(), LineFailed> {
        self.reply(tunnel::CAPTURES, |fields| Captures::new(captured).put(fields))
    }

    /// Answers [`Request::FlashRead`].
    ///
    /// # Errors
    /// The line's.
    pub fn flash_read(&mut self, answer: Result<&[u8], OutOfBounds>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::FLASH_READ, answer)
    }

    /// Answers [`Request::FlashWrite`].
    ///
    /// # Errors
    /// The line's.
    pub fn flash_written(&mut self, answer: Result<(), OutOfBounds>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::FLASH_WRITE, answer.map(|()| &[] as &[u8]))
    }

    /// Answers [`Request::FlashErase`].
    ///
    /// # Errors
    /// The line's.
    pub fn flash_erased(&mut self, answer: Result<(), OutOfBounds>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::FLASH_ERASE, answer.map(|()| &[] as &[u8]))
    }
}

/// What an error of a socket means; `None` where it is that nothing has come.
fn failure(error: &io::Error) -> Option<LineFailed> {
    match error.kind() {
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted => None,
        io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => Some(LineFailed::Ended),
        kind => Some(LineFailed::Socket(kind)),
    }
}

/// What a packet asks for.
fn understand(packet: &[u8]) -> Result<Request, LineFailed> {
    let (kind, mut fields) =
        Message::open(packet).ok_or(LineFailed::Garbled("a wrong checksum"))?;
    let unreadable = |_: Unreadable| LineFailed::Garbled("a message that can't be read");
    match kind {
        tunnel::HELLO => match fields.take().map_err(unreadable)? {
            [tunnel::VERSION] => match Wire::take(&mut fields).map_err(unreadable)? {
                tunnel::SOURCES => Ok(Request::Hello),
                _ => Err(LineFailed::OtherSources),
            },
            [other] => Err(LineFailed::OtherVersion(other)),
        },
        tunnel::NEXT => Ok(Request::Next),
        tunnel::TRANSFER => {
            let [read] = fields.take().map_err(unreadable)?;
            Ok(Request::Transfer { written: fields.rest().to_vec(), read })
        }
        tunnel::WAIT => Ok(Request::Wait { us: Wire::take(&mut fields).map_err(unreadable)? }),
        tunnel::CAPTURES => Ok(Request::Captures),
        tunnel::FLASH_READ => {
            let offset = Wire::take(&mut fields).map_err(unreadable)?;
            let [length] = fields.take().map_err(unreadable)?;
            Ok(Request::FlashRead { offset, length })
        }
        tunnel::FLASH_WRITE => {
            let offset = Wire::take(&mut fields).map_err(unreadable)?;
            Ok(Request::FlashWrite { offset, bytes: fields.rest().to_vec() })
        }
        tunnel::FLASH_ERASE => {
            let [from, to] = Wire::take(&mut fields).map_err(unreadable)?;
            Ok(Request::FlashErase { from, to })
        }
        tunnel::FAILED => {
            Err(LineFailed::GaveUp(String::from_utf8_lossy(fields.rest()).into_owned()))
        }
        _ => Err(LineFailed::Garbled("a request that doesn't exist")),
    }
}
