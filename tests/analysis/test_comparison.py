"""The fit in per cent, and which rows and models it is of."""

import json

import numpy as np
import pandas as pd
import pytest

import camid
from camid.analysis.comparison import fit_percent
from camid.cli import main
from camid.errors import InputError
from camid.simulation.file import write_simulation
from tests.support import linear_rig as rig
from tests.support import pendulum_and_drive as rigs
from tests.support.swinging_marker import SIMULATION as TWO_COLUMNS
from tests.support.swinging_marker import swinging_marker
from tests.support.two_rates import SIMULATION as TWO_RATES
from tests.support.two_rates import two_rates


def camera(column, **more):
    return {"column": column, "kind": "camera", **more}


def test_the_fit_of_a_worked_example():
    """By hand: ‖error‖ = √0.1, ‖y − 2.5‖ = √5, so 100 (1 − √0.02) = 85.857864 %."""
    recorded, simulated = np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.1, 1.9, 3.2, 3.8])
    assert fit_percent(recorded, simulated) == pytest.approx(85.85786437626905, abs=1e-12)


def test_the_fit_is_that_of_the_system_identification_toolbox():
    """Its documentation of goodnessOfFit: an NRMSE of 0.2943 is what ``compare`` shows as 70.57 %."""
    recorded = np.array([3.0, -1.0, 4.0, 1.0, -5.0, 9.0])
    error = np.array([1.0, -2.0, 2.0, 0.5, 1.0, -1.0])
    error *= 0.2943 * np.linalg.norm(recorded - recorded.mean()) / np.linalg.norm(error)
    assert round(fit_percent(recorded, recorded - error), 2) == 70.57


def test_the_ends_of_the_scale():
    recorded = np.array([0.0, 1.0, 5.0, 2.0])
    assert fit_percent(recorded, recorded) == 100.0
    assert fit_percent(recorded, np.full(4, recorded.mean())) == pytest.approx(0.0, abs=1e-12)
    assert fit_percent(recorded, recorded + 100.0) < -1000.0
    assert fit_percent(np.array([1.0, np.nan, 3.0]), np.array([1.0, 7.0, 3.0])) == 100.0
    assert fit_percent(np.full(4, 0.1 + 0.2), recorded) is None
    assert fit_percent(np.full(4, np.nan), recorded) is None


def test_models_are_compared_on_the_rows_that_were_fitted_and_on_the_others(identified):
    recording = rig.recording(count=600)
    believed = rig.simulation(plant=rig.plant([90.0], [1.0, 4.0, 90.0]))
    found = camid.compare(recording, believed, identified, held_out=(19.99, 30.0))
    assert found.models == ("model 1", "identified")
    table = found.fits.set_index("model")
    simulated = camid.simulate(recording, identified.simulation)["simulated"].to_numpy()
    output, time = recording["y"].to_numpy(), recording["t"].to_numpy()
    parts = {"fit": time >= 0.0, "fit_fitted": time < 19.99, "fit_held_out": time > 19.99}
    for name, rows in parts.items():
        expected = fit_percent(output[rows], simulated[rows])
        assert table.loc["identified", name] == pytest.approx(expected, abs=1e-9)
        assert table.loc["identified", name] > 85.0 > table.loc["model 1", name]
    # The residual that identify states is the same number.
    whole = camid.compare(recording, identified).fits["fit"][0]
    assert whole == pytest.approx(100.0 * (1.0 - identified.nrmse), abs=1e-6)
    assert np.isnan(camid.compare(recording, identified).fits["fit_held_out"][0])


def test_an_initial_state_is_not_fitted_to_rows_that_are_held_out():
    """A free decay whose held-out end is something else: the state that explains the rest explains nothing of it."""
    recording = rigs.pendulum(natural_frequency=5.5, damping=0.01, rest=0.0, angle=0.1, count=600)
    recording.loc[recording["t"] >= 4.0, "angle"] = 0.3
    model = {
        "schema": 1,
        "time": {"column": "t"},
        "input": None,
        "plant": {"transfer_function": {"numerator": [30.25], "denominator": [1.0, 0.11, 30.25]}},
        "sensor": {"column": "angle", "kind": "instant"},
        "initial_state": "estimate",
    }
    found = camid.compare(recording, model, held_out=(4.0, 6.0)).fits
    assert found["fit_fitted"][0] > 98.0
    without = camid.compare(recording, model).signals[0]
    assert fit_percent(without.recorded[:400], without.simulated["model 1"][:400]) < 95.0


def test_a_closed_loop_is_compared_by_its_control_too():
    recording = rigs.drive(mass=12.0, viscous=30.0, friction=0.0, bias=0.0)
    right, wrong = rigs.drive_simulation(12.0, 30.0), rigs.drive_simulation(20.0, 30.0)
    table = camid.compare(recording, right, wrong).fits.set_index(["signal", "model"])["fit"]
    assert table["y", "model 1"] > 99.0
    assert table["u", "model 1"] > 99.0
    assert table["u", "model 2"] < 90.0


def test_effects_and_several_experiments_are_compared():
    table = rig.recording(count=300)
    both = pd.concat([table.assign(run="a"), table.assign(run="b")], ignore_index=True)
    content = rig.simulation(recording={"experiment": {"column": "run"}})
    friction = {"id": "coulomb-friction", "parameters": {"force": 0.2}}
    found = camid.compare(both, content, content | {"effects": [friction]})
    fits = found.fits.set_index(["experiment", "model"])["fit"]
    assert len(fits) == 4
    assert fits["a", "model 1"] == pytest.approx(fits["b", "model 1"])
    assert fits["a", "model 1"] > 88.0 > fits["a", "model 2"]
    assert set(found.numbers["experiment"]) == {"a", "b"}
    assert "experiment" in found.short_table().headings


def test_several_columns_of_a_sensor_are_compared_each():
    table = swinging_marker(seconds=6.0)
    fits = camid.compare(table, TWO_COLUMNS, held_out=(4.0, 6.0)).fits.set_index("signal")
    assert list(fits.index) == ["x", "y"]
    assert fits["fit"].notna().all()
    other = rig.simulation(input=None, initial_state="estimate", sensor=camera("t2"))
    with pytest.raises(InputError, match="model 1 and model 2 read different columns"):
        camid.compare(table.assign(t2=table["x"]), TWO_COLUMNS, other)


def test_rows_that_a_model_leaves_out_do_not_count():
    table = rig.recording(count=300, noise=0.0)
    table.loc[table["t"] < 2.0, "y"] += 5.0
    whole, rest = (camid.compare(table, rig.simulation(recording=r)).fits["fit"][0] for r in ({}, {"leave_out": 2.0}))
    assert rest > 99.9 > whole + 50.0


@pytest.mark.parametrize(
    ("models", "options", "said"),
    [
        ((), {}, "no model is given"),
        ((rig.simulation(),) * 7, {}, "7 models; at most 6"),
        ((rig.simulation(),), {"held_out": (3.0, 2.0)}, "starts at 3 s and ends at 2 s; give the earlier one first"),
        ((rig.simulation(),), {"held_out": (300.0, 310.0)}, "no two rows lie in the held-out part"),
        ((rig.simulation(),), {"zoom": (300.0, 310.0)}, "the recording lasts from 0 s to 14.95 s"),
        (
            (rig.simulation(validation={"start": 1.0, "end": 2.0}), rig.simulation(validation={"start": 1, "end": 3})),
            {},
            "the models hold out different rows (model 1: 1 to 2 s, model 2: 1 to 3 s); say which with --held-out",
        ),
        (
            (rig.simulation(), rig.simulation(sensor=camera("u2"))),
            {},
            "model 1 and model 2 read different values",
        ),
        ((rig.simulation(sensor=camera("z")),), {}, "no column 'z' to compare with"),
        (
            (rig.simulation(sensor=camera("y", latency="estimate")),),
            {},
            "the latency is not known yet",
        ),
        ((rig.simulation(recording={"leave_out": 100.0}),), {}, "leave_out"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_one_line(models, options, said):
    table = rig.recording(count=300).assign(u2=lambda t: 2.0 * t["y"])
    with pytest.raises(InputError) as caught:
        camid.compare(table, *models, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("latency", [0.0, 1.5])
def test_rows_that_saw_what_was_before_the_record_do_not_count(latency, tmp_path, capsys, monkeypatch):
    """The numbers of ``compare`` and ``simulate`` are those of ``identify``."""
    recorded = rig.recording(count=400, before=20, latency=latency)
    sensor = camera("y", latency=latency * rig.PERIOD)
    result = camid.identify(recorded, rig.simulation(initial_state="estimate", sensor=sensor))
    compared = result.compare()
    assert compared.to_mapping()["rows_compared"] == result.rows_fitted < 400
    assert compared.fits["fit"][0] == pytest.approx(100.0 * (1.0 - result.nrmse), abs=1e-6)
    monkeypatch.chdir(tmp_path)
    recorded.to_csv("recording.csv", index=False)
    write_simulation(result.simulation, "model.yaml")
    command = ["simulate", "recording.csv", "--simulation", "model.yaml", "--output", "out.csv", "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["nrmse"] == pytest.approx(result.nrmse, abs=1e-8)
    assert len(pd.read_csv("out.csv")) == 400


def test_rows_before_the_record_of_every_experiment(tmp_path):
    parts = [rig.recording(count=200, before=20, seed=seed).assign(run=seed) for seed in (1, 2)]
    table = pd.concat(parts, ignore_index=True)
    content = rig.simulation(initial_state="estimate", recording={"experiment": {"column": "run"}})
    result = camid.identify(table, content)
    assert result.compare().to_mapping()["rows_compared"] == result.rows_fitted == 398


def test_models_that_count_in_frames_and_in_rows(tmp_path):
    table = two_rates(seconds=4.0)
    frames = TWO_RATES | {"initial_state": "estimate"}
    rows = frames | {"sensor": {"column": "y", "kind": "instant"}, "recording": {"missing": "leave-out"}}
    with pytest.raises(InputError, match=r"compare models with the same sensor\.time: one of them counts in frames"):
        camid.compare(table, frames, rows)


def test_an_open_latency_names_the_times_that_it_is_counted_from():
    table = two_rates(seconds=4.0)
    sensor = TWO_RATES["sensor"] | {"latency": "estimate"}
    with pytest.raises(InputError, match=r"counted from the times in sensor\.time \('frame'\)"):
        camid.compare(table, TWO_RATES | {"sensor": sensor})
