"""Friction with pre-sliding displacement: how files declare it, what it becomes, and how it is looked for."""

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.effects import Situation, bristle_friction, friction, hysteresis, known_effects
from camid.effects.declared import declared, effects_of
from camid.effects.extent import Extent
from camid.effects.hysteresis_of_any_power import EXPONENTS
from camid.engine.mechanics import Chain
from camid.engine.run import run
from camid.errors import InputError
from camid.simulation.file import load_simulation
from tests.support.mass_on_spring import PERIOD, PLANT, command, simulation

COULOMB = {"force": 0.2}
STRIBECK = {"coulomb": 0.1, "breakaway": 0.3, "velocity": 1.0}


def effect_of(identifier, parameters):
    """What a simulation file that declares it is read as."""
    (found,) = effects_of(load_simulation(simulation(effects=[{"id": identifier, "parameters": parameters}])))
    return found


def situation():
    """A mass that swings."""
    time = PERIOD * np.arange(500)
    position, velocity = np.sin(3.0 * time), 3.0 * np.cos(3.0 * time)
    used = np.ones(500, bool)
    return Situation(time, position, position, position, velocity, 0.0 * time, PLANT, Acquisition(PERIOD), used)


@pytest.mark.parametrize(
    ("identifier", "parameters", "plain", "finer"),
    [
        ("coulomb-friction", COULOMB, friction.CoulombFriction, bristle_friction.CoulombBristleFriction),
        ("stribeck-friction", STRIBECK, friction.StribeckFriction, bristle_friction.StribeckBristleFriction),
    ],
)
def test_one_key_gives_a_friction_bristles(identifier, parameters, plain, finer):
    assert type(effect_of(identifier, parameters)) is plain is known_effects()[identifier]
    found = effect_of(identifier, {**parameters, "presliding": 0.05})
    assert type(found) is finer
    (written,) = declared([found], [{"presliding": 0.001}])
    assert (written.identifier, written.parameters["presliding"]) == (identifier, 0.05)
    unit = next(p.unit for p in finer.parameters if p.name == "presliding")
    assert unit == "y"


@pytest.mark.parametrize("presliding", [0.0, -0.1, "small"])
def test_a_displacement_is_positive(presliding):
    with pytest.raises(InputError, match="presliding"):
        effect_of("coulomb-friction", {**COULOMB, "presliding": presliding})


def test_a_misspelt_key_is_answered_with_the_right_one():
    with pytest.raises(InputError, match="presldiing") as raised:
        effect_of("coulomb-friction", {**COULOMB, "presldiing": 0.1})
    assert "presliding" in str(raised.value.hint)
    with pytest.raises(InputError, match="twice"):
        effects_of(
            load_simulation(
                simulation(
                    effects=[
                        {"id": "coulomb-friction", "parameters": COULOMB},
                        {"id": "coulomb-friction", "parameters": {**COULOMB, "presliding": 0.1}},
                    ]
                )
            )
        )


@pytest.mark.parametrize(("identifier", "parameters"), [("coulomb-friction", COULOMB), ("stribeck-friction", STRIBECK)])
def test_short_bristles_are_friction_without_them(identifier, parameters):
    signal = command(300)
    time = PERIOD * np.arange(len(signal))

    def output(**more):
        return run(Chain(PLANT, Acquisition(PERIOD), (effect_of(identifier, {**parameters, **more}),)), signal, time)

    plain = output()
    errors = [float(np.std(output(presliding=bend) - plain) / np.std(plain)) for bend in (0.1, 1e-3, 1e-5)]
    assert errors[0] > 0.05
    assert errors[0] > 3.0 * errors[1] > 15.0 * errors[2]
    assert errors[2] < 2e-3


def test_a_stribeck_law_of_one_level_is_dahls():
    signal = command(300)
    time = PERIOD * np.arange(len(signal))
    same = (
        bristle_friction.CoulombBristleFriction(force=0.2, presliding=0.05),
        bristle_friction.StribeckBristleFriction(coulomb=0.2, breakaway=0.2, velocity=1.0, presliding=0.05),
    )
    first, second = (run(Chain(PLANT, Acquisition(PERIOD), (law,)), signal, time) for law in same)
    assert np.max(np.abs(first - second)) < 1e-4 * np.std(first)


def test_what_never_saturates_is_not_friction():
    law = bristle_friction.CoulombBristleFriction(force=0.2, presliding=1.0)
    assert law.is_plausible(Extent(4.1, 1.0))
    assert not law.is_plausible(Extent(3.9, 1.0))


def test_a_search_goes_from_a_law_to_finer_ones():
    given = situation()
    laws = hysteresis.Hysteresis(strength=0.2, shape=10.0).finer(given)
    sudden, from_hysteresis = laws[:2], laws[2:]
    assert [law.values["exponent"] for law in sudden] == list(EXPONENTS)
    assert [(type(e).__name__, e.values) for e in from_hysteresis[:1]] == [
        ("CoulombBristleFriction", {"force": 0.2, "presliding": 0.1})
    ]
    assert {type(e).__name__ for e in from_hysteresis[1:]} == {"GradualCoulombFriction"}
    for plain in (friction.CoulombFriction(**COULOMB), friction.StribeckFriction(**STRIBECK)):
        finer = [law for law in plain.finer(given) if "presliding" in law.values]
        assert len(finer) == len(bristle_friction.BENDS)
        assert {e.identifier for e in finer} == {plain.identifier}
        assert all(plain.values.items() <= e.values.items() for e in finer)
    levels_that_fall = [law for law in from_hysteresis[0].finer(given) if "breakaway" in law.values]
    assert {e.identifier for e in levels_that_fall} == {"stribeck-friction"}
    assert levels_that_fall[0].finer(given) == ()


def test_a_fit_keeps_to_displacements_that_the_motion_can_show():
    given = situation()
    _, _, law, *_ = hysteresis.Hysteresis(strength=0.2, shape=10.0).finer(given)
    least = bristle_friction.LEAST_SHARE * float(np.std(given.position))
    acquisition = Acquisition(PERIOD)
    assert law.bounds(acquisition)[1] == (least, np.inf)
    assert law.with_vector(law.vector).bounds(acquisition)[1] == (least, np.inf)
    assert law.with_vector(np.array([0.2, least])).finer(given) == ()  # nothing bends
