"""``camid init recording``: what it writes loads, says what is a guess, and can be used at once."""

from pathlib import Path

import control
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML
from scipy.io import savemat

import camid
from camid.cli import main
from camid.draft.plant import resonance_of
from camid.draft.roles import says
from camid.draft.simulation import quoted
from camid.simulation.file import load_simulation
from tests.support import linear_rig as rig
from tests.support.two_rates import two_rates


def drafted(capsys, *arguments):
    """Simulation file that the command writes, read again, and its text."""
    assert main(["init", "recording", *map(str, arguments), "-o", "drafted.yaml"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("written to drafted.yaml")
    assert err == ""
    with open("drafted.yaml", encoding="utf-8") as stream:
        text = stream.read()
    return load_simulation("drafted.yaml"), text


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_driven_recording(capsys):
    rig.recording().rename(columns={"t": "time", "u": "volts", "y": "angle"}).to_csv("a.csv", index=False)
    found, text = drafted(capsys, "a.csv")
    assert (found.time_column, found.input_column, found.output_column) == ("time", "volts", "angle")
    assert found.hold == "zoh"
    np.testing.assert_allclose(found.plant.denominator, np.array(rig.DENOMINATOR) / 2.0, rtol=0.2)
    assert text.count("a guess") >= 4
    assert "regular" in text
    assert "# pendulum: {natural_frequency: " in text
    assert camid.identify("a.csv", "drafted.yaml").nrmse < 0.2  # the noise is 0.1; the exposure is for the user to say
    assert main(["diagnose", "a.csv", "--simulation", "drafted.yaml", "--output", "diagnosis", "--no-report"]) == 0


def test_the_pendulum_in_the_comment_loads_in_place_of_the_transfer_function(capsys):
    rig.recording().to_csv("a.csv", index=False)
    _, text = drafted(capsys, "a.csv")
    lines = [line for line in text.splitlines() if "transfer_function:" not in line]
    swapped = "\n".join(line.replace("  # pendulum:", "  pendulum:") for line in lines)
    assert load_simulation(YAML(typ="safe").load(swapped)).pendulum is not None


def decay(count=3000, period=0.01, offset=3.0, encoder=0.002):
    time = period * np.arange(count)
    swing = 0.6 * np.exp(-0.05 * time) * np.cos(5.0 * time)
    rows = encoder * np.round((swing + offset) / encoder)
    return time, rows, np.gradient(rows, period)


def test_a_free_decay_of_an_encoder_without_names_and_with_its_rate(capsys):
    np.savetxt("decay.csv", np.column_stack(decay()), delimiter=",")
    found, text = drafted(capsys, "decay.csv")
    assert found.input_column is None
    assert (found.time_column, found.output_column) == ("column1", "column2")
    assert found.sensor == "instant"
    assert "steps of 0.002 as of an encoder" in text
    assert "column3 (looks like the rate of change of 'column2')" in text
    assert found.plant.denominator[2] == pytest.approx(25.0, rel=0.01)
    assert found.offset == "estimate"
    assert camid.identify("decay.csv", "drafted.yaml").nrmse < 0.05


def test_positions_of_a_marker_are_no_input(capsys):
    """What moves most is the output, although the other coordinate is rougher."""
    time, swing, _ = decay()
    late = {"y": 0.02 * np.sin(2.0 * np.arange(len(time))), "x_std": 0.002, "y_std": 0.003}
    pd.DataFrame({"t": time, "x": swing, **late}).to_csv("tracked.csv", index=False)
    found, text = drafted(capsys, "tracked.csv")
    assert (found.input_column, found.output_column) == (None, "x")
    assert "input: null  # a guess: all columns are positions of a marker: taken for a free decay" in text


def test_runs_side_by_side_with_a_period_in_a_cell(capsys):
    first, second = rig.recording(), rig.recording(seed=4)
    table = pd.DataFrame({"uA": first["u"], "uB": second["u"], "yA": first["y"], "yB": second["y"]})
    table.assign(Ts=[rig.PERIOD, *[np.nan] * (len(table) - 1)]).to_csv("runs.csv", index=False)
    found, text = drafted(capsys, "runs.csv")
    assert found.reading.runs == ({"uA": "uA", "yA": "yA"}, {"uA": "uB", "yA": "yB"})
    assert found.reading.period == rig.PERIOD
    assert "from the single value in the file" in text
    assert camid.identify("runs.csv", "drafted.yaml").rows_fitted >= 796


def test_a_period_that_is_nowhere(capsys):
    rig.recording()[["u", "y"]].to_csv("a.csv", index=False)
    found, text = drafted(capsys, "a.csv")
    assert "NOT IN THE FILE: write the sampling period in s" in text
    assert found.reading.period == 1.0
    assert main(["init", "recording", "a.csv", "--period", "0.05"]) == 0
    assert "time: {period: 0.05}  # as given" in capsys.readouterr().out


def test_cells_and_structures_of_a_mat_file(capsys):
    table = rig.recording()
    columns = {n: table[n].to_numpy() for n in "tuy"}
    runs = np.empty((1, 2), dtype=object)
    runs[0, 0], runs[0, 1] = columns, {n: v[:300] for n, v in columns.items()}
    savemat("a.mat", {"runs": runs, "gain": 3.0})
    found, text = drafted(capsys, "a.mat")
    assert found.reading.group == "runs"
    assert "# 2 experiments: [0], [1]" in text
    assert len(camid.identify("a.mat", "drafted.yaml").simulation.to_mapping()) > 3
    savemat("b.mat", {"log": {"time": columns["t"], "signals": {"values": table[["u", "y"]].to_numpy()}}})
    found, _ = drafted_again(capsys, "b.mat")
    assert (found.input_column, found.output_column) == ("signals/values[0]", "signals/values[1]")


def drafted_again(capsys, *arguments):
    Path("drafted.yaml").unlink()
    return drafted(capsys, *arguments)


def moved_by(plant, signal, period):
    """Readings at the beginnings of the rows of a plant under a held input, with a little noise."""
    time = period * np.arange(len(signal))
    moved = control.forced_response(control.sample_system(control.tf(*plant), period, "zoh"), time, signal)
    return time, moved.outputs + 0.003 * np.std(moved.outputs) * np.random.default_rng(2).standard_normal(len(time))


@pytest.mark.parametrize(
    ("plant", "said", "poles"),
    [
        (([0.1], [1.0, 0.03]), "A first-order plant fitted", 1),
        (([0.2], [1.0, 0.0]), "An integrator fitted", 1),
        (([2.0], [1.0, 1.5, 0.0]), "An integrator with a first-order lag fitted", 2),
    ],
)
def test_a_plant_that_does_not_swing_has_its_own_structure(capsys, plant, said, poles):
    signal = np.repeat(np.random.default_rng(1).choice([-2.0, -1.0, 0.0, 1.0, 2.2], 40), 10)
    time, output = moved_by(plant, signal, 0.5)
    pd.DataFrame({"t": time, "u": signal, "y": output}).to_csv("a.csv", index=False)
    found, text = drafted(capsys, "a.csv")
    assert said in text
    assert "pendulum" not in text  # it would have nothing to swing with
    assert found.plant.order == poles
    np.testing.assert_allclose(found.plant.denominator, plant[1], rtol=0.1, atol=1e-6)
    table = camid.simulate("a.csv", "drafted.yaml")
    assert np.std(table["simulated"] - table["y"]) < 0.01 * np.std(output)


def test_a_fit_that_explains_nothing_is_not_used(capsys):
    noise = np.random.default_rng(3).standard_normal(400)
    signal = np.repeat(np.random.default_rng(1).choice([-1.0, 1.0], 40), 10)
    pd.DataFrame({"t": 0.1 * np.arange(400), "u": signal, "y": noise + 0.004 * np.arange(400)}).to_csv(
        "a.csv", index=False
    )
    _, text = drafted(capsys, "a.csv")
    assert "A guess: a resonance read off the output; a second-order fit leaves" in text


def test_pixels_mean_a_camera_and_milliseconds_in_a_name_are_declared(capsys):
    table = rig.recording(exposure=1.0)
    pd.DataFrame({"t_ms": 1e3 * table["t"], "u": table["u"], "x [px]": 100.0 * table["y"]}).to_csv("a.csv", index=False)
    found, text = drafted(capsys, "a.csv")
    assert found.sensor == "camera"
    assert found.reading.time.unit == "ms"
    assert "period 0.05 s" in text
    assert camid.identify("a.csv", "drafted.yaml").period == pytest.approx(rig.PERIOD)


@pytest.mark.parametrize("frames", [47.3, 120.0])  # blank in most rows, or in some
def test_frames_between_the_samples_of_the_drive(capsys, frames):
    table = two_rates(frames=frames).rename(columns={"frame": "frame_time", "y": "x"})
    table.assign(x_std=0.002 + 0.001 * np.sin(table["x"])).to_csv("joined.csv", index=False)
    found, text = drafted(capsys, "joined.csv")
    assert found.reading.frame_time == "frame_time"
    assert (found.time_column, found.input_column, found.output_column) == ("t", "u", "x")
    assert (found.sensor, found.reading.missing) == ("camera", "refuse")
    assert "  time: frame_time  # a guess: when each frame was delivered; rows without one are blank" in text
    assert "after camid join say estimate" in text
    assert "x_std (belongs to what was tracked)" in text
    known = text.replace("kind: camera", "kind: camera\n  exposure: 0.008").replace("latency: 0.0", "latency: 0.004")
    Path("drafted.yaml").write_text(known)
    result = camid.identify("joined.csv", "drafted.yaml")
    assert result.nrmse < 0.1
    natural = [row for row in result.characteristics() if row["name"] == "natural frequency"]
    assert natural[0]["value"] == pytest.approx(9.0, rel=0.02)


def test_times_of_frames_are_not_taken_for_an_output_of_every_row(capsys):
    table = two_rates().rename(columns={"y": "x"})
    encoder = np.interp(table["t"], table["frame"].dropna(), table["x"].dropna())
    table.assign(y=encoder, x=np.nan).drop(columns="x").to_csv("encoder.csv", index=False)
    found, _ = drafted(capsys, "encoder.csv")
    assert (found.reading.frame_time, found.output_column) == (None, "y")


@pytest.mark.parametrize("last", [True, False])
def test_an_output_with_blank_cells_is_the_output_and_what_is_not_used_is_named(capsys, last):
    table = rig.recording()
    table.loc[[7, 60, 200, *([len(table) - 1] if last else [])], "y"] = np.nan
    short = np.where(np.arange(len(table)) < 30, np.arange(len(table)) ** 2.0, np.nan)
    table.assign(note="a", empty=np.nan, few=short).to_csv("a.csv", index=False)
    found, text = drafted(capsys, "a.csv")
    assert (found.input_column, found.output_column, found.reading.missing) == ("u", "y", "leave-out")
    assert "# Not used: note (text); empty (blank); few (numbers in 30 rows only)." in text
    assert camid.identify("a.csv", "drafted.yaml").nrmse < 0.2


def test_a_closed_loop_is_recognised_by_its_reference(capsys):
    time = 0.01 * np.arange(1000)
    wanted = np.sin(2.0 * time)
    measured = np.sin(2.0 * time - 0.1)
    control = np.gradient(np.gradient(measured)) * 1e3 + np.random.default_rng(1).normal(0.0, 0.1, 1000)
    pd.DataFrame({"t": time, "qa": wanted, "qb": measured, "u": control}).to_csv("a.csv", index=False)
    found, text = drafted(capsys, "a.csv")
    assert found.output_column == "qb"  # it follows, so it is what was measured
    assert "# controller: {reference: qa, " in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.csv"], "none.csv: no such file"),
        (["words.csv"], "words.csv: no column holds numbers in at least 20 rows"),
        (["a.csv", "--period", "0.1"], "a period is given, and column 't' looks like the time"),
        (["a.csv", "--period", "-1"], "--period -1; it takes a positive number of seconds"),
        (["a.csv", "-o", "a.csv"], "--output would overwrite what it is made from"),
        (["a.csv", "-o", "words.csv"], "words.csv: this file exists"),
        (["a.csv", "other.csv"], "other.csv: no column 'y'"),
    ],
)
def test_refusals(capsys, folder, arguments, said):
    rig.recording().to_csv("a.csv", index=False)
    rig.recording().drop(columns="y").to_csv("other.csv", index=False)
    (folder / "words.csv").write_text("a,b\nc,d\n", encoding="utf-8")
    before = {p: p.read_bytes() for p in folder.iterdir()}
    assert main(["init", "recording", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1
    assert {p: p.read_bytes() for p in folder.iterdir()} == before


@pytest.mark.parametrize(
    ("name", "role", "expected"),
    [
        ("u1", "input", True),
        ("uEst", "input", True),
        ("motor voltage [V]", "input", True),
        ("y_ref", "output", True),
        ("angle (deg)", "output", True),
        ("upper", "input", False),
        ("Time [s]", "time", True),
        ("data/run1/theta", "output", True),
    ],
)
def test_names_that_say_what_a_column_is(name, role, expected):
    assert says(name, role) is expected


@given(st.text(min_size=1, max_size=12).filter(str.isprintable))
@settings(max_examples=200, deadline=None)
def test_any_name_is_read_back_from_yaml_as_it_is(name):
    assert YAML(typ="safe", pure=True).load(f"{{column: {quoted(name)}}}") == {"column": name}


@pytest.mark.parametrize("damping", [0.005, 0.02, 0.1])
def test_a_resonance_is_read_off_a_decay(damping):
    time = 0.01 * np.arange(4000)
    natural = 6.0
    swing = 0.3 * np.exp(-damping * natural * time) * np.cos(natural * np.sqrt(1 - damping**2) * time)
    found = resonance_of(swing + 2.0, None, 0.01)
    assert found.natural_frequency == pytest.approx(natural, rel=0.02)
    assert found.damping == pytest.approx(damping, rel=0.1)
    assert found.rest == pytest.approx(2.0, abs=0.01)


def test_a_recording_in_which_nothing_moves_is_refused_in_one_line(tmp_path):
    path = tmp_path / "still.csv"
    path.write_text("t,y\n" + "".join(f"{0.1 * k:.1f},2\n" for k in range(60)))
    with pytest.raises(camid.InputError, match="no column beside the time changes"):
        camid.init_recording(path)
