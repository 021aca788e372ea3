"""A mass on a spring beside the one that is seen: what it does, and how it is found by way of a mode in parallel."""

import numpy as np
import pytest
from scipy import signal

import camid
from camid.effects.modes import MassBeside, ParallelMode
from camid.effects.situation import Situation
from tests.support.mass_on_spring import PERIOD, PLANT, command, simulation

MASS, DAMPING, STIFFNESS = 1.0, 2.0, 64.0
OWN, OWN_DAMPING, SHARE = 9.5, 0.02, 0.3


def two_masses(share=SHARE):
    """Frames of a mass on a spring with another one beside it: a linear system of scipy, held input."""
    spring, damper = share * MASS * OWN**2, 2.0 * OWN_DAMPING * share * MASS * OWN
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-(STIFFNESS + spring) / MASS, -(DAMPING + damper) / MASS, spring / MASS, damper / MASS],
            [0.0, 0.0, 0.0, 1.0],
            [OWN**2, 2.0 * OWN_DAMPING * OWN, -(OWN**2), -2.0 * OWN_DAMPING * OWN],
        ]
    )
    system = signal.StateSpace(matrix, np.array([[0.0], [64.0], [0.0], [0.0]]), np.array([[1.0, 0.0, 0.0, 0.0]]), 0.0)
    return system.to_discrete(PERIOD, method="zoh")


def recorded(count=2000, noise=0.002):
    import pandas as pd

    given = command(count, 3)
    _, output, _ = signal.dlsim(two_masses(), given)
    random = np.random.default_rng(17)
    output = output[:, 0] + noise * random.standard_normal(count)
    return pd.DataFrame({"t": PERIOD * np.arange(count), "u": given, "y": output})


def test_it_is_found_with_the_frequency_and_damping_that_it_has_by_itself():
    found = camid.diagnose(recorded(), simulation(sensor={"column": "y", "kind": "instant"}))
    (finding,) = found.findings
    assert (finding.identifier, finding.title) == ("parallel-mode", MassBeside.title)
    for name, truth in (("own_frequency", OWN), ("own_damping", OWN_DAMPING)):
        estimate = finding.parameters[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.standard_deviation < 0.1 * truth, name
    assert found.verdict == "explained"
    # The table's gain is that of the other resonance, and the sentence says the way from it to the seen mass's.
    (sentence,) = [warning for warning in found.warnings if "beside a mass on a spring" in warning]
    gain = next(c.improved for c in found.coefficients if c.name == "b0")
    words = sentence.split()
    assert gain * float(words[-3]) == pytest.approx(64.0, rel=0.01)
    assert float(words[-3]) * float(words[words.index("is", words.index("seen") + 1) + 1]) == pytest.approx(
        1.0, rel=1e-3
    )


def test_its_zeros_are_those_of_plant_and_mode_together():
    law = ParallelMode(gain=0.2, natural_frequency=12.0, damping=0.05)
    situation = Situation.__new__(Situation)
    object.__setattr__(situation, "plant", PLANT)
    (start,) = MassBeside.starts(situation, **law.values)
    whole = PLANT + law.beside_plant()
    np.testing.assert_allclose(
        np.sort_complex(np.roots((PLANT * start.after_plant()).numerator)),
        np.sort_complex(np.roots(whole.numerator)),
        rtol=1e-9,
    )
    assert start.beside_plant() is None
    # A mode against the plant has no antiresonance.
    assert not list(MassBeside.starts(situation, **{**law.values, "gain": -0.6}))


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0])
def test_nothing_is_left_of_it_where_resonance_and_antiresonance_are_one(factor):
    law = MassBeside(natural_frequency=8.0, damping=0.02, own_frequency=9.0, own_damping=0.04)
    values = law.scaled(factor).values
    assert values["own_frequency"] == pytest.approx(8.0 * (9.0 / 8.0) ** factor)
    assert values["own_damping"] == pytest.approx(0.02 + factor * 0.02)
    assert ParallelMode.with_keys(values) is MassBeside
    assert list(MassBeside.candidates(None)) == []
