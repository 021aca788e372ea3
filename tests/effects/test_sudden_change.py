"""Coefficients that change at once, in recordings of another integrator."""

import numpy as np
import pandas as pd
import pytest

import camid
from camid.effects.sudden_change import SuddenChange
from tests.support.mass_on_spring import PLANT

PERIOD, COUNT, FINE = 0.02, 1500, 10
TRUE = {"gain": 20.0, "damping": 2.0, "stiffness": 40.0}
BELIEVED = {"numerator": [15.0], "denominator": [1.0, 3.0, 35.0]}


def recorded(factors, when, seed, levels=(-1.5, -0.4, 0.3, 1.1)):
    """A mass on a spring some of whose coefficients are multiplied with factors from a time on (Runge and Kutta)."""
    random = np.random.default_rng(seed)
    signal = np.repeat(random.choice(levels, COUNT // 12 + 1), 12)[:COUNT]
    state, outputs, step = np.zeros(2), [], PERIOD / FINE

    def slope(at, x, level):
        gain, damping, stiffness = (TRUE[k] * (factors.get(k, 1.0) if at >= when else 1.0) for k in TRUE)
        return np.array([x[1], gain * level - damping * x[1] - stiffness * x[0]])

    for k, level in enumerate(signal):
        outputs.append(state[0])
        for j in range(FINE):
            at = (k + j / FINE) * PERIOD
            first = slope(at, state, level)
            second = slope(at, state + 0.5 * step * first, level)
            third = slope(at, state + 0.5 * step * second, level)
            fourth = slope(at, state + step * third, level)
            state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    output = np.array(outputs)
    noise = 0.01 * np.std(output) * random.standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": output + noise})


CASES = [
    ("gain", {"gain": 0.8}, -0.2, 9.302),
    ("stiffness", {"stiffness": 1.15}, 0.15, 21.782),
    ("damping", {"damping": 1.8}, 0.8, 11.002),
    ("inertia", dict.fromkeys(TRUE, 1.0 / 1.25), 0.25, 14.004),
]


NOMINAL = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": BELIEVED},
    "sensor": {"column": "y", "kind": "instant"},
}


@pytest.mark.parametrize(("coefficient", "factors", "change", "when"), CASES, ids=[case[0] for case in CASES])
def test_it_is_found_when_and_by_how_much(coefficient, factors, change, when):
    found = camid.diagnose(recorded(factors, when, seed=3), NOMINAL)
    assert [f.identifier for f in found.findings] == ["parameter-drift"]
    parameters = found.findings[0].parameters
    assert found.improved.effects[0].parameters["coefficient"] == coefficient
    estimate = parameters["change"]
    assert abs(estimate.value - change) < 4.0 * estimate.standard_deviation < 0.3 * abs(change)
    assert parameters["time"].value == pytest.approx(when, abs=0.3)
    assert found.verdict == "explained"


@pytest.mark.parametrize("side", [-1.0, pytest.param(1.0, marks=pytest.mark.slow)])
def test_about_where_the_force_turns_round_it_is_found_on_the_right_side(side):
    """A spring that changes a little before it is slack, or a little behind, pushes as much on the whole."""
    motion = recorded({}, 1e9, seed=3)
    slack = next(k for k in range(1000, COUNT) if motion.y[k] > 0.05 and motion.y[k + 1] < -0.05) + 0.5
    when = PERIOD * (slack + 2.0 * side)
    found = camid.diagnose(recorded({"stiffness": 1.5}, when, seed=3), NOMINAL)
    assert [f.identifier for f in found.findings] == ["parameter-drift"]
    assert found.improved.effects[0].parameters["coefficient"] == "stiffness"
    estimate = found.findings[0].parameters["time"]
    assert estimate.value == pytest.approx(when, abs=0.5 * PERIOD)
    assert estimate.standard_deviation < 2.0 * PERIOD


@pytest.mark.parametrize("seed", [pytest.param(3, marks=pytest.mark.slow), 4])
def test_times_that_explain_the_recording_as_well_are_within_its_uncertainty(seed):
    """About where the input changes its sign, a gain that changes before does nearly what one behind does."""
    levels = (-1.0, 1.0)
    signal = recorded({}, 1e9, seed, levels).u
    turn = next(k for k in range(700, COUNT) if signal[k] != signal[k - 1])
    when = PERIOD * (turn + 1)
    found = camid.diagnose(recorded({"gain": 0.8}, when, seed, levels), NOMINAL)
    assert [f.identifier for f in found.findings] == ["parameter-drift"]
    time = found.findings[0].parameters["time"]
    # Before the turn and behind: two periods lie between the two, and the curvature at either says a tenth of one.
    assert abs(time.value - when) < 4.0 * time.standard_deviation
    assert 0.5 * PERIOD < time.standard_deviation < 2.0 * PERIOD


def test_before_it_nothing_acts_and_of_a_heavier_mass_all_forces_do_less():
    law = SuddenChange(coefficient="inertia", change=0.25, time=3.0)
    values = law.force_values(PLANT)
    assert law.force.at(2.9, 1.0, 1.0, 1.0, 0.0, values=values) == 0.0
    # u - A/B(y) is what accelerates the mass; 1 - 1/1.25 of it is taken away.
    driving = 1.0 - (PLANT.denominator[2] * 0.3 + PLANT.denominator[1] * 0.2) / PLANT.numerator[0]
    assert law.force.at(3.1, 0.3, 0.2, 1.0, 0.0, values=values) == pytest.approx(0.2 * driving)
    assert law.breaks() == (3.0,)
