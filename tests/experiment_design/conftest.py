"""A rig that one recording with two levels leaves open: an uneven gain, or a bias of the input."""

import numpy as np
import pytest

import camid
from tests.support.mass_on_spring import effect, record, simulation

ROWS = 320


def played(signal, seed, *effects):
    """A recording of an input, of the rig with an uneven gain or with other effects."""
    effects = effects or (effect("gain-asymmetry", ratio=1.1),)
    return record(*effects, count=len(signal), seed=seed, noise=0.02, signal=signal)


@pytest.fixture(scope="session")
def first():
    random = np.random.default_rng(3)
    return played(np.repeat(random.choice([-1.0, 1.0], ROWS // 8), 8), 3)


@pytest.fixture(scope="session")
def diagnosis(first):
    return camid.diagnose(first, simulation())


@pytest.fixture(scope="session")
def design(diagnosis):
    return camid.design(diagnosis, time_limit=None)
