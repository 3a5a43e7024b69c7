#!/usr/bin/env bash
# Ground systems: the XTCE description by an independent reader, and the flight image in QEMU through Yamcs.
#
# Needs Python 3.10 or later, PyPI, QEMU and a Java runtime of version 17 or later. Without Java the tests of Yamcs are
# skipped, and pytest prints the reason.
set -euo pipefail

cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}

cargo target build --package fsw-target --bin flight --profile firmware
image=$(cd "$target" && pwd)/thumbv7em-none-eabihf/firmware/flight

rm -rf "$target/ground"
mkdir -p "$target/ground"
python3 -m venv "$target/ground/python"
"$target/ground/python/bin/pip" install --quiet --requirement fsw-target/ground/tests/requirements.txt
FLIGHT_IMAGE=$image "$target/ground/python/bin/python" -m pytest --quiet -rs -p no:cacheprovider fsw-target/ground/tests
