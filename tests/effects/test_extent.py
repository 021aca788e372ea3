"""What recordings reach, and laws that would act beyond it."""

from dataclasses import replace

import numpy as np
import pytest

from camid.effects.extent import Extent
from camid.effects.friction import CoulombFriction, StribeckFriction
from camid.effects.gradual_dead_zone import GradualDeadZone
from camid.effects.gradual_friction import GradualAsymmetricFriction, GradualCoulombFriction, GradualStribeckFriction
from camid.effects.modes import ModeDampedBetween
from camid.effects.rows_of_the_log import InputPickup, InputPickupOfRowBefore
from camid.effects.two_term_springs import CubicStiffnessWithFifthPower
from camid.fitting.recorded_extent import extent_of
from tests.fitting.test_fitted_rows import COUNT, PERIOD, problem_and_model

REACHED = Extent(span=2.0, duration=10.0, speed=0.5, signal=3.0)


@pytest.mark.parametrize(
    "law",
    [
        lambda speed: GradualCoulombFriction(force=1.0, transition=speed),
        lambda speed: GradualAsymmetricFriction(forward=1.0, backward=0.9, transition=speed),
        lambda speed: GradualStribeckFriction(coulomb=1.0, breakaway=1.2, velocity=2.0, transition=speed),
    ],
)
def test_friction_that_turns_round_beyond_the_speeds_recorded_is_viscous(law):
    assert law(0.4).is_plausible(REACHED)
    assert not law(0.6).is_plausible(REACHED)
    assert law(0.6).is_plausible(Extent(2.0, 10.0))  # of speeds of which nothing is known


def test_a_dead_zone_that_no_command_leaves_is_a_curve():
    assert GradualDeadZone(half_width=2.9, sharpness=2.0).is_plausible(REACHED)
    assert not GradualDeadZone(half_width=3.1, sharpness=2.0).is_plausible(REACHED)
    assert CoulombFriction(force=9.0).is_plausible(REACHED)


def test_friction_that_falls_to_nothing_is_another_force():
    law = StribeckFriction(coulomb=0.5, breakaway=1.0, velocity=0.1)
    assert law.is_plausible(REACHED)
    assert not law.with_vector(np.array([0.05, 1.0, 0.1])).is_plausible(REACHED)
    assert not law.with_vector(np.array([1.1, 1.0, 0.1])).is_plausible(REACHED)
    # Where nothing moved fast, nothing says what it falls to.
    assert law.with_vector(np.array([0.05, 1.0, 0.8])).is_plausible(REACHED)


def test_a_fifth_power_beside_a_quadratic_spring_is_a_series():
    law = CubicStiffnessWithFifthPower(coefficient=1.0, fifth=20.0)
    assert law.is_plausible(REACHED)
    assert not law.is_plausible(replace(REACHED, beside=frozenset({"quadratic-stiffness"})))


def test_the_extent_is_that_of_the_recordings():
    problem, _ = problem_and_model("zoh")
    extent = extent_of(problem)
    time = PERIOD * np.arange(COUNT)
    swinging = 2.0 * np.sin(3.0 * time) + 1e-3 * np.random.default_rng(3).standard_normal(COUNT)
    moved = [replace(e, output=swinging) for e in problem.experiments]
    found = extent_of(replace(problem, experiments=moved))
    assert extent.duration == pytest.approx(PERIOD * (COUNT - 1))
    assert extent.signal == pytest.approx(max(np.max(np.abs(e.signal)) for e in problem.experiments))
    assert found.span == pytest.approx(4.0, rel=0.01)
    assert found.speed == pytest.approx(6.0 / np.sqrt(2.0), rel=0.02)


@pytest.mark.parametrize(("share", "plausible"), [(0.0, True), (1.0, True), (1.4, True), (1.6, False), (100.0, False)])
def test_no_more_of_a_mode_s_damping_lies_in_its_spring_than_there_is(share, plausible):
    """Half as much again at most, by an estimate: what the output does earlier than that is no mode."""
    law = ModeDampedBetween(natural_frequency=30.0, damping=0.1, lead=share * 2.0 * 0.1 / 30.0)
    assert law.is_plausible(REACHED) is plausible


@pytest.mark.parametrize(("coefficient", "plausible"), [(0.6, True), (-0.6, True), (0.7, False), (-4.3, False)])
def test_no_more_of_the_command_is_picked_up_than_is_read(coefficient, plausible):
    """A fast plant that is a frame late was a pick-up of minus four times the command, which the plant took back."""
    for law in (InputPickup(coefficient=coefficient), InputPickupOfRowBefore(coefficient=coefficient, row="before")):
        assert law.is_plausible(REACHED) is plausible
    assert InputPickup(coefficient=coefficient).is_plausible(Extent(2.0, 10.0))
