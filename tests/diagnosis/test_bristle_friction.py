"""Friction with pre-sliding displacement in a recording that scipy integrated: its name, and its numbers."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import camid
from camid.diagnosis.laws import learned_laws
from tests.support.mass_on_spring import PERIOD, PLANT, command, simulation

NOISE = 0.003
DAHL = {"force": 0.25, "presliding": 0.06}
LUGRE = {"coulomb": 0.15, "breakaway": 0.35, "velocity": 1.0, "presliding": 0.06}


def recording(parameters, count=900, seed=1):
    """Held levels, and the sampled position of a mass on a spring with bristles; LuGre without damping of these."""
    gain, (damping, stiffness) = PLANT.numerator[0], PLANT.denominator[1:]
    coulomb = parameters.get("coulomb", parameters.get("force"))
    breakaway, speed = parameters.get("breakaway", coulomb), parameters.get("velocity", 1.0)
    spring = breakaway / parameters["presliding"]

    def rates(_time, state, signal):
        y, v, bend = state
        level = coulomb + (breakaway - coulomb) * np.exp(-((v / speed) ** 2))
        return [v, gain * (signal - spring * bend) - damping * v - stiffness * y, v - spring * abs(v) / level * bend]

    signal, state, output = command(count, seed), np.zeros(3), []
    for level in signal:
        output.append(state[0])
        state = solve_ivp(rates, (0.0, PERIOD), state, "Radau", args=(level,), rtol=1e-8, atol=1e-11).y[:, -1]
    noise = NOISE * np.random.default_rng((seed, 3)).standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "u": signal, "y": np.array(output) + noise})


@pytest.mark.parametrize(
    ("identifier", "truth"),
    [pytest.param("coulomb-friction", DAHL, marks=pytest.mark.slow), ("stribeck-friction", LUGRE)],
)
@pytest.mark.slow
def test_friction_with_bristles_is_friction(identifier, truth, monkeypatch):
    monkeypatch.setattr(learned_laws, "_likeliest", lambda *_, **__: pytest.fail("a law was learned"))
    believed = simulation(sensor={"column": "y", "kind": "instant", "offset": 0.0})
    diagnosis = camid.diagnose(recording(truth), believed, time_limit=None)
    (finding,) = diagnosis.findings
    assert finding.identifier == identifier
    assert finding.weight > 0.5
    assert diagnosis.verdict == "explained"
    for name, value in truth.items():
        parameter = finding.parameters[name]
        assert abs(parameter.value - value) < 3.0 * parameter.standard_deviation < 0.5 * value, name
    assert finding.parameters["presliding"].unit == "y"
    assert "friction with pre-sliding displacement" in diagnosis.explanation
    improved = next(e for e in diagnosis.improved.effects if e.identifier == identifier)
    assert improved.parameters["presliding"] == pytest.approx(truth["presliding"], rel=0.3)
