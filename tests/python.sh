#!/usr/bin/env bash
# The Python package: wheel, its metadata, and its tests and notebook in an empty environment, against the program.
#
# Arguments are those of `cargo build`, as --release. HOST_SIM: the program, where it has been built. Needs Python 3.10 or later
# and PyPI.
set -euo pipefail

cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}
profile=debug
for argument in "$@"; do [ "$argument" = --release ] && profile=release; done

if [ -z "${HOST_SIM:-}" ]; then
    cargo build --package host-sim "$@"
    HOST_SIM=$target/$profile/host-sim
fi
HOST_SIM=$(realpath "$HOST_SIM")

rm -rf "$target/python"
mkdir -p "$target/python"
folder=$(cd "$target/python" && pwd)
python3 -m venv "$folder/build"
"$folder/build/bin/pip" install --quiet 'maturin>=1.9,<2' twine
"$folder/build/bin/maturin" build --quiet --manifest-path host-sim/python/Cargo.toml --out "$folder/wheel" "$@"
"$folder/build/bin/twine" check --strict "$folder"/wheel/*.whl

python3 -m venv "$folder/empty"
wheel=$(echo "$folder"/wheel/*.whl)
"$folder/empty/bin/pip" install --quiet "${wheel}[test]"
HOST_SIM=$HOST_SIM "$folder/empty/bin/pytest" --quiet host-sim/python/tests
