"""Interface of the package: inputs, errors, interrupts, plots."""

import importlib.resources
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import host_sim

CRAFT = {
    "wheel": [{"axis": [0, 0, 1], "spin_inertia_kg_m2": 1e-3}],
    "gyro": {"noise_rad_s": 1e-4},
}
LOG = {
    "t_s": np.arange(30) * 0.1,
    "gyro_x_rad_s": np.full(30, 0.1),
    "gyro_y_rad_s": np.full(30, 0.2),
    "gyro_z_rad_s": np.full(30, 0.3),
    "wheel_1_rad_s": np.arange(30) + 100,
}


def test_craft_and_scenario_may_be_dictionaries():
    result = host_sim.replay(CRAFT, LOG)
    assert result.samples == 30 and result.inertia_kg_m2.shape == (3, 3)
    scenario = {
        "name": "free",
        "duration_s": 10.0,
        "spacecraft": {
            "inertia_kg_m2": np.array([1, 1.1, 1.2, 0, 0, 0]),
            "rate_rad_s": [0.1, 0.2, 0.3],
        },
        "gyro": {"rate_hz": 10.0, "noise_rad_s": 1e-4},
    }
    assert host_sim.run(scenario).scenario == "free"
    assert host_sim.crlb(scenario).observed_directions == 5


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: host_sim.run("stsat"), ["stsat: neither a file nor", "stsat3-spin-up"]),
        (lambda: host_sim.run(estimator="kalman"), ["kalman", "joint-ekf"]),
        (lambda: host_sim.run(precision="f16"), ["f16", "f64"]),
        (lambda: host_sim.mc("stsat3-spin-up", 0), ["runs is 0"]),
        (lambda: host_sim.replay("gone.toml", LOG), ["gone.toml: cannot be read"]),
        (lambda: host_sim.replay(CRAFT | {"gyros": {}}, LOG), ["gyros", "gyro"]),
        (lambda: host_sim.replay(CRAFT, LOG | {"gyro_x_rad_s": np.zeros(7)}), ["7", "30 rows"]),
        (lambda: host_sim.replay(CRAFT, {"t_s": LOG["t_s"]}), ["log", "gyro_x_rad_s"]),
        (lambda: host_sim.replay(CRAFT, np.zeros((30, 4))), ["log: ndarray without named columns", "data frame"]),
        (
            lambda: host_sim.replay(
                CRAFT | {"log": {"wheels": {"columns": ["a"], "file": "wheels.csv"}}}, LOG
            ),
            ["names the file wheels.csv", "merge"],
        ),
        (lambda: host_sim.replay(CRAFT, LOG, estimator="ekf-sgf-rls"), ["[prior]"]),
        (lambda: host_sim.diagnose(CRAFT, {k: v[:5] for k, v in LOG.items()}), ["5 rows"]),
        (lambda: host_sim.design("stsat3-spin-up", duration_s=-1), ["duration", "positive"]),
        (lambda: host_sim.Window(CRAFT, sample_period_s=0), ["sample_period_s"]),
        (lambda: host_sim.JointEkf({"wheel": []}, sample_period_s=1), ["noise_rad_s"]),
    ],
)
def test_bad_input_is_a_value_error_with_the_message_of_the_command(call, words):
    with pytest.raises(ValueError) as raised:
        call()
    for word in words:
        assert word in str(raised.value)


@pytest.mark.parametrize(
    "sample, words",
    [
        (host_sim.Sample(0.5, [0, 0, 0], [1.0]), "time_us is 0.5"),
        (host_sim.Sample(0, [0, 0], [1.0]), "rate_rad_s has 2 numbers; it takes 3"),
        (host_sim.Sample(0, [0, 0, 0], 1.0), "wheel_speed_rad_s is 1.0"),
    ],
)
def test_a_sample_of_another_shape_is_refused_by_name(sample, words):
    estimator = host_sim.Window(CRAFT, sample_period_s=0.1)
    with pytest.raises(ValueError, match=words):
        estimator.step(sample)


def test_a_mapped_log_is_not_applied_to_samples_and_a_note_says_so():
    mapped = CRAFT | {"log": {"gyro": {"columns": ["a", "b", "c"], "unit": "deg/s"}}}
    notes = host_sim.Window(mapped, sample_period_s=0.1).estimate().notes
    assert any("[log] of the craft is for logs" in note for note in notes)


def test_a_column_whose_name_contradicts_its_unit_is_noted():
    names = ["wx_dps", "wy_dps", "wz_dps"]
    log = dict(LOG) | {name: LOG[f"gyro_{axis}_rad_s"] for name, axis in zip(names, "xyz")}
    for unit, is_noted in [("rad/s", True), ("deg/s", False)]:
        mapped = CRAFT | {"log": {"gyro": {"columns": names, "unit": unit}}}
        notes = host_sim.replay(mapped, log).notes
        assert any("its name says deg/s" in note for note in notes) == is_noted, notes


def test_stepped_estimator_refuses_another_number_of_wheels():
    estimator = host_sim.Window(CRAFT, sample_period_s=0.1)
    with pytest.raises(ValueError, match="the craft has 1 wheels"):
        estimator.step(host_sim.Sample(0, [0, 0, 0]))
    outcome = estimator.step(host_sim.Sample(0, [0.1, 0.2, 0.3], [100.0]))
    assert isinstance(outcome.name, str)
    with pytest.raises(ValueError, match="history"):
        estimator.estimate().plot()


def test_estimator_belongs_to_its_thread():
    estimator = host_sim.Window(CRAFT, sample_period_s=0.1)
    raised = []

    def step():
        try:
            estimator.step(host_sim.Sample(0, [0.1, 0.2, 0.3], [100.0]))
        except RuntimeError as error:
            raised.append(str(error))

    thread = threading.Thread(target=step)
    thread.start()
    thread.join()
    assert raised and "thread" in raised[0]


def test_threads_run_during_a_campaign():
    ticks = []
    over = threading.Event()

    def tick():
        while not over.wait(0.01):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    host_sim.mc("cubesat-pyramid", 400, estimator="joint-ekf")
    over.set()
    thread.join()
    assert len(ticks) >= 3


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_ends_a_campaign():
    program = textwrap.dedent("""
        import host_sim
        print("begun", flush=True)
        try:
            host_sim.mc("cubesat-pyramid", 100_000_000)
        except KeyboardInterrupt:
            print("interrupted")
    """)
    words = [sys.executable, "-c", program]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "begun\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=60)
    assert output == "interrupted\n" and process.returncode == 0


def design(folder):
    """A short manoeuvre of three wheels."""
    axes = ([1, 0, 0], [0, 1, 0], [0, 0, 1])
    wheel = "spin_inertia_kg_m2 = 1e-5\nmax_torque_n_m = 1e-3\nmax_speed_rad_s = 600\n"
    text = "".join(f"[[wheel]]\naxis = {axis}\n{wheel}" for axis in axes)
    text += "[gyro]\nnoise_rad_s = 1e-4\n[prior]\ninertia_kg_m2 = [0.06, 0.1, 0.12, 0, 0, 0]\n"
    craft = folder / "design.toml"
    craft.write_text(text + "sigma_kg_m2 = [0.006, 0.01, 0.012, 0.003, 0.003, 0.003]\n")
    return host_sim.design(craft, duration_s=10, excursion_deg=2, starts=1)


def test_results_have_plots_and_documents(tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    run = host_sim.run("cubesat-pyramid")
    campaign = host_sim.mc("cubesat-pyramid", 20, estimator="joint-ekf")
    results = [run, host_sim.replay(CRAFT, LOG), campaign, host_sim.crlb("cubesat-pyramid")]
    results += [host_sim.diagnose(CRAFT, LOG), design(tmp_path)]
    for number, result in enumerate(results):
        file = tmp_path / f"{number}.png"
        result.plot().savefig(file)
        assert file.stat().st_size > 1000
        assert isinstance(result.to_dict(), dict) and type(result).__name__ in repr(result)
    assert run.elements_kg_m2.shape == run.truth_kg_m2.shape == (6,)
    assert campaign.rows["error_jxx_kg_m2"].shape == (20,)


def test_import_needs_no_matplotlib():
    program = "import sys, host_sim; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_package_is_typed_and_documented():
    files = importlib.resources.files("host_sim")
    assert files.joinpath("py.typed").is_file() and files.joinpath("_native.pyi").is_file()
    for name in host_sim.__all__:
        assert getattr(host_sim, name).__doc__, name
    assert host_sim.estimators()[:2] == ["window", "joint-ekf"]
    assert host_sim.scenarios()[0] == "stsat3-spin-up"
