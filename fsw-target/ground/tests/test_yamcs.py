"""The flight image in QEMU, through ``bridge.py`` and Yamcs: telemetry decoded, telecommands obeyed.

``FLIGHT_IMAGE`` is the ELF file of the image, ``FLIGHT_KEY`` the key file of slot 1 for an image with a key.
"""

import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree

import bridge
import pytest
from conftest import GROUND

#: Limit of each wait, s. Seconds are usual; a loaded machine takes longer.
LIMIT_S = 90
XTCE = "{http://www.omg.org/spec/XTCE/20180204}"


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for(what, found):
    """First result of ``found`` that is not None."""
    deadline = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline:
        result = found()
        if result is not None:
            return result
        time.sleep(0.1)
    pytest.fail(f"{what}: not within {LIMIT_S} s")


@pytest.fixture(scope="module")
def ports():
    return {"http": free_port(socket.SOCK_STREAM), "tm": free_port(socket.SOCK_DGRAM),
            "tc": free_port(socket.SOCK_DGRAM)}


@pytest.fixture(scope="module")
def yamcs(ports, tmp_path_factory):
    """Client of a Yamcs server with the committed configuration on free ports."""
    if not shutil.which("java"):
        pytest.skip("no Java: Yamcs cannot run (Debian: apt-get install default-jre-headless)")
    import fprime_yamcs_bundle
    from yamcs.client import ConnectionFailure, YamcsClient

    folder = tmp_path_factory.mktemp("yamcs")
    for name, changes in {
        "yamcs.yaml": {"8090": ports["http"]},
        "yamcs.inertia.yaml": {"10015": ports["tm"], "10025": ports["tc"]},
        "processor.yaml": {},
    }.items():
        text = (GROUND / "yamcs" / name).read_text(encoding="utf-8")
        for old, new in changes.items():
            assert text.count(old) == 1
            text = text.replace(old, str(new))
        (folder / name).write_text(text, encoding="utf-8")
    # The server reads link.xml from its working folder, and writes a cache there.
    shutil.copy(GROUND / "link.xml", folder)
    jars = pathlib.Path(fprime_yamcs_bundle.__file__).parent / "lib" / "*"
    words = ["java", "-Xmx512m", "-XX:TieredStopAtLevel=1", "-cp", str(jars), "org.yamcs.YamcsServer",
             "--etc-dir", str(folder), "--data-dir", str(folder / "data")]
    log = open(folder / "log", "w", encoding="utf-8")
    server = subprocess.Popen(words, cwd=folder, stdout=log, stderr=log)

    def running():
        assert server.poll() is None, (folder / "log").read_text(encoding="utf-8")[-3000:]
        try:
            client = YamcsClient(f"127.0.0.1:{ports['http']}")
            states = {instance.name: instance.state for instance in client.list_instances()}
        except ConnectionFailure:
            return None
        return client if states.get("inertia") == "RUNNING" else None

    try:
        yield wait_for("Yamcs", running)
    finally:
        server.terminate()
        server.wait()
        log.close()


@pytest.fixture(scope="module")
def processor(yamcs):
    return yamcs.get_processor("inertia", "realtime")


@pytest.fixture(scope="module")
def values(processor):
    """Current values of parameters by name; those without a value are left out."""

    def read(*names):
        found = processor.get_parameter_values([f"/inertia/{name}" for name in names])
        return {value.name.rpartition("/")[2]: value.eng_value for value in found if value}

    return read


@pytest.fixture(scope="module")
def flight(ports, tmp_path_factory):
    """The flight image in QEMU with the bridge on its serial port."""
    image = os.environ.get("FLIGHT_IMAGE")
    if not image:
        pytest.skip("FLIGHT_IMAGE names no flight image")
    qemu = subprocess.Popen(
        ["qemu-system-arm", "-machine", "netduinoplus2", "-display", "none", "-monitor", "none",
         "-kernel", image, "-serial", "pty"],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    line = qemu.stdout.readline()
    device = re.search(r"/dev/\S+", line)
    assert device, f"QEMU named no pseudo-terminal: {line}"
    words = [sys.executable, bridge.__file__, device.group(), "--tm", f"127.0.0.1:{ports['tm']}",
             "--tc", f"127.0.0.1:{ports['tc']}"]
    key = os.environ.get("FLIGHT_KEY")
    process = subprocess.Popen(words + (["--key", key] if key else []))
    try:
        yield process
    finally:
        for child in (process, qemu):
            child.terminate()
            child.wait()


def test_yamcs_has_every_parameter_and_telecommand(yamcs):
    tree = ElementTree.parse(bridge.DESCRIPTION)
    described = [
        {element.get("name") for element in tree.iter(XTCE + kind) if element.get("abstract") != "true"}
        for kind in ("Parameter", "MetaCommand")
    ]
    mdb = yamcs.get_mdb("inertia")
    parameters = {parameter.name for parameter in mdb.list_parameters()
                  if parameter.qualified_name.startswith("/inertia/")}
    commands = {command.name for command in mdb.list_commands() if not command.abstract}
    assert [parameters, commands] == described
    print(len(parameters), "parameters,", len(commands), "telecommands")


def test_yamcs_decodes_every_value(values, ports, telemetry):
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    every = {name for sample in telemetry for name in sample["values"]}
    seen = {}
    # The packets without optional values come first: what they lack must have no value.
    for sample in sorted(telemetry, key=lambda sample: len(sample["values"])):
        packet = bytes.fromhex(sample["packet"])
        out.sendto(packet, ("127.0.0.1", ports["tm"]))
        checksum = int.from_bytes(packet[-2:], "big")
        wait_for(sample["container"], lambda: values("checksum").get("checksum") == checksum or None)
        seen |= sample["values"]
        assert values(*every) == seen
    assert seen.keys() == every


def test_yamcs_encodes_every_telecommand(processor, telecommands):
    for sample in telecommands:
        sent = processor.issue_command(f"/inertia/{sample['command']}", args=sample["arguments"], dry_run=True)
        assert sent.binary.hex() == sample["packet"][:-4], sample["command"]


def test_argument_out_of_range_is_refused_by_yamcs(processor):
    from yamcs.client import YamcsError

    with pytest.raises(YamcsError, match="range"):
        processor.issue_command("/inertia/set_telemetry_period", args={"period_ms": 5}, dry_run=True)


def test_telecommands_from_yamcs_are_obeyed_by_the_flight_image(flight, processor, values):
    # Values of the samples last until the first packets of the image arrive.
    wait_for("status", lambda: values("status_uptime_s").get("status_uptime_s", 600) < 600 or None)
    assert values("status_last_command_present") == {"status_last_command_present": False}

    def answered(command):
        wait_for(f"answer to {command}", lambda: values("status_last_command").get("status_last_command") == command
                 or None)
        return values("status_last_command_done")["status_last_command_done"]

    processor.issue_command("/inertia/select", args={"estimator": "joint-ekf"})
    assert answered("select")
    wait_for("estimator", lambda: values("estimate_estimator").get("estimate_estimator") == "joint-ekf" or None)

    prior = {"jxx": 0.0625, "jyy": 0.125, "jzz": 0.125, "jxy": 0.0, "jxz": 0.0, "jyz": 0.0}
    sigma = {"jxx": 0.03125, "jyy": 0.03125, "jzz": 0.03125, "jxy": 0.0078125, "jxz": 0.0078125, "jyz": 0.0078125}
    given = {f"inertia_{element}_kg_m2": value for element, value in prior.items()}
    given |= {f"sigma_{element}_kg_m2": value for element, value in sigma.items()}
    processor.issue_command("/inertia/set_prior", args=given)
    assert answered("set_prior")
    names = [f"estimate_inertia_kg_m2_{number}" for number in range(1, 7)]
    wait_for("prior", lambda: list(values(*names).values()) == list(prior.values()) or None)
    assert values("status_uplink_accepted")["status_uplink_accepted"] == 2
    assert flight.poll() is None
