"""On-board spacecraft inertia estimation: the program ``host-sim`` on numpy arrays.

All quantities are in SI units, body axes about the centre of mass. The elements of a tensor are
ordered ``jxx jyy jzz jxy jxz jyz``. Arithmetic is that of the flight core, in ``f32`` or ``f64``: results
equal those of the command line to the last bit. Bad input raises ``ValueError`` with the message of the
command line.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence

from . import _native
from ._estimators import (
    EkfSgfLls,
    EkfSgfRls,
    JointEkf,
    MomentumBatch,
    Outcome,
    Sample,
    SteppedEstimator,
    Window,
)
from ._inputs import Log, Source, columns_of, source_of
from ._results import (
    CrlbResult,
    DesignResult,
    DiagnosisResult,
    History,
    McResult,
    ReplayResult,
    Result,
    RunResult,
)

__all__ = [
    "CrlbResult",
    "DesignResult",
    "DiagnosisResult",
    "EkfSgfLls",
    "EkfSgfRls",
    "History",
    "JointEkf",
    "McResult",
    "MomentumBatch",
    "Outcome",
    "ReplayResult",
    "Result",
    "RunResult",
    "Sample",
    "SteppedEstimator",
    "Window",
    "crlb",
    "design",
    "diagnose",
    "draft_craft",
    "estimators",
    "mc",
    "replay",
    "run",
    "scenarios",
]


def replay(craft: Source, log: Log, *, estimator: str = "window", precision: str = "f32") -> ReplayResult:
    """Estimate the inertia from a recorded log.

    Args:
        craft: path of a ``CRAFT.toml``, or its content as a dictionary: wheels, gyro, prior.
        log: path of a CSV or Parquet file, or its columns: a mapping of names to arrays, or a data frame.
            Names are those of a log file: ``t_s``, ``gyro_x_rad_s``, …, ``wheel_1_rad_s``, …,
            ``torque_x_n_m``, …, or those that ``[log]`` of the craft maps.
        estimator: a name of :func:`estimators`.
        precision: ``"f32"``, as in flight, or ``"f64"``.

    Raises:
        ValueError: craft or log is rejected; the message names the key or the row.
    """
    document, history = _native.replay(source_of(craft), columns_of(log), estimator, precision)
    return ReplayResult(json.loads(document), History(history))


def run(
    scenario: Source = "stsat3-spin-up",
    *,
    seed: int = 0,
    estimator: str = "window",
    precision: str = "f32",
) -> RunResult:
    """Simulate a flight, estimate the inertia, and compare it with truth and Cramér-Rao bound.

    Args:
        scenario: name of :func:`scenarios`, path of a ``SCENARIO.toml``, or its content as a dictionary.
        seed: seed of gyro noise and dispersion.
        estimator: a name of :func:`estimators`.
        precision: ``"f32"``, as in flight, or ``"f64"``.
    """
    document, history, log = _native.run(source_of(scenario), seed, estimator, precision)
    return RunResult(json.loads(document), History(history), log)


def mc(
    scenario: Source,
    runs: int,
    *,
    seed: int = 0,
    estimator: str = "window",
    precision: str = "f32",
) -> McResult:
    """Monte Carlo campaign over gyro noise and the dispersion of the scenario, on all cores.

    The interpreter is free meanwhile. Ctrl-C ends the campaign with ``KeyboardInterrupt``.

    Args:
        scenario: as of :func:`run`.
        runs: number of runs; run ``i`` has the seed ``seed + i``.
        seed: seed of the first run.
        estimator: a name of :func:`estimators`.
        precision: ``"f32"``, as in flight, or ``"f64"``.
    """
    document, rows = _native.mc(source_of(scenario), runs, seed, estimator, precision)
    return McResult(json.loads(document), rows)


def crlb(scenario: Source = "stsat3-spin-up", *, seed: int | None = None) -> CrlbResult:
    """Cramér-Rao bound of a scenario: the smallest sigma of any unbiased estimator.

    Args:
        scenario: as of :func:`run`.
        seed: seed of a truth that differs from run to run.
    """
    return CrlbResult(json.loads(_native.crlb(source_of(scenario), seed)))


def diagnose(craft: Source, log: Log) -> DiagnosisResult:
    """Rank the causes that explain the residuals of a log.

    Args:
        craft, log: as of :func:`replay`.
    """
    return DiagnosisResult(json.loads(_native.diagnose(source_of(craft), columns_of(log))))


def draft_craft(log: Log) -> str:
    """Draft a craft file from a log: columns, units and clock.

    Write the text to a file, confirm the lines marked ``CONFIRM``, fill in those marked ``FILL IN``, and give
    the path to :func:`replay`.

    Args:
        log: as of :func:`replay`, with any names of columns.

    Raises:
        ValueError: no column of time, or none of a gyro, is recognised.
    """
    return _native.draft_craft(columns_of(log))


def design(
    subject: str | os.PathLike[str],
    *,
    duration_s: float = 60.0,
    excursion_deg: float = 5.0,
    rate_deg_s: float | None = None,
    torque_share: float = 1.0,
    momentum_share: float = 1.0,
    return_deg: float = 0.1,
    keep_out: Iterable[tuple[Sequence[float], Sequence[float], float]] = (),
    optimality: str = "a",
    hardware: str = "considered",
    rate_hz: float = 10.0,
    starts: int = 4,
    seed: int = 0,
) -> DesignResult:
    """Design the wheel torques that minimise the expected sigma of the inertia within limits.

    Args:
        subject: path of a scenario or craft file, or name of :func:`scenarios`.
        duration_s: duration of the manoeuvre, s.
        excursion_deg: largest rotation from the attitude at the start, deg.
        rate_deg_s: largest body rate, deg/s; unlimited if None.
        torque_share, momentum_share: share of each wheel's torque and speed that may be used.
        return_deg: largest rotation left at the end, deg.
        keep_out: cones as boresight in body axes, direction in inertial axes, half angle in deg.
        optimality: ``"a"``, sum of variances; ``"d"``, volume; ``"e"``, worst direction.
        hardware: ``"considered"`` or ``"solved"``: treatment of the stated errors.
        rate_hz: samples per second of the gyro of a craft file, Hz.
        starts: manoeuvres from which the search starts.
        seed: seed of starts and of samples of the prior.

    Ctrl-C ends the search with ``KeyboardInterrupt``.
    """
    options = {
        "--duration": duration_s,
        "--excursion": excursion_deg,
        "--torque": torque_share,
        "--momentum": momentum_share,
        "--return": return_deg,
        "--optimality": optimality,
        "--hardware": hardware,
        "--rate-hz": rate_hz,
        "--starts": starts,
        "--seed": seed,
    }
    if rate_deg_s is not None:
        options["--rate"] = rate_deg_s
    arguments = [os.fspath(subject)]
    arguments += [f"{name}={value}" for name, value in options.items()]
    for boresight, direction, angle_deg in keep_out:
        cone = (",".join(str(float(x)) for x in axis) for axis in (boresight, direction))
        arguments.append(f"--keep-out={':'.join(cone)}:{float(angle_deg)}")
    return DesignResult(json.loads(_native.design(arguments)))


def estimators() -> list[str]:
    """Names of the estimators, the default first."""
    return _native.estimators()


def scenarios() -> list[str]:
    """Names of the built-in scenarios, the default first."""
    return _native.scenarios()
