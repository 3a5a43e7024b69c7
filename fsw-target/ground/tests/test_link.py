"""``link.xml`` by an independent reader, and the packets of ``bridge.py`` against those of the flight software."""

import bridge
import pytest
from cobs import cobs
from space_packet_parser.xtce.definitions import XtcePacketDefinition
from space_packet_parser.xtce.validation import validate_xtce


@pytest.fixture(scope="module")
def definition():
    return XtcePacketDefinition.from_xtce(bridge.DESCRIPTION, root_container_name=bridge.ROOT_CONTAINER)


def status(**changed):
    """Values of a status as the bridge uses them."""
    values = {"status_authentication": "off", "status_last_sequence_count": 0}
    values |= {f"status_key_counters_{number}": 0 for number in (1, 2, 3)}
    return values | changed


def from_ground_system(sample):
    """The telecommand as a ground system sends it: without checksum."""
    return bytes.fromhex(sample["packet"])[:-2]


def test_description_is_valid_xtce():
    validate_xtce(bridge.DESCRIPTION, level="schema", allow_schema_download=False)


def test_independent_reader_decodes_every_value(definition, telemetry):
    read = 0
    for sample in telemetry:
        packet = definition.parse_bytes(bytes.fromhex(sample["packet"]))
        for name, value in sample["values"].items():
            assert packet[name] == value, name
            read += 1
        raw = bytes.fromhex(sample["packet"])
        assert (packet["time_us"], packet["checksum"]) == (123_456_789, int.from_bytes(raw[-2:], "big"))
        has_tag = sample["container"].endswith("_with_tag")
        assert packet.get("tag") == (raw[-18:-2] if has_tag else None)
        if sample["container"].startswith("checkpoint"):
            name = "checkpoint_bytes_with_tag" if has_tag else "checkpoint_bytes"
            assert packet[name] == b"\x01\x02\x03\xff"
    print(read, "values in", len(telemetry), "packets")


def test_telecommands_have_the_bytes_of_the_flight_software(telecommands):
    for sample in telecommands:
        uplink = bridge.Uplink()
        uplink.on_status(status(status_last_sequence_count=0x3FFF))
        assert uplink.complete(from_ground_system(sample)).hex() == sample["packet"]


def test_tags_are_those_of_the_flight_software(telecommands):
    for sample in telecommands:
        by = sample["tagged_by"]
        uplink = bridge.Uplink(bytes.fromhex(by["key"]), by["slot"])
        counter = {f"status_key_counters_{by['slot'] + 1}": by["counter"] - 1}
        uplink.on_status(status(status_authentication="required", **counter))
        assert uplink.complete(from_ground_system(sample)).hex() == sample["tagged_packet"]


def test_counts_ascend_and_follow_the_status(telecommands):
    ping = from_ground_system(telecommands[0])
    uplink = bridge.Uplink()
    uplink.on_status(status(status_last_sequence_count=0x3FFE))

    def count():
        return int.from_bytes(uplink.complete(ping)[2:4], "big") & 0x3FFF

    assert [count(), count()] == [0x3FFF, 0]
    uplink.on_status(status(status_last_sequence_count=0x3FFE))
    assert count() == 1
    uplink.on_status(status(status_last_sequence_count=40))
    assert count() == 41


@pytest.mark.parametrize(
    ("key", "authentication", "reason"),
    [(None, None, "no status"), (None, "required", "requires a tag"), (bytes(16), "off", "has no key")],
)
def test_telecommand_that_would_be_rejected_is_not_sent(telecommands, key, authentication, reason):
    uplink = bridge.Uplink(key)
    if authentication:
        uplink.on_status(status(status_authentication=authentication))
    with pytest.raises(bridge.Refused, match=reason):
        uplink.complete(from_ground_system(telecommands[0]))


def test_other_datagrams_are_not_sent(telecommands):
    uplink = bridge.Uplink()
    uplink.on_status(status())
    for datagram in (b"", b"\x00" * 9, bytes.fromhex(telecommands[0]["packet"])):
        with pytest.raises(bridge.Refused):
            uplink.complete(datagram)


def test_frames_arrive_whole_and_damaged_ones_are_dropped(definition, telemetry, capsys):
    packets = [bytes.fromhex(sample["packet"]) for sample in telemetry]
    frames = [b"\0" + cobs.encode(packet) + b"\0" for packet in packets]
    damaged = frames[0][:40] + bytes([frames[0][40] ^ 1]) + frames[0][41:]
    line = damaged + b"\x05" * 1000 + b"\0" + b"".join(frames)
    downlink = bridge.Downlink(definition)
    pieces = [line[start : start + 100] for start in range(0, len(line), 100)]
    received = [packet for piece in pieces for packet, _ in downlink.push(piece)]
    assert received == packets
    assert capsys.readouterr().err.count("frame dropped") == 2


def test_intact_packet_of_another_layout_is_dropped(definition, telemetry, capsys):
    status = next(bytes.fromhex(sample["packet"]) for sample in telemetry if "status" in sample["container"])
    unknown_code = status[:35] + b"\xee" + status[36:-2]
    for body in (b"\x09\xf7" + status[2:-2], status[:60], status[:7], unknown_code):
        frame = cobs.encode(body + bridge.checksum(body)) + b"\0"
        assert not list(bridge.Downlink(definition).push(frame))
        assert "not described" in capsys.readouterr().err


def test_telemetry_without_the_right_tag_is_dropped_where_one_is_required(definition, telemetry, capsys):
    frames = b"".join(cobs.encode(bytes.fromhex(sample["packet"])) + b"\0" for sample in telemetry)
    tagged = sum(sample["container"].endswith("_with_tag") for sample in telemetry)

    def received(key):
        return sum(1 for _ in bridge.Downlink(definition, key, slot=1, require_tag=True).push(frames))

    assert received(bytes([7] * 16)) == tagged > 0
    assert received(bytes(16)) == 0
    assert "wrong tag" in capsys.readouterr().err
