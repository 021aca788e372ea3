"""Drag with a peak: what it does, and how it is found by way of friction that falls as the speed grows."""

import numpy as np
import pytest

import camid
from camid.effects.eddy_current_brake import EddyCurrentBrake
from camid.effects.extent import Extent
from camid.effects.friction import StribeckFriction
from camid.effects.gradual_friction import GradualStribeckFriction
from tests.support.mass_on_spring import PERIOD, PLANT, record, simulation


def test_the_drag_is_viscous_at_low_speeds_and_falls_beyond_its_peak():
    law = EddyCurrentBrake(peak=0.5, velocity=0.8)
    values = law.force_values(PLANT)
    force = [law.force.at(0.0, 0.0, speed, 0.0, 0.0, values=values) for speed in (-0.8, 0.0, 1e-3, 0.4, 0.8, 80.0)]
    np.testing.assert_allclose(force, [-0.5, 0.0, 2.0 * 0.5 * 1e-3 / 0.8, 0.4, 0.5, 0.01], rtol=2e-4)
    assert law.scaled(0.5).values == {"peak": 0.25, "velocity": 0.8}
    assert law.is_plausible(Extent(1.0, 1.0, speed=0.3))
    assert not law.is_plausible(Extent(1.0, 1.0, speed=0.1))  # below the peak it is viscous
    plain = law.simplified()
    assert type(plain) is GradualStribeckFriction
    assert StribeckFriction.with_keys({"peak", "velocity"}) is EddyCurrentBrake


def test_it_resembles_a_friction_that_falls_and_turns_round_gradually():
    law, speeds = EddyCurrentBrake(peak=0.5, velocity=0.8), np.linspace(0.0, 3.2, 41)
    plain = law.simplified()
    drag, friction = (
        np.array([each.force.at(0.0, 0.0, v, 0.0, 0.0, values=each.force_values(PLANT)) for v in speeds])
        for each in (law, plain)
    )
    np.testing.assert_allclose(friction, drag, atol=0.02 * 0.5)


@pytest.mark.slow
def test_an_eddy_current_brake_is_found():
    """It was a Stribeck friction that turns round gradually, and a learned force beside it."""
    law = EddyCurrentBrake(peak=0.4, velocity=0.9)
    (found,) = camid.diagnose(record(law, noise=0.001, count=2500), simulation()).findings
    assert found.title == EddyCurrentBrake.title
    for name, truth in law.values.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.4 * truth, name


@pytest.mark.parametrize("velocity", [6.0, pytest.param(9.0, marks=pytest.mark.slow)])
def test_one_whose_peak_lies_beyond_most_speeds_is_found(velocity):
    """A resonance is swept through: it was Coulomb friction beside bristles of any exponent, or a curve of the way."""
    law, time = EddyCurrentBrake(peak=0.05 * velocity, velocity=velocity), PERIOD * np.arange(2500)
    sweep = np.sin(2.0 * np.pi * (0.5 + 0.02 * time) * time) * np.where(time % 9.0 < 6.5, 0.5, 0.15)
    (found,) = camid.diagnose(record(law, signal=sweep, noise=0.005, count=2500), simulation()).findings
    assert found.title == EddyCurrentBrake.title
    for name, truth in law.values.items():
        estimate = found.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation, name
        assert estimate.standard_deviation < 0.4 * truth, name


@pytest.mark.parametrize("noise", [0.001, 0.01])
@pytest.mark.slow
def test_friction_that_falls_is_none(noise):
    law = StribeckFriction(coulomb=0.2, breakaway=0.4, velocity=0.8)
    found = camid.diagnose(record(law, noise=noise, count=2500), simulation()).findings
    assert EddyCurrentBrake.title not in [f.title for f in found]
