"""Waves of a force along the way, by the plant's equation at the recorded positions."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.periodic_in_position import MANY_PERIODS, RECORDED_PERIODS
from camid.effects.recorded_force import best_pairs, short_periods, waves_of_force
from camid.effects.situation import Situation

PERIOD, ROWS = 0.01, 2500
MASS, DAMPING = 0.5, 1.5
FRICTION, AMPLITUDE, PITCH, PHASE = 1.1, 0.4, 0.8, 0.7
NOMINAL = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [2.6], "denominator": [1.0, 2.4, 0.0]}},
    "sensor": {"column": "y", "kind": "instant", "offset": 0.0},
    "controller": {"reference": "r", "position_gain": 6.0, "velocity_gain": 9.0},
    "initial_state": "zero",
}


def reference():
    """Where a belt is sent: to and fro over some poles."""
    times = PERIOD * np.arange(ROWS)
    return 2.5 * np.sin(0.9 * times) * np.sin(0.23 * times)


@pytest.fixture(scope="module")
def belt():
    """Position and command of a belt with strong dry friction and poles, by another integrator."""
    state, positions, commands = np.zeros(2), [], []
    for target in reference():
        held = 9.0 * (6.0 * (target - state[0]) - state[1])
        positions.append(state[0])
        commands.append(held)

        def motion(_, x, held=held):
            friction = FRICTION * np.tanh(x[1] / 1e-3)
            poles = AMPLITUDE * np.sin(2.0 * np.pi * x[0] / PITCH + PHASE)
            return [x[1], (held - DAMPING * x[1] - friction - poles) / MASS]

        state = solve_ivp(motion, (0.0, PERIOD), state, method="LSODA", rtol=1e-7, atol=1e-10).y[:, -1]
    return np.array(positions), np.array(commands)


def test_the_wave_is_seen_before_anything_is_fitted(belt):
    positions, commands = belt
    plant = TransferFunction((2.6,), (1.0, 2.4, 0.0))
    far = np.full(ROWS, 3.0)  # a simulation that is somewhere else
    used = np.ones(ROWS, bool)
    situation = Situation(
        PERIOD * np.arange(ROWS),
        commands,
        positions,
        far,
        far,
        far,
        plant,
        Acquisition(PERIOD, sensor="instant"),
        used,
        controlled=True,
    )
    best = waves_of_force(situation, np.ptp(positions) / RECORDED_PERIODS, 3)[0]
    assert best["period"] == pytest.approx(PITCH, rel=0.05)
    assert best["amplitude"] == pytest.approx(AMPLITUDE, rel=0.2)


def test_a_recording_without_such_a_force_shows_none():
    generator = np.random.default_rng(1)
    signal = np.repeat(generator.normal(size=ROWS // 25), 25)
    plant = TransferFunction((2.0,), (1.0, 3.0, 0.0))
    velocity = np.zeros(ROWS)
    for k in range(ROWS - 1):
        velocity[k + 1] = velocity[k] + PERIOD * (2.0 * signal[k] - 3.0 * velocity[k])
    position = PERIOD * np.cumsum(velocity)
    rows = (PERIOD * np.arange(ROWS), signal, position, position, velocity, np.zeros(ROWS))
    situation = Situation(*rows, plant, Acquisition(PERIOD, sensor="instant"), np.ones(ROWS, bool))
    assert waves_of_force(situation, np.ptp(position) / RECORDED_PERIODS, 3) == []


def turning_motor(pitch):
    """Input and position of a motor that turns over many of its poles, by small steps."""
    generator = np.random.default_rng(6)
    signal, parts = np.repeat(generator.choice([-3.0, -1.5, 1.0, 3.0], ROWS // 50), 50), 100
    position, velocity, positions = 0.0, 0.0, []
    for held in signal:
        positions.append(position)
        for _ in range(parts):
            pole = 0.8 * np.sin(2.0 * np.pi * position / pitch + PHASE)
            velocity += PERIOD / parts * (30.0 * (held - pole) - 10.0 * velocity)
            position += PERIOD / parts * velocity
    return signal, np.array(positions) + 1e-3 * generator.standard_normal(ROWS)


def test_a_motor_that_turns_often_passes_many_poles():
    pitch = 0.25
    signal, position = turning_motor(pitch)
    span = np.ptp(position)
    assert span / pitch > 100.0  # more than are looked at one by one
    rows = (PERIOD * np.arange(ROWS), signal, position, position, np.gradient(position, PERIOD), np.zeros(ROWS))
    plant = TransferFunction((25.0,), (1.0, 12.0, 0.0))
    situation = Situation(*rows, plant, Acquisition(PERIOD, sensor="instant"), np.ones(ROWS, bool))
    short = short_periods(situation, span / MANY_PERIODS, 3)
    assert short[0] == pytest.approx(pitch, rel=2e-3)
    (best, *_) = waves_of_force(situation, np.concatenate([span / RECORDED_PERIODS, short]), 3)
    assert best["period"] == pytest.approx(pitch, rel=2e-3)
    assert best["amplitude"] == pytest.approx(0.8, rel=0.2)


@pytest.mark.slow
def test_cogging_of_a_motor_that_turns_often_is_found():
    pitch = 0.25
    signal, position = turning_motor(pitch)
    simulation = {**NOMINAL, "plant": {"transfer_function": {"numerator": [25.0], "denominator": [1.0, 12.0, 0.0]}}}
    del simulation["controller"]
    table = pd.DataFrame({"t": PERIOD * np.arange(ROWS), "u": signal, "y": position})
    (finding,) = camid.diagnose(table, simulation).findings
    assert finding.identifier == "cogging"
    period = finding.parameters["period"]
    assert abs(period.value - pitch) < 4.0 * period.standard_deviation < 1e-3 * pitch


def test_pairs_are_fitted_by_least_squares():
    generator = np.random.default_rng(2)
    residual, sines, cosines = generator.normal(size=50), *generator.normal(size=(2, 50, 3))
    shares, amplitudes, phases = best_pairs(residual, sines, cosines)
    for k in range(3):
        (first, second), left, *_ = np.linalg.lstsq(np.column_stack([sines[:, k], cosines[:, k]]), residual, rcond=None)
        assert shares[k] == pytest.approx(left[0] / (residual @ residual))
        assert amplitudes[k] == pytest.approx(np.hypot(first, second))
        assert phases[k] == pytest.approx(np.arctan2(second, first))
    assert best_pairs(residual, sines, 2.0 * sines)[1].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.slow
def test_cogging_is_found_beside_friction_that_hides_it(belt):
    positions, commands = belt
    generator = np.random.default_rng(3)
    table = {"t": PERIOD * np.arange(ROWS), "r": reference(), "y": positions}
    table["u"] = commands + 0.01 * generator.normal(size=ROWS)
    found = camid.diagnose(pd.DataFrame(table), NOMINAL)
    names = {f.identifier: f.parameters for f in found.findings}
    assert {"coulomb-friction", "cogging"} <= set(names)
    truth = {"amplitude": AMPLITUDE, "period": PITCH, "phase": PHASE}
    for name, value in truth.items():
        assert names["cogging"][name].value == pytest.approx(value, rel=0.03)
    assert names["coulomb-friction"]["force"].value == pytest.approx(FRICTION, rel=0.02)
    assert any("zero" in effect.parameters for effect in found.improved.effects)
