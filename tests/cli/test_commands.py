"""The commands: what they print, and files that are written whole."""

import json
import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from camid.cli import main
from tests.support import linear_rig as rig
from tests.support.command_lines import IDENTIFY, SIMULATE, load, replaced


def test_identify_writes_a_model_that_both_commands_accept(bench, capsys):
    assert main(IDENTIFY) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "natural frequency" in out
    assert "written to model.yaml" in out
    model = load(bench / "model.yaml")
    found = model["plant"]["transfer_function"]
    assert found["denominator"][0] == rig.DENOMINATOR[0]  # two, as it was written
    deviations = model["plant"]["standard_deviations"]
    covariance = np.array(model["plant"]["covariance"])
    assert covariance.shape == (3, 3)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9)
    estimated = [*deviations["numerator"], *deviations["denominator"][1:]]
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), estimated, rtol=1e-9)
    assert deviations["denominator"][0] == 0.0
    errors = np.array([*found["numerator"], *found["denominator"][1:]]) - [*rig.NUMERATOR, *rig.DENOMINATOR[1:]]
    assert np.all(np.abs(errors) < 4.0 * np.array(estimated))
    assert 0.0 < max(np.array(estimated) / [*rig.NUMERATOR, *rig.DENOMINATOR[1:]]) < 0.05

    again = ["identify", "recording.csv", "--simulation", "model.yaml", "--output", "second.yaml"]
    assert main(again) == 0
    second = load(bench / "second.yaml")["plant"]["transfer_function"]
    np.testing.assert_allclose(second["denominator"], found["denominator"], rtol=1e-6)
    assert main(replaced(SIMULATE, "S.yaml", "model.yaml")) == 0
    table = pd.read_csv(bench / "simulated.csv")
    assert np.std(table["y"] - table["simulated"]) / np.std(table["y"]) < 0.12


def test_simulate_writes_a_row_for_every_recorded_row(bench, capsys):
    assert main(SIMULATE) == 0
    assert capsys.readouterr().out.startswith("400 rows written to simulated.csv\n")
    recorded, table = pd.read_csv(bench / "recording.csv"), pd.read_csv(bench / "simulated.csv")
    assert list(table.columns) == ["t", "simulated", "y"]
    np.testing.assert_array_equal(table["t"], recorded["t"])
    np.testing.assert_array_equal(table["y"], recorded["y"])
    assert not table.isna().any().any()
    np.testing.assert_allclose(table["simulated"], rig.film(recorded["u"].to_numpy()), atol=1e-5)


def test_simulate_without_a_recorded_output(bench):
    pd.read_csv("recording.csv").drop(columns="y").to_parquet("input.parquet")
    assert main(replaced(SIMULATE, "recording.csv", "input.parquet", "simulated.csv", "simulated.parquet")) == 0
    table = pd.read_parquet(bench / "simulated.parquet")
    assert list(table.columns) == ["t", "simulated"]
    assert len(table) == 400


@pytest.mark.parametrize("command", [IDENTIFY, SIMULATE, ["identify", "recording.csv", "--order", "2", "0"]])
def test_json_is_all_there_is_on_the_output(bench, capsys, command):
    assert main([*command, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    content = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert content["schema"] == 1
    if command[0] == "identify":
        assert content["converged"] is True
        assert content["rows_fitted"] == 400
        assert content["period"] == pytest.approx(rig.PERIOD)
        assert content["nrmse"] == pytest.approx(0.1, rel=0.1)
        assert content["nrmse_validation"] is None
        scale = content["denominator"][0]
        np.testing.assert_allclose(np.array(content["denominator"]) / scale, [1.0, 3.0, 100.0], rtol=0.03)
    else:
        assert content["rows"] == 400
        assert content["nrmse"] == pytest.approx(0.1, rel=0.1)


def test_json_knows_no_infinity(bench, capsys):
    """A validation row alone has no spread to compare with."""
    rig.write_yaml(rig.simulation(validation={"start": 1.0, "end": 1.01}), bench / "S.yaml")
    assert main([*IDENTIFY, "--json"]) == 0
    content = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert content["nrmse_validation"] is None
    assert content["rows_fitted"] == 399


@pytest.mark.parametrize(
    "options", [["--sensor", "instant"], ["--hold", "foh"], ["--exposure", "0.02"], ["--latency", "0.03"]]
)
def test_options_say_what_a_file_says(bench, capsys, options):
    name, value = options[0][2:], options[1]
    content = rig.simulation(plant=rig.plant([1.0], [1.0, 3.0, 100.0]))
    where = content["input"] if name == "hold" else content["sensor"]
    where["kind" if name == "sensor" else name] = value if value.isalpha() else float(value)
    rig.write_yaml(content, bench / "S.yaml")
    assert main([*IDENTIFY, "--json"]) == 0
    by_file = json.loads(capsys.readouterr().out)
    assert main(["identify", "recording.csv", "--order", "2", "0", *options, "--json"]) == 0
    by_options = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose(by_options["denominator"], by_file["denominator"], rtol=1e-4)
    assert main(["identify", "recording.csv", "--order", "2", "0", "--json"]) == 0
    assert abs(json.loads(capsys.readouterr().out)["denominator"][1] - by_file["denominator"][1]) > 1e-3


def test_undetermined_coefficients_have_no_accuracy(bench, capsys):
    """A step that has settled tells nothing of a third-order plant, and nothing may look as if it did."""
    count = np.arange(50)
    table = pd.DataFrame({"t": 0.05 * count, "u": 1.0, "y": np.where(count < 1, 0.0, 1.0)})
    table.to_csv("recording.csv", index=False)
    rig.write_yaml(rig.simulation(plant=rig.plant([1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0])), bench / "S.yaml")
    assert main([*IDENTIFY, "--method", "plain-srivc"]) == 0
    out, err = capsys.readouterr()
    assert out.count("undetermined") == 10  # 6 coefficients, 4 characteristics
    assert out.count("(fixed)") == 1  # the leading one
    assert err.startswith("camid: warning: ")
    assert err.count("\n") == 1
    plant = load(bench / "model.yaml")["plant"]
    assert set(plant) == {"transfer_function", "free"}
    assert main([*IDENTIFY, "--method", "plain-srivc", "--json"]) == 0
    content = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert content["converged"] is False
    assert content["standard_deviations"] is None


def test_an_older_result_is_replaced(bench):
    (bench / "simulated.csv").write_text("older result")
    assert main(SIMULATE) == 0
    assert len(pd.read_csv("simulated.csv")) == 400
    assert sorted(os.listdir()) == ["S.yaml", "recording.csv", "simulated.csv"]


def test_an_iteration_that_fails_says_so(bench, capsys):
    """Noise has no dynamics of order six: whatever comes out, the numbers do not pass for an estimate in silence."""
    noise = np.random.default_rng(0).standard_normal((60, 2))
    pd.DataFrame({"t": 0.05 * np.arange(60), "u": noise[:, 0], "y": noise[:, 1]}).to_csv("noise.csv", index=False)
    assert (
        main(["identify", "noise.csv", "--order", "6", "5", "--method", "plain-srivc", "--output", "m.yaml", "--json"])
        == 0
    )
    out, err = capsys.readouterr()
    assert json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))["converged"] is False
    assert err.startswith("camid: warning: the iteration did not converge; do not use the numbers")
    assert err.count("\n") == 1
    assert "NOT CONVERGED" in (bench / "m.yaml").read_text().splitlines()[0]


@pytest.mark.parametrize(
    "arguments",
    [["--help"], ["-h"], ["identify", "--help"], ["order", "-h"], ["simulate", "-h"], ["track", "-h"], ["--version"]],
)
def test_help(capsys, arguments):
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("camid, version" if arguments == ["--version"] else "Usage: camid")


def test_the_command_line_starts_without_the_engine():
    program = "import sys, camid.cli; print(*{'numpy', 'numba', 'scipy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"


def test_the_module_runs_as_a_program(bench):
    def run(*arguments):
        environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONWARNINGS": "default"}
        return subprocess.run(
            [sys.executable, "-m", "camid", *arguments], capture_output=True, text=True, check=False, env=environment
        )

    done = run(*IDENTIFY)
    assert (done.returncode, done.stderr) == (0, "")
    assert (bench / "model.yaml").exists()
    failed = run(*replaced(SIMULATE, "recording.csv", "none.csv"))
    assert (failed.returncode, failed.stdout) == (2, "")
    assert failed.stderr == "camid: error: none.csv: no such file; check the path\n"


def test_the_correlations_of_the_residual(bench, capsys):
    assert main([*IDENTIFY, "--residuals", "residuals.csv"]) == 0
    out = capsys.readouterr().out
    assert "residual: white (p = " in out
    assert "independent of the input (p = " in out
    assert "written to residuals.csv" in out
    table = pd.read_csv(bench / "residuals.csv")
    assert list(table.columns) == [
        "lag",
        "seconds",
        "autocorrelation",
        "bound_autocorrelation",
        "crosscorrelation",
        "bound_crosscorrelation",
    ]
    assert table["lag"].tolist() == list(range(-25, 26))
    np.testing.assert_allclose(table["seconds"], rig.PERIOD * table["lag"])
    # Computed here again, from what the commands write: the residual of the identified model.
    assert main(replaced(SIMULATE, "S.yaml", "model.yaml")) == 0
    simulated = pd.read_csv(bench / "simulated.csv")
    residual = (simulated["y"] - simulated["simulated"]).to_numpy(copy=True)
    residual -= residual.mean()
    for lag in (1, 7):
        row = table[table["lag"] == lag].iloc[0]
        plain = residual[lag:] @ residual[:-lag] / (residual @ residual)
        assert row["autocorrelation"] == pytest.approx(plain, abs=0.02)
        assert row["bound_autocorrelation"] == pytest.approx(2.576 / 20.0, rel=0.1)
        assert abs(row["crosscorrelation"]) < row["bound_crosscorrelation"] < 2.7 / 20.0


def test_a_wrong_declaration_is_warned_of(bench, capsys):
    assert main(["identify", "recording.csv", "--order", "2", "0", "--sensor", "instant", "--json"]) == 0
    out, err = capsys.readouterr()
    content = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert err.startswith("camid: warning: the residual depends on the input (p ")
    assert err.count("\n") == 1
    assert "a camera with an exposure of 50 ms" in err
    assert content["warnings"] == [err.removeprefix("camid: warning: ").rstrip("\n")]
    analysis = content["residual_analysis"]
    assert analysis["independence_p"] < 1e-3
    assert {"whiteness_p", "lags", "noise_order"} < set(analysis)
    right = [a for a in analysis["alternatives"] if a["changed"] == ["sensor"]]
    assert right[0]["sensor"] == "camera"
    assert right[0]["exposure"] == pytest.approx(rig.PERIOD)
    assert right[0]["passes"] is True


def test_order_finds_the_order(bench, capsys):
    assert main(["order", "recording.csv", "--largest", "2", "--output", "table.csv"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "chosen: --order 2 0" in out
    table = pd.read_csv(bench / "table.csv")
    assert table["chosen"].tolist() == [False, True, False]
    assert main(["order", "recording.csv", "--simulation", "S.yaml", "--largest", "2", "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    content = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert (content["schema"], content["poles"], content["zeros"]) == (1, 2, 0)
    assert content["explained"] is True
    assert [c["delta_bic"] for c in content["candidates"]] == pytest.approx(table["delta_bic"].tolist())


def test_what_is_known_can_be_said_on_the_command_line(bench, capsys):
    """Two recordings of a rig in motion, a known delay, and a known coefficient, as --help has it."""
    rig.recording(300, before=9, latency=1.3).to_csv("first.csv", index=False)
    rig.recording(300, before=12, latency=1.3, seed=4).to_csv("second.csv", index=False)
    common = ["first.csv", "second.csv", "--json"]
    delay = ["--latency", str(1.3 * rig.PERIOD), "--initial-state", "estimate"]
    assert main(["identify", "--order", "2", "0", *delay, *common]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["rows_fitted"] == 2 * 300 - 2 * 3
    assert content["warnings"] == []
    np.testing.assert_allclose(content["denominator"], [1.0, 3.0, 100.0], rtol=0.05)
    known = rig.plant([300.0], [2.0, 6.0, 200.0], free={"numerator": [True], "denominator": [False, False, True]})
    sensor = {"column": "y", "kind": "camera", "latency": 1.3 * rig.PERIOD}
    rig.write_yaml(rig.simulation(plant=known, sensor=sensor, initial_state="estimate"), bench / "S.yaml")
    assert main(["identify", "--simulation", "S.yaml", *common]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["denominator"][1] == 6.0
    assert content["standard_deviations"]["denominator"][:2] == [0.0, 0.0]
    assert content["standard_deviations"]["denominator"][2] > 0.0
    assert main(["identify", "--help"]) == 0
    said = capsys.readouterr().out
    for word in ("--latency", "plant.free", "--initial-state estimate", "several recordings", "camid order"):
        assert word in said


@pytest.mark.parametrize(
    ("raised", "code", "said"), [(EOFError, 2, "a file ends too soon"), (KeyboardInterrupt, 130, "interrupted")]
)
def test_a_module_that_is_cut_short_is_no_interruption(bench, capsys, monkeypatch, raised, code, said):
    """Python leaves a compiled module cut short on a full disk; click takes the EOFError of its import for Ctrl-D."""

    def fail(*_, **__):
        raise raised("marshal data too short")

    monkeypatch.setattr("camid.commands.identify.identify", fail)
    assert main(IDENTIFY) == code
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") - error.startswith("\n") == 1
