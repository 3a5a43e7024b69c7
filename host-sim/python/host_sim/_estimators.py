"""Estimators of the flight core, stepped from Python."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._inputs import Source, source_of
from ._results import ReplayResult


@dataclass(frozen=True)
class Sample:
    """One sample, body axes.

    Attributes:
        time_us: time of the sample, µs of any clock.
        rate_rad_s: body rate relative to inertial space, rad/s.
        wheel_speed_rad_s: speed of each wheel relative to the body, rad/s, in the order of the craft.
        torque_n_m: known external torque, N m.
        attitude: quaternion from inertial to body axes, scalar last; for the ``momentum`` estimators.
    """

    time_us: int
    rate_rad_s: Sequence[float] | NDArray[np.float64]
    wheel_speed_rad_s: Sequence[float] | NDArray[np.float64] = ()
    torque_n_m: Sequence[float] | NDArray[np.float64] = (0.0, 0.0, 0.0)
    attitude: Sequence[float] | NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Outcome:
    """Outcome of a step.

    Attributes:
        name: ``updated``, ``aligning``, a reason of rejection, or a reason of a reset.
        used_sample: the sample is in the estimate.
    """

    name: str
    used_sample: bool


def _whole(name: str, value: object) -> int:
    """A whole number, or an error that names it."""
    try:
        whole = int(value)  # type: ignore[call-overload]
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}; it takes a whole number") from None
    if whole != value or whole < 0:
        raise ValueError(f"{name} is {value!r}; it takes a whole number from 0 on")
    return whole


def _numbers(name: str, values: Iterable[float], count: int | None = None) -> list[float]:
    """Numbers, or an error that names them."""
    try:
        numbers = [float(x) for x in values]
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {values!r}; it takes a sequence of numbers") from None
    if count is not None and len(numbers) != count:
        raise ValueError(f"{name} has {len(numbers)} numbers; it takes {count}")
    return numbers


class SteppedEstimator:
    """An estimator of the flight core, by its name.

    Args:
        craft: as of :func:`host_sim.replay`. The gyro noise has to be stated, except for ``window``.
        sample_period_s: typical time between samples, s.
        precision: ``"f32"``, as in flight, or ``"f64"``.
        name: a name of :func:`host_sim.estimators`; of the class unless given.

    An estimator belongs to the thread that has made it.
    """

    #: Name on the command line.
    NAME: ClassVar[str] = "window"

    def __init__(
        self,
        craft: Source,
        *,
        sample_period_s: float,
        precision: str = "f32",
        name: str | None = None,
    ) -> None:
        self._thread = threading.get_ident()
        self._inner = _native.Estimator(name or self.NAME, source_of(craft), sample_period_s, precision)

    def _own(self) -> _native.Estimator:
        if threading.get_ident() != self._thread:
            raise RuntimeError("an estimator belongs to the thread that has made it; make one per thread")
        return self._inner

    def step(self, sample: Sample) -> Outcome:
        """Process one sample."""
        attitude = sample.attitude
        name, used = self._own().step(
            _whole("time_us", sample.time_us),
            _numbers("rate_rad_s", sample.rate_rad_s, 3),
            _numbers("wheel_speed_rad_s", sample.wheel_speed_rad_s),
            _numbers("torque_n_m", sample.torque_n_m, 3),
            None if attitude is None else _numbers("attitude", attitude, 4),
        )
        return Outcome(name, used)

    def finish(self) -> None:
        """Complete the work that is due on the samples so far: for the end of a record."""
        self._own().finish()

    def estimate(self) -> ReplayResult:
        """Estimate after the last sample. It has no history."""
        return ReplayResult(json.loads(self._own().estimate()), None)

    @property
    def rate_rad_s(self) -> NDArray[np.float64]:
        """Filtered body rate, rad/s."""
        return np.array(self._own().rate_rad_s())


class Window(SteppedEstimator):
    """``window``: Gauss-Newton fit of each manoeuvre as a whole, at the Cramér-Rao bound."""

    NAME = "window"


class JointEkf(SteppedEstimator):
    """``joint-ekf``: nine-state filter of rate and inertia in UD form, in the flight image."""

    NAME = "joint-ekf"


class EkfSgfRls(SteppedEstimator):
    """``ekf-sgf-rls``: rate filter, Savitzky-Golay filter, recursive least squares of the moments."""

    NAME = "ekf-sgf-rls"


class EkfSgfLls(SteppedEstimator):
    """``ekf-sgf-lls``: rate filter, Savitzky-Golay filter, batch least squares of all elements."""

    NAME = "ekf-sgf-lls"


class MomentumBatch(SteppedEstimator):
    """``momentum-batch``: conservation of momentum, all elements at once. It needs the attitude."""

    NAME = "momentum-batch"
