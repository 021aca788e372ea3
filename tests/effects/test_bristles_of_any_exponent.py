"""Dahl's friction with its exponent: its step against the differential equation, and how it is found."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.effects.bristle_friction import CoulombBristleFriction
from camid.effects.bristles_of_any_exponent import CoulombBristlesOfAnyExponent
from camid.effects.hysteresis import Hysteresis
from tests.effects.test_bristle_friction import situation
from tests.support.mass_on_spring import PERIOD, PLANT, record, simulation
from tests.support.runge_kutta import positions

BEND = 0.7


def after(law, way, memory):
    """What becomes of the memory over a way, by the compiled part."""
    return law.memory_after.at(0.0, way, 0.0, 0.0, memory, values=law.force_values(PLANT))


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.6, 3.0])
@pytest.mark.parametrize("memory", [-1.0, -0.4, 0.9])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_its_step_follows_the_differential_equation(exponent, memory, side):
    law = CoulombBristlesOfAnyExponent(force=1.0, presliding=BEND, bristle_exponent=exponent)
    ways = np.linspace(0.05, 3.0, 9)
    exact = solve_ivp(
        lambda _, z: side * np.maximum(1.0 - side * z, 0.0) ** exponent / BEND,
        (0.0, 3.0),
        [side * memory],
        t_eval=ways,
        rtol=1e-10,
        atol=1e-12,
    )
    np.testing.assert_allclose([after(law, side * way, side * memory) for way in ways], exact.y[0], atol=1e-5)


def test_brittle_bristles_break_away_on_a_way_that_ends():
    """An exponent of a half leaves nothing after 2 √w δ, for w that was left."""
    law = CoulombBristlesOfAnyExponent(force=1.0, presliding=BEND, bristle_exponent=0.5)
    assert after(law, 2.0 * BEND, 0.0) == 1.0
    assert after(law, 1.9 * BEND, 0.0) < 1.0
    assert after(law, 0.3, 1.0) == 1.0
    assert after(law, -0.3, -1.0) == -1.0


def test_with_an_exponent_of_one_it_is_the_plain_law():
    law = CoulombBristlesOfAnyExponent(force=1.0, presliding=BEND, bristle_exponent=1.0)
    plain = law.simplified()
    assert type(plain) is CoulombBristleFriction
    for way in (-2.0, -0.1, 0.3):
        assert after(law, way, 0.4) == pytest.approx(after(plain, way, 0.4), abs=1e-12)


def test_it_is_started_from_bristles_alone():
    given = situation()
    (first, *_) = CoulombBristleFriction.starts(given, force=0.2, presliding=0.1)
    exponents = [law for law in first.finer(given) if "bristle_exponent" in law.values]
    assert {law.values["presliding"] for law in exponents} == {0.1}
    assert (
        min(law.values["bristle_exponent"] for law in exponents)
        < 1.0
        < max(law.values["bristle_exponent"] for law in exponents)
    )
    assert not list(CoulombBristlesOfAnyExponent.starts(given, force=0.2))
    assert CoulombBristlesOfAnyExponent not in {type(law) for law in Hysteresis(strength=0.2, shape=10.0).finer(given)}
    assert exponents[0].finer(given) == ()


def held_by_bristles(seed):
    """Positions of a mass on a spring under friction that yields with an exponent of 1.7, by another program."""
    random = np.random.default_rng([23, seed])
    rows = 1500
    signal = np.repeat(random.uniform(-2.0, 2.0, rows // 15), 15)
    gain, damping, stiffness = PLANT.numerator[-1], *PLANT.denominator[-2:]

    def rate(state, drive):
        way = np.sign(state[1]) * max(1.0 - np.sign(state[1]) * state[2], 0.0) ** 1.7
        force = gain * (drive - 0.4 * state[2])
        return np.array([state[1], force - damping * state[1] - stiffness * state[0], abs(state[1]) * way / 0.15])

    seen = positions(rate, signal, PERIOD, 8, states=3)
    return signal, seen + 0.001 * np.std(seen) * random.standard_normal(rows)


@pytest.mark.slow
def test_it_is_found():
    signal, seen = held_by_bristles(1)
    table = record(signal=signal, count=len(signal)).assign(u=signal, y=seen)
    found = camid.diagnose(table, {**simulation(), "sensor": {"column": "y", "kind": "instant"}})
    (friction,) = found.findings
    assert (friction.identifier, found.verdict) == ("coulomb-friction", "explained")
    for name, truth in {"force": 0.4, "presliding": 0.15, "bristle_exponent": 1.7}.items():
        estimate = friction.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.2 * truth
    assert camid.diagnose(table, found.improved.to_mapping()).verdict == "adequate"
