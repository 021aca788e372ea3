"""What all tests share."""

import os

# Each worker of xdist has one core, and sums are added in one order on every machine.
for library in ("MKL", "OMP", "OPENBLAS"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np
import pytest
from hypothesis import settings

from camid.chain.excitation import pseudo_random_binary_sequence

# The same examples in every run; `pytest --hypothesis-profile=default` looks for new ones.
settings.register_profile("camid", derandomize=True, database=None, deadline=None, max_examples=40)
settings.load_profile("camid")

# Folders whose files take longest go first, so that no worker is left with a long one at the end.
LONG = ("workflow", "docs", "diagnosis", "proof", "real_recordings", "commands", "identification")


def pytest_collection_modifyitems(items):
    def rank(item):
        folder = item.path.parent.name
        return LONG.index(folder) if folder in LONG else len(LONG)

    items.sort(key=rank)


@pytest.fixture(scope="session")
def excitation() -> np.ndarray:
    """The paper's PRBS of order 9."""
    return pseudo_random_binary_sequence(9)
