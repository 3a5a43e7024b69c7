"""The command line, for comparison. ``HOST_SIM`` is its path; without it these tests are skipped."""

import json
import os
import subprocess

import pytest


@pytest.fixture(scope="session")
def command_text():
    """Standard output of ``host-sim ARGUMENTS``."""
    program = os.environ.get("HOST_SIM")
    if not program:
        pytest.skip("HOST_SIM names no program to compare with")

    def run(*arguments):
        words = [program, *map(str, arguments)]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def command(command_text):
    """Document of ``host-sim ARGUMENTS --json``."""
    return lambda *arguments: json.loads(command_text(*arguments, "--json"))


@pytest.fixture(scope="session")
def flight_folder(tmp_path_factory):
    """Folder of a simulated flight: ``log.csv``, ``craft.toml``, ``history.csv``."""
    program = os.environ.get("HOST_SIM")
    if not program:
        pytest.skip("HOST_SIM names no program to compare with")
    folder = tmp_path_factory.mktemp("flight")
    words = [program, "run", "cubesat-pyramid", "--seed", "4", "--out", str(folder)]
    subprocess.run(words, check=True, capture_output=True)
    return folder
