"""Pendulum plants: simulated as an independent integrator does, identified, and diagnosed."""

import numpy as np
import pytest

import camid
from camid.errors import InputError
from camid.simulation.file import load_simulation
from tests.support import pendulum_and_drive as rigs

RIG = {"natural_frequency": 5.5, "damping": 0.005, "rest": 3.1, "angle": 5.6}


@pytest.mark.parametrize("friction", [0.0, 0.01])
def test_a_large_swing_is_simulated(friction):
    """Of 0.8 of a half turn, with all initial states and dry friction until it stands still."""
    recording = rigs.pendulum(**RIG, friction=friction, count=2000)
    content = rigs.pendulum_simulation(natural_frequency=5.5, damping=0.005, rest=3.1)
    if friction:
        content["effects"] = [{"id": "coulomb-friction", "parameters": {"force": friction}}]
    found = camid.simulate(recording, content)
    error = found["simulated"] - recording["angle"]
    assert np.sqrt(np.mean(error**2)) < 3e-4 * np.std(recording["angle"])


def test_identified_from_far_off():
    """A belief under which the pendulum would turn over, and the accuracy that is stated."""
    deviations = []
    for seed in range(6):
        recording = rigs.pendulum(**RIG, noise=0.01, seed=seed, count=800)
        result = camid.identify(
            recording, rigs.pendulum_simulation(natural_frequency=4.4, damping=0.02, rest=np.pi, gain=2.0)
        )
        found = result.simulation.pendulum
        assert found.gain == 2.0  # a free decay says nothing of it
        for name, true in (("natural_frequency", 5.5), ("damping", 0.005), ("rest", 3.1)):
            deviations.append((getattr(found, name) - true) / found.standard_deviations[name])
    assert np.max(np.abs(deviations)) < 4.0
    assert 0.5 < np.sqrt(np.mean(np.square(deviations))) < 1.6


def test_friction_is_found_and_the_improved_file_is_adequate(tmp_path):
    recording = rigs.pendulum(**RIG, friction=0.008, noise=0.003, count=800)
    diagnosis = camid.diagnose(recording, rigs.pendulum_simulation(natural_frequency=5.0, damping=0.01, rest=np.pi))
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]
    force = diagnosis.findings[0].parameters["force"]
    assert abs(force.value - 0.008) < 4.0 * force.standard_deviation
    assert diagnosis.verdict == "explained"
    told = {c.name: (c.improved, c.unit) for c in diagnosis.coefficients}
    assert [*told] == ["natural frequency", "damping", "gain", "rest"]
    assert told["natural frequency"] == (pytest.approx(5.5, abs=0.01), "rad/s")
    assert told["rest"] == (pytest.approx(3.1, abs=0.01), "y")
    gain = diagnosis.coefficients[2]
    assert (gain.refitted, gain.refitted_deviation) == (gain.nominal, 0.0)  # a free decay says nothing of it
    content = diagnosis.improved.to_mapping()
    assert abs(content["plant"]["pendulum"]["natural_frequency"] - 5.5) < 0.01
    assert load_simulation(content).to_mapping() == content
    assert camid.diagnose(recording, content).verdict == "adequate"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"plant": {"pendulum": {"natural_frequency": 0, "damping": 0}}}, "natural_frequency"),
        ({"plant": {"pendulum": {"natural_frequency": 3, "damping": 0, "gain": 0}}}, "gain = 0"),
        (
            {"plant": {"pendulum": {"natural_frequency": 3, "damping": 0}, "free": {"rset": False}}},
            "did you mean 'rest'",
        ),
        ({"plant": {"pendulum": {"natural_frequency": 3, "damping": 0}, "covariance": [[1.0]]}}, "4 by 4"),
        (
            {
                "plant": {
                    "pendulum": {"natural_frequency": 3, "damping": 0},
                    "transfer_function": {"numerator": [1], "denominator": [1, 1]},
                }
            },
            "keep one",
        ),
    ],
)
def test_wrong_pendulums_are_refused(change, said):
    with pytest.raises(InputError) as refused:
        load_simulation(rigs.pendulum_simulation(natural_frequency=3, damping=0.0) | change)
    assert said in str(refused.value)
