"""Shared fixtures."""

import numpy as np
import pytest

from camid.chain.excitation import pseudo_random_binary_sequence


@pytest.fixture(scope="session")
def excitation() -> np.ndarray:
    """The paper's PRBS of order 9."""
    return pseudo_random_binary_sequence(9)
