"""A plant that falls without its controller: a magnet that levitates a ball."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.errors import InputError
from camid.simulation.file import load_simulation, write_simulation

PERIOD, COUNT = 0.005, 2000
GAIN, DAMPING, FALL = 2400.0, 3.0, 900.0
CONTROLLER = {"reference": "r", "position_gain": 30.0, "velocity_gain": 0.035, "limit": 6.0}


def levitated(dead_zone=0.0, seed=4, substeps=20):
    """The ball follows steps; its force is a current with a dead zone. By steps far shorter than a sample."""
    random = np.random.default_rng(seed)
    reference = 0.5 * np.repeat(random.choice([-1.0, -0.3, 0.4, 1.0], COUNT // 40), 40)
    position = velocity = 0.0
    control, positions = np.zeros(COUNT), np.zeros(COUNT)
    step = PERIOD / substeps
    for k in range(COUNT):
        positions[k] = position
        wanted = CONTROLLER["position_gain"] * (reference[k] - position) - velocity
        control[k] = np.clip(CONTROLLER["velocity_gain"] * wanted, -CONTROLLER["limit"], CONTROLLER["limit"])
        current = np.sign(control[k]) * max(abs(control[k]) - dead_zone, 0.0)
        for _ in range(substeps):
            middle = velocity + 0.5 * step * (GAIN * current - DAMPING * velocity + FALL * position)
            here = position + 0.5 * step * velocity
            position += step * middle
            velocity += step * (GAIN * current - DAMPING * middle + FALL * here)
    noise = random.standard_normal((2, COUNT))
    return pd.DataFrame(
        {
            "t": PERIOD * np.arange(COUNT),
            "r": reference,
            "i": control + 0.002 * noise[0],
            "y": positions + 0.002 * noise[1],
        }
    )


def believed(**more):
    return {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "i", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [2000.0], "denominator": [1.0, 2.0, -780.0]}},
        "controller": CONTROLLER,
        "sensor": {"column": "y", "kind": "instant"},
        **more,
    }


def test_it_is_simulated_in_its_loop():
    recording = levitated()
    plant = {"transfer_function": {"numerator": [GAIN], "denominator": [1.0, DAMPING, -FALL]}}
    found = camid.simulate(recording, believed(plant=plant))
    assert np.std(found["simulated"] - recording["y"]) < 2.0 * 0.002
    assert np.std(found["simulated_input"] - recording["i"]) < 2.0 * 0.002


def test_its_coefficients_are_identified():
    found = camid.identify(levitated(), believed())
    deviations = found.simulation.standard_deviations
    for key, index, truth in (("numerator", 0, GAIN), ("denominator", 1, DAMPING), ("denominator", 2, -FALL)):
        value = getattr(found.simulation.plant, key)[index]
        assert abs(value - truth) < 3.5 * deviations[key][index], key
        assert deviations[key][index] < 0.05 * abs(truth)


@pytest.mark.parametrize("dead_zone", [0.0, 0.06])
@pytest.mark.slow
def test_what_its_simulation_leaves_out_is_named(dead_zone, recwarn):
    diagnosis = camid.diagnose(levitated(dead_zone), believed())
    assert [f.identifier for f in diagnosis.findings] == (["dead-zone"] if dead_zone else [])
    assert diagnosis.verdict == ("explained" if dead_zone else "adequate")
    if dead_zone:
        (found,) = diagnosis.findings
        estimate = found.parameters["half_width"]
        assert abs(estimate.value - dead_zone) < 3.0 * estimate.standard_deviation < 0.1 * dead_zone
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]


@pytest.mark.slow
def test_what_is_written_is_read_again(tmp_path):
    recording = levitated(0.06)
    write_simulation(camid.diagnose(recording, believed()).improved, tmp_path / "improved.yaml")
    assert load_simulation(tmp_path / "improved.yaml").plant.unstable_poles().size == 1
    again = camid.simulate(recording, tmp_path / "improved.yaml")
    assert np.std(again["simulated"] - recording["y"]) < 2.0 * 0.002


def test_without_a_controller_it_is_refused():
    content = believed()
    del content["controller"]
    with pytest.raises(InputError, match=r"unstable: poles at 26\.95 rad/s"):
        load_simulation(content)
