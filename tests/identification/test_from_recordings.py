"""Recordings as people have them, read as a simulation says: units, experiments, gaps, jitter, and real files."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML
from scipy.signal import lsim

import camid
from camid.cli import main
from camid.errors import InputError
from camid.identification import from_recordings
from camid.identification.from_recordings import experiments_of, load_recordings, warnings_of
from camid.simulation.file import load_simulation
from tests.support import linear_rig as rig

TRUTH = np.array([*rig.NUMERATOR, *rig.DENOMINATOR])


def believed(**changes):
    """A simulation with an instant sensor; keys of its parts are added to those that are there."""
    content = rig.simulation(sensor={"column": "y", "kind": "instant"})
    for key, value in changes.items():
        content[key] = content[key] | value if isinstance(value, dict) and key in content else value
    return content


def load(source, **changes):
    return load_recordings(source, load_simulation(believed(**changes)), output_needed=True)


def refusal(source, command=load, **changes):
    with pytest.raises(InputError) as caught:
        command(source, **changes)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def table(count=60, start=0.0):
    return rig.recording(count, start=start, exposure=0.0)


# -- rows -------------------------------------------------------------------------------------------------------------


def test_a_file_without_a_time_column(tmp_path):
    recorded = table()
    recorded[["u", "y"]].to_csv(tmp_path / "a.csv", index=False)
    content = believed() | {"time": {"period": rig.PERIOD}}
    result = camid.simulate(tmp_path / "a.csv", content)
    np.testing.assert_allclose(result, camid.simulate(recorded, believed()), atol=1e-9)
    late = camid.simulate(tmp_path / "a.csv", content | {"recording": {"start": 1.0}})
    assert late["t"].iloc[0] == pytest.approx(1.0)
    assert len(late) == 40


def test_start_and_end_are_times_of_the_file():
    (found,) = load(table(start=100.0), recording={"start": 100.5, "end": 101.5})
    assert (found.time[0], found.time[-1], len(found)) == (pytest.approx(100.5), pytest.approx(101.5), 21)


def test_bad_rows_outside_of_start_and_end_are_not_read():
    recorded = table()
    recorded.loc[:5, "y"] = np.nan
    assert "row 0, column 'y'" in refusal(recorded)
    assert len(load(recorded, recording={"start": 0.3})[0]) == 54


def test_leave_out_is_simulated_and_not_compared():
    recorded = table()
    recorded.loc[:9, "y"] += 5.0
    content = believed(recording={"leave_out": 0.5})
    _, (experiment,), _ = experiments_of(recorded, load_simulation(content), None)
    assert np.flatnonzero(~experiment.used).tolist() == list(range(10))
    assert len(camid.simulate(recorded, content)) == 60
    estimating = content | {"initial_state": "estimate"}
    simulated = camid.simulate(recorded, estimating)["simulated"]
    np.testing.assert_allclose(simulated[2:], camid.simulate(recorded, believed())["simulated"][2:], atol=0.2)
    assert np.ptp(simulated[:10]) > 0.1
    long = load_simulation(believed(recording={"leave_out": 50.0}))
    assert "the recording lasts 2.95 s: choose a shorter leave_out" in refusal(
        recorded, lambda source: experiments_of(source, long, None)
    )


def test_rows_without_output_are_left_out_where_allowed():
    recorded = table()
    recorded.loc[[3, 20, 21], "y"] = np.nan
    message = refusal(recorded)
    assert "row 3, column 'y': an empty cell or NaN where a number should be" in message
    assert "missing: leave-out" in message
    content = believed(recording={"missing": "leave-out"})
    (found,), (experiment,), _ = experiments_of(recorded, load_simulation(content), None)
    assert np.flatnonzero(~experiment.used).tolist() == [3, 20, 21]
    assert np.all(np.isfinite(experiment.output))
    assert "3 rows (5 %) without output" in " ".join(warnings_of([found]))
    result = camid.simulate(recorded, content)
    assert np.flatnonzero(result["y"].isna()).tolist() == [3, 20, 21]
    assert result["simulated"].notna().all()
    assert "column 'u'" in refusal(recorded.assign(u=recorded["y"].to_numpy()), recording={"missing": "leave-out"})
    broken = recorded.astype({"y": object})
    broken.loc[5, "y"] = "lost"
    assert "row 5, column 'y': 'lost'" in refusal(broken, recording={"missing": "leave-out"})


# -- experiments ------------------------------------------------------------------------------------------------------


def several():
    parts = [table(count).assign(run=run) for count, run in ((40, 1), (50, 2), (60, 1))]
    return pd.concat(parts, ignore_index=True)


def test_one_recording_for_each_run_of_equal_values(tmp_path):
    several().to_csv(tmp_path / "runs.csv", index=False)
    assert "line 42, column 't': the time goes back" in refusal(tmp_path / "runs.csv")
    found = load(tmp_path / "runs.csv", recording={"experiment": {"column": "run"}})
    assert [len(r) for r in found] == [40, 50, 60]
    assert [r.experiment for r in found] == ["1 from line 2", "2", "1 from line 92"]
    assert found[1].source == f"{tmp_path / 'runs.csv'}, run 2"
    gap = several()
    gap.loc[45, "run"] = np.nan
    assert "row 45, column 'run': an empty cell" in refusal(gap, recording={"experiment": {"column": "run"}})


def test_commands_take_the_experiments_of_a_file_like_recordings():
    content = believed(recording={"experiment": {"column": "run"}})
    parts = [several().iloc[:40], several().iloc[40:90], several().iloc[90:]]
    alone = camid.identify(parts, believed())
    together = camid.identify(several(), content)
    assert together.rows_fitted == 150
    assert together.simulation.plant == alone.simulation.plant
    result = camid.simulate(several(), content)
    expected = np.concatenate([camid.simulate(p, believed())["simulated"] for p in parts])
    np.testing.assert_allclose(result["simulated"], expected)
    assert result["experiment"].unique().tolist() == ["1 from row 0", "2", "1 from row 90"]


def test_experiments_without_rows_between_start_and_end_are_named():
    recorded = several().assign(t=rig.PERIOD * np.arange(150))
    found = load(recorded, recording={"experiment": {"column": "run"}, "start": 2.5})
    assert [len(r) for r in found] == [40, 60]
    assert "recording, run 1 from row 0: no row between start and end, left out" in found[0].warnings


def test_validation_rows_may_lie_in_one_of_the_experiments():
    recorded = several().assign(t=rig.PERIOD * np.arange(150))
    content = believed(recording={"experiment": {"column": "run"}}, validation={"start": 2.5, "end": 3.0})
    held_out = experiments_of(recorded, load_simulation(content), None)[2]
    assert [int(rows.sum()) for rows in held_out] == [0, 11, 0]
    late = load_simulation(content | {"validation": {"start": 99.0, "end": 100.0}})
    assert "no row of the recording lies between 99 s and 100 s" in refusal(
        recorded, lambda source: experiments_of(source, late, None)
    )


# -- irregular times --------------------------------------------------------------------------------------------------


def jittered(count=500, share=0.15, noise=0.02, seed=4):
    """An instant sensor read, and a held input changed, at irregular times."""
    random = np.random.default_rng(seed)
    places = np.arange(count) + random.uniform(-share, share, count)
    places[0] = 0.0
    signal = rig.steps(count)
    fine = np.arange((count - 1) * 200 + 1) / 200
    driven = signal[np.clip(np.searchsorted(places, fine, side="right") - 1, 0, None)]
    moved = lsim((rig.NUMERATOR, rig.DENOMINATOR), driven, fine * rig.PERIOD, interp=False)[1]
    output = np.interp(places, fine, moved) + noise * np.std(moved) * random.standard_normal(count)
    return pd.DataFrame({"t": rig.PERIOD * places, "u": signal, "y": output}), np.interp(places, fine, moved)


def test_a_jittered_recording_is_simulated_at_its_own_times():
    recorded, exact = jittered(noise=0.0)
    result = camid.simulate(recorded, believed())
    np.testing.assert_array_equal(result["t"], recorded["t"])
    np.testing.assert_array_equal(result["y"], recorded["y"])
    error = np.std(result["simulated"] - exact) / np.std(exact)
    blind = camid.simulate(recorded.assign(t=rig.PERIOD * np.arange(500)), believed())["simulated"]
    assert error < 0.015
    assert error < 0.2 * np.std(blind - exact) / np.std(exact)
    assert "500 rows" not in result.attrs["warnings"][0]
    assert "the input brought there by its hold" in result.attrs["warnings"][0]


def test_a_jittered_recording_identifies_the_plant_and_says_what_was_done():
    recorded, _ = jittered()
    result = camid.identify(recorded, believed())
    found = np.array([*result.simulation.plant.numerator, *result.simulation.plant.denominator])
    np.testing.assert_allclose(found, TRUTH, rtol=0.02)
    assert result.nrmse < 0.03
    assert any("off a regular grid" in w for w in result.warnings())
    assert "off a regular grid" in camid.select_order(recorded, believed(), largest=2).warnings()[0]
    blind = camid.identify(recorded.assign(t=rig.PERIOD * np.arange(500)), believed())
    assert blind.nrmse > 1.5 * result.nrmse


def test_gaps_of_a_driven_recording():
    recorded = table().drop(index=[10, 30, 31]).reset_index(drop=True)
    message = refusal(recorded)
    assert "row 29, column 't': a step of 0.15 s where the others have 0.05 s: 2 rows seem to be missing" in message
    assert "gaps: hold" in message
    (found,) = load(recorded, recording={"gaps": "hold"})
    assert np.flatnonzero(found.missing).tolist() == [10, 30, 31]
    assert found.columns["u"][30] == pytest.approx(recorded["u"][28])
    assert "3 rows are missing" in found.warnings[0]
    assert len(camid.simulate(recorded, believed(recording={"gaps": "hold"}))) == 57


def test_gaps_without_an_input_are_accepted():
    moved = rig.film(np.zeros(200), exposure=0.0, initial_state=[3.0, 0.2])[3:]
    recorded = pd.DataFrame({"t": rig.PERIOD * np.arange(197), "y": moved}).drop(index=[50, 51, 120])
    content = believed(initial_state="estimate") | {"input": None}
    result = camid.identify(recorded, content)
    assert result.rows_fitted == 194
    np.testing.assert_allclose(result.simulation.plant.denominator, rig.DENOMINATOR, rtol=1e-3)
    table_of_rows = camid.simulate(recorded, content)
    np.testing.assert_array_equal(table_of_rows["t"], recorded["t"])
    np.testing.assert_allclose(table_of_rows["simulated"], recorded["y"], atol=1e-3)


@pytest.mark.parametrize("command", ["identify", "simulate", "diagnose"])
def test_the_commands_say_what_is_wrong_in_one_line_and_write_nothing(tmp_path, command, capsys):
    simulation = rig.write_yaml(believed(), tmp_path / "rig.yaml")
    (tmp_path / "book.xlsx").write_bytes(b"PK\x03\x04")
    table().drop(index=10).to_csv(tmp_path / "gap.csv", index=False)
    for name, said in (("book.xlsx", "this is no spreadsheet, although"), ("gap.csv", "gaps: hold")):
        written = tmp_path / ("out.csv" if command == "simulate" else "out")
        arguments = [command, str(tmp_path / name), "--simulation", str(simulation), "--output", str(written)]
        assert main(arguments) == 2
        shown = capsys.readouterr()
        assert shown.err.count("\n") == 1
        assert said in shown.err
        assert sorted(p.name for p in tmp_path.iterdir()) == ["book.xlsx", "gap.csv", "rig.yaml"]


def test_the_written_table_has_no_blanks(tmp_path):
    recorded = table()
    recorded.loc[[3, 59], "y"] = np.nan
    recorded.to_csv(tmp_path / "recording.csv", index=False)
    simulation = rig.write_yaml(believed(recording={"missing": "leave-out"}), tmp_path / "rig.yaml")
    files = [str(tmp_path / "recording.csv"), "--simulation", str(simulation), "--output", str(tmp_path / "out.csv")]
    assert main(["simulate", *files]) == 0
    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert len(lines) == 61
    assert not any(",," in line or line.endswith(",") for line in lines)
    assert lines[4].endswith(",nan")


# -- real recordings --------------------------------------------------------------------------------------------------


def real(name):
    folder = os.environ.get("CAMID_RECORDINGS")
    if folder is None:
        pytest.skip("CAMID_RECORDINGS names no folder of real recordings")
    if not (Path(folder) / name).exists():
        pytest.skip(f"no {name} in {folder}")
    return Path(folder) / name


def test_silverbox():
    """Commas at the ends of the lines, no time column."""
    changes = {"input": {"column": "V1", "hold": "foh"}, "sensor": {"column": "V2"}}
    content = load_simulation(believed(**changes) | {"time": {"period": 1 / 610.35}})
    (found,) = load_recordings(real("silverbox.csv"), content, output_needed=True)
    assert len(found) == 131072
    assert found.columns["V1"][0] == 0.0057756
    assert found.columns["V2"][1] == 0.012971
    assert found.warnings == ()


def test_emps():
    """A MAT file with scalars beside the columns; the force is 35.15 N/V times the voltage."""
    content = believed(input={"column": "vir", "scale": 35.15}, sensor={"column": "qm"})
    (found,) = load_recordings(real("emps.mat"), load_simulation(content), output_needed=True)
    assert len(found) == 24841
    assert found.period == pytest.approx(1e-3, rel=1e-9)
    assert not found.missing.any()
    assert 100.0 < np.max(found.columns["vir"]) <= 351.5
    assert "is a single value" in refusal(real("emps.mat"), input={"column": "gtau"}, sensor={"column": "qm"})


def test_pendulum_decay():
    """No header line; times with five decimals about a period of 6.67 ms."""
    content = believed(
        recording={"header": False, "columns": ["t", "angle", "rate"], "start": 16.0},
        sensor={"column": "angle"},
        initial_state="estimate",
    )
    (found,) = load_recordings(
        real("pendulum_decay.csv"), load_simulation(content | {"input": None}), output_needed=True
    )
    assert found.period == pytest.approx(1 / 150, rel=2e-3)
    assert found.missing.sum() <= 1
    assert found.recorded_time[0] >= 16.0
    assert np.max(np.abs(found.columns["angle"] - np.pi)) < 1.9
    assert "off a regular grid" in found.warnings[0]


def test_more_rows_than_are_fitted_at_once_are_refused_with_a_cut_that_helps(monkeypatch):
    recorded = rig.recording()
    half = len(recorded) // 2
    monkeypatch.setattr(from_recordings, "MOST_ROWS", half)
    with pytest.raises(InputError, match="rows are too many to fit at once") as caught:
        camid.identify(recorded, rig.simulation())
    message = str(caught.value)
    assert "\n" not in message
    cut = YAML(typ="safe").load(message.rpartition("recording: ")[2])
    assert cut == {"start": recorded["t"].iloc[0], "end": pytest.approx(recorded["t"].iloc[half - 1])}
    assert camid.identify(recorded, rig.simulation() | {"recording": cut}).converged
    with pytest.raises(InputError, match="name fewer recordings"):
        camid.identify([recorded.iloc[:half], recorded.iloc[half:]], rig.simulation())


def test_of_a_gap_between_regular_rows_only_the_missing_rows_are_said():
    """What the floating point leaves of regular times is no irregularity."""
    recorded = pd.DataFrame({"t": 0.02 * np.arange(200), "u": 1.0, "y": np.sin(0.3 * np.arange(200))})
    recorded = recorded.drop(index=range(100, 110))
    (found,) = load(recorded, recording={"gaps": "hold", "missing": "leave-out"})
    assert [w.partition(": ")[2] for w in found.warnings] == [
        "10 rows are missing (5 % of the grid), the input held over them, not compared"
    ]


def test_rows_without_output_are_said_once():
    recorded = pd.DataFrame({"t": 0.02 * np.arange(200), "u": 1.0, "y": np.sin(0.3 * np.arange(200))})
    recorded.loc[100:109, "y"] = np.nan
    (found,) = load(recorded, recording={"missing": "leave-out"})
    assert [w.partition(": ")[2] for w in found.warnings] == ["10 rows (5 %) without output, not compared"]
