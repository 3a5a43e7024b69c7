#!/usr/bin/env python3
"""Bridge between the serial line of the flight computer and a ground system that speaks space packets over UDP.

Telemetry: COBS frames of the line are checked and sent on as packets, one a datagram. Telecommands: packets without
tag and checksum are completed (count or counter, tag, checksum) and sent as COBS frames. Counts and counters continue
from the status packets, hence a telecommand waits for the first one. The key is read from a file and stays in this
process. See ``docs/ground.md``.
"""

import argparse
import binascii
import os
import pathlib
import select
import socket
import sys
import termios
import tty

from cobs import cobs
from cryptography.hazmat.primitives.ciphers import algorithms
from cryptography.hazmat.primitives.cmac import CMAC
from space_packet_parser.exceptions import UnrecognizedPacketTypeError
from space_packet_parser.xtce.definitions import XtcePacketDefinition

DESCRIPTION = pathlib.Path(__file__).with_name("link.xml")
ROOT_CONTAINER = "packet"

PRIMARY_HEADER = 6
CHECKSUM = 2
TAG = 16
#: Packet type 1, APID 0x1f0; the secondary header flag is set for a telecommand with a tag.
PLAIN_ID = 0x11F0
TAGGED_ID = 0x19F0
UNSEGMENTED = 0xC000
COUNTS = 0x4000
#: Longest frame without delimiters, bytes: a packet of 254 and its COBS overhead.
LONGEST_FRAME = 256


def checksum(packet):
    """CRC-16 of ``link.md``, two bytes."""
    return binascii.crc_hqx(packet, 0xFFFF).to_bytes(CHECKSUM, "big")


def tag(packet, key):
    """AES-128-CMAC of the packet so far, 16 bytes."""
    cmac = CMAC(algorithms.AES(key))
    cmac.update(packet)
    return cmac.finalize()


def read_key(path):
    """Key of a slot, 32 hexadecimal digits, as ``host-sim derive-key`` prints it."""
    text = pathlib.Path(path).read_text(encoding="ascii", errors="replace").strip()
    try:
        key = bytes.fromhex(text)
    except ValueError:
        key = b""
    if len(key) != 16:
        sys.exit(f"bridge: {path} holds no key: 32 hexadecimal digits are required (host-sim derive-key)")
    return key


def packet_of(packet_id, count, body, key=None):
    """Telecommand packet around secondary header and user data, with tag and checksum."""
    after = len(body) + (TAG if key else 0) + CHECKSUM
    words = (packet_id, UNSEGMENTED | count, after - 1)
    packet = b"".join(word.to_bytes(2, "big") for word in words) + body
    if key:
        packet += tag(packet, key)
    return packet + checksum(packet)


class Refused(Exception):
    """A telecommand that cannot be sent, with the reason."""


class Uplink:
    """Count and counter of the next telecommand, and the key."""

    def __init__(self, key=None, slot=1):
        self.key, self.slot = key, slot
        self.count = None
        self.counter = None
        self.authentication = None

    def on_status(self, status):
        """Continues from the status of the flight computer where that is ahead."""
        self.authentication = str(status["status_authentication"])
        counter = int(status[f"status_key_counters_{self.slot + 1}"])
        self.counter = max(counter, self.counter or 0)
        count = int(status["status_last_sequence_count"])
        if self.count is None or 0 < (count - self.count) % COUNTS < COUNTS // 2:
            self.count = count

    def complete(self, packet):
        """Packet for the line from one of the ground system: primary header and user data."""
        if len(packet) <= PRIMARY_HEADER or int.from_bytes(packet[:2], "big") != PLAIN_ID:
            raise Refused(f"no telecommand of link.xml: {packet[:8].hex(' ')}")
        user_data = packet[PRIMARY_HEADER:]
        if int.from_bytes(packet[4:6], "big") != len(user_data) + CHECKSUM - 1:
            raise Refused("its length differs from its length field; the ground system must not add a checksum")
        if self.count is None:
            raise Refused("no status received yet, hence no count; wait for telemetry, then repeat it")
        if self.key is None and self.authentication != "off":
            raise Refused("the flight computer requires a tag; start the bridge with --key")
        if self.key is not None and self.authentication == "off":
            raise Refused("the flight image has no key; start the bridge without --key")
        if self.key is None:
            self.count = (self.count + 1) % COUNTS
            return packet_of(PLAIN_ID, self.count, user_data)
        self.counter += 1
        secondary = bytes([self.slot]) + self.counter.to_bytes(4, "big")
        return packet_of(TAGGED_ID, self.counter % COUNTS, secondary + user_data, self.key)


class Downlink:
    """Frames from the bytes of the line."""

    def __init__(self, definition, key=None, slot=1, require_tag=False):
        self.definition, self.key, self.slot, self.require_tag = definition, key, slot, require_tag
        self.frame = bytearray()

    def push(self, chunk):
        """Pairs of a packet and its parameters, for the frames that ``chunk`` completes."""
        for byte in chunk:
            if byte != 0:
                if len(self.frame) <= LONGEST_FRAME:
                    self.frame.append(byte)
                continue
            frame, self.frame = bytes(self.frame), bytearray()
            if frame:
                try:
                    yield self.packet(frame)
                except (cobs.DecodeError, Refused) as error:
                    print(f"bridge: frame dropped: {error}", file=sys.stderr, flush=True)

    def packet(self, frame):
        packet = cobs.decode(frame)
        if len(packet) <= PRIMARY_HEADER or checksum(packet[:-CHECKSUM]) != packet[-CHECKSUM:]:
            raise Refused("wrong checksum")
        try:
            values = self.definition.parse_bytes(packet)
        # The reader looks up a header field by another name for an unknown packet: LookupError.
        except (UnrecognizedPacketTypeError, LookupError, ValueError) as error:
            raise Refused(f"packet not described by link.xml, of another version? {error}") from error
        if "tag" not in values and self.require_tag:
            raise Refused("telemetry without a tag")
        if "tag" in values and self.key is not None and values["tag_slot"] == self.slot + 1:
            if tag(packet[: -TAG - CHECKSUM], self.key) != values["tag"]:
                raise Refused("telemetry with a wrong tag")
        elif self.require_tag:
            raise Refused("telemetry with the tag of another key slot")
        return packet, values


def open_line(path):
    """The serial device, 115,200 baud, 8 data bits, no parity, one stop bit."""
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    if os.isatty(line):
        tty.setraw(line)
        settings = termios.tcgetattr(line)
        settings[4] = settings[5] = termios.B115200
        termios.tcsetattr(line, termios.TCSANOW, settings)
    return line


def write_all(line, data):
    while data:
        data = data[os.write(line, data) :]


def run(line, telemetry_to, telecommands, downlink, uplink):
    """Serves both directions until the line ends."""
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    while True:
        readable, _, _ = select.select([line, telecommands], [], [])
        if line in readable:
            try:
                chunk = os.read(line, 4096)
            except OSError:  # a pseudo-terminal whose other end was closed
                chunk = b""
            if not chunk:
                return
            for packet, values in downlink.push(chunk):
                if "status_authentication" in values:
                    uplink.on_status(values)
                out.sendto(packet, telemetry_to)
        if telecommands in readable:
            datagram = telecommands.recv(4096)
            try:
                packet = uplink.complete(datagram)
            except Refused as error:
                print(f"bridge: telecommand not sent: {error}", file=sys.stderr, flush=True)
                continue
            write_all(line, b"\0" + cobs.encode(packet) + b"\0")
            print(f"bridge: telecommand sent: {packet.hex(' ')}", file=sys.stderr, flush=True)


def address(text):
    host, _, port = text.rpartition(":")
    if not host or not port.isdigit():
        raise argparse.ArgumentTypeError(f"{text} is no HOST:PORT")
    return host, int(port)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("device", help="serial device, such as /dev/ttyUSB0")
    parser.add_argument("--tm", type=address, default=("127.0.0.1", 10015), metavar="HOST:PORT",
                        help="where telemetry packets go [127.0.0.1:10015]")
    parser.add_argument("--tc", type=address, default=("127.0.0.1", 10025), metavar="HOST:PORT",
                        help="where telecommands are received [127.0.0.1:10025]")
    parser.add_argument("--key", metavar="FILE", help="key of the slot, for a flight image with a key")
    parser.add_argument("--slot", type=int, default=1, choices=(0, 1, 2), help="key slot [1]")
    parser.add_argument("--require-tag", action="store_true", help="drop telemetry without a right tag (needs --key)")
    given = parser.parse_args()
    if given.require_tag and given.key is None:
        parser.error("--require-tag needs --key")
    return given


def main():
    given = arguments()
    key = read_key(given.key) if given.key else None
    definition = XtcePacketDefinition.from_xtce(DESCRIPTION, root_container_name=ROOT_CONTAINER)
    telecommands = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        telecommands.bind(given.tc)
        line = open_line(given.device)
    except OSError as error:
        sys.exit(f"bridge: cannot open {given.device} or {given.tc[0]}:{given.tc[1]}: {error}")
    downlink = Downlink(definition, key, given.slot, given.require_tag)
    run(line, given.tm, telecommands, downlink, Uplink(key, given.slot))


if __name__ == "__main__":
    main()
