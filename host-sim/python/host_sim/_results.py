"""Results: the documents of ``--json``, with lists of numbers as numpy arrays.

A number that is ``null`` in a document is NaN in an array. Every key of a document is an attribute.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Elements of a tensor, in their order.
ELEMENTS = ("jxx", "jyy", "jzz", "jxy", "jxz", "jyz")
_ROWS = (0, 1, 2, 0, 0, 1)
_COLUMNS = (0, 1, 2, 1, 2, 2)

Array = NDArray[np.float64]


class Result:
    """A document. Its keys are attributes."""

    def __init__(self, document: dict[str, Any]) -> None:
        self._document = document
        for key, value in document.items():
            setattr(self, key, _value(value))

    def to_dict(self) -> dict[str, Any]:
        """The document of ``--json``, as plain Python objects."""
        return copy.deepcopy(self._document)

    def __repr__(self) -> str:
        shown = {
            key: value
            for key, value in self._document.items()
            if isinstance(value, (str, int, float, bool)) or value is None
        }
        fields = ", ".join(f"{key}={value!r}" for key, value in shown.items())
        return f"{type(self).__name__}({fields})"


def _value(value: Any) -> Any:
    if not isinstance(value, list) or not value:
        return value
    flat = value
    while isinstance(flat, list) and flat and isinstance(flat[0], list):
        flat = [cell for row in flat if isinstance(row, list) for cell in row]
    if all(isinstance(cell, bool) for cell in flat):
        return np.array(value)
    if all(cell is None or (isinstance(cell, (int, float)) and not isinstance(cell, bool)) for cell in flat):
        try:
            return np.array(value, dtype=np.float64)
        except (TypeError, ValueError):
            return value
    return value


class History:
    """State of the estimator after each sample: arrays of one row per sample.

    Attributes:
        t_s: time since the first sample, s.
        gyro_rad_s: measured body rate, rad/s.
        rate_rad_s: estimated body rate, rad/s.
        rate_sigma_rad_s: one sigma of it, rad/s; NaN where the sample was not predicted.
        acceleration_rad_s2: angular acceleration, rad/s²; NaN without a differentiator.
        acceleration_delay_s: delay of its instant, s.
        innovation_rad_s: measured minus predicted rate, rad/s.
        innovation_sigma_rad_s: one sigma of it, rad/s.
        nis: normalised innovation squared, three degrees of freedom.
        inertia_kg_m2: elements of the tensor, kg m².
        sigma_kg_m2: one sigma of each, kg m².
        outcome: outcome of each step, as ``updated``.
    """

    t_s: Array
    gyro_rad_s: Array
    rate_rad_s: Array
    rate_sigma_rad_s: Array
    acceleration_rad_s2: Array
    acceleration_delay_s: Array
    innovation_rad_s: Array
    innovation_sigma_rad_s: Array
    nis: Array
    inertia_kg_m2: Array
    sigma_kg_m2: Array
    outcome: list[str]

    def __init__(self, arrays: dict[str, Any]) -> None:
        for key, value in arrays.items():
            setattr(self, key, value)

    def __len__(self) -> int:
        return len(self.t_s)


class ReplayResult(Result):
    """Estimate from a log.

    Attributes:
        status: ``converged``, ``partial``, ``unobservable`` or ``diverged``.
        samples, accepted: samples in the log, and used in the estimate.
        rejected: rejected samples by reason.
        inertia_kg_m2: inertia tensor, 3 × 3, wheels locked and included, kg m².
        sigma_kg_m2: one sigma of each element, kg m².
        sigma_random_kg_m2, sigma_systematic_kg_m2: its parts by noise and by errors of the hardware.
        covariance_kg2_m4: covariance of the elements, 6 × 6, kg² m⁴.
        observed_directions: 0 to 6.
        element_observed: observability of each element.
        physical: tensor of a rigid body.
        disturbance_torque_n_m: constant disturbance torque, N m; None unless asked for.
        gyro_bias_rad_s: gyro bias, rad/s; None unless asked for.
        residual_rms_rad_s: RMS of measured minus estimated rate, rad/s.
        residuals_white: result of the test for white noise; None if not tested.
        notes: notes on input and set-up.
        history: state after each sample; None from a stepped estimator.
    """

    estimator: str
    precision: str
    status: str
    samples: int
    accepted: int
    rejected: dict[str, int]
    inertia_kg_m2: Array
    sigma_kg_m2: Array
    sigma_random_kg_m2: Array
    sigma_systematic_kg_m2: Array
    covariance_kg2_m4: Array
    observed_directions: int
    element_observed: NDArray[np.bool_]
    scale_observed: bool
    physical: bool
    disturbance_torque_n_m: Array | None
    gyro_bias_rad_s: Array | None
    residual_rms_rad_s: float
    residuals_white: bool | None
    notes: list[str]

    def __init__(self, document: dict[str, Any], history: History | None) -> None:
        super().__init__(document)
        self.history = history

    @property
    def elements_kg_m2(self) -> Array:
        """Elements of the tensor, kg m²."""
        return self.inertia_kg_m2[_ROWS, _COLUMNS]

    def _truth_kg_m2(self) -> Array | None:
        return None

    def plot(self) -> Figure:
        """Each element over time with one sigma; of a simulated flight the truth."""
        if self.history is None:
            raise ValueError("a stepped estimator keeps no history; plot the result of replay or run")
        figure, axes = _figure(2, 3)
        history, truth = self.history, self._truth_kg_m2()
        for i, axis in enumerate(axes.flat):
            value, sigma = history.inertia_kg_m2[:, i], history.sigma_kg_m2[:, i]
            axis.plot(history.t_s, value, label="estimate")
            axis.fill_between(history.t_s, value - sigma, value + sigma, alpha=0.3, label="one sigma")
            if truth is not None:
                axis.axhline(truth[i], color="black", linestyle="--", label="truth")
            final, spread = value[-1], 20.0 * sigma[-1]
            if np.isfinite(final) and np.isfinite(spread) and spread > 0.0:
                axis.set_ylim(final - spread, final + spread)
            axis.set_title(ELEMENTS[i])
            axis.set_xlabel("time, s")
            axis.set_ylabel("kg m²")
        axes.flat[0].legend()
        figure.suptitle(f"{self.estimator}, {self.precision}: {self.status}")
        return figure


class RunResult(ReplayResult):
    """Estimate from a simulated flight: that of a log, and

    Attributes:
        scenario: name of the scenario.
        seed: seed of gyro noise and dispersion.
        truth_kg_m2: true elements at the end of the flight, kg m².
        bound_kg_m2: Cramér-Rao bound of each element, kg m²; NaN if it is unobserved.
        joint_bound_kg_m2: the bound with the stated errors of the hardware among the unknowns; NaN of ideal hardware.
        error_percent: estimated minus true, per cent; NaN if the element is zero.
        error_over_sigma: estimated minus true over the reported sigma.
        log: the simulated log by the columns of a log file, for :func:`host_sim.replay`.
    """

    scenario: str
    seed: int
    truth_kg_m2: Array
    bound_kg_m2: Array
    joint_bound_kg_m2: Array
    error_percent: Array
    error_over_sigma: Array

    def __init__(self, document: dict[str, Any], history: History, log: dict[str, Array]) -> None:
        super().__init__(document, history)
        self.log = log

    def _truth_kg_m2(self) -> Array | None:
        return self.truth_kg_m2


class McResult(Result):
    """Statistics of a campaign.

    Attributes:
        runs, used, diverged, not_converged, silent_lies: numbers of runs.
        truth_kg_m2: true elements, kg m²; the mean if runs differ.
        rmse_kg_m2, bias_kg_m2: RMS and mean of estimated minus true, kg m².
        bound_kg_m2: Cramér-Rao bound, kg m²; the RMS if runs differ.
        rmse_over_bound: RMS of each run's error over its own bound.
        nees_per_dof: mean normalised estimation error squared over its degrees of freedom.
        nees_95: interval of it for a consistent covariance, 95 %.
        rows: columns of the runs, as ``mc --out runs.csv`` writes them: arrays by name.
    """

    scenario: str
    estimator: str
    precision: str
    seed: int
    runs: int
    used: int
    diverged: int
    not_converged: int
    silent_lies: int
    truth_kg_m2: Array
    rmse_kg_m2: Array
    bias_kg_m2: Array
    bound_kg_m2: Array
    rmse_over_bound: Array
    nees_per_dof: float | None
    nees_95: Array | None

    def __init__(self, document: dict[str, Any], rows: dict[str, Any]) -> None:
        super().__init__(document)
        self.rows = {name: np.asarray(cells) for name, cells in rows.items()}

    def plot(self) -> Figure:
        """Histogram of each element's error over the reported sigma, beside the normal distribution."""
        figure, axes = _figure(2, 3)
        used = self.rows["shown"].astype(bool) & ~self.rows["diverged"].astype(bool)
        x = np.linspace(-5.0, 5.0, 201)
        normal = np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi)
        for element, axis in zip(ELEMENTS, axes.flat):
            error = self.rows[f"error_{element}_kg_m2"] / self.rows[f"sigma_{element}_kg_m2"]
            axis.hist(error[used], bins=x[::8], density=True, alpha=0.6)
            axis.plot(x, normal, color="black")
            axis.set_title(element)
            axis.set_xlabel("error / sigma")
        figure.suptitle(f"{self.scenario}, {self.estimator}: {self.runs} runs")
        return figure


class CrlbResult(Result):
    """Cramér-Rao bound.

    Attributes:
        scenario: name of the scenario.
        unknowns: names of the unknowns.
        bound_kg_m2: bound of each element, one sigma, kg m²; NaN if it is unobserved.
        bound_percent: the same in per cent of the true element.
        observed_directions: 0 to 6.
    """

    scenario: str
    unknowns: list[str]
    bound_kg_m2: Array
    bound_percent: Array
    observed_directions: int

    def plot(self) -> Figure:
        """Bound of each element, kg m²."""
        figure, axes = _figure(1, 1)
        axis = axes.flat[0]
        axis.bar(ELEMENTS, self.bound_kg_m2)
        axis.set_yscale("log")
        axis.set_ylabel("Cramér-Rao bound, kg m²")
        figure.suptitle(self.scenario)
        return figure


class DiagnosisResult(Result):
    """Causes that explain the residuals of a log.

    Attributes:
        explanations: dictionaries with name, value, sigma, unit, chi_square, share_explained, remedy, best first.
        measured_noise_rad_s: gyro noise by differences of the readings, rad/s.
        chi_square: chi-square of the log as it is; None if no model follows the motion.
        readings: number of scalar readings.
    """

    explanations: list[dict[str, Any]]
    measured_noise_rad_s: float
    chi_square: float | None
    readings: float

    def plot(self) -> Figure:
        """Share of the excess of chi-square that each cause explains."""
        figure, axes = _figure(1, 1)
        axis = axes.flat[0]
        shown = self.explanations[::-1]
        names = [f"{row['name']} {row['component']}".strip() for row in shown]
        axis.barh(names, [row["share_explained"] for row in shown])
        axis.set_xlabel("share of the excess of chi-square")
        return figure


class DesignResult(Result):
    """A designed manoeuvre.

    Attributes:
        duration_s: duration, s.
        sigma_before_kg_m2: one sigma of the prior, kg m²; None if the inertia is known.
        sigma_kg_m2: one sigma after the manoeuvre, kg m².
        gain: sigma of the best standard manoeuvre over that of the design.
        step_s: time between the rows of the torque table, s.
        torque_n_m: torque of each motor on its wheel, N m, a row a step.
        limits: use of each limit, and its share in what limits the design.
    """

    scenario: str
    duration_s: float
    sigma_before_kg_m2: Array | None
    sigma_kg_m2: Array
    gain: float
    step_s: float
    torque_n_m: Array
    limits: list[dict[str, Any]]

    def plot(self) -> Figure:
        """Torque of each motor over time."""
        figure, axes = _figure(1, 1)
        axis = axes.flat[0]
        time_s = self.step_s * np.arange(len(self.torque_n_m))
        for i, torque_n_m in enumerate(self.torque_n_m.T):
            axis.plot(time_s, torque_n_m, label=f"wheel {i + 1}")
        axis.set_xlabel("time, s")
        axis.set_ylabel("motor torque, N m")
        axis.legend()
        figure.suptitle(self.scenario)
        return figure


def _figure(rows: int, columns: int) -> tuple[Figure, Any]:
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install 'host-sim[plot]'") from error
    return pyplot.subplots(
        rows, columns, figsize=(4.0 * columns, 3.0 * rows), layout="constrained", squeeze=False
    )
