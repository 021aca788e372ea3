"""Hysteresis with a free exponent: its step against closed forms, and how it is found."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.effects.hysteresis import Hysteresis
from camid.effects.hysteresis_of_any_power import HysteresisOfAnyPower
from tests.support.mass_on_spring import PLANT, record, simulation


def after(law, way, memory):
    """What becomes of the memory over a way, by the compiled part."""
    return law.memory_after.at(0.0, way, 0.0, 0.0, memory, values=law.force_values(PLANT))


@pytest.mark.parametrize("way", [-60.0, -0.9, 0.05, 1.3])
@pytest.mark.parametrize("memory", [-0.8, 0.0, 0.6])
def test_with_an_exponent_of_one_it_is_the_plain_law(way, memory):
    law = HysteresisOfAnyPower(strength=1.0, shape=1.3, exponent=1.0)
    plain = law.simplified()
    assert isinstance(plain, Hysteresis)
    np.testing.assert_allclose(after(law, way, memory), after(plain, way, memory), rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("way", [0.02, 0.7, 4.0, 100.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_with_an_exponent_of_two_it_is_a_hyperbolic_tangent(way, side):
    law = HysteresisOfAnyPower(strength=1.0, shape=1.0, exponent=2.0)
    np.testing.assert_allclose(after(law, side * way, side * 0.2), side * np.tanh(way + np.arctanh(0.2)), atol=1e-5)


@pytest.mark.parametrize("exponent", [1.5, 3.0, 8.0, 20.0])
def test_two_ways_in_turn_are_one_way(exponent):
    law = HysteresisOfAnyPower(strength=1.0, shape=1.0, exponent=exponent)
    ways = np.linspace(0.01, 3.0, 50)
    in_turn = [after(law, 0.7, after(law, way, 0.1)) for way in ways]
    np.testing.assert_allclose(in_turn, [after(law, way + 0.7, 0.1) for way in ways], atol=1e-9)


@pytest.mark.parametrize("exponent", [1.5, 3.0, 8.0, 20.0])
def test_it_follows_its_differential_equation(exponent):
    law = HysteresisOfAnyPower(strength=1.0, shape=1.0, exponent=exponent)
    ways = np.linspace(0.05, 3.0, 40)
    exact = solve_ivp(lambda _, z: 1.0 - np.abs(z) ** exponent, (0.0, 3.0), [0.1], t_eval=ways, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose([after(law, way, 0.1) for way in ways], exact.y[0], atol=2e-6)


def test_against_the_present_force_it_is_straight():
    law = HysteresisOfAnyPower(strength=1.0, shape=2.0, exponent=5.0)
    assert after(law, -0.2, 0.9) == pytest.approx(0.5)


@pytest.mark.slow
def test_a_loop_that_saturates_suddenly_is_found():
    law = HysteresisOfAnyPower(strength=0.5, shape=3.0, exponent=3.0)
    found = camid.diagnose(record(law, noise=0.002, count=1500), simulation())
    assert [f.identifier for f in found.findings] == ["hysteresis"]
    for name, truth in law.values.items():
        estimate = found.findings[0].parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.5 * truth
