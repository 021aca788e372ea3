"""Friction that turns round gradually: what it does, and how it is found."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.bristle_friction import StribeckBristleFriction
from camid.effects.extent import Extent
from camid.effects.friction import StribeckFriction
from camid.effects.gradual_friction import (
    AsymmetricFrictionOfAnyKnee,
    CoulombFrictionOfAnyKnee,
    GradualCoulombFriction,
    GradualStribeckFriction,
)
from camid.engine.mechanics import Chain
from camid.engine.run import run
from tests.support.mass_on_spring import PLANT, record, simulation

SPEEDS = np.linspace(-3.0, 3.0, 61)


def forces(law):
    """Of a law at some speeds."""
    values = law.force_values(PLANT)
    return np.array([law.force.at(0.0, 0.0, speed, 0.0, 0.0, values=values) for speed in SPEEDS])


@pytest.mark.parametrize(
    ("sharpness", "known", "within"),
    [
        (2.0, lambda x: x / np.sqrt(1.0 + x**2), 1e-12),
        (1.0, lambda x: x / (1.0 + np.abs(x)), 1e-12),
        (2.4, np.tanh, 0.04),
        (20.0, lambda x: np.clip(x, -1.0, 1.0), 0.04),
    ],
)
def test_a_knee_of_any_sharpness(sharpness, known, within):
    law = CoulombFrictionOfAnyKnee(force=0.4, transition=0.5, sharpness=sharpness)
    np.testing.assert_allclose(forces(law), 0.4 * known(SPEEDS / 0.5), atol=0.4 * within)
    assert type(law.simplified()) is GradualCoulombFriction
    assert law.simplified().values == {"force": 0.4, "transition": 0.5}


@pytest.mark.slow
def test_friction_over_a_square_root_is_found_with_its_knee():
    """With a hyperbolic tangent in its place two frictions were named for one."""
    law = CoulombFrictionOfAnyKnee(force=0.3, transition=0.5, sharpness=2.0)
    found = camid.diagnose(record(law, noise=0.0005, count=2500), simulation())
    assert [f.identifier for f in found.findings] == ["coulomb-friction"]
    for name, truth in law.values.items():
        estimate = found.findings[0].parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.4 * truth, name
    (declared,) = found.improved.effects
    assert "sharpness" in declared.parameters


def test_a_damper_with_valves_has_a_knee_and_another_force_in_each_direction():
    law = AsymmetricFrictionOfAnyKnee(forward=0.5, backward=0.1, transition=0.4, sharpness=2.0)
    shape = SPEEDS / np.sqrt(0.4**2 + SPEEDS**2)
    np.testing.assert_allclose(forces(law), np.where(SPEEDS > 0.0, 0.5, 0.1) * shape, atol=1e-12)
    plain = law.simplified()
    assert type(plain) is CoulombFrictionOfAnyKnee
    assert plain.values == {"force": 0.3, "transition": 0.4, "sharpness": 2.0}
    assert {type(each) for each in plain.finer(None)} == {AsymmetricFrictionOfAnyKnee}
    extent = Extent(span=1.0, duration=10.0, speed=1.0)
    assert law.is_plausible(extent)
    assert not law.with_vector(np.array([0.5, 0.01, 0.4, 2.0])).is_plausible(extent)


@pytest.mark.slow
def test_a_shock_absorber_is_found_whose_rebound_is_damped_more():
    """It was a Coulomb friction beside a bias, and a learned curve of the sensor."""
    law = AsymmetricFrictionOfAnyKnee(forward=0.5, backward=0.12, transition=0.4, sharpness=2.0)
    (found,) = camid.diagnose(record(law, noise=0.001, count=2500), simulation()).findings
    assert found.title == AsymmetricFrictionOfAnyKnee.title
    for name, truth in law.values.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.4 * truth, name


def test_friction_that_turns_round_gradually_is_viscous_at_rest_and_dry_beyond():
    law = GradualCoulombFriction(force=0.4, transition=0.1)
    values = np.array([0.4, 0.1])
    force = [law.force.function(0.0, 0.0, speed, 0.0, 0.0, values) for speed in (-9.0, 0.0, 1e-3, 9.0)]
    np.testing.assert_allclose(force, [-0.4, 0.0, 0.4 * np.tanh(0.01), 0.4], rtol=1e-9)
    assert law.simplified().values == {"force": 0.4}


@pytest.mark.slow
def test_friction_that_turns_round_gradually_is_no_stribeck_friction():
    """Whose level would have to rise with the speed."""
    table = record(GradualCoulombFriction(force=0.3, transition=0.6), count=2500)
    (found,) = camid.diagnose(table, simulation()).findings
    assert found.identifier == "coulomb-friction"
    for name, truth in (("force", 0.3), ("transition", 0.6)):
        estimate = found.parameters[name]
        assert abs(estimate.value - truth) < 3.0 * estimate.standard_deviation < 0.5 * truth


def test_friction_that_turns_round_gradually_may_fall_beyond():
    law = GradualStribeckFriction(coulomb=0.2, breakaway=0.5, velocity=1.0, transition=0.1)
    values = np.array([0.2, 0.5, 1.0, 0.1])
    force = [law.force.function(0.0, 0.0, speed, 0.0, 0.0, values) for speed in (-9.0, 0.0, 1e-3, 0.5, 9.0)]
    falling = 0.2 + 0.3 * np.exp(-0.25)
    np.testing.assert_allclose(force, [-0.2, 0.0, 0.5 * np.tanh(0.01), falling * np.tanh(5.0), 0.2], rtol=1e-5)
    assert law.simplified().values == {"coulomb": 0.2, "breakaway": 0.5, "velocity": 1.0}
    assert not law.with_vector(np.array([0.2, 0.5, 1.0, 1.1])).is_plausible(Extent(1.0, 1.0))
    assert not law.with_vector(np.array([0.5, 0.2, 1.0, 0.1])).is_plausible(Extent(1.0, 1.0))


@pytest.mark.slow
def test_friction_of_a_servo_that_falls_and_turns_round_gradually_is_found():
    """As of a motor with an encoder: neither law of less detail leaves noise, nor does one with bristles."""
    plant = {"numerator": [2500.0], "denominator": [1.0, 9.0, 0.0]}
    law = GradualStribeckFriction(coulomb=0.45, breakaway=0.72, velocity=90.0, transition=6.0)
    chain = Chain(
        TransferFunction(**{k: tuple(v) for k, v in plant.items()}), Acquisition(0.01, sensor="instant"), (law,)
    )
    random = np.random.default_rng(5)
    signal = np.repeat(random.choice([-1.5, -1.0, -0.8, 0.8, 1.0, 1.5], 45), 40)
    time = 0.01 * np.arange(len(signal))
    table = pd.DataFrame({"t": time, "u": signal, "y": run(chain, signal, time) + 0.3 * random.standard_normal(1800)})
    believed = simulation(
        plant={"transfer_function": {"numerator": [2000.0], "denominator": [1.0, 12.0, 0.0]}},
        sensor={"column": "y", "kind": "instant", "offset": 0.0},
    )
    (found,) = camid.diagnose(table, believed).findings
    assert found.title == GradualStribeckFriction.title
    for name, truth in law.values.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.4 * truth, name


def test_stribeck_friction_falls_as_the_speed_grows():
    levels = {"breakaway": 0.3, "velocity": 1.0}
    assert StribeckFriction(coulomb=0.2, **levels).is_plausible(Extent(1.0, 1.0))
    assert not StribeckFriction(coulomb=0.4, **levels).is_plausible(Extent(1.0, 1.0))
    assert not StribeckBristleFriction(coulomb=0.4, presliding=0.1, **levels).is_plausible(Extent(1.0, 1.0))
