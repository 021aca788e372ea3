"""Stops at both ends of a way, and play around a spring."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.effects.end_stops_on_both_sides import EndStopsOnBothSides
from camid.effects.extent import Extent
from camid.effects.stiffness import EndStop
from tests.support.mass_on_spring import PLANT
from tests.support.runge_kutta import positions

PERIOD, COUNT, FINE = 0.02, 1500, 10


@pytest.mark.parametrize("gain", [1.0, -1.0])
def test_each_stop_pushes_back_beyond_it(gain):
    plant = TransferFunction(tuple(gain * np.array(PLANT.numerator)), PLANT.denominator)
    law = EndStopsOnBothSides(position=0.9, stiffness=3.0, opposite=-0.5, opposite_stiffness=2.0)
    mirrored = EndStopsOnBothSides(position=-0.5, stiffness=2.0, opposite=0.9, opposite_stiffness=3.0)
    for at, force in ((1.1, 0.6), (0.8, 0.0), (-0.4, 0.0), (-0.75, -0.5)):
        for each in (law, mirrored):
            found = each.force.at(0.0, at, 0.0, 0.0, 0.0, values=each.force_values(plant))
            assert gain * found == pytest.approx(force)
    at_stops = [law.switch.at(0.0, at, 0.0, 0.0, 0.0, values=law.force_values(plant)) for at in (1.0, 0.0, -1.0)]
    assert np.sign(at_stops).tolist() == [1.0, -1.0, 1.0]
    assert type(law.simplified()) is EndStop
    assert law.scaled(2.0).values == {"position": 0.9, "stiffness": 6.0, "opposite": -0.5, "opposite_stiffness": 4.0}


def test_without_a_way_between_them_they_are_a_spring_and_a_constant_force():
    """What they do beyond the plant's own spring is a bias, which asymmetric friction is, too."""
    gap = {"position": 0.05, "opposite": 0.049}
    spring = EndStopsOnBothSides(**gap, stiffness=3.0, opposite_stiffness=3.0)
    apart = EndStopsOnBothSides(position=0.5, stiffness=3.0, opposite=-0.5, opposite_stiffness=3.0)
    extent = Extent(span=2.0, duration=30.0)
    assert not spring.is_plausible(extent)
    assert apart.is_plausible(extent)
    seen = SimpleNamespace(position=np.array([-1.0, 1.0]), plant=PLANT)
    (bias,) = spring.relatives(seen)
    assert bias.identifier == "input-bias"
    # At the sensor's zero it pushes by the spring's force there.
    force = spring.force.at(0.0, 0.0, 0.0, 0.0, 0.0, values=spring.force_values(PLANT))
    assert bias.values["bias"] == pytest.approx(-force, rel=0.02)
    assert apart.relatives(seen) == ()


def recorded(force, seed):
    """A mass on a spring, and a force over its position."""
    random = np.random.default_rng(seed)
    signal = np.repeat(random.choice([-1.6, -0.6, 0.4, 1.3], COUNT // 12 + 1), 12)[:COUNT]

    def slope(x, level):
        return np.array([x[1], 20.0 * (level - force(x[0])) - 2.0 * x[1] - 40.0 * x[0]])

    output = positions(slope, signal, PERIOD, FINE)
    noise = 0.004 * np.std(output) * random.standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": output + noise})


CASES = {
    "stops": ((0.8, 12.0, -1.0, 25.0), lambda y: 12.0 * max(y - 0.8, 0.0) + 25.0 * min(y + 1.0, 0.0)),
    # No spring of 2 u for a unit of y between -0.5 and 0.5, and the whole spring beyond.
    "play": ((0.5, 2.0, -0.5, 2.0), lambda y: -2.0 * np.clip(y, -0.5, 0.5)),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.slow
def test_stops_on_both_sides_and_play_around_a_spring_are_found(name):
    wanted, force = CASES[name]
    nominal = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [15.0], "denominator": [1.0, 3.0, 35.0]}},
        "sensor": {"column": "y", "kind": "instant"},
    }
    found = camid.diagnose(recorded(force, seed=2), nominal)
    assert [f.identifier for f in found.findings] == ["end-stop"]
    parameters = found.findings[0].parameters
    pairs = [
        [parameters[key].value for key in keys]
        for keys in (("position", "stiffness"), ("opposite", "opposite_stiffness"))
    ]
    (high, stiff), (low, other) = sorted(pairs, reverse=True)
    assert (high, stiff, low, other) == pytest.approx(wanted, rel=0.03)
    assert found.verdict == "explained"
