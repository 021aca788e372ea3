"""A motor whose tachometer is the output: dry friction of a speed that is read, and not of its derivative."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.effects.extent import Extent
from camid.effects.friction import CoulombFriction
from camid.effects.friction_of_a_shaft import FrictionOfAShaft
from tests.support.mass_on_spring import PLANT

PERIOD, COUNT, FINE = 0.02, 1500, 40
GAIN, RATE, FRICTION = 60.0, 4.0, 0.8


def speeds(signal):
    """Speed at each row, shape (N,), of a shaft that dry friction holds and slows (implicit steps, exact at rest)."""
    step, speed, found = PERIOD / FINE, 0.0, []
    for level in signal:
        found.append(speed)
        for _ in range(FINE):
            free = speed + step * (GAIN * level - RATE * speed)
            speed = np.sign(free) * max(abs(free) - step * GAIN * FRICTION, 0.0)
    return np.array(found)


@pytest.mark.parametrize("gain", [1.0, -1.0])
def test_the_friction_acts_against_the_speed_that_is_read(gain):
    law = FrictionOfAShaft(force=0.8, standstill=0.1)
    plant = TransferFunction((gain * GAIN,), (1.0, RATE))
    acting = [law.force.at(0.0, y, 0.0, 0.0, 0.0, values=law.force_values(plant)) for y in (-5.0, 0.0, 5.0)]
    assert [gain * f for f in acting] == pytest.approx([-0.8, 0.0, 0.8])
    assert law.is_plausible(Extent(span=10.0, duration=1.0))
    assert not law.is_plausible(Extent(span=0.2, duration=1.0))  # viscous
    assert CoulombFriction.with_keys({"standstill"}) is FrictionOfAShaft


def test_a_motor_with_dry_friction_is_told_by_its_tachometer():
    """It was an outflow with the square root of the level."""
    random = np.random.default_rng(7)
    signal = np.repeat(random.choice([-6.0, -3.0, -1.2, -0.5, 0.0, 0.7, 1.5, 3.0, 6.0], COUNT // 40 + 1), 40)[:COUNT]
    true = speeds(signal)
    output = true + 0.01 * np.std(true) * random.standard_normal(COUNT)
    recording = pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": output})
    simulation = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [50.0], "denominator": [1.0, 3.2]}},
        "sensor": {"column": "y", "kind": "instant"},
    }
    found = camid.diagnose(recording, simulation)
    (finding,) = found.findings
    assert (finding.identifier, finding.title) == ("coulomb-friction", FrictionOfAShaft.title)
    force = finding.parameters["force"]
    assert abs(force.value - FRICTION) < 4.0 * force.standard_deviation < 0.1 * FRICTION
    assert camid.diagnose(recording, found.improved.to_mapping()).verdict == "adequate"


def test_a_body_on_a_spring_is_no_shaft():
    shaft, body = (SimpleNamespace(plant=plant) for plant in (TransferFunction((GAIN,), (1.0, RATE)), PLANT))
    assert FrictionOfAShaft.invisible(shaft) is None
    assert "one pole" in FrictionOfAShaft.invisible(body)
