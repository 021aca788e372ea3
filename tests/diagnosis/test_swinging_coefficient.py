"""A coefficient that swings in time: it is no coloured noise, though nothing of it stays on the average."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.diagnosis.residual.residual_structure import STRUCTURE_P_VALUE
from camid.diagnosis.swinging_coefficient import swinging_coefficient
from tests.support.mass_on_spring import PERIOD, command, record, simulation

COUNT = 1000


def swinging(share, angular, *, of_gain=False):
    """A mass on a spring of which the stiffness, or the gain, swings; by a solver that shares nothing with the tool."""
    signal = command(COUNT, seed=4)

    def rate(time, state, u):
        swing = 1.0 + share * np.sin(angular * time + 0.3)
        stiffness, gain = (100.0, 100.0 * swing) if of_gain else (100.0 * swing, 100.0)
        return [state[1], gain * u - 2.0 * state[1] - stiffness * state[0]]

    state, positions = np.zeros(2), []
    for k, u in enumerate(signal):
        positions.append(state[0])
        span = (k * PERIOD, (k + 1) * PERIOD)
        state = solve_ivp(rate, span, state, args=(u,), rtol=1e-8, atol=1e-10).y[:, -1]
    noise = 0.005 * np.random.default_rng(5).standard_normal(COUNT)
    return pd.DataFrame({"t": PERIOD * np.arange(COUNT), "u": signal, "y": np.array(positions) + noise})


def diagnosed(table):
    return camid.diagnose(table, simulation(sensor={"column": "y", "kind": "instant"}))


def chance(diagnosis):
    """Of as much by chance, before and after."""
    (row,) = [test for test in diagnosis.tests if test.name == "coefficients"]
    return row.before, row.after


@pytest.mark.parametrize(("of_gain", "name", "place"), [(False, "a0", "plant"), (True, "b0", "actuator")])
def test_a_coefficient_that_swings_is_no_coloured_noise(of_gain, name, place):
    found = diagnosed(swinging(0.06, 4.1, of_gain=of_gain))
    assert found.verdict == "unexplained"
    assert found.findings == []
    assert found.location.place == place
    assert chance(found)[0] < STRUCTURE_P_VALUE
    assert found.swing.name == name
    assert abs(found.swing.angular - 4.1) < 4.0 * found.swing.deviation < 0.2
    assert f"a coefficient that swings in time, {name} at 4." in found.explanation


def test_noise_swings_nothing():
    """White or coloured: chances are spread evenly, and colour is said to be one."""
    white = [diagnosed(record(noise=0.01, sensor="instant", seed=seed)) for seed in range(4)]
    assert all(found.verdict == "adequate" for found in white)
    assert all(chance(found)[1] > 1e-3 for found in white)
    random = np.random.default_rng(6)
    table = record(noise=0.0, sensor="instant", count=COUNT)
    noise = np.zeros(COUNT)
    for k in range(1, COUNT):
        noise[k] = 0.85 * noise[k - 1] + 0.01 * random.standard_normal()
    coloured = diagnosed(table.assign(y=table["y"] + noise))
    assert [finding.identifier for finding in coloured.findings] == ["coloured-noise"]
    assert coloured.swing is None


def test_what_has_no_spectrum_swings_nothing():
    """A residual of zeros, and one of a simulation that has run away, end in no traceback."""
    rows = np.ones((40, 1))
    experiment = SimpleNamespace(used=np.ones(40, bool))
    problem = SimpleNamespace(
        experiments=[experiment],
        whitened=lambda values, whitening: values,
        acquisition=SimpleNamespace(period=PERIOD),
        structure=SimpleNamespace(names=["b0"]),
    )

    def found(residual):
        noise, packing = SimpleNamespace(whitening=np.ones(1)), SimpleNamespace(names=["coefficient 0"])
        fitted = SimpleNamespace(residual=residual, sensitivities=rows, noise=noise, packing=packing)
        with np.errstate(invalid="ignore"):
            return swinging_coefficient(problem, fitted)

    assert found(np.zeros(40)) is None
    assert found(np.full(40, np.inf)) is None
    assert found(np.sin(np.arange(40.0))).name == "b0"
