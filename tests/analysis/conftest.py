"""An identified model of a linear rig, and models that are made from it."""

import pytest

import camid
from tests.support import linear_rig as rig


@pytest.fixture(scope="session")
def identified():
    """Of a recording with 20 dB of noise; what made it is ``rig.NUMERATOR`` over ``rig.DENOMINATOR``."""
    return camid.identify(rig.recording(count=600), rig.simulation())
