"""What the tests of the ablations share."""

import pytest
from ruamel.yaml import YAML

from tests.support import ROOT


@pytest.fixture(scope="session")
def configuration():
    """config/config.yaml."""
    return YAML(typ="safe").load(ROOT / "config/config.yaml")


@pytest.fixture(scope="session")
def imaging(configuration):
    """Its section of the camera and the marker."""
    return configuration["imaging"]
