"""Drag that grows with any power of the speed: what it is, and how it is found."""

from types import SimpleNamespace

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.effects.damping import QuadraticDrag
from camid.effects.drag_of_any_power import DragOfAnyPower
from camid.effects.extent import Extent
from camid.effects.plant_force import force_along
from tests.support.mass_on_spring import PERIOD, PLANT, record, simulation
from tests.support.runge_kutta import positions

LAW = DragOfAnyPower(coefficient=0.2, power=1.6, speed=2.0)


@pytest.mark.parametrize("gain", [1.0, -1.0])
def test_it_is_the_power_and_at_the_stated_speed_quadratic_drag(gain):
    plant = TransferFunction((gain,), (1.0, 1.0, 0.0))
    speeds = np.array([-4.0, -2.0, -0.1, 0.0, 0.3, 2.0, 5.0])
    motion = (np.zeros(7), np.zeros(7), speeds, np.zeros(7))
    forces = force_along(LAW, plant, motion)
    np.testing.assert_allclose(forces, -gain * 0.8 * np.sign(speeds) * (np.abs(speeds) / 2.0) ** 1.6, atol=1e-12)
    plain = LAW.simplified()
    assert type(plain) is QuadraticDrag
    np.testing.assert_allclose(force_along(plain, plant, motion)[[1, 5]], forces[[1, 5]])


def test_the_speed_is_stated_and_not_estimated():
    assert [parameter.name for parameter in LAW.numeric()] == ["coefficient", "power"]
    moved = LAW.with_vector(np.array([0.3, 2.1]))
    assert moved.values == {"coefficient": 0.3, "power": 2.1, "speed": 2.0}


def test_a_power_of_one_is_the_damping_of_the_plant():
    extent = Extent(1.0, 1.0)
    assert LAW.is_plausible(extent)
    assert not DragOfAnyPower(coefficient=0.2, power=1.05, speed=2.0).is_plausible(extent)


def test_it_is_started_at_the_usual_speed():
    velocity = np.random.default_rng(1).standard_normal(500) * 3.333
    starts = list(DragOfAnyPower.starts(SimpleNamespace(velocity=velocity), coefficient=0.1))
    (speed,) = {law.values["speed"] for law in starts}
    assert speed == pytest.approx(np.std(velocity), rel=0.05)
    assert min(law.values["power"] for law in starts) < 2.0 < max(law.values["power"] for law in starts)


@pytest.mark.parametrize("power", [1.5, 2.8])
@pytest.mark.slow
def test_it_is_found(power):
    """Of a mass on a spring, by another program."""
    random = np.random.default_rng([29, round(10 * power)])
    rows = 1500
    signal = np.repeat(random.uniform(-2.0, 2.0, rows // 15), 15)
    gain, damping, stiffness = PLANT.numerator[-1], *PLANT.denominator[-2:]
    usual = 3.0

    def rate(state, drive):
        drag = 0.5 * np.sign(state[1]) * (abs(state[1]) / usual) ** power
        return np.array([state[1], gain * (drive - drag) - damping * state[1] - stiffness * state[0]])

    seen = positions(rate, signal, PERIOD, 6)
    seen += 0.0005 * np.std(seen) * random.standard_normal(rows)
    table = record(signal=signal, count=rows).assign(u=signal, y=seen)
    found = camid.diagnose(table, {**simulation(), "sensor": {"column": "y", "kind": "instant"}})
    (drag,) = found.findings
    assert (drag.identifier, found.verdict) == ("quadratic-drag", "explained")
    estimate, coefficient = (drag.parameters[name] for name in ("power", "coefficient"))
    assert abs(estimate.value - power) < 4.0 * estimate.standard_deviation < 0.2
    speed = drag.parameters["speed"]
    assert speed.standard_deviation is None
    truth = 0.5 / speed.value**2 * (speed.value / usual) ** power
    assert abs(coefficient.value - truth) < 4.0 * coefficient.standard_deviation < 0.2 * truth
    assert camid.diagnose(table, found.improved.to_mapping()).verdict == "adequate"
