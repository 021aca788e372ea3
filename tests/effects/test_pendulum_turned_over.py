"""A pendulum that has turned over: a simulation with a spring in the place of gravity is anywhere by then."""

import numpy as np
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.effects.gravity import PendulumGravity
from camid.effects.situation import Situation
from tests.support import pendulum_and_drive as rigs

PERIOD, LEVELS = 0.02, (-0.5, -0.3, 0.45, 1.3)


def disc(seed):
    """An unbalanced disc that a torque larger than gravity's turns over at times."""
    return rigs.disc(count=1200, levels=LEVELS, held=12, noise=0.05, seed=seed)


# The disc of seed 1 turns by 84 rad, beyond the largest angle that is asked of.
@pytest.mark.parametrize("seed", [0, 2, 3])
def test_the_recorded_motion_says_what_a_turn_is(seed):
    table = disc(seed)
    angles = table["y"].to_numpy()
    assert np.ptp(angles) > 2.0 * np.pi
    nothing = np.zeros(len(table))
    situation = Situation(
        table["t"].to_numpy(),
        table["u"].to_numpy(),
        angles,
        nothing,
        nothing,
        angles,
        TransferFunction((90.0,), (1.0, 6.0, 90.0)),
        Acquisition(PERIOD, sensor="instant"),
        np.ones(len(table), bool),
    )
    amplitudes = [e.values["amplitude"] for e in PendulumGravity.candidates(situation)]
    assert min(abs(amplitude - 1.0) for amplitude in amplitudes) < 0.05


@pytest.mark.parametrize("seed", [1, 3])
@pytest.mark.slow
def test_a_pendulum_that_has_turned_over_is_found(seed):
    diagnosis = camid.diagnose(disc(seed), rigs.disc_simulation())
    (found,) = diagnosis.findings
    assert (found.identifier, diagnosis.verdict) == ("pendulum-gravity", "explained")
    amplitude = found.parameters["amplitude"]
    assert abs(amplitude.value - 1.0) < 4.0 * amplitude.standard_deviation < 0.01
