"""What has no name is modelled: learned where the catalogue leaves structure, and nowhere else."""

import json

import numpy as np
import pandas as pd
import pytest

import camid
from camid.simulation.file import write_simulation
from tests.support.mass_on_spring import simulation
from tests.support.runge_kutta import positions

PERIOD, COUNT, STEPS = 0.02, 1600, 20


def rig(force, seed, actuator=lambda u: u, noise=0.004):
    """A mass on a spring with a force of its own, by an integrator that shares nothing with the tool's."""
    random = np.random.default_rng(np.random.SeedSequence((seed, 31)))
    signal = np.repeat(random.uniform(-1.5, 1.5, COUNT // 8), 8)

    def slope(state, u):
        y, v = state
        return np.array([v, 100.0 * (actuator(u) - force(y, v)) - 2.0 * v - 100.0 * y])

    output = positions(slope, signal, PERIOD, STEPS)
    time = PERIOD * np.arange(COUNT)
    noisy = output + noise * random.standard_normal(COUNT)
    return pd.DataFrame({"t": time, "u": signal, "y": noisy, "clean": output})


def believed():
    return simulation(sensor={"column": "y", "kind": "instant", "offset": 0.0})


def bump(y, v):
    """A magnet beside the way: a force that pulls to one place and is nothing elsewhere."""
    return -0.35 * (y - 0.8) / 0.25 * np.exp(-(((y - 0.8) / 0.25) ** 2))


@pytest.fixture(scope="module")
def magnet():
    recording = rig(bump, 1)
    return recording, camid.diagnose(recording.drop(columns="clean"), believed())


def test_a_force_that_no_law_describes_is_learned(magnet):
    _, diagnosis = magnet
    assert diagnosis.verdict == "partly-explained"
    assert "learned force over the position" in diagnosis.explanation
    (part,) = diagnosis.learned
    assert (part.identifier, part.variables) == ("learned-force", "position")
    knots, values = np.array(part.knots), np.array(part.values)
    inner = (knots > -1.2) & (knots < 1.9)
    # What a straight line does is the spring's.
    line = np.polyval(np.polyfit(knots[inner], values[inner] - bump(knots[inner], 0.0), 1), knots)
    assert np.max(np.abs(values - bump(knots, 0.0) - line)[inner]) < 0.12
    assert diagnosis.fit.improved < 1.5 * diagnosis.fit.noise_floor


def test_the_improved_simulation_follows_another_recording(magnet):
    _, diagnosis = magnet
    again = rig(bump, 2)
    table = again.drop(columns="clean")
    refitted = camid.identify(magnet[0].drop(columns="clean"), believed()).simulation
    errors = [
        float(np.sqrt(np.mean((camid.simulate(table, model)["simulated"] - again["clean"]) ** 2)))
        for model in (refitted, diagnosis.improved)
    ]
    assert errors[1] < 0.15 * errors[0]


def test_json_and_improved_simulation_hold_it(magnet, tmp_path):
    recording, diagnosis = magnet
    recording.drop(columns="clean").to_csv(tmp_path / "rig.csv", index=False)
    write_simulation(diagnosis.improved, tmp_path / "improved.yaml")
    simulated = camid.simulate(tmp_path / "rig.csv", tmp_path / "improved.yaml")["simulated"]
    assert np.sqrt(np.mean((simulated - recording["clean"]) ** 2)) < 0.004
    content = json.loads(json.dumps(diagnosis.to_mapping()))
    entry = content["effects"][-1]
    assert entry["id"] == "learned-force"
    assert len(entry["knots"]) == len(entry["values"]) == len(entry["standard_deviations"])
    assert entry["formula"].startswith("f(y) = a·(y − y0)/c·exp(−((y − y0)/c)²), a = ")
    truth = {"a": -0.35, "y0": 0.8, "c": 0.25}
    for name, value in truth.items():
        found = entry["formula_parameters"][name]
        assert abs(found["value"] - value) < 4.0 * found["std"] < 0.2 * abs(value)
    assert "centred at y = " in entry["description"]
    declared = diagnosis.improved.effects[-1].parameters
    assert (declared["formula"], declared["description"]) == (entry["formula"], entry["description"])


def test_a_law_of_the_catalogue_is_named_and_not_learned():
    recording = rig(lambda y, v: 0.06 * y**3, 3)
    diagnosis = camid.diagnose(recording.drop(columns="clean"), believed())
    assert diagnosis.verdict == "explained"
    assert diagnosis.learned == []
    assert [f.identifier for f in diagnosis.findings] == ["cubic-stiffness"]


def test_nothing_is_learned_where_nothing_is_missing():
    recording = rig(lambda y, v: 0.0, 4)
    diagnosis = camid.diagnose(recording.drop(columns="clean"), believed())
    assert diagnosis.verdict == "adequate"
    assert diagnosis.learned == []
