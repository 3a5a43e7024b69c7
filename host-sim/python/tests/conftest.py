"""The command line, for comparison. ``HOST_SIM`` is its path; without it these tests are skipped."""

import json
import os
import subprocess

import pytest


@pytest.fixture(scope="session")
def command():
    """Document of ``host-sim ARGUMENTS --json``."""
    program = os.environ.get("HOST_SIM")
    if not program:
        pytest.skip("HOST_SIM names no program to compare with")

    def run(*arguments):
        words = [program, *map(str, arguments), "--json"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


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
