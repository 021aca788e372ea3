"""Gravity on an arm whose joint has no spring: its torque, where it hangs, and how it is found."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.arm_gravity import ArmGravity
from camid.effects.extent import Extent
from camid.effects.gravity import PendulumGravity
from camid.effects.plant_force import force_along
from camid.effects.situation import Situation
from camid.engine.mechanics import Chain
from camid.engine.run import run

PERIOD, ROWS = 0.02, 1500
GAIN, DAMPING = 2.5, 1.2
POSITION_GAIN, VELOCITY_GAIN = 8.0, 2.0
NOMINAL = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [2.0], "denominator": [1.0, 1.6, 0.0]}},
    "sensor": {"column": "y", "kind": "instant", "offset": 0.0},
    "initial_state": "zero",
}


def command(seed=1):
    """Torques held for half a second."""
    return np.repeat(np.random.default_rng(seed).normal(size=ROWS // 25), 25)


def controlled(reference, state):
    """Of a cascade: a speed for the position's error, and a torque for the speed's."""
    return VELOCITY_GAIN * (POSITION_GAIN * (reference - state[0]) - state[1])


def arm(torque, phase, amplitude=1.0, *, signal=None, reference=None):
    """Angles and commands of a joint that a signal drives, or that a controller makes follow a reference."""
    state, angles, commands = np.zeros(2), [], []
    for k in range(len(signal if reference is None else reference)):
        held = signal[k] if reference is None else controlled(reference[k], state)
        angles.append(state[0])
        commands.append(held)

        def motion(_, x, held=held):
            return [x[1], GAIN * (held - torque * np.sin(x[0] / amplitude + phase)) - DAMPING * x[1]]

        state = solve_ivp(motion, (0.0, PERIOD), state, rtol=1e-9, atol=1e-11).y[:, -1]
    return np.array(angles), np.array(commands)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_torque_pulls_to_where_the_arm_hangs(sign):
    signal = command()[:400]
    plant = TransferFunction((sign * GAIN,), (1.0, DAMPING, 0.0))
    effect = ArmGravity(amplitude=0.8, torque=1.7, phase=0.4)
    chain = Chain(plant, Acquisition(PERIOD, sensor="instant"), (effect,))
    found = run(chain, sign * signal, PERIOD * np.arange(400))
    np.testing.assert_allclose(found, arm(1.7, 0.4, 0.8, signal=signal)[0], atol=2e-4)


def test_a_plant_with_a_spring_has_a_pendulum_s_gravity_and_one_without_an_arm_s():
    signal = command()
    angles, _ = arm(1.4, 0.0, signal=signal)
    still = np.zeros(ROWS)
    rows = (PERIOD * np.arange(ROWS), signal, angles, still, still, angles)
    for last, law in ((0.0, ArmGravity), (3.0, PendulumGravity)):
        plant = TransferFunction((GAIN,), (1.0, DAMPING, last))
        situation = Situation(*rows, plant, Acquisition(PERIOD, sensor="instant"), np.ones(ROWS, bool))
        guesses = list(PendulumGravity.candidates(situation))
        assert guesses
        assert all(isinstance(guess, ArmGravity) == (law is ArmGravity) for guess in guesses)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_recorded_motion_shows_the_torque_before_anything_is_fitted(sign):
    """Also where the drive is connected the other way round."""
    signal = command()
    angles, _ = arm(1.4, 0.6, signal=signal)
    still = np.zeros(ROWS)
    plant = TransferFunction((sign,), (1.0, 9.0, 0.0))
    acquisition = Acquisition(PERIOD, sensor="instant")
    rows = (PERIOD * np.arange(ROWS), sign * signal, angles, still, still, angles)
    best = next(iter(ArmGravity.candidates(Situation(*rows, plant, acquisition, np.ones(ROWS, bool)))))
    assert best.values["amplitude"] == pytest.approx(1.0, rel=0.15)
    assert best.values["torque"] == pytest.approx(1.4, rel=0.15)
    assert (best.values["phase"] + np.pi) % (2.0 * np.pi) - np.pi == pytest.approx(0.6, abs=0.15)


@pytest.mark.parametrize("phase", [0.0, np.pi / 2])
@pytest.mark.slow
def test_an_arm_is_found_wherever_its_zero_is(phase):
    """A sensor counts from where the arm hangs; another one from where it is level, and a controller holds it there."""
    generator = np.random.default_rng(3)
    nominal, table = NOMINAL, {"t": PERIOD * np.arange(ROWS)}
    if phase == 0.0:
        angles, table["u"] = arm(1.4, phase, signal=command())
        table["y"] = angles + 0.002 * generator.normal(size=ROWS)
    else:
        table["r"] = command()
        table["y"], commands = arm(1.4, phase, reference=table["r"])
        table["u"] = commands + 0.002 * generator.normal(size=ROWS)
        gains = {"position_gain": POSITION_GAIN, "velocity_gain": VELOCITY_GAIN}
        nominal = {**NOMINAL, "controller": {"reference": "r", **gains}}
    recording = pd.DataFrame(table)
    found = camid.diagnose(recording, nominal)
    (gravity,) = found.findings
    assert gravity.identifier == "pendulum-gravity"
    assert gravity.weight > 0.9
    for name, value in {"amplitude": 1.0, "torque": 1.4, "phase": phase}.items():
        estimate = gravity.parameters[name]
        assert abs(estimate.value - value) < 4.0 * estimate.standard_deviation < 0.2
    assert set(found.improved.effects[0].parameters) == {"amplitude", "torque", "phase"}
    assert camid.diagnose(recording, found.improved.to_mapping()).verdict == "adequate"


def test_gravity_of_the_other_sign_is_that_of_an_arm_which_hangs_where_this_one_stands():
    arm = ArmGravity(amplitude=1.0, torque=0.6, phase=0.35)
    turned = arm.scaled(-2.0)
    plant = TransferFunction((1.0,), (1.0, 1.0, 0.0))
    angles = np.linspace(-3.0, 3.0, 13)
    motion = (np.zeros(13), angles, np.zeros(13), np.zeros(13))
    np.testing.assert_allclose(force_along(turned, plant, motion), -2.0 * force_along(arm, plant, motion), atol=1e-12)
    assert turned.values["torque"] == pytest.approx(1.2)
    assert -np.pi < turned.values["phase"] <= np.pi


def test_an_arm_that_hardly_turns_is_a_constant_and_a_spring():
    extent = Extent(span=0.5, duration=10.0)
    assert ArmGravity(amplitude=1.0, torque=1.0, phase=0.4).is_plausible(extent)
    assert not ArmGravity(amplitude=50.0, torque=1.0, phase=0.4).is_plausible(extent)
    assert not ArmGravity(amplitude=0.01, torque=1.0, phase=0.4).is_plausible(extent)  # cogging


@pytest.mark.parametrize("phase", [0.5 * np.pi, -0.5 * np.pi])
def test_a_level_arm_bends_like_a_square(phase):
    """And one that hangs does not: what is left of its torque there is no constant and no square."""
    plant = TransferFunction((-2.0,), (1.0, 1.0, 0.0))
    arm = ArmGravity(amplitude=1.5, torque=0.6, phase=phase)
    situation = SimpleNamespace(plant=plant)
    (square,) = arm.relatives(situation)
    at = np.linspace(-0.1, 0.1, 5)
    motion = (np.zeros(5), at, np.zeros(5), np.zeros(5))
    bent = force_along(arm, plant, motion)
    np.testing.assert_allclose(force_along(square, plant, motion), bent - bent[2], atol=1e-5)
    assert ArmGravity(amplitude=1.5, torque=0.6, phase=0.3).relatives(situation) == ()
