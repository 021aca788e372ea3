"""The mechanics of the concealed recordings, against exact linear theory and smaller steps; the sizes of effects."""

from __future__ import annotations

import numpy as np
import pytest

from camid.chain.acquisition import Acquisition
from camid.chain.exact import sample
from camid.proof.concealed import vector_layout as s
from camid.proof.concealed.camera_readings import clean, motion, readings
from camid.proof.concealed.cases import CATALOGUE
from camid.proof.concealed.detectability import strength_for
from camid.proof.concealed.drawn_recording import add_effect, draw_recording
from camid.proof.concealed.generator import Case, make
from camid.proof.concealed.machine_integrator import DivergedError
from camid.proof.concealed.rig import draw_rig
from camid.proof.concealed.rig_setup import Setup


def plain_setup(
    order: int, seed: int, *, exposure: float, latency: float, frames: int = 400
) -> tuple[Setup, np.ndarray]:
    """A linear rig and an input that also has what reaches beyond the last frame."""
    generator = np.random.default_rng(seed)
    rig = draw_rig(generator, order, 3.0, 0.2)
    period = 0.4 / rig.rate
    setup = Setup(rig, period, frames, exposure * period, latency * period, False, rig.parameters())
    return setup, generator.choice([-0.2, 0.05, 0.2], setup.input_length)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize(
    ("exposure", "latency", "hold"), [(1.0, 0.0, "zoh"), (0.37, 0.8, "zoh"), (0.0, 0.25, "zoh"), (0.6, 0.3, "foh")]
)
def test_linear_machine_agrees_with_the_exact_chain(order, exposure, latency, hold):
    setup, command = plain_setup(order, order, exposure=exposure, latency=latency)
    setup.hold = hold
    output = readings(setup, motion(setup, command))
    sensor = "camera" if exposure else "instant"
    acquisition = Acquisition(setup.period, hold, sensor, setup.exposure or None, setup.latency)
    exact = sample(setup.rig.transfer_function(), command, acquisition)[: setup.frames]
    assert np.max(np.abs(output - exact)) < 1e-6 * np.std(exact)


LAWS = [
    ("coulomb-friction", "catalogue"),
    ("coulomb-friction", "lugre"),
    ("stribeck-friction", "catalogue"),
    ("end-stop", "catalogue"),
    ("end-stop", "kelvin-voigt"),
    ("end-stop", "hertz"),
    ("hysteresis", "catalogue"),
    ("hysteresis", "iwan"),
    ("end-stop", "play-in-joint"),
    ("rate-limit", "catalogue"),
    ("backlash", "catalogue"),
    ("impulse-disturbance", "half-sine"),
    ("speed-weighted-centroid", "catalogue"),
    ("heating-winding", "heating-winding"),
    ("reluctance-force", "reluctance-force"),
    ("travelling-wave", "travelling-wave"),
    ("swinging-stiffness", "swinging-stiffness"),
    ("sagging-supply", "sagging-supply"),
]


def drafted(identity: str, law: str, seed: int = 0):
    """A drawn with one effect of the law that is asked for."""
    for index in range(seed, seed + 60):
        drawn = draw_recording(Case(11, index, "several", (identity,)), np.random.default_rng([11, index]))
        add_effect(drawn, identity, np.random.default_rng([12, index]))
        if drawn.effects[0].effect.law == law:
            return drawn
    raise AssertionError(f"no {law} in 60 draws")


@pytest.mark.parametrize(("identity", "law"), LAWS)
def test_half_the_step_changes_nothing(identity, law):
    drawn = drafted(identity, law)
    setup = drawn.setup_with(drawn.effects)
    coarse, fine = (readings(setup, motion(setup, drawn.command, refinement)) for refinement in (1, 2))
    assert np.max(np.abs(coarse - fine)) < 5e-5 * np.std(fine)


def test_dry_friction_sticks_until_the_drive_exceeds_it():
    setup, _ = plain_setup(2, 5, exposure=1.0, latency=0.0, frames=60)
    level = 0.1 * setup.rig.actuator_constant
    setup.parameters[[s.DRY_COULOMB, s.DRY_BREAKAWAY]] = level, 2.0 * level
    setup.parameters[s.DRY_VELOCITY] = 1e-3 * setup.rig.rate / setup.rig.output_scale
    command = np.full(setup.input_length, 0.19)
    assert np.all(motion(setup, command).position == 0.0)
    command[20:] = 0.21
    trajectory = motion(setup, command)
    times = trajectory.start + trajectory.step * np.arange(len(trajectory.position))
    assert np.all(trajectory.position[times <= 20.0 * setup.period * (1.0 + 1e-9)] == 0.0)
    assert trajectory.position[-1] > 0.0


def test_a_blow_may_turn_what_slides():
    """Dry friction stops a mass that comes to rest, and not one that a blow sends the other way."""
    setup, _ = plain_setup(2, 5, exposure=1.0, latency=0.0, frames=60)
    level = 0.1 * setup.rig.actuator_constant
    setup.parameters[[s.DRY_COULOMB, s.DRY_BREAKAWAY]] = level, level
    setup.parameters[s.DRY_VELOCITY] = 1e-3 * setup.rig.rate / setup.rig.output_scale
    command = np.full(setup.input_length, 1.0)
    before = motion(setup, command)
    node = len(before.position) // 8
    time, speed = before.start + before.step * node, before.velocity_after[node]
    assert speed > 0.0
    setup.kicks.append((time, -3.0 * speed))
    after = motion(setup, command)
    assert after.velocity_after[node + 1] == pytest.approx(-2.0 * speed, rel=0.1)


def test_stuck_mass_does_not_creep():
    drawn = drafted("coulomb-friction", "catalogue")
    drawn.setup.parameters[:] = drawn.setup_with(drawn.effects).parameters
    drawn.setup.parameters[[s.DRY_COULOMB, s.DRY_BREAKAWAY]] = (
        0.3 * drawn.context().peak * drawn.setup.rig.actuator_constant
    )
    trajectory = motion(drawn.setup, drawn.command)
    still = (trajectory.velocity_after == 0.0) & (trajectory.velocity_before == 0.0)
    assert 0.02 < np.mean(still) < 0.98
    # Where the mass is at rest at both ends of an interval, it has mostly not moved in between.
    moved = np.abs(np.diff(trajectory.position)[still])
    assert np.mean(moved == 0.0) > 0.95


def test_runaway_is_reported():
    setup, command = plain_setup(2, 6, exposure=1.0, latency=0.0)
    setup.parameters[s.CUBIC] = -1e3 * setup.rig.stiffness * setup.rig.output_scale**2
    with pytest.raises(DivergedError):
        motion(setup, command)


@pytest.mark.parametrize("identity", ["quadratic-drag", "lens-distortion", "delay", "step-disturbance"])
def test_effect_has_the_size_that_was_drawn(identity):
    drawn = draw_recording(Case(21, 7, "several", (identity,)), np.random.default_rng(7))
    effect = CATALOGUE[identity].law(np.random.default_rng(8), drawn.context(), False)
    strength = strength_for(6.0, lambda g: drawn.size(effect, g), effect.start, effect.high)
    assert drawn.size(effect, strength) == pytest.approx(6.0, rel=0.1)
    setup = drawn.setup.copy()
    effect.apply(setup, strength)
    output = clean(setup, readings(setup, motion(setup, drawn.command)))
    left = drawn.belief.left_over_after_estimate(drawn.recorded(drawn.command), output)
    assert np.sqrt(left / 25.0) / drawn.noise_std(output) == pytest.approx(6.0, rel=0.1)


def test_strength_is_the_largest_where_the_family_ends():
    assert strength_for(100.0, lambda g: 5.0 * np.tanh(g), 0.1, 2.0) == 2.0
    assert strength_for(3.0, lambda g: g**2, 0.1, 1e3) == pytest.approx(np.sqrt(3.0), rel=0.05)

    def broken(strength):
        if strength > 0.7:
            raise DivergedError
        return strength

    assert 0.6 < strength_for(5.0, broken, 0.1, 1e3) <= 0.7


@pytest.mark.parametrize("identity", ["dead-zone", "backlash", "end-stop", "clipping"])
def test_invisible_effects_leave_nothing_to_see(identity):
    laws = set()
    for index in range(4, 12):
        made = make(Case(31, index, "invisible", (identity,)))
        (effect,) = made.truth["effects"]
        assert effect["multiple"] < 0.5
        laws.add(effect["law"])
    assert len(laws) > 1  # all laws can be out of reach


@pytest.mark.parametrize("alternative", [False, True])
@pytest.mark.parametrize("identity", [n for n, family in CATALOGUE.items() if family.place == "actuator"])
def test_an_actuator_effect_without_strength_is_none(identity, alternative):
    """Else no strength gives a small size, and the truth is named after something that is not in the recording."""
    family = CATALOGUE[identity]
    drawn = draw_recording(Case(3, 1, "single", (identity,)), np.random.default_rng(5))
    effect = family.law(np.random.default_rng(6), drawn.context(), alternative and family.alternatives)
    if effect.fixed:
        pytest.skip("it has no strength")
    whole, faint = (np.sqrt(drawn.left_over(effect, share * effect.start)[0]) for share in (1.0, 0.01))
    assert faint < 0.02 * whole


def test_a_soft_rate_limit_limits_what_is_recorded():
    """Twice the command is not followed twice as far: the law is no lag at the smallest sizes that are made either."""
    drawn = draw_recording(Case(3, 1, "single", ("rate-limit",)), np.random.default_rng(5))
    effect = CATALOGUE["rate-limit"].law(np.random.default_rng(6), drawn.context(), True)
    size = drawn.size(effect, effect.start)
    strength = strength_for(0.1 * size, lambda g: drawn.size(effect, g), effect.start, effect.high)
    setup = drawn.setup_with([])
    effect.apply(setup, strength)
    plain = drawn.setup_with([])
    one, two = (
        drawn.output(setup, factor * drawn.command) - drawn.output(plain, factor * drawn.command)
        for factor in (1.0, 2.0)
    )
    assert np.std(two - 2.0 * one) > 0.3 * np.std(one)


@pytest.mark.parametrize(
    "identity", [n for n, family in CATALOGUE.items() if family.place == "plant" and n != "end-stop"]
)
@pytest.mark.slow
def test_what_a_law_leaves_falls_with_its_strength(identity):
    """Else a small size is something other than what the truth names.

    A stop at the end of the motion is one still: it is met between the frames of the motion without it.
    """
    family = CATALOGUE[identity]
    for seed in (6, 7, 8, 9):
        drawn = draw_recording(Case(3, 1, "single", (identity,)), np.random.default_rng(5))
        effect = family.law(np.random.default_rng(seed), drawn.context(), family.alternatives)
        if effect.fixed:
            pytest.skip("it has no strength")
        whole, faint = (np.sqrt(drawn.left_over(effect, share * effect.start)[0]) for share in (1.0, 0.01))
        assert faint < 0.02 * whole


def test_a_small_swing_of_a_driven_pendulum_is_not_mostly_drag():
    """Drag has a name of its own, and the truth would be that one."""
    drawn = draw_recording(Case(3, 1, "single", ("pendulum-gravity",)), np.random.default_rng(5))
    effect = CATALOGUE["pendulum-gravity"].law(np.random.default_rng(6), drawn.context(), True)

    def left(strength, drag):
        setup = drawn.setup_with([])
        effect.apply(setup, strength)
        if not drag:
            setup.parameters[s.DRAG] = 0.0
        return drawn.output(setup, drawn.command) - drawn.output(drawn.setup_with([]), drawn.command)

    for strength in (0.02, 0.2):
        whole, without = left(strength, drag=True), left(strength, drag=False)
        assert np.std(whole - without) < 0.5 * np.std(whole)
