"""Samples of packets and telecommands with their values, written by the flight software."""

import json
import pathlib
import sys

import pytest

GROUND = pathlib.Path(__file__).parents[1]
sys.path.insert(0, str(GROUND))


def _samples():
    lines = (GROUND / "samples.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


@pytest.fixture(scope="session")
def telemetry():
    """Telemetry packets with their values."""
    return [sample for sample in _samples() if "values" in sample]


@pytest.fixture(scope="session")
def telecommands():
    """Telecommands with their arguments and packets."""
    return [sample for sample in _samples() if "command" in sample]
