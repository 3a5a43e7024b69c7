#!/usr/bin/env bash
# Speed on this machine: a step of each estimator and of dense filters, campaigns of `mc`, and a textbook EKF over many
# flights at once in numpy and in numba. Argument: runs of a campaign, 10000 if absent.
#
# Needs Python 3.10 or later with venv, and PyPI. The machine should be idle.
set -euo pipefail

cd "$(dirname "$0")/.."
runs=${1:-10000}
target=${CARGO_TARGET_DIR:-target}

printf '=== Steps, items per second\n'
cargo bench --quiet --package host-sim --bench step

printf '\n=== mc stsat3-spin-up --runs %s\n' "$runs"
cargo build --quiet --release --package host-sim
for estimator in window joint-ekf; do
    printf '%-20s' "$estimator"
    "$target/release/host-sim" mc stsat3-spin-up --runs "$runs" --estimator "$estimator" | grep '^speed'
done

printf '\n=== Textbook EKF over many flights\n'
python3 -m venv "$target/speed"
"$target/speed/bin/pip" install --quiet numpy numba
# One core, so that the figure is that of a core.
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 "$target/speed/bin/python" host-sim/benches/filters.py
