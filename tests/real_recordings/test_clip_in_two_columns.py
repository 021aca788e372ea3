"""Both coordinates of the filmed pendulum: a swing out of the plane explains what one coordinate left open."""

import numpy as np
import pytest
from ruamel.yaml import YAML

import camid
from tests.real_recordings.test_real_recordings import recording
from tests.support import ROOT

FILE = ROOT / "config/simulations/pendulum_clip_xy.yaml"


@pytest.fixture(scope="module")
def clip():
    tracked = camid.track(recording("pendulum_clip"), colour="red")
    return tracked.table


@pytest.fixture(scope="module")
def believed():
    return YAML(typ="safe").load(FILE)


def in_the_plane(content):
    """The same without the motion out of the plane."""
    physical = dict(content["plant"]["physical"])
    equations = dict(physical["equations"])
    states = {name: equations["states"][name] for name in ("angle", "rate")}
    start = {name: equations["start"][name] for name in states}
    physical["parameters"] = {name: v for name, v in physical["parameters"].items() if name != "depth"}
    physical["units"] = {name: v for name, v in physical["units"].items() if name != "depth"}
    physical["equations"] = {**equations, "states": states, "start": start}
    columns = content["sensor"]["columns"]
    read = {"x": columns["x"].replace(" + depth*lift", ""), "y": columns["y"].replace(" + lift", "")}
    return {**content, "plant": {"physical": physical}, "sensor": {**content["sensor"], "columns": read}}


def errors(clip, simulation):
    found = camid.identify(clip, simulation)
    assert found.converged
    table = camid.simulate(clip, found.simulation)
    return found, [float(np.sqrt(np.mean((table[f"simulated_{name}"] - table[name]) ** 2))) for name in "xy"]


@pytest.mark.slow
def test_a_swing_out_of_the_plane_explains_most_of_what_a_plane_leaves(clip, believed):
    found, (x, y) = errors(clip, believed)
    _, (x_plane, y_plane) = errors(clip, in_the_plane(believed))
    assert x == pytest.approx(0.60, abs=0.03)
    assert y == pytest.approx(0.315, abs=0.02)
    assert x_plane == pytest.approx(1.34, abs=0.05)
    assert y_plane == pytest.approx(1.05, abs=0.05)
    period = 2.0 * np.pi / np.sqrt(found.simulation.physical.parameters["stiffness"])
    assert period == pytest.approx(2.624, abs=0.002)
