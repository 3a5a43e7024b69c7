"""Results equal those of the command line to the last bit, in both precisions."""

import csv

import numpy as np
import pytest

import host_sim

METHODS = [
    ("window", "f32"),
    ("window", "f64"),
    ("joint-ekf", "f32"),
    ("joint-ekf", "f64"),
    ("ekf-sgf-rls", "f32"),
    ("momentum-batch", "f64"),
]


def log_columns(folder):
    with open(folder / "log.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}


def options(estimator, precision):
    return ["--estimator", estimator, "--precision", precision]


def without_times(document):
    return {k: v for k, v in document.items() if k not in ("wall_s", "steps_per_s_per_core")}


def prior_of(folder, tmp_path):
    """Craft file of the flight with a prior, which the rate filter needs."""
    craft = tmp_path / "craft.toml"
    text = (folder / "craft.toml").read_text()
    if "[prior]" not in text:
        text += (
            "\n[prior]\ninertia_kg_m2 = [0.06, 0.1, 0.12, 0.0, 0.0, 0.0]\n"
            "sigma_kg_m2 = [0.03, 0.03, 0.03, 0.01, 0.01, 0.01]\n"
        )
    craft.write_text(text)
    return craft


@pytest.mark.parametrize("estimator, precision", METHODS)
def test_replay_of_file_and_of_columns(command, flight_folder, tmp_path, estimator, precision):
    craft, log = prior_of(flight_folder, tmp_path), flight_folder / "log.csv"
    expected = command("replay", "--craft", craft, log, *options(estimator, precision))
    for source in (log, log_columns(flight_folder)):
        found = host_sim.replay(craft, source, estimator=estimator, precision=precision)
        document = found.to_dict()
        # Notes name the file.
        document.pop("notes"), (reference := dict(expected)).pop("notes")
        assert document == reference


def test_replay_of_a_data_frame(command, flight_folder):
    pandas = pytest.importorskip("pandas")
    craft, log = flight_folder / "craft.toml", flight_folder / "log.csv"
    expected = command("replay", "--craft", craft, log)
    found = host_sim.replay(craft, pandas.read_csv(log))
    assert found.to_dict()["covariance_kg2_m4"] == expected["covariance_kg2_m4"]
    assert np.array_equal(found.inertia_kg_m2, np.array(expected["inertia_kg_m2"]))


@pytest.mark.parametrize("estimator, precision", METHODS)
def test_run(command, tmp_path, estimator, precision):
    scenario = "kim-2016" if estimator.startswith("ekf") else "cubesat-pyramid"
    arguments = ["run", scenario, "--seed", 4, *options(estimator, precision)]
    out = tmp_path / "out"
    expected = command(*arguments, "--out", out)
    found = host_sim.run(scenario, seed=4, estimator=estimator, precision=precision)
    assert found.to_dict() == expected
    with open(out / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    history = found.history
    assert len(history) == len(rows) == found.samples
    for i, element in enumerate(("jxx", "jyy", "jzz", "jxy", "jxz", "jyz")):
        column = [float(row[f"{element}_kg_m2"]) for row in rows]
        assert np.array_equal(history.inertia_kg_m2[:, i], column, equal_nan=True)
    nis = [float(row["nis"] or "nan") for row in rows]
    assert np.array_equal(history.nis, nis, equal_nan=True)
    assert history.outcome == [row["outcome"] for row in rows]
    again = host_sim.replay(
        out / "craft.toml",
        found.log,
        estimator=estimator,
        precision=precision,
    )
    assert np.array_equal(again.inertia_kg_m2, found.inertia_kg_m2)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_mc(command, tmp_path, precision):
    file = tmp_path / "runs.csv"
    arguments = ["mc", "random-spacecraft", "--runs", 12, "--seed", 5]
    expected = command(*arguments, *options("window", precision), "--out", file)
    found = host_sim.mc("random-spacecraft", 12, seed=5, precision=precision)
    assert without_times(found.to_dict()) == without_times(expected)
    with open(file, newline="") as rows:
        rows = list(csv.DictReader(rows))
    assert list(found.rows) == list(rows[0])
    for name, cells in found.rows.items():
        if cells.dtype.kind == "f":
            column = [float(row[name] or "nan") for row in rows]
            assert np.array_equal(cells, column, equal_nan=True), name


def test_crlb_design_diagnose(command, flight_folder):
    for scenario in ("microsat-slew", "stsat3-spin-up-data-sheet"):
        assert host_sim.crlb(scenario).to_dict() == command("crlb", scenario)
    craft, log = flight_folder / "craft.toml", flight_folder / "log.csv"
    expected = command("diagnose", "--craft", craft, log)
    assert host_sim.diagnose(craft, log).to_dict() == expected
    assert host_sim.diagnose(craft, log_columns(flight_folder)).to_dict() == expected


def test_draft_is_that_of_the_command(command_text, flight_folder):
    log = flight_folder / "log.csv"
    expected = command_text("init", "--from", log)
    assert host_sim.draft_craft(log) == expected
    of_columns = host_sim.draft_craft(log_columns(flight_folder))
    assert of_columns.splitlines()[1:] == expected.splitlines()[1:]  # the first line names the file
    with pytest.raises(ValueError, match="no columns of time"):
        host_sim.draft_craft({"a": np.zeros(3)})


def test_design(command, tmp_path):
    scenario = tmp_path / "craft.toml"
    wheels = "".join(
        f"[[wheel]]\naxis = {axis}\nspin_inertia_kg_m2 = 1e-5\nmax_torque_n_m = 1e-3\nmax_speed_rad_s = 600\n"
        for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1])
    )
    scenario.write_text(
        wheels + "[gyro]\nnoise_rad_s = 1e-4\n[prior]\n"
        "inertia_kg_m2 = [0.06, 0.1, 0.12, 0, 0, 0]\n"
        "sigma_kg_m2 = [0.006, 0.01, 0.012, 0.003, 0.003, 0.003]\n"
    )
    found = host_sim.design(scenario, duration_s=10, excursion_deg=2, starts=1, rate_deg_s=5)
    arguments = ["--duration", 10, "--excursion", 2, "--starts", 1, "--rate", 5]
    assert found.to_dict() == command("design", scenario, *arguments)
    assert found.torque_n_m.shape[1] == 3


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("estimator", [host_sim.Window, host_sim.JointEkf])
def test_stepped_estimator(flight_folder, estimator, precision):
    craft = flight_folder / "craft.toml"
    log = log_columns(flight_folder)
    replayed = host_sim.replay(craft, log, estimator=estimator.NAME, precision=precision)
    period_s = float(np.median(np.diff(log["t_s"])))
    stepped = estimator(craft, sample_period_s=round(period_s, 6), precision=precision)
    wheels = [name for name in log if name.startswith("wheel_")]
    used = 0
    for k, time_s in enumerate(log["t_s"]):
        outcome = stepped.step(
            host_sim.Sample(
                time_us=round(time_s * 1e6),
                rate_rad_s=[log[f"gyro_{axis}_rad_s"][k] for axis in "xyz"],
                wheel_speed_rad_s=[log[name][k] for name in wheels],
                torque_n_m=[log[f"torque_{axis}_n_m"][k] for axis in "xyz"],
            )
        )
        used += outcome.used_sample
    stepped.finish()
    estimate = stepped.estimate()
    for key in ("inertia_kg_m2", "covariance_kg2_m4", "status", "accepted", "hardware"):
        assert estimate.to_dict()[key] == replayed.to_dict()[key], key
    assert used == estimate.accepted
    assert stepped.rate_rad_s.shape == (3,)
