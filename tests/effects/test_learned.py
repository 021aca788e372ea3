"""Laws without a name: values at knots, which stand in a simulation like any effect."""

import numpy as np
import pytest

import camid
from camid.chain.plant import TransferFunction
from camid.effects import known_effects
from camid.effects.learned import LearnedCurve, LearnedForce
from camid.errors import InputError
from tests.support.mass_on_spring import command, effect, record, simulation

FINE = np.linspace(-8.0, 8.0, 4001)
FAST = np.linspace(-40.0, 40.0, 2001)


def test_damping_and_gain_over_the_way():
    knots = [-1.0, 1.0]
    for name, expected in (("damping over position", 3.0), ("gain over position", 5.0), ("gain over velocity", -10.0)):
        law = LearnedForce(variables=name, knots=knots, values=[-2.0, 2.0])
        values = np.array(law.force_values(plant_of(1.0)))
        assert LearnedForce.force.function(0.0, 0.5, 3.0 if "damping" in name else -7.0, 5.0, 0.0, values) == expected


def force(variables, knots, law):
    return LearnedForce(variables=variables, knots=knots.tolist(), values=law(knots).tolist())


def curve(variables, law):
    return LearnedCurve(variables=variables, knots=FINE.tolist(), values=law(FINE).tolist())


@pytest.mark.parametrize(
    ("learned", "named"),
    [
        (force("position", FINE, lambda y: 0.3 * y**3), effect("cubic-stiffness", coefficient=0.3)),
        (force("velocity", FAST, lambda v: 0.002 * v * np.abs(v)), effect("quadratic-drag", coefficient=0.002)),
        (curve("input", lambda u: np.clip(u, -0.7, 0.7)), effect("saturation", limit=0.7)),
        (curve("reading", lambda y: y + 0.02 * y**3), effect("lens-distortion", k1=0.02)),
    ],
    ids=lambda each: each.identifier,
)
def test_a_law_at_many_knots_does_what_the_named_one_does(learned, named):
    # A lens bends what is seen within an exposure, a learned curve what comes out of it.
    recorded = (record(*each, noise=0.0, sensor="instant", exposure=None)["y"] for each in ((learned,), (named,), ()))
    with_law, with_name, without = recorded
    assert np.std(with_name - without) > 1e-2 * np.std(without)
    assert np.std(with_law - with_name) < 2e-3 * np.std(with_name - without)


def test_beyond_its_knots_a_force_stays_and_a_curve_goes_on():
    short = LearnedForce(variables="position", knots=[-1.0, 1.0], values=[-2.0, 2.0])
    values = np.array(short.force_values(plant_of(1.0)))
    at = [LearnedForce.force.function(0.0, y, 0.0, 0.0, 0.0, values) for y in (-5.0, -1.0, 0.25, 1.0, 7.0)]
    assert at == pytest.approx([-2.0, -2.0, 0.5, 2.0, 2.0])
    bent = LearnedCurve(variables="input", knots=[-1.0, 0.0, 1.0], values=[-0.5, 0.0, 2.0])
    assert bent.bent(np.array([-3.0, -1.0, -0.5, 0.5, 1.0, 4.0])) == pytest.approx([-2.5, -0.5, -0.25, 1.0, 2.0, 5.0])


def plant_of(gain):
    return TransferFunction((gain,), (1.0, 1.0, 1.0))


def test_compiled_curve_of_the_actuator_is_that_of_the_open_loop():
    law = curve("input", np.tanh)
    values = np.array(law.force_values(plant_of(1.0)))
    signal = np.linspace(-5.0, 5.0, 41)
    compiled = [LearnedCurve.actuated.function(0.1, 0.0, 0.0, u, 0.0, values) for u in signal]
    assert compiled == pytest.approx(law.bent(signal), abs=1e-12)
    # A curve of the sensor leaves the input alone.
    assert curve("reading", np.tanh).force_values(plant_of(1.0)) == [0.0]
    assert LearnedCurve.actuated.function(0.1, 0.0, 0.0, 0.4, 0.0, np.zeros(1)) == 0.4


def test_force_has_the_sign_of_the_motion_whatever_that_of_the_gain():
    law = force("velocity", FAST, lambda v: 0.01 * v)
    against = [law.force_values(plant_of(gain))[-1] for gain in (2.0, -2.0)]
    assert against == pytest.approx([0.4, -0.4])


def test_it_belongs_to_no_catalogue():
    assert not {"learned-force", "learned-curve"} & set(known_effects())


def declared(*laws):
    effects = [{"id": law.identifier, "parameters": dict(law.values)} for law in laws]
    return simulation(effects=effects, sensor={"column": "y", "kind": "camera", "exposure": 0.02})


def test_a_simulation_declares_several():
    knots = np.linspace(-3.0, 3.0, 13)
    laws = [force("position", knots, lambda y: 0.2 * y**3), force("velocity", 10.0 * knots, np.tanh)]
    table = record(noise=0.0, signal=command())
    alone, both = (camid.simulate(table, declared(*each))["simulated"] for each in (laws[:1], laws))
    assert 0.0 < np.std(both - alone) < np.std(alone)


def test_a_formula_that_is_not_known_may_be_null():
    law = force("position", np.linspace(-3.0, 3.0, 13), lambda y: 0.2 * y**3)
    without, null = declared(law), declared(law)
    null["effects"][0]["parameters"]["formula"] = None
    table = record(noise=0.0, count=200)
    said, expected = (camid.simulate(table, content)["simulated"] for content in (null, without))
    np.testing.assert_array_equal(said, expected)
    null["effects"][0]["parameters"]["values"] = None
    with pytest.raises(InputError, match="values: None is not"):
        camid.simulate(table, null)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"variables": "position", "knots": [0.0, 1.0, 1.0], "values": [0.0, 1.0, 2.0]}, "increasing"),
        ({"variables": "position", "knots": [0.0, 1.0], "values": [0.0]}, "2 knots, but 1 values"),
        ({"variables": "weather", "knots": [0.0, 1.0], "values": [0.0, 1.0]}, "weather"),
        ({"variables": "velocity", "knots": [0.0, float("nan")], "values": [0.0, 1.0]}, "knots"),
    ],
)
def test_impossible_laws_are_refused(values, says):
    table = record(noise=0.0, count=100)
    wrong = simulation(effects=[{"id": "learned-force", "parameters": values}])
    with pytest.raises(InputError, match=says):
        camid.simulate(table, wrong)
