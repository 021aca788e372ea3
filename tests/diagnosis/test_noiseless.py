"""Recordings that another simulation has written, without noise: the first that many try."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, lfilter

import camid

PERIOD, COUNT = 0.02, 600
NUMERATOR, DENOMINATOR = [1.1], [1.0, 0.6, 4.2]
BELIEVED = {
    "schema": 1,
    "time": {"column": "t"},
    "input": {"column": "u", "hold": "zoh"},
    "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 0.5, 4.0]}},
    "sensor": {"column": "y", "kind": "instant"},
}


def command():
    random = np.random.default_rng(41)
    return np.repeat(random.choice([-1.0, 1.0], COUNT // 8), 8)


def table(output):
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": command(), "y": output})


def linear():
    numerator, denominator, _ = cont2discrete((NUMERATOR, DENOMINATOR), PERIOD, method="zoh")
    return lfilter(numerator.ravel(), denominator, command())


def with_force(force):
    """Positions under a force of position and velocity, by a solver of another author."""
    state, positions = np.zeros(2), [0.0]
    for held in command()[:-1]:

        def motion(_, x, held=held):
            return [x[1], NUMERATOR[0] * (held - force(*x)) - DENOMINATOR[1] * x[1] - DENOMINATOR[2] * x[0]]

        state = solve_ivp(motion, (0.0, PERIOD), state, rtol=1e-10, atol=1e-13).y[:, -1]
        positions.append(state[0])
    return np.array(positions)


def said(diagnosis):
    return [w for w in diagnosis.warnings if "holds no noise" in w]


@pytest.mark.parametrize("digits", [9, 17])
def test_digits_that_integrators_differ_in_are_no_physics(digits):
    output = np.array([float(f"{y:.{digits}g}") for y in linear()])
    diagnosis = camid.diagnose(table(output), BELIEVED)
    assert (diagnosis.verdict, diagnosis.findings) == ("adequate", [])
    assert "down to 0.001\N{NO-BREAK SPACE}% of its standard deviation" in said(diagnosis)[0]
    for coefficient, true in zip(diagnosis.coefficients, NUMERATOR + DENOMINATOR[1:], strict=True):
        assert abs(coefficient.improved - true) < 4.0 * coefficient.improved_deviation < 1e-4 * true


@pytest.mark.parametrize(
    ("identifier", "force", "parameter", "true"),
    [
        pytest.param("cubic-stiffness", lambda y, v: 18.0 * y**3, "coefficient", 18.0, marks=pytest.mark.slow),
        ("quadratic-drag", lambda y, v: 0.5 * abs(v) * v, "coefficient", 0.5),
    ],
)
def test_an_effect_is_found_without_noise_and_nothing_beside_it(identifier, force, parameter, true):
    recorded = table(with_force(force))
    diagnosis = camid.diagnose(recorded, BELIEVED)
    (found,) = diagnosis.findings
    assert (found.identifier, diagnosis.verdict) == (identifier, "explained")
    estimate = found.parameters[parameter]
    assert abs(estimate.value - true) < 4.0 * estimate.standard_deviation < 1e-3 * true
    assert len(said(diagnosis)) == 1


def test_the_noise_that_is_added_is_always_the_same():
    recorded = table(linear())
    values = [camid.diagnose(recorded, BELIEVED).coefficients[0].improved for _ in range(2)]
    assert values[0] == values[1]


def test_noise_that_a_recording_has_is_its_own():
    output = linear()
    noise = 1e-4 * np.std(output) * np.random.default_rng(42).standard_normal(COUNT)
    diagnosis = camid.diagnose(table(output + noise), BELIEVED)
    assert (diagnosis.verdict, said(diagnosis)) == ("adequate", [])
    assert diagnosis.fit.noise_floor < 2e-4
