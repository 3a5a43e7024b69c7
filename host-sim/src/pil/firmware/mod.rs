//! The image `pil` in QEMU, its sensor line, and its link to the ground.
//!
//! ```text
//! request  requests on the sensor line      line  errors of both lines
//! ```

mod line;
mod request;

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use fsw_target::drivers::wheel_tach::Captured;
use fsw_target::flight::craft::WHEELS;
use fsw_target::link::Receiver;
use fsw_target::link::frame::{DELIMITER, FrameReceiver, MAX_PACKET};
use fsw_target::link::telemetry::Received;
use fsw_target::link::wire::{Wire, Writer};
use fsw_target::stand_in::tunnel::{self, Captures, Message, Setup, Stated};
use target_tools::board::Board;
use target_tools::firmware::build_for;
use target_tools::machine::Machine;

use super::flash::OutOfBounds;
use super::hardware::Announced;
use crate::sensor::bmi088::BusFault;
pub use line::LineFailed;
use line::failure;
pub use request::Request;

/// Time limit of a request. The firmware answers within milliseconds; a loaded machine takes longer.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// Interval at which the ground link is read while no request arrives: a full link stops the
/// firmware.
const LISTEN: Duration = Duration::from_millis(5);

/// An image that can be started.
#[derive(Clone, Debug)]
pub struct Image {
    elf: PathBuf,
    machine: &'static str,
}

impl Image {
    /// The image of a board in the file `elf`, or the one built from source.
    ///
    /// # Errors
    /// No compiler for the target.
    pub fn find(board: &Board, elf: Option<PathBuf>) -> anyhow::Result<Self> {
        let elf = match elf {
            Some(elf) => elf,
            None => build_for(board, "pil")?,
        };
        Ok(Self { elf, machine: board.machine })
    }

    /// Starts the image in QEMU.
    ///
    /// # Errors
    /// No such file, or no QEMU.
    pub fn start(&self) -> anyhow::Result<Firmware> {
        anyhow::ensure!(self.elf.is_file(), "{}: no such image", self.elf.display());
        let (machine, [link, sensors]) = Machine::start_on::<2>(self.machine, &self.elf)?;
        Firmware::on(sensors, link, PATIENCE, Some(machine))
    }
}

/// A running firmware.
pub struct Firmware {
    sensors: UnixStream,
    link: UnixStream,
    patience: Duration,
    frames: FrameReceiver<MAX_PACKET>,
    /// Bytes received on the sensor line, last first.
    arrived: Vec<u8>,
    receiver: Receiver,
    /// Telemetry received and not yet read.
    telemetry: Vec<Received>,
    /// Sample announced last.
    announced: Announced,
    /// Ends QEMU when dropped. None if the firmware runs elsewhere.
    _machine: Option<Machine>,
}

impl Firmware {
    /// A firmware at the other end of the sensor line and the ground link.
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
            telemetry: Vec::new(),
            announced: Announced { time_us: 0, torque_n_m: [0.0; 3] },
            _machine: machine,
        })
    }

    /// Time limit of a request.
    pub fn patience(&self) -> Duration {
        self.patience
    }

    /// Telemetry received since the last call.
    ///
    /// # Errors
    /// A closed link, or bytes that are not telemetry.
    pub fn telemetry(&mut self) -> Result<Vec<Received>, LineFailed> {
        self.listen()?;
        Ok(std::mem::take(&mut self.telemetry))
    }

    /// Reads the ground link until it is empty.
    fn listen(&mut self) -> Result<(), LineFailed> {
        let mut buffer = [0; 4096];
        loop {
            match self.link.read(&mut buffer) {
                Ok(0) => return Err(LineFailed::Ended),
                Ok(count) => {
                    for packet in
                        buffer[..count].iter().filter_map(|byte| self.receiver.push(*byte))
                    {
                        let packet =
                            packet.map_err(|error| LineFailed::NotTelemetry(error.to_string()));
                        self.telemetry.push(packet?);
                    }
                }
                Err(error) => match failure(&error) {
                    None => return Ok(()),
                    Some(failed) => return Err(failed),
                },
            }
        }
    }

    /// Sends the frame of a telecommand.
    ///
    /// # Errors
    /// Those of the line.
    pub fn command(&mut self, frame: &[u8]) -> Result<(), LineFailed> {
        // A frame is shorter than the socket's buffer.
        self.link
            .write_all(frame)
            .map_err(|error| failure(&error).unwrap_or(LineFailed::Socket(error.kind())))
    }

    /// Waits for the next request.
    ///
    /// # Errors
    /// No request within the time limit, a closed line, a malformed request, or an abort.
    pub fn request(&mut self) -> Result<Request, LineFailed> {
        loop {
            let byte = self.byte()?;
            match self.frames.push(byte) {
                None => {}
                Some(Err(_)) => return Err(LineFailed::Malformed("broken frame")),
                Some(Ok(packet)) => return Request::decode(packet),
            }
        }
    }

    /// Next byte on the sensor line.
    fn byte(&mut self) -> Result<u8, LineFailed> {
        let start = Instant::now();
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
                    None if start.elapsed() > self.patience => {
                        return Err(LineFailed::Silent(self.patience));
                    }
                    None => self.listen()?,
                },
            }
        }
    }

    /// Sends a reply.
    fn reply(&mut self, kind: u8, fields: impl FnOnce(&mut Writer<'_>)) -> Result<(), LineFailed> {
        let frame = Message::new(kind, fields)
            .frame()
            .ok_or(LineFailed::Malformed("reply longer than a message"))?;
        // The leading delimiter ends noise on a real line. On a socket it only costs time.
        let bytes = frame.bytes().strip_prefix(&[DELIMITER]).unwrap_or(frame.bytes());
        let written = self.sensors.write_all(bytes);
        written.map_err(|error| failure(&error).unwrap_or(LineFailed::Socket(error.kind())))
    }

    /// Sends bytes as a reply, or a refusal.
    fn reply_or_no<E>(&mut self, kind: u8, answer: Result<&[u8], E>) -> Result<(), LineFailed> {
        match answer {
            Ok(bytes) => self.reply(kind, |fields| fields.put(bytes)),
            Err(_) => self.reply(tunnel::NO, |_| ()),
        }
    }

    /// Answers [`Request::Hello`] with the craft data.
    ///
    /// # Errors
    /// Those of the line, as for every answer.
    pub fn introduce(&mut self, setup: &Setup) -> Result<(), LineFailed> {
        self.announced.time_us = setup.now_us;
        self.reply(tunnel::HELLO, |fields| setup.put(fields))
    }

    /// Answers [`Request::Hardware`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn state(&mut self, stated: &Stated) -> Result<(), LineFailed> {
        self.reply(tunnel::HARDWARE, |fields| stated.put(fields))
    }

    /// Answers [`Request::Next`] with a sample.
    ///
    /// # Errors
    /// Those of the line.
    pub fn announce(&mut self, announced: &Announced) -> Result<(), LineFailed> {
        let elapsed_us = announced.time_us.saturating_sub(self.announced.time_us);
        let elapsed_us = u32::try_from(elapsed_us)
            .map_err(|_| LineFailed::Malformed("more than an hour between two samples"))?;
        let before = std::mem::replace(&mut self.announced, *announced);
        if announced.torque_n_m.map(f32::to_bits) == before.torque_n_m.map(f32::to_bits) {
            return self.reply(tunnel::NEXT, |fields| elapsed_us.put(fields));
        }
        self.reply(tunnel::NEXT_WITH_TORQUE, |fields| {
            elapsed_us.put(fields);
            announced.torque_n_m.put(fields);
        })
    }

    /// Answers [`Request::Next`]: no sample yet.
    ///
    /// # Errors
    /// Those of the line.
    pub fn idle(&mut self) -> Result<(), LineFailed> {
        self.reply(tunnel::IDLE, |_| ())
    }

    /// Answers [`Request::Next`]: end of the flight.
    ///
    /// # Errors
    /// Those of the line.
    pub fn end(&mut self) -> Result<(), LineFailed> {
        self.reply(tunnel::NO, |_| ())
    }

    /// Answers [`Request::Transfer`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn transferred(&mut self, answer: Result<&[u8], BusFault>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::TRANSFER, answer)
    }

    /// Answers [`Request::Wait`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn waited(&mut self) -> Result<(), LineFailed> {
        self.reply(tunnel::WAIT, |_| ())
    }

    /// Answers [`Request::Captures`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn captured(
        &mut self,
        captured: &[Captured; WHEELS],
        motor_torque_n_m: [f32; WHEELS],
    ) -> Result<(), LineFailed> {
        let captures = Captures::new(captured, motor_torque_n_m);
        self.reply(tunnel::CAPTURES, |fields| captures.put(fields))
    }

    /// Answers [`Request::Motors`]: taken, or refused.
    ///
    /// # Errors
    /// Those of the line.
    pub fn commanded(&mut self, is_taken: bool) -> Result<(), LineFailed> {
        self.reply(if is_taken { tunnel::MOTORS } else { tunnel::NO }, |_| ())
    }

    /// Answers [`Request::FlashRead`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn flash_read(&mut self, answer: Result<&[u8], OutOfBounds>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::FLASH_READ, answer)
    }

    /// Answers [`Request::FlashWrite`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn flash_written(&mut self, answer: Result<(), OutOfBounds>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::FLASH_WRITE, answer.map(|()| &[] as &[u8]))
    }

    /// Answers [`Request::FlashErase`].
    ///
    /// # Errors
    /// Those of the line.
    pub fn flash_erased(&mut self, answer: Result<(), OutOfBounds>) -> Result<(), LineFailed> {
        self.reply_or_no(tunnel::FLASH_ERASE, answer.map(|()| &[] as &[u8]))
    }
}
